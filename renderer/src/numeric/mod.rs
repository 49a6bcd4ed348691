//! Number types of the tracer and what is built from them.
//!
//! The tracer's formulas are written once, over [`Real`](real::Real). Plain `f64` is the instance that
//! renders; [`Dd`](dd::Dd) carries about 32 digits, is used where a scene is set up, and renders when
//! asked to.

pub mod affine;
pub mod ball;
pub mod dd;
pub mod real;
pub mod vec3;
