use std::collections::HashMap;

use cranny_spatial::nalgebra::Vector2;
use cranny_spatial::{Point, Pose, Rotation, Vector};

use crate::distance::ray::triangle_normal;
use crate::mesh::signed_solid_angle;
use crate::{ShapeError, TriangleSoup};

/// Pose of an object at rest on level ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StablePose {
    /// Pose of the object: ground at z = 0, centre of mass above the origin. Its turn about z is free; this is the pose reached
    /// by the shortest rotation.
    pub ground_from_body: Pose,
    /// Probability that the object, dropped with a uniformly random rotation, ends on this face.
    pub probability: f64,
    /// Minimum angle by which the object must be tilted to fall onto another face, in radians; `None`: not computed.
    pub tilt_rad: Option<f64>,
}

/// Stable poses of an object with these `points` and this centre of mass, the likeliest first. Their probabilities sum to 1.
///
/// Quasi-static method (Goldberg et al. 1999, "Part pose statistics: estimators and experiments", whole; Boothroyd et al. 1972,
/// "Statistical distributions of natural resting aspects of parts for automatic handling", whole): a dropped object first meets
/// the ground with the face of its convex hull that the vertical through its centre of mass crosses. The probability of a face
/// is its solid angle over 4π.
/// 1. Finds the faces of the hull: coplanar facets are one face.
/// 2. Computes the solid angle of each, seen from the centre of mass.
/// 3. The object rolls off a face if the vertical from the centre of mass meets its plane outside the face: over the edge that
///    the vertical is farthest beyond, to a lower position, until it is stable on a face.
///
/// # Errors
/// [`ShapeError::FlatHull`], [`ShapeError::NotFinite`], or [`ShapeError::CenterOutside`] for a centre of mass outside the hull.
pub fn stable_poses(points: &[Point], center: &Point) -> Result<Vec<StablePose>, ShapeError> {
    let hull = TriangleSoup::convex_hull(points)?;
    // 1.
    let faces = Faces::of(&hull);
    let is_inside = faces.normals.iter().zip(&faces.heights).all(|(n, h)| n.dot(&center.coords) < *h);
    if !is_inside {
        return Err(ShapeError::CenterOutside { x: center.x, y: center.y, z: center.z });
    }
    // 2.
    let mut share = vec![0.0; faces.normals.len()];
    for (triangle, &face) in faces.of_triangle.iter().enumerate() {
        share[face] += signed_solid_angle(&hull.corners(triangle), center) / (2.0 * std::f64::consts::TAU);
    }
    // 3.
    let next: Vec<Option<usize>> = (0..share.len()).map(|face| faces.rolls_to(&hull, face, center)).collect();
    let mut probability = vec![0.0; share.len()];
    for (first, share) in share.iter().enumerate() {
        let mut face = first;
        // Each roll lowers the centre of mass, so no face repeats; the limit guards against a cycle by rounding.
        for _ in 0..next.len() {
            match next[face] {
                Some(lower) => face = lower,
                None => break,
            }
        }
        probability[face] += share;
    }
    let total: f64 = probability.iter().sum();
    let mut poses: Vec<StablePose> = (0..probability.len())
        .filter(|&face| probability[face] > 0.0)
        .map(|face| StablePose {
            ground_from_body: faces.resting(face, center),
            probability: probability[face] / total,
            tilt_rad: Some(faces.tilt_rad(&hull, face, center)),
        })
        .collect();
    poses.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    Ok(poses)
}

struct Faces {
    of_triangle: Vec<usize>,
    /// Unit normals, outwards; `heights` are the distances of the planes from the origin along them, in metres.
    normals: Vec<Vector>,
    heights: Vec<f64>,
    /// Edges of each face, as corner indices counterclockwise from outside, with the face beyond.
    edges: Vec<Vec<([u32; 2], usize)>>,
}

/// Angle between normals below which facets are one face, in radians. The facets of a flat side read from a file in
/// single precision differ by 1e-5.
const ONE_PLANE_RAD: f64 = 1e-4;

impl Faces {
    fn of(hull: &TriangleSoup) -> Self {
        let count = hull.triangles.len();
        let mut at_edge: HashMap<(u32, u32), usize> = HashMap::new();
        for (index, &[a, b, c]) in hull.triangles.iter().enumerate() {
            for edge in [(a, b), (b, c), (c, a)] {
                at_edge.insert(edge, index);
            }
        }
        let normal = |triangle: usize| triangle_normal(&hull.corners(triangle));
        let area = |triangle: usize| {
            let [a, b, c] = hull.corners(triangle);
            (b - a).cross(&(c - a)).norm()
        };
        // From the largest facet down, so that the plane of a face is that of its most accurate facet.
        let mut order: Vec<usize> = (0..count).collect();
        order.sort_by(|&a, &b| area(b).total_cmp(&area(a)).then(a.cmp(&b)));
        let mut faces =
            Self { of_triangle: vec![usize::MAX; count], normals: vec![], heights: vec![], edges: vec![] };
        for seed in order {
            if faces.of_triangle[seed] != usize::MAX {
                continue;
            }
            let plane = normal(seed);
            let face = faces.normals.len();
            faces.of_triangle[seed] = face;
            let mut members = vec![seed];
            let mut height = f64::NEG_INFINITY;
            while let Some(triangle) = members.pop() {
                let [a, b, c] = hull.triangles[triangle];
                for corner in hull.corners(triangle) {
                    height = height.max(plane.dot(&corner.coords));
                }
                for edge in [(b, a), (c, b), (a, c)] {
                    let Some(&other) = at_edge.get(&edge) else { continue };
                    let turn = plane.cross(&normal(other)).norm();
                    let is_same = turn < ONE_PLANE_RAD && plane.dot(&normal(other)) >= 0.0;
                    if faces.of_triangle[other] == usize::MAX && is_same {
                        faces.of_triangle[other] = face;
                        members.push(other);
                    }
                }
            }
            faces.normals.push(plane);
            faces.heights.push(height);
        }
        faces.edges = vec![Vec::new(); faces.normals.len()];
        for (triangle, &[a, b, c]) in hull.triangles.iter().enumerate() {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                let Some(&other) = at_edge.get(&(to, from)) else { continue };
                let (face, beyond) = (faces.of_triangle[triangle], faces.of_triangle[other]);
                if face != beyond {
                    faces.edges[face].push(([from, to], beyond));
                }
            }
        }
        faces
    }

    /// Face onto which an object that stands on `face` rolls; `None` if it stays.
    fn rolls_to(&self, hull: &TriangleSoup, face: usize, center: &Point) -> Option<usize> {
        (self.beyond(hull, face, center)).filter(|farthest| farthest.0 > 0.0).map(|farthest| farthest.1)
    }

    /// Minimum angle, in radians, by which an object that stays on `face` must be tilted to roll over an edge of it.
    fn tilt_rad(&self, hull: &TriangleSoup, face: usize, center: &Point) -> f64 {
        let height_m = self.heights[face] - self.normals[face].dot(&center.coords);
        self.beyond(hull, face, center).map_or(0.0, |(beyond_m, _)| libm::atan2(-beyond_m, height_m))
    }

    /// Distance (m) of the vertical from the centre of mass beyond the edge that it is farthest beyond, negative within
    /// the face, and the face on the other side of that edge.
    fn beyond(&self, hull: &TriangleSoup, face: usize, center: &Point) -> Option<(f64, usize)> {
        let normal = self.normals[face];
        let beyond = |ends: &[u32; 2]| {
            let [from, to] = ends.map(|vertex| hull.vertices[vertex as usize]);
            let outwards = (to - from).cross(&normal).try_normalize(0.0).unwrap_or_else(Vector::zeros);
            (center - from).dot(&outwards)
        };
        let edges = self.edges[face].iter().map(|(ends, other)| (beyond(ends), *other));
        edges.max_by(|a, b| a.0.total_cmp(&b.0))
    }

    fn resting(&self, face: usize, center: &Point) -> Pose {
        let down = -Vector::z();
        let half_turn = || Rotation::from_axis_angle(&Vector::x_axis(), std::f64::consts::PI);
        let rotation = Rotation::rotation_between(&self.normals[face], &down).unwrap_or_else(half_turn);
        let across: Vector2<f64> = (rotation * center.coords).xy();
        Pose::from_parts(Vector::new(-across.x, -across.y, self.heights[face]).into(), rotation)
    }
}
