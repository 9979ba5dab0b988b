use cranny_spatial::{Point, Pose, Vector};

use crate::distance::closest::pieces_near;
use crate::distance::convex::Convex;
use crate::distance::gjk::core_points;
use crate::solid::Kind;
use crate::{Solid, distance::parry, overlap, separation};

/// Margin beyond the distance found within which triangles are searched, in metres.
const SLACK_M: f64 = 1e-5;

/// Signed distance of two solids, with the motion that changes it.
///
/// Its derivative along a rigid motion is `normal · (v_a − v_b)`, where `v_a` and `v_b` are the velocities of `on_a` and `on_b`
/// as points of the two solids, wherever the distance is differentiable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SignedDistance {
    /// Distance, in metres: a certified lower bound where the solids are apart, minus the depth of [`overlap`] where they
    /// overlap.
    pub distance_m: f64,
    /// Closest point of the first solid, or one in the overlap, in the common frame.
    pub on_a: Point,
    /// Closest point of the second solid, or one in the overlap, in the common frame.
    pub on_b: Point,
    /// Unit vector from the second solid to the first, in the common frame: the direction in which the first one moves away.
    pub normal: Vector,
}

impl SignedDistance {
    fn exchanged(self) -> Self {
        Self { on_a: self.on_b, on_b: self.on_a, normal: -self.normal, ..self }
    }
}

/// Signed distance of two solids with poses in a common frame; `None` if it exceeds `beyond_m` (m), for two half-spaces, and if
/// no direction separates the two.
pub fn signed_distance(
    a: &Solid,
    common_from_a: &Pose,
    b: &Solid,
    common_from_b: &Pose,
    beyond_m: f64,
) -> Option<SignedDistance> {
    match (a.kind(), b.kind()) {
        (Kind::HalfSpace, Kind::HalfSpace) => None,
        (Kind::HalfSpace, _) => {
            above_plane(b, common_from_b, common_from_a, beyond_m).map(SignedDistance::exchanged)
        }
        (_, Kind::HalfSpace) => above_plane(a, common_from_a, common_from_b, beyond_m),
        (Kind::Convex(one), Kind::Convex(other)) => {
            let a_from_b = common_from_a.inv_mul(common_from_b);
            let apart = match apart(one, other, &a_from_b, beyond_m) {
                Apart::By(distance) => in_common_frame(distance, common_from_a),
                Apart::Beyond => return None,
                Apart::Overlap => overlapping(a, common_from_a, b, common_from_b)?,
            };
            Some(apart).filter(|found| found.distance_m <= beyond_m)
        }
        _ => {
            let gap = separation(a, common_from_a, b, common_from_b, beyond_m);
            if gap.lower_m <= 0.0 {
                return overlapping(a, common_from_a, b, common_from_b);
            }
            if gap.lower_m >= beyond_m || !gap.upper_m.is_finite() {
                return None;
            }
            let reach_m = gap.upper_m + SLACK_M;
            let a_from_b = common_from_a.inv_mul(common_from_b);
            let of_a = pieces_near(a, &b.aabb().transformed(&a_from_b).grown(reach_m));
            let of_b = pieces_near(b, &a.aabb().transformed(&a_from_b.inverse()).grown(reach_m));
            let pairs = of_a.iter().flat_map(|one| of_b.iter().map(move |other| (one, other)));
            let found = pairs.filter_map(|(one, other)| match apart(one, other, &a_from_b, reach_m) {
                Apart::By(distance) => Some(distance),
                Apart::Beyond | Apart::Overlap => None,
            });
            let nearest = found.min_by(|m, n| m.distance_m.total_cmp(&n.distance_m))?;
            Some(in_common_frame(nearest, common_from_a))
        }
    }
}

fn in_common_frame(found: SignedDistance, common_from_a: &Pose) -> SignedDistance {
    SignedDistance {
        distance_m: found.distance_m,
        on_a: common_from_a * found.on_a,
        on_b: common_from_a * found.on_b,
        normal: common_from_a.rotation * found.normal,
    }
}

/// Result for two convex solids whose cores may be apart.
enum Apart {
    /// Signed distance, in the frame of the first; negative if only the roundings overlap.
    By(SignedDistance),
    /// The distance exceeds the limit.
    Beyond,
    /// The cores overlap.
    Overlap,
}

fn apart(a: &Convex, b: &Convex, a_from_b: &Pose, beyond_m: f64) -> Apart {
    let radii = a.radius_m + b.radius_m;
    let found = core_points(&a.core, &b.core, &parry::pose(a_from_b), beyond_m + radii);
    if found.lower_m - radii >= beyond_m {
        return Apart::Beyond;
    }
    let [on_a, on_b] = found.way.map(parry::to_vector);
    let Some(away) = (on_a - on_b).try_normalize(0.0).filter(|_| found.lower_m > 0.0) else {
        return Apart::Overlap;
    };
    Apart::By(SignedDistance {
        distance_m: found.lower_m - radii,
        on_a: (on_a - away * a.radius_m).into(),
        on_b: (on_b + away * b.radius_m).into(),
        normal: away,
    })
}

fn overlapping(a: &Solid, common_from_a: &Pose, b: &Solid, common_from_b: &Pose) -> Option<SignedDistance> {
    let found = overlap(a, common_from_a, b, common_from_b)?;
    let between_middles = || common_from_a * a.ball().center - common_from_b * b.ball().center;
    let normal = found.way_out.map(|way_out| -way_out);
    let normal = normal.or_else(|| between_middles().try_normalize(0.0))?;
    // The motion of a point of the overlap along the normal does not depend on its place along the normal.
    Some(SignedDistance { distance_m: 0.0 - found.depth_m, on_a: found.point, on_b: found.point, normal })
}

/// Height of the lowest point of a solid over a plane, with the plane as the second solid.
fn above_plane(
    solid: &Solid,
    common_from_solid: &Pose,
    common_from_plane: &Pose,
    beyond_m: f64,
) -> Option<SignedDistance> {
    let plane_from_solid = common_from_plane.inv_mul(common_from_solid);
    let distance_m = solid.lowest_z(&plane_from_solid);
    if distance_m > beyond_m {
        return None;
    }
    let down_in_solid = plane_from_solid.rotation.inverse_transform_vector(&-Vector::z());
    let lowest_in_solid = match solid.kind() {
        Kind::Mesh(mesh) => {
            let depth = |vertex: &Point| vertex.coords.dot(&down_in_solid);
            mesh.vertices().max_by(|m, n| depth(m).total_cmp(&depth(n)))
        }
        _ => solid.support_point(&down_in_solid),
    };
    let lowest = plane_from_solid * lowest_in_solid?;
    let foot = Point::new(lowest.x, lowest.y, 0.0);
    Some(SignedDistance {
        distance_m,
        on_a: common_from_plane * lowest,
        on_b: common_from_plane * foot,
        normal: common_from_plane.rotation * Vector::z(),
    })
}
