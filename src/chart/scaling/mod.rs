//! Charts of growth: how the time for a ray changes as a scene gets more solids, holes, reflections or
//! lights.
//!
//! A series is a row of [`series::SERIES`]: a program that makes the scene of any size. What is measured
//! is data ([`data`]), which tables and drawings are made of, as for charts of methods.

pub(crate) mod data;
pub(crate) mod measure;
pub(crate) mod series;

mod draw;
mod table;
