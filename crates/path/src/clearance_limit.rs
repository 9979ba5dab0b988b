use cranny_collision::{Cell, NearestPair};
use serde::Serialize;

/// The two things whose distance limits the clearance of a path, and the margin that applies to them.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ClearanceLimit {
    /// A link.
    pub first: String,
    /// Another link, or a body.
    pub second: String,
    /// The least distance of the two that counts as free, in metres.
    pub required_m: f64,
    /// The margin that applies to them.
    pub margin: AppliedMargin,
}

/// One of the two margins of a problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum AppliedMargin {
    /// [`Margins::margin_m`](cranny_collision::Margins::margin_m).
    Margin,
    /// [`Margins::grasp_margin_m`](cranny_collision::Margins::grasp_margin_m): a link of the hand against what it grasps,
    /// or what carries that.
    GraspMargin,
}

impl ClearanceLimit {
    pub(crate) fn of(cell: &Cell, nearest: &NearestPair) -> Self {
        let NearestPair { first, second, required_m, has_grasp_margin } = *nearest;
        let [first, second] = [first, second].map(|collider| cell.name(collider).to_owned());
        let margin = if has_grasp_margin { AppliedMargin::GraspMargin } else { AppliedMargin::Margin };
        Self { first, second, required_m, margin }
    }
}
