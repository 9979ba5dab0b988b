use cranny_robot::{LaneFrame, LaneKinematics, Robot};
use cranny_spatial::{LANES, LaneVector};
use fearless_simd::prelude::*;
use fearless_simd::{Level, Simd, dispatch, f32x16, i32x16};

use crate::batch::lanes_of;
use crate::cell::{Other, Pair};
use crate::joint_table::{self, JointTable};
use crate::lane_body::{LaneBody, LaneNode};
use crate::lane_part::LanePart;
use crate::lane_scratch::{Descent, LaneScratch, Near, as_index};
use crate::lane_tree::LaneBranch;
use crate::link_body::LinkBody;
use crate::part_tree::PartTree;
use crate::single_lane::{Bars, LARGE_INNER, SingleFrame, Verdict};
use crate::world::Part;

/// What [`LANES`] configurations are asked at once, in `f32`, with the error bounded: each pair of things is
/// certainly far enough apart, certainly too close, or in doubt.
///
/// A link lies within the balls of its tree and contains its inner balls. What keeps off an outer ball keeps
/// off that piece of the link; what meets an inner ball meets the link. What neither decides in some lanes,
/// and what is near in few lanes from the start, the hulls decide one by one. What is in doubt then, the exact
/// check decides.
#[derive(Clone, Debug)]
pub(crate) struct Lanes {
    kinematics: LaneKinematics,
    pub(crate) bodies: Vec<LaneBody>,
    parts: Vec<LanePart>,
    /// What leads to the parts that are near.
    branches: Vec<LaneBranch>,
    /// Per link body the parts that it is checked against: all or none, in the order of the branches.
    part_pairs: Vec<Vec<LanePair>>,
    /// Per link body the greatest `free_m` of these, in metres.
    farthest_free_m: Vec<f32>,
    /// Pairs of links that are looked up.
    tables: Vec<JointTable>,
    /// Per pair how much closer it can seem than it is, in metres.
    blurs_m: Vec<f64>,
    /// All pairs of link bodies, those of the tables last.
    pub(crate) link_pairs: Vec<LanePair>,
    /// Body of the first link of each of `link_pairs`.
    pub(crate) link_firsts: Vec<u32>,
    /// Where those of the tables begin.
    first_tabled: usize,
}

/// Up to so many lanes are looked at one by one: a step of all lanes takes as long as a few of one lane.
pub(crate) const FEW_LANES: u32 = 4;

/// A cell of a table is about this large, in metres that the links move.
const TABLE_BLUR_M: f64 = 0.01;

/// A hull or mesh of the world fills its box to about this, in metres.
const BOX_BLUR_M: f64 = 0.02;

/// Two things that are checked against each other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LanePair {
    /// The index in [`crate::Cell`]'s list.
    pub pair: u32,
    /// The other thing: a part or a link body.
    pub other: u32,
    /// At this distance, or farther, the pair is certainly far enough apart.
    pub free_m: f32,
    /// Below this distance it is certainly too close.
    pub contact_m: f32,
}

/// Which lanes still matter once some are in contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Interest {
    /// Each for itself.
    Each,
    /// Only those before the first in contact.
    UpToContact,
    /// None.
    AllOrNothing,
}

impl Interest {
    #[inline(always)]
    fn narrowed(self, asked: u32, open: u32) -> u32 {
        match (self, asked & !open) {
            (_, 0) | (Self::Each, _) => open,
            (Self::UpToContact, contact) => open & ((1 << contact.trailing_zeros()) - 1),
            (Self::AllOrNothing, _) => 0,
        }
    }
}

impl Lanes {
    /// `pairs` has the parts that a link is checked against in the order of `tree`.
    pub fn new(
        robot: &Robot,
        bodies: &[LinkBody],
        parts: &[(usize, Part)],
        tree: &PartTree,
        pairs: &[Pair],
    ) -> Self {
        let kinematics = LaneKinematics::new(robot);
        let lane_bodies: Vec<LaneBody> = bodies.iter().map(|body| LaneBody::new(&kinematics, body)).collect();
        let lane_parts: Vec<LanePart> = parts.iter().map(|(_, part)| LanePart::of(part)).collect();
        let mut part_pairs = vec![Vec::new(); bodies.len()];
        let mut link_pairs = Vec::new();
        let tables = JointTable::all(robot, bodies, pairs);
        let mut blurs_m = Vec::with_capacity(pairs.len());
        let mut tabled = Vec::new();
        for (index, pair) in pairs.iter().enumerate() {
            let LaneBody { blur_m, slack_m, .. } = lane_bodies[pair.first];
            match pair.second {
                Other::Part(part) => {
                    let slack_m = slack_m + lane_parts[part].slack_m;
                    blurs_m.push(blur_m + if lane_parts[part].is_exact { 0.0 } else { BOX_BLUR_M });
                    part_pairs[pair.first].push(LanePair::new(index, part, pair.required_m, slack_m));
                }
                Other::Link { body, .. } => {
                    let slack_m = slack_m + lane_bodies[body].slack_m;
                    let is_tabled = tables.iter().any(|table| table.pairs.contains(&as_index(index)));
                    blurs_m.push(if is_tabled { TABLE_BLUR_M } else { blur_m + lane_bodies[body].blur_m });
                    let link_pair = LanePair::new(index, body, pair.required_m, slack_m);
                    let pairs = if is_tabled { &mut tabled } else { &mut link_pairs };
                    pairs.push((link_pair, as_index(pair.first)));
                }
            }
        }
        let first_tabled = link_pairs.len();
        link_pairs.append(&mut tabled);
        let (link_pairs, link_firsts) = link_pairs.into_iter().unzip();
        let farthest = |pairs: &Vec<LanePair>| pairs.iter().map(|pair| pair.free_m).fold(0.0, f32::max);
        Self {
            kinematics,
            farthest_free_m: part_pairs.iter().map(farthest).collect(),
            bodies: lane_bodies,
            parts: lane_parts,
            branches: tree.nodes().iter().map(LaneBranch::of).collect(),
            part_pairs,
            tables,
            blurs_m,
            link_pairs,
            link_firsts,
            first_tabled,
        }
    }

    /// Takes the slack off every comparison, to see that the law of the lanes notices.
    #[cfg(test)]
    pub fn forget_slack(&mut self) {
        for pair in self.part_pairs.iter_mut().flatten().chain(&mut self.link_pairs) {
            let middle = 0.5 * (pair.free_m + pair.contact_m);
            (pair.free_m, pair.contact_m) = (middle, middle);
        }
    }

    /// The pairs of links: their index in the list of all pairs.
    pub fn link_pairs(&self) -> impl Iterator<Item = usize> {
        self.link_pairs.iter().map(|pair| pair.pair as usize)
    }

    /// How much closer a pair can seem than it is, in metres: below that the lanes cannot tell.
    pub fn blur_m(&self, pair: u32) -> f64 {
        self.blurs_m[pair as usize]
    }

    pub fn scratch(&self, dof: usize) -> LaneScratch {
        let balls = self.bodies.iter().map(|body| body.outer.len());
        LaneScratch::new(dof, self.kinematics.frame_count(), self.link_pairs.len(), balls)
    }

    /// Looks at the configurations in `scratch.q` whose bits are set in `asked`. Returns the lanes that are
    /// certainly in contact, or of no more interest (see [`Interest`]); what is in doubt in the others is in
    /// `scratch.doubts` then, and a lane that is in neither is certainly free. "Free" and "in doubt" hold for
    /// everything that is no farther away than `scratch.travel` says.
    ///
    /// 1. Pairs of links that are in a table are looked up.
    /// 2. Every link against the world: the box around it against every part. What is near in few lanes is
    ///    looked at one by one; else inner balls against the parts that are near, and down its tree of balls
    ///    against those that are still near, until a leaf leaves the pair in doubt; what is left one by one.
    /// 3. The other pairs of links in the same way, and those that their table leaves in doubt one by one.
    pub fn look(&self, level: Level, scratch: &mut LaneScratch, asked: u32, interest: Interest) -> u32 {
        dispatch!(level, simd => self.look_with(simd, scratch, asked, interest))
    }

    #[inline(always)]
    fn look_with<S: Simd>(&self, simd: S, scratch: &mut LaneScratch, asked: u32, interest: Interest) -> u32 {
        scratch.begin();
        let mut open = asked;
        for table in &self.tables {
            if open != 0 {
                look_up(simd, table, scratch, &mut open);
                open = interest.narrowed(asked, open);
            }
        }
        let tabled = scratch.doubts.len();
        let mut frames = std::mem::take(&mut scratch.frames);
        if open != 0 {
            self.kinematics.forward(simd, &scratch.q, &mut frames);
            for (body, lanes) in self.bodies.iter().zip(&mut scratch.boxes) {
                frames[body.frame].point(simd, body.middle).store(&mut lanes.middle);
                frames[body.frame].box_around(simd, body.half_extents).store(&mut lanes.half_extents);
            }
        }
        for body in (0..self.bodies.len()).rev() {
            if open != 0 {
                self.body_against_world(simd, body, &frames, scratch, &mut open);
                open = interest.narrowed(asked, open);
            }
        }
        for index in 0..self.first_tabled {
            let lanes = if open == 0 { 0 } else { self.link_boxes_near(simd, index, scratch) & open };
            if lanes != 0 {
                self.link_against_link(simd, index, lanes, &frames, scratch, &mut open);
                open = interest.narrowed(asked, open);
            }
        }
        for index in self.first_tabled..self.link_pairs.len() {
            let pair = self.link_pairs[index].pair;
            let Some(doubt) = scratch.doubts[..tabled].iter().position(|(doubtful, _)| *doubtful == pair)
            else {
                continue;
            };
            let lanes = scratch.doubts[doubt].1 & open;
            scratch.doubts[doubt].1 = self.links_one_by_one(simd, index, lanes, &frames, scratch, &mut open);
            open = interest.narrowed(asked, open);
        }
        scratch.frames = frames;
        asked & !open
    }

    /// Step 2 of [`Self::look`] for one link. A function of its own for each instruction set: all in one would
    /// take minutes to compile.
    ///
    /// 1. The box around the link against every part; few lanes that are near are looked at one by one.
    /// 2. Its largest inner balls: deep contact shows at once.
    /// 3. Down its tree of outer balls.
    /// 4. The other inner balls, where many lanes are in doubt.
    /// 5. What is left one by one.
    #[inline(never)]
    fn body_against_world<S: Simd>(
        &self,
        simd: S,
        body: usize,
        frames: &[LaneFrame],
        scratch: &mut LaneScratch,
        open: &mut u32,
    ) {
        simd.vectorize(
            #[inline(always)]
            || self.body_against_parts(simd, body, frames, scratch, open),
        );
    }

    #[inline(always)]
    fn body_against_parts<S: Simd>(
        &self,
        simd: S,
        body: usize,
        frames: &[LaneFrame],
        scratch: &mut LaneScratch,
        open: &mut u32,
    ) {
        let pairs = &self.part_pairs[body];
        if pairs.is_empty() {
            return;
        }
        let LaneBody { frame, outer, inner, hulls, .. } = &self.bodies[body];
        let frame = &frames[*frame];
        // 1.
        let middle = LaneVector::load(simd, &scratch.boxes[body].middle);
        let half_extents = LaneVector::load(simd, &scratch.boxes[body].half_extents);
        let travel_m = scratch.travel.bodies[body];
        let farthest = f32x16::splat(simd, self.farthest_free_m[body] + travel_m);
        scratch.near.clear();
        let mut next = 0;
        while next < self.branches.len() {
            let branch = &self.branches[next];
            if branch.within_reach(simd, middle, half_extents, farthest) & *open == 0 {
                next = branch.next;
                continue;
            }
            next += 1;
            for index in branch.begin..branch.end {
                let pair = &pairs[index as usize];
                let reach = f32x16::splat(simd, pair.free_m + travel_m);
                let part = &self.parts[pair.other as usize];
                let lanes = part.box_within_reach(simd, middle, half_extents, reach) & *open;
                if lanes.count_ones() > FEW_LANES {
                    scratch.near.push(Near { index, lanes });
                    continue;
                }
                let doubt = self.part_one_by_one(simd, body, pair, lanes, frame, travel_m, open);
                if doubt != 0 {
                    scratch.doubts.push((pair.pair, doubt));
                }
            }
        }
        if scratch.near.is_empty() {
            return;
        }
        // 2.
        let (large, small) = inner.split_at(inner.len().min(LARGE_INNER));
        for ball in large {
            let center = frame.point(simd, ball.center);
            for near in &scratch.near {
                *open &=
                    !self.meets(simd, &pairs[near.index as usize], center, ball.radius, near.lanes & *open);
            }
        }
        // 3.
        let rough_doubt = scratch.doubts.len();
        scratch.stack.clear();
        scratch.stack.push(Descent { node: 0, begin: 0, end: as_index(scratch.near.len()) });
        while let Some(Descent { node, begin, end }) = scratch.stack.pop() {
            let LaneNode { ball, children } = outer[node as usize];
            let center = scratch.center(simd, body, node as usize, &ball, frame);
            scratch.near.truncate(end as usize);
            let kept = scratch.near.len();
            for index in begin as usize..end as usize {
                let Near { index, lanes } = scratch.near[index];
                let pair = &pairs[index as usize];
                let lanes = lanes & *open & !scratch.doubt(rough_doubt, pair.pair);
                if lanes == 0 {
                    continue;
                }
                let reach = f32x16::splat(simd, pair.free_m + travel_m + ball.radius);
                let lanes = self.parts[pair.other as usize].solid.within_reach(simd, center, reach) & lanes;
                if lanes == 0 {
                    continue;
                }
                if children == [0; 2] {
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
                    // The pairs of a link with parts follow each other.
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
            *lanes = self.part_one_by_one(simd, body, pair, *lanes & *open, frame, travel_m, open);
        }
    }

    /// The lanes of `lanes` in which a link and a part are in doubt, each looked at by itself; where they are
    /// in contact is taken out of `open`.
    // One step of the function above, with what it has at hand.
    #[allow(clippy::too_many_arguments)]
    #[inline(always)]
    fn part_one_by_one<S: Simd>(
        &self,
        simd: S,
        body: usize,
        pair: &LanePair,
        lanes: u32,
        frame: &LaneFrame,
        travel_m: f32,
        open: &mut u32,
    ) -> u32 {
        let part = &self.parts[pair.other as usize];
        let bars = Bars { free_m: pair.free_m + travel_m, contact_m: pair.contact_m };
        let mut doubt = 0;
        for lane in lanes_of(lanes) {
            let frame = SingleFrame::of(frame, lane);
            match self.bodies[body].against_part(simd, &frame, part, bars) {
                Verdict::Free => {}
                Verdict::Contact => *open &= !(1 << lane),
                Verdict::Doubt => doubt |= 1 << lane,
            }
        }
        doubt
    }

    /// The lanes in which an inner ball is certainly too close to a part.
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
        part.solid.within_reach(simd, center, f32x16::splat(simd, pair.contact_m + radius)) & lanes
    }
}

impl LanePair {
    // Lanes are `f32` by design; the slack covers it.
    #[allow(clippy::cast_possible_truncation)]
    fn new(pair: usize, other: usize, required_m: f64, slack_m: f64) -> Self {
        Self {
            pair: as_index(pair),
            other: as_index(other),
            free_m: (required_m + slack_m) as f32,
            contact_m: (required_m - slack_m) as f32,
        }
    }
}

/// Step 1 for one table.
#[inline(always)]
fn look_up<S: Simd>(simd: S, table: &JointTable, scratch: &mut LaneScratch, open: &mut u32) {
    let mut low = [[0; LANES]; 2];
    let mut high = [[0; LANES]; 2];
    for (axis, (low, high)) in low.iter_mut().zip(&mut high).enumerate() {
        let joint = table.joints[axis];
        let value = f32x16::from_slice(simd, &scratch.q[joint]) - table.lower[axis];
        let travel = scratch.travel.joints[joint];
        let cell = (value - travel) * table.per_unit[axis];
        i32x16::truncate_from(cell.floor()).store_slice(low);
        let cell = (value + travel) * table.per_unit[axis];
        i32x16::truncate_from(cell.floor()).store_slice(high);
    }
    let first_doubt = scratch.doubts.len();
    for lane in lanes_of(*open) {
        match table.look_up([low[0][lane], low[1][lane]], [high[0][lane], high[1][lane]]) {
            0 => {}
            joint_table::CONTACT => *open &= !(1 << lane),
            doubtful => {
                for (bit, pair) in table.pairs.iter().enumerate() {
                    if doubtful >> bit & 1 == 1 {
                        scratch.add_doubt(first_doubt, *pair, 1 << lane);
                    }
                }
            }
        }
    }
}
