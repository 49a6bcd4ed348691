//! The page itself: one file, which names nothing from elsewhere, and what it fetches when images are
//! looked at more closely.

const PAGE: &str = include_str!("page/page.html");
const STYLE: &str = include_str!("page/page.css");
const SCRIPT: &str = concat!(
    include_str!("page/editor.js"),
    include_str!("page/code.js"),
    include_str!("page/image.js"),
    include_str!("page/live.js")
);

/// What there is by this name besides the page: its media type and content.
pub(super) fn on_demand(name: &str) -> Option<(&'static str, &'static str)> {
    Some(match name {
        "icon.svg" => ("image/svg+xml", include_str!("page/icon.svg")),
        "chart.js" => ("text/javascript; charset=utf-8", include_str!("page/chart.js")),
        "compare.js" => ("text/javascript; charset=utf-8", include_str!("page/compare.js")),
        "compare.css" => ("text/css; charset=utf-8", include_str!("page/compare.css")),
        _ => return None,
    })
}

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
    use renderer::certify::Certainty;
    use renderer::shade::Doubt;

    use super::*;
    use crate::run::certainty;

    /// The page explains the colours of certainty by itself.
    #[test]
    fn certainties_have_the_colours_of_the_marks() {
        let (_, script) = on_demand("compare.js").expect("a file");
        let doubts = [Doubt::Boundary, Doubt::Light, Doubt::Surface, Doubt::Color];
        let known = [Certainty::Double, Certainty::DoubleDouble];
        for certainty in known.into_iter().chain(doubts.map(Certainty::Rule)) {
            let [red, green, blue] = certainty::color(&certainty);
            assert!(script.contains(&format!("[\"{red} {green} {blue}\", ")), "{certainty:?}");
        }
    }

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
