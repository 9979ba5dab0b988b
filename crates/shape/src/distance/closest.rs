use std::borrow::Cow;

use cranny_spatial::{Point, Pose, Vector};

use crate::distance::convex::Convex;
use crate::distance::gjk::core_distance;
use crate::solid::Kind;
use crate::{Aabb, Range, Solid, distance::parry, separation};

/// Margin beyond the distance found within which triangles are searched, in metres: above the error at which the iteration
/// stalls on curved faces.
const SLACK_M: f64 = 1e-5;

/// Closest points of two solids with poses in a common frame, in that frame, accurate to about the contact tolerance; `None` if
/// the solids touch.
///
/// For display only: use [`separation`] for certified distances.
pub fn closest_points(
    a: &Solid,
    common_from_a: &Pose,
    b: &Solid,
    common_from_b: &Pose,
) -> Option<[Point; 2]> {
    match (a.kind(), b.kind()) {
        (Kind::HalfSpace, Kind::HalfSpace) => None,
        (Kind::HalfSpace, _) => above_plane(b, common_from_b, common_from_a).map(|[on_b, foot]| [foot, on_b]),
        (_, Kind::HalfSpace) => above_plane(a, common_from_a, common_from_b),
        _ => {
            let gap = separation(a, common_from_a, b, common_from_b, f64::MAX);
            if gap.lower_m <= 0.0 {
                return None;
            }
            let reach_m = gap.upper_m + SLACK_M;
            let a_from_b = common_from_a.inv_mul(common_from_b);
            let of_a = pieces_near(a, &b.aabb().transformed(&a_from_b).grown(reach_m));
            let of_b = pieces_near(b, &a.aabb().transformed(&a_from_b.inverse()).grown(reach_m));
            let pairs = of_a.iter().flat_map(|one| of_b.iter().map(move |other| (one, other)));
            let [on_a, on_b] = pairs
                .filter_map(|(one, other)| convex_points(one, other, &a_from_b))
                .min_by(|m, n| (m[1] - m[0]).norm_squared().total_cmp(&(n[1] - n[0]).norm_squared()))?;
            Some([common_from_a * on_a, common_from_a * on_b])
        }
    }
}

/// Convex pieces of a solid that meet a box in its frame.
pub(crate) fn pieces_near<'a>(solid: &'a Solid, region: &Aabb) -> Vec<Cow<'a, Convex>> {
    match solid.kind() {
        Kind::Convex(convex) => vec![Cow::Borrowed(convex)],
        Kind::Mesh(mesh) => {
            let triangle = |index: u32| Cow::Borrowed(&mesh.triangles()[index as usize]);
            mesh.triangles_near(region).into_iter().map(triangle).collect()
        }
        Kind::Union(union) => union.pieces_near(region).into_iter().map(Cow::Owned).collect(),
        Kind::HalfSpace => Vec::new(),
    }
}

/// Closest points of two convex solids, both in the frame of the first.
fn convex_points(a: &Convex, b: &Convex, a_from_b: &Pose) -> Option<[Point; 2]> {
    let found = core_distance(&a.core, &b.core, &parry::pose(a_from_b), Range::to(f64::MAX));
    let [on_a, on_b] = found.way.map(parry::to_vector);
    let direction: Vector = (on_b - on_a).try_normalize(0.0)?;
    Some([(on_a + direction * a.radius_m).into(), (on_b - direction * b.radius_m).into()])
}

/// Lowest point of a solid above a plane, and its projection onto the plane, both in the common frame.
fn above_plane(solid: &Solid, common_from_solid: &Pose, common_from_plane: &Pose) -> Option<[Point; 2]> {
    let plane_from_solid = common_from_plane.inv_mul(common_from_solid);
    let down_in_solid = plane_from_solid.rotation.inverse_transform_vector(&-Vector::z());
    let lowest_in_solid = match solid.kind() {
        Kind::Mesh(mesh) => {
            let height = |vertex: &Point| vertex.coords.dot(&down_in_solid);
            mesh.vertices().max_by(|m, n| height(m).total_cmp(&height(n)))
        }
        _ => solid.support_point(&down_in_solid),
    };
    let lowest = plane_from_solid * lowest_in_solid?;
    let foot = Point::new(lowest.x, lowest.y, 0.0);
    (lowest.z > 0.0).then(|| [common_from_plane * lowest, common_from_plane * foot])
}
