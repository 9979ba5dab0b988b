use cranny_spatial::{LANES, LaneArray, LaneVector};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

use crate::Aabb;

/// Sixteen boxes along the axes of one frame, side by side for vector instructions.
#[derive(Clone, Debug)]
pub(crate) struct BoxChunk {
    center: [LaneArray; 3],
    half_extents: [LaneArray; 3],
}

/// A box in single precision: centre and half extents, in metres.
pub(crate) type NarrowBox = [[f32; 3]; 2];

/// Coordinate of the centre of an empty place, in metres: its distance to any point is infinite.
const NOWHERE: f32 = 1e30;

impl BoxChunk {
    /// Creates a chunk of at most [`LANES`] boxes.
    pub fn of(boxes: impl Iterator<Item = NarrowBox>) -> Self {
        let mut chunk = Self { center: [[NOWHERE; LANES]; 3], half_extents: [[0.0; LANES]; 3] };
        for (lane, [center, half_extents]) in boxes.take(LANES).enumerate() {
            for axis in 0..3 {
                chunk.center[axis][lane] = center[axis];
                chunk.half_extents[axis][lane] = half_extents[axis];
            }
        }
        chunk
    }

    /// Returns the bits of the boxes whose squared distance from a point is less than `bound` (m²), or NaN.
    #[inline(always)]
    pub fn within<S: Simd>(&self, simd: S, point: LaneVector<S>, bound: f32x16<S>) -> u32 {
        let zero = f32x16::splat(simd, 0.0);
        let beyond = point
            .minus(LaneVector::load(simd, &self.center))
            .abs()
            .minus(LaneVector::load(simd, &self.half_extents));
        let (x, y, z) = (beyond.x.max(zero), beyond.y.max(zero), beyond.z.max(zero));
        #[allow(clippy::cast_possible_truncation, reason = "sixteen lanes, sixteen bits")]
        let bits = (!(x * x + y * y + z * z).simd_ge(bound)).to_bitmask() as u32;
        bits
    }

    /// Returns the box in a lane.
    pub fn get(&self, lane: usize) -> Aabb {
        let [center, half_extents] = self.narrow(lane).map(|row| row.map(f64::from));
        Aabb { center: center.into(), half_extents: half_extents.into() }
    }

    /// Returns the box in a lane, in single precision.
    pub fn narrow(&self, lane: usize) -> NarrowBox {
        [&self.center, &self.half_extents].map(|rows| rows.each_ref().map(|row| row[lane]))
    }

    /// Returns the smallest box in single precision around the first `count` boxes.
    pub fn around(&self, count: usize) -> NarrowBox {
        let range = |axis: usize| {
            let bounds = |lane: usize| {
                let wide = |rows: &[LaneArray; 3]| f64::from(rows[axis][lane]);
                let (center, half) = (wide(&self.center), wide(&self.half_extents));
                [center - half, center + half]
            };
            let all = (0..count).map(bounds);
            all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], [a, b]| [low.min(a), high.max(b)])
        };
        let axes = [0, 1, 2].map(|axis| {
            let [low, high] = range(axis);
            enclosing(low, high)
        });
        [axes.map(|[center, _]| center), axes.map(|[_, half]| half)]
    }
}

/// Returns centre and half extent, in single precision, of an interval that contains that from `low` to `high`.
#[allow(clippy::cast_possible_truncation, reason = "rounded outwards")]
pub(crate) fn enclosing(low: f64, high: f64) -> [f32; 2] {
    let center = (0.5 * (low + high)) as f32;
    let half = (f64::from(center) - low).max(high - f64::from(center));
    let narrow = half as f32;
    [center, if f64::from(narrow) < half { narrow.next_up() } else { narrow }]
}
