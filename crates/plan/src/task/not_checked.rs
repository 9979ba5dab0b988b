use cranny_collision::{Cell, UncheckedReason};
use serde::{Deserialize, Serialize};

/// Two things that touch and are compared by no check and no proof, by name: "proven" is said of a path but for these.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
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
    /// Two links that touch in every configuration that was checked.
    AlwaysTouching,
    /// A link that no joint moves, on what it stands on.
    NeverMoves,
}

impl NotChecked {
    pub(crate) fn of(cell: &Cell) -> Vec<Self> {
        let named = cell.unchecked().iter().map(|unchecked| Self {
            first: cell.name(unchecked.first).to_owned(),
            second: cell.name(unchecked.second).to_owned(),
            depth_m: unchecked.depth_m,
            reason: match unchecked.reason {
                UncheckedReason::AlwaysTouching => NotCheckedReason::AlwaysTouching,
                UncheckedReason::NeverMoves => NotCheckedReason::NeverMoves,
            },
        });
        named.collect()
    }
}
