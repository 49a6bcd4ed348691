//! `gmlvm eval`: the stack that a program leaves.

use crate::args::EvalArgs;
use crate::console;
use crate::driver::accept::run_without_images;
use crate::failure::Failure;
use crate::report::Reporter;

pub(super) fn eval(args: &EvalArgs, reporter: &Reporter) -> Result<u8, Failure> {
    let stack = run_without_images(&args.scene, &args.inputs, args.limits, reporter)?;
    console::data(|out| {
        stack.iter().try_for_each(|value| writeln!(out, "{}", vm::display::to_text(value)))
    })?;
    Ok(0)
}
