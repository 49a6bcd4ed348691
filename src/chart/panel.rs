//! What panels have in common: a heading, a frame with axes, and room for lines below.

use plotters::prelude::*;

use crate::chart::axes::Axis;
use crate::chart::draw::{Area, FAINT, INK, NOTES_HEIGHT, Pixel, text};

/// Where axes stand for nothing above zero.
const BAND: RGBColor = RGBColor(240, 240, 240);

/// Pixels from a panel's left edge to where its frame begins.
pub(super) const FRAME_LEFT: i32 = 68;

/// What stands around the marks of a panel.
pub(super) struct Frame<'t> {
    pub(super) heading: &'t str,
    /// The horizontal one first.
    pub(super) axes: [Axis; 2],
    /// What the axes show.
    pub(super) titles: [&'t str; 2],
    /// Where the band of zeros ends, which begins at the bottom; none if there is none.
    pub(super) zeros: Option<f64>,
}

/// What places become on the page, and the area below the frame.
pub(super) type Opened<B, At> =
    Result<(At, Area<B>), DrawingAreaErrorKind<<B as DrawingBackend>::ErrorType>>;

/// Draws a frame. What comes of it tells where on the page places are, and has room for notes.
///
/// # Errors
/// Those of the backend.
pub(super) fn open<B: DrawingBackend>(
    panel: &Area<B>,
    frame: Frame<'_>,
) -> Opened<B, impl Fn((f64, f64)) -> Pixel + use<B>> {
    let Frame { heading, axes: [x_axis, y_axis], titles: [x_title, y_title], zeros } = frame;
    let ([left, right], bottom) = (x_axis.range, y_axis.range[0]);
    panel.draw_text(heading, &text(14), (FRAME_LEFT, 10))?;
    let (_, height) = panel.dim_in_pixel();
    let (plot, notes) = panel.split_vertically(height.saturating_sub(NOTES_HEIGHT));
    let mut context = ChartBuilder::on(&plot)
        .margin_top(30)
        .margin_right(14)
        .margin_left(4)
        .x_label_area_size(36)
        .y_label_area_size(64)
        .build_cartesian_2d(x_axis, y_axis)?;
    if let Some(zeros) = zeros {
        let band = Rectangle::new([(left, bottom), (right, zeros)], BAND.filled());
        context.draw_series([band])?;
    }
    context
        .configure_mesh()
        .bold_line_style(FAINT)
        .light_line_style(TRANSPARENT)
        .axis_style(INK)
        .label_style(text(11))
        .axis_desc_style(text(11))
        .x_desc(x_title)
        .y_desc(y_title)
        .draw()?;
    let plotted = context.plotting_area().clone();
    Ok((move |place| plotted.map_coordinate(&place), notes))
}
