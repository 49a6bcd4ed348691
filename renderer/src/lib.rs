//! Ray tracing of GML solids: scene to image.
//!
//! This crate owns shapes, set operations, lights, shading and pixels. It knows no GML: surfaces are
//! numbers, which a [`SurfaceEval`](surface::SurfaceEval) evaluates.
#![forbid(unsafe_code)]

pub mod light;
pub mod numeric;
pub mod object;
pub mod surface;
