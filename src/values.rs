//! The values of command line options: how they are written, and what they mean.

use std::fmt;
use std::sync::Arc;
use std::time::Duration;

use compiler::bytecode::Constant;
use compiler::diagnostic::Code;
use compiler::lexer::TokenKind;
use compiler::preprocess::{self, NoIncludes};
use compiler::source::SourceMap;

/// An image size in pixels, both at least 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Size {
    pub(crate) width: u32,
    pub(crate) height: u32,
}

/// A rectangle of pixels, counted from the upper left corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Region {
    pub(crate) x: u32,
    pub(crate) y: u32,
    pub(crate) width: u32,
    pub(crate) height: u32,
}

impl Region {
    /// The part inside an image of this size; `None` if there is none.
    pub(crate) fn clipped(self, width: u32, height: u32) -> Option<Region> {
        let inside = |from: u32, length: u32, limit: u32| {
            limit.checked_sub(from).map(|rest| length.min(rest)).filter(|&length| length > 0)
        };
        Some(Region {
            width: inside(self.x, self.width, width)?,
            height: inside(self.y, self.height, height)?,
            ..self
        })
    }
}

impl fmt::Display for Region {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{},{},{},{}", self.x, self.y, self.width, self.height)
    }
}

/// A binding made before the scene starts.
#[derive(Clone, Debug)]
pub(crate) struct Definition {
    pub(crate) name: Arc<str>,
    pub(crate) value: Constant,
    /// `NAME=VALUE`, as written.
    pub(crate) text: String,
}

/// Reads `WxH`.
pub(crate) fn size(text: &str) -> Result<Size, String> {
    let (width, height) = text.split_once('x').ok_or("write WIDTHxHEIGHT, as in 320x240")?;
    Ok(Size { width: at_least_one(width)?, height: at_least_one(height)? })
}

/// Reads `X,Y,W,H`.
pub(crate) fn region(text: &str) -> Result<Region, String> {
    let parts: Vec<_> = text.split(',').collect();
    let [x, y, width, height] = parts[..] else {
        return Err("write X,Y,WIDTH,HEIGHT, as in 112,40,16,16".to_owned());
    };
    Ok(Region {
        x: whole(x)?,
        y: whole(y)?,
        width: at_least_one(width)?,
        height: at_least_one(height)?,
    })
}

/// Reads a number of bytes, with `k`, `M`, `G` or `T` for powers of 1024.
pub(crate) fn bytes(text: &str) -> Result<u64, String> {
    let (digits, shift) = match text.char_indices().next_back() {
        Some((at, 'k' | 'K')) => (&text[..at], 10),
        Some((at, 'M')) => (&text[..at], 20),
        Some((at, 'G')) => (&text[..at], 30),
        Some((at, 'T')) => (&text[..at], 40),
        _ => (text, 0),
    };
    let number: u64 = digits.parse().map_err(|_| "write a number of bytes, as in 512M or 4G")?;
    number.checked_mul(1 << shift).ok_or_else(|| "is more than there can be".to_owned())
}

/// Reads a time above zero, with `s` or `ms`; without either it is in seconds.
pub(crate) fn duration(text: &str) -> Result<Duration, String> {
    let (number, unit) = match text.strip_suffix("ms") {
        Some(number) => (number, 1e-3),
        None => (text.strip_suffix('s').unwrap_or(text), 1.0),
    };
    let seconds = number.parse::<f64>().ok().filter(|seconds| *seconds > 0.0);
    seconds
        .and_then(|seconds| Duration::try_from_secs_f64(seconds * unit).ok())
        .ok_or_else(|| "write a time above zero, as in 10s or 500ms".to_owned())
}

/// Reads a tolerance: a real that is not negative.
pub(crate) fn tolerance(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number >= 0.0 => Ok(number),
        _ => Err("write a number that is not negative".to_owned()),
    }
}

fn whole(text: &str) -> Result<u32, String> {
    text.trim()
        .parse()
        .map_err(|_| format!("`{text}` is not a whole number from 0 to {}", u32::MAX))
}

fn at_least_one(text: &str) -> Result<u32, String> {
    match whole(text)? {
        0 => Err("a width or height must be at least 1".to_owned()),
        number => Ok(number),
    }
}

/// Reads `NAME=VALUE`; both are read as GML would, but text without quotes is a string too.
pub(crate) fn definition(text: &str) -> Result<Definition, String> {
    let (name, value) = text.split_once('=').ok_or("write NAME=VALUE")?;
    let name = match words(&format!("/{name}")).as_deref() {
        Ok([TokenKind::Binder(name)]) => name.clone(),
        Err(Code::ReservedBinder) => return Err(format!("`{name}` is reserved")),
        _ => return Err(format!("`{name}` is not a name: letters, then digits, `-` and `_`")),
    };
    Ok(Definition { name, value: constant(value)?, text: text.to_owned() })
}

fn constant(text: &str) -> Result<Constant, String> {
    match words(text).as_deref() {
        Ok([TokenKind::Bool(value)]) => Ok(Constant::Bool(*value)),
        Ok([TokenKind::Int(value)]) => Ok(Constant::Int(*value)),
        Ok([TokenKind::Real(value)]) => Ok(Constant::Real(*value)),
        Ok([TokenKind::Str(value)]) => Ok(Constant::Str(value.clone())),
        Err(Code::BadNumber) => Err(format!("the number `{text}` is out of range")),
        _ if text.starts_with('"') => Err(format!("`{text}` is not a string in quotes")),
        _ => Ok(Constant::Str(text.into())),
    }
}

/// The words of a line of GML, or the code of the first error.
fn words(text: &str) -> Result<Vec<TokenKind>, Code> {
    let mut sources = SourceMap::default();
    let file = sources.add("", text.as_bytes().to_vec()).map_err(|_| Code::SourceTooLarge)?;
    match preprocess::tokens(&mut sources, file, &mut NoIncludes) {
        Ok(tokens) => Ok(tokens.into_iter().map(|token| token.kind).collect()),
        Err(diagnostics) => Err(diagnostics.first().map_or(Code::BadCharacter, |d| d.code)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn definitions_are_read_as_gml_would() {
        let show = |text: &str| match definition(text) {
            Ok(Definition { name, value, .. }) => format!("{name} {value:?}"),
            Err(error) => format!("error: {error}"),
        };
        assert_eq!(show("n=5"), "n Int(5)");
        assert_eq!(show("n=-5"), "n Int(-5)");
        assert_eq!(show("n=1e3"), "n Real(1000.0)");
        assert_eq!(show("ok=true"), "ok Bool(true)");
        assert_eq!(show("s=\"a b\""), "s Str(\"a b\")");
        assert_eq!(show("s=a.ppm"), "s Str(\"a.ppm\")");
        assert_eq!(show("s=sphere"), "s Str(\"sphere\")");
        assert_eq!(show("s="), "s Str(\"\")");
        assert_eq!(show("a=b=c"), "a Str(\"b=c\")");
        assert_eq!(show("n=1.5.2"), "n Str(\"1.5.2\")");
        assert!(show("n=99999999999999999999").contains("out of range"));
        assert!(show("s=\"a").contains("not a string"));
        assert_eq!(show("addi=5"), "error: `addi` is reserved");
        assert!(show("5=5").contains("not a name") && show("a b=5").contains("not a name"));
        assert!(show("=5").contains("not a name") && show("n").contains("NAME=VALUE"));
    }

    #[test]
    fn sizes_and_regions() {
        assert_eq!(size("320x240"), Ok(Size { width: 320, height: 240 }));
        assert!(size("0x5").is_err() && size("5").is_err() && size("5x-1").is_err());
        let region = region("2,3,10,10").expect("well formed");
        let clipped = region.clipped(8, 100).expect("overlaps");
        assert_eq!((clipped.width, clipped.height), (6, 10));
        assert!(region.clipped(2, 100).is_none());
    }

    #[test]
    fn durations() {
        assert_eq!(duration("10s"), Ok(Duration::from_secs(10)));
        assert_eq!(duration("0.5"), Ok(Duration::from_millis(500)));
        assert_eq!(duration("250ms"), Ok(Duration::from_millis(250)));
        assert!(
            ["0", "-1s", "s", "NaN", "inf", "1e300s"].iter().all(|text| duration(text).is_err())
        );
    }

    #[test]
    fn byte_counts() {
        assert_eq!(bytes("512"), Ok(512));
        assert_eq!(bytes("4G"), Ok(4 << 30));
        assert_eq!(bytes("1k"), Ok(1024));
        assert!(bytes("").is_err() && bytes("-1").is_err() && bytes("99999999999T").is_err());
    }
}
