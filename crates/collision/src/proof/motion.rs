use cranny_spatial::{LANES, ROUNDING_M, simd_level};
use fearless_simd::Level;

use crate::cell::{Cell, Scratch};
use crate::lane::lane_bits::{first_lanes, lanes_of};
use crate::lane::lane_scratch::{LaneMotion, LanePace};
use crate::lane::lanes::Interest;
use crate::pair::pairs::{Other, Pair};
use crate::proof::course::Course;
#[cfg(doc)]
use crate::proof::course::Rates;
use crate::proof::tool::Excess;
use crate::proof::travel::Pace;
use crate::proof::work_list::{Interval, WorkList};
use crate::touch::contact::Contact;

/// Proof of a motion, or what prevents it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// Every pair keeps its demanded distance at every point of the motion. By how much,
    /// [`Cell::least_clearance`] measures.
    Proven,
    /// Some point of the motion is in contact, or closer than demanded.
    Contact {
        /// Where, in [0, 1] along the motion.
        at: f64,
        /// What touches what.
        contact: Contact,
    },
    /// No contact was found, but neither could it be excluded: a pair comes within 1 µm of what
    /// is demanded, or the effort was spent.
    Unresolved {
        /// Where, in [0, 1] along the motion.
        at: f64,
        /// The pair in doubt, its distance, and what is demanded.
        contact: Contact,
    },
    /// The tool does not keep a bound, or was not proven to keep it.
    OutOfBounds {
        /// Place in [0, 1] along the motion.
        at: f64,
        /// The bound, by its number ([`Cell::tool_bounds`]).
        bound: usize,
        /// The excess over it there, in radians or metres.
        by: f64,
    },
    /// An end lies outside the joint limits.
    OutOfLimits {
        /// The first joint that does, by its index in the group.
        joint: usize,
    },
}

impl Motion {
    /// Whether the whole motion is certified.
    pub fn is_proven(&self) -> bool {
        matches!(self, Self::Proven)
    }
}

impl From<Excess> for Motion {
    fn from(Excess { at, bound, by }: Excess) -> Self {
        Self::OutOfBounds { at, bound, by }
    }
}

/// What a proof is asked for besides what the pairs demand.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Demand {
    /// By what every bound on motion is multiplied: less than 1 makes a wrong proof, for tests of the proof.
    pub factor: f64,
    /// How much farther than they must be all pairs are to keep apart, in metres.
    pub beyond_m: f64,
    /// The proof is given up where more than so many intervals need exact distances.
    pub effort: u64,
}

impl Default for Demand {
    fn default() -> Self {
        Self { factor: 1.0, beyond_m: 0.0, effort: u64::MAX }
    }
}

/// Bisection ends where no link can move farther than this within an interval, in metres: a tenth of what
/// counts as contact.
const RESOLUTION_M: f64 = 1e-6;

/// Where a pair moves by less than this within an interval, in metres, exact distances are cheaper than
/// more lanes.
const FINEST_IN_LANES_M: f64 = 3e-5;

/// Nothing moves farther than this from the middle of one of the intervals that a proof begins with, in metres:
/// half the thickness of an arm. Of longer ones most would be in doubt, of shorter ones more than needed checked.
const FIRST_TRAVEL_M: f64 = 0.04;

/// A proof begins with so many passes at most.
const MOST_FIRST_PASSES: f64 = 64.0;

/// Where a proof ends without being one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Failure {
    /// In [0, 1] along the motion.
    at: f64,
    /// The pair that is in contact or in doubt; nothing where the lanes alone have seen contact.
    pair: Option<u32>,
    is_contact: bool,
}

impl Cell {
    /// Proves the straight motion from `a` to `b` (m, rad; one value per joint), or says what prevents it.
    ///
    /// 1. The joint limits are a box, so the ends decide for the whole edge. The bounds of the tool, the tilt of what is held among
    ///    them, are proven by bisection ([`Self::tool_bounds`]).
    /// 2. Breadth first, coarse to fine: at the middle of an interval, a pair is certified for all of it if
    ///    its certified distance exceeds what is demanded by more than the pair can move within it. First in
    ///    lanes, many intervals at once, down to where the lanes cannot tell; what is left then, one
    ///    by one with the exact distance.
    /// 3. A pair that is closer than demanded at a middle ends the search.
    /// 4. The pairs left over are checked again in both halves, until nothing is left over.
    ///
    /// # Panics
    /// If `a` or `b` has not one value per joint.
    pub fn motion_is_free(&self, a: &[f64], b: &[f64], scratch: &mut Scratch) -> Motion {
        for end in [a, b] {
            if let Some(violation) = self.robot().first_limit_violation(end) {
                return Motion::OutOfLimits { joint: violation.joint };
            }
        }
        let excess = self.out_of_bounds_at(a, b, &[], scratch);
        excess.map_or_else(|| self.prove(Course::Line([a, b]), scratch, Demand::default()), Motion::from)
    }

    /// Parameter in [0, 1] at which the proof of [`Self::motion_is_free`] from `a` to `b` (m, rad; one per joint) fails; nothing
    /// for a motion that is proven. It is given up where more than `effort` intervals need exact distances: a motion
    /// that passes something very closely takes thousands, and a planner may know another.
    ///
    /// # Panics
    /// If `a` or `b` has not one value per joint.
    pub fn unproven_at(&self, effort: u64, a: &[f64], b: &[f64], scratch: &mut Scratch) -> Option<f64> {
        let beyond = [(a, 0.0), (b, 1.0)].into_iter().find(|(end, _)| !self.robot().within_limits(end));
        let beyond = beyond.map(|(_, at)| at);
        beyond.or_else(|| self.out_of_bounds_at(a, b, &[], scratch).map(|excess| excess.at)).or_else(|| {
            let failure =
                self.first_failure(Course::Line([a, b]), scratch, Demand { effort, ..Demand::default() });
            failure.map(|failure| failure.at)
        })
    }

    /// [`Self::motion_is_free`] along a motion, without joint limits and bounds of the tool.
    pub(crate) fn prove(&self, course: Course<'_>, scratch: &mut Scratch, demand: Demand) -> Motion {
        let mut failure = self.first_failure(course, scratch, demand);
        if let Some(Failure { at, pair: None, .. }) = failure {
            self.check_at(course, at, 0.0, scratch, demand.factor);
            if let Some(pair) = self.first_close_pair(&scratch.frames) {
                failure = Some(Failure { at, pair: Some(pair), is_contact: true });
            } else {
                // The lanes are certain of contact only where the exact check is; were it not so, it would have
                // to check everything itself.
                scratch.work.clear();
                scratch.work.pairs.extend(self.all_pairs());
                let pairs = (0, self.pairs.len());
                scratch.work.intervals.push(Interval { middle: 0.5, half_width: 0.5, pairs });
                failure = self.certify_exactly(course, scratch, demand);
            }
        }
        let Some((Failure { at, is_contact, .. }, pair)) =
            failure.and_then(|failure| Some((failure, failure.pair?)))
        else {
            return Motion::Proven;
        };
        let contact = self.describe(&self.pairs.get(pair), &scratch.frames);
        if is_contact { Motion::Contact { at, contact } } else { Motion::Unresolved { at, contact } }
    }

    /// What keeps the proof from being one; a pair that it names stands as it is there in the frames of `scratch`.
    pub(crate) fn first_failure(
        &self,
        course: Course<'_>,
        scratch: &mut Scratch,
        demand: Demand,
    ) -> Option<Failure> {
        scratch.rates.set(course);
        match self.certify_in_lanes(simd_level(), course, scratch, demand) {
            Some(at) => Some(Failure { at, pair: None, is_contact: true }),
            None => self.certify_exactly(course, scratch, demand),
        }
    }

    /// Step 2 in lanes. What is left is in `scratch.work`; a place where something is in contact is returned.
    fn certify_in_lanes(
        &self,
        level: Level,
        course: Course<'_>,
        scratch: &mut Scratch,
        demand: Demand,
    ) -> Option<f64> {
        // How far everything can move along the whole motion bounds how far it can move in each part of it.
        self.check_at(course, 0.5, 0.5, scratch, demand.factor);
        let mut work = std::mem::take(&mut scratch.work);
        let mut next = std::mem::take(&mut scratch.next_work);
        let mut rest = std::mem::take(&mut scratch.rest);
        [&mut work, &mut next, &mut rest].into_iter().for_each(WorkList::clear);
        let first_intervals = self.first_intervals(scratch);
        let mut half_width = 0.5 / first_intervals as f64;
        // At first nothing is certified: these intervals have all pairs, and list none.
        let mut is_first = true;
        // Each pass checks along the whole edge: contact shows the sooner.
        let passes = first_intervals / LANES;
        let along = (0..passes).flat_map(|pass| (0..LANES).map(move |lane| lane * passes + pass));
        work.intervals.extend(along.map(|index| Interval {
            middle: (2 * index + 1) as f64 * half_width,
            half_width,
            pairs: (0, 0),
        }));
        let mut contact_at = None;
        while !work.intervals.is_empty() && contact_at.is_none() {
            next.clear();
            let share = 2.0 * half_width;
            self.set_travel(share, demand, scratch);
            for intervals in work.intervals.chunks(LANES) {
                scratch.lanes.wanted.clear();
                scratch.lanes.set_lanes_along(course, intervals.iter().map(|interval| interval.middle));
                for (lane, Interval { pairs, .. }) in intervals.iter().enumerate() {
                    work.pairs[pairs.0..pairs.1].iter().for_each(|pair| scratch.lanes.want(*pair, lane));
                }
                let (asked, interest) = (first_lanes(intervals.len()), Interest::AllOrNothing);
                let contact = if is_first {
                    self.lanes.check(level, &mut scratch.lanes, asked, interest)
                } else {
                    self.lanes.check_again(level, &mut scratch.lanes, asked, interest)
                };
                if contact != 0 {
                    contact_at = lanes_of(contact).next().map(|lane| intervals[lane].middle);
                    break;
                }
                let doubtful = scratch.lanes.doubts.iter().fold(0, |all, (_, lanes)| all | lanes);
                for lane in lanes_of(doubtful) {
                    let interval = &intervals[lane];
                    let (begin_next, begin_rest) = (next.pairs.len(), rest.pairs.len());
                    for (pair, lanes) in &scratch.lanes.doubts {
                        if lanes >> lane & 1 == 0 {
                            continue;
                        }
                        let known = self.pairs.get(*pair);
                        let blur_m = self.lanes.blur_m(&known).max(FINEST_IN_LANES_M);
                        let travel_m = match known.second {
                            Other::Part(_) => f64::from(scratch.lanes.travel.bodies[known.first][lane]),
                            Other::Link { .. } => travel_of(&known, scratch) * share,
                        };
                        if travel_m > blur_m + demand.beyond_m {
                            next.pairs.push(*pair);
                        } else {
                            rest.pairs.push(*pair);
                        }
                    }
                    next.push_halves(interval, begin_next);
                    if begin_rest < rest.pairs.len() {
                        rest.intervals.push(Interval { pairs: (begin_rest, rest.pairs.len()), ..*interval });
                    }
                }
            }
            std::mem::swap(&mut work, &mut next);
            is_first = false;
            half_width *= 0.5;
        }
        scratch.work = rest;
        scratch.next_work = next;
        scratch.rest = work;
        contact_at
    }

    /// How many intervals a proof begins with: as many as whole passes check.
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "at most `MOST_FIRST_PASSES` passes"
    )]
    fn first_intervals(&self, scratch: &Scratch) -> usize {
        // As many as make `Pace::travel_m` as much, by the velocity half way.
        let intervals = |Pace { now, acceleration, .. }: Pace| {
            (now + (now * now + 2.0 * FIRST_TRAVEL_M * acceleration).sqrt()) / (4.0 * FIRST_TRAVEL_M)
        };
        let most =
            (0..self.bodies.len()).map(|body| intervals(scratch.travel.pace(body))).fold(0.0, f64::max);
        (most / LANES as f64).ceil().clamp(1.0, MOST_FIRST_PASSES) as usize * LANES
    }

    /// Tells the lanes how far everything can move within an interval that has this share of the edge whose
    /// travel `scratch` holds; what must be kept beyond what is demanded is as if it moved so much farther.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "lanes are `f32` by design; what is rounded away is added"
    )]
    pub(crate) fn set_travel(&self, share: f64, demand: Demand, scratch: &mut Scratch) {
        /// The velocity of a point is off by less than this share of what its joints could add up to: a hundred times
        /// what `f32` rounds.
        const ROUNDED: f64 = 1e-4;
        let Demand { factor, beyond_m, .. } = demand;
        let lane = |travel: f64| ((travel + beyond_m + ROUNDING_M) * (1.0 + 1e-6)) as f32;
        let half_width = 0.5 * share * factor;
        let pace = |body: usize| {
            let Pace { most, acceleration, .. } = scratch.travel.pace(body);
            let beside = half_width * (0.5 * half_width * acceleration + ROUNDED * most);
            LanePace { most_m: lane(half_width * most), beside_m: lane(beside) }
        };
        let LaneMotion { half_width: lanes_half_width, paces, .. } = &mut scratch.lanes.travel.motion;
        *lanes_half_width = half_width as f32;
        paces.clear();
        paces.extend((0..self.bodies.len()).map(pace));
        for (slot, pair) in self.lanes.link_pairs().enumerate() {
            scratch.lanes.travel.link_pairs[slot] = lane(travel_of(&self.pairs.get(pair), scratch) * share);
        }
        for (joint, travel) in scratch.lanes.travel.joints.iter_mut().enumerate() {
            let turn = (0.5 * scratch.rates.most_of(joint) * share + ROUNDING_M) * (1.0 + 1e-6);
            // Tables know of nothing beyond what is demanded.
            *travel = if beyond_m > 0.0 { f32::INFINITY } else { turn as f32 };
        }
    }

    /// Steps 2 to 4 for what is in `scratch.work`, with exact distances.
    fn certify_exactly(&self, course: Course<'_>, scratch: &mut Scratch, demand: Demand) -> Option<Failure> {
        let mut work = std::mem::take(&mut scratch.work);
        let mut next = std::mem::take(&mut scratch.next_work);
        let mut failure = None;
        let mut intervals: u64 = 0;
        'levels: while !work.intervals.is_empty() {
            next.clear();
            for interval in &work.intervals {
                self.place_at(course, interval.middle, scratch);
                scratch.travel.forget();
                intervals += 1;
                let begin = next.pairs.len();
                for &index in &work.pairs[interval.pairs.0..interval.pairs.1] {
                    let pair = &self.pairs.get(index);
                    self.know_travel(pair, interval.half_width * demand.factor, scratch);
                    // 2.
                    let travel = travel_of(pair, scratch) + ROUNDING_M;
                    let required_m = pair.required_m + demand.beyond_m;
                    let needed = required_m + travel;
                    if self.quick_bound(pair, &scratch.frames, needed) > needed {
                        continue;
                    }
                    let gap = self.distance(pair, &scratch.frames, needed);
                    if gap.lower_m >= needed {
                        continue;
                    }
                    // 3.
                    let is_contact = gap.upper_m <= required_m;
                    if is_contact || travel < RESOLUTION_M || intervals > demand.effort {
                        failure = Some(Failure { at: interval.middle, pair: Some(index), is_contact });
                        break 'levels;
                    }
                    next.pairs.push(index);
                }
                // 4.
                next.push_halves(interval, begin);
            }
            std::mem::swap(&mut work, &mut next);
        }
        scratch.work = work;
        scratch.next_work = next;
        failure
    }

    /// Frames at `middle`, and how far everything can move within `half_width` of it.
    pub(crate) fn check_at(
        &self,
        course: Course<'_>,
        middle: f64,
        half_width: f64,
        scratch: &mut Scratch,
        factor: f64,
    ) {
        self.place_at(course, middle, scratch);
        let Scratch { travel, frames, rates, .. } = scratch;
        travel.update(self.robot(), &self.bodies, frames, rates, half_width, factor);
    }

    /// Frames and rates at `middle` of a motion whose rates are bounded already ([`Rates::set`]).
    fn place_at(&self, course: Course<'_>, middle: f64, scratch: &mut Scratch) {
        course.place(middle, &mut scratch.q);
        if let Course::Curve(_) = course {
            course.slope(middle, &mut scratch.rates.now);
        }
        self.robot().forward_kinematics(&scratch.q, &mut scratch.frames);
    }

    /// How far the links of a pair can move within `half_width` of the frames of `scratch`, unless that is known.
    fn know_travel(&self, pair: &Pair, half_width: f64, scratch: &mut Scratch) {
        let other = match pair.second {
            Other::Link { body, .. } => Some(body),
            Other::Part(_) => None,
        };
        let Scratch { travel, frames, rates, .. } = scratch;
        for body in std::iter::once(pair.first).chain(other) {
            travel.know(self.robot(), &self.bodies, body, frames, rates, half_width);
        }
    }
}

pub(crate) fn travel_of(pair: &Pair, scratch: &Scratch) -> f64 {
    match pair.second {
        Other::Part(_) => scratch.travel.of(pair.first),
        Other::Link { body, shared_joints } => scratch.travel.between(pair.first, body, shared_joints),
    }
}
