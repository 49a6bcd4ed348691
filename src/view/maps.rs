//! What there is to know of all pixels of an image, computed when somebody asks for it.

use std::sync::Arc;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

use rayon::ThreadPool;
use renderer::probe::Cost;
use renderer::sampling::Sampling;
use serde_json::json;

use crate::args::{Precision, ViewArgs};
use crate::driver;
use crate::formats::difference;
use crate::run::certainty;
use crate::view::kept::Kept;
use crate::view::live;
use crate::view::protocol::{Map, Method, NUMBERS, Out};

/// Why there is no map.
const FAILED: &str = "a surface function fails there, or these numbers are beyond a limit";

/// Answers a question about an image, in a thread of its own. The time limit of a run holds for a map as
/// well: when that is over, the process ends.
pub(super) fn answer(
    id: u64,
    image: Option<Arc<Kept>>,
    map: Map,
    args: &'static ViewArgs,
    out: &'static Out,
) {
    let (sender, done) = mpsc::channel::<()>();
    if let Some(limit) = args.time.timeout {
        thread::spawn(move || limit_time(id, limit, &done, out));
    }
    thread::spawn(move || {
        let threads = driver::threads(args.threads.map_or(0, usize::from)).ok();
        let found = image.zip(threads).and_then(|(image, threads)| compute(&image, map, &threads));
        match found {
            Some((media_type, bytes)) => {
                out.send_with(json!({ "event": "answer", "id": id }), media_type, &bytes);
            }
            None => refuse(id, FAILED, out),
        }
        drop(sender);
    });
}

fn limit_time(id: u64, limit: Duration, done: &mpsc::Receiver<()>, out: &Out) {
    if done.recv_timeout(limit) == Err(RecvTimeoutError::Timeout) {
        refuse(id, "the time limit is reached; pixels are not explained until the next run", out);
        std::process::exit(0);
    }
}

fn refuse(id: u64, why: &str, out: &Out) {
    out.send(json!({ "event": "answer", "id": id, "answer": { "error": why } }));
}

/// The media type and the bytes of a map; none if it is not to be had.
fn compute(image: &Kept, map: Map, threads: &ThreadPool) -> Option<(&'static str, Vec<u8>)> {
    let bytes = match map {
        Map::Light => {
            let light = image.retraced::<[f32; 3]>(&image.plan, image.method, threads)?.picture;
            light.pixels.iter().flatten().flat_map(|channel| channel.to_le_bytes()).collect()
        }
        Map::ErrorF64 => errors(image, Precision::F64, threads)?,
        Map::ErrorDd => errors(image, Precision::Dd, threads)?,
        Map::ErrorCertified => errors(image, Precision::Certified, threads)?,
        Map::Cost => image.costs(threads)?.iter().flat_map(cost).collect(),
        Map::Certainty => return Some(("image/png", certainty(image, threads)?)),
    };
    Some((NUMBERS, bytes))
}

/// The method that differs in its numbers.
fn with(precision: Precision, method: Method) -> Method {
    match precision {
        // Which is about the centres of pixels.
        Precision::Certified => Method { precision, sampling: Sampling::Centre, ..method },
        _ => Method { precision, ..method },
    }
}

fn errors(image: &Kept, precision: Precision, threads: &ThreadPool) -> Option<Vec<u8>> {
    let light = |method| Some(image.retraced::<[f64; 3]>(&image.plan, method, threads)?.picture);
    let (own, other) = (light(image.method)?, light(with(precision, image.method))?);
    let channels = own.pixels.iter().flatten().zip(other.pixels.iter().flatten());
    Some(channels.flat_map(|(a, b)| (difference(*a, *b) as f32).to_le_bytes()).collect())
}

fn cost(cost: &Cost) -> [u8; 8] {
    let [rays, work] = [cost.rays, cost.work].map(|n| u32::try_from(n).unwrap_or(u32::MAX));
    (u64::from(rays) | u64::from(work) << 32).to_le_bytes()
}

fn certainty(image: &Kept, threads: &ThreadPool) -> Option<Vec<u8>> {
    let marks = |known: &[_]| live::png(&certainty::marks(known, &image.traced.picture));
    if let Some(known) = &image.traced.certainties {
        return Some(marks(known));
    }
    let method = with(Precision::Certified, image.method);
    let traced = image.retraced::<[u8; 3]>(&image.plan, method, threads)?;
    Some(marks(&traced.certainties?))
}
