//! Work-precision charts: what methods to render cost, and how far their images are from the exact
//! one.
//!
//! A method is a row of [`methods::METHODS`]. What is measured is data ([`data`]), which tables,
//! drawings and pages are made of, whether it was measured now or comes from a file.

pub(crate) mod data;
pub(crate) mod measure;
pub(crate) mod methods;
pub(crate) mod page;
pub(crate) mod scaling;
pub(crate) mod study;
pub(crate) mod table;

mod axes;
mod doubled;
mod draw;
mod errors;
mod front;
mod panel;
mod render;
