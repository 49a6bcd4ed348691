//! What `bench` and `chart` measure with: clocks, whose turn it is, what times say, and files of results.

pub(crate) mod json;
pub(crate) mod machine;
pub(crate) mod rounds;
pub(crate) mod statistics;

/// A time in the unit that suits it.
pub(crate) fn time(seconds: f64) -> String {
    let (factor, unit) = match seconds {
        s if s >= 1.0 => (1.0, "s"),
        s if s >= 1e-3 => (1e3, "ms"),
        s if s >= 1e-6 => (1e6, "µs"),
        _ => (1e9, "ns"),
    };
    format!("{:.2} {unit}", seconds * factor)
}
