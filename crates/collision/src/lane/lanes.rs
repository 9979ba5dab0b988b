use std::sync::Arc;

use cranny_robot::{Hold, LaneFrame, LaneKinematics, Robot};
use cranny_spatial::LANES;
use fearless_simd::prelude::*;
use fearless_simd::{Level, Simd, dispatch, f32x16, i32x16};

use crate::body::part_tree::PartTree;
use crate::body::robot_body::RobotBody;
use crate::lane::lane_bits::lanes_of;
use crate::lane::lane_body::LaneBody;
use crate::lane::lane_part::{LaneAround, LanePart};
use crate::lane::lane_scratch::{LaneLinkSpeed, LaneMotion, LaneScratch, as_index};
use crate::lane::lane_tree::LaneBranch;
use crate::lane::lane_vector::RELATIVE_ROUNDING;
use crate::pair::pairs::{Other, Pair, Pairs};
use crate::proof::joint_table::{self, JointTable};

/// Check of [`LANES`] configurations at once, in `f32` with bounded error: each pair is certainly far enough apart, certainly
/// too close, or in doubt.
///
/// The leaves of its tree of balls cover a link, and its inner balls lie inside it. If an outer ball is clear, so is the
/// portion of the link that it covers; if an inner ball is in contact, so is the link. The hulls decide the remaining doubts
/// lane by lane, and from the start the pairs that are near in few lanes. The exact check decides the rest.
#[derive(Clone, Debug)]
pub(crate) struct Lanes {
    kinematics: Arc<LaneKinematics>,
    pub(crate) bodies: Arc<[LaneBody]>,
    pub(crate) parts: Arc<[LanePart]>,
    /// Nodes of the tree of parts, for the broad phase.
    pub(crate) branches: Vec<LaneBranch>,
    /// Pairs of each link with parts, in the order of the branches: with all parts or with none.
    pub(crate) part_pairs: Vec<Vec<LanePair>>,
    /// Bounding volume of each part, in the order of the branches.
    pub(crate) arounds: Vec<LaneAround>,
    /// Greatest `free_m` of the pairs of each link with parts, in metres.
    pub(crate) farthest_free_m: Vec<f32>,
    /// Tables of the pairs of links that depend on one or two joints.
    tables: Vec<JointTable>,
    /// All pairs of links, those of the tables last.
    pub(crate) link_pairs: Vec<LanePair>,
    /// Index of the first link of each of `link_pairs`, among the links with geometry.
    pub(crate) link_firsts: Vec<u32>,
    /// Index in `link_pairs` of the first pair that is in a table.
    first_tabled: usize,
    /// Index in `link_pairs` of each pair of links, in the order of [`crate::Cell`]'s list.
    link_slots: Vec<usize>,
}

/// Maximum number of lanes that are checked one by one: an operation on all lanes takes as long as a few on one lane.
pub(crate) const FEW_LANES: u32 = 4;

/// A collision pair of the lanes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LanePair {
    /// Index in [`crate::Cell`]'s list.
    pub pair: u32,
    /// Index of the second member: among the parts, or the links with geometry.
    pub other: u32,
    /// Least computed distance at which the pair is certainly far enough apart, in metres; negative infinity if the two are
    /// never near each other.
    pub free_m: f32,
    /// Distance below which the pair is certainly too close, in metres.
    pub contact_m: f32,
}

/// Lanes whose verdict is of interest once some lanes are in contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Interest {
    /// Every lane, independently of the others.
    Each,
    /// Only the lanes before the first one in contact.
    UpToContact,
    /// No lane.
    AllOrNothing,
}

/// State of a check.
struct LaneCheck {
    asked: u32,
    interest: Interest,
    /// Lanes that are not certainly in contact, and of interest.
    open: u32,
}

impl LaneCheck {
    fn is_open(&self) -> bool {
        self.open != 0
    }

    /// Updates the lanes of interest after an operation.
    #[inline(always)]
    fn narrow(&mut self) {
        match (self.interest, self.contact()) {
            (_, 0) | (Interest::Each, _) => {}
            (Interest::UpToContact, contact) => self.open &= (1 << contact.trailing_zeros()) - 1,
            (Interest::AllOrNothing, contact) => (self.asked, self.open) = (contact, 0),
        }
    }

    /// Returns the lanes that are in contact, or of no further interest.
    #[inline(always)]
    fn contact(&self) -> u32 {
        self.asked & !self.open
    }
}

impl Lanes {
    pub fn new(
        robot: &Robot,
        body: &RobotBody,
        lane_parts: Arc<[LanePart]>,
        tree: &PartTree,
        pairs: &Pairs,
    ) -> Self {
        let lane_bodies = body.lanes.clone();
        let mut part_pairs = vec![Vec::new(); lane_bodies.len()];
        let (of_links, first_of_links) = pairs.of_links();
        let tables: Vec<JointTable> = body
            .tables(robot, of_links)
            .iter()
            .filter(|table| table.asked_pairs().next().is_some())
            .map(|table| table.counted_from(as_index(first_of_links)))
            .collect();
        let (mut untabled, mut tabled) = (Vec::new(), Vec::new());
        for (index, pair) in pairs.iter().enumerate() {
            let slack_m = lane_bodies[pair.first].slack_m;
            match pair.second {
                Other::Part(part) => {
                    let slack_m = slack_m + lane_parts[part].slack_m;
                    part_pairs[pair.first].push(LanePair::new(index, part, pair.required_m, slack_m));
                }
                Other::Link { body, .. } => {
                    let slack_m = slack_m + lane_bodies[body].slack_m;
                    let is_tabled = tables
                        .iter()
                        .any(|table| table.asked_pairs().any(|(_, pair)| pair == as_index(index)));
                    let link_pair = LanePair::new(index, body, pair.required_m, slack_m);
                    let pairs = if is_tabled { &mut tabled } else { &mut untabled };
                    pairs.push((link_pair, as_index(pair.first)));
                }
            }
        }
        let first_tabled = untabled.len();
        let (link_pairs, link_firsts): (Vec<LanePair>, Vec<u32>) = untabled.into_iter().chain(tabled).unzip();
        let mut link_slots: Vec<usize> = (0..link_pairs.len()).collect();
        link_slots.sort_unstable_by_key(|slot| link_pairs[*slot].pair);
        for (sweep, pairs) in std::iter::zip(&body.swept, &mut part_pairs) {
            let Some(sweep) = sweep else { continue };
            for LanePair { other, free_m, .. } in pairs {
                if !lane_parts[*other as usize].is_near(sweep, *free_m) {
                    *free_m = f32::NEG_INFINITY;
                }
            }
        }
        let farthest =
            |pairs: &Vec<LanePair>| pairs.iter().map(|pair| pair.free_m).fold(f32::NEG_INFINITY, f32::max);
        Self {
            kinematics: body.kinematics.clone(),
            farthest_free_m: part_pairs.iter().map(farthest).collect(),
            arounds: tree.parts().iter().map(|part| lane_parts[*part].around).collect(),
            bodies: lane_bodies,
            parts: lane_parts,
            branches: tree.nodes().iter().map(LaneBranch::of).collect(),
            part_pairs,
            tables,
            link_pairs,
            link_firsts,
            first_tabled,
            link_slots,
        }
    }

    /// Returns the tables of pairs of links.
    pub fn tables(&self) -> &[JointTable] {
        &self.tables
    }

    /// Returns the pairs of links that are in no table, by index in [`crate::Cell`]'s list.
    pub fn untabled(&self) -> impl Iterator<Item = u32> {
        self.link_pairs[..self.first_tabled].iter().map(|pair| pair.pair)
    }

    /// Removes the slack from every comparison, to test that this is detected.
    #[cfg(test)]
    pub fn forget_slack(&mut self) {
        for pair in self.part_pairs.iter_mut().flatten().chain(&mut self.link_pairs) {
            let middle = 0.5 * (pair.free_m + pair.contact_m);
            (pair.free_m, pair.contact_m) = (middle, middle);
        }
    }

    /// Returns the pairs of links, by index in the list of all pairs.
    pub fn link_pairs(&self) -> impl Iterator<Item = u32> {
        self.link_pairs.iter().map(|pair| pair.pair)
    }

    /// Returns the maximum underestimate of a pair's distance, in metres: the resolution of the lanes.
    pub fn blur_m(&self, pair: &Pair) -> f64 {
        let LaneBody { blur_m, ref hulls, .. } = self.bodies[pair.first];
        blur_m
            + match pair.second {
                Other::Part(part) => self.parts[part].blur_m(!hulls.is_empty()),
                Other::Link { body, .. } => self.bodies[body].blur_m,
            }
    }

    pub fn scratch(&self, robot: &Robot, hold: Option<&Hold>) -> LaneScratch {
        let (frames, bodies) = (self.kinematics.frame_count(), self.bodies.len());
        let mut scratch = LaneScratch::new(robot.dof(), frames, bodies, self.link_pairs.len());
        if let Some(hold) = hold {
            self.kinematics.place_held(robot, hold, &mut scratch.places);
        }
        scratch
    }

    /// Checks the configurations in `scratch.q` whose bits are set in `asked`. Returns the lanes that are certainly in contact;
    /// with [`Interest::UpToContact`] also the lanes after the first of them. `scratch.doubts` then contains the pairs in doubt
    /// in the other lanes. A lane without contact or doubt is certainly free, unless contact ended the check. "Free" and "in
    /// doubt" are valid for all configurations within the motion bounds of `scratch.travel`.
    ///
    /// 1. Pairs of links that are in a table are looked up.
    /// 2. Every link is checked against the world: the box and the ball around it against every part. If few lanes are near,
    ///    they are checked one by one; otherwise inner balls are checked against the near parts, then the tree of balls, until
    ///    a leaf leaves the pair in doubt. The remaining lanes are checked one by one.
    /// 3. The other pairs of links are checked in the same manner; doubts of the tables are checked one by one.
    pub fn check(&self, level: Level, scratch: &mut LaneScratch, asked: u32, interest: Interest) -> u32 {
        dispatch!(level, simd => self.check_with(simd, scratch, asked, interest))
    }

    /// Runs [`Self::check`] for the pairs of `scratch.wanted` alone, each in its wanted lanes.
    pub fn check_again(
        &self,
        level: Level,
        scratch: &mut LaneScratch,
        asked: u32,
        interest: Interest,
    ) -> u32 {
        scratch.wanted.sort_unstable();
        dispatch!(level, simd => self.look_again_with(simd, scratch, asked, interest))
    }

    #[inline(always)]
    fn check_with<S: Simd>(&self, simd: S, scratch: &mut LaneScratch, asked: u32, interest: Interest) -> u32 {
        scratch.doubts.clear();
        let mut check = LaneCheck { asked, interest, open: asked };
        for table in &self.tables {
            if check.is_open() {
                look_up(simd, table, scratch, u32::MAX, &mut check.open);
                check.narrow();
            }
        }
        let tabled = scratch.doubts.len();
        let mut frames = std::mem::take(&mut scratch.frames);
        if check.is_open() {
            self.place(simd, &mut frames, scratch);
        }
        for body in (0..self.bodies.len()).rev() {
            if check.is_open() {
                self.body_against_world(simd, body, None, &frames, scratch, &mut check.open);
                check.narrow();
            }
        }
        for index in 0..self.first_tabled {
            if check.is_open() {
                self.links(simd, index, u32::MAX, &frames, scratch, &mut check.open);
                check.narrow();
            }
        }
        self.settle_tabled(simd, tabled, &frames, scratch, &mut check);
        scratch.frames = frames;
        check.contact()
    }

    #[inline(always)]
    fn look_again_with<S: Simd>(
        &self,
        simd: S,
        scratch: &mut LaneScratch,
        asked: u32,
        interest: Interest,
    ) -> u32 {
        scratch.doubts.clear();
        let mut check = LaneCheck { asked, interest, open: asked };
        let mut frames = std::mem::take(&mut scratch.frames);
        let wanted = std::mem::take(&mut scratch.wanted);
        let place = |pair: u32| wanted.partition_point(|(known, _)| *known < pair);
        let lanes_of_pair = |pair: u32| match wanted.get(place(pair)) {
            Some((known, lanes)) if *known == pair => *lanes,
            _ => 0,
        };
        for table in &self.tables {
            let lanes = table.asked_pairs().fold(0, |all, (_, pair)| all | lanes_of_pair(pair));
            if lanes != 0 && check.is_open() {
                look_up(simd, table, scratch, lanes, &mut check.open);
                check.narrow();
            }
        }
        scratch.doubts.iter_mut().for_each(|(pair, lanes)| *lanes &= lanes_of_pair(*pair));
        let tabled = scratch.doubts.len();
        if check.is_open() {
            self.place(simd, &mut frames, scratch);
        }
        for body in (0..self.bodies.len()).rev() {
            let Some(LanePair { pair, .. }) = self.part_pairs[body].first() else { continue };
            let wanted = &wanted[place(*pair)..place(pair + as_index(self.parts.len()))];
            if !wanted.is_empty() && check.is_open() {
                self.body_against_world(simd, body, Some(wanted), &frames, scratch, &mut check.open);
                check.narrow();
            }
        }
        let first_link_pair = self.first_link_pair();
        for (pair, lanes) in &wanted[place(first_link_pair)..] {
            let index = self.link_slots[(pair - first_link_pair) as usize];
            if index < self.first_tabled && check.is_open() {
                self.links(simd, index, *lanes, &frames, scratch, &mut check.open);
                check.narrow();
            }
        }
        self.settle_tabled(simd, tabled, &frames, scratch, &mut check);
        (scratch.frames, scratch.wanted) = (frames, wanted);
        check.contact()
    }

    /// Computes the poses of all links in every lane, and the boxes around them.
    #[inline(always)]
    fn place<S: Simd>(&self, simd: S, frames: &mut [LaneFrame], scratch: &mut LaneScratch) {
        self.kinematics.forward(simd, &scratch.q, &scratch.places, frames);
        if scratch.travel.motion.half_width > 0.0 {
            self.kinematics.twists(simd, &scratch.travel.motion.rates, frames, &mut scratch.twists);
        }
        for (body, lanes) in self.bodies.iter().zip(&mut scratch.boxes) {
            frames[body.frame].point(simd, body.middle).store(&mut lanes.middle);
            frames[body.frame].box_around(simd, body.half_extents).store(&mut lanes.half_extents);
        }
    }

    /// Computes a bound on the motion of a link within the interval of each lane, in metres.
    #[inline(always)]
    pub fn travel_of<S: Simd>(
        &self,
        simd: S,
        body: usize,
        frame: &LaneFrame,
        scratch: &mut LaneScratch,
    ) -> f32x16<S> {
        let travels = &mut scratch.travel.bodies[body];
        let LaneMotion { half_width, link_speeds, .. } = &scratch.travel.motion;
        if *half_width > 0.0 {
            let LaneBody { frame: number, outer, .. } = &self.bodies[body];
            let ball = &outer[0].ball;
            let center = frame.point(simd, ball.center);
            let (turn, velocity) = scratch.twists[*number].at(simd, frame, center);
            let fastest = velocity.norm_squared().sqrt() + turn.norm_squared().sqrt() * ball.radius;
            let LaneLinkSpeed { most_m, beside_m } = link_speeds[body];
            let travel = (fastest * *half_width + beside_m).min(f32x16::splat(simd, most_m));
            travel.store_slice(travels);
        }
        f32x16::from_slice(simd, travels)
    }

    /// Runs phase 3 of [`Self::check`] for one pair, in the given lanes.
    #[inline(always)]
    fn links<S: Simd>(
        &self,
        simd: S,
        index: usize,
        lanes: u32,
        frames: &[LaneFrame],
        scratch: &mut LaneScratch,
        open: &mut u32,
    ) {
        let lanes = self.link_boxes_near(simd, index, scratch) & lanes & *open;
        if lanes != 0 {
            self.link_against_link(simd, index, lanes, frames, scratch, open);
        }
    }

    /// Checks one by one the pairs left in doubt by the tables: the first `tabled` of `scratch.doubts`.
    #[inline(always)]
    fn settle_tabled<S: Simd>(
        &self,
        simd: S,
        tabled: usize,
        frames: &[LaneFrame],
        scratch: &mut LaneScratch,
        check: &mut LaneCheck,
    ) {
        for doubt in 0..tabled {
            let (pair, lanes) = scratch.doubts[doubt];
            let index = self.link_slots[(pair - self.first_link_pair()) as usize];
            let lanes = lanes & check.open;
            scratch.doubts[doubt].1 =
                self.links_one_by_one(simd, index, lanes, frames, scratch, &mut check.open);
            check.narrow();
        }
    }

    /// Returns the index of the first pair of links, after all pairs with parts.
    fn first_link_pair(&self) -> u32 {
        as_index(self.part_pairs.iter().map(Vec::len).sum())
    }
}

impl LanePair {
    /// Creates a pair; an infinite slack leaves every configuration in doubt.
    #[allow(clippy::cast_possible_truncation, reason = "lanes are `f32` by design; the slack covers it")]
    fn new(pair: usize, other: usize, required_m: f64, slack_m: f64) -> Self {
        let slack_m = slack_m + RELATIVE_ROUNDING * required_m;
        Self {
            pair: as_index(pair),
            other: as_index(other),
            free_m: (required_m + slack_m) as f32,
            contact_m: (required_m - slack_m) as f32,
        }
    }
}

/// Runs phase 1 of [`Lanes::check`] for one table.
#[inline(always)]
fn look_up<S: Simd>(simd: S, table: &JointTable, scratch: &mut LaneScratch, lanes: u32, open: &mut u32) {
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
    if table.joints.iter().any(|joint| scratch.travel.joints[*joint].is_infinite()) {
        scratch.doubts.extend(table.asked_pairs().map(|(_, pair)| (pair, *open & lanes)));
        return;
    }
    for lane in lanes_of(*open & lanes) {
        match table.look_up([low[0][lane], low[1][lane]], [high[0][lane], high[1][lane]]) {
            0 => {}
            found if found & joint_table::CONTACT != 0 => *open &= !(1 << lane),
            doubtful => {
                for (_, pair) in table.asked_pairs().filter(|(bit, _)| doubtful & bit != 0) {
                    scratch.add_doubt(first_doubt, pair, 1 << lane);
                }
            }
        }
    }
}
