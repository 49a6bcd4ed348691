//! Signatures: what was decided on the way to a colour, in one number.
//!
//! Where two samples of an image have the same signature, they have met the same faces, in the same
//! light, and their surface functions took the same way through the same code; what is between them
//! is likely to be smooth.

/// A hash of decisions in the order in which they were made.
///
/// Whoever evaluates a surface function takes the same decisions into account with the same numbers, so
/// that the hash is the same number for all of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Signature(pub u64);

impl Signature {
    /// That of no decisions: the golden ratio, as any number without a pattern that is not 0.
    pub const NONE: Signature = Signature(0x9e37_79b9_7f4a_7c15);

    /// What the hash is turned by before the next decision comes in.
    pub const TURN: u32 = 5;

    /// What it is multiplied by afterwards: an odd number, so that no two hashes become one (2^64 over pi,
    /// rounded to an odd number).
    pub const FACTOR: u64 = 0x517c_c1b7_2722_0a95;

    /// With one more decision.
    #[inline]
    #[must_use]
    pub fn with(self, decision: u64) -> Signature {
        Signature((self.0.rotate_left(Self::TURN) ^ decision).wrapping_mul(Self::FACTOR))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_and_number_of_decisions_matter() {
        let of = |decisions: &[u64]| decisions.iter().fold(Signature::NONE, |s, d| s.with(*d));
        let some: [&[u64]; 7] = [&[], &[0], &[0, 0], &[1], &[0, 1], &[1, 0], &[1, 1]];
        for (index, one) in some.iter().enumerate() {
            for other in &some[..index] {
                assert_ne!(of(one), of(other), "{one:?} {other:?}");
            }
        }
    }
}
