use std::cmp::Ordering;

use cranny_spatial::{LaneVector, Vector};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

use crate::lane::lane_bits::bits;

/// Whether a length, given by its square, is less than a bound, or not a number.
pub(crate) fn is_shorter(squared: f32, bound: f32) -> bool {
    let bound = bound.max(0.0);
    !matches!(squared.partial_cmp(&(bound * bound)), Some(Ordering::Greater | Ordering::Equal))
}

/// Bits of the lanes in which a length, given by its square, is less than a bound, or not a number.
#[inline(always)]
pub(crate) fn shorter<S: Simd>(squared: f32x16<S>, bound: f32x16<S>) -> u32 {
    let bound = bound.max(f32x16::splat(bound.token(), 0.0));
    bits(!squared.simd_ge(bound * bound))
}

/// The rounding of a distance in lanes, relative to how far from the root and how large both things are: 32 times
/// the unit roundoff of `f32`, 2⁻²⁴.
///
/// Between two places and their distance stand, each off by one unit of something no larger than that: the
/// constants of place and turn (2) and of sizes (2); the difference of the places (1); three products with a row of
/// the turn and their two sums, in each of three coordinates (√3 · 5); half extents taken off (1); three squares,
/// their sums and the square root that a comparison of squares stands for (3); the bound it is compared with, its sum
/// and its square (4): 22. Corners of hulls are turned there and back (√3 · 5).
pub(crate) const RELATIVE_ROUNDING: f64 = 32.0 * 0.5 * f32::EPSILON as f64;

/// A vector as the lanes hold it.
pub(crate) fn lanes(vector: &Vector) -> [f32; 3] {
    std::array::from_fn(|axis| narrow(vector[axis]))
}

/// The product of two vectors of one lane.
#[inline(always)]
pub(crate) fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The way from the second point of one lane to the first.
#[inline(always)]
pub(crate) fn minus(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// A number as the lanes hold it.
#[allow(clippy::cast_possible_truncation, reason = "single precision is what is meant")]
pub(crate) fn narrow(x: f64) -> f32 {
    x as f32
}

/// The same to compute with.
#[derive(Clone, Copy)]
pub(crate) struct BoxLanes<S: Simd> {
    pub middle: LaneVector<S>,
    pub half_extents: LaneVector<S>,
}

impl<S: Simd> BoxLanes<S> {
    /// Bits of the lanes in which two boxes are not certainly `reach` (m) or farther apart along an axis.
    #[inline(always)]
    pub fn within_reach(self, other: Self, reach: f32x16<S>) -> u32 {
        let offset = self.middle.minus(other.middle).abs();
        let gap = offset.minus(self.half_extents).minus(other.half_extents);
        bits(!gap.x.max(gap.y).max(gap.z).simd_ge(reach))
    }
}
