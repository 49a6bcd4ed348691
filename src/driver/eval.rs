//! `gmlvm eval`: the stack that a program leaves.

use crate::args::EvalArgs;
use crate::clean::clean;
use crate::console;
use crate::driver::accept::run_without_images;
use crate::failure::Failure;
use crate::report::Reporter;

pub(super) fn eval(args: &EvalArgs, reporter: &Reporter) -> Result<u8, Failure> {
    let stack = run_without_images(&args.scene, &args.inputs, args.limits, reporter)?;
    console::data(|out| {
        // A string that the command line has bound may hold anything.
        let mut lines = stack.iter().map(vm::display::to_text);
        lines.try_for_each(|line| writeln!(out, "{}", clean(&line)))
    })?;
    Ok(0)
}
