//! Which of some points nothing beats.

/// Cost and error of a method, of which less is better.
pub(crate) type Point = (f64, f64);

/// Whether one point is no worse than another in either respect, and better in one.
fn dominates((cost, error): Point, (other_cost, other_error): Point) -> bool {
    cost <= other_cost && error <= other_error && (cost < other_cost || error < other_error)
}

/// For each point, the cheapest of those that dominate it; none if it is on the Pareto front.
pub(crate) fn dominators(points: &[Point]) -> Vec<Option<usize>> {
    let dominator = |point: &Point| {
        (0..points.len())
            .filter(|&other| dominates(points[other], *point))
            .min_by(|&a, &b| points[a].0.total_cmp(&points[b].0))
    };
    points.iter().map(dominator).collect()
}

/// The points that nothing dominates, cheapest first.
pub(crate) fn front(points: &[Point]) -> Vec<usize> {
    let dominators = dominators(points);
    let mut front: Vec<_> =
        (0..points.len()).filter(|&index| dominators[index].is_none()).collect();
    front.sort_by(|&a, &b| points[a].0.total_cmp(&points[b].0));
    front
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_is_what_nothing_beats() {
        let points =
            [(4.0, 0.0), (1.0, 0.5), (2.0, 0.5), (2.0, 0.1), (9.0, 0.0), (1.5, 0.9), (1.0, 0.7)];
        assert_eq!(front(&points), [1, 3, 0]);
        let expected = [None, None, Some(1), None, Some(0), Some(1), Some(1)];
        assert_eq!(dominators(&points), expected);
        // Of equals, both are on it.
        assert_eq!(front(&[(1.0, 1.0), (1.0, 1.0)]), [0, 1]);
        assert!(front(&[]).is_empty());
    }

    #[test]
    fn a_front_falls_and_everything_else_is_dominated_by_it() {
        let point = |n: u32| (f64::from(n * 37 % 101), f64::from(n * 53 % 97));
        let points: Vec<_> = (0..90).map(point).collect();
        let front = front(&points);
        for pair in front.windows(2) {
            let ((cost, error), (next_cost, next_error)) = (points[pair[0]], points[pair[1]]);
            assert!(cost < next_cost && error > next_error);
        }
        for (index, dominator) in dominators(&points).into_iter().enumerate() {
            assert_eq!(dominator.is_none(), front.contains(&index));
            let best = front.iter().any(|&on| dominates(points[on], points[index]));
            assert_eq!(dominator.is_some(), best);
        }
    }
}
