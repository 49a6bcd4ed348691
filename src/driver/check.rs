//! `gmlvm check`: what is wrong with scenes.

use crate::args::CheckArgs;
use crate::driver::accept::run_without_images;
use crate::failure::Failure;
use crate::report::Reporter;

pub(super) fn check(args: &CheckArgs, reporter: &Reporter) -> Result<u8, Failure> {
    let mut code = 0;
    for scene in &args.scenes {
        if let Err(failure) = run_without_images(scene, &args.inputs, args.limits, reporter) {
            if let Some(message) = failure.message() {
                reporter.message(message);
            }
            if code == 0 {
                code = failure.exit_code();
            }
        } else {
            reporter.detail(&format!("{}: nothing found", scene.display()));
        }
    }
    Ok(code)
}
