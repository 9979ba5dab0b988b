use cranny_robot::LaneFrame;
use cranny_spatial::{LaneArray, LaneVector};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

use crate::lane::lane_body::{LaneBody, LaneNode};
use crate::lane::lane_scratch::{Descent, LaneScratch, Near};
use crate::lane::lane_vector::BoxLanes;
use crate::lane::lanes::{FEW_LANES, LanePair, Lanes};
use crate::lane::single_frame::{Bars, SingleFrame, Verdict};

/// Number of inner balls of a link that are checked first: the largest, which detect deep contact quickly.
const LARGE_INNER: usize = 8;

impl Lanes {
    /// Runs phase 2 of [`Self::check`] for one link; with `wanted`, only for these pairs, each in its lanes. Each instruction
    /// set has a separate function, because one function for all would take minutes to compile.
    ///
    /// 1. The box and the ball around the link are checked against every part; where few lanes are near, they are checked one
    ///    by one.
    /// 2. Its largest inner balls detect deep contact.
    /// 3. Its tree of outer balls is traversed from the root.
    /// 4. The other inner balls are checked where many lanes are in doubt.
    /// 5. The remaining lanes are checked one by one.
    #[inline(never)]
    pub fn body_against_world<S: Simd>(
        &self,
        simd: S,
        body: usize,
        wanted: Option<&[(u32, u32)]>,
        frames: &[LaneFrame],
        scratch: &mut LaneScratch,
        open: &mut u32,
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                let pairs = &self.part_pairs[body];
                if pairs.is_empty() {
                    return;
                }
                let LaneBody { frame, outer, inner, hulls, .. } = &self.bodies[body];
                let frame = &frames[*frame];
                let travel = self.travel_of(simd, body, frame, scratch);
                // 1.
                self.find_near(simd, body, wanted, frame, scratch, open);
                if scratch.near.is_empty() {
                    return;
                }
                // 2.
                let (large, small) = inner.split_at(inner.len().min(LARGE_INNER));
                for ball in large {
                    let center = frame.point(simd, ball.center);
                    for near in &scratch.near {
                        *open &= !self.meets(
                            simd,
                            &pairs[near.index as usize],
                            center,
                            ball.radius,
                            near.lanes & *open,
                        );
                    }
                }
                // 3.
                let rough_doubt = scratch.doubts.len();
                scratch.stack.clear();
                scratch.push_children(outer[0].children, 0, scratch.near.len());
                if scratch.stack.is_empty() {
                    let near =
                        scratch.near.iter().map(|near| (pairs[near.index as usize].pair, near.lanes & *open));
                    scratch.doubts.extend(near.filter(|(_, lanes)| *lanes != 0));
                }
                while let Some(Descent { node, begin, end }) = scratch.stack.pop() {
                    let LaneNode { ball, children } = outer[node as usize];
                    let center = frame.point(simd, ball.center);
                    scratch.near.truncate(end as usize);
                    let kept = scratch.near.len();
                    for index in begin as usize..end as usize {
                        let Near { index, lanes } = scratch.near[index];
                        let pair = &pairs[index as usize];
                        let lanes = lanes & *open & !scratch.doubt(rough_doubt, pair.pair);
                        if lanes == 0 {
                            continue;
                        }
                        let reach = travel + (pair.free_m + ball.radius);
                        let part = &self.parts[pair.other as usize];
                        let is_leaf = children == [0; 2];
                        let lanes = if is_leaf {
                            part.solid.within_reach(simd, center, reach, lanes)
                        } else {
                            part.solid.maybe_within_reach(simd, center, reach, lanes)
                        };
                        if lanes == 0 {
                            continue;
                        }
                        if is_leaf {
                            scratch.add_doubt(rough_doubt, pair.pair, lanes);
                        } else {
                            scratch.near.push(Near { index, lanes });
                        }
                    }
                    if scratch.near.len() > kept {
                        scratch.push_children(children, kept, scratch.near.len());
                    }
                }
                // 4.
                for ball in small {
                    let mut center = None;
                    for (pair, lanes) in &mut scratch.doubts[rough_doubt..] {
                        *lanes &= *open;
                        if lanes.count_ones() > if hulls.is_empty() { 0 } else { FEW_LANES } {
                            let center = *center.get_or_insert(frame.point(simd, ball.center));
                            // The pairs of a link with parts are consecutive.
                            let place = (*pair - pairs[0].pair) as usize;
                            *open &= !self.meets(simd, &pairs[place], center, ball.radius, *lanes);
                        }
                    }
                }
                // 5.
                if hulls.is_empty() {
                    return;
                }
                for (pair, lanes) in &mut scratch.doubts[rough_doubt..] {
                    let pair = &pairs[(*pair - pairs[0].pair) as usize];
                    *lanes = self.part_one_by_one(
                        simd,
                        body,
                        pair,
                        *lanes & *open,
                        frame,
                        &scratch.travel.bodies[body],
                        open,
                    );
                }
            },
        );
    }

    /// Runs phase 1 of [`Self::body_against_world`]: `scratch.near` then contains the parts that are near in many lanes.
    #[inline(always)]
    fn find_near<S: Simd>(
        &self,
        simd: S,
        body: usize,
        wanted: Option<&[(u32, u32)]>,
        frame: &LaneFrame,
        scratch: &mut LaneScratch,
        open: &mut u32,
    ) {
        let pairs = &self.part_pairs[body];
        let travel = f32x16::from_slice(simd, &scratch.travel.bodies[body]);
        let link = scratch.boxes[body].load(simd);
        // Compare the boxes.
        scratch.near.clear();
        if let Some(wanted) = wanted {
            for (pair, lanes) in wanted {
                let index = pair - pairs[0].pair;
                let lanes = self.box_near(body, index, link, travel) & lanes & *open;
                if lanes != 0 {
                    scratch.near.push(Near { index, lanes });
                }
            }
        } else {
            let farthest = travel + self.farthest_free_m[body];
            let mut next = 0;
            while next < self.branches.len() {
                let branch = &self.branches[next];
                let near = match &branch.around {
                    Some(around) => link.within_reach(around.splat(simd), farthest),
                    None => u32::MAX,
                };
                if near & *open == 0 {
                    next = branch.next;
                    continue;
                }
                next += 1;
                for index in branch.begin..branch.end {
                    let lanes = self.box_near(body, index, link, travel) & *open;
                    if lanes != 0 {
                        scratch.near.push(Near { index, lanes });
                    }
                }
            }
        }
        if scratch.near.is_empty() {
            return;
        }
        // Compare the ball around the link.
        let root = &self.bodies[body].outer[0].ball;
        let center = frame.point(simd, root.center);
        let mut kept = 0;
        for candidate in 0..scratch.near.len() {
            let Near { index, lanes } = scratch.near[candidate];
            let pair = &pairs[index as usize];
            let reach = travel + (pair.free_m + root.radius);
            let part = &self.parts[pair.other as usize];
            let lanes = part.solid.maybe_within_reach(simd, center, reach, lanes & *open);
            if lanes.count_ones() > FEW_LANES {
                scratch.near[kept] = Near { index, lanes };
                kept += 1;
                continue;
            }
            let travels_m = &scratch.travel.bodies[body];
            let doubt = self.part_one_by_one(simd, body, pair, lanes, frame, travels_m, open);
            if doubt != 0 {
                scratch.doubts.push((pair.pair, doubt));
            }
        }
        scratch.near.truncate(kept);
    }

    /// Returns the lanes in which the boxes around a link and a part are near each other.
    #[inline(always)]
    fn box_near<S: Simd>(&self, body: usize, index: u32, link: BoxLanes<S>, travel: f32x16<S>) -> u32 {
        let reach = travel + self.part_pairs[body][index as usize].free_m;
        self.arounds[index as usize].within_reach(travel.token(), link, reach)
    }

    /// Checks a link and a part lane by lane, and returns the `lanes` that stay in doubt; removes lanes in contact from `open`.
    #[allow(clippy::too_many_arguments, reason = "one step of the function above, with what it has at hand")]
    #[inline(always)]
    fn part_one_by_one<S: Simd>(
        &self,
        simd: S,
        body: usize,
        pair: &LanePair,
        lanes: u32,
        frame: &LaneFrame,
        travels_m: &LaneArray,
        open: &mut u32,
    ) -> u32 {
        let part = &self.parts[pair.other as usize];
        let against = |lane: usize| {
            let bars = Bars { free_m: pair.free_m + travels_m[lane], contact_m: pair.contact_m };
            self.bodies[body].against_part(simd, &SingleFrame::of(frame, lane), part, bars)
        };
        Verdict::one_by_one(lanes, against, open)
    }

    /// Returns the lanes in which an inner ball is certainly too close to a part.
    #[inline(always)]
    fn meets<S: Simd>(
        &self,
        simd: S,
        pair: &LanePair,
        center: LaneVector<S>,
        radius: f32,
        lanes: u32,
    ) -> u32 {
        let part = &self.parts[pair.other as usize];
        if !part.is_exact || lanes == 0 {
            return 0;
        }
        part.solid.surely_within_reach(simd, center, f32x16::splat(simd, pair.contact_m + radius), lanes)
    }
}
