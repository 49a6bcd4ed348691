//! Ray tracing of GML solids: scene to image.
//!
//! This crate owns shapes, set operations, lights, shading and pixels. It knows no GML: surfaces are
//! numbers, which a [`SurfaceEval`](surface::SurfaceEval) evaluates. What is computed is described
//! beside the code that does it: intersections in `shape`, set operations in `tree` and `trace`,
//! illumination in [`shade`].
#![forbid(unsafe_code)]

mod bounds;
pub mod camera;
mod carving;
pub mod certify;
mod hierarchy;
pub mod image;
mod intern;
pub mod light;
pub mod line;
pub mod numeric;
pub mod object;
mod obstacles;
mod placement;
pub mod plan;
pub mod probe;
mod ray;
mod render;
pub mod sampling;
pub mod scene;
pub mod shade;
mod shape;
pub mod signature;
pub mod surface;
mod tiles;
mod trace;
mod tree;

pub use render::{Failure, render};
