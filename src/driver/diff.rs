//! `gmlvm diff`: how much two images differ.

use std::path::Path;

use serde::Serialize;

use crate::args::{DiffArgs, ImageFormat, Metric};
use crate::clean::clean;
use crate::console;
use crate::failure::Failure;
use crate::formats::{self, Picture, Pixels, Raster, difference};
use crate::output::Target;

/// Exit code for images that differ.
const EXIT_DIFFER: u8 = 1;

/// How two images of one size differ.
#[derive(Debug, Serialize)]
struct Comparison {
    same: bool,
    metric: &'static str,
    /// None for infinity, which JSON does not have.
    value: Option<f64>,
    tolerance: Option<f64>,
    width: u32,
    height: u32,
    /// Pixels with a channel off by more than the tolerance (0 unless the metric is `count`).
    differing: u64,
    /// The first of these, in reading order.
    first: Option<[u32; 2]>,
    /// Levels.
    max: f64,
    /// Levels.
    rmse: f64,
}

pub(super) fn diff(args: &DiffArgs) -> Result<u8, Failure> {
    let (a, b) = (read(&args.a)?, read(&args.b)?);
    if (a.width, a.height) != (b.width, b.height) {
        return unequal_sizes(args, &a, &b);
    }
    let comparison = compare(&a, &b, args);
    if let Some(path) = &args.map {
        write_map(&a, &b, path)?;
    }
    let text = if args.json { json(&comparison) } else { words(&comparison) };
    console::data(|out| writeln!(out, "{text}"))?;
    Ok(if comparison.same { 0 } else { EXIT_DIFFER })
}

fn read(path: &Path) -> Result<Raster, Failure> {
    formats::read(path).map_err(|reason| {
        Failure::Usage(format!("cannot read `{}`: {reason}", clean(&path.to_string_lossy())))
    })
}

fn unequal_sizes(args: &DiffArgs, a: &Raster, b: &Raster) -> Result<u8, Failure> {
    let sizes = [[a.width, a.height], [b.width, b.height]];
    let text = if args.json {
        serde_json::json!({ "same": false, "sizes": sizes }).to_string()
    } else {
        let [[aw, ah], [bw, bh]] = sizes;
        format!("differ: the sizes are {aw}x{ah} and {bw}x{bh}")
    };
    console::data(|out| writeln!(out, "{text}"))?;
    Ok(EXIT_DIFFER)
}

fn compare(a: &Raster, b: &Raster, args: &DiffArgs) -> Comparison {
    let default = if args.metric == Metric::Psnr { f64::INFINITY } else { 0.0 };
    let tolerance = args.tolerance.unwrap_or(default);
    let level = if args.metric == Metric::Count { tolerance } else { 0.0 };
    let (mut differing, mut first, mut max, mut squares) = (0, None, 0.0_f64, 0.0);
    for (idx, (pixel_a, pixel_b)) in a.pixels.iter().zip(&b.pixels).enumerate() {
        let differences = differences(pixel_a, pixel_b);
        let largest = differences.into_iter().fold(0.0, f64::max);
        max = max.max(largest);
        squares += differences.iter().map(|d| d * d).sum::<f64>();
        if largest > level {
            differing += 1;
            let width = a.width as usize;
            first.get_or_insert([(idx % width) as u32, (idx / width) as u32]);
        }
    }
    let rmse = (squares / (3 * a.pixels.len()) as f64).sqrt();
    let psnr = 20.0 * (255.0 / rmse).log10();
    let (metric, value, same) = match args.metric {
        Metric::Count => ("count", differing as f64, differing == 0),
        Metric::Max => ("max", max, max <= tolerance),
        Metric::Rmse => ("rmse", rmse, rmse <= tolerance),
        Metric::Psnr => ("psnr", psnr, psnr >= tolerance),
    };
    let finite = |number: f64| Some(number).filter(|number| number.is_finite());
    Comparison {
        same,
        metric,
        value: finite(value),
        tolerance: finite(tolerance),
        width: a.width,
        height: a.height,
        differing,
        first,
        max,
        rmse,
    }
}

/// Difference of each channel, in levels.
fn differences(a: &[f32; 3], b: &[f32; 3]) -> [f64; 3] {
    std::array::from_fn(|idx| difference(f64::from(a[idx]), f64::from(b[idx])))
}

fn json(comparison: &Comparison) -> String {
    serde_json::to_string(comparison).unwrap_or_else(|error| error.to_string())
}

fn words(comparison: &Comparison) -> String {
    let Comparison { same, metric, value, tolerance, differing, first, max, rmse, .. } = comparison;
    let n_pixels = u64::from(comparison.width) * u64::from(comparison.height);
    let level = if *metric == "count" { tolerance.unwrap_or_default() } else { 0.0 };
    let mut text = format!(
        "{}: {differing} of {n_pixels} pixels off by more than {level} levels, max {max}, \
         rmse {rmse:.4}",
        if *same { "same" } else { "differ" }
    );
    if *metric == "psnr" {
        text += &value.map_or(", psnr infinite".to_owned(), |psnr| format!(", psnr {psnr:.2} dB"));
    }
    if let Some([x, y]) = first {
        text += &format!(", first at ({x}, {y})");
    }
    text
}

/// Writes the picture of the differences: any difference can be seen, larger ones are brighter.
fn write_map(a: &Raster, b: &Raster, path: &Path) -> Result<(), Failure> {
    let brightness = |difference: f64| match difference {
        0.0 => 0,
        // `as` cuts at 255.
        levels => (64.0 + levels) as u8,
    };
    let pixels =
        a.pixels.iter().zip(&b.pixels).map(|(a, b)| differences(a, b).map(brightness)).collect();
    let picture = Picture { width: a.width, height: a.height, pixels: Pixels::Bytes(pixels) };
    let target = Target::path(path.to_owned());
    target.write_plain(&mut |out| formats::write(ImageFormat::Png, &picture, out))
}
