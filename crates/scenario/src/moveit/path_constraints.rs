//! Position and orientation constraints along a motion, as bounds of the tool.

use std::f64::consts::{FRAC_PI_2, PI};

use cranny_collision::{ToolBound, ToolRegion};
use cranny_robot::Robot;
use cranny_spatial::{Point, Pose, Vector};
use serde_saphyr::Spanned;

use crate::moveit::file::{
    NameOrNumber, OrientationConstraintEntry, PoseEntry, PositionConstraintEntry, PrimitiveEntry,
};
use crate::moveit::frames::Frames;
use crate::moveit::request::Files;
use crate::{MoveItDeviation, ScenarioError};

/// Names of a `SolidPrimitive`'s kinds, the first of which has the number 1.
const PRIMITIVES: [&str; 2] = ["box", "sphere"];

/// Names of the parameterizations of an `OrientationConstraint`, the first of which has the number 0.
const PARAMETERIZATIONS: [&str; 2] = ["xyz_euler_angles", "rotation_vector"];

impl Files {
    /// Returns the tool bounds, in the root frame, for the path constraints of the request: satisfying the bounds satisfies the
    /// constraints.
    ///
    /// A position stays in its box or sphere. An orientation stays in cones about the z axis of the link and, unless rotation
    /// about that axis is free, about its x axis; they lie within the tolerances ([`cones`]).
    pub fn tool_bounds(
        &self,
        robot: &Robot,
        world_from_root: &Pose,
        deviations: &mut Vec<MoveItDeviation>,
    ) -> Result<Vec<ToolBound>, ScenarioError> {
        let Some(path) = &self.request.path_constraints else { return Ok(Vec::new()) };
        let file = &self.request_file;
        if !path.value.visibilities.is_empty() {
            return Err(file.unsupported(path.referenced, "a visibility constraint", "leave it out"));
        }
        let frames = Frames::new(&self.scene_file, &self.scene, robot, world_from_root)?;
        let mut bounds = Vec::new();
        for (index, entry) in path.value.positions.iter().enumerate() {
            let name = format!("position constraint {}", index + 1);
            let link = self.link(&entry.value.link_name, robot)?;
            bounds.push(ToolBound { name, link, region: self.position(entry, &frames)? });
        }
        for (index, entry) in path.value.orientations.iter().enumerate() {
            let link = self.link(&entry.value.link_name, robot)?;
            let regions = self.orientation(entry, &frames)?;
            deviations.push(MoveItDeviation::Cones { link: entry.value.link_name.value.clone() });
            bounds.extend(regions.into_iter().map(|(axis, region)| {
                let name = format!("orientation constraint {}, {axis} axis", index + 1);
                ToolBound { name, link: link.clone(), region }
            }));
        }
        Ok(bounds)
    }

    fn position(
        &self,
        entry: &Spanned<PositionConstraintEntry>,
        frames: &Frames,
    ) -> Result<ToolRegion, ScenarioError> {
        let file = &self.request_file;
        let PositionConstraintEntry { header, target_point_offset, constraint_region, .. } = &entry.value;
        let refuse = |what, hint| Err(file.unsupported(entry.referenced, what, hint));
        let ([Spanned { value: PrimitiveEntry { kind, dimensions, .. }, referenced, .. }], []) =
            (&constraint_region.primitives[..], &constraint_region.meshes[..])
        else {
            return refuse(
                "a position constraint whose region is not one primitive",
                "give one box or sphere",
            );
        };
        let [pose] = &constraint_region.primitive_poses[..] else {
            return refuse(
                "a position constraint whose region has not one pose",
                "give that of its primitive",
            );
        };
        let root_from_region = frames.find(file, header)? * file.pose(pose)?;
        let offset = target_point_offset.map_or([0.0; 3], |offset| offset.0);
        let point_in_link = Point::from(offset);
        let sizes = dimensions.iter().map(|size| file.finite(size)).collect::<Result<Vec<f64>, _>>()?;
        if !sizes.iter().all(|size| *size > 0.0) {
            let hint = "give positive ones";
            return Err(file.unsupported(
                *referenced,
                "a region with a dimension that is not positive",
                hint,
            ));
        }
        match (&kind.name(&PRIMITIVES, 1)[..], &sizes[..]) {
            ("box", [x, y, z]) => Ok(ToolRegion::Box {
                point_in_link,
                world_from_box: root_from_region,
                half_m: Vector::new(*x, *y, *z) * 0.5,
            }),
            ("sphere", [radius_m]) => Ok(ToolRegion::Ball {
                point_in_link,
                center: root_from_region * Point::origin(),
                radius_m: *radius_m,
            }),
            _ => refuse(
                "a position constraint whose region is no box of three dimensions and no sphere of one",
                "give one of these",
            ),
        }
    }

    fn orientation(
        &self,
        entry: &Spanned<OrientationConstraintEntry>,
        frames: &Frames,
    ) -> Result<Vec<(char, ToolRegion)>, ScenarioError> {
        let file = &self.request_file;
        let constraint = &entry.value;
        let tolerance = |given: &Spanned<f64>| {
            // `MoveIt` takes absolute values.
            if given.value.abs() > 0.0 {
                return Ok(given.value.abs().min(PI));
            }
            Err(file.unsupported(given.referenced, "an axis tolerance of 0", "give a greater one"))
        };
        let tolerances = [
            tolerance(&constraint.absolute_x_axis_tolerance)?,
            tolerance(&constraint.absolute_y_axis_tolerance)?,
            tolerance(&constraint.absolute_z_axis_tolerance)?,
        ];
        let named =
            constraint.parameterization.as_ref().map(|kind: &NameOrNumber| kind.name(&PARAMETERIZATIONS, 0));
        let is_vector = match named.as_deref() {
            None | Some("xyz_euler_angles") => false,
            Some("rotation_vector") => true,
            Some(_) => {
                let hint = "give 0 (XYZ Euler angles) or 1 (rotation vector)";
                return Err(file.unsupported(entry.referenced, "an unknown parameterization", hint));
            }
        };
        let pose = PoseEntry { position: None, orientation: constraint.orientation };
        let pose = Spanned { value: pose, referenced: entry.referenced, defined: entry.defined };
        let root_from_goal = frames.find(file, &constraint.header)? * file.pose(&pose)?;
        let cone = |(axis, most_rad): (char, f64)| {
            let direction = if axis == 'z' { Vector::z() } else { Vector::x() };
            let toward = root_from_goal.rotation * direction;
            (axis, ToolRegion::Cone { axis_in_link: direction, toward, most_rad })
        };
        Ok(cones(tolerances, is_vector).into_iter().map(cone).collect())
    }

    /// Returns the name of a link, which the robot must have.
    fn link(&self, name: &Spanned<String>, robot: &Robot) -> Result<Option<String>, ScenarioError> {
        if robot.link_index(&name.value).is_some() {
            return Ok(Some(name.value.clone()));
        }
        let what = "a path constraint of a link that the robot does not have";
        Err(self.request_file.unsupported(name.referenced, what, "name one of the URDF"))
    }
}

/// Returns cones about the z axis and the x axis, by half angle (rad), that lie within tolerances about x, y and z (rad, at
/// most π): a rotation within them is within each tolerance.
///
/// - XYZ Euler angles a, b, c: the z axis is `(sin b, −sin a cos b, cos a cos b)`, so a cone of β ≤ π/2 about z bounds a and b
///   by β (b is at most π/2 anyway). The x component of the x axis is `cos b cos c`, so a cone of ψ about x with
///   `cos ψ = cos t_z`, or `cos t_z cos β` beyond a quarter turn, bounds c by `t_z`.
/// - A rotation vector of length φ ≤ π with a share s across z: `sin(θ/2) = s sin(φ/2) ≥ s φ/π` for the tilt θ of the z axis,
///   so `θ ≤ 2 asin(t/π)` bounds both components across z by t. If z is bounded too, φ bounds its component, and `1 − cos φ` is
///   at most the sum of `1 − cos` of the angles of two axes.
fn cones([x, y, z]: [f64; 3], is_vector: bool) -> Vec<(char, f64)> {
    let is_free_across = x >= PI && y >= FRAC_PI_2;
    let across = x.min(y);
    let is_free = z >= PI;
    let of_z = match (is_vector, is_free) {
        (false, _) if is_free_across => PI,
        (false, _) => across.min(FRAC_PI_2),
        (true, true) => 2.0 * libm::asin((across / PI).min(1.0)),
        (true, false) => {
            (2.0 * libm::asin((across / PI).min(1.0))).min(libm::acos(0.5 * (1.0 + libm::cos(z))))
        }
    };
    let of_x = match (is_vector, is_free) {
        (_, true) => PI,
        (true, false) => libm::acos((1.0 + libm::cos(z) - libm::cos(of_z)).clamp(-1.0, 1.0)),
        (false, false) if z <= FRAC_PI_2 => z,
        (false, false) => libm::acos(libm::cos(z) * libm::cos(of_z.min(FRAC_PI_2))),
    };
    [('z', of_z), ('x', of_x)].into_iter().filter(|(_, most_rad)| *most_rad < PI).collect()
}

#[cfg(test)]
mod tests {
    use cranny_spatial::{Rotation, Stream};

    use super::*;

    /// Rotations within the cones are within the tolerances, and the cones contain a fair share of the rotations within those.
    #[test]
    fn what_is_in_the_cones_is_within_the_tolerances() {
        let mut stream = Stream::new(7, 0);
        for is_vector in [false, true] {
            let all = [
                [0.2, 0.3, PI],
                [0.3, 0.2, 0.5],
                [0.1, 0.4, 2.5],
                [1.0, 1.2, 0.3],
                [0.5, 0.5, 3.1],
                [2.5, 2.5, PI],
                [1.6, 1.6, 1.0],
                [PI, 1.6, 0.4],
                [2.0, 3.0, 3.0],
            ];
            for tolerances in all {
                let cones = cones(tolerances, is_vector);
                let (mut kept, mut within) = (0, 0);
                for _ in 0..40_000 {
                    let mut draw = || stream.uniform_between(-1.0, 1.0);
                    let scale = if tolerances[0].min(tolerances[1]) < 0.6 { 0.6 } else { PI };
                    let across = Vector::new(draw(), draw(), 0.0) * scale;
                    let rotation = Rotation::new(across) * Rotation::new(Vector::z() * draw() * PI);
                    let values: [f64; 3] = if is_vector {
                        rotation.scaled_axis().into()
                    } else {
                        // R = Rx(a) Ry(b) Rz(c).
                        let m = rotation.to_rotation_matrix();
                        [
                            libm::atan2(-m[(1, 2)], m[(2, 2)]),
                            libm::asin(m[(0, 2)]),
                            libm::atan2(-m[(0, 1)], m[(0, 0)]),
                        ]
                    };
                    let is_within =
                        values.iter().zip(tolerances).all(|(value, most)| value.abs() <= most + 1e-9);
                    let angle = |axis: char| {
                        let direction = if axis == 'z' { Vector::z() } else { Vector::x() };
                        (rotation * direction).angle(&direction)
                    };
                    let is_kept = cones.iter().all(|(axis, most_rad)| angle(*axis) <= *most_rad);
                    assert!(!is_kept || is_within, "{tolerances:?} {is_vector} {values:?}");
                    kept += u32::from(is_kept);
                    within += u32::from(is_within);
                }
                // A rotation vector with a tight bound about z is bounded as a whole.
                let is_narrow = is_vector && tolerances[2] < tolerances[0];
                assert!(
                    kept > 0 && (is_narrow || kept * 20 > within),
                    "{tolerances:?} {is_vector}: {kept} of {within}"
                );
            }
        }
    }
}
