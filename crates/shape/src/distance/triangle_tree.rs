use cranny_spatial::{Point, Vector};
use parry3d_f64::bounding_volume::{Aabb as ParryAabb, BoundingVolume as _};
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy, BvhNode};
use parry3d_f64::query::{Ray, RayCast as _};

use crate::bound::{Aabb, Ball};
use crate::distance::parry;

/// A bounding volume hierarchy over triangles.
#[derive(Clone, Debug)]
pub(crate) struct TriangleTree {
    tree: Bvh,
}

impl TriangleTree {
    pub fn new(corners: &[[Point; 3]]) -> Self {
        Self::of_boxes(corners.iter().map(|triangle| Aabb::around(triangle, 0.0)))
    }

    /// A hierarchy over boxes, for [`Self::near`].
    pub fn of_boxes(boxes: impl Iterator<Item = Aabb>) -> Self {
        let leaves: Vec<ParryAabb> = boxes.map(|aabb| parry_box(&aabb)).collect();
        Self { tree: Bvh::from_leaves(BvhBuildStrategy::Binned, &leaves) }
    }

    /// Indices of the triangles whose boxes meet `region`, in a fixed order.
    pub fn near(&self, region: &Aabb) -> impl Iterator<Item = u32> {
        let region = BvhNode::leaf(parry_box(region), 0);
        self.tree.leaves(move |node| node.intersects(&region))
    }

    /// Calls `visit` with triangles and the current reach, in metres: at first `reach_m`, then the value that the last
    /// call returned. Visits those in balls that `gap_m` puts within the reach, mostly the nearest first.
    pub fn nearest(&self, gap_m: impl Fn(&Ball) -> f64, reach_m: f64, visit: impl Fn(u32, f64) -> f64) {
        let of_node = |node: &BvhNode, _| {
            let center = Point::from(parry::to_vector(node.center()));
            let radius_m = 0.5 * (node.maxs() - node.mins()).length();
            // NaN does not count as far.
            gap_m(&Ball { center, radius_m }).max(f64::MIN)
        };
        self.tree.find_best(reach_m, of_node, |triangle, reach_m| Some(visit(triangle, reach_m)));
    }

    /// Triangles whose boxes a segment meets, and possibly some whose boxes it passes within rounding.
    pub fn along_segment(&self, from: &Point, to: &Point) -> impl Iterator<Item = u32> {
        let ray = Ray::new(parry::point(from), parry::vector(&(to - from)));
        let rounding_m = 1e-12 * from.coords.amax().max(to.coords.amax());
        let grown = move |node: &BvhNode| node.aabb().loosened(rounding_m);
        self.tree.leaves(move |node| grown(node).cast_local_ray(&ray, 1.0, true).is_some())
    }

    /// Distance from the point beyond which there is no triangle, in metres; `None` if the point lies outside the box
    /// around all triangles.
    pub fn reach_from(&self, point: &Point) -> Option<f64> {
        let around = self.tree.root_aabb();
        let size_m = (around.maxs - around.mins).length();
        around.contains_local_point(parry::point(point)).then_some(2.0 * size_m)
    }

    /// Calls `visit` with each triangle whose box a ray meets within `reach_m`, in a fixed order.
    pub fn along_ray(&self, origin: &Point, direction: &Vector, reach_m: f64, mut visit: impl FnMut(u32)) {
        let slabs = RaySlabs::new(origin, direction, reach_m);
        for triangle in self.tree.leaves(|node| slabs.meet(node)) {
            visit(triangle);
        }
    }
}

/// Test of boxes against one ray, by the parameters at which it passes their faces.
struct RaySlabs {
    origin: [f64; 3],
    inverse: [f64; 3],
    reach_m: f64,
}

/// Reciprocal of a component of a direction that is 0: large, but 0 times it is 0.
const PARALLEL: f64 = 1e300;

impl RaySlabs {
    fn new(origin: &Point, direction: &Vector, reach_m: f64) -> Self {
        let inverse = |along: f64| if along.abs() * PARALLEL < 1.0 { PARALLEL } else { along.recip() };
        Self { origin: origin.coords.into(), inverse: direction.map(inverse).into(), reach_m }
    }

    /// Returns true if the ray meets the box of a node within its reach, and possibly if it passes it within rounding.
    fn meet(&self, node: &BvhNode) -> bool {
        let (low, high) = (node.mins().to_array(), node.maxs().to_array());
        let (mut from, mut to) = (0.0_f64, self.reach_m);
        for axis in 0..3 {
            let [a, b] = [low[axis], high[axis]].map(|face| (face - self.origin[axis]) * self.inverse[axis]);
            from = from.max(a.min(b));
            // Three roundings (Ize 2013, "Robust BVH ray traversal", whole).
            to = to.min(a.max(b) * (1.0 + 4.0 * f64::EPSILON));
        }
        from <= to
    }
}

fn parry_box(aabb: &Aabb) -> ParryAabb {
    let vector = |v: Vector| parry::vector(&v);
    ParryAabb { mins: vector(aabb.low().coords), maxs: vector(aabb.high().coords) }
}
