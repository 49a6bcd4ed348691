//! What the server of a page and the process that renders for it say to one another.
//!
//! The server writes a [`Task`] as one line of JSON, behind which the scene's text follows, and then a
//! [`Question`] on each line. The worker answers with messages: a line of JSON that names an `event`, and
//! behind it as many bytes as its `bytes` says. What is wrong with the scene goes to the standard error,
//! as `--message-format json` has it.

use std::io::{self, Write};
use std::sync::{Mutex, PoisonError};

use clap::ValueEnum;
use renderer::sampling::Sampling;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::args::{Engine, Precision, ViewArgs, sampling};

/// How a scene is rendered, as the page chooses.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Choice {
    engine: String,
    precision: String,
    sampling: String,
}

/// The same in our own terms.
#[derive(Clone, Copy, Debug)]
pub(super) struct Method {
    pub(super) engine: Engine,
    pub(super) precision: Precision,
    pub(super) sampling: Sampling,
}

/// What a worker is to do first.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Task {
    /// Length of the scene's text in bytes.
    pub(super) n_bytes: usize,
    pub(super) choice: Choice,
}

/// What somebody wants to know of an image.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct Question {
    /// By which the answer is known.
    pub(super) id: u64,
    pub(super) image: usize,
    pub(super) about: About,
}

/// What a question is about.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) enum About {
    /// A pixel that somebody points at.
    Pixel { x: u32, y: u32 },
    /// All pixels.
    Map(Map),
}

/// What there is to know of all pixels of an image. Numbers have 32 bits, the lowest byte first, row by row
/// from the upper left.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Map {
    /// Linear red, green and blue, not clamped, as the image was traced.
    Light,
    /// How far each of them is from the same traced with these numbers.
    ErrorF64,
    ErrorDd,
    ErrorCertified,
    /// The rays that the pixel's centre takes, and the instructions of surface functions.
    Cost,
    /// How the pixel's centre is known, as a picture.
    Certainty,
}

/// The media type of maps of numbers.
pub(super) const NUMBERS: &str = "application/octet-stream";

impl Map {
    /// The map of a name; none if there is no such map.
    pub(super) fn named(name: &str) -> Option<Self> {
        serde_json::from_value(json!(name)).ok()
    }
}

impl Choice {
    /// What the command line says.
    pub(super) fn of(args: &ViewArgs) -> Self {
        Method {
            engine: args.engine,
            precision: args.precision,
            sampling: args.sampling.sampling(),
        }
        .choice()
    }

    /// What it stands for; none if that is nothing.
    pub(super) fn method(&self) -> Option<Method> {
        let engine = Engine::from_str(&self.engine, false).ok()?;
        let precision = Precision::from_str(&self.precision, false).ok()?;
        let sampling = match precision {
            // Which is about the centres of pixels.
            Precision::Certified => Sampling::Centre,
            _ => sampling::named(&self.sampling)?,
        };
        Some(Method { engine, precision, sampling })
    }
}

impl Method {
    /// The words for it.
    pub(super) fn choice(self) -> Choice {
        Choice {
            engine: self.engine.name().to_owned(),
            precision: self.precision.name().to_owned(),
            sampling: sampling::name(self.sampling),
        }
    }
}

/// Where a worker's messages go.
pub(super) struct Out(Mutex<io::Stdout>);

impl Out {
    pub(super) fn new() -> Self {
        Out(Mutex::new(io::stdout()))
    }

    /// Sends a message without bytes.
    pub(super) fn send(&self, message: Value) {
        self.send_with(message, "", &[]);
    }

    /// Sends a message with a file of this media type.
    pub(super) fn send_with(&self, mut message: Value, media_type: &str, bytes: &[u8]) {
        if !media_type.is_empty() {
            message["bytes"] = json!(bytes.len());
            message["type"] = json!(media_type);
        }
        let mut out = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let written = writeln!(out, "{message}")
            .and_then(|()| out.write_all(bytes))
            .and_then(|()| out.flush());
        if written.is_err() {
            // Nobody is interested any more.
            std::process::exit(0);
        }
    }
}
