use cranny_robot::{Hold, JointKind};
use cranny_spatial::{Pose, ROUNDING_M};

use crate::cell::{Cell, Scratch};
use crate::contact::Contact;
use crate::link_body::{LinkBody, group_separation};
use crate::pairs::{Other, Pair};

/// How the fingers of a hand meet what is between them.
#[derive(Clone, Debug, PartialEq)]
pub struct Closing {
    /// How far the hand has closed when the first finger touches, from 0, open, to 1.
    pub closing: f64,
    /// How much farther the finger that touches last would have to go, in metres of its own way.
    pub uneven_m: f64,
}

/// Fingers that are nearer touch, in metres.
const TOUCHING_M: f64 = 1e-5;

/// Steps of a finger towards what it meets: each is as long as the distance left.
const MOST_STEPS: usize = 1000;

impl Cell {
    /// Closes the fingers, from open, on what the hand holds: each until it touches; `None` if one of them touches
    /// nothing, or there is no finger, or nothing in the hand. How far the hand of the cell is closed does not enter.
    pub fn close_on_held(&self) -> Option<Closing> {
        let held = self.held.as_ref()?;
        let thing = self.bodies.iter().rfind(|body| Some(body.link) == self.robot().held_link())?;
        let tip_from_held = held.hold.tip_from_held;
        let things: Vec<_> = thing.shapes.iter().map(|(pose, solid)| (tip_from_held * pose, solid)).collect();
        let mut touches: Vec<(f64, f64)> = Vec::new();
        for (finger, (_, stroke)) in self.robot().finger_strokes().enumerate() {
            let own = |body: &&LinkBody| self.robot().finger_of(body.link) == Some(finger);
            let bodies: Vec<&LinkBody> = self.bodies.iter().filter(own).collect();
            let reach = bodies.iter().map(|body| self.finger_reach(body)).fold(0.0, f64::max);
            let way_m = stroke * reach;
            let mut closing = 0.0;
            for _ in 0..MOST_STEPS {
                let hold = Hold { closing, ..held.hold };
                let mut gap_m = f64::INFINITY;
                for body in &bodies {
                    let tip_from_link = self.tip_from_finger_link(body.link, finger, &hold)?;
                    let placed = body.shapes.iter().map(|(pose, solid)| (tip_from_link * pose, solid));
                    gap_m = gap_m.min(group_separation(placed, &things.iter().copied(), way_m).lower_m);
                }
                if gap_m < TOUCHING_M {
                    touches.push((closing, way_m));
                    break;
                }
                closing += gap_m / way_m;
                if closing > 1.0 {
                    return None;
                }
            }
        }
        let first = touches.iter().map(|(closing, _)| *closing).fold(f64::INFINITY, f64::min);
        let uneven_m = touches.iter().map(|(closing, way_m)| (closing - first) * way_m).fold(0.0, f64::max);
        (touches.len() == self.robot().finger_strokes().count() && !touches.is_empty())
            .then_some(Closing { closing: first, uneven_m })
    }

    /// What the fingers meet, other than what the hand holds, while it closes from open to where the cell has it, the arm
    /// at `q`; `None` if that is proven to be nothing. What cannot be decided counts as met.
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn closing_contact(&self, q: &[f64], scratch: &mut Scratch) -> Option<Contact> {
        let held = self.held.as_ref()?;
        let is_of_finger = |body: usize| self.robot().is_of_finger(self.bodies[body].link);
        let is_swept = |pair: &Pair| {
            let is_second = matches!(pair.second, Other::Link { body, .. } if is_of_finger(body));
            !pair.is_exempt() && (is_of_finger(pair.first) || is_second)
        };
        let pairs: Vec<Pair> = self.pairs.iter().filter(is_swept).collect();
        let travel_of = |pair: &Pair, share: f64| {
            let of_body = |body: usize| {
                let link = &self.bodies[body];
                let finger = self.robot().finger_of(link.link);
                let stroke = finger.and_then(|finger| self.robot().finger_strokes().nth(finger));
                stroke.map_or(0.0, |(_, stroke)| stroke * self.finger_reach(link) * share)
            };
            let second = match pair.second {
                Other::Link { body, .. } => of_body(body),
                Other::Part(_) => 0.0,
            };
            of_body(pair.first) + second + ROUNDING_M
        };
        let half = 0.5 * held.hold.closing;
        let mut open = vec![(half, half, pairs)];
        while let Some((middle, half_width, pairs)) = open.pop() {
            self.robot().place_held(&Hold { closing: middle, ..held.hold }, &mut scratch.frames);
            self.robot().forward_kinematics(q, &mut scratch.frames);
            let mut doubtful = Vec::new();
            for pair in pairs {
                let travel_m = travel_of(&pair, half_width);
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

    /// How far any point of a finger moves at most for a unit of its joint: 1 where it slides, in metres where it turns.
    fn finger_reach(&self, body: &LinkBody) -> f64 {
        let Some(finger) = self.robot().finger_of(body.link) else { return 0.0 };
        match self.robot().finger_strokes().nth(finger) {
            Some((JointKind::Revolute, _)) => {
                // From the origin of the link right below the joint, through which its axis runs.
                let Some(link) = self.robot().loose_links().nth(finger) else { return 0.0 };
                let rest = self.robot().frames();
                let finger_from_body = rest.link(link).inverse() * rest.link(body.link);
                (finger_from_body * body.bounds.ball.center).coords.norm() + body.bounds.ball.radius_m
            }
            _ => 1.0,
        }
    }

    /// Where a link of a finger stands in the frame of the tip.
    fn tip_from_finger_link(&self, link: usize, finger: usize, hold: &Hold) -> Option<Pose> {
        let tip_from_finger = self.robot().tip_from_loose(hold).nth(finger)?;
        let finger_link = self.robot().loose_links().nth(finger)?;
        let rest = self.robot().frames();
        Some(tip_from_finger * rest.link(finger_link).inverse() * rest.link(link))
    }
}

/// As in a proof of a motion, in metres.
const RESOLUTION_M: f64 = 1e-6;
