use std::f64::consts::PI;

use cranny_spatial::{Point, Pose, Rotation, Vector};

use crate::{Aabb, ShapeError, StablePose, Surface, TriangleSoup, VolumeMoments};

/// Stable poses of an object without those equal to a likelier one, the likeliest first, with the probabilities of equal ones
/// added. So a bottle of 48 sides has one lying pose, not 48, and a cuboid stands on three sides, not on six.
///
/// Two poses are equal if a turn about the vertical maps the object from one to the other: no vertex of one is then farther
/// from the surface of the other than 0.2 % of the greatest extent of the object. The turns tried align the principal axes of
/// inertia, or the vertex farthest from the vertical through the centre of mass with vertices equally far out and equally high.
///
/// More than 512 poses are not merged: the object is round in all directions.
///
/// # Errors
/// Those of [`VolumeMoments::of_mesh`].
pub fn distinct_poses(poses: &[StablePose], mesh: &TriangleSoup) -> Result<Vec<StablePose>, ShapeError> {
    let mut distinct: Vec<(usize, StablePose)> = Vec::new();
    for (pose, first) in poses.iter().zip(equal_poses(poses, mesh)?) {
        match distinct.iter_mut().find(|(known, _)| *known == first) {
            Some((_, other)) => other.probability += pose.probability,
            None => distinct.push((first, *pose)),
        }
    }
    distinct.sort_by(|(_, a), (_, b)| b.probability.total_cmp(&a.probability));
    Ok(distinct.into_iter().map(|(_, pose)| pose).collect())
}

/// Index of the first pose equal to each pose, as in [`distinct_poses`]; its own index if there is none.
///
/// # Errors
/// Those of [`VolumeMoments::of_mesh`].
pub fn equal_poses(poses: &[StablePose], mesh: &TriangleSoup) -> Result<Vec<usize>, ShapeError> {
    const MOST: usize = 512;
    if poses.len() > MOST {
        return Ok((0..poses.len()).collect());
    }
    let body = Body { mesh, surface: Surface::new(mesh)?, moments: VolumeMoments::of_mesh(mesh)? };
    let mut first: Vec<usize> = Vec::new();
    for (index, pose) in poses.iter().enumerate() {
        let is_equal = |&other: &usize| {
            first[other] == other && body.is_equal_in(&poses[other].ground_from_body, &pose.ground_from_body)
        };
        let equal = (0..index).find(is_equal);
        first.push(equal.unwrap_or(index));
    }
    Ok(first)
}

/// Tolerance of equal poses, as a share of the object's greatest extent: 0.4 mm for a bottle of 0.2 m, half the noise of a
/// scan.
const TOLERANCE_SHARE: f64 = 0.002;

struct Body<'a> {
    mesh: &'a TriangleSoup,
    surface: Surface,
    moments: VolumeMoments,
}

impl Body<'_> {
    fn tolerance_m(&self) -> f64 {
        TOLERANCE_SHARE * 2.0 * self.surface.aabb().half_extents.max()
    }

    fn is_equal_in(&self, ground_from_first: &Pose, ground_from_second: &Pose) -> bool {
        let poses = [ground_from_first, ground_from_second];
        let [first_m, second_m] = poses.map(|pose| (pose * self.moments.center).z);
        (first_m - second_m).abs() <= self.tolerance_m()
            && self.turns(poses).into_iter().any(|angle| {
                let turn = Rotation::from_axis_angle(&Vector::z_axis(), angle);
                let turned = Pose::from_parts(Vector::zeros().into(), turn) * ground_from_first;
                self.is_mapped_by(&ground_from_second.inv_mul(&turned))
            })
    }

    /// Turns about the vertical that may map the first pose to the second, in radians.
    fn turns(&self, poses: [&Pose; 2]) -> Vec<f64> {
        let [first, second] = poses.map(|pose| {
            let rotation = pose.rotation.to_rotation_matrix();
            let inertia =
                rotation.matrix() * self.moments.inertia_per_mass_m2 * rotation.matrix().transpose();
            0.5 * libm::atan2(2.0 * inertia[(0, 1)], inertia[(0, 0)] - inertia[(1, 1)])
        });
        let mut turns = vec![second - first, second - first + PI];
        let [first, second] =
            poses.map(|pose| self.mesh.vertices.iter().map(move |v| Polar::of(&(pose * v))));
        if let Some(farthest) = first.max_by(|a, b| a.radius_m.total_cmp(&b.radius_m)) {
            let near = |a: f64, b: f64| (a - b).abs() <= self.tolerance_m();
            let alike =
                second.filter(|p| near(p.radius_m, farthest.radius_m) && near(p.height_m, farthest.height_m));
            turns.extend(alike.map(|p| p.angle - farthest.angle));
        }
        turns
    }

    /// Returns true if a motion maps the object onto itself.
    fn is_mapped_by(&self, motion: &Pose) -> bool {
        let back = motion.inverse();
        let stays = |v: &Point| self.is_near(&(motion * v)) && self.is_near(&(back * v));
        self.mesh.vertices.iter().all(stays)
    }

    fn is_near(&self, point: &Point) -> bool {
        let reach_m = self.tolerance_m();
        let region = Aabb { center: *point, half_extents: Vector::repeat(reach_m) };
        let mut near = self.surface.tree.near(&region);
        near.any(|triangle| distance_to_triangle(point, &self.surface.corners[triangle as usize]) <= reach_m)
    }
}

/// Point in cylindrical coordinates: angle about the vertical, distance from it, and height.
struct Polar {
    angle: f64,
    radius_m: f64,
    height_m: f64,
}

impl Polar {
    fn of(p: &Point) -> Self {
        Self { angle: libm::atan2(p.y, p.x), radius_m: p.coords.xy().norm(), height_m: p.z }
    }
}

/// Distance of a point from a triangle (m), by the region of the triangle in front of which it lies (Ericson 2005, §5.1.5).
pub(crate) fn distance_to_triangle(p: &Point, [a, b, c]: &[Point; 3]) -> f64 {
    let (ab, ac) = (b - a, c - a);
    let [from_a, from_b, from_c] = [a, b, c].map(|corner| p - corner);
    let [d1, d2] = [ab.dot(&from_a), ac.dot(&from_a)];
    let [d3, d4] = [ab.dot(&from_b), ac.dot(&from_b)];
    let [d5, d6] = [ab.dot(&from_c), ac.dot(&from_c)];
    let [va, vb, vc] = [d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2];
    let nearest = if d1 <= 0.0 && d2 <= 0.0 {
        *a
    } else if d3 >= 0.0 && d4 <= d3 {
        *b
    } else if d6 >= 0.0 && d5 <= d6 {
        *c
    } else if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        a + ab * (d1 / (d1 - d3))
    } else if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        a + ac * (d2 / (d2 - d6))
    } else if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)))
    } else {
        a + (ab * vb + ac * vc) / (va + vb + vc)
    };
    (p - nearest).norm()
}
