//! `gmlvm explain`: the paragraph behind a diagnostic's code.

use compiler::diagnostic::Code;

use crate::args::ExplainArgs;
use crate::clean::clean;
use crate::console;
use crate::failure::Failure;

/// Width of the text, in characters.
const WIDTH: usize = 80;

pub(super) fn explain(args: &ExplainArgs) -> Result<u8, Failure> {
    let wanted = args.code.to_ascii_uppercase();
    let digits = wanted.strip_prefix('E').unwrap_or(&wanted);
    let Some(code) = Code::ALL.iter().find(|code| &code.as_str()[1..] == digits) else {
        return Err(Failure::Usage(format!(
            "there is no code `{}`; did you mean `{}`?",
            clean(&args.code),
            nearest(digits).as_str()
        )));
    };
    console::data(|out| {
        writeln!(out, "{}: {}\n", code.as_str(), code.title())?;
        writeln!(out, "{}", wrapped(code.explanation()))
    })?;
    Ok(0)
}

/// The code with the most digits in their places; of several, the nearest number.
fn nearest(digits: &str) -> Code {
    let number: i64 = digits.parse().unwrap_or_default();
    let distance = |code: &Code| {
        let own = &code.as_str()[1..];
        let n_equal = own.bytes().zip(digits.bytes()).filter(|(a, b)| a == b).count();
        let own_number: i64 = own.parse().unwrap_or_default();
        (std::cmp::Reverse(n_equal), own_number.abs_diff(number))
    };
    Code::ALL.iter().copied().min_by_key(distance).unwrap_or(Code::BadCharacter)
}

fn wrapped(text: &str) -> String {
    let mut shown = String::new();
    let mut length = 0;
    for word in text.split_whitespace() {
        let word_length = word.chars().count();
        if length > 0 {
            let fits = length + 1 + word_length <= WIDTH;
            shown.push(if fits { ' ' } else { '\n' });
            length = if fits { length + 1 } else { 0 };
        }
        shown.push_str(word);
        length += word_length;
    }
    shown
}
