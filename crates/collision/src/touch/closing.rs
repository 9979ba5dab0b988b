use std::collections::VecDeque;

use cranny_robot::Hold;
use cranny_spatial::{Pose, ROUNDING_M};

use crate::body::link_body::{LinkBody, group_separation};
use crate::cell::{Cell, Scratch};
use crate::pair::pair_group::PairGroup;
use crate::pair::pairs::{Other, Pair};
use crate::touch::contact::Contact;

/// Result of closing the fingers on an object.
#[derive(Clone, Debug, PartialEq)]
pub struct Closing {
    /// Closing of the hand at which the first finger touches, from 0, open, to 1.
    pub closing: f64,
    /// Travel of the pad of the finger that touches last, after the first one touches, in metres.
    pub uneven_m: f64,
    /// Fraction of its travel, from 0, open, to 1, at which each finger touches, by finger index.
    pub touching: Vec<f64>,
    /// Link of a finger that touches the object before any pad of that finger does.
    pub beside: Option<usize>,
}

/// Distance below which a finger touches, in metres.
const TOUCHING_M: f64 = 1e-5;

/// Maximum number of advances of a finger towards the object, each by the remaining distance.
const MOST_STEPS: usize = 1000;

impl Cell {
    /// Closes each finger, from open, until it touches the held object. `None` if a finger touches nothing, or there is no
    /// finger, or nothing is held. The closing of the cell's hand has no influence.
    pub fn close_on_held(&self) -> Option<Closing> {
        let held = self.held.as_ref()?;
        let thing = self.bodies.iter().rfind(|body| Some(body.link) == self.robot().held_link())?;
        let tip_from_held = held.hold.tip_from_held;
        let things: Vec<_> = thing.shapes.iter().map(|(pose, solid)| (tip_from_held * pose, solid)).collect();
        let mut touching: Vec<f64> = Vec::new();
        let mut beside = None;
        let hand = self.robot().hand()?;
        let fingers = hand.fingers;
        for finger in 0..fingers {
            let own = |body: &&LinkBody| self.robot().finger_of(body.link) == Some(finger);
            let bodies: Vec<&LinkBody> = self.bodies.iter().filter(own).collect();
            let way_m = self.finger_travel_m(finger);
            let mut closing = 0.0;
            for _ in 0..MOST_STEPS {
                let hold = Hold { closing, ..held.hold };
                let (mut gap_m, mut pad_gap_m, mut nearest) = (f64::INFINITY, f64::INFINITY, None);
                let tip_from_loose = self.robot().tip_from_loose(&hold);
                for body in &bodies {
                    let tip_from_link = self.tip_from_finger_link(body.link, &tip_from_loose)?;
                    let placed = body.shapes.iter().map(|(pose, solid)| (tip_from_link * pose, solid));
                    let own_m = group_separation(placed, &things.iter().copied(), way_m).lower_m;
                    if self.robot().bears_pad(body.link) {
                        pad_gap_m = own_m.min(pad_gap_m);
                    }
                    if own_m < gap_m {
                        (gap_m, nearest) = (own_m, Some(body.link));
                    }
                }
                if gap_m < TOUCHING_M {
                    touching.push(closing);
                    beside = beside.or(nearest.filter(|_| pad_gap_m >= TOUCHING_M));
                    break;
                }
                closing += gap_m / way_m;
                if closing > 1.0 {
                    return None;
                }
            }
        }
        let first = touching.iter().copied().fold(f64::INFINITY, f64::min);
        let further =
            touching.iter().enumerate().map(|(finger, last)| hand.pads.travel_m(finger, [first, *last]));
        let uneven_m = further.fold(0.0, f64::max);
        let is_whole = touching.len() == fingers && !touching.is_empty();
        is_whole.then_some(Closing { closing: first, uneven_m, touching, beside })
    }

    /// Returns the links with geometry of a finger, by index, each with its pose in the frame of the tip when the hand has
    /// closed by a fraction of its travel; empty if nothing is held.
    pub fn finger_at(&self, finger: usize, closing: f64) -> Vec<(usize, Pose)> {
        let Some(held) = &self.held else { return Vec::new() };
        let tip_from_loose = self.robot().tip_from_loose(&Hold { closing, ..held.hold });
        let links = self.bodies.iter().map(|body| body.link);
        let own = links.filter(|link| self.robot().finger_of(*link) == Some(finger));
        own.filter_map(|link| Some((link, self.tip_from_finger_link(link, &tip_from_loose)?))).collect()
    }

    /// Returns an upper bound on the motion of any point of a finger while the hand closes from open, in metres.
    pub fn finger_travel_m(&self, finger: usize) -> f64 {
        let own = self.bodies.iter().filter(|body| self.robot().finger_of(body.link) == Some(finger));
        own.map(|body| self.closing_motion_bound_m(body)).fold(0.0, f64::max)
    }

    /// Returns the contact of the fingers, other than with the held object, while the hand closes from open to the closing of
    /// the cell, the arm at `q` (m, rad; one per joint); `None` if there is certainly none. Undecided cases count as contact.
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn closing_contact(&self, q: &[f64], scratch: &mut Scratch) -> Option<Contact> {
        let closing = self.held.as_ref()?.hold.closing;
        let fingers = self.robot().hand().map_or(0, |hand| hand.fingers);
        self.closing_contact_each(q, &vec![closing; fingers], scratch)
    }

    /// Returns the contact of [`Self::closing_contact`], the arm at `q` (m, rad; one per joint), while each finger closes from
    /// open by its own fraction of its travel (`touching`, one per finger, from 0 to 1) and stops there. All fingers close at
    /// the same rate. The motion bound of a closing finger also covers a stopped one.
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn closing_contact_each(
        &self,
        q: &[f64],
        touching: &[f64],
        scratch: &mut Scratch,
    ) -> Option<Contact> {
        let held = self.held.as_ref()?;
        let pairs = self.swept_pairs().collect();
        let half = 0.5 * touching.iter().copied().fold(0.0, f64::max);
        let mut open = vec![(half, half, pairs)];
        while let Some((middle, half_width, pairs)) = open.pop() {
            let closings: Vec<f64> = touching.iter().map(|touching| middle.min(*touching)).collect();
            self.robot().place_fingers(held.hold.tip_from_held, &closings, &mut scratch.frames);
            self.robot().forward_kinematics(q, &mut scratch.frames);
            let mut doubtful = Vec::new();
            for pair in pairs {
                let travel_m = self.swept_m(&pair, half_width);
                let needed_m = pair.required_m + travel_m;
                if self.quick_bound(&pair, &scratch.frames, needed_m) > needed_m {
                    continue;
                }
                let gap = self.distance(&pair, &scratch.frames, needed_m);
                if gap.lower_m >= needed_m {
                    continue;
                }
                if gap.upper_m <= pair.required_m || travel_m < RESOLUTION_M {
                    let contact = self.describe(&pair, &scratch.frames);
                    self.robot().place_held(&held.hold, &mut scratch.frames);
                    return Some(contact);
                }
                doubtful.push(pair);
            }
            if !doubtful.is_empty() {
                let half_width = 0.5 * half_width;
                open.push((middle + half_width, half_width, doubtful.clone()));
                open.push((middle - half_width, half_width, doubtful));
            }
        }
        self.robot().place_held(&held.hold, &mut scratch.frames);
        None
    }

    /// Returns the least distance of a group of pairs, fingers against all but the held object, while the hand closes from open
    /// to the closing of the cell, or opens from there, the arm at `q` (m, rad; one per joint), in metres: a certified lower
    /// bound, at most 10 µm too low; infinite if there is no such pair.
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn closing_clearance(&self, q: &[f64], group: PairGroup, scratch: &mut Scratch) -> f64 {
        let Some(held) = &self.held else { return f64::INFINITY };
        let pairs: Vec<Pair> = self.swept_pairs().filter(|pair| self.group_of(pair) == group).collect();
        let mut least_m = f64::INFINITY;
        let half = 0.5 * held.hold.closing;
        let mut open = VecDeque::from([(half, half, pairs)]);
        while let Some((middle, half_width, pairs)) = open.pop_front().filter(|_| least_m > 0.0) {
            self.robot().place_held(&Hold { closing: middle, ..held.hold }, &mut scratch.frames);
            self.robot().forward_kinematics(q, &mut scratch.frames);
            let mut doubtful = Vec::new();
            for pair in pairs {
                // The interval is done for pairs that are at least this far apart in its middle.
                let bar_m = |least_m: f64| least_m - SWEEP_TOLERANCE_M + self.swept_m(&pair, half_width);
                if self.quick_bound(&pair, &scratch.frames, bar_m(least_m)) >= bar_m(least_m) {
                    continue;
                }
                let gap = self.distance(&pair, &scratch.frames, least_m.max(bar_m(least_m)));
                least_m = least_m.min(gap.lower_m);
                if gap.lower_m < bar_m(least_m) {
                    doubtful.push(pair);
                }
            }
            if !doubtful.is_empty() && half_width > f64::EPSILON {
                let half_width = 0.5 * half_width;
                open.push_back((middle - half_width, half_width, doubtful.clone()));
                open.push_back((middle + half_width, half_width, doubtful));
            }
        }
        self.robot().place_held(&held.hold, &mut scratch.frames);
        (least_m - SWEEP_TOLERANCE_M).max(0.0)
    }

    /// Returns the pairs that involve a finger, without the held object and the parts that it may touch.
    fn swept_pairs(&self) -> impl Iterator<Item = Pair> {
        let is_of_finger = |body: usize| self.robot().is_of_finger(self.bodies[body].link);
        self.pairs.iter().filter(move |pair| {
            let is_second = matches!(pair.second, Other::Link { body, .. } if is_of_finger(body));
            !pair.is_exempt() && (is_of_finger(pair.first) || is_second)
        })
    }

    /// Returns an upper bound on the approach of a pair while the hand closes by a fraction of its travel, in metres.
    fn swept_m(&self, pair: &Pair, share: f64) -> f64 {
        let of_body = |body: usize| self.closing_motion_bound_m(&self.bodies[body]) * share;
        let second = match pair.second {
            Other::Link { body, .. } => of_body(body),
            Other::Part(_) => 0.0,
        };
        of_body(pair.first) + second + ROUNDING_M
    }

    /// Returns an upper bound on the motion of any point of a link while the hand closes from open, in metres.
    pub(crate) fn closing_motion_bound_m(&self, body: &LinkBody) -> f64 {
        let ball = &body.bounds.ball;
        self.robot().closing_motion_bound_m(body.link, (ball.center, ball.radius_m))
    }

    /// Returns the pose of a link of a finger in the frame of the tip, for given poses of the loose links.
    fn tip_from_finger_link(&self, link: usize, tip_from_loose: &[Pose]) -> Option<Pose> {
        let robot = self.robot();
        let mut above = std::iter::successors(Some(link), |&link| robot.links()[link].parent);
        let slot_of = |link: usize| robot.loose_links().position(|loose| loose == link);
        let (slot, loose) = above.find_map(|link| Some((slot_of(link)?, link)))?;
        let rest = robot.frames();
        Some(tip_from_loose[slot] * rest.link(loose).inverse() * rest.link(link))
    }
}

/// Maximum amount by which the measured clearance of a closing motion is below the true one, in metres.
const SWEEP_TOLERANCE_M: f64 = 1e-5;

/// Travel below which bisection ends, as in a proof of a motion, in metres.
const RESOLUTION_M: f64 = 1e-6;
