//! What is told of a scene when its images are there: its code, what its plan saves, and a chart of
//! methods, measured at a small size.

use std::path::Path;
use std::sync::{Arc, PoisonError};
use std::time::Duration;

use compiler::source::SourceMap;
use rayon::ThreadPool;
use serde_json::{Value, json};
use vm::program::LoadedProgram;

use crate::args::{ChartArgs, ViewArgs};
use crate::chart::data::{About, Chart, Data};
use crate::chart::measure::{self, Bench};
use crate::chart::methods::{METHODS, Render};
use crate::chart::page::{self, Sheet, Spot};
use crate::driver;
use crate::listing::html::Page;
use crate::listing::{Selection, Walk};
use crate::load::Source;
use crate::report::Reporter;
use crate::run::economy;
use crate::run::plan::Plan;
use crate::trace;
use crate::values::Size;
use crate::view::kept::Kept;
use crate::view::protocol::{Method, Out};
use crate::view::worker::Images;

/// A page of code has room for about so many rows, more than anybody reads.
const MAX_ROWS: usize = 20_000;

/// What is measured is of images this wide at most; it takes a moment at the usual sizes' cost.
const SMALL_WIDTH: u32 = 48;

/// The methods charted: of our own tracer, the naive one for comparison, and ways to sample.
const CHARTED: [&[&str]; 2] = [
    &["interp-f64", "jit-f64", "jit-dd", "jit-certified", "naive-f64-1e-6", "naive-f32-1e-3"],
    &["grid-1x1", "grid-2x2", "grid-4x4", "adaptive-2", "adaptive-3"],
];

/// Rounds of a chart, and the time after which a method is given up.
const N_ROUNDS: u32 = 3;
const CHART_TIMEOUT: Duration = Duration::from_secs(2);

/// Tells all of it, the quickest first. What cannot be told is left out: the images are there.
pub(super) fn tell(
    args: &ViewArgs,
    method: Method,
    source: &Source<'_>,
    program: &Arc<LoadedProgram>,
    images: &Images,
    threads: &ThreadPool,
    out: &Out,
) {
    let kept = images.lock().unwrap_or_else(PoisonError::into_inner).clone();
    tell_code(args, program, &source.sources, &kept, out);
    for (image, kept) in kept.iter().enumerate() {
        tell_savings(args, method, kept, threads, (image, out));
    }
    if let Some(first) = kept.first() {
        let size = small(first);
        for methods in CHARTED {
            tell_chart(args, source, methods, size, threads, out);
        }
    }
}

fn tell_code(
    args: &ViewArgs,
    program: &Arc<LoadedProgram>,
    sources: &SourceMap,
    images: &[Arc<Kept>],
    out: &Out,
) {
    let mut page = Page::new(&program.bytecode, sources, MAX_ROWS);
    let selection = Selection { surface: None, functions: None };
    let mut walk = Walk::new(selection, args.limits.machine());
    for image in images {
        let visited = walk.visit(&image.job(), &mut |shown| {
            page.add(shown);
            Ok(())
        });
        if visited.is_err() {
            return;
        }
    }
    let Ok(data) = page.data() else { return };
    out.send_with(json!({ "event": "code" }), "application/json", data.as_bytes());
}

/// The size of an image that is measured in place of this one.
fn small(image: &Kept) -> Size {
    let renderer::camera::View { width, height, .. } = image.plan.view;
    let small = width.min(SMALL_WIDTH);
    let height = u64::from(height) * u64::from(small) / u64::from(width);
    Size { width: small, height: height.clamp(1, 2 * u64::from(SMALL_WIDTH)) as u32 }
}

fn tell_savings(
    args: &ViewArgs,
    method: Method,
    kept: &Kept,
    threads: &ThreadPool,
    (image, out): (usize, &Out),
) {
    let size = small(kept);
    let mut picture = args.picture;
    picture.size = Some(size);
    picture.region = None;
    let job = kept.job();
    let settings = method.settings(args, threads);
    let Ok(plan) = Plan::new(&job, &picture) else { return };
    let Ok(traced) = trace::trace_job(&job, &plan, settings, false, &|_| {}) else { return };
    let Ok(savings) = economy::savings(&job, &plan, settings, &traced) else { return };
    let mut lines = economy::uses(&kept.traced);
    lines.push(format!("At {}x{}:", size.width, size.height));
    lines.extend(savings);
    out.send(json!({ "event": "plan", "image": image, "lines": lines }));
}

fn tell_chart(
    args: &ViewArgs,
    source: &Source<'_>,
    methods: &[&str],
    size: Size,
    threads: &ThreadPool,
    out: &Out,
) {
    let mut picture = args.picture;
    picture.size = Some(size);
    picture.region = None;
    let chart_args = ChartArgs {
        scenes: Vec::new(),
        inputs: args.inputs.clone(),
        methods: methods.iter().map(|name| (*name).to_owned()).collect(),
        set: None,
        scaling: None,
        up_to: 1,
        runs: N_ROUNDS,
        warmup: 1,
        timeout: CHART_TIMEOUT,
        output: None,
        export: None,
        picture,
        limits: args.limits,
    };
    let Ok(thread) = driver::threads(1) else { return };
    let reporter = Reporter::for_programs();
    let bench = Bench {
        args: &chart_args,
        thread: &thread,
        two_threads: threads,
        all_threads: threads,
        about: &About::here(),
        reporter: &reporter,
    };
    let scene: &Path = &args.scene;
    let Ok(charts) = measure::measure_source(source.afresh(), scene, bench) else { return };
    for chart in charts {
        send_chart(chart, size, out);
    }
}

fn send_chart(chart: Chart, Size { width, height }: Size, out: &Out) {
    let diagram = chart.diagram.name();
    let reference = chart.diagram.reference_words();
    let data = Data { charts: vec![chart] };
    let Ok((svg, spots)) = page::svg(&data) else { return };
    let drawn = data.size();
    let share = |place: i32, length: u32| f64::from(place) / f64::from(length);
    let mark = |Spot { name, at: (x, y), .. }: &Spot| {
        json!([name, share(*x, drawn.0), share(*y, drawn.1)])
    };
    let message = json!({
        "event": "chart",
        "diagram": diagram,
        "size": format!("{width}x{height}"),
        "reference": reference,
        "tables": data.tables(),
        "marks": spots.iter().map(mark).collect::<Vec<_>>(),
        "methods": METHODS.iter().filter_map(choice).collect::<serde_json::Map<_, _>>(),
    });
    out.send_with(message, "image/svg+xml", svg.as_bytes());
}

/// A method's name, and what the page would choose to have it; none for those that only charts have.
fn choice(method: &crate::chart::methods::Method) -> Option<(String, Value)> {
    let chosen = match method.render {
        Render::Tracer(engine, precision) => {
            Method { engine, precision, sampling: renderer::sampling::Sampling::Centre }
        }
        Render::Sampled(sampling) => Method {
            engine: crate::args::Engine::Auto,
            precision: crate::args::Precision::F64,
            sampling,
        },
        Render::Naive(..) => return None,
    };
    Some((method.name.to_owned(), json!(chosen.choice())))
}
