//! Listings of surface functions as one page with linked panes, without anything from elsewhere.
//!
//! Programs are not trusted. Their text is data in the page, in which no `<` is left as it is, and the
//! script only ever makes text of it. The page's policy names its one script by its hash, so that no
//! browser would run another.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, Write};

use compiler::bytecode::Program;
use compiler::disasm;
use compiler::source::{SourceFile, SourceMap, Span};
use jit::listing::{Line, Outcome, Site};
use serde::Serialize;

use crate::clean::clean;
use crate::listing::text::{details, outcome, span};
use crate::listing::{Surfaces, numbered};
use crate::load::place;

const PAGE: &str = include_str!("page/page.html");
const STYLE: &str = include_str!("page/page.css");
const SCRIPT: &str = include_str!("page/page.js");
/// What `openssl dgst -sha256 -binary FILE | base64` says of the two. A browser that finds another
/// hash ignores them.
const STYLE_HASH: &str = "1WZkA0vRdbXY+ptE/uPH0jofyvWDsWir6C1qi85OSec=";
const SCRIPT_HASH: &str = "CoEeey0Gt9Tg4azkkDuar+LU9m2nYeLTepHMHgX35yE=";

/// A page has at most so many rows, and one surface; whoever wants more chooses a surface.
pub(crate) const MAX_ROWS: usize = 200_000;
/// Of longer files only those lines are shown that something came from, and lines around them.
const MAX_FILE_LINES: usize = 2000;
const LINES_AROUND: usize = 3;
/// Lines are cut at this many characters.
const MAX_LINE_CHARS: usize = 400;

/// A page in the making.
pub(crate) struct Page<'p> {
    program: &'p Program,
    sources: &'p SourceMap,
    surfaces: Vec<SurfaceData>,
    functions: BTreeMap<u32, FunctionData>,
    /// The files that something came from, in the order of their appearance, with the lines.
    files: Vec<(&'p SourceFile, BTreeSet<usize>)>,
    n_rows: usize,
    max_rows: usize,
    n_hidden: usize,
}

/// Number, text, source line, bytecode instruction.
type Row = (String, String, String, String);

#[derive(Serialize)]
struct SurfaceData {
    name: String,
    numbers: Vec<usize>,
    outcome: String,
    details: Vec<(String, String)>,
    functions: Vec<u32>,
    clif: Vec<Row>,
    asm: Vec<Row>,
}

#[derive(Serialize)]
struct FunctionData {
    title: String,
    lines: Vec<Row>,
}

#[derive(Serialize)]
struct FileData {
    name: String,
    lines: Vec<(usize, String)>,
}

#[derive(Serialize)]
struct Data<'d> {
    surfaces: &'d [SurfaceData],
    functions: &'d BTreeMap<u32, FunctionData>,
    files: Vec<FileData>,
    hidden: String,
}

impl<'p> Page<'p> {
    /// A page without surfaces, with room for about so many rows.
    pub(crate) fn new(program: &'p Program, sources: &'p SourceMap, max_rows: usize) -> Self {
        Page {
            program,
            sources,
            surfaces: Vec::new(),
            functions: BTreeMap::new(),
            files: Vec::new(),
            n_rows: 0,
            max_rows,
            n_hidden: 0,
        }
    }

    /// Adds surfaces that share a shader, as long as there is room.
    pub(crate) fn add(&mut self, surfaces: &Surfaces) {
        if self.n_rows > self.max_rows {
            self.n_hidden += 1;
            return;
        }
        let Surfaces { numbers, listing } = surfaces;
        let functions: Vec<u32> = listing.functions.iter().rev().copied().collect();
        for &function in &functions {
            self.add_function(function);
        }
        let (clif, asm) = match &listing.outcome {
            Outcome::Native(native) => (self.rows(&native.clif), self.rows(&native.asm)),
            Outcome::Constant(_) | Outcome::Declined(_) => (Vec::new(), Vec::new()),
        };
        let details = details(listing);
        self.n_rows += 1 + details.len() + clif.len() + asm.len();
        let title = disasm::title(self.program, listing.function);
        self.surfaces.push(SurfaceData {
            name: cut(&format!("{}: {title}", numbered(numbers))),
            numbers: numbers.clone(),
            outcome: outcome(&listing.outcome, self.sources),
            details,
            functions,
            clif,
            asm,
        });
    }

    fn add_function(&mut self, index: u32) {
        if self.functions.contains_key(&index) {
            return;
        }
        let function = &self.program.functions[index as usize];
        let lines: Vec<Row> = (0..function.code.len())
            .map(|pc| {
                let site = Site { function: index, pc: pc as u32 };
                let text = cut(&disasm::instruction(self.program, index, pc));
                self.row(format!("{pc:04}"), text, Some(site))
            })
            .collect();
        self.n_rows += lines.len();
        let at = place(self.sources, function.span);
        let title = cut(&format!("{}, {at}", disasm::title(self.program, index)));
        self.functions.insert(index, FunctionData { title, lines });
    }

    fn rows(&mut self, lines: &[Line]) -> Vec<Row> {
        let row = |line: &Line| {
            let offset = line.offset.map_or(String::new(), |offset| format!("{offset:04x}"));
            self.row(offset, line.text.clone(), line.site)
        };
        lines.iter().map(row).collect()
    }

    fn row(&mut self, number: String, text: String, site: Option<Site>) -> Row {
        let line = site.and_then(|site| self.source_line(span(self.program, site)));
        let site = site.map_or(String::new(), |site| format!("{}:{}", site.function, site.pc));
        (number, text, line.unwrap_or_default(), site)
    }

    /// The name of a source line on the page, which it is on from now on.
    fn source_line(&mut self, span: Span) -> Option<String> {
        let file = self.sources.file_of(span)?;
        let known = self.files.iter().position(|(other, _)| std::ptr::eq(*other, file));
        let index = known.unwrap_or_else(|| {
            self.files.push((file, BTreeSet::new()));
            self.files.len() - 1
        });
        let line = file.line_column(span).line;
        self.files[index].1.insert(line);
        Some(format!("{index}:{line}"))
    }

    /// What the page shows, as JSON in which no `<` is left as it is.
    ///
    /// # Errors
    /// None that can happen to text.
    pub(crate) fn data(&self) -> io::Result<String> {
        let hidden = match self.n_hidden {
            0 => String::new(),
            n => format!("{n} more did not fit; choose one with --surface"),
        };
        let files = self.files.iter().map(|(file, used)| file_data(file, used)).collect();
        let data = Data { surfaces: &self.surfaces, functions: &self.functions, files, hidden };
        Ok(serde_json::to_string(&data)?.replace('<', "\\u003c"))
    }

    /// Writes the page.
    ///
    /// # Errors
    /// Those of `out`.
    pub(crate) fn write(&self, title: &str, out: &mut dyn Write) -> io::Result<()> {
        let data = self.data()?;
        let mut rest = PAGE;
        // What is put in may look like a place to put something, and is not looked at again.
        while let Some((before, after)) = rest.split_once('{') {
            let (name, after) = after.split_once('}').unwrap_or((after, ""));
            out.write_all(before.as_bytes())?;
            let text = match name {
                "style" => STYLE,
                "script" => SCRIPT,
                "style-hash" => STYLE_HASH,
                "script-hash" => SCRIPT_HASH,
                "data" => &data,
                _ => &escaped(&cut(title)),
            };
            out.write_all(text.as_bytes())?;
            rest = after;
        }
        out.write_all(rest.as_bytes())
    }
}

fn file_data(file: &SourceFile, used: &BTreeSet<usize>) -> FileData {
    let is_short = file.line(MAX_FILE_LINES + 1).is_none();
    let is_shown = |line: usize| {
        let around = line.saturating_sub(LINES_AROUND)..=line + LINES_AROUND;
        is_short || used.range(around).next().is_some()
    };
    let numbers: Vec<usize> = match used.last() {
        Some(last) if !is_short => {
            (1..=last + LINES_AROUND).filter(|line| is_shown(*line)).collect()
        }
        _ => (1..=MAX_FILE_LINES).collect(),
    };
    let lines = numbers.into_iter().map_while(|line| Some((line, cut(file.line(line)?))));
    FileData { name: cut(&file.name), lines: lines.collect() }
}

/// A line that is fit to be shown. Tabs stay.
fn cut(text: &str) -> String {
    let end = text.char_indices().nth(MAX_LINE_CHARS).map_or(text.len(), |(end, _)| end);
    let cleaned: Vec<_> = text[..end].split('\t').map(clean).collect();
    let dots = if end < text.len() { "..." } else { "" };
    cleaned.join("\t") + dots
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
