use cranny_spatial::{LANES, LaneArray, LaneVector};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

use crate::lane::lane_ball::LaneBall;
use crate::lane::lane_bits::first_lanes;
use crate::lane::lane_solid::LaneSolid;
use crate::lane::lane_vector::shorter;
use crate::lane::single_frame::SingleFrame;

/// Balls of a link side by side, one per lane, for the check of a single configuration.
#[derive(Clone, Debug)]
pub(crate) struct BallPack {
    center: [LaneArray; 3],
    radius: LaneArray,
    count: usize,
}

impl BallPack {
    /// Packs all of `balls`, in order; the last ball is repeated to fill the last pack.
    pub fn all(balls: &[LaneBall]) -> Vec<Self> {
        let pack = |balls: &[LaneBall]| {
            let ball = |lane: usize| balls[lane.min(balls.len() - 1)];
            Self {
                center: std::array::from_fn(|axis| std::array::from_fn(|lane| ball(lane).center[axis])),
                radius: std::array::from_fn(|lane| ball(lane).radius),
                count: balls.len(),
            }
        };
        balls.chunks(LANES).map(pack).collect()
    }

    /// Returns true unless all of `packs` are certainly `reach_m` (m) or farther from a solid; `must_be_sure`: with a union, false in
    /// most cases of doubt too.
    pub fn any_closer<S: Simd>(
        simd: S,
        packs: &[Self],
        frame: &SingleFrame,
        solid: &LaneSolid,
        reach_m: f32,
        must_be_sure: bool,
    ) -> bool {
        simd.vectorize(
            #[inline(always)]
            || {
                // Loops, not closures: a closure would lose the instruction set of the enclosing function.
                for pack in packs {
                    let (centers, reaches) = (pack.centers(simd, frame), pack.radii(simd) + reach_m);
                    let lanes = first_lanes(pack.count);
                    let near = if must_be_sure {
                        solid.surely_within_reach(simd, centers, reaches, lanes)
                    } else {
                        solid.within_reach(simd, centers, reaches, lanes)
                    };
                    if near != 0 {
                        return true;
                    }
                }
                false
            },
        )
    }

    /// Returns true unless all balls of `packs` are certainly `reach_m` (m) or farther from those of another link.
    pub fn any_meet<S: Simd>(
        simd: S,
        [packs, others]: [&[Self]; 2],
        [frame, other_frame]: [&SingleFrame; 2],
        reach_m: f32,
    ) -> bool {
        simd.vectorize(
            #[inline(always)]
            || {
                for other in others {
                    let (centers, reaches) = (other.centers(simd, other_frame), other.radii(simd) + reach_m);
                    for pack in packs {
                        let [x, y, z] = &pack.center;
                        for ball in 0..pack.count {
                            let center = frame.point([x[ball], y[ball], z[ball]]);
                            let way = centers.minus(LaneVector::splat(simd, center));
                            if shorter(way.norm_squared(), reaches + pack.radius[ball]) != 0 {
                                return true;
                            }
                        }
                    }
                }
                false
            },
        )
    }

    #[inline(always)]
    fn radii<S: Simd>(&self, simd: S) -> f32x16<S> {
        f32x16::from_slice(simd, &self.radius)
    }

    /// Returns the centres of the balls in the root frame.
    #[inline(always)]
    fn centers<S: Simd>(&self, simd: S, frame: &SingleFrame) -> LaneVector<S> {
        frame.points(LaneVector::load(simd, &self.center))
    }
}
