//! Answers to requests about one document: what a word means, where else it stands, what may follow.

use std::collections::BTreeMap;

use compiler::names::{Binding, Clash};
use compiler::op::{Operator, Type};
use compiler::source::Span;
use serde_json::{Value, json};

use crate::lsp::documents::Document;
use crate::lsp::program::{Program, without_slash};
use crate::lsp::types::{Location, Position, TextEdit};

// What names are, by the protocol's numbers.
const HIGHLIGHT_READ: u8 = 2;
const HIGHLIGHT_WRITE: u8 = 3;
const SYMBOL_FUNCTION: u8 = 12;
const SYMBOL_VARIABLE: u8 = 13;
const SYMBOL_ARRAY: u8 = 18;
const SYMBOL_OBJECT: u8 = 19;
const ITEM_FUNCTION: u8 = 3;
const ITEM_VARIABLE: u8 = 6;
const ITEM_CONSTANT: u8 = 21;
const ITEM_OPERATOR: u8 = 24;

/// The most bytes of source text that a hover shows of a value.
const MAX_SHOWN: usize = 300;

/// The most lines of comment that a hover shows of what stands above a binding.
const MAX_COMMENT: usize = 12;

/// What an operator does, or what a name is bound to.
pub(super) fn hover(program: &Program, place: Position) -> Option<Value> {
    let (text, span) = match program.operator_at(place) {
        Some((op, span)) => (operator_text(op), span),
        None => {
            let (binding, span) = program.binding_at(place)?;
            (binding_text(program, &program.names.bindings[binding]), span)
        }
    };
    Some(json!({ "contents": markdown(&text), "range": program.range(span) }))
}

fn markdown(text: &str) -> Value {
    json!({ "kind": "markdown", "value": text })
}

fn operator_text(op: Operator) -> String {
    let effect = op.stack_effect();
    format!("{}\n\n{}", fenced("text", &format!("{}: {effect}", op.spelling())), op.doc())
}

fn binding_text(program: &Program, binding: &Binding) -> String {
    let ty = binding.ty.map_or("a value", Type::with_article);
    let Some(file) = program.sources.file_of(binding.span) else {
        return format!("`{}`: {ty}, bound before the program starts", binding.name);
    };
    let is_here = program.is_before(binding.value, binding.span);
    let start = if is_here { binding.value.to(binding.span) } else { binding.span };
    let line = file.line_column(binding.span).line;
    let text = comment_above(program, start) + &shown(program.sources.text(start));
    let from = if binding.is_surface_argument {
        ", given to surface functions"
    } else if program.is_here(binding.span) {
        ""
    } else {
        &format!(", from `{}`", file.name.replace('`', "'"))
    };
    let effect = binding.effect.as_ref().map_or(String::new(), |effect| format!(" `{effect}`"));
    format!("{}\n\n{ty}{effect}, bound in line {line}{from}", fenced("gml", &text))
}

/// A block of code in Markdown. Nothing in a scene, which may be a stranger's, ends it, or is taken
/// for Markdown.
fn fenced(language: &str, text: &str) -> String {
    let longest = text.split(|c| c != '`').map(str::len).max().unwrap_or(0);
    let fence = "`".repeat(3.max(longest + 1));
    format!("{fence}{language}\n{text}\n{fence}")
}

/// A piece of source text, cut if it is long.
fn shown(text: &str) -> String {
    if text.len() <= MAX_SHOWN {
        return text.to_owned();
    }
    format!("{} ...", &text[..text.floor_char_boundary(MAX_SHOWN)])
}

/// The comment in the lines right above a place.
fn comment_above(program: &Program, span: Span) -> String {
    let Some(file) = program.sources.file_of(span) else { return String::new() };
    let line = file.line_column(span).line;
    let above = (1..line).rev().take(MAX_COMMENT).map_while(|line| {
        file.line(line).map(str::trim).filter(|text| text.starts_with('%')).map(shown)
    });
    let mut lines: Vec<_> = above.collect();
    lines.reverse();
    lines.iter().map(|line| format!("{line}\n")).collect()
}

/// The binder of the name at a place.
pub(super) fn definition(
    program: &Program,
    place: Position,
    open: &BTreeMap<String, Document>,
) -> Option<Location> {
    let (binding, _) = program.binding_at(place)?;
    program.location(without_slash(program.names.bindings[binding].span), open)
}

/// The uses of the name at a place, behind its binder if that is wanted.
pub(super) fn references(
    program: &Program,
    place: Position,
    with_binder: bool,
    open: &BTreeMap<String, Document>,
) -> Option<Vec<Location>> {
    let (binding, _) = program.binding_at(place)?;
    let binder = without_slash(program.names.bindings[binding].span);
    let spans = with_binder.then_some(binder).into_iter().chain(program.names.uses_of(binding));
    Some(spans.filter_map(|span| program.location(span, open)).collect())
}

/// The same within the document.
pub(super) fn highlights(program: &Program, place: Position) -> Option<Vec<Value>> {
    let (binding, _) = program.binding_at(place)?;
    let mark = |(span, kind)| json!({ "range": program.range(span), "kind": kind });
    let binder = without_slash(program.names.bindings[binding].span);
    let uses = program.names.uses_of(binding).map(|span| (span, HIGHLIGHT_READ));
    let all = std::iter::once((binder, HIGHLIGHT_WRITE)).chain(uses);
    Some(all.filter(|(span, _)| program.is_here(*span)).map(mark).collect())
}

/// The name that a renaming would change.
pub(super) fn prepare_rename(program: &Program, place: Position) -> Option<Value> {
    let (binding, span) = program.binding_at(place)?;
    let binding = &program.names.bindings[binding];
    let span = if span == binding.span { without_slash(span) } else { span };
    Some(json!({ "range": program.range(span), "placeholder": &*binding.name }))
}

/// The edits that give the name at a place another one wherever it stands.
///
/// # Errors
/// In words, when some name would come to mean something else, here or in other scenes.
pub(super) fn rename(
    program: &Program,
    place: Position,
    new: &str,
) -> Result<Vec<TextEdit>, String> {
    let (binding, _) = program.binding_at(place).ok_or("no name that is bound stands here")?;
    let Binding { name, span: binder, .. } = &program.names.bindings[binding];
    if binder.is_none() {
        return Err(format!("`{name}` is bound before the program starts, not in its text"));
    }
    let spans: Vec<Span> = program.names.uses_of(binding).chain([without_slash(*binder)]).collect();
    if let Some(&elsewhere) = spans.iter().find(|span| !program.is_here(**span)) {
        let file = program.sources.file_of(elsewhere).map_or("", |file| &file.name);
        return Err(format!("`{name}` stands in `{file}` too, which other scenes may include"));
    }
    let checked = program.names.check_renaming(&program.tokens, &program.predefined, binding, new);
    checked.map_err(|clash| match clash {
        Clash::NoName(reason) => format!("`{new}` cannot be bound: {reason}"),
        Clash::Captured(used, binder) => {
            let line = |span| program.sources.file_of(span).map_or(0, |f| f.line_column(span).line);
            let word = program.sources.text(used);
            let meant = match binder {
                Some(span) if !span.is_none() => format!("bound in line {}", line(span)),
                _ => "bound elsewhere".to_owned(),
            };
            format!("`{word}` in line {} would become another `{new}`, {meant}", line(used))
        }
    })?;
    let edit = |&span| TextEdit { range: program.range(span), new_text: new.to_owned() };
    Ok(spans.iter().map(edit).collect())
}

/// What the document binds outside all brackets.
pub(super) fn symbols(program: &Program) -> Vec<Value> {
    let bindings = program.names.bindings.iter();
    let own = bindings.filter(|binding| binding.depth == 0 && program.is_here(binding.span));
    own.map(|binding| {
        let kind = match binding.ty {
            Some(Type::Closure) => SYMBOL_FUNCTION,
            Some(Type::Array) => SYMBOL_ARRAY,
            Some(Type::Object | Type::Light) => SYMBOL_OBJECT,
            _ => SYMBOL_VARIABLE,
        };
        // A value bound under a second name stands elsewhere.
        let value = Some(binding.value).filter(|value| program.is_before(*value, binding.span));
        let whole = value.unwrap_or(binding.span).to(binding.span);
        json!({
            "name": &*binding.name,
            "detail": binding.ty.map_or("", Type::name),
            "kind": kind,
            "range": program.range(whole),
            "selectionRange": program.range(without_slash(binding.span)),
        })
    })
    .collect()
}

/// The words that may stand at a place: names in sight, operators, booleans.
pub(super) fn completions(program: &Program, place: Position) -> Vec<Value> {
    let text = &program.file().text;
    let at = program.lines.byte(text, place);
    let line = &text[..at][text[..at].rfind(['\n', '\r']).map_or(0, |end| end + 1)..];
    let word_start = line.rfind(|c: char| !(c.is_ascii_alphanumeric() || "-_".contains(c)));
    let before = word_start.map_or("", |start| &line[start..]);
    // In a string or a comment, and behind the `/` of a binder, no word of ours can stand.
    let is_quoted = line.matches('"').count() % 2 == 1;
    if is_quoted || line.contains('%') || before.starts_with('/') {
        return Vec::new();
    }
    let names = program.in_sight(place).into_iter().map(|binding| {
        let kind = match binding.ty {
            Some(Type::Closure) => ITEM_FUNCTION,
            _ => ITEM_VARIABLE,
        };
        let detail = binding.ty.map_or("", Type::name);
        json!({ "label": &*binding.name, "kind": kind, "detail": detail })
    });
    let operators = Operator::ALL.iter().map(|op| {
        json!({
            "label": op.spelling(),
            "kind": ITEM_OPERATOR,
            "detail": op.stack_effect(),
            "documentation": markdown(op.doc()),
        })
    });
    let booleans = ["true", "false"].map(|word| json!({ "label": word, "kind": ITEM_CONSTANT }));
    names.chain(operators).chain(booleans).collect()
}
