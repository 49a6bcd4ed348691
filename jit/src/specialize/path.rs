//! Places of scalars within a state: an entry of the stack or a captured value, and the parts of
//! parts from there.

/// A place: where to start, then which part, and so on.
pub(crate) type Path = Vec<u32>;

/// First number of the place of a stack entry or a captured value.
pub(crate) const STACK: u32 = 0;
pub(crate) const CAPTURES: u32 = 1;

/// Whether some place in a sorted set lies within `prefix`.
pub(crate) fn any_within(places: &std::collections::BTreeSet<Path>, prefix: &[u32]) -> bool {
    places.range(prefix.to_vec()..).next().is_some_and(|place| place.starts_with(prefix))
}
