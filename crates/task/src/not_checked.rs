use cranny_collision::{CONTACT_ALLOWANCE_M, Cell, UncheckedReason};
use serde::{Deserialize, Serialize};
use strum::IntoStaticStr;

/// Two things, by name, that are not compared by any check or proof, or only up to an allowance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NotChecked {
    /// Name of a link.
    pub first: String,
    /// Name of another link or of a body.
    pub second: String,
    /// Smallest penetration depth found, in metres.
    pub depth_m: f64,
    /// Reason why the pair is not compared.
    pub reason: NotCheckedReason,
    /// The allowed contact of an object with its support.
    #[serde(flatten, default, skip_serializing_if = "Option::is_none")]
    pub contact: Option<AllowedContact>,
}

/// A contact that is allowed along a segment of a path.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AllowedContact {
    /// Mode of the segment.
    pub segment: ContactSegment,
    /// Proven upper bound of the depth, in metres.
    pub allowance_m: f64,
}

/// Segment of a path along which an object may touch its support.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, IntoStaticStr)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum ContactSegment {
    /// Lift-off from the initial support.
    LiftOff,
    /// Set-down on the new support.
    SetDown,
}

/// Reason why two things are not compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum NotCheckedReason {
    /// Two links, proven to touch at every value of the joints between them.
    AlwaysTouching,
    /// Two adjacent links, proven to touch at every value of their joint.
    AdjacentTouching,
    /// Two adjacent links that touch, or nearly do, at all sampled values of their joint.
    AdjacentUnproven,
    /// Two adjacent links that are free at some values of their joint and touch at others: proven only near its axis.
    AdjacentAtJoint,
    /// Two adjacent links, proven to touch at no value of their joint: only their distance is ignored.
    AdjacentFree,
    /// A link that no joint moves, with the body on which it stands.
    NeverMoves,
    /// A held object, with the faces of its support.
    Resting,
}

impl NotChecked {
    /// Returns true if this pair is an exception to "free" and "proven"; false for adjacent links proven never to touch.
    pub fn is_exception(&self) -> bool {
        self.reason != NotCheckedReason::AdjacentFree
    }

    /// Returns true if `--strict-pairs` removes this exception by checking the pair.
    pub fn can_be_checked(&self) -> bool {
        matches!(self.reason, NotCheckedReason::AlwaysTouching | NotCheckedReason::AdjacentAtJoint)
    }

    /// Returns the pairs that a cell does not check.
    pub fn of(cell: &Cell) -> Vec<Self> {
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
                UncheckedReason::Resting => NotCheckedReason::Resting,
            },
            contact: None,
        });
        named.collect()
    }

    /// Returns the counts of unchecked pairs and of allowed contacts in words ("1 pair that is not checked"); `None` for none.
    pub fn summary(not_checked: &[Self]) -> Option<String> {
        let contacts = not_checked.iter().filter(|pair| pair.contact.is_some()).count();
        let counted = |count: usize, one: &str, more: &str| match count {
            0 => None,
            1 => Some(format!("1 {one}")),
            _ => Some(format!("{count} {more}")),
        };
        let pairs = not_checked.iter().filter(|pair| pair.is_exception()).count() - contacts;
        let pairs = counted(pairs, "pair that is not checked", "pairs that are not checked");
        let contacts = counted(contacts, "allowed contact", "allowed contacts");
        pairs.into_iter().chain(contacts).reduce(|pairs, contacts| format!("{pairs} and {contacts}"))
    }

    /// Returns this pair along a segment of a path.
    #[must_use]
    pub fn along(self, segment: ContactSegment) -> Self {
        let is_contact = self.reason == NotCheckedReason::Resting;
        let contact = AllowedContact { segment, allowance_m: CONTACT_ALLOWANCE_M };
        Self { contact: is_contact.then_some(contact), ..self }
    }
}
