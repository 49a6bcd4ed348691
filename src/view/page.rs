//! The page itself: one file, which names nothing from elsewhere.

const PAGE: &str = include_str!("page/page.html");
/// What stands for the page in a row of tabs.
pub(super) const ICON: &str = include_str!("page/icon.svg");
const STYLE: &str = include_str!("page/page.css");
const SCRIPT: &str = concat!(
    include_str!("page/editor.js"),
    include_str!("page/code.js"),
    include_str!("page/image.js"),
    include_str!("page/live.js")
);

/// The page, with the number by which a browser knows its style and its script. Indentation and comments,
/// which have lines of their own, are left out.
pub(super) fn with_nonce(nonce: &str) -> String {
    let indented =
        PAGE.replace("{nonce}", nonce).replace("{style}", STYLE).replace("{script}", SCRIPT);
    let lines = indented.lines().map(str::trim_start);
    lines.filter(|line| !line.starts_with("/*")).flat_map(|line| [line, "\n"]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_is_small_and_complete() {
        let page = with_nonce("0123456789abcdef0123456789abcdef");
        assert!(page.len() <= 40_000, "{} bytes", page.len());
        for placeholder in ["{nonce}", "{style}", "{script}"] {
            assert!(!page.contains(placeholder), "{placeholder}");
        }
        for elsewhere in ["http:", "https:", "@import", "url("] {
            assert!(!page.contains(elsewhere), "{elsewhere}");
        }
        assert_eq!((page.matches("<script").count(), page.matches("<style").count()), (1, 1));
    }
}
