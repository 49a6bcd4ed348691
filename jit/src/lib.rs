//! Surface functions to machine code: the boundary of a crate to come.
//!
//! This crate will own the specialising compiler, executable memory and the calls into it, and
//! with them the only `unsafe` code of the workspace. What it takes is a
//! surface closure and its program; what it gives is an implementation of the renderer's
//! `SurfaceEval` that agrees bit for bit with the interpreter, and, for each function it declines,
//! the reason and the place. The interpreter then runs that function.
//!
//! Until then every surface function is interpreted, and `gmlvm run --engine jit` says so.
