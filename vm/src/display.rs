//! Values as text, in GML syntax where there is one.

use crate::value::Value;

/// Text of one value is cut at this many bytes: arrays can share their parts, and a few dozen
/// lines of program can describe more elements than there are atoms.
const MAX_TEXT: usize = 1 << 20;

/// A value as GML would write it: reals with the fewest digits that read back the same, functions
/// as `{...}`, objects and lights as `<object>` and `<light>`.
#[must_use]
pub fn to_text(value: &Value) -> String {
    enum Piece<'v> {
        Value(&'v Value),
        Close,
    }
    let mut text = String::new();
    let mut pieces = vec![Piece::Value(value)];
    while let Some(piece) = pieces.pop() {
        if !text.is_empty() {
            text.push(' ');
        }
        if text.len() > MAX_TEXT {
            text.push_str("...");
            break;
        }
        match piece {
            Piece::Close => text.push(']'),
            Piece::Value(Value::Array(array)) => {
                text.push('[');
                pieces.push(Piece::Close);
                let room = MAX_TEXT.min(array.items().len());
                pieces.extend(array.items()[..room].iter().rev().map(Piece::Value));
            }
            Piece::Value(value) => text.push_str(&leaf_text(value)),
        }
    }
    text
}

fn leaf_text(value: &Value) -> String {
    match value {
        Value::Bool(value) => value.to_string(),
        Value::Int(value) => value.to_string(),
        Value::Real(value) => format!("{value:?}"),
        Value::Point([x, y, z]) => format!("{x:?} {y:?} {z:?} point"),
        Value::Str(text) => format!("\"{text}\""),
        Value::Closure(_) => "{...}".to_owned(),
        Value::Array(_) => "[...]".to_owned(),
        Value::Object(_) => "<object>".to_owned(),
        Value::Light(_) => "<light>".to_owned(),
    }
}
