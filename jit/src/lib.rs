//! Surface functions to machine code.
#![deny(unsafe_code)]

mod abi;
mod code;
mod lower;
mod outline;
mod runtime;
pub mod shaders;
mod sir;
mod specialize;
mod sym;
mod unsupported;

pub use unsupported::Unsupported;
