use cranny_collision::{Cell, NearestPair};
use serde::Serialize;

/// Pair whose distance limits the clearance of a path, and the margin that applies to it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ClearanceLimit {
    /// Name of a link.
    pub first: String,
    /// Name of another link, or of a body.
    pub second: String,
    /// Minimum distance of the pair that counts as free, in metres.
    pub required_m: f64,
    /// Margin that applies to the pair.
    pub margin: AppliedMargin,
}

/// One of the two margins of a problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum AppliedMargin {
    /// [`Margins::margin_m`](cranny_collision::Margins::margin_m).
    Margin,
    /// [`Margins::grasp_margin_m`](cranny_collision::Margins::grasp_margin_m): for a link of the hand against the object it
    /// grasps, or against the support of that object.
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
