//! Surface functions to machine code.
//!
//! A surface function is a closure, and all that it captured is known when a scene is rendered. So
//! it is specialized: run on values that are partly known (`specialize`), which inlines its calls,
//! settles what can be settled and leaves arithmetic on scalars (`sir`), which Cranelift compiles
//! (`lower`, `code`). [`shaders`] decides which functions that is done for, and when.
//!
//! Whatever cannot be compiled stays with the interpreter, for a [reason](Unsupported); whatever
//! would be an error at run time is left to it too. So the results are the interpreter's, bit for
//! bit. Not compiled are functions whose recursion changes the shape of a value with each call, such
//! as the length of an array, and those whose conditions leave different numbers of values.
#![deny(unsafe_code)]

mod abi;
mod batch;
mod bounded;
mod certify;
mod code;
#[cfg(target_arch = "x86_64")]
mod decode;
pub mod listing;
mod lower;
mod outline;
mod report;
mod runtime;
pub mod shaders;
mod signed;
mod simplify;
mod sir;
mod specialize;
mod stopwatch;
mod sym;
mod text;
mod unsupported;

pub use unsupported::Unsupported;
