use crate::cell::Cell;
use crate::pair::pairs::{Other, Pair};

/// Collision pairs that one kind of error moves against each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PairGroup {
    /// Links against links.
    Links,
    /// Links and the held object against the world except the object to be grasped.
    Around,
    /// The object to be grasped against the links; once it is held, against all that it may not touch.
    Object,
}

impl Cell {
    pub(crate) fn group_of(&self, pair: &Pair) -> PairGroup {
        let is_held =
            |body: usize| self.held.is_some() && self.robot.held_link() == Some(self.bodies[body].link);
        let is_target = |part: usize| self.grasp_bodies.last() == Some(&self.parts()[part].0);
        match pair.second {
            _ if is_held(pair.first) => PairGroup::Object,
            Other::Link { body, .. } if is_held(body) => PairGroup::Object,
            Other::Link { .. } => PairGroup::Links,
            Other::Part(part) if self.held.is_none() && is_target(part) => PairGroup::Object,
            Other::Part(_) => PairGroup::Around,
        }
    }
}
