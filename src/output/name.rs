//! File names as scenes give them: what is allowed at all.

/// The longest name, in bytes.
const MAX_NAME: usize = 4096;

/// The longest component, in bytes; most file systems have the same limit.
const MAX_COMPONENT: usize = 255;

/// The components of a name from a scene; at least one.
///
/// # Errors
/// Says what is wrong, as in "the name *is absolute*".
pub(super) fn components(name: &str) -> Result<impl DoubleEndedIterator<Item = &str>, String> {
    let problem = if name.is_empty() {
        Some("is empty")
    } else if name.starts_with('/') {
        Some("is absolute")
    } else if name.len() > MAX_NAME {
        Some("is longer than 4096 bytes")
    } else {
        name.split('/').find_map(component_problem)
    };
    match problem {
        Some(problem) => Err(problem.to_owned()),
        None => Ok(name.split('/')),
    }
}

fn component_problem(component: &str) -> Option<&'static str> {
    match component {
        "" => Some("has an empty component"),
        "." => Some("has a component `.`"),
        ".." => Some("leaves the output directory"),
        _ if component.chars().any(char::is_control) => Some("holds a control character"),
        // What is a name here is a path elsewhere.
        _ if component.contains('\\') => Some("holds a backslash"),
        // Such files steer shells and tools, and nobody would see them appear.
        _ if component.starts_with('.') => Some("has a hidden component"),
        _ if component.len() > MAX_COMPONENT => Some("has a component of more than 255 bytes"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_lead_elsewhere_are_refused() {
        let refused = |name: &str| components(name).err().unwrap_or_default();
        for good in ["a.ppm", "a/b/c.ppm", "a..b", "a b", "-", "~", "C:a", "\u{e9}"] {
            assert_eq!(refused(good), "", "{good}");
        }
        for (bad, why) in [
            ("", "is empty"),
            ("/a", "is absolute"),
            ("//a", "is absolute"),
            ("..", "leaves the output directory"),
            ("../a", "leaves the output directory"),
            ("a/../../b", "leaves the output directory"),
            ("a/..", "leaves the output directory"),
            (".", "has a component `.`"),
            ("./a", "has a component `.`"),
            (".bashrc", "has a hidden component"),
            ("a/.git/b", "has a hidden component"),
            ("...", "has a hidden component"),
            ("a//b", "has an empty component"),
            ("a/", "has an empty component"),
            ("a\\b", "holds a backslash"),
            ("..\\a", "holds a backslash"),
            ("a\0b", "holds a control character"),
            ("a\u{1b}[2J", "holds a control character"),
            ("a\u{85}", "holds a control character"),
        ] {
            assert_eq!(refused(bad), why, "{bad:?}");
        }
        assert_eq!(refused(&"a".repeat(255)), "");
        assert_eq!(refused(&"a".repeat(256)), "has a component of more than 255 bytes");
        assert_eq!(refused(&"a/".repeat(3000)), "is longer than 4096 bytes");
    }
}
