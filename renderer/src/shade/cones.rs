//! Solids that lie outside the cones of spotlights: there the lamp need not be asked at any point.

use glam::DVec3;

use crate::bounds::Bounds;
use crate::light::{Light, cos_cutoff};
use crate::numeric::real::Real;
use crate::plan::Part;
use crate::scene::Scene;

/// Pairs of shapes and lamps at most: with more of them, finding out takes a thread milliseconds.
const MAX_PAIRS: usize = 1 << 16;

/// What cosines must differ by, at least, for a solid to be outside a cone. Those of the tracer, and the
/// one that they are held against here, are off by less than 32 roundings of 2^-53.
const MARGIN: f64 = 1.0 / (1u64 << 40) as f64;

/// The boxes' ends are padded with more than their own roundings; half their diagonal has a few.
const WIDER: f64 = 1.0 + 16.0 * f64::EPSILON;

/// For each shape, the lamps that do not reach it, by bit. Empty where there are none.
#[derive(Debug)]
pub(super) struct Cones(Vec<u64>);

impl Cones {
    pub(super) fn new<R: Real>(scene: &Scene<R>, lights: &[Light]) -> Self {
        let n_pairs = scene.leaves.len().saturating_mul(lights.len());
        let has_cones = lights.iter().any(|light| matches!(light, Light::Spot { .. }));
        let may_pay = has_cones && lights.len() <= 64 && n_pairs <= MAX_PAIRS;
        if !may_pay || !scene.omissions.holds(Part::Cones) {
            return Cones(Vec::new());
        }
        let unlit_by = |leaf| {
            let bounds = scene.bounds_of(leaf);
            let bits = lights
                .iter()
                .enumerate()
                .map(|(bit, light)| u64::from(misses(light, &bounds)) << bit);
            bits.fold(0, |bits, bit| bits | bit)
        };
        Cones((0..scene.leaves.len() as u32).map(unlit_by).collect())
    }

    /// The lamps, by bit, that do not reach a shape.
    #[inline(always)]
    pub(super) fn unlit_by(&self, leaf: u32) -> u64 {
        self.0.get(leaf as usize).copied().unwrap_or(0)
    }
}

/// Whether the ball around a box surely lies outside of a lamp's cone.
fn misses(light: &Light, bounds: &Bounds) -> bool {
    let Light::Spot { position, at, cutoff_deg, .. } = *light else { return false };
    let centre = 0.5 * (bounds.lo + bounds.hi);
    let radius = 0.5 * (bounds.hi - bounds.lo).length() * WIDER;
    let to_centre = centre - position;
    let distance = to_centre.length();
    let Some(axis) = (at - position).try_normalize() else { return false };
    if !(distance > radius && DVec3::splat(distance).is_finite()) {
        return false;
    }
    // Seen from the lamp, the centre is at the angle a from the axis, and the ball takes b around it.
    let (cos_a, sin_b) = (axis.dot(to_centre) / distance, radius / distance);
    let [sin_a, cos_b] = [cos_a, sin_b].map(|x| (1.0 - x * x).max(0.0).sqrt());
    // If a is above b, what is nearest to the axis is at a - b. The sines are off by more than roundings
    // where they are small, but then they are multiplied with what is smaller.
    cos_a < cos_b && cos_a * cos_b + sin_a * sin_b + MARGIN < cos_cutoff::<f64>(cutoff_deg)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spot(cutoff_deg: f64) -> Light {
        let (position, at) = (DVec3::new(0.0, 4.0, 0.0), DVec3::ZERO);
        Light::Spot { position, at, color: DVec3::ONE, cutoff_deg, exponent: 1.0 }
    }

    /// The cube of side 2 around a point has a ball of radius 3^(1/2) around it.
    fn cube(x: f64, y: f64) -> Bounds {
        let centre = DVec3::new(x, y, 0.0);
        Bounds { lo: centre - 1.0, hi: centre + 1.0 }
    }

    #[test]
    fn balls_outside_of_cones_are_missed() {
        // At 45 degrees, 32^(1/2) away, the ball takes 17.83 degrees.
        let side = cube(4.0, 0.0);
        assert!(misses(&spot(27.1), &side));
        assert!(!misses(&spot(27.2), &side));
        // Behind the lamp, at 180 degrees, it takes 25.66.
        let behind = cube(0.0, 8.0);
        assert!(misses(&spot(154.3), &behind));
        assert!(!misses(&spot(154.4), &behind));
        assert!(!misses(&spot(1.0), &cube(0.0, 0.0)), "it is on the axis");
        assert!(!misses(&spot(0.0), &cube(0.0, 3.5)), "the lamp is inside");
        assert!(!misses(&spot(200.0), &side) && !misses(&spot(f64::NAN), &side));
        assert!(!misses(&spot(1.0), &Bounds::ALL));
    }
}
