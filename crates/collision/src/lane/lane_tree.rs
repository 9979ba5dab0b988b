use cranny_spatial::Vector;

use crate::body::part_tree::PartNode;
use crate::lane::lane_part::LaneAabb;

/// A node of the [`PartTree`](crate::body::part_tree::PartTree) in lane form.
#[derive(Clone, Debug)]
pub(crate) struct LaneBranch {
    /// Box around all its parts; `None` where it would not help.
    pub around: Option<LaneAabb>,
    /// Positions of its parts; an empty range for a node that is not a leaf.
    pub begin: u32,
    pub end: u32,
    /// Next node if this one is skipped.
    pub next: usize,
}

impl LaneBranch {
    pub fn of(node: &PartNode) -> Self {
        /// Upper bound on the shift of a face by rounding to `f32`, relative to its distance from the origin.
        const OVERHANG: f64 = 2e-6;
        let around = node.aabb.as_ref().map(|aabb| {
            let farthest_m = aabb.center.coords.abs() + aabb.half_extents;
            let grown = aabb.half_extents + (farthest_m + Vector::repeat(1.0)) * OVERHANG;
            LaneAabb::new(&aabb.center.coords, &grown)
        });
        let [begin, end] = [node.places.start, node.places.end].map(|p| u32::try_from(p).unwrap_or(u32::MAX));
        Self { around, begin, end, next: node.next }
    }
}
