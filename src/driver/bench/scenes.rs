//! Whole scenes: each run reads, compiles, runs, traces and encodes anew.

use std::path::{Path, PathBuf};

use rayon::ThreadPool;

use crate::args::{
    BenchArgs, Dialect, EconomyArgs, Engine, OutputsArgs, PartsArgs, Precision, RunArgs, TimeArgs,
};
use crate::clean::clean;
use crate::driver::bench::Pools;
use crate::driver::bench::export::{Compared, Details, Entry, SceneDetails};
use crate::driver::run;
use crate::failure::Failure;
use crate::measure::machine::ProcessorTime;
use crate::measure::rounds::Rounds;
use crate::measure::statistics::{median, paired_ratio};
use crate::report::Reporter;
use crate::run::Renders;
use crate::run::digest::Digest;
use crate::run::stats::{Phases, Stats};

/// One engine in one precision with one number of threads.
struct Variant<'p> {
    args: RunArgs,
    threads: &'p ThreadPool,
    runs: Vec<Run>,
    processor_time: ProcessorTime,
    /// Of the last run.
    stats: Stats,
    digest: Option<Digest>,
}

/// Seconds that one run took.
struct Run {
    wall: f64,
    /// Of all threads together, and with the hashing of the images, which `wall` leaves out.
    processor: f64,
    phases: Phases,
}

/// Times all variants of a scene.
///
/// # Errors
/// What is wrong with the scene, or that variants give different images.
pub(super) fn measure(
    scene: &Path,
    args: &BenchArgs,
    pools: &Pools,
    reporter: &Reporter,
) -> Result<Vec<Entry>, Failure> {
    let mut variants: Vec<Variant<'_>> = args
        .engines
        .iter()
        .flat_map(|&engine| args.precision.iter().map(move |&precision| (engine, precision)))
        .flat_map(|way| args.threads.iter().map(move |threads| (way, threads)))
        .map(|(way, threads)| Variant::new(scene, way, *threads, &pools[threads], args))
        .collect();
    let rounds = Rounds::new(args.warmup, args.runs, args.time);
    let shown = scene.display().to_string();
    let bar = rounds.bar(&clean(&shown), variants.len(), reporter.quiet);
    let mut expected: Vec<(Precision, Digest, String)> = Vec::new();
    let outcome = rounds.each(variants.len(), |index, counts| {
        let variant = &mut variants[index];
        let digest = variant.run(counts, reporter)?;
        bar.inc(1);
        let precision = variant.args.precision;
        match expected.iter().find(|(of, ..)| *of == precision) {
            Some((_, first, name)) => {
                same_images(&shown, (*first, name), (digest, &variant.name()))
            }
            None => {
                expected.push((precision, digest, variant.name()));
                Ok(())
            }
        }
    });
    bar.finish();
    outcome?;
    Ok(entries(scene, &variants))
}

/// Fails if two runs of a scene in one precision gave different images.
fn same_images(
    scene: &str,
    (first, first_name): (Digest, &str),
    (digest, name): (Digest, &str),
) -> Result<(), Failure> {
    if digest == first {
        return Ok(());
    }
    Err(Failure::Unequal(format!(
        "the images of `{}` differ: {first_name} gives the hash {first}, {name} gives {digest}; \
         engines and numbers of threads must not matter, so this is a bug in gmlvm",
        clean(scene)
    )))
}

impl<'p> Variant<'p> {
    fn new(
        scene: &Path,
        (engine, precision): (Engine, Precision),
        n_threads: u16,
        threads: &'p ThreadPool,
        args: &BenchArgs,
    ) -> Self {
        let args = RunArgs {
            scene: scene.to_owned(),
            inputs: args.inputs.clone(),
            out_dir: PathBuf::from("."),
            output: None,
            outputs: OutputsArgs::default(),
            frames: None,
            format: None,
            stats: None,
            mark_uncertain: None,
            threads: Some(n_threads),
            engine,
            perf_map: false,
            economy: EconomyArgs::default(),
            picture: args.picture,
            sampling: args.sampling,
            precision,
            certify: false,
            watch: false,
            parts: PartsArgs::default(),
            limits: args.limits,
            time: TimeArgs::default(),
        };
        Variant {
            args,
            threads,
            runs: Vec::new(),
            processor_time: ProcessorTime::default(),
            stats: Stats::default(),
            digest: None,
        }
    }

    fn name(&self) -> String {
        let RunArgs { engine, precision, .. } = self.args;
        format!("{} -j {}", engine.in_precision(precision), self.threads.current_num_threads())
    }

    /// Runs once. What a run says besides errors would be said hundreds of times.
    fn run(&mut self, counts: bool, reporter: &Reporter) -> Result<Digest, Failure> {
        let reporter = reporter.of_errors();
        let mut host = Renders::to_memory(&self.args, self.threads, &reporter);
        let start = ProcessorTime::now();
        run::execute(&self.args, &mut host, &reporter)?;
        if counts {
            let processor = self.processor_time.add_since(start);
            let Stats { total, phases, .. } = host.stats;
            self.runs.push(Run { wall: total, processor, phases });
        }
        self.stats = host.stats;
        self.digest = Some(host.digest);
        Ok(host.digest)
    }

    fn times(&self) -> Vec<f64> {
        self.runs.iter().map(|run| run.wall).collect()
    }

    fn median_of(&self, part: impl Fn(&Run) -> f64) -> f64 {
        median(&self.runs.iter().map(part).collect::<Vec<_>>())
    }

    fn median_phases(&self) -> Phases {
        let of = |phase: fn(&Phases) -> f64| self.median_of(|run| phase(&run.phases));
        Phases {
            read: of(|phases| phases.read),
            compile: of(|phases| phases.compile),
            run: of(|phases| phases.run),
            build: of(|phases| phases.build),
            jit: of(|phases| phases.jit),
            trace: of(|phases| phases.trace),
            write: of(|phases| phases.write),
        }
    }

    /// The command that does what was measured, besides writing the image.
    fn command(&self) -> String {
        let RunArgs { scene, inputs, picture, precision, .. } = &self.args;
        let mut words = vec!["gmlvm".to_owned(), "run".to_owned(), scene.display().to_string()];
        words.extend(["--engine".to_owned(), self.args.engine.name().to_owned()]);
        words.extend(["-j".to_owned(), self.threads.current_num_threads().to_string()]);
        words.extend(self.args.sampling.option());
        let mut option = |name: &str, value: Option<String>| {
            words.extend(value.map(|value| [name.to_owned(), value]).into_iter().flatten());
        };
        option("--size", picture.size.map(|size| format!("{}x{}", size.width, size.height)));
        option("--depth", picture.depth.map(|depth| depth.to_string()));
        option("--region", picture.region.map(|region| region.to_string()));
        let dialect = match picture.dialect {
            Dialect::Auto => None,
            Dialect::Icfp => Some("icfp".to_owned()),
            Dialect::Chicago => Some("chicago".to_owned()),
        };
        option("--dialect", dialect);
        let is_plain = *precision == Precision::F64;
        option("--precision", (!is_plain).then(|| precision.name().to_owned()));
        inputs.defines.iter().for_each(|define| option("-D", Some(define.text.clone())));
        inputs.include_dirs.iter().for_each(|dir| option("-I", Some(dir.display().to_string())));
        words.iter().map(|word| quoted(word)).collect::<Vec<_>>().join(" ")
    }
}

/// A word as a shell takes it for one.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:+".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

fn entries(scene: &Path, variants: &[Variant<'_>]) -> Vec<Entry> {
    let base = variants.first().map(Variant::times).unwrap_or_default();
    let entry = |(index, variant): (usize, &Variant<'_>)| {
        let times = variant.times();
        let phases = variant.median_phases();
        let rays = variant.stats.rays;
        let n_rays = rays.primary + rays.reflected + rays.shadow;
        let details = SceneDetails {
            scene: scene.display().to_string(),
            engine: variant.args.engine.name(),
            precision: variant.args.precision.name(),
            way: variant.args.engine.in_precision(variant.args.precision),
            threads: variant.threads.current_num_threads(),
            images: variant.stats.counts.images,
            pixels: variant.stats.counts.pixels,
            rays,
            rays_per_second: rate(n_rays, phases.trace),
            surface_calls_per_second: rate(rays.surface_calls, phases.trace),
            processor_time: variant.median_of(|run| run.processor),
            phases,
            ratio_to_first: (index > 0).then(|| Compared::from(paired_ratio(&base, &times))),
            image_hash: variant.digest.map(|digest| digest.to_string()).unwrap_or_default(),
        };
        let of_each = variant.processor_time.of_each(times.len());
        Entry::new(variant.command(), times, of_each, Details::Scene(details))
    };
    variants.iter().enumerate().map(entry).collect()
}

/// Events a second; none if there was no time to tell.
fn rate(n: u64, seconds: f64) -> Option<f64> {
    (seconds > 0.0).then(|| n as f64 / seconds)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_fit_for_a_shell() {
        assert_eq!(quoted("scenes/a-1.gml"), "scenes/a-1.gml");
        assert_eq!(quoted("s=a b"), "'s=a b'");
        assert_eq!(quoted("it's"), r"'it'\''s'");
        assert_eq!(quoted(""), "''");
    }

    #[test]
    fn different_images_are_an_error() {
        let a = Digest::default();
        let mut b = a;
        b.add(b"x");
        assert!(same_images("s.gml", (a, "interp -j 1"), (a, "jit -j 1")).is_ok());
        let failure =
            same_images("s.gml", (a, "interp -j 1"), (b, "jit -j 2")).expect_err("differ");
        assert_eq!(failure.exit_code(), 1);
        let message = failure.message().expect("not told yet");
        for part in ["s.gml", "interp -j 1", "jit -j 2", &a.to_string(), &b.to_string()] {
            assert!(message.contains(part), "{message}");
        }
    }
}
