//! The GML virtual machine: bytecode to values and render jobs.
//!
//! This crate owns values, the operand stack, frames, limits and run-time errors. `render`, the
//! one side effect of GML, goes to a [`Host`](host::Host): the machine knows no files, no threads
//! and no native code.
#![forbid(unsafe_code)]

mod decision;
mod dispatch;
pub mod display;
pub mod error;
mod exchange;
mod heap;
pub mod host;
mod interp;
pub mod machine;
mod ops;
pub mod program;
mod registers;
mod stack;
mod step;
pub mod surfaces;
pub mod value;
mod word;
