use cranny_shape::{Solid, closest_points};
use cranny_spatial::{CONTACT_M, Point, Pose, Rotation, Vector};

use crate::body::extent::{Extent, ONE_NORMAL, greatest_normals, is_flat, is_round};
use crate::body::link_body::group_separation;
use crate::body::world::Part;
use crate::touch::contact_patch::{Across, Overlap, OverlapCorner, PlanePoint, Seen, distance_to_hull};

/// A body with its first solid at a pose.
#[derive(Clone, Copy)]
pub(crate) struct SupportedObject<'a> {
    pub extent: &'a Extent,
    pub world_from_held: &'a Pose,
    /// Its solids, at their poses there.
    pub placed: &'a [(Pose, &'a Solid)],
}

/// A face of a part below a body: a plane perpendicular to the part's normal at their contact, above which the body lies.
#[derive(Clone, Debug)]
pub(crate) struct Face {
    /// Outward normal, a unit vector.
    pub direction: Vector,
    /// Height of the plane along the direction, in metres.
    pub top_m: f64,
    /// Height of the lowest point of the body above the plane, in metres.
    pub separation_m: f64,
    /// Least height of the body above the part in their overlaps, along the direction, in metres.
    pub gap_m: f64,
    /// Regions in which the body is above the part by at most [`REACH_M`].
    overlaps: Vec<Overlap>,
    across: Across,
}

/// Maximum depth of a body in its support face, in metres: stated poses and sizes are rounded.
pub const CONTACT_ALLOWANCE_M: f64 = 1e-4;

/// Maximum height of a resting body above its support, in metres: objects in the paper's release float up to 1.8 mm.
pub(crate) const MOST_GAP_M: f64 = 2e-3;
/// Maximum excess of the gap of a further part over that of the nearest one if the body needs its support, in metres, measured
/// at points of the body's convex hull. The body may be slightly tilted, and a round one coarse (the centre of a ball of 27
/// corners in the paper's release is over corners 1.7 mm above the ground).
pub(crate) const UNEVEN_M: f64 = 1.8e-3;
/// Resolution, as in a proof of a motion, in metres.
pub(crate) const RESOLUTION_M: f64 = 1e-6;
/// Distance below a body beyond which a part supports nothing, in metres.
const REACH_M: f64 = MOST_GAP_M + UNEVEN_M;
/// Least cosine of the angle between a face's normal and the vertical: on steeper faces most objects slide.
const STEEPEST: f64 = std::f64::consts::FRAC_1_SQRT_2;
/// Cosine to the direction of a face below which triangles of a part are its sides.
const SIDE: f64 = 0.01;
/// Maximum number of tried directions of a part, and of a body.
const MOST_DIRECTIONS: usize = 12;
/// Tolerance for equal heights and equal points of a part, in metres: rounding.
const SAME_M: f64 = 2e-6;

impl Face {
    /// Returns the face by which a part may support a body: of the possible faces, the one whose contact regions are nearest to
    /// the body's centre of mass, as seen along gravity.
    pub fn below(supported: SupportedObject<'_>, part: &Part, up: &Vector) -> Option<Self> {
        let surface = surface_near(part, supported.placed);
        let ground = Ground { part, surface: &surface };
        let gravity = Across::new(up);
        let center = gravity.seen(&(supported.world_from_held * supported.extent.center_of_mass()));
        let mut best: Option<(f64, Self)> = None;
        for direction in directions(&ground, supported, up) {
            let Some(face) = ground.face(supported, direction) else { continue };
            let off_m = distance_to_hull(&face.places(&gravity, face.gap_m + UNEVEN_M), center);
            if best.as_ref().is_none_or(|(least_m, _)| off_m < *least_m) {
                best = Some((off_m, face));
            }
            if off_m <= 0.0 {
                break;
            }
        }
        best.map(|(_, face)| face)
    }

    /// Returns the corners of all regions in which the body is above the part by at most `gap_m` (m), as seen along gravity.
    pub fn places(&self, gravity: &Across, gap_m: f64) -> Vec<PlanePoint> {
        let within = self.overlaps.iter().flat_map(|overlap| overlap.within(gap_m).corners);
        within.map(|corner| gravity.seen(&self.body_at(&corner))).collect()
    }

    /// Returns the corners of the regions of [`Self::places`] in which the body's surface is on its convex hull, to
    /// [`CONTACT_ALLOWANCE_M`]: elsewhere it touches no plane in any orientation.
    pub fn places_on_hull(
        &self,
        supported: SupportedObject<'_>,
        gravity: &Across,
        gap_m: f64,
    ) -> Vec<PlanePoint> {
        let SupportedObject { extent, world_from_held, .. } = supported;
        let within: Vec<_> = self.overlaps.iter().map(|overlap| overlap.within(gap_m)).collect();
        let planes = extent.lower_planes(world_from_held, &self.direction, self.top_m + gap_m);
        let on = |(normal, height_m): (Vector, f64)| {
            let over_m = move |corner: &OverlapCorner| normal.dot(&self.body_at(corner).coords) - height_m;
            within
                .iter()
                .flat_map(move |overlap| overlap.part(|corner| CONTACT_ALLOWANCE_M - over_m(corner)).corners)
        };
        planes.into_iter().flat_map(on).map(|corner| gravity.seen(&self.body_at(&corner))).collect()
    }

    /// Returns the point of the body at a corner of an overlap.
    fn body_at(&self, corner: &OverlapCorner) -> Point {
        self.across.point(corner.at, corner.surface_m + corner.gap_m)
    }
}

/// Returns the height above which a part does not belong to its face of height `top_m`, both in metres.
fn cut_m(top_m: f64) -> f64 {
    top_m + CONTACT_ALLOWANCE_M
}

/// Returns the portion of a part that is higher along a direction than its face at height `top_m` (m): an ordinary obstacle.
pub(crate) fn lip(part: &Part, direction: &Vector, top_m: f64) -> Option<Part> {
    let Part { world_from_solid, solid } = part;
    let own = world_from_solid.rotation.inverse() * direction;
    let height_m = cut_m(top_m) - direction.dot(&world_from_solid.translation.vector);
    let solid = solid.surface_above(&own, height_m)?;
    Some(Part { world_from_solid: *world_from_solid, solid })
}

/// A part with those of its triangles that are near a body.
struct Ground<'a> {
    part: &'a Part,
    surface: &'a [[Point; 3]],
}

impl Ground<'_> {
    /// 1. Find the regions in which the body is above the part.
    /// 2. Take the plane through their highest points.
    /// 3. Check that the direction is a normal of the part there.
    /// 4. Check that the portion above the plane is apart from the body.
    fn face(&self, supported: SupportedObject<'_>, direction: Vector) -> Option<Face> {
        let low_m = supported.extent.lowest_along(supported.world_from_held, &direction);
        let ceiling_m = low_m + CONTACT_ALLOWANCE_M + RESOLUTION_M;
        let gaps_m = [-CONTACT_ALLOWANCE_M - RESOLUTION_M, REACH_M];
        let reach_m = reach_along(self.part, &direction);
        // A convex part has no portion above its face.
        if reach_m.is_some_and(|reach_m| reach_m > ceiling_m || reach_m < low_m - REACH_M) {
            return None;
        }
        // 1.
        let across = Across::new(&direction);
        let feet = supported.extent.lower_triangles(
            supported.world_from_held,
            (&across, &direction),
            ceiling_m + REACH_M,
        );
        let raised_m = self.raised_m(&direction, reach_m);
        let mut overlaps: Vec<(Overlap, Vector)> = Vec::new();
        if self.part.solid.is_half_space() {
            let top_m = reach_m?;
            overlaps.extend(feet.iter().map(|foot| (foot.above_plane(top_m, gaps_m), direction)));
        } else {
            let tops = self.tops(&across, &direction, raised_m, [low_m - REACH_M, ceiling_m]);
            for foot in &feet {
                let [low, high] = foot.around();
                for (top, normal, [other_low, other_high]) in &tops {
                    if (0..2).all(|axis| low[axis] <= other_high[axis] && other_low[axis] <= high[axis]) {
                        overlaps.push((foot.above(top, ceiling_m, gaps_m), *normal));
                    }
                }
            }
        }
        // 2.
        let corners = || overlaps.iter().flat_map(|(overlap, _)| &overlap.corners);
        let top_m = corners().map(|corner| corner.surface_m).fold(f64::NEG_INFINITY, f64::max);
        let gap_m = corners().map(|corner| corner.gap_m).fold(f64::INFINITY, f64::min);
        if !top_m.is_finite() {
            return None;
        }
        // 3.
        let is_normal_at = |overlap: &Overlap, normal: &Vector| {
            overlap.corners.iter().filter(|corner| corner.surface_m >= top_m - SAME_M).any(|corner| {
                (normal - direction).norm() < ONE_NORMAL
                    || self.is_summit(&across.point(corner.at, corner.surface_m), &direction)
            })
        };
        let is_normal = match reach_m {
            Some(reach_m) => top_m >= reach_m - SAME_M,
            None => overlaps.iter().any(|(overlap, normal)| is_normal_at(overlap, normal)),
        };
        if !is_normal {
            return None;
        }
        // A convex part lies entirely below its highest point.
        let top_m = reach_m.unwrap_or(top_m);
        let overlaps = overlaps.into_iter().map(|(overlap, _)| overlap);
        let overlaps = overlaps.filter(|overlap| !overlap.corners.is_empty()).collect();
        let face = Face { direction, top_m, separation_m: low_m - top_m, gap_m, overlaps, across };
        // 4.
        let is_higher = |corner: &Point| direction.dot(&corner.coords) > cut_m(top_m);
        if self.surface.iter().flatten().any(is_higher)
            && let Some(lip) = lip(self.part, &direction, top_m)
        {
            let lip = std::iter::once((lip.world_from_solid, &lip.solid));
            if group_separation(supported.placed.iter().copied(), &lip, CONTACT_M).lower_m < CONTACT_M {
                return None;
            }
        }
        Some(face)
    }

    /// Returns the distance by which a round part protrudes along a direction beyond its triangles, in metres.
    fn raised_m(&self, direction: &Vector, reach_m: Option<f64>) -> f64 {
        let heights = self.surface.iter().flatten().map(|corner| direction.dot(&corner.coords));
        match reach_m {
            Some(reach_m) if is_round(&self.part.solid) => {
                reach_m - heights.fold(f64::NEG_INFINITY, f64::max)
            }
            _ => 0.0,
        }
    }

    /// Returns the projections of its triangles that face a direction and reach into a range of heights (m), with normals and
    /// bounding boxes.
    fn tops(
        &self,
        across: &Across,
        direction: &Vector,
        raised_m: f64,
        [low_m, high_m]: [f64; 2],
    ) -> Vec<(Seen, Vector, [PlanePoint; 2])> {
        let seen = self.surface.iter().filter_map(|corners| {
            let normal = normal_of(corners).filter(|normal| normal.dot(direction) >= SIDE)?;
            let seen = across.triangle(corners, raised_m)?;
            let [lowest_m, highest_m] = seen.heights_m();
            (highest_m >= low_m && lowest_m <= high_m).then(|| (seen, normal, seen.around()))
        });
        seen.collect()
    }

    /// Returns true if no triangle of the part rises along a direction from a point of its surface: the direction is a normal
    /// there, at least of an edge or a corner.
    fn is_summit(&self, point: &Point, direction: &Vector) -> bool {
        let rises = |corner: &Point| {
            let to = corner - point;
            to.dot(direction) > ONE_NORMAL * to.norm() + SAME_M
        };
        let mut around = self.surface.iter().filter(|corners| is_near(point, corners)).peekable();
        around.peek().is_some() && around.all(|corners| !corners.iter().any(rises))
    }
}

/// Returns true if a point is on a triangle, to [`SAME_M`].
fn is_near(point: &Point, [a, b, c]: &[Point; 3]) -> bool {
    let Some(normal) = normal_of(&[*a, *b, *c]) else { return false };
    (point - a).dot(&normal).abs() <= SAME_M
        && [(a, b), (b, c), (c, a)].into_iter().all(|(from, to)| {
            let inwards = normal.cross(&(to - from)).try_normalize(0.0).unwrap_or_else(Vector::zeros);
            (point - from).dot(&inwards) >= -SAME_M
        })
}

fn normal_of([a, b, c]: &[Point; 3]) -> Option<Vector> {
    (b - a).cross(&(c - a)).try_normalize(0.0)
}

/// Returns the reach of a convex part along a direction, in metres; `None` for a mesh, infinite if it is unbounded there.
fn reach_along(part: &Part, direction: &Vector) -> Option<f64> {
    let Part { world_from_solid, solid } = part;
    let origin_m = direction.dot(&world_from_solid.translation.vector);
    if solid.is_half_space() {
        let normal = world_from_solid.rotation * Vector::z();
        return Some(if (normal - direction).norm() < 1e-9 { origin_m } else { f64::INFINITY });
    }
    let own = world_from_solid.rotation.inverse() * direction;
    Some(own.dot(&solid.support_point(&own)?.coords) + origin_m)
}

/// Returns the triangles of a part near a body.
fn surface_near(part: &Part, placed: &[(Pose, &Solid)]) -> Vec<[Point; 3]> {
    let Part { world_from_solid, solid } = part;
    let mut near: Vec<[Point; 3]> = Vec::new();
    for (pose, own) in placed {
        let region = own.aabb().transformed(&world_from_solid.inv_mul(pose)).grown(REACH_M);
        let corners = solid.triangles_near(&region).into_iter();
        near.extend(corners.map(|corners| corners.map(|corner| world_from_solid * corner)));
        if solid.support_point(&Vector::x()).is_some() {
            break;
        }
    }
    near
}

/// Returns candidate normals of a face of a part below a body, in the order to try them: normals of its flat faces; normals of
/// flat faces of the body, which may lie on an edge or a corner; the direction between their closest points; then up, which may
/// also be a normal of an edge or a corner.
fn directions<'a>(
    ground: &Ground<'a>,
    supported: SupportedObject<'a>,
    up: &'a Vector,
) -> impl Iterator<Item = Vector> + use<'a> {
    let part = ground.part;
    let plane = part.solid.is_half_space().then(|| part.world_from_solid.rotation * Vector::z());
    let of_part = greatest_normals(ground.surface, |normal| {
        normal.dot(up) >= STEEPEST
            && is_flat(&part.solid, &(part.world_from_solid.rotation.inverse() * normal))
    });
    let of_body = supported.extent.inward_normals(supported.world_from_held);
    let of_body = of_body.filter(|normal| normal.dot(up) >= STEEPEST).take(MOST_DIRECTIONS);
    let nearest = supported.placed.iter().filter_map(move |(pose, solid)| {
        let between = |pose: &Pose| closest_points(&part.solid, &part.world_from_solid, solid, pose);
        let lifted = || Pose::from_parts((up * LIFTED_M).into(), Rotation::identity()) * pose;
        let [from, to] = between(pose).or_else(|| between(&lifted()))?;
        (to - from).try_normalize(1e-9)
    });
    let others = of_part.into_iter().take(MOST_DIRECTIONS).chain(of_body).chain(nearest).chain([*up]);
    let others = others.filter(move |_| plane.is_none());
    plane.into_iter().chain(others).filter(|normal| normal.dot(up) >= STEEPEST)
}

/// Height by which a touching body is raised to get closest points, in metres: twice the allowance.
const LIFTED_M: f64 = 2.0 * CONTACT_ALLOWANCE_M;
