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

/// The same for a text of several lines, which stay apart; tabs stay too.
pub(crate) fn clean_lines(text: &str) -> String {
    let pieces = text.split_inclusive(['\n', '\t']);
    pieces.fold(String::with_capacity(text.len()), |mut shown, piece| {
        let printed = piece.strip_suffix(['\n', '\t']).unwrap_or(piece);
        shown.push_str(&clean(printed));
        shown.push_str(&piece[printed.len()..]);
        shown
    })
}

/// A message without the middle of what would fill the screen, such as a name of a million letters.
pub(crate) fn shortened(text: &str) -> Cow<'_, str> {
    const MAX: usize = 400;
    const KEPT: usize = 160;
    if text.len() <= MAX {
        return Cow::Borrowed(text);
    }
    let start = &text[..text.floor_char_boundary(KEPT)];
    let end = &text[text.ceil_char_boundary(text.len() - KEPT)..];
    Cow::Owned(format!("{start} ... {end}"))
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
        assert_eq!(clean_lines("\ta\n\u{7}\n"), "\ta\n\\u{7}\n");
    }

    #[test]
    fn long_messages_lose_their_middle() {
        let short = "\u{e9}".repeat(200);
        assert_eq!(shortened(&short), short);
        let long = format!("start{}end", "\u{e9}".repeat(200));
        let shown = shortened(&long);
        assert!(shown.len() < 340 && shown.starts_with("start") && shown.ends_with("end"));
    }
}
