use std::sync::Arc;

use cranny_robot::Robot;
use cranny_shape::overlap;
use cranny_spatial::CONTACT_M;

use crate::cell::{Cell, Scratch};
use crate::contact::Collider;
use crate::link_body::{LinkBody, group_separation};
use crate::world::Part;

/// Two things that touch, and that no check and no proof compares: whoever says "free" or "proven" names them.
///
/// Pairs that are exempt by declaration (adjacent links, those of an SRDF) are not among them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unchecked {
    /// A link.
    pub first: Collider,
    /// Another link, or a body of the world.
    pub second: Collider,
    /// How deep they are in each other: the least that was seen, in metres.
    pub depth_m: f64,
    /// Why they are not compared.
    pub reason: UncheckedReason,
}

/// Why two things that touch are not compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UncheckedReason {
    /// Two links that touch in every configuration that was looked at: a robot without a list of the pairs that may
    /// touch could not start otherwise.
    AlwaysTouching,
    /// A link that no joint moves, on what it stands on.
    NeverMoves,
}

impl Unchecked {
    pub(crate) fn always_touching(bodies: &[LinkBody], pairs: &[((usize, usize), f64)]) -> Vec<Self> {
        let of_pair = |&((first, second), depth_m): &((usize, usize), f64)| Self {
            first: Collider::Link(bodies[first].link),
            second: Collider::Link(bodies[second].link),
            depth_m,
            reason: UncheckedReason::AlwaysTouching,
        };
        pairs.iter().map(of_pair).collect()
    }

    /// Links that no joint moves, in contact with bodies of the world.
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

    /// The two links, the lower index first, if this is a pair of links that may yet be checked.
    fn links(&self) -> Option<(usize, usize)> {
        match (self.first, self.second) {
            (Collider::Link(a), Collider::Link(b)) => Some((a.min(b), a.max(b))),
            _ => None,
        }
    }
}

impl Cell {
    /// What touches and is not checked.
    pub fn unchecked(&self) -> &[Unchecked] {
        &self.unchecked
    }

    /// Those pairs of links of [`Self::unchecked`] that keep their distance at `q`: seen free once, a pair is to be
    /// checked from then on. By link index, the lower first.
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn unchecked_but_free_at(&self, q: &[f64], scratch: &mut Scratch) -> Vec<(usize, usize)> {
        if self.unchecked.is_empty() {
            return Vec::new();
        }
        self.robot().forward_kinematics(q, &mut scratch.frames);
        let frames = &scratch.frames;
        let body_of = |link: usize| self.bodies.iter().find(|body| body.link == link);
        let is_free = |&(first, second): &(usize, usize)| {
            let (Some(first), Some(second)) = (body_of(first), body_of(second)) else { return false };
            let required_m = self.margins().required_m(false);
            let gap = group_separation(first.placed(frames), &second.placed(frames), required_m);
            gap.lower_m >= required_m
        };
        self.unchecked.iter().filter_map(Unchecked::links).filter(is_free).collect()
    }

    /// The same cell with all pairs of links checked but those that are exempt by declaration.
    #[must_use]
    pub fn with_all_pairs(&self) -> Self {
        self.with_pairs(&self.unchecked.iter().filter_map(Unchecked::links).collect::<Vec<_>>())
    }

    /// This cell, or one in which every pair is checked that is free at one of these configurations.
    ///
    /// # Panics
    /// If a configuration has not one value per joint.
    #[must_use]
    pub fn with_pairs_free_at<'a>(
        self: &Arc<Self>,
        configurations: impl IntoIterator<Item = &'a [f64]>,
    ) -> Arc<Self> {
        let mut cell = self.clone();
        let mut scratch = None;
        for q in configurations {
            if cell.unchecked.iter().all(|unchecked| unchecked.links().is_none()) {
                break;
            }
            let scratch = scratch.get_or_insert_with(|| self.scratch());
            let free = cell.unchecked_but_free_at(q, scratch);
            if !free.is_empty() {
                cell = Arc::new(cell.with_pairs(&free));
            }
        }
        cell
    }
}
