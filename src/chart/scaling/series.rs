//! The series that there are: a row each in one table.

/// A kind of scene that comes in sizes.
#[derive(Debug)]
pub(crate) struct Series {
    /// How it is called, on the command line too: what there are more and more of.
    pub(crate) name: &'static str,
    /// What its scenes are.
    pub(crate) about: &'static str,
    /// The program that renders the scene of size `n`, a name that is bound before it starts.
    pub(super) program: &'static str,
    /// The sizes, ascending.
    pub(super) sizes: &'static [u64],
    /// The size that the largest is compared with.
    pub(super) from: u64,
    /// Whether making the scene, which then has `n` solids that cost what they cost, is charted too.
    pub(super) is_about_solids: bool,
}

/// No series goes beyond this size.
pub(crate) const MAX_SIZE: u64 = 1_000_000;

/// All series, in the order of tables and panels.
pub(crate) const SERIES: &[Series] = &[
    Series {
        name: "spheres",
        about: "in a cube, of which they fill the same share",
        program: include_str!("spheres.gml"),
        sizes: &[1, 10, 100, 1000, 10_000, 100_000, MAX_SIZE],
        // Fewer leave most rays nothing to meet.
        from: 1000,
        is_about_solids: true,
    },
    Series {
        name: "holes",
        about: "in a plate, of which they take the same share",
        program: include_str!("holes.gml"),
        sizes: &[1, 3, 10, 30, 100, 300, 1000],
        from: 1,
        is_about_solids: false,
    },
    Series {
        name: "reflections",
        about: "of each ray in a room of mirrors",
        program: include_str!("reflections.gml"),
        sizes: &[1, 3, 10, 30, 100, 300, 1000],
        from: 1,
        is_about_solids: false,
    },
    Series {
        name: "lights",
        about: "above three spheres and a floor",
        program: include_str!("lights.gml"),
        sizes: &[1, 2, 4, 8, 16, 32, 64],
        from: 1,
        is_about_solids: false,
    },
];

/// The word for all of them.
pub(crate) const ALL: &str = "all";

impl Series {
    /// The words that ask for series.
    pub(crate) fn words() -> impl Iterator<Item = &'static str> {
        std::iter::once(ALL).chain(SERIES.iter().map(|series| series.name))
    }

    /// Whether this word asks for it.
    pub(super) fn is_meant_by(&self, word: &str) -> bool {
        word == ALL || word == self.name
    }

    /// The series of a name.
    pub(super) fn named(name: &str) -> Option<&'static Series> {
        SERIES.iter().find(|series| series.name == name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_ascend_from_one_and_hold_what_is_compared() {
        for series in SERIES {
            assert!(series.sizes.is_sorted_by(|a, b| a < b), "{}", series.name);
            assert!(series.sizes[0] == 1 && series.sizes.iter().all(|n| *n <= MAX_SIZE));
            assert!(series.sizes.contains(&series.from), "{}", series.name);
        }
    }
}
