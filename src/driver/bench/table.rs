//! Results as tables for people.

use std::fmt::Write;
use std::path::Path;

use compiler::diagnostic::grouped;

use crate::clean::clean;
use crate::driver::bench::export::{Compared, Details, Entry, Old, SceneDetails, SurfaceDetails};
use crate::measure::machine::Machine;
use crate::measure::statistics::unpaired_ratio;
use crate::measure::time;
use crate::run::stats::Phases;

/// What the figures below it depend on.
pub(super) fn heading(machine: &Machine) -> String {
    let cores = if machine.cores == 1 { "core" } else { "cores" };
    let load = machine.load.map(|load| format!(", load {load:.1}")).unwrap_or_default();
    format!(
        "gmlvm {} on {}, {} {cores}{load}\n",
        env!("CARGO_PKG_VERSION"),
        machine.cpu,
        machine.cores
    )
}

/// All entries of a scene.
pub(super) fn scene(scene: &Path, entries: &[Entry]) -> String {
    let name = scene.display().to_string();
    let mut text = format!("\n{}: ", clean(&name));
    match entries.first().map(|entry| &entry.details) {
        None => text.push_str("no surface functions\n"),
        Some(Details::Scene(first)) => {
            summary(first, entries[0].times.len(), &mut text);
            variants(entries, &mut text);
            phases(entries, &mut text);
        }
        Some(Details::Surface(_)) => surfaces(entries, &mut text),
    }
    text
}

/// Writing to a string cannot fail.
macro_rules! put {
    ($text:expr, $($arg:tt)*) => {
        writeln!($text, $($arg)*).expect("a string takes all")
    };
}

fn summary(first: &SceneDetails, n_rounds: usize, text: &mut String) {
    let rays = first.rays;
    put!(
        text,
        "{} {}, {} pixels, {} rays, {} surface calls, hash {}; {}",
        first.images,
        if first.images == 1 { "image" } else { "images" },
        grouped(first.pixels),
        grouped(rays.primary + rays.reflected + rays.shadow),
        grouped(rays.surface_calls),
        first.image_hash,
        rounds(n_rounds),
    );
}

fn rounds(n: usize) -> String {
    format!("{n} {}", if n == 1 { "round" } else { "rounds" })
}

fn variants(entries: &[Entry], text: &mut String) {
    put!(
        text,
        "  {:<9} {:>3} {:>10} {:>10} {:>10} {:>8} {:>8}  {}",
        "engine",
        "-j",
        "median",
        "spread",
        "processor",
        "Mrays/s",
        "Mcalls/s",
        "ratio"
    );
    for entry in entries {
        let Details::Scene(details) = &entry.details else { continue };
        let mega =
            |rate: Option<f64>| rate.map_or("–".to_owned(), |rate| format!("{:.2}", rate / 1e6));
        put!(
            text,
            "  {:<9} {:>3} {:>10} {:>10} {:>10} {:>8} {:>8}  {}",
            details.way,
            details.threads,
            time(entry.median),
            time(entry.spread),
            time(details.processor_time),
            mega(details.rays_per_second),
            mega(details.surface_calls_per_second),
            details.ratio_to_first.map_or("1".to_owned(), ratio),
        );
    }
}

fn phases(entries: &[Entry], text: &mut String) {
    let names = ["read", "compile", "run", "build", "jit", "trace", "write"];
    let names = names.map(|name| format!("{name:>9}")).join(" ");
    put!(text, "  {:<9} {:>3} {names}", "ms in", "-j");
    for entry in entries {
        let Details::Scene(SceneDetails { way, threads, phases, .. }) = &entry.details else {
            continue;
        };
        let Phases { read, compile, run, build, jit, trace, write } = *phases;
        let times = [read, compile, run, build, jit, trace, write];
        let times = times.map(|time| format!("{:>9.3}", time * 1e3)).join(" ");
        put!(text, "  {way:<9} {threads:>3} {times}");
    }
}

fn surfaces(entries: &[Entry], text: &mut String) {
    let is_first = |entry: &&Entry| matches!(&entry.details, Details::Surface(d) if d.ratio_to_first.is_none());
    let n_functions = entries.iter().filter(is_first).count();
    let n_rounds = entries[0].times.len();
    let functions = if n_functions == 1 { "function" } else { "functions" };
    put!(text, "{n_functions} surface {functions}; {}", rounds(n_rounds));
    for entry in entries {
        let Details::Surface(details) = &entry.details else { continue };
        if details.ratio_to_first.is_none() {
            surface_title(details, text);
        }
        let ratio = details.ratio_to_first.map(ratio).unwrap_or_default();
        let line = format!(
            "    {:<6} {:>10} ± {:<9}  {ratio}",
            details.engine,
            time(entry.median),
            time(entry.spread)
        );
        put!(text, "{}", line.trim_end());
        if let (Some(n_bytes), Some(n_uniforms)) = (details.code_bytes, details.uniforms)
            && details.ratio_to_first.is_some()
        {
            put!(
                text,
                "    specialized in {}, compiled in {}: {n_bytes} bytes, {n_uniforms} uniforms",
                time(details.specialize),
                time(details.generate)
            );
        }
    }
}

fn surface_title(details: &SurfaceDetails, text: &mut String) {
    let SurfaceDetails { surface, closures, failing_points, .. } = details;
    let times = if *closures == 1 { String::new() } else { format!(", {closures} times") };
    let failing = match failing_points {
        0 => String::new(),
        n => format!(", fails at {n} of the points"),
    };
    let how = match (&details.reason, details.evaluation) {
        (Some(reason), _) => format!(", not compiled: {reason}"),
        (None, "constant") => {
            format!(", constant (found in {}): never called", time(details.specialize))
        }
        _ => String::new(),
    };
    put!(text, "  {surface}{times}{failing}{how}");
}

/// How new entries compare with old ones of the same commands.
pub(super) fn comparison(old: &Old, entries: &[Entry], machine: &Machine) -> String {
    let mut text = format!("\nagainst {}, new time / old time:\n", old.name);
    if old.is_from_elsewhere(machine) {
        text.push_str("  these are times of another machine\n");
    }
    let by_command = old.by_command();
    for entry in entries {
        let found = match by_command.get(entry.command.as_str()) {
            None => "not measured then".to_owned(),
            Some(then) => {
                let compared = Compared::from(unpaired_ratio(then.times(), &entry.times));
                let images = if then.has_other_images(entry) { "; other images" } else { "" };
                format!("{}{images}", ratio(compared))
            }
        };
        put!(text, "  {}\n    {found}", clean(&entry.command));
    }
    text
}

/// A ratio, its interval and what they say.
fn ratio(compared: Compared) -> String {
    let Compared { ratio, interval, verdict } = compared;
    let interval = interval.map(|[low, high]| format!(" [{low:.3}, {high:.3}]"));
    format!("{ratio:.3}{}  {verdict}", interval.unwrap_or_default())
}
