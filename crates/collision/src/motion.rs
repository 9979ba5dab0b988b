use cranny_spatial::ROUNDING_M;

use crate::cell::{Cell, Other, Pair, Scratch};
use crate::contact::Contact;

/// What is known about a straight motion from one configuration to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// Every pair keeps its demanded distance at every point of the motion.
    Proven {
        /// Every pair keeps at least this distance too, in metres. A by-product of the proof, so it may be
        /// far below the truth: [`Cell::least_clearance`] measures it.
        least_clearance_m: f64,
    },
    /// Some point of the motion is in contact, or closer than demanded.
    Contact {
        /// Where, in [0, 1] along the motion.
        at: f64,
        /// What touches what.
        contact: Contact,
    },
    /// No contact was found, but neither could it be excluded: a pair comes within 1 µm of what
    /// is demanded.
    Unresolved {
        /// Where, in [0, 1] along the motion.
        at: f64,
        /// The pair in doubt, its distance, and what is demanded.
        contact: Contact,
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
        matches!(self, Self::Proven { .. })
    }
}

/// Bisection ends where no link can move farther than this within an interval, in metres: a tenth of what
/// counts as contact.
const RESOLUTION_M: f64 = 1e-6;

/// How far [`Cell::least_clearance`] may lie below the truth, in metres.
const CLEARANCE_TOLERANCE_M: f64 = 1e-5;

/// A piece of the motion that is not certified yet, and the pairs in doubt there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Interval {
    middle: f64,
    half_width: f64,
    /// Where in the list of doubtful pairs its own begin and end.
    pairs: (usize, usize),
}

impl Cell {
    /// Proves the straight motion from `a` to `b` (m, rad; one value per joint), or says what prevents it.
    ///
    /// 1. The joint limits are a box, so the ends decide for the whole edge.
    /// 2. Breadth first, coarse to fine: at the middle of an interval, a pair is certified for all of it if
    ///    its certified distance exceeds what is demanded by more than the pair can move within it.
    /// 3. A pair that is closer than demanded at a middle ends the search.
    /// 4. The pairs left over are looked at again in both halves, until nothing is left over.
    ///
    /// # Panics
    /// If `a` or `b` has not one value per joint.
    pub fn motion_is_free(&self, a: &[f64], b: &[f64], scratch: &mut Scratch) -> Motion {
        for end in [a, b] {
            if let Some(violation) = self.robot().first_limit_violation(end) {
                return Motion::OutOfLimits { joint: violation.joint };
            }
        }
        self.prove(a, b, scratch, 1.0)
    }

    /// [`Self::motion_is_free`] without joint limits, and with every bound on motion multiplied by `factor`.
    pub(crate) fn prove(&self, a: &[f64], b: &[f64], scratch: &mut Scratch, factor: f64) -> Motion {
        for (slope, (a, b)) in scratch.slope.iter_mut().zip(a.iter().zip(b)) {
            *slope = b - a;
        }
        scratch.doubtful.clear();
        scratch.doubtful.extend(self.all_pairs());
        scratch.intervals.clear();
        scratch.intervals.push(Interval { middle: 0.5, half_width: 0.5, pairs: (0, self.pairs.len()) });

        let mut least_clearance_m = f64::INFINITY;
        while !scratch.intervals.is_empty() {
            scratch.next_intervals.clear();
            scratch.next_doubtful.clear();
            for index in 0..scratch.intervals.len() {
                let interval = scratch.intervals[index];
                self.look_at(a, b, &interval, scratch, factor);
                let begin = scratch.next_doubtful.len();
                for slot in interval.pairs.0..interval.pairs.1 {
                    let pair_index = scratch.doubtful[slot];
                    let pair = &self.pairs[pair_index as usize];
                    // 2.
                    let travel = travel_of(pair, scratch) + ROUNDING_M;
                    let needed = pair.required_m + travel;
                    let quick = self.quick_bound(pair, &scratch.frames, needed);
                    if quick > needed {
                        least_clearance_m = least_clearance_m.min(quick - travel);
                        continue;
                    }
                    let gap = self.distance(pair, &scratch.frames, needed);
                    if gap.lower_m >= needed {
                        least_clearance_m = least_clearance_m.min(gap.lower_m - travel);
                        continue;
                    }
                    // 3.
                    if gap.upper_m <= pair.required_m {
                        let contact = self.describe(pair, &scratch.frames);
                        return Motion::Contact { at: interval.middle, contact };
                    }
                    if travel < RESOLUTION_M {
                        let contact = self.describe(pair, &scratch.frames);
                        return Motion::Unresolved { at: interval.middle, contact };
                    }
                    scratch.next_doubtful.push(pair_index);
                }
                // 4.
                let pairs = (begin, scratch.next_doubtful.len());
                if pairs.0 < pairs.1 {
                    let half_width = interval.half_width * 0.5;
                    for middle in [interval.middle - half_width, interval.middle + half_width] {
                        scratch.next_intervals.push(Interval { middle, half_width, pairs });
                    }
                }
            }
            std::mem::swap(&mut scratch.intervals, &mut scratch.next_intervals);
            std::mem::swap(&mut scratch.doubtful, &mut scratch.next_doubtful);
        }
        Motion::Proven { least_clearance_m: least_clearance_m.max(0.0) }
    }

    /// The least distance over all pairs along the straight motion from `a` to `b`, in metres: a certified
    /// lower bound that is at most 10 µm too low; 0 if there is contact, infinite if there is nothing to
    /// touch. Meant for motions that are proven: the closer two things come, the longer it takes.
    ///
    /// # Panics
    /// If `a` or `b` has not one value per joint.
    pub fn least_clearance(&self, a: &[f64], b: &[f64], scratch: &mut Scratch) -> f64 {
        for (slope, (a, b)) in scratch.slope.iter_mut().zip(a.iter().zip(b)) {
            *slope = b - a;
        }
        let mut least = self.clearance(a, scratch).min(self.clearance(b, scratch));
        let all: Vec<u32> = self.all_pairs().collect();
        let mut open = std::collections::VecDeque::from([(0.5, 0.5, all)]);
        // Branch and bound: an interval is done with a pair once the pair cannot come below the least
        // distance that was seen, save for the tolerance.
        while let Some((middle, half_width, pairs)) = open.pop_front() {
            let interval = Interval { middle, half_width, pairs: (0, 0) };
            self.look_at(a, b, &interval, scratch, 1.0);
            let mut doubtful = Vec::new();
            for index in pairs {
                let pair = &self.pairs[index as usize];
                let travel = travel_of(pair, scratch) + ROUNDING_M;
                let bar = |least: f64| least - CLEARANCE_TOLERANCE_M + travel;
                if self.quick_bound(pair, &scratch.frames, bar(least)) >= bar(least) {
                    continue;
                }
                let gap = self.distance(pair, &scratch.frames, least.max(bar(least)));
                least = least.min(gap.lower_m);
                if least <= 0.0 {
                    return 0.0;
                }
                if gap.lower_m < bar(least) {
                    doubtful.push(index);
                }
            }
            if !doubtful.is_empty() && half_width > f64::EPSILON {
                let quarter = half_width * 0.5;
                open.push_back((middle - quarter, quarter, doubtful.clone()));
                open.push_back((middle + quarter, quarter, doubtful));
            }
        }
        (least - CLEARANCE_TOLERANCE_M).max(0.0)
    }

    /// Frames at the middle of the interval, and how far everything can move within it.
    fn look_at(&self, a: &[f64], b: &[f64], interval: &Interval, scratch: &mut Scratch, factor: f64) {
        for (q, (a, b)) in scratch.q.iter_mut().zip(a.iter().zip(b)) {
            *q = a + (b - a) * interval.middle;
        }
        self.robot().forward_kinematics(&scratch.q, &mut scratch.frames);
        scratch.travel.update(
            self.robot(),
            &self.bodies,
            &scratch.frames,
            &scratch.slope,
            interval.half_width,
            factor,
        );
    }
}

fn travel_of(pair: &Pair, scratch: &Scratch) -> f64 {
    match pair.second {
        Other::Part(_) => scratch.travel.of(pair.first),
        Other::Link { body, shared_joints } => scratch.travel.between(pair.first, body, shared_joints),
    }
}
