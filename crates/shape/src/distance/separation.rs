use std::cell::Cell;

use cranny_spatial::{Point, Pose, Vector};
use parry3d_f64::math::{Pose as ParryPose, Vector as ParryVector};
use parry3d_f64::query::details::contact_support_map_support_map;
use parry3d_f64::shape::SupportMap;

use crate::distance::convex::Convex;
use crate::distance::gjk::{core_distance, core_reaches};
use crate::mesh::Mesh;
use crate::solid::Kind;
use crate::{Aabb, Ball, BoxUnion, Range, Solid, distance::parry};

/// Bounds of the distance of two solids: `lower_m ≤ distance ≤ upper_m`.
///
/// A plane between the two solids certifies the lower bound, a point of each the upper one, so both are valid even if the
/// iteration that found them failed. Unless the search stopped early they agree to better than 10⁻⁷ m
/// (`both_bounds_meet_where_contact_is_decided`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Separation {
    /// Lower bound of the distance, in metres; 0 in contact.
    pub lower_m: f64,
    /// Upper bound of the distance, in metres; infinite if the search stopped early.
    pub upper_m: f64,
}

impl Separation {
    const CONTACT: Self = Self { lower_m: 0.0, upper_m: 0.0 };

    fn least(self, other: Self) -> Self {
        Self { lower_m: self.lower_m.min(other.lower_m), upper_m: self.upper_m.min(other.upper_m) }
    }
}

/// Overlap of two solids.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overlap {
    /// Distance by which one must move to separate the two, in metres, ≥ 0. Exact for two convex solids; for a mesh the largest
    /// depth of any of its triangles.
    pub depth_m: f64,
    /// A point in the overlap, in the common frame.
    pub point: Point,
    /// Unit vector in the common frame along which the second solid moves by the depth to separate the two; `None` if unknown.
    pub way_out: Option<Vector>,
}

impl Overlap {
    /// Returns this overlap with the two solids exchanged.
    fn exchanged(self) -> Self {
        Self { way_out: self.way_out.map(|way_out| -way_out), ..self }
    }
}

/// Distance of two solids with poses in a common frame: [`separation_in`] all distances up to `beyond_m`, in metres.
pub fn separation(
    a: &Solid,
    common_from_a: &Pose,
    b: &Solid,
    common_from_b: &Pose,
    beyond_m: f64,
) -> Separation {
    separation_in(a, common_from_a, b, common_from_b, Range::to(beyond_m))
}

/// Distance of two solids with poses in a common frame, as exact as `range` requires.
///
/// With an infinite `exact_below_m`, `lower_m ≥ beyond_m` exactly if the distance is certified to reach `beyond_m`. Otherwise
/// `lower_m ≥ exact_below_m` exactly if it is certified to reach the lesser of the two. Solids are full: one inside the other
/// is in contact.
pub fn separation_in(
    a: &Solid,
    common_from_a: &Pose,
    b: &Solid,
    common_from_b: &Pose,
    range: Range,
) -> Separation {
    match (a.kind(), b.kind()) {
        (Kind::HalfSpace, Kind::HalfSpace) => Separation::CONTACT,
        (Kind::HalfSpace, _) => above_plane(b, &common_from_a.inv_mul(common_from_b)),
        (_, Kind::HalfSpace) => above_plane(a, &common_from_b.inv_mul(common_from_a)),
        (Kind::Union(union), _) => union_separation(union, b, &common_from_a.inv_mul(common_from_b), range),
        (_, Kind::Union(union)) => union_separation(union, a, &common_from_b.inv_mul(common_from_a), range),
        (Kind::Convex(one), Kind::Convex(other)) => {
            convex_separation(one, other, &parry::pose(&common_from_a.inv_mul(common_from_b)), range)
        }
        (Kind::Mesh(mesh), Kind::Convex(convex)) => {
            mesh_convex_separation(mesh, convex, b.aabb(), &common_from_a.inv_mul(common_from_b), range)
        }
        (Kind::Convex(convex), Kind::Mesh(mesh)) => {
            mesh_convex_separation(mesh, convex, a.aabb(), &common_from_b.inv_mul(common_from_a), range)
        }
        (Kind::Mesh(one), Kind::Mesh(other)) => {
            mesh_mesh_separation(one, other, &common_from_a.inv_mul(common_from_b), range.beyond_m)
        }
    }
}

/// Returns true if the distance of two solids with poses in a common frame is certified to reach `distance_m` (m, above 0).
/// Agrees with `lower_m ≥ distance_m` of [`separation`], in less time if the distance is shorter.
pub fn reaches(a: &Solid, common_from_a: &Pose, b: &Solid, common_from_b: &Pose, distance_m: f64) -> bool {
    match (a.kind(), b.kind()) {
        (Kind::Convex(one), Kind::Convex(other)) => {
            let relative = parry::pose(&common_from_a.inv_mul(common_from_b));
            core_reaches(&one.core, &other.core, &relative, distance_m + (one.radius_m + other.radius_m))
        }
        _ => separation(a, common_from_a, b, common_from_b, distance_m).lower_m >= distance_m,
    }
}

/// Lower bound of the distance (m) from balls and boxes alone, for a few multiplications; may be negative. Skips the
/// boxes if the balls show that the distance exceeds `enough_m`.
pub fn quick_lower_bound(
    a: &Solid,
    common_from_a: &Pose,
    b: &Solid,
    common_from_b: &Pose,
    enough_m: f64,
) -> f64 {
    if a.is_half_space() {
        return (common_from_a.inv_mul(common_from_b) * b.ball().center).z - b.ball().radius_m;
    }
    if b.is_half_space() {
        return (common_from_b.inv_mul(common_from_a) * a.ball().center).z - a.ball().radius_m;
    }
    a.bounds().distance_bound(common_from_a, b.bounds(), common_from_b, enough_m)
}

/// Depth and location of the overlap of two solids; `None` if they do not overlap.
pub fn overlap(a: &Solid, common_from_a: &Pose, b: &Solid, common_from_b: &Pose) -> Option<Overlap> {
    match (a.kind(), b.kind()) {
        (Kind::HalfSpace, Kind::HalfSpace) => None,
        (Kind::HalfSpace, _) => below_plane(b, common_from_a, common_from_b),
        (_, Kind::HalfSpace) => below_plane(a, common_from_b, common_from_a).map(Overlap::exchanged),
        (Kind::Union(union), _) => union_overlap(union, common_from_a, b, common_from_b),
        (_, Kind::Union(union)) => {
            union_overlap(union, common_from_b, a, common_from_a).map(Overlap::exchanged)
        }
        (Kind::Convex(one), Kind::Convex(other)) => convex_overlap(one, common_from_a, other, common_from_b),
        (Kind::Mesh(mesh), Kind::Convex(convex)) => {
            mesh_overlap(mesh, common_from_a, &[convex.as_ref()], common_from_b)
        }
        (Kind::Convex(convex), Kind::Mesh(mesh)) => {
            mesh_overlap(mesh, common_from_b, &[convex.as_ref()], common_from_a).map(Overlap::exchanged)
        }
        (Kind::Mesh(one), Kind::Mesh(other)) => {
            let triangles: Vec<&Convex> = other.triangles().iter().collect();
            mesh_overlap(one, common_from_a, &triangles, common_from_b).or_else(|| {
                let triangles: Vec<&Convex> = one.triangles().iter().collect();
                mesh_overlap(other, common_from_b, &triangles, common_from_a).map(Overlap::exchanged)
            })
        }
    }
}

fn above_plane(solid: &Solid, plane_from_solid: &Pose) -> Separation {
    let height = solid.lowest_z(plane_from_solid).max(0.0);
    Separation { lower_m: height, upper_m: height }
}

fn below_plane(solid: &Solid, common_from_plane: &Pose, common_from_solid: &Pose) -> Option<Overlap> {
    let plane_from_solid = common_from_plane.inv_mul(common_from_solid);
    let depth_m = -solid.lowest_z(&plane_from_solid);
    let mut foot = plane_from_solid * solid.ball().center;
    foot.z = 0.0;
    let way_out = Some(common_from_plane.rotation * Vector::z());
    (depth_m >= 0.0).then(|| Overlap { depth_m, point: common_from_plane * foot, way_out })
}

fn convex_separation(a: &Convex, b: &Convex, a_from_b: &ParryPose, range: Range) -> Separation {
    let radii = a.radius_m + b.radius_m;
    let found = core_distance(&a.core, &b.core, a_from_b, range.grown(radii));
    Separation { lower_m: (found.lower_m - radii).max(0.0), upper_m: (found.upper_m - radii).max(0.0) }
}

fn mesh_convex_separation(
    mesh: &Mesh,
    convex: &Convex,
    convex_box: &Aabb,
    mesh_from_convex: &Pose,
    range: Range,
) -> Separation {
    let relative = parry::pose(mesh_from_convex);
    // 1. The mesh is at least as far as the hull of its vertices.
    let around =
        mesh.hull().map(|hull| core_distance(hull, &convex.core, &relative, range.grown(convex.radius_m)));
    let bound_m = around.map_or(0.0, |around| around.lower_m - convex.radius_m);
    if bound_m >= range.beyond_m.min(range.exact_below_m) {
        return Separation { lower_m: bound_m, upper_m: f64::INFINITY };
    }
    // 2. A convex solid wholly inside touches no triangle.
    if bound_m <= 0.0 && mesh.contains(&(mesh_from_convex * some_point(convex))) {
        return Separation::CONTACT;
    }
    // 3. The search for the nearest triangle ends at the least distance measured.
    let best = Cell::new(Separation { lower_m: range.beyond_m, upper_m: f64::INFINITY });
    let gap_m = |ball: &Ball| {
        convex_box.distance_to(&mesh_from_convex.inverse_transform_point(&ball.center)) - ball.radius_m
    };
    mesh.nearest_triangles(gap_m, range.beyond_m, |index, reach_m| {
        let nearer = Range { beyond_m: reach_m, ..range };
        let found = convex_separation(&mesh.triangles()[index as usize], convex, &relative, nearer);
        best.set(best.get().least(found));
        let upper_m = best.get().upper_m;
        if upper_m <= bound_m + ENOUGH_M { f64::MIN } else { range.reach_m(upper_m) }
    });
    // Triangles that were not visited are at least as far as the reach, or the hull.
    let Separation { lower_m, upper_m } = best.get();
    if upper_m <= 0.0 {
        return Separation::CONTACT;
    }
    let lower_m = lower_m.min(range.reach_m(upper_m));
    Separation { lower_m: if upper_m <= bound_m + ENOUGH_M { bound_m.max(0.0) } else { lower_m }, upper_m }
}

/// Difference of two bounds below which they count as equal, in metres.
const ENOUGH_M: f64 = 1e-9;

fn mesh_mesh_separation(a: &Mesh, b: &Mesh, a_from_b: &Pose, beyond_m: f64) -> Separation {
    let b_from_a = a_from_b.inverse();
    if b.witnesses().iter().any(|point| a.contains(&(a_from_b * point)))
        || a.witnesses().iter().any(|point| b.contains(&(b_from_a * point)))
    {
        return Separation::CONTACT;
    }
    let relative = parry::pose(a_from_b);
    let first = convex_separation(&a.triangles()[0], &b.triangles()[0], &relative, Range::to(beyond_m));
    let mut best = Separation { lower_m: beyond_m.min(first.upper_m), upper_m: first.upper_m };
    for triangle_b in b.triangles() {
        let reach = best.upper_m.min(beyond_m);
        let region = Aabb::around(&triangle_b.bounding_points(), 0.0).transformed(a_from_b).grown(reach);
        for index in a.triangles_near(&region) {
            let pair =
                convex_separation(&a.triangles()[index as usize], triangle_b, &relative, Range::to(reach));
            best = best.least(pair);
        }
        if best.upper_m <= 0.0 {
            return Separation::CONTACT;
        }
    }
    best
}

/// Distance of a union from a solid that is no half-space.
fn union_separation(union: &BoxUnion, other: &Solid, union_from_other: &Pose, range: Range) -> Separation {
    let best = Cell::new(Separation { lower_m: range.beyond_m, upper_m: f64::INFINITY });
    let Ball { center, radius_m } = other.ball();
    let ball = Ball { center: union_from_other * center, radius_m: *radius_m };
    let turn = union_from_other.rotation.to_rotation_matrix();
    let gap_m = |aabb: &Aabb| aabb.gap_to_turned(other.aabb(), union_from_other, &turn);
    let origin = Pose::identity();
    union.nearest(&ball, gap_m, range.beyond_m, |aabb| {
        let nearer = Range { beyond_m: range.reach_m(best.get().upper_m), ..range };
        let piece = Solid::convex(union.piece(aabb));
        best.set(best.get().least(separation_in(&piece, &origin, other, union_from_other, nearer)));
        range.reach_m(best.get().upper_m)
    });
    // Boxes that were not visited are at least as far as the reach.
    let Separation { lower_m, upper_m } = best.get();
    if upper_m <= 0.0 {
        return Separation::CONTACT;
    }
    Separation { lower_m: lower_m.min(range.reach_m(upper_m)), upper_m }
}

fn union_overlap(
    union: &BoxUnion,
    common_from_union: &Pose,
    other: &Solid,
    common_from_other: &Pose,
) -> Option<Overlap> {
    let region = other.aabb().transformed(&common_from_union.inv_mul(common_from_other));
    let overlaps = union
        .pieces_near(&region)
        .into_iter()
        .filter_map(|piece| overlap(&Solid::convex(piece), common_from_union, other, common_from_other));
    overlaps.max_by(|a, b| a.depth_m.total_cmp(&b.depth_m))
}

fn convex_overlap(a: &Convex, common_from_a: &Pose, b: &Convex, common_from_b: &Pose) -> Option<Overlap> {
    let radii = a.radius_m + b.radius_m;
    let relative = parry::pose(&common_from_a.inv_mul(common_from_b));
    // Solids that lie apart have no depth, even if the search for the deepest point returned one.
    if core_reaches(&a.core, &b.core, &relative, radii.next_up()) {
        return None;
    }
    let contact = contact_support_map_support_map(&relative, &a.core, &b.core, radii)?;
    // The depth is at most that along the normal found, measured on both solids: moved by this distance, they are apart.
    let direction = contact.normal1;
    let far_on_a = a.core.local_support_point(direction);
    let near_on_b = relative.rotation * b.core.local_support_point(relative.rotation.inverse() * -direction)
        + relative.translation;
    let depth_m = radii + direction.dot(far_on_a - near_on_b).min(-contact.dist);
    let normal = parry::to_vector(direction);
    let on_a = parry::to_vector(contact.point1) + normal * a.radius_m;
    let middle: Vector = on_a - normal * (0.5 * depth_m);
    let way_out = Some(common_from_a.rotation * normal);
    (depth_m >= 0.0).then(|| Overlap { depth_m, point: common_from_a * Point::from(middle), way_out })
}

fn mesh_overlap(
    mesh: &Mesh,
    common_from_mesh: &Pose,
    parts: &[&Convex],
    common_from_parts: &Pose,
) -> Option<Overlap> {
    let mesh_from_parts = common_from_mesh.inv_mul(common_from_parts);
    let mut deepest: Option<Overlap> = None;
    for part in parts {
        let region = Aabb::around(&part.bounding_points(), part.radius_m).transformed(&mesh_from_parts);
        for index in mesh.triangles_near(&region) {
            let triangle = &mesh.triangles()[index as usize];
            let found = convex_overlap(triangle, common_from_mesh, part, common_from_parts);
            if found.is_some_and(|f| deepest.is_none_or(|d| f.depth_m > d.depth_m)) {
                deepest = found;
            }
        }
        let point = mesh_from_parts * some_point(part);
        if deepest.is_none() && mesh.contains(&point) {
            // The convex solid is wholly inside, and at least as deep as that point.
            let depth_m = mesh
                .triangles()
                .iter()
                .map(|triangle| {
                    let probe = Convex::sharp(crate::distance::convex::Core::Point);
                    let at = parry::pose(&Pose::translation(point.x, point.y, point.z));
                    convex_separation(triangle, &probe, &at, Range::to(f64::MAX)).upper_m
                })
                .fold(f64::INFINITY, f64::min);
            deepest = Some(Overlap { depth_m, point: common_from_mesh * point, way_out: None });
        }
    }
    deepest
}

/// Any point of the solid, in its frame.
fn some_point(convex: &Convex) -> Point {
    parry::to_vector(convex.core.local_support_point(ParryVector::X)).into()
}
