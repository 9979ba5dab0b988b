use cranny_robot::LaneFrame;
use cranny_spatial::LaneVector;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

use crate::lane::lane_scratch::{Descent, LaneScratch};
use crate::lane::lane_vector::shorter;
use crate::lane::lanes::{FEW_LANES, Lanes};
use crate::lane::single_frame::{Bars, SingleFrame, Verdict};

impl Lanes {
    /// Returns the lanes in which the boxes around a pair of links are not certainly far enough apart.
    #[inline(always)]
    pub fn link_boxes_near<S: Simd>(&self, simd: S, index: usize, scratch: &LaneScratch) -> u32 {
        let pair = &self.link_pairs[index];
        let [first, second] = [self.link_firsts[index], pair.other].map(|body| &scratch.boxes[body as usize]);
        let reach = f32x16::splat(simd, pair.free_m + scratch.travel.link_pairs[index]);
        first.load(simd).within_reach(second.load(simd), reach)
    }

    /// Checks a pair of links that is in no table ([`Self::check`]), in the lanes in which their boxes are near each other.
    ///
    /// 1. A few lanes are checked one by one.
    /// 2. Otherwise their trees of balls are traversed together, splitting the larger ball, until two leaves are in doubt.
    /// 3. The remaining lanes are checked one by one.
    #[inline(never)]
    pub fn link_against_link<S: Simd>(
        &self,
        simd: S,
        index: usize,
        lanes: u32,
        frames: &[LaneFrame],
        scratch: &mut LaneScratch,
        open: &mut u32,
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                let pair = &self.link_pairs[index];
                let (first, second) = (self.link_firsts[index] as usize, pair.other as usize);
                let (a, b) = (&self.bodies[first], &self.bodies[second]);
                // 1.
                if lanes.count_ones() <= FEW_LANES {
                    let doubt = self.links_one_by_one(simd, index, lanes, frames, scratch, open);
                    scratch.doubts.extend((doubt != 0).then_some((pair.pair, doubt)));
                    return;
                }
                let lanes = self.balls_near(simd, index, [0, 0], frames, scratch) & lanes;
                if lanes == 0 {
                    return;
                }
                // 2.
                let mut doubt = 0;
                scratch.stack.clear();
                scratch.stack.push(Descent { node: 0, begin: 0, end: lanes });
                while let Some(Descent { node: node_a, begin: node_b, end: lanes }) = scratch.stack.pop() {
                    let lanes = lanes & !doubt;
                    if lanes == 0 {
                        continue;
                    }
                    let (outer_a, outer_b) = (&a.outer[node_a as usize], &b.outer[node_b as usize]);
                    let (is_leaf_a, is_leaf_b) = (outer_a.children == [0; 2], outer_b.children == [0; 2]);
                    if is_leaf_a && is_leaf_b {
                        doubt |= lanes;
                        continue;
                    }
                    // Split the larger ball.
                    let halves_a = !is_leaf_a && (is_leaf_b || outer_a.ball.radius >= outer_b.ball.radius);
                    let children = if halves_a { outer_a.children } else { outer_b.children };
                    for child in children {
                        let (next_a, next_b) = if halves_a { (child, node_b) } else { (node_a, child) };
                        let lanes = self.balls_near(simd, index, [next_a, next_b], frames, scratch) & lanes;
                        if lanes != 0 {
                            scratch.stack.push(Descent { node: next_a, begin: next_b, end: lanes });
                        }
                    }
                }
                // 3.
                let doubt = self.links_one_by_one(simd, index, doubt, frames, scratch, open);
                scratch.doubts.extend((doubt != 0).then_some((pair.pair, doubt)));
            },
        );
    }

    /// Checks a pair of links lane by lane, and returns the `lanes` that stay in doubt; removes lanes in contact from `open`.
    #[inline(never)]
    pub fn links_one_by_one<S: Simd>(
        &self,
        simd: S,
        index: usize,
        lanes: u32,
        frames: &[LaneFrame],
        scratch: &LaneScratch,
        open: &mut u32,
    ) -> u32 {
        let pair = &self.link_pairs[index];
        let (a, b) = (&self.bodies[self.link_firsts[index] as usize], &self.bodies[pair.other as usize]);
        let bars = Bars { free_m: pair.free_m + scratch.travel.link_pairs[index], contact_m: pair.contact_m };
        let against = |lane| {
            let [frame_a, frame_b] = [a, b].map(|body| SingleFrame::of(&frames[body.frame], lane));
            a.against_body(simd, &frame_a, b, &frame_b, bars)
        };
        Verdict::one_by_one(lanes, against, open)
    }

    /// Returns the lanes in which two outer balls of a pair of links are not certainly far enough apart.
    #[inline(always)]
    fn balls_near<S: Simd>(
        &self,
        simd: S,
        index: usize,
        nodes: [u32; 2],
        frames: &[LaneFrame],
        scratch: &LaneScratch,
    ) -> u32 {
        let pair = &self.link_pairs[index];
        let (first, second) = (self.link_firsts[index] as usize, pair.other as usize);
        let (a, b) = (&self.bodies[first], &self.bodies[second]);
        let (node_a, node_b) = (nodes[0] as usize, nodes[1] as usize);
        let (ball_a, ball_b) = (&a.outer[node_a].ball, &b.outer[node_b].ball);
        let center_a = frames[a.frame].point(simd, ball_a.center);
        let center_b = frames[b.frame].point(simd, ball_b.center);
        let reach = pair.free_m + scratch.travel.link_pairs[index];
        touching(center_a, center_b, reach + ball_a.radius + ball_b.radius)
    }
}

/// Returns the bits of the lanes in which two points are closer than `reach` (m).
#[inline(always)]
fn touching<S: Simd>(a: LaneVector<S>, b: LaneVector<S>, reach: f32) -> u32 {
    shorter(a.minus(b).norm_squared(), f32x16::splat(a.x.token(), reach))
}
