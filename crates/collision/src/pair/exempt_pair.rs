use cranny_robot::Robot;
use cranny_shape::overlap;
use cranny_spatial::CONTACT_M;

use crate::body::held_body::Spared;
use crate::body::link_body::{LinkBody, group_separation};
use crate::body::world::Part;
use crate::touch::contact::Collider;

/// A pair that no check and no proof compares, or only up to an allowance; each answer names it.
///
/// Pairs that are exempt by declaration (in an SRDF, or by the caller) are not included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExemptPair {
    /// A link.
    pub first: Collider,
    /// Another link, or a body of the world.
    pub second: Collider,
    /// Least penetration depth found, in metres.
    pub depth_m: f64,
    /// Reason for the exemption.
    pub reason: UncheckedReason,
}

/// Reason why a pair is not compared. Links are adjacent if no third link with geometry is between them, and one joint moves
/// them relative to each other ([`Robot::adjacent_pairs`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UncheckedReason {
    /// Two links, proven to touch at every value of the joints between them: no motion changes this.
    AlwaysTouching,
    /// Two adjacent links, proven to touch at every value of their joint.
    AdjacentTouching,
    /// Two adjacent links of which nothing is proven: they touch, or nearly touch, at all sampled values.
    AdjacentUnproven,
    /// Two adjacent links that are free at some values of their joint, and proven to touch only near its axis at the others.
    AdjacentAtJoint,
    /// Two adjacent links, proven to touch at no value of their joint. No margin and no clearance includes their distance.
    AdjacentFree,
    /// A link that no joint moves, and its support.
    NeverMoves,
    /// The held object and its support face before the lift-off or after the set-down. It may penetrate the face by at most
    /// [`CONTACT_ALLOWANCE_M`](crate::CONTACT_ALLOWANCE_M). `depth_m` is the depth at rest.
    Resting,
}

/// Reason why a pair is not compared, with the least depth found (m).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Exempt {
    pub reason: UncheckedReason,
    pub depth_m: f64,
}

/// A pair that is not compared, as indices among the links with geometry, with its exemption.
pub(crate) type ExemptIndices = ((usize, usize), Exempt);

impl UncheckedReason {
    /// Returns true if the pair was found free at no value of its joint; if it were checked, no configuration would be free.
    pub(crate) fn is_never_free(self) -> bool {
        matches!(self, Self::AdjacentTouching | Self::AdjacentUnproven)
    }
}

impl ExemptPair {
    pub(crate) fn of_links(bodies: &[LinkBody], pairs: &[ExemptIndices]) -> Vec<Self> {
        let of_pair = |&((first, second), exempt): &ExemptIndices| Self {
            first: Collider::Link(bodies[first].link),
            second: Collider::Link(bodies[second].link),
            depth_m: exempt.depth_m,
            reason: exempt.reason,
        };
        pairs.iter().map(of_pair).collect()
    }

    /// Finds the links that no joint moves and that are in contact with bodies of the world.
    pub(crate) fn still_in_contact(robot: &Robot, bodies: &[LinkBody], parts: &[(usize, Part)]) -> Vec<Self> {
        let frames = robot.frames();
        let mut found: Vec<Self> = Vec::new();
        for still in bodies.iter().filter(|body| robot.ancestors(body.link).is_empty()) {
            for (body, part) in parts {
                if still.quick_bound_to(frames.link(still.link), part, CONTACT_M) > CONTACT_M {
                    continue;
                }
                let placed = std::iter::once((part.world_from_solid, &part.solid));
                if group_separation(still.placed(&frames), &placed, CONTACT_M).lower_m >= CONTACT_M {
                    continue;
                }
                let depths = still.placed(&frames).filter_map(|(pose, solid)| {
                    overlap(solid, &pose, &part.solid, &part.world_from_solid).map(|overlap| overlap.depth_m)
                });
                let depth_m = depths.fold(0.0, f64::max);
                let (first, second) = (Collider::Link(still.link), Collider::Body(*body));
                match found.iter_mut().find(|known| (known.first, known.second) == (first, second)) {
                    Some(known) => known.depth_m = known.depth_m.max(depth_m),
                    None => {
                        found.push(Self { first, second, depth_m, reason: UncheckedReason::NeverMoves });
                    }
                }
            }
        }
        found
    }

    /// Returns the pairs of the held object with the bodies on which it may rest.
    pub(crate) fn resting(held_link: usize, spared: &[Spared], parts: &[(usize, Part)]) -> Vec<Self> {
        let mut found: Vec<Self> = Vec::new();
        for &Spared { part, depth_m } in spared {
            let (first, second) = (Collider::Link(held_link), Collider::Body(parts[part].0));
            match found.iter_mut().find(|known| known.second == second) {
                Some(known) => known.depth_m = known.depth_m.max(depth_m),
                None => found.push(Self { first, second, depth_m, reason: UncheckedReason::Resting }),
            }
        }
        found
    }

    /// Returns the two links, the lower index first, if this pair of links can still be checked.
    pub(crate) fn links(&self) -> Option<(usize, usize)> {
        match (self.first, self.second) {
            (Collider::Link(a), Collider::Link(b)) => Some((a.min(b), a.max(b))),
            _ => None,
        }
    }
}
