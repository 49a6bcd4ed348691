//! The light of lamps at a point.

use super::{Hit, Sample, Shader};
use crate::light::Way;
use crate::numeric::real::Real;
use crate::numeric::vec3::Vec3;
use crate::plan::Part;
use crate::ray::{Ray, TIE_ROUNDINGS};
use crate::surface::SurfaceEval;

impl<R: Real, E: SurfaceEval> Shader<'_, R, E> {
    /// The light of ambient light and lamps: diffuse, still without the surface's colour, and
    /// specular.
    #[inline(always)]
    pub(super) fn direct_light<const SIGNED: bool>(
        &mut self,
        hit: &Hit<R>,
        dir: Vec3<R>,
        sample: &Sample<R>,
    ) -> (Vec3<R>, Vec3<R>) {
        let &Sample { kd, ks, phong_exp, .. } = sample;
        let mut diffuse = self.ambient * kd;
        let mut specular = Vec3::ZERO;
        let Some(normal) = hit.normal else { return (diffuse, specular) };
        for idx in 0..self.lamps.len() {
            let lamp = &self.lamps[idx];
            let Some(way) = lamp.way(hit.point) else {
                self.sign::<SIGNED>(0);
                continue;
            };
            let cos = normal.dot(way.toward);
            // A light behind the surface does not reach the viewer's side, nor does one in its plane,
            // as far as rounding can tell; NaN reaches nothing.
            if !cos.exceeds(TIE_ROUNDINGS * R::UNIT_ROUNDOFF) {
                self.sign::<SIGNED>(0);
                continue;
            }
            let Some(intensity) = lamp.intensity(&way) else {
                self.sign::<SIGNED>(0);
                continue;
            };
            let is_left_out =
                self.scene.omissions.holds(Part::Shadows) && adds_nothing(sample, intensity);
            if is_left_out || self.is_in_shadow(hit, idx, &way) {
                self.sign::<SIGNED>(0);
                continue;
            }
            // Whether it is left out or not, what adds nothing is signed alike.
            self.sign::<SIGNED>(u64::from(!(SIGNED && adds_nothing(sample, intensity))));
            diffuse = diffuse + intensity * (kd * cos);
            if ks == R::ZERO {
                continue;
            }
            let halfway = (way.toward - dir).normalized();
            let highlight = halfway.map_or(R::ZERO, |h| normal.dot(h));
            if highlight > R::ZERO {
                specular = specular + intensity * (ks * R::power(highlight, phong_exp));
            }
        }
        (diffuse, specular)
    }

    #[inline(always)]
    fn is_in_shadow(&mut self, hit: &Hit<R>, lamp: usize, way: &Way<R>) -> bool {
        self.counts.shadow += 1;
        let ray =
            Ray { origin: hit.point, dir: way.shadow_dir, on: Some(hit.on), medium: hit.medium };
        // Numbers that keep account of doubts must not depend on what was traced before: of two that may
        // be in the way, one may leave a doubt that is not there if the other is tried first.
        if R::KEEPS_ACCOUNT || !self.scene.omissions.holds(Part::Blockers) {
            self.blockers[lamp] = None;
        }
        let blocker = &mut self.blockers[lamp];
        let obstacles = self.obstacles[lamp].for_point_of(hit.point.max_norm().to_f64());
        let (end, workspace) = (way.shadow_end, &mut self.workspace);
        let is_blocked = self.scene.is_blocked(&ray, end, obstacles, blocker, workspace);
        self.counts.blocked += u64::from(is_blocked);
        is_blocked
    }
}

/// Whether light of this intensity leaves the sums as they are: finite numbers times 0 do, but for the
/// sign of a zero, which no pixel has.
#[inline(always)]
fn adds_nothing<R: Real>(sample: &Sample<R>, intensity: Vec3<R>) -> bool {
    sample.kd.is_surely_zero() && sample.ks.is_surely_zero() && intensity.to_dvec3().is_finite()
}
