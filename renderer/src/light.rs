//! Light sources, and the light that reaches a point from them.

use glam::DVec3;

use crate::numeric::dd::Dd;
use crate::numeric::real::Real;
use crate::numeric::vec3::Vec3;
use crate::obstacles::Whence;
use crate::plan::{Omissions, Part};

/// A light source, in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// Infinitely far away, never attenuated.
    Directional {
        /// The direction that the light travels in; of any length.
        dir: DVec3,
        /// Intensity, linear RGB.
        color: DVec3,
    },
    /// Shines in all directions.
    Point {
        /// Where it is.
        position: DVec3,
        /// Intensity, linear RGB.
        color: DVec3,
    },
    /// Shines in a cone.
    Spot {
        /// Where it is.
        position: DVec3,
        /// The point that it is aimed at.
        at: DVec3,
        /// Intensity on the axis, linear RGB.
        color: DVec3,
        /// Half the opening angle of the cone, in degrees.
        cutoff_deg: f64,
        /// How fast the intensity falls off from the axis.
        exponent: f64,
    },
}

impl Light {
    /// What its intensity does not exceed without attenuation, in size; infinite if there is no such
    /// bound.
    pub(crate) fn greatest(&self) -> DVec3 {
        match *self {
            Light::Directional { color, .. } | Light::Point { color, .. } => color,
            Light::Spot { color, exponent, .. } if exponent >= 0.0 => color,
            Light::Spot { .. } => DVec3::INFINITY,
        }
    }
}

/// How point and spot lights grow weaker with distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Attenuation {
    /// `100 / (99 + d²)`: ICFP 2000, equation 12.
    Icfp,
    /// `1 / (a0 + a1 d + a2 d²)`: Chicago 2003, equation 2.
    Polynomial([f64; 3]),
}

impl Attenuation {
    /// Numerator, and coefficients of the denominator.
    fn law(self) -> (f64, [f64; 3]) {
        match self {
            Attenuation::Icfp => (100.0, [99.0, 0.0, 1.0]),
            Attenuation::Polynomial(coefficients) => (1.0, coefficients),
        }
    }

    /// The same in the tracer's numbers.
    fn fading<R: Real>(self) -> Fading<R> {
        let (numerator, coefficients) = self.law();
        Fading { numerator: R::from_f64(numerator), coefficients: coefficients.map(R::from_f64) }
    }

    /// What neither the factor nor 1 exceeds; infinite if there is no such bound.
    pub(crate) fn greatest(self) -> f64 {
        let (numerator, [a0, a1, a2]) = self.law();
        let falls = a0 > 0.0 && a1 >= 0.0 && a2 >= 0.0;
        if falls { f64::max(1.0, numerator / a0) } else { f64::INFINITY }
    }

    /// Whether the factor is the same at all finite distances.
    pub(crate) fn is_constant(self) -> bool {
        let (_, [_, a1, a2]) = self.law();
        a1 == 0.0 && a2 == 0.0
    }
}

/// How a light grows weaker: numerator, and coefficients of the denominator.
#[derive(Clone, Debug)]
struct Fading<R> {
    numerator: R,
    coefficients: [R; 3],
}

impl<R: Real> Fading<R> {
    /// The factor at distance `d`; 0 where the denominator is not positive.
    #[inline(always)]
    fn at(&self, d: R) -> R {
        let [a0, a1, a2] = self.coefficients;
        let denominator = d.mul_add(d.mul_add(a2, a1), a0);
        if denominator > R::ZERO { self.numerator / denominator } else { R::ZERO }
    }
}

/// A light prepared for shading.
#[derive(Clone, Debug)]
pub(crate) struct Lamp<R> {
    source: Source<R>,
    color: Vec3<R>,
    fading: Fading<R>,
    /// The colour with the attenuation of all finite distances, if that is the same.
    faded: Option<Vec3<R>>,
}

#[derive(Clone, Debug)]
enum Source<R> {
    /// Unit vector toward the light.
    Directional(Vec3<R>),
    Positional {
        position: Vec3<R>,
        spot: Option<Spot<R>>,
    },
    /// Its direction is no direction: contributes nothing.
    Dark,
}

#[derive(Clone, Debug)]
struct Spot<R> {
    axis: Vec3<R>,
    /// Below this cosine a point is outside the cone.
    cos_cutoff: R,
    exponent: f64,
}

/// The way from a point to a light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Way<R> {
    /// Unit vector toward the light.
    pub(crate) toward: Vec3<R>,
    /// Direction of the shadow ray, of any length.
    pub(crate) shadow_dir: Vec3<R>,
    /// Where the light is on the shadow ray; none for infinity.
    pub(crate) shadow_end: Option<R>,
    /// Cosine of the angle between a spotlight's axis and the way; 1 for other lights.
    cos_axis: R,
}

impl<R: Real> Lamp<R> {
    pub(crate) fn new(light: &Light, attenuation: Attenuation, omissions: Omissions) -> Self {
        let (source, color) = match *light {
            Light::Directional { dir, color } => {
                let toward = (-Vec3::from_dvec3(dir)).normalized();
                (toward.map_or(Source::Dark, Source::Directional), color)
            }
            Light::Point { position, color } => {
                let position = Vec3::from_dvec3(position);
                (Source::Positional { position, spot: None }, color)
            }
            Light::Spot { position, at, color, cutoff_deg, exponent } => {
                let position: Vec3<R> = Vec3::from_dvec3(position);
                let axis = (Vec3::from_dvec3(at) - position).normalized();
                let spot = |axis| {
                    let spot = Spot { axis, cos_cutoff: cos_cutoff(cutoff_deg), exponent };
                    Source::Positional { position, spot: Some(spot) }
                };
                (axis.map_or(Source::Dark, spot), color)
            }
        };
        let color: Vec3<R> = Vec3::from_dvec3(color);
        let is_constant = omissions.holds(Part::Fading) && attenuation.is_constant();
        let fading = attenuation.fading();
        let faded = is_constant.then(|| color * fading.at(R::ONE));
        Lamp { source, color, fading, faded }
    }

    /// Where its light comes from; none if it has none.
    pub(crate) fn whence(&self) -> Option<Whence<R>> {
        match &self.source {
            Source::Directional(toward) => Some(Whence::Toward(*toward)),
            Source::Positional { position, .. } => Some(Whence::At(*position)),
            Source::Dark => None,
        }
    }

    /// The way from a point to the light, `None` where there is no light for sure.
    #[inline(always)]
    pub(crate) fn way(&self, point: Vec3<R>) -> Option<Way<R>> {
        let (position, spot) = match &self.source {
            Source::Dark => return None,
            Source::Directional(toward) => {
                let (toward, shadow_dir) = (*toward, *toward);
                return Some(Way { toward, shadow_dir, shadow_end: None, cos_axis: R::ONE });
            }
            Source::Positional { position, spot } => (*position, spot),
        };
        let shadow_dir = position - point;
        let toward = shadow_dir.normalized()?;
        let mut cos_axis = R::ONE;
        if let Some(spot) = spot {
            cos_axis = -spot.axis.dot(toward);
            // Reference 4.6: a point exactly on the edge of the cone is lit.
            if cos_axis < spot.cos_cutoff {
                return None;
            }
        }
        Some(Way { toward, shadow_dir, shadow_end: Some(R::ONE), cos_axis })
    }

    /// The light that arrives on this way if nothing is in it, linear RGB; `None` if there is none
    /// for sure.
    #[inline(always)]
    pub(crate) fn intensity(&self, way: &Way<R>) -> Option<Vec3<R>> {
        let Source::Positional { spot, .. } = &self.source else { return Some(self.color) };
        let distance = way.shadow_dir.dot(way.toward);
        // Only where the distance is beyond all doubles, fading that is constant is not.
        let mut intensity = match self.faded {
            Some(faded) if distance.to_f64().is_finite() => faded,
            _ => self.color * self.fading.at(distance),
        };
        if let Some(spot) = spot {
            intensity = intensity * R::power(way.cos_axis.max(R::ZERO), spot.exponent);
        }
        let is_dark = [intensity.x, intensity.y, intensity.z].into_iter().all(R::is_surely_zero);
        (!is_dark).then_some(intensity)
    }
}

fn cos_cutoff<R: Real>(cutoff_deg: f64) -> R {
    // From 180 degrees on the cone is all space, and rounding must not cut a hole into it.
    if cutoff_deg >= 180.0 {
        R::from_f64(-2.0)
    } else {
        R::from_dd(Dd::sin_cos_degrees(cutoff_deg).1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHITE: DVec3 = DVec3::ONE;

    #[test]
    fn attenuation_follows_the_equations() {
        assert_eq!(Attenuation::Icfp.fading().at(10.0), 100.0 / 199.0);
        assert_eq!(Attenuation::Polynomial([1.0, 0.5, 0.25]).fading().at(2.0), 1.0 / 3.0);
        assert_eq!(Attenuation::Polynomial([0.0, 0.0, 0.0]).fading().at(2.0), 0.0);
        assert_eq!(Attenuation::Polynomial([1.0, -1.0, 0.0]).fading().at(2.0), 0.0);
    }

    #[test]
    fn lights_without_a_direction_are_dark() {
        let lamp = |light| Lamp::<f64>::new(&light, Attenuation::Icfp, Omissions::ALL);
        let nowhere = Light::Directional { dir: DVec3::ZERO, color: WHITE };
        assert!(lamp(nowhere).way(Vec3::ZERO).is_none());
        let position = DVec3::new(1.0, 2.0, 3.0);
        let here = Light::Point { position, color: WHITE };
        assert!(lamp(here).way(Vec3::from_dvec3(position)).is_none());
        let aimless =
            Light::Spot { position, at: position, color: WHITE, cutoff_deg: 90.0, exponent: 1.0 };
        assert!(lamp(aimless).way(Vec3::ZERO).is_none());
    }

    #[test]
    fn spots_are_bright_inside_their_cone() {
        let no_attenuation = Attenuation::Polynomial([1.0, 0.0, 0.0]);
        let lit = |cutoff_deg, x: f64, y: f64| {
            let (position, at) = (DVec3::ZERO, DVec3::new(0.0, -1.0, 0.0));
            let spot = Light::Spot { position, at, color: WHITE, cutoff_deg, exponent: 0.0 };
            let lamp = Lamp::<f64>::new(&spot, no_attenuation, Omissions::ALL);
            let way = lamp.way(Vec3::new(x, y, 0.0));
            way.is_some_and(|way| lamp.intensity(&way) == Some(Vec3::from_dvec3(WHITE)))
        };
        assert!(lit(30.0, 0.5, -1.0) && !lit(30.0, 0.6, -1.0));
        assert!(lit(180.0, 0.0, 1.0) && lit(500.0, 0.0, 1.0) && !lit(179.0, 0.0, 1.0));
    }
}
