//! Drawing a study: a panel for each of its parts, in the form that suits it.

use plotters::prelude::*;

use crate::chart::draw::{self, Area, Drawn, Foot, Layout, PANEL_HEIGHT, Sign};
use crate::chart::page::{Sheet, Spot};
use crate::chart::study::data::{Form, Mark, Panel, Study};
use crate::chart::study::sets::{Kind, SERIES};
use crate::chart::study::{bars, plot, table};
use crate::chart::table::{ONE_THREAD, Table, captions};

impl Sheet for Study {
    fn title(&self) -> &'static str {
        self.panels.first().map_or("", |panel| panel.kind.set().title)
    }

    fn size(&self) -> (u32, u32) {
        draw::size(self.panels.len(), self.layout(), &self.foot())
    }

    fn draw<B: DrawingBackend>(&self, area: &Area<B>, _: &mut dyn FnMut(Spot)) -> Drawn<B> {
        draw::draw(area, &self.panels, self.layout(), draw_panel, &self.foot())
    }

    fn tables(&self) -> Vec<Table> {
        self.panels.iter().map(table::table).collect()
    }

    fn captions(&self) -> Vec<String> {
        let is_of_two = self.panels.iter().any(|panel| panel.kind == Kind::Threads);
        let threads = if is_of_two { "one thread and two" } else { ONE_THREAD };
        captions(self.panels.iter().map(|panel| &panel.about), threads)
    }
}

impl Study {
    fn layout(&self) -> Layout {
        let are_wide = self.panels.iter().any(|panel| match &panel.form {
            Form::Curves { .. } | Form::Dots { .. } => false,
            Form::Cells { .. } | Form::Shares { .. } | Form::Masks { .. } => true,
            // Many lines have long names.
            Form::Pairs { .. } => self.panels.len() == 1,
        });
        let heights = self.panels.iter().map(height);
        Layout {
            n_columns: if are_wide { 1 } else { draw::n_columns(self.panels.len()) },
            panel_height: heights.max().unwrap_or(PANEL_HEIGHT),
        }
    }

    fn foot(&self) -> Foot {
        let mut legend = Vec::new();
        let forms = || self.panels.iter().map(|panel| &panel.form);
        for series in SERIES {
            let is_shown = |form: &Form| match form {
                Form::Curves { items } => items.iter().any(|item| item.name == series.name),
                _ => false,
            };
            if forms().any(is_shown) {
                legend.push((Sign::Mark(series.look, series.is_filled), series.name));
            }
        }
        if forms().any(|form| matches!(form, Form::Shares { .. })) {
            legend.extend(
                table::SHARES
                    .iter()
                    .zip(bars::SHARES)
                    .map(|(name, color)| (Sign::Swatch(color), *name)),
            );
        }
        if forms().any(|form| matches!(form, Form::Masks { .. })) {
            let sign = |mark: Mark| (Sign::Swatch(bars::color_of(mark)), table::words(mark));
            legend.extend(Mark::DIFFERENT.map(sign));
        }
        let key = self.panels.first().map(|panel| panel.kind.set().key.to_owned());
        Foot { legend, lines: key.into_iter().chain(self.captions()).collect() }
    }
}

fn height(panel: &Panel) -> u32 {
    match &panel.form {
        Form::Curves { .. } | Form::Dots { .. } => PANEL_HEIGHT,
        Form::Cells { cases, .. } => bars::cells_height(cases.len()),
        Form::Shares { items } => bars::height(items.len()),
        Form::Pairs { items } => bars::height(items.len()),
        Form::Masks { items } => bars::masks_height(items),
    }
}

/// Draws a panel. `page` is the area of the whole drawing.
fn draw_panel<B: DrawingBackend>(page: &Area<B>, area: &Area<B>, panel: &Panel) -> Drawn<B> {
    match &panel.form {
        Form::Curves { items } => plot::draw_curves(page, area, panel, items),
        Form::Dots { items } => plot::draw_dots(page, area, panel, items),
        Form::Cells { cases, items } => bars::draw_cells(area, panel, cases, items),
        Form::Shares { items } => bars::draw_shares(area, panel, items),
        Form::Pairs { items } => bars::draw_pairs(area, panel, items),
        Form::Masks { items } => bars::draw_masks(area, panel, items),
    }
}
