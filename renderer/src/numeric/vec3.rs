//! Vectors over any [`Real`].

use std::ops::{Add, Mul, Neg, Sub};

use glam::DVec3;

use crate::numeric::real::Real;

/// A point, a vector or a colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vec3<R> {
    /// First component.
    pub x: R,
    /// Second component.
    pub y: R,
    /// Third component.
    pub z: R,
}

impl<R: Real> Vec3<R> {
    /// The origin.
    pub const ZERO: Vec3<R> = Vec3 { x: R::ZERO, y: R::ZERO, z: R::ZERO };

    /// The vector with these components.
    #[inline(always)]
    pub fn new(x: R, y: R, z: R) -> Self {
        Vec3 { x, y, z }
    }

    /// The vector with these components.
    #[inline(always)]
    #[must_use]
    pub fn from_dvec3(v: DVec3) -> Self {
        Vec3::from_f64s(v.to_array())
    }

    /// The vector with these components.
    #[inline(always)]
    #[must_use]
    pub fn from_f64s([x, y, z]: [f64; 3]) -> Self {
        Vec3 { x: R::from_f64(x), y: R::from_f64(y), z: R::from_f64(z) }
    }

    /// The nearest vector of doubles.
    #[inline(always)]
    #[must_use]
    pub fn to_dvec3(self) -> DVec3 {
        DVec3::new(self.x.to_f64(), self.y.to_f64(), self.z.to_f64())
    }

    /// The inner product.
    #[inline(always)]
    pub fn dot(self, other: Self) -> R {
        R::dot(self.into(), other.into())
    }

    /// The inner product and a number, added up.
    #[inline(always)]
    pub fn dot_and(self, other: Self, number: R) -> R {
        R::dot_and(self.into(), other.into(), number)
    }

    /// The cross product, each component to 1.5 units in the last place.
    #[inline(always)]
    #[must_use]
    pub fn cross(self, other: Self) -> Self {
        Vec3 {
            x: R::difference_of_products(self.y, other.z, self.z, other.y),
            y: R::difference_of_products(self.z, other.x, self.x, other.z),
            z: R::difference_of_products(self.x, other.y, self.y, other.x),
        }
    }

    /// Component by component.
    #[inline(always)]
    #[must_use]
    pub fn scaled_by(self, other: Self) -> Self {
        Vec3 { x: self.x * other.x, y: self.y * other.y, z: self.z * other.z }
    }

    /// Component by component, times signs: -1, 0 or 1.
    #[inline(always)]
    #[must_use]
    pub fn with_signs(self, [x, y, z]: [f64; 3]) -> Self {
        Vec3 { x: self.x.with_sign(x), y: self.y.with_sign(y), z: self.z.with_sign(z) }
    }

    /// Applies a function to each component.
    #[inline(always)]
    #[must_use]
    pub fn map<T>(self, f: impl Fn(R) -> T) -> Vec3<T> {
        Vec3 { x: f(self.x), y: f(self.y), z: f(self.z) }
    }

    /// The size of the largest component.
    #[inline(always)]
    pub fn max_norm(self) -> R {
        self.x.abs().max(self.y.abs()).max(self.z.abs())
    }

    /// The vector of length 1 with this direction; none for the zero vector and for vectors that
    /// are not finite.
    #[inline(always)]
    #[must_use]
    pub fn normalized(self) -> Option<Self> {
        // Squares of what lies in this range neither overflow nor lose bits to underflow.
        const SAFE: std::ops::Range<f64> = 1e-140..1e140;
        if SAFE.contains(&self.max_norm().to_f64()) {
            return Some(self.over_its_length());
        }
        self.scaled_and_normalized()
    }

    #[inline(always)]
    fn over_its_length(self) -> Self {
        let [x, y, z] = R::unit(self.into());
        Vec3 { x, y, z }
    }

    #[cold]
    #[inline(never)]
    fn scaled_and_normalized(self) -> Option<Self> {
        let largest = self.max_norm().to_f64();
        let is_number = largest > 0.0 && largest.is_finite();
        if self.is_zero() || !is_number {
            return None;
        }
        // A power of two keeps the direction exact.
        let scale = R::from_f64(libm::scalbn(1.0, -libm::ilogb(largest).max(-1000)));
        Some((self * scale).over_its_length())
    }

    /// Whether all components are 0.
    #[inline]
    pub fn is_zero(self) -> bool {
        self == Vec3::ZERO
    }
}

impl<R> From<Vec3<R>> for [R; 3] {
    #[inline(always)]
    fn from(Vec3 { x, y, z }: Vec3<R>) -> Self {
        [x, y, z]
    }
}

impl<R: Real> Add for Vec3<R> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Vec3 { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }
}

impl<R: Real> Sub for Vec3<R> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Vec3 { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }
}

impl<R: Real> Mul<R> for Vec3<R> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: R) -> Self {
        Vec3 { x: self.x * factor, y: self.y * factor, z: self.z * factor }
    }
}

impl<R: Real> Neg for Vec3<R> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Vec3 { x: -self.x, y: -self.y, z: -self.z }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normalizing_works_at_every_magnitude() {
        for scale in [1.0, 1e200, 1e-200, 1e300, 4e-320, 1e-310] {
            let unit = Vec3::new(3.0 * scale, 0.0, -4.0 * scale).normalized().expect("not zero");
            // Subnormal numbers are multiples of the least, and lose up to half of it to start with.
            let least = f64::from_bits(1);
            let bound = 4.0 * f64::EPSILON + least / scale;
            assert!(
                (unit.x - 0.6).abs() < bound && (unit.z + 0.8).abs() < bound,
                "{scale} {unit:?}"
            );
        }
        assert_eq!(Vec3::<f64>::ZERO.normalized(), None);
        assert_eq!(Vec3::new(f64::INFINITY, 0.0, 0.0).normalized(), None);
        assert_eq!(Vec3::new(f64::NAN, 0.0, 0.0).normalized(), None);
    }
}
