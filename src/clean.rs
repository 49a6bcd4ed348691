//! Text that is fit to be shown: control characters become visible, large numbers legible.

use std::borrow::Cow;

/// The text with every character that is not plainly printable as `\u{1b}`; line breaks too.
pub(crate) fn clean(text: &str) -> Cow<'_, str> {
    if text.chars().all(is_printable) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        push(&mut shown, c);
    }
    Cow::Owned(shown)
}

/// The same for a text of several lines, which stay apart.
pub(crate) fn clean_lines(text: &str) -> String {
    let lines: Vec<_> = text.split('\n').map(clean).collect();
    lines.join("\n")
}

/// A number with its digits in groups of three.
pub(crate) fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (idx, digit) in digits.chars().enumerate() {
        if idx > 0 && (digits.len() - idx).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

/// Appends one character as [`clean`] shows it.
pub(crate) fn push(shown: &mut String, c: char) {
    if is_printable(c) { shown.push(c) } else { shown.extend(c.escape_unicode()) }
}

fn is_printable(c: char) -> bool {
    // `escape_debug` knows what is printable, but would escape quotes too.
    matches!(c, ' '..='~') || c.escape_debug().len() == 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terminals_get_no_commands() {
        assert_eq!(clean("a\u{1b}[2J\"b\\\n"), "a\\u{1b}[2J\"b\\\\u{a}");
        assert_eq!(clean("caf\u{e9} \u{202e}"), "caf\u{e9} \\u{202e}");
        assert_eq!(clean_lines("a\n\u{7}"), "a\n\\u{7}");
    }

    #[test]
    fn numbers_are_grouped() {
        assert_eq!([1, 999, 1000, 1_234_567].map(grouped), ["1", "999", "1 000", "1 234 567"]);
    }
}
