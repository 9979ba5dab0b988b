use cranny_spatial::CONTACT_M;

use crate::body::link_body::{LinkBody, group_separation};
use crate::body::world::Part;
use crate::cell::Cell;
use crate::touch::contact::{Collider, Contact};

#[cfg(doc)]
use crate::UncheckedReason;

/// Distances between the world and the links that no joint moves, in metres, as certified lower bounds; infinite without pairs.
/// No proof of a motion compares these pairs, but an error in the placement of the robot or the object changes their distances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StandingClearance {
    /// Distance from all bodies except the object to be grasped.
    pub around_m: f64,
    /// Distance from the object to be grasped, as long as it is not held.
    pub object_m: f64,
}

impl Cell {
    /// Returns the distances between the links that no joint moves and every part of the world except those that they touch:
    /// each answer lists these ([`UncheckedReason::NeverMoves`]).
    pub fn standing_clearance(&self) -> StandingClearance {
        let mut least = StandingClearance { around_m: f64::INFINITY, object_m: f64::INFINITY };
        for (still, body, part) in self.standing_pairs() {
            let known = if self.is_target(body) { &mut least.object_m } else { &mut least.around_m };
            *known = self.standing_distance_m(still, part, *known).map_or(*known, |found| found.min(*known));
        }
        least
    }

    /// Returns the contact of a link that no joint moves with the object to be grasped, if it is closer than the uncertainty of
    /// the object allows ([`Margins::object_margin_m`](crate::Margins::object_margin_m)); `None` without uncertainty.
    pub fn standing_contact(&self) -> Option<Contact> {
        if self.margins.object_margin_m <= 0.0 {
            return None;
        }
        let required_m = self.margins.of_held_m();
        let mut of_target = self.standing_pairs().filter(|(_, body, _)| self.is_target(*body));
        of_target.find_map(|(still, body, part)| {
            let clearance_m = self.standing_distance_m(still, part, required_m)?;
            (clearance_m < required_m).then_some(Contact {
                first: Collider::Link(still.link),
                second: Collider::Body(body),
                clearance_m,
                required_m,
                depth_m: 0.0,
                point: None,
            })
        })
    }

    /// Returns true if a body of the world is to be grasped, and is not held.
    fn is_target(&self, body: usize) -> bool {
        self.held.is_none() && self.grasp_bodies.last() == Some(&body)
    }

    /// Returns every link that no joint moves, with every part of the world that is not held, and the index of its body.
    fn standing_pairs(&self) -> impl Iterator<Item = (&LinkBody, usize, &Part)> {
        let held = self.held.as_ref().map(|held| held.body);
        let still = self.bodies.iter().filter(|body| self.robot.ancestors(body.link).is_empty());
        still.flat_map(move |still| {
            let parts = self.parts().iter().filter(move |(body, _)| Some(*body) != held);
            parts.map(move |(body, part)| (still, *body, part))
        })
    }

    /// Returns the distance of a link and a part, in metres, as a certified lower bound; `None` if they touch, or are at least
    /// `beyond_m` (m) apart.
    fn standing_distance_m(&self, still: &LinkBody, part: &Part, beyond_m: f64) -> Option<f64> {
        let frames = self.robot.frames();
        if still.quick_bound_to(frames.link(still.link), part, beyond_m) >= beyond_m {
            return None;
        }
        let placed = std::iter::once((part.world_from_solid, &part.solid));
        let distance_m = group_separation(still.placed(&frames), &placed, beyond_m).lower_m;
        (distance_m >= CONTACT_M).then_some(distance_m)
    }
}
