//! Light sources, and the light that reaches a point from them.

use glam::DVec3;

use crate::numeric::dd::Dd;
use crate::numeric::real::Real;
use crate::numeric::vec3::Vec3;

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

/// How point and spot lights grow weaker with distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Attenuation {
    /// `100 / (99 + d²)`: ICFP 2000, equation 12.
    Icfp,
    /// `1 / (a0 + a1 d + a2 d²)`: Chicago 2003, equation 2.
    Polynomial([f64; 3]),
}

impl Attenuation {
    /// The factor at distance `d`; 0 where the denominator is not positive.
    fn factor<R: Real>(self, d: R) -> R {
        let (numerator, [a0, a1, a2]) = match self {
            Attenuation::Icfp => (100.0, [99.0, 0.0, 1.0]),
            Attenuation::Polynomial(coefficients) => (1.0, coefficients),
        };
        let [a0, a1, a2] = [a0, a1, a2].map(R::from_f64);
        let denominator = d.mul_add(d.mul_add(a2, a1), a0);
        if denominator > R::ZERO { R::from_f64(numerator) / denominator } else { R::ZERO }
    }
}

/// A light prepared for shading.
#[derive(Clone, Debug)]
pub(crate) struct Lamp<R> {
    source: Source<R>,
    color: Vec3<R>,
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

/// The light that arrives at a point if nothing is in the way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arriving<R> {
    /// Unit vector toward the light.
    pub(crate) toward: Vec3<R>,
    /// Direction of the shadow ray, of any length.
    pub(crate) shadow_dir: Vec3<R>,
    /// Where the light is on the shadow ray; none for infinity.
    pub(crate) shadow_end: Option<R>,
    /// Linear RGB, attenuated.
    pub(crate) intensity: Vec3<R>,
}

impl<R: Real> Lamp<R> {
    pub(crate) fn new(light: &Light) -> Self {
        match *light {
            Light::Directional { dir, color } => {
                let toward = (-Vec3::from_dvec3(dir)).normalized();
                Lamp {
                    source: toward.map_or(Source::Dark, Source::Directional),
                    color: Vec3::from_dvec3(color),
                }
            }
            Light::Point { position, color } => Lamp {
                source: Source::Positional { position: Vec3::from_dvec3(position), spot: None },
                color: Vec3::from_dvec3(color),
            },
            Light::Spot { position, at, color, cutoff_deg, exponent } => {
                let position: Vec3<R> = Vec3::from_dvec3(position);
                let axis = (Vec3::from_dvec3(at) - position).normalized();
                let spot =
                    axis.map(|axis| Spot { axis, cos_cutoff: cos_cutoff(cutoff_deg), exponent });
                Lamp {
                    source: spot.map_or(Source::Dark, |spot| Source::Positional {
                        position,
                        spot: Some(spot),
                    }),
                    color: Vec3::from_dvec3(color),
                }
            }
        }
    }

    /// The light at `point`, `None` where there is none for sure.
    pub(crate) fn arriving(&self, point: Vec3<R>, attenuation: Attenuation) -> Option<Arriving<R>> {
        let (position, spot) = match &self.source {
            Source::Dark => return None,
            Source::Directional(toward) => {
                return Some(Arriving {
                    toward: *toward,
                    shadow_dir: *toward,
                    shadow_end: None,
                    intensity: self.color,
                });
            }
            Source::Positional { position, spot } => (*position, spot),
        };
        let shadow_dir = position - point;
        let toward = shadow_dir.normalized()?;
        let mut intensity = self.color * attenuation.factor(shadow_dir.dot(toward));
        if let Some(spot) = spot {
            let cos = -spot.axis.dot(toward);
            // Reference 4.6: a point exactly on the edge of the cone is lit.
            if cos < spot.cos_cutoff {
                return None;
            }
            intensity = intensity * R::power(cos.max(R::ZERO), spot.exponent);
        }
        let is_dark = [intensity.x, intensity.y, intensity.z].into_iter().all(R::is_surely_zero);
        (!is_dark).then_some(Arriving { toward, shadow_dir, shadow_end: Some(R::ONE), intensity })
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
        assert_eq!(Attenuation::Icfp.factor(10.0), 100.0 / 199.0);
        assert_eq!(Attenuation::Polynomial([1.0, 0.5, 0.25]).factor(2.0), 1.0 / 3.0);
        assert_eq!(Attenuation::Polynomial([0.0, 0.0, 0.0]).factor(2.0), 0.0);
        assert_eq!(Attenuation::Polynomial([1.0, -1.0, 0.0]).factor(2.0), 0.0);
    }

    #[test]
    fn lights_without_a_direction_are_dark() {
        let nowhere = Light::Directional { dir: DVec3::ZERO, color: WHITE };
        assert!(Lamp::<f64>::new(&nowhere).arriving(Vec3::ZERO, Attenuation::Icfp).is_none());
        let position = DVec3::new(1.0, 2.0, 3.0);
        let here = Light::Point { position, color: WHITE };
        assert!(
            Lamp::<f64>::new(&here)
                .arriving(Vec3::from_dvec3(position), Attenuation::Icfp)
                .is_none()
        );
        let aimless =
            Light::Spot { position, at: position, color: WHITE, cutoff_deg: 90.0, exponent: 1.0 };
        assert!(Lamp::<f64>::new(&aimless).arriving(Vec3::ZERO, Attenuation::Icfp).is_none());
    }

    #[test]
    fn spots_are_bright_inside_their_cone() {
        let spot = |cutoff_deg| {
            let at = DVec3::new(0.0, -1.0, 0.0);
            Lamp::<f64>::new(&Light::Spot {
                position: DVec3::ZERO,
                at,
                color: WHITE,
                cutoff_deg,
                exponent: 0.0,
            })
        };
        let no_attenuation = Attenuation::Polynomial([1.0, 0.0, 0.0]);
        let lit = |cutoff, x: f64, y: f64| {
            spot(cutoff).arriving(Vec3::new(x, y, 0.0), no_attenuation).is_some()
        };
        assert!(lit(30.0, 0.5, -1.0) && !lit(30.0, 0.6, -1.0));
        assert!(lit(180.0, 0.0, 1.0) && lit(500.0, 0.0, 1.0) && !lit(179.0, 0.0, 1.0));
    }
}
