use cranny_collision::{Cell, UncheckedReason};
use serde::{Deserialize, Serialize};

/// Two things that are compared by no check and no proof, by name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NotChecked {
    /// A link.
    pub first: String,
    /// Another link, or a body.
    pub second: String,
    /// How deep they are in each other: the least that was seen, in metres.
    pub depth_m: f64,
    /// Why they are not compared.
    pub reason: NotCheckedReason,
}

/// Why two things are not compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum NotCheckedReason {
    /// Two links, proven to touch at every value of the joints between them.
    AlwaysTouching,
    /// Two adjacent links, proven to touch at every value of their joint.
    AdjacentTouching,
    /// Two adjacent links that touch, or nearly do, at all values of their joint that were looked at.
    AdjacentUnproven,
    /// Two adjacent links that are free at some values of their joint, and touch at others: near the joint alone, as far as
    /// it was looked at.
    AdjacentAtJoint,
    /// Two adjacent links, proven to touch at no value of their joint: only their distance counts for nothing.
    AdjacentFree,
    /// A link that no joint moves, on what it stands on.
    NeverMoves,
}

impl NotChecked {
    /// Whether "free" and "proven" hold but for this pair. They hold for adjacent links that are proven never to touch.
    pub fn is_exception(&self) -> bool {
        self.reason != NotCheckedReason::AdjacentFree
    }

    pub(crate) fn of(cell: &Cell) -> Vec<Self> {
        let named = cell.unchecked().iter().map(|unchecked| Self {
            first: cell.name(unchecked.first).to_owned(),
            second: cell.name(unchecked.second).to_owned(),
            depth_m: unchecked.depth_m,
            reason: match unchecked.reason {
                UncheckedReason::AlwaysTouching => NotCheckedReason::AlwaysTouching,
                UncheckedReason::AdjacentTouching => NotCheckedReason::AdjacentTouching,
                UncheckedReason::AdjacentUnproven => NotCheckedReason::AdjacentUnproven,
                UncheckedReason::AdjacentAtJoint => NotCheckedReason::AdjacentAtJoint,
                UncheckedReason::AdjacentFree => NotCheckedReason::AdjacentFree,
                UncheckedReason::NeverMoves => NotCheckedReason::NeverMoves,
            },
        });
        named.collect()
    }
}
