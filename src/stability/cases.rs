//! The cases: scenes, and what must hold of their images.

use super::image::{BLACK, Place, Rgb};
use super::oracle::Oracle::{self, Outline, Pairs, Pixels, Same, Symmetric, Turned, Unshadowed};

/// A scene that breaks ray tracers.
pub(crate) struct Case {
    /// The scene's file, without extension.
    pub(crate) name: &'static str,
    /// The scene.
    pub(super) text: &'static str,
    pub(super) oracle: Oracle,
    /// A larger error is a failure.
    pub(crate) bound: u64,
}

impl Case {
    /// What fails in it, in a line: the first of the scene.
    pub(crate) fn failure(&self) -> &'static str {
        self.text.lines().next().unwrap_or_default().trim_start_matches("% ")
    }
}

/// What all scenes include.
pub(super) const COMMON: &str = include_str!("../../tests/stability/common.gml");

macro_rules! cases {
    ($($name:literal: $oracle:expr;)*) => {
        &[$(Case {
            name: $name,
            text: include_str!(concat!("../../tests/stability/", $name, ".gml")),
            oracle: $oracle,
            bound: 0,
        }),*]
    };
}

const WHITE: Rgb = [255; 3];
const ORANGE: Rgb = [229, 153, 76];
const BLUE: Rgb = [51, 127, 229];
const GREEN: Rgb = [76, 204, 102];
const YELLOW: Rgb = [255, 255, 0];

/// All cases, in the order of the table.
pub(crate) const CASES: &[Case] = cases! {
    "far-spheres": Outline(far_sphere);
    "scales": Same;
    "planet": Same;
    "pancakes": Same;
    "needle": Same;
    "horizons": Pixels(|_, at| if at.up < 0 { [127; 3] } else { BLACK });
    "low-sun": Pixels(|_, at| if at.up < 0 { [63; 3] } else { BLACK });
    "gap": Pixels(|_, at| if at.up == 0 { BLACK } else { [127; 3] });
    "bore": Pixels(bore);
    "cone-apex": Pixels(cone_apex);
    "cone-tip": Outline(|_, at| at.up > at.across.abs());
    "eye-at-apex": Pixels(|_, at| if at.off() < 48 * 48 { ORANGE } else { BLUE });
    "generators": Same;
    "seams": Pixels(|_, at| if at.across >= 0 { ORANGE } else { BLUE });
    "poles": Pixels(|_, at| sector(at));
    "inlay": Pixels(|index, at| if index == 0 && 9 * at.off() < 48 * 48 { BLUE } else { ORANGE });
    "nothing-left": Pixels(|_, _| BLACK);
    "nothing-left-turned": Pixels(|_, _| BLACK);
    "limb": Outline(|index, at| index < 2 && at.across > 0);
    "with-itself": Same;
    "flush-drill": Same;
    "touching-difference": Same;
    "touching-intersection": Pixels(|_, _| BLACK);
    "octants": Same;
    "parallel-faces": Same;
    "edges": Pixels(|_, at| if at.across.abs().max(at.up.abs()) < 15 { ORANGE } else { BLACK });
    "edge-to-edge": Pixels(|_, at| if at.across == 0 { BLUE } else { ORANGE });
    "thin-shell": Same;
    "nested-shells": Pixels(nested_shells);
    "thousand-mirrors": Pixels(|_, _| [220; 3]);
    "mirror-symmetry": Symmetric;
    "quarter-turns": Turned;
    "tiles": Pixels(|_, at| if (at.across + at.up).rem_euclid(4) == 0 { ORANGE } else { BLUE });
    "light-lengths": Same;
    "lamps-on-surfaces": Pixels(|_, at| if at.up < 0 { [63; 3] } else { BLACK });
    "spot-edges": Outline(|index, at| if index == 0 { 3 * at.off() <= 49 * 49 } else { at.up >= 0 });
    "eye-on-a-face": Pixels(|index, _| if index == 0 { ORANGE } else { BLUE });
    "rooms": Unshadowed;
    "convex-solids": Unshadowed;
    "cancelling-transforms": Same;
    "grays": Pixels(|_, at| [[25, 51, 76, 102, 127, 153, 178, 204, 229][(at.across + 44) as usize / 10]; 3]);
    "stacked-planes": Pixels(|_, at| if at.up < 0 { BLUE } else { BLACK });
    "identities": Pairs;
    "drilled-plate": Same;
};

/// The outline of a unit sphere: the sine of its angular radius is 1 / distance.
fn far_sphere(index: usize, at: Place) -> bool {
    let distance = [1e4, 1e6, 1e8][index];
    let half_pixel = (148.96902673401403 / distance / 2.0_f64).to_radians().tan() / 48.0;
    at.off() as f64 * half_pixel * half_pixel * (distance * distance - 1.0) <= 1.0
}

/// The tube's end is at distance 1, where half the picture is 1 wide.
fn bore(_: usize, at: Place) -> Rgb {
    let off = at.off();
    match off {
        0 => GREEN,
        _ if 4 * off < 49 * 49 => BLUE,
        _ if off < 49 * 49 => ORANGE,
        _ => GREEN,
    }
}

/// 45 degrees steep: 0.25 of ambient light and 0.5 times the cosine of 45 degrees.
fn cone_apex(_: usize, at: Place) -> Rgb {
    let off = at.off();
    match off {
        0 => [63; 3],
        _ if 4 * off < 49 * 49 => [153; 3],
        _ => BLACK,
    }
}

/// A quarter of the directions belongs to its first meridian, and the pole to the first quarter.
fn sector(at: Place) -> Rgb {
    match at {
        Place { across: 0, up: 0 } => ORANGE,
        Place { across: 0.., up: ..0 } => ORANGE,
        Place { across: 1.., up: 0.. } => BLUE,
        Place { across: ..=0, up: 1.. } => GREEN,
        Place { across: ..0, up: ..=0 } => WHITE,
    }
}

/// Ball n of 40 has the radius n / 40, and those with even numbers are solid; the cut is at
/// distance 2, so that `r = off.sqrt() / 24` in the plane of the cut.
fn nested_shells(_: usize, at: Place) -> Rgb {
    let inner = (0..40).take_while(|n| 25 * at.off() >= 9 * n * n).count();
    match inner {
        _ if at.off() >= 24 * 24 => BLACK,
        ball if ball % 2 == 0 => YELLOW,
        _ => BLUE,
    }
}
