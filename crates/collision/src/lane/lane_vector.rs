use std::cmp::Ordering;

use cranny_spatial::{LaneVector, Vector};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

use crate::lane::lane_bits::bits;

/// Returns true if a length, given by its square, is less than a bound, or is NaN.
pub(crate) fn is_shorter(squared: f32, bound: f32) -> bool {
    let bound = bound.max(0.0);
    !matches!(squared.partial_cmp(&(bound * bound)), Some(Ordering::Greater | Ordering::Equal))
}

/// Returns the bits of the lanes in which a length, given by its square, is less than a bound, or is NaN.
#[inline(always)]
pub(crate) fn shorter<S: Simd>(squared: f32x16<S>, bound: f32x16<S>) -> u32 {
    let bound = bound.max(f32x16::splat(bound.token(), 0.0));
    bits(!squared.simd_ge(bound * bound))
}

/// Rounding of a distance in lanes, relative to the distance from the root and the size of both solids: 32 times the unit
/// roundoff of `f32`, 2⁻²⁴.
///
/// The operations from two positions to their distance are each off by one unit of at most that length: constants of position
/// and rotation (2) and of sizes (2); difference of the positions (1); three products with a row of the rotation and their two
/// sums, in each of three coordinates (√3 · 5); subtraction of half extents (1); three squares, their sums and the square root,
/// which a comparison of squares replaces (3); the compared bound, its sum and its square (4): 22. Corners of hulls are rotated
/// to the frame and back (√3 · 5).
pub(crate) const RELATIVE_ROUNDING: f64 = 32.0 * 0.5 * f32::EPSILON as f64;

/// Converts a vector to single precision.
pub(crate) fn lanes(vector: &Vector) -> [f32; 3] {
    std::array::from_fn(|axis| narrow(vector[axis]))
}

/// Returns the dot product of two vectors of one lane.
#[inline(always)]
pub(crate) fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Returns the vector from `b` to `a` of one lane.
#[inline(always)]
pub(crate) fn minus(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Converts a number to single precision.
#[allow(clippy::cast_possible_truncation, reason = "single precision is what is meant")]
pub(crate) fn narrow(x: f64) -> f32 {
    x as f32
}

/// A box in every lane, in registers.
#[derive(Clone, Copy)]
pub(crate) struct BoxLanes<S: Simd> {
    pub middle: LaneVector<S>,
    pub half_extents: LaneVector<S>,
}

impl<S: Simd> BoxLanes<S> {
    /// Returns the bits of the lanes in which two boxes are not certainly `reach` (m) or farther apart along an axis.
    #[inline(always)]
    pub fn within_reach(self, other: Self, reach: f32x16<S>) -> u32 {
        let offset = self.middle.minus(other.middle).abs();
        let gap = offset.minus(self.half_extents).minus(other.half_extents);
        bits(!gap.x.max(gap.y).max(gap.z).simd_ge(reach))
    }
}
