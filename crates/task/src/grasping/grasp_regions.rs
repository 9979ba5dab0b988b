use cranny_collision::Body;
use cranny_shape::{Outline, Roundness, VolumeMoments};
use cranny_spatial::{Pose, Rotation, Vector};

use crate::grasping::load_model::soup_in_world;
use crate::stages::pose_bounds::rotation_of;
use crate::{Moved, PoseBounds, Region, RegionFrame};

/// Returns the regions of the poses at which the hand is to an object as at one grasp, `world_from_gripper`, by the symmetry of
/// the object:
///
/// - a ball: any rotation about its centre;
/// - a round object: any turn about its axis;
/// - a cylinder or a capsule: the same, slid along the axis while the gripper frame stays between its ends, and from the other
///   end;
/// - a box: half a turn about each of its axes;
/// - any other object: the grasp alone.
///
/// The planner decides where in a region the hand is free.
pub fn grasp_regions(body: &Body, world_from_gripper: &Pose) -> Vec<Region> {
    let only = match &body.parts[..] {
        [part] => Some((part.world_from_solid, part.solid.outline())),
        _ => None,
    };
    let turned = |frame: &Pose, rpy: [f64; 3]| {
        Pose::from_parts(Vector::zeros().into(), rotation_of(rpy)) * frame.inverse() * world_from_gripper
    };
    let half_turns = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let half_turns = half_turns.map(|rpy| rpy.map(|turns: f64| turns * std::f64::consts::PI));
    match only {
        Some((
            frame,
            Outline::Segment { half_length_m: half_m, .. } | Outline::Cylinder { half_length_m: half_m, .. },
        )) if half_m > 0.0 => {
            let about = |rpy| {
                let end = turned(&frame, rpy);
                let along_m = end.translation.z.clamp(-half_m, half_m);
                about_axis(frame, [-half_m - along_m, half_m - along_m], end)
            };
            vec![about(half_turns[0]), about(half_turns[1])]
        }
        Some((frame, Outline::Segment { .. })) => vec![about_centre(frame, turned(&frame, half_turns[0]))],
        Some((frame, Outline::Cuboid { .. })) => {
            half_turns.map(|rpy| fixed(frame, turned(&frame, rpy))).to_vec()
        }
        _ => {
            let frame = round_frame(body);
            let region = match frame {
                Some((frame, true)) => about_centre(frame, turned(&frame, half_turns[0])),
                Some((frame, false)) => about_axis(frame, [0.0; 2], turned(&frame, half_turns[0])),
                None => fixed(*world_from_gripper, Pose::identity()),
            };
            vec![region]
        }
    }
}

/// Returns the frame of a round body, with z along its axis, and true if it is a ball.
fn round_frame(body: &Body) -> Option<(Pose, bool)> {
    let soup = soup_in_world(body)?;
    let center = VolumeMoments::of_mesh(&soup).ok()?.center;
    let at = |rotation| Pose::from_parts(center.coords.into(), rotation);
    match Roundness::of_mesh(&soup).ok()? {
        Roundness::None => None,
        Roundness::Ball => Some((at(Rotation::identity()), true)),
        Roundness::About(axis) => {
            // Either direction of the axis is the same axis.
            let axis = if axis.z < 0.0 { -axis.into_inner() } else { axis.into_inner() };
            let rotation = Rotation::rotation_between(&Vector::z(), &axis).unwrap_or_default();
            Some((at(rotation), false))
        }
    }
}

fn region(pose: Pose, slide_m: [f64; 2], rpy_deg: [[f64; 2]; 3], end: Pose) -> Region {
    let bounds = PoseBounds::Intervals { position_m: [[0.0; 2], [0.0; 2], slide_m], rpy_deg };
    Region { moved: Moved::Hand, frames: vec![RegionFrame { pose, bounds, end }] }
}

fn about_axis(frame: Pose, slide_m: [f64; 2], end: Pose) -> Region {
    region(frame, slide_m, [[0.0; 2], [0.0; 2], [-180.0, 180.0]], end)
}

fn about_centre(frame: Pose, end: Pose) -> Region {
    region(frame, [0.0; 2], [[-180.0, 180.0], [-90.0, 90.0], [-180.0, 180.0]], end)
}

fn fixed(frame: Pose, end: Pose) -> Region {
    region(frame, [0.0; 2], [[0.0; 2]; 3], end)
}

#[cfg(test)]
mod tests {
    use cranny_shape::Solid;
    use cranny_spatial::Stream;

    use super::*;

    /// Every pose of the regions has the gripper as far from the surface, and from the axis, as at the grasp.
    #[test]
    fn poses_of_the_regions_are_those_of_the_grasp_on_a_turned_object() {
        let at = Pose::from_parts(Vector::new(0.4, -0.2, 0.3).into(), rotation_of([0.3, -0.7, 1.1]));
        let half_m = Vector::new(0.02, 0.03, 0.05);
        let solids = [(Solid::sphere(0.03), 1), (Solid::cylinder(0.05, 0.02), 2), (Solid::cuboid(half_m), 4)];
        let grasp =
            at * Pose::from_parts(Vector::new(0.04, 0.01, 0.02).into(), rotation_of([0.4, 0.2, -2.0]));
        for (solid, count) in solids {
            let body = Body::new("object", at, solid.expect("a positive size"));
            let regions = grasp_regions(&body, &grasp);
            assert_eq!(regions.len(), count);
            assert!(regions.iter().any(|region| region.off(&grasp).is_exact()));
            let here = at.inverse() * grasp;
            let mut random = Stream::new(1, 0);
            for pose in regions.iter().flat_map(|region| [region.draw(&mut random), region.draw(&mut random)])
            {
                let there = at.inverse() * pose;
                let [a, b] = [here, there].map(|pose| pose.translation.vector);
                match count {
                    1 => assert!((a.norm() - b.norm()).abs() < 1e-9),
                    2 => assert!((a.xy().norm() - b.xy().norm()).abs() < 1e-9 && b.z.abs() <= 0.05 + 1e-9),
                    _ => assert!((a.abs() - b.abs()).norm() < 1e-9),
                }
            }
        }
    }

    #[test]
    fn a_round_mesh_has_turns_about_its_axis_and_another_none() {
        let mesh = |solid: Solid| Solid::mesh(&solid.tessellation().expect("bounded")).expect("closed");
        let can = Body::new("can", Pose::identity(), mesh(Solid::cylinder(0.05, 0.02).expect("a size")));
        let box_mesh = Body::new(
            "box",
            Pose::identity(),
            mesh(Solid::cuboid(Vector::new(0.02, 0.03, 0.05)).expect("a size")),
        );
        let grasp = Pose::translation(0.03, 0.0, 0.01);
        let turned = Pose::from_parts(Vector::zeros().into(), rotation_of([0.0, 0.0, 1.0])) * grasp;
        let can = grasp_regions(&can, &grasp);
        assert!(can[0].off(&turned).is_exact() && can[0].off(&grasp).is_exact());
        let other = grasp_regions(&box_mesh, &grasp);
        assert!(!other[0].off(&turned).is_exact() && other[0].off(&grasp).is_exact());
    }
}
