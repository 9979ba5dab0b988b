use cranny_spatial::{LANES, ROUNDING_M, simd_level};
use fearless_simd::Level;

use crate::cell::{Cell, Scratch};
use crate::lane::lane_bits::{first_lanes, lanes_of};
use crate::lane::lane_scratch::{LaneLinkSpeed, LaneMotion};
use crate::lane::lanes::Interest;
use crate::pair::pairs::{Other, Pair};
use crate::proof::joint_curve::JointCurve;
#[cfg(doc)]
use crate::proof::joint_curve::Rates;
use crate::proof::tool::Excess;
use crate::proof::travel::LinkSpeed;
use crate::proof::work_list::{Interval, MOST_INTERVALS, WorkList};
use crate::touch::contact::Contact;

/// Proof of a motion, or its failure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// Every pair keeps its demanded distance at every point of the motion. [`Cell::least_clearance`] measures the clearance.
    Proven,
    /// Some point of the motion is in contact, or closer than demanded.
    Contact {
        /// Parameter in [0, 1] along the motion.
        at: f64,
        /// Contact there.
        contact: Contact,
    },
    /// Contact was neither found nor excluded: a pair comes within 1 µm of the demanded distance, or the effort was exhausted.
    Unresolved {
        /// Parameter in [0, 1] along the motion.
        at: f64,
        /// Pair in doubt, its distance, and the demanded one.
        contact: Contact,
    },
    /// The tool exceeds a bound, or was not proven to keep it.
    OutOfBounds {
        /// Parameter in [0, 1] along the motion.
        at: f64,
        /// Index of the bound ([`Cell::tool_bounds`]).
        bound: usize,
        /// Excess over the bound there, in radians or metres.
        by: f64,
    },
    /// An end of the motion, or a control point of a curve, lies outside the joint limits.
    OutOfLimits {
        /// Index of the first such joint in the group.
        joint: usize,
    },
}

impl Motion {
    /// Returns true if the whole motion is certified.
    pub fn is_proven(&self) -> bool {
        matches!(self, Self::Proven)
    }
}

impl From<Excess> for Motion {
    fn from(Excess { at, bound, by }: Excess) -> Self {
        Self::OutOfBounds { at, bound, by }
    }
}

/// Options of a proof.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Demand {
    /// Factor on every bound on motion: less than 1 makes a wrong proof, for tests of the proof.
    pub factor: f64,
    /// Distance that all pairs must keep in addition to the demanded one, in metres.
    pub beyond_m: f64,
    /// Maximum number of intervals with exact distances, beyond which the proof fails. Default: [`MOST_INTERVALS`].
    pub effort: u64,
}

impl Default for Demand {
    fn default() -> Self {
        Self { factor: 1.0, beyond_m: 0.0, effort: MOST_INTERVALS }
    }
}

/// Maximum number of intervals that wait for the lanes; the exact phase takes further ones, within [`MOST_INTERVALS`].
const MOST_WAITING: usize = 1 << 18;

/// Travel of a link within an interval below which bisection ends, in metres: a tenth of the distance that counts as contact.
const RESOLUTION_M: f64 = 1e-6;

/// Travel of a pair within an interval below which exact distances are cheaper than further lanes, in metres.
const FINEST_IN_LANES_M: f64 = 3e-5;

/// Maximum travel from the middle of one of the first intervals of a proof, in metres: half the thickness of an arm. Most
/// longer intervals would be in doubt, and shorter ones would be unnecessarily many.
const FIRST_TRAVEL_M: f64 = 0.04;

/// Maximum number of passes over the first intervals of a proof.
const MOST_FIRST_PASSES: f64 = 64.0;

/// Failure of a proof.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Failure {
    at: f64,
    /// Pair in contact or in doubt; `None` if only the lanes found contact.
    pair: Option<u32>,
    is_contact: bool,
}

impl Cell {
    /// Proves the straight motion from `a` to `b` (m, rad; one value per joint), or returns the fault.
    ///
    /// 1. The joint limits are a box, so the ends decide for the whole edge. The bounds on the tool, including the tilt of the
    ///    held object, are proven by bisection ([`Self::tool_bounds`]).
    /// 2. Breadth first, coarse to fine: at the middle of an interval, a pair is certified for the whole interval if its
    ///    certified distance exceeds the demanded one by more than the travel of the pair within it. The lanes check many
    ///    intervals at once, down to their resolution; the rest is checked one by one with the exact distance.
    /// 3. A pair that is closer than demanded at a middle ends the search.
    /// 4. The remaining pairs are checked again in both halves, until none is left.
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
        excess.map_or_else(|| self.prove(JointCurve::Line([a, b]), scratch, Demand::default()), Motion::from)
    }

    /// Returns the parameter in [0, 1] at which the proof of [`Self::motion_is_free`] from `a` to `b` (m, rad; one per joint)
    /// fails; `None` for a proven motion. It also fails if more than `effort` intervals need exact distances: a motion with a
    /// very small clearance takes thousands, and a planner may find another one.
    ///
    /// # Panics
    /// If `a` or `b` has not one value per joint.
    pub fn unproven_at(&self, effort: u64, a: &[f64], b: &[f64], scratch: &mut Scratch) -> Option<f64> {
        let beyond = [(a, 0.0), (b, 1.0)].into_iter().find(|(end, _)| !self.robot().within_limits(end));
        let beyond = beyond.map(|(_, at)| at);
        beyond.or_else(|| self.out_of_bounds_at(a, b, &[], scratch).map(|excess| excess.at)).or_else(|| {
            let failure =
                self.first_failure(JointCurve::Line([a, b]), scratch, Demand { effort, ..Demand::default() });
            failure.map(|failure| failure.at)
        })
    }

    /// Proves [`Self::motion_is_free`] along any motion, without joint limits and bounds on the tool.
    pub(crate) fn prove(&self, curve: JointCurve<'_>, scratch: &mut Scratch, demand: Demand) -> Motion {
        let mut failure = self.first_failure(curve, scratch, demand);
        if let Some(Failure { at, pair: None, .. }) = failure {
            self.check_at(curve, at, 0.0, scratch, demand.factor);
            if let Some(pair) = self.first_close_pair(&scratch.frames) {
                failure = Some(Failure { at, pair: Some(pair), is_contact: true });
            } else {
                // The lanes report contact only if the exact check does. Here they are wrong: the exact check decides alone.
                scratch.work.clear();
                scratch.work.pairs.extend(self.all_pairs());
                let pairs = (0, self.pairs.len());
                scratch.work.intervals.push(Interval { middle: 0.5, half_width: 0.5, pairs });
                failure = self.certify_exactly(curve, scratch, demand);
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

    /// Returns the failure of the proof, if any; the frames of `scratch` are then at the configuration of a named pair.
    pub(crate) fn first_failure(
        &self,
        curve: JointCurve<'_>,
        scratch: &mut Scratch,
        demand: Demand,
    ) -> Option<Failure> {
        scratch.rates.set(curve);
        match self.certify_in_lanes(simd_level(), curve, scratch, demand) {
            Some(at) => Some(Failure { at, pair: None, is_contact: true }),
            None => self.certify_exactly(curve, scratch, demand),
        }
    }

    /// Runs phase 2 in lanes. `scratch.work` then contains the remaining intervals; returns the parameter of a contact, if any.
    fn certify_in_lanes(
        &self,
        level: Level,
        curve: JointCurve<'_>,
        scratch: &mut Scratch,
        demand: Demand,
    ) -> Option<f64> {
        // Travel bounds of the whole motion bound those of each interval in proportion.
        self.check_at(curve, 0.5, 0.5, scratch, demand.factor);
        let mut work = std::mem::take(&mut scratch.work);
        let mut next = std::mem::take(&mut scratch.next_work);
        let mut rest = std::mem::take(&mut scratch.rest);
        [&mut work, &mut next, &mut rest].into_iter().for_each(WorkList::clear);
        let first_intervals = self.first_intervals(scratch);
        let mut half_width = 0.5 / first_intervals as f64;
        // The first intervals cover all pairs, and list none.
        let mut is_first = true;
        // Each pass is spread over the whole edge, so that contact is found sooner.
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
                scratch.lanes.set_lanes_along(curve, intervals.iter().map(|interval| interval.middle));
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
                    let is_full = next.intervals.len() >= MOST_WAITING;
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
                        if travel_m > blur_m + demand.beyond_m && !is_full {
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

    /// Returns the number of first intervals of a proof, a multiple of the lanes.
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "at most `MOST_FIRST_PASSES` passes"
    )]
    fn first_intervals(&self, scratch: &Scratch) -> usize {
        // Solve `LinkSpeed::travel_m` for the number of intervals, by the velocity in the middle of the motion.
        let intervals = |LinkSpeed { now, acceleration, .. }: LinkSpeed| {
            (now + (now * now + 2.0 * FIRST_TRAVEL_M * acceleration).sqrt()) / (4.0 * FIRST_TRAVEL_M)
        };
        let most =
            (0..self.bodies.len()).map(|body| intervals(scratch.travel.link_speed(body))).fold(0.0, f64::max);
        (most / LANES as f64).ceil().clamp(1.0, MOST_FIRST_PASSES) as usize * LANES
    }

    /// Sets the travel bounds of the lanes for intervals of this fraction of the edge; `scratch` contains the travel of the
    /// whole edge. The distance to keep in addition to the demanded one is added to the travel.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "lanes are `f32` by design; what is rounded away is added"
    )]
    pub(crate) fn set_travel(&self, share: f64, demand: Demand, scratch: &mut Scratch) {
        /// Maximum error of a point's velocity as a fraction of the sum of its joints' contributions: a hundred times the
        /// rounding of `f32`.
        const ROUNDED: f64 = 1e-4;
        let Demand { factor, beyond_m, .. } = demand;
        let lane = |travel: f64| ((travel + beyond_m + ROUNDING_M) * (1.0 + 1e-6)) as f32;
        let half_width = 0.5 * share * factor;
        let link_speed = |body: usize| {
            let LinkSpeed { most, acceleration, .. } = scratch.travel.link_speed(body);
            let beside = half_width * (0.5 * half_width * acceleration + ROUNDED * most);
            LaneLinkSpeed { most_m: lane(half_width * most), beside_m: lane(beside) }
        };
        let LaneMotion { half_width: lanes_half_width, link_speeds, .. } = &mut scratch.lanes.travel.motion;
        *lanes_half_width = half_width as f32;
        link_speeds.clear();
        link_speeds.extend((0..self.bodies.len()).map(link_speed));
        for (slot, pair) in self.lanes.link_pairs().enumerate() {
            scratch.lanes.travel.link_pairs[slot] = lane(travel_of(&self.pairs.get(pair), scratch) * share);
        }
        for (joint, travel) in scratch.lanes.travel.joints.iter_mut().enumerate() {
            let turn = (0.5 * scratch.rates.most_of(joint) * share + ROUNDING_M) * (1.0 + 1e-6);
            // Tables certify only the demanded distance.
            *travel = if beyond_m > 0.0 { f32::INFINITY } else { turn as f32 };
        }
    }

    /// Runs phases 2 to 4 for `scratch.work`, with exact distances.
    fn certify_exactly(
        &self,
        curve: JointCurve<'_>,
        scratch: &mut Scratch,
        demand: Demand,
    ) -> Option<Failure> {
        let mut work = std::mem::take(&mut scratch.work);
        let mut next = std::mem::take(&mut scratch.next_work);
        let mut failure = None;
        let mut intervals: u64 = 0;
        'levels: while !work.intervals.is_empty() {
            next.clear();
            for interval in &work.intervals {
                self.place_at(curve, interval.middle, scratch);
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

    /// Computes the frames at `middle`, and the travel bounds within `half_width` of it.
    pub(crate) fn check_at(
        &self,
        curve: JointCurve<'_>,
        middle: f64,
        half_width: f64,
        scratch: &mut Scratch,
        factor: f64,
    ) {
        self.place_at(curve, middle, scratch);
        let Scratch { travel, frames, rates, .. } = scratch;
        travel.update(self.robot(), &self.bodies, frames, rates, half_width, factor);
    }

    /// Computes frames and rates at `middle` of a motion whose rates are already bounded ([`Rates::set`]).
    fn place_at(&self, curve: JointCurve<'_>, middle: f64, scratch: &mut Scratch) {
        curve.place(middle, &mut scratch.q);
        if let JointCurve::Curve(_) = curve {
            curve.slope(middle, &mut scratch.rates.now);
        }
        self.robot().forward_kinematics(&scratch.q, &mut scratch.frames);
    }

    /// Computes and caches the travel bounds of the links of a pair within `half_width` of the frames of `scratch`.
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
