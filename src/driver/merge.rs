//! `gmlvm merge`: the images, from their parts.

use compiler::diagnostic::{Code, Diagnostic};
use compiler::source::{SourceMap, Span};

use crate::args::{ImageFormat, MergeArgs};
use crate::clean::clean;
use crate::console;
use crate::failure::Failure;
use crate::formats::{self, Picture, Pixels};
use crate::output::{Contents, Problem, Written};
use crate::parts::merge::{Merged, Parts};
use crate::report::Reporter;
use crate::run::naming::{Destination, Naming, Number, Sink};

pub(super) fn merge(args: &MergeArgs, reporter: &Reporter) -> Result<u8, Failure> {
    let naming = Naming::new(args.output.as_deref(), &args.out_dir, false)?;
    let parts = Parts::find(&args.inputs, args.allow_missing)?;
    if matches!(naming, Naming::Stdout) && parts.n_images() > 1 {
        let message = "there is more than one image, and the standard output has room for one; use \
                       `--output NAME` with {n} in the name";
        return Err(Failure::Usage(message.to_owned()));
    }
    let mut written = Written::default();
    for number in parts.numbers() {
        let merged = parts.join(number, args.max_pixels, args.allow_missing)?;
        write(&merged, args, &naming, &mut written, reporter)?;
    }
    Ok(0)
}

fn write(
    merged: &Merged,
    args: &MergeArgs,
    naming: &Naming,
    written: &mut Written,
    reporter: &Reporter,
) -> Result<(), Failure> {
    let Merged { name, number, picture, n_missing, .. } = merged;
    let by_output = args.output.as_deref().and_then(formats::of_name);
    let format = args.format.or(by_output).unwrap_or(merged.format);
    if (format == ImageFormat::Pfm) != matches!(picture.pixels, Pixels::Linear(_)) {
        let kind = if format == ImageFormat::Pfm { "bytes" } else { "linear light" };
        return Err(Failure::Usage(format!(
            "the parts hold {kind}, which {} files do not; give `run --parts` the same `--format`",
            format.extension().to_uppercase()
        )));
    }
    let unwritable = |problem, shown: &str| unwritable(problem, name, shown, args, reporter);
    let Destination { sink, format } = naming
        .destination(name, Number { image: *number, frame: None }, Some(format))
        .map_err(|problem| unwritable(problem, &args.out_dir.join(name).to_string_lossy()))?;
    let fill = |out: &mut dyn std::io::Write| formats::write(format, picture, out);
    let shown = match &sink {
        Sink::File(target) => {
            let shown = clean(&target.shown().to_string_lossy()).into_owned();
            let contents = Contents { name: name.clone(), option: "--output" };
            written.check(target, &contents)?;
            target
                .write(args.existing(), &mut { fill })
                .map_err(|problem| unwritable(problem, &shown))?;
            written.add(target, contents);
            shown
        }
        Sink::Stdout | Sink::Memory => {
            console::data(fill)?;
            "-".to_owned()
        }
    };
    let Picture { width, height, .. } = picture;
    let missing = match n_missing {
        0 => String::new(),
        n => format!("  {n} rows missing"),
    };
    reporter.note(&format!("{shown}  {width}x{height}{missing}"));
    Ok(())
}

/// Names in parts come from scenes, and are trusted as little.
fn unwritable(
    problem: Problem,
    name: &str,
    shown: &str,
    args: &MergeArgs,
    reporter: &Reporter,
) -> Failure {
    let diagnostic = match problem {
        Problem::Refused(reason) => {
            let message = format!("the file name `{}` {reason}", clean(name));
            let root = args.out_dir.to_string_lossy();
            Diagnostic::new(Code::RefusedPath, Span::NONE, message)
                .note(format!("images are written only below `{}` (--out-dir)", clean(&root)))
                .help("to choose the name yourself: `--output '{n}.ppm'`")
        }
        Problem::Failed(reason) => {
            let message = format!("could not write `{}`: {reason}", clean(shown));
            Diagnostic::new(Code::CannotWrite, Span::NONE, message)
        }
    };
    reporter.diagnostics(&[diagnostic], &SourceMap::default(), None)
}
