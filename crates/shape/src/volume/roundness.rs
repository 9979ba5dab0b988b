use std::f64::consts::TAU;

use cranny_spatial::nalgebra::{SymmetricEigen, Unit};
use cranny_spatial::{Point, Pose, Rotation, Vector};

use crate::volume::pose_symmetry::distance_to_triangle;
use crate::{Aabb, ShapeError, Surface, TriangleSoup, VolumeMoments};

/// Rotational symmetry of an object: the rotations that map its surface onto itself.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Roundness {
    /// No symmetry: every rotation is visible.
    #[default]
    None,
    /// Symmetry about an axis, a unit vector in the frame of the object: a can.
    About(Unit<Vector>),
    /// Symmetry under all rotations: a ball.
    Ball,
}

/// Tolerance of a rotated surface, as a share of the greatest distance from the axis, or the centre: a tube of 24 sides
/// is round.
const TOLERANCE_SHARE: f64 = 0.01;
/// Relative difference below which two principal moments of inertia count as equal.
const SAME_MOMENT_SHARE: f64 = 0.02;
/// Turns about an axis that are tried, as shares of a whole one; none is a simple fraction.
const TURNS: [f64; 5] = [0.0813, 0.1931, 0.3187, 0.4463, 0.6229];
/// Maximum number of vertices that are rotated.
const MOST_VERTICES: usize = 400;

impl Roundness {
    /// Roundness of the volume that a mesh encloses, about its centre of mass: the rotated surface deviates from itself by at
    /// most 1 % of its greatest distance from the axis.
    ///
    /// # Errors
    /// Those of [`VolumeMoments::of_mesh`].
    pub fn of_mesh(mesh: &TriangleSoup) -> Result<Self, ShapeError> {
        let (surface, moments) = (Surface::new(mesh)?, VolumeMoments::of_mesh(mesh)?);
        let center = moments.center;
        // The corners of a cube are equally far out, the centres of its triangles are not.
        let middle = |[a, b, c]: &[Point; 3]| Point::from((a.coords + b.coords + c.coords) / 3.0);
        let points = || mesh.vertices.iter().copied().chain(surface.corners.iter().map(middle));
        let radii = || points().map(|point| (point - center).norm());
        let (least, most) = radii().fold((f64::INFINITY, 0.0_f64), |(a, b), r| (a.min(r), b.max(r)));
        if most - least <= TOLERANCE_SHARE * most {
            return Ok(Self::Ball);
        }
        let principal = SymmetricEigen::new(moments.inertia_per_mass_m2);
        let step = mesh.vertices.len().div_ceil(MOST_VERTICES).max(1);
        let is_near = |point: &Point, tolerance_m: f64| {
            let region = Aabb { center: *point, half_extents: Vector::repeat(tolerance_m) };
            let corners = |triangle: u32| &surface.corners[triangle as usize];
            let mut near = surface.tree.near(&region);
            near.any(|triangle| distance_to_triangle(point, corners(triangle)) <= tolerance_m)
        };
        let is_round = |axis: &Unit<Vector>| {
            let off_axis = |vertex: &Point| (vertex - center).cross(axis).norm();
            let tolerance_m = TOLERANCE_SHARE * mesh.vertices.iter().map(off_axis).fold(0.0, f64::max);
            TURNS.iter().all(|share| {
                let turn = Rotation::from_axis_angle(axis, TAU * share);
                let about = Pose::translation(center.x, center.y, center.z)
                    * Pose::from_parts(Vector::zeros().into(), turn)
                    * Pose::translation(-center.x, -center.y, -center.z);
                mesh.vertices.iter().step_by(step).all(|vertex| is_near(&(about * vertex), tolerance_m))
            })
        };
        let axis = |index: usize| {
            let [a, b] = [1, 2].map(|other| principal.eigenvalues[(index + other) % 3]);
            let is_even = (a - b).abs() <= SAME_MOMENT_SHARE * a.max(b);
            is_even.then(|| Unit::new_normalize(principal.eigenvectors.column(index).into_owned()))
        };
        // If all three moments are equal, any direction is principal, so the axes of the frame are tried too.
        let of_frame = [Vector::x_axis(), Vector::y_axis(), Vector::z_axis()];
        let found = (0..3).filter_map(axis).chain(of_frame).find(is_round);
        Ok(found.map_or(Self::None, Self::About))
    }

    /// Angle between two orientations of an object up to its rotational symmetry, in radians.
    pub fn angle(&self, from: &Rotation, to: &Rotation) -> f64 {
        match self {
            Self::None => from.angle_to(to),
            Self::About(axis) => (from * axis).angle(&(to * axis)),
            Self::Ball => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Solid;

    #[test]
    fn balls_and_tubes_are_round_and_boxes_are_not() {
        let of = |solid: Solid| Roundness::of_mesh(&solid.tessellation().unwrap()).unwrap();
        assert_eq!(of(Solid::sphere(0.03).unwrap()), Roundness::Ball);
        assert_eq!(of(Solid::cuboid(Vector::repeat(0.02)).unwrap()), Roundness::None);
        for half_m in [0.1, 0.5] {
            assert_eq!(of(Solid::cuboid(Vector::new(0.005, 0.005, half_m)).unwrap()), Roundness::None);
        }
        // The third cylinder has three equal moments of inertia: h = √3 r.
        for half_m in [0.01, 0.06, 0.02 * 3.0_f64.sqrt()] {
            let Roundness::About(axis) = of(Solid::cylinder(half_m, 0.04).unwrap()) else {
                panic!("half {half_m}: not round")
            };
            assert!(axis.z.abs() > 0.9999, "{axis:?}");
        }
    }

    #[test]
    fn turns_that_nobody_sees_do_not_count() {
        let round = Roundness::About(Vector::z_axis());
        let about_z = Rotation::from_axis_angle(&Vector::z_axis(), 2.0);
        let tilted = Rotation::from_axis_angle(&Vector::x_axis(), 0.3) * about_z;
        assert!(round.angle(&Rotation::identity(), &about_z) < 1e-12);
        assert!((round.angle(&Rotation::identity(), &tilted) - 0.3).abs() < 1e-12);
        assert!(Roundness::Ball.angle(&Rotation::identity(), &tilted) < 1e-12);
        assert!((Roundness::None.angle(&Rotation::identity(), &about_z) - 2.0).abs() < 1e-12);
    }
}
