//! "Did you mean": the bound name nearest to one that is not.

use crate::ast::{Body, TermKind};
use crate::source::Span;

/// Longer names are like none: comparing two takes time with the product of their lengths.
const MAX_LETTERS: usize = 64;

/// The binder whose name is most like `name`, if any is like it: at most a third of the letters
/// changed, added, dropped, or swapped with their neighbour.
#[must_use]
pub fn similar_binder<'t>(tree: &'t Body, name: &str) -> Option<(&'t str, Span)> {
    let allowed = (name.chars().count() / 3).max(1);
    let mut nearest: Option<(usize, &str, Span)> = None;
    let mut bodies = vec![tree];
    while let Some(body) = bodies.pop() {
        for term in body {
            match &term.kind {
                TermKind::Function(inner) | TermKind::Array(inner) => bodies.push(inner),
                TermKind::Binder(candidate) => {
                    let distance = distance(name, candidate, allowed);
                    if distance <= allowed && nearest.is_none_or(|(best, ..)| distance < best) {
                        nearest = Some((distance, &**candidate, term.span));
                    }
                }
                _ => {}
            }
        }
    }
    nearest.map(|(_, name, span)| (name, span))
}

/// Edit distance with swaps of neighbours; anything above `limit` may come out as `limit + 1`.
fn distance(a: &str, b: &str, limit: usize) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    if a == b {
        return 0;
    }
    if a.len().abs_diff(b.len()) > limit || a.len().max(b.len()) > MAX_LETTERS {
        return limit + 1;
    }
    let mut before = vec![0; b.len() + 1];
    let mut last: Vec<usize> = (0..=b.len()).collect();
    for i in 1..=a.len() {
        let mut row = vec![i; b.len() + 1];
        for j in 1..=b.len() {
            let changed = last[j - 1] + usize::from(a[i - 1] != b[j - 1]);
            row[j] = changed.min(last[j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                row[j] = row[j].min(before[j - 2] + 1);
            }
        }
        before = std::mem::replace(&mut last, row);
    }
    last[b.len()]
}

#[cfg(test)]
mod tests {
    use super::{MAX_LETTERS, distance};

    #[test]
    fn a_swap_counts_once() {
        assert_eq!(distance("raduis", "radius", 2), 1);
        assert_eq!(distance("sphere", "spheres", 2), 1);
        assert_eq!(distance("x", "radius", 1), 2);
    }

    #[test]
    fn long_names_are_like_none() {
        let (a, b) = ("a".repeat(MAX_LETTERS), "a".repeat(MAX_LETTERS + 1));
        assert_eq!(distance(&a[1..], &a, 1), 1);
        assert_eq!(distance(&a, &b, 1), 2);
        assert_eq!(distance(&b, &b, 1), 0);
    }
}
