use cranny_robot::LinkFrames;
use cranny_shape::Solid;
use cranny_spatial::Pose;

use crate::cell::Cell;
use crate::pair::pairs::{Other, Pair};

/// A pair that every check and every proof compares, and the distance that it must keep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DemandedPair {
    /// Index of a link.
    pub link: usize,
    /// Another link, or a part of the world.
    pub other: DemandedOther,
    /// Distance that counts as free, in metres; `None` for a part that the link may touch.
    pub required_m: Option<f64>,
}

/// Second member of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DemandedOther {
    /// Index of a link.
    Link(usize),
    /// Index of a part of the world, in the order of [`Cell::parts`].
    Part(usize),
}

impl Cell {
    /// Returns all pairs that are compared.
    pub fn demanded_pairs(&self) -> Vec<DemandedPair> {
        let demanded = |pair: Pair| DemandedPair {
            link: self.bodies[pair.first].link,
            other: match pair.second {
                Other::Link { body, .. } => DemandedOther::Link(self.bodies[body].link),
                Other::Part(part) => DemandedOther::Part(part),
            },
            required_m: (!pair.is_exempt()).then_some(pair.required_m),
        };
        self.pairs.iter().map(demanded).collect()
    }

    /// Returns frames of the robot, with its fingers and the held object where they are in this cell.
    pub fn frames(&self) -> LinkFrames {
        self.scratch().frames
    }

    /// Returns the solids of a link that are compared, each with its pose in the frame of the link.
    pub fn solids_of(&self, link: usize) -> &[(Pose, Solid)] {
        self.bodies.iter().find(|body| body.link == link).map_or(&[], |body| &body.shapes)
    }
}
