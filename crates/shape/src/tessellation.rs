use std::f64::consts::TAU;

use cranny_spatial::{Point, Vector, sin_cos};

use crate::solid::Kind;
use crate::{BoxUnion, Outline, Solid, Surface, TriangleSoup};

/// Corners of a full circle: a cylinder of 5 cm radius then bulges by 0.15 mm between two of them.
const CIRCLE_POINTS: u32 = 40;

/// Divisions of a geodesic sphere: 1280 triangles.
const SPHERE_DIVISIONS: u32 = 3;

impl Solid {
    /// Surface of the solid as triangles in its own frame, normals outwards, for display. Exact for cuboids, hulls and
    /// meshes; for round solids the corners lie on the surface. A point of a cloud is an octahedron; pieces of a union may
    /// overlap. `None` for a half-space.
    pub fn tessellation(&self) -> Option<TriangleSoup> {
        match self.outline() {
            Outline::HalfSpace => None,
            Outline::Cuboid { half_extents } => Some(Surface::cuboid_soup(&half_extents)),
            Outline::Segment { half_length_m: 0.0, radius_m } => {
                Some(TriangleSoup::geodesic_sphere(radius_m, SPHERE_DIVISIONS))
            }
            Outline::Segment { half_length_m, radius_m } => Some(capsule(half_length_m, radius_m)),
            Outline::Cylinder { half_length_m, radius_m } => {
                Some(turned(&[(-half_length_m, radius_m), (half_length_m, radius_m)]))
            }
            Outline::Union => self.as_union().map(|union| union_soup(union)),
            Outline::Other => {
                if let Kind::Mesh(mesh) = self.kind() {
                    return TriangleSoup::from_corners(mesh.vertices()).ok();
                }
                let (points, _) = self.bounding_points()?;
                TriangleSoup::convex_hull(&points).ok()
            }
        }
    }
}

/// Triangles of all boxes of a union, or an octahedron at each point.
fn union_soup(union: &BoxUnion) -> TriangleSoup {
    let mut soup = TriangleSoup::default();
    let tips = [Vector::x(), Vector::y(), Vector::z()].map(|axis| axis * union.radius_m());
    let tips: Vec<Point> = tips.iter().flat_map(|tip| [Point::from(*tip), Point::from(-tip)]).collect();
    let octahedron = TriangleSoup::convex_hull(&tips).unwrap_or_default();
    for aabb in union.boxes() {
        let is_point = aabb.half_extents.amax() <= 0.0;
        let piece = if is_point { octahedron.clone() } else { Surface::cuboid_soup(&aabb.half_extents) };
        let first = u32::try_from(soup.vertices.len()).unwrap_or(u32::MAX);
        soup.vertices.extend(piece.vertices.iter().map(|vertex| aabb.center + vertex.coords));
        soup.triangles.extend(piece.triangles.iter().map(|corners| corners.map(|corner| first + corner)));
    }
    soup
}

/// A capsule along z.
fn capsule(half_length_m: f64, radius_m: f64) -> TriangleSoup {
    let quarter = CIRCLE_POINTS / 4;
    let cap = |index: u32| {
        let (height, across) = sin_cos(TAU * f64::from(index) / f64::from(CIRCLE_POINTS));
        (half_length_m + radius_m * height, radius_m * across)
    };
    let upper: Vec<(f64, f64)> = (0..quarter).map(cap).chain([(half_length_m + radius_m, 0.0)]).collect();
    let lower = upper.iter().rev().map(|&(z, radius_m)| (-z, radius_m));
    turned(&lower.chain(upper.iter().copied()).collect::<Vec<_>>())
}

/// Surface of revolution of a profile about z. The profile is pairs of height and radius (m), upwards; flat discs close ends
/// that are not on the axis.
fn turned(profile: &[(f64, f64)]) -> TriangleSoup {
    let mut soup = TriangleSoup::default();
    for &(z, radius_m) in profile {
        soup.vertices.extend((0..CIRCLE_POINTS).map(|corner| {
            let (sine, cosine) = sin_cos(TAU * f64::from(corner) / f64::from(CIRCLE_POINTS));
            Point::new(radius_m * cosine, radius_m * sine, z)
        }));
    }
    let next = |corner: u32| (corner + 1) % CIRCLE_POINTS;
    for (below, pair) in (0_u32..).step_by(CIRCLE_POINTS as usize).zip(profile.windows(2)) {
        let above = below + CIRCLE_POINTS;
        for corner in 0..CIRCLE_POINTS {
            let [a, b] = [below + corner, below + next(corner)];
            let [d, c] = [above + corner, above + next(corner)];
            if pair[0].1 > 0.0 {
                soup.triangles.push([a, b, c]);
            }
            if pair[1].1 > 0.0 {
                soup.triangles.push([a, c, d]);
            }
        }
    }
    let (Some(&(low, low_radius_m)), Some(&(high, high_radius_m))) = (profile.first(), profile.last()) else {
        return soup;
    };
    let count = |soup: &TriangleSoup| u32::try_from(soup.vertices.len()).unwrap_or(u32::MAX);
    let last_ring = count(&soup).saturating_sub(CIRCLE_POINTS);
    if low_radius_m > 0.0 {
        let middle = count(&soup);
        soup.vertices.push(Point::new(0.0, 0.0, low));
        soup.triangles.extend((0..CIRCLE_POINTS).map(|corner| [middle, next(corner), corner]));
    }
    if high_radius_m > 0.0 {
        let middle = count(&soup);
        soup.vertices.push(Point::new(0.0, 0.0, high));
        let fan = |corner: u32| [middle, last_ring + corner, last_ring + next(corner)];
        soup.triangles.extend((0..CIRCLE_POINTS).map(fan));
    }
    soup
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    /// Compares the volume of the triangles with that of the solid. A polygon of 40 corners has 0.4 % less area than its
    /// circle.
    fn volume_is(solid: &Solid, expected_m3: f64) {
        let soup = solid.tessellation().unwrap();
        crate::inside::closed_mesh::check_indices(&soup).unwrap();
        let volume_m3 = soup.signed_volume_m3();
        assert!(volume_m3 <= expected_m3 * (1.0 + 1e-9), "{volume_m3} > {expected_m3}");
        assert!(volume_m3 > 0.985 * expected_m3, "{volume_m3} < {expected_m3}");
    }

    #[test]
    fn the_triangles_of_a_solid_enclose_its_volume() {
        let ball = 4.0 / 3.0 * PI * 0.2_f64.powi(3);
        volume_is(&Solid::sphere(0.2).unwrap(), ball);
        volume_is(&Solid::capsule(0.3, 0.2).unwrap(), ball + PI * 0.04 * 0.6);
        volume_is(&Solid::cylinder(0.3, 0.2).unwrap(), PI * 0.04 * 0.6);
        let half_extents = Vector::new(0.1, 0.2, 0.3);
        volume_is(&Solid::cuboid(half_extents).unwrap(), 0.048);
        let corners = Surface::cuboid_soup(&half_extents);
        volume_is(&Solid::hull(&corners.vertices).unwrap(), 0.048);
        volume_is(&Solid::mesh(&corners).unwrap(), 0.048);
        assert!(Solid::half_space().tessellation().is_none());
    }

    #[test]
    fn round_bodies_are_closed() {
        for solid in [Solid::capsule(0.3, 0.2).unwrap(), Solid::cylinder(0.3, 0.2).unwrap()] {
            let soup = solid.tessellation().unwrap();
            let merged = TriangleSoup::from_corners(
                soup.triangles.iter().flatten().map(|&vertex| soup.vertices[vertex as usize]),
            );
            crate::inside::closed_mesh::check_closed(&merged.unwrap()).unwrap();
        }
    }
}
