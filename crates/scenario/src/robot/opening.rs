use cranny_robot::Robot;
use cranny_shape::{Solid, separation};
use cranny_spatial::Pose;

/// Maximum opening of a hand, in metres.
const WIDEST_M: f64 = 1.0;

/// Distance below which a point counts as touching, in metres: too small to matter in a picture or a drawing.
const TOUCHED_M: f64 = 1e-5;

/// Returns the distance between the pads of a robot's open hand, measured on its collision geometry, in metres: along the y
/// axis of the gripper frame, from its origin to either side. `None` if there is geometry at the origin, or none on a side.
pub fn measured_opening_m(robot: &Robot) -> Option<f64> {
    // A tiny sphere represents the point.
    let point = Solid::sphere(1e-6).ok()?;
    let mut frames = robot.frames();
    robot.forward_kinematics(&vec![0.0; robot.dof()], &mut frames);
    let root_from_tip = frames.link(robot.tip());
    let bodies: Vec<(&Solid, Pose)> = robot
        .hand_links()
        .iter()
        .flat_map(|&link| robot.links()[link].collisions.iter().map(move |shape| (link, shape)))
        .map(|(link, shape)| (&shape.solid, frames.link(link) * shape.link_from_shape))
        .collect();
    let distance_m = |place_m: f64| {
        let root_from_point = root_from_tip * Pose::translation(0.0, place_m, 0.0);
        let to = |(solid, root_from_solid): &(&Solid, Pose)| {
            separation(&point, &root_from_point, solid, root_from_solid, f64::INFINITY).lower_m
        };
        bodies.iter().map(to).fold(f64::INFINITY, f64::min)
    };
    // The distance is a lower bound, so an advance by it passes through nothing.
    let to_side_m = |side: f64| {
        let mut gone_m = 0.0;
        while gone_m < WIDEST_M {
            let free_m = distance_m(side * gone_m);
            if free_m <= TOUCHED_M {
                return (gone_m > 0.0).then_some(gone_m);
            }
            gone_m += free_m;
        }
        None
    };
    Some(to_side_m(1.0)? + to_side_m(-1.0)?)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::{BUILTIN_ROBOTS, RecipeRobot, wide_opening};

    #[test]
    fn the_fingers_of_the_built_in_robots_are_as_far_apart_as_their_files_say() {
        for builtin in BUILTIN_ROBOTS {
            let robot = RecipeRobot::load(Path::new(builtin.name)).unwrap().robot;
            let said_m = robot.hand().unwrap().description.opening_m;
            let measured_m = measured_opening_m(&robot).unwrap();
            assert!((measured_m - said_m).abs() < 2e-3, "{}: {said_m} {measured_m}", builtin.name);
            assert_eq!(wide_opening(&robot), None, "{}", builtin.name);
        }
    }

    #[test]
    fn a_hand_that_is_said_to_open_wider_than_it_does_is_doubted() {
        let folder = tempfile::tempdir().unwrap();
        let urdf = RecipeRobot::of_the_paper().unwrap().write(folder.path()).unwrap();
        let file = folder.path().join("robot.yaml");
        let text = std::fs::read_to_string(&file).unwrap();
        std::fs::write(&file, text.replace("opening_m: 0.08", "opening_m: 0.12")).unwrap();
        let doubt = wide_opening(&RecipeRobot::load(&urdf).unwrap().robot).unwrap();
        assert!(doubt.contains("120.0 mm") && doubt.contains("81.1 mm apart"), "{doubt}");
    }
}
