use fearless_simd::prelude::*;
use fearless_simd::{Simd, mask32x16};

/// Returns the lanes of a mask as bits, lane 0 in the lowest.
#[inline(always)]
#[allow(clippy::cast_possible_truncation, reason = "sixteen lanes, sixteen bits")]
pub(crate) fn bits<S: Simd>(mask: mask32x16<S>) -> u32 {
    mask.to_bitmask() as u32
}

/// Returns the bits of the first `count` lanes.
pub(crate) fn first_lanes(count: usize) -> u32 {
    (1 << count) - 1
}

/// Returns the indices of the lanes whose bits are set, in order.
pub(crate) fn lanes_of(mut bits: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        (bits != 0).then(|| {
            let lane = bits.trailing_zeros() as usize;
            bits &= bits - 1;
            lane
        })
    })
}
