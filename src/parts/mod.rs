//! Images in parts: bands of rows, each a file, so that a run can go on where another stopped, and many
//! can share the work.
//!
//! Where bands begin depends on the image alone ([`bands`]), and a pixel on the scene and its place. So
//! parts fit together whoever has made them; a part file says what it is a part of ([`mod@file`]), so that
//! nothing else is ever put in its place.

pub(crate) mod merge;
pub(crate) mod shard;
pub(crate) mod store;

mod bands;
pub(crate) mod file;
mod identity;
