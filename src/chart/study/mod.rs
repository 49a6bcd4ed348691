//! Sets of charts: what kernels, numbers and omissions do, each measured in a way of its own.
//!
//! A set is a row of [`sets::SETS`]. What is measured is data ([`data`]), which tables and drawings are
//! made of, as for charts of methods.

use std::path::PathBuf;

use crate::chart::measure::Bench;
use crate::failure::Failure;

use self::data::{Form, Study};
use self::sets::{Set, Subject};

pub(crate) mod data;
pub(crate) mod sets;

mod bars;
mod distance;
mod draw;
mod kernels;
mod own;
mod plot;
mod scenes;
mod table;

/// Measures a set, on these scenes if it is of scenes. A scene that fails is told of to `failed`, and the
/// others are measured.
///
/// # Errors
/// When the set is not of scenes and cannot be measured.
pub(crate) fn measure(
    set: &Set,
    scenes: &[PathBuf],
    bench: Bench<'_>,
    failed: &mut dyn FnMut(Failure),
) -> Result<Study, Failure> {
    let mut study = Study { panels: Vec::new() };
    match set.subject {
        Subject::Own(measure) => study.panels = measure(bench)?,
        Subject::Scenes(kind) => {
            for scene in scenes {
                match scenes::measure(kind, scene, bench) {
                    Ok(panels) => study.add(panels),
                    Err(failure) => failed(failure),
                }
            }
        }
    }
    Ok(study)
}

impl Study {
    /// Adds panels, or their rows to the last panel if that has room for them.
    fn add(&mut self, panels: Vec<data::Panel>) {
        for mut panel in panels {
            let is_of_scenes = panel.kind.heading().is_some();
            match (self.panels.last_mut().map(|last| &mut last.form), &mut panel.form) {
                (Some(Form::Shares { items: all }), Form::Shares { items }) => all.append(items),
                (Some(Form::Pairs { items: all }), Form::Pairs { items }) if is_of_scenes => {
                    all.append(items);
                }
                _ => self.panels.push(panel),
            }
        }
    }
}
