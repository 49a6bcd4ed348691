//! `gmlvm bench`: engines, precisions and numbers of threads against one another, or surface
//! functions alone.

use std::collections::BTreeMap;
use std::path::Path;

use rayon::ThreadPool;

use crate::args::BenchArgs;
use crate::console;
use crate::driver::bench::export::{Entry, Old};
use crate::driver::run;
use crate::failure::Failure;
use crate::load::is_stdio;
use crate::measure::machine::Machine;
use crate::report::Reporter;

mod export;
mod points;
mod scenes;
mod surfaces;
mod table;

/// Thread pools by their numbers of threads.
type Pools = BTreeMap<u16, ThreadPool>;

pub(super) fn bench(args: &BenchArgs, reporter: &Reporter) -> Result<u8, Failure> {
    if args.scenes.iter().any(|scene| is_stdio(scene)) {
        let message = "the standard input can be read only once; a benchmark needs a file";
        return Err(Failure::Usage(message.to_owned()));
    }
    let old = args.compare.as_deref().map(Old::read).transpose()?;
    let pools = args
        .threads
        .iter()
        .map(|&n| Ok((n, run::threads(usize::from(n))?)))
        .collect::<Result<Pools, Failure>>()?;
    let machine = Machine::here();
    let is_shown = args.export.as_deref() != Some(Path::new("-"));
    let show = |text: &str| {
        if is_shown { console::data(|out| out.write_all(text.as_bytes())) } else { Ok(()) }
    };
    show(&table::heading(&machine))?;
    let mut entries = Vec::new();
    let mut code = 0;
    for scene in &args.scenes {
        match measure(scene, args, &pools, reporter) {
            Ok(measured) => {
                show(&table::scene(scene, &measured))?;
                entries.extend(measured);
            }
            Err(failure) => {
                failure.message().inspect(|message| reporter.message(message));
                code = if code == 0 { failure.exit_code() } else { code };
            }
        }
    }
    if let Some(old) = &old {
        show(&table::comparison(old, &entries, &machine))?;
    }
    if let Some(path) = &args.export {
        export::write(path, &machine, &entries)?;
    }
    Ok(code)
}

fn measure(
    scene: &Path,
    args: &BenchArgs,
    pools: &Pools,
    reporter: &Reporter,
) -> Result<Vec<Entry>, Failure> {
    if args.surfaces {
        surfaces::measure(scene, args, reporter)
    } else {
        scenes::measure(scene, args, pools, reporter)
    }
}
