//! Setup of the built-in robots from their URDFs alone, compared with their own files.

use cranny_robot::{HandJoint, Robot, RobotOptions};
use cranny_scenario::{BUILTIN_ROBOTS, BuiltinRobot};
use cranny_setup::{RobotFindings, RobotSetup, SetupOptions};
use cranny_spatial::Pose;

fn from_urdf_alone(builtin: &BuiltinRobot) -> RobotSetup {
    let folder = tempfile::tempdir().unwrap();
    let urdf = builtin.write(folder.path()).unwrap();
    std::fs::remove_file(urdf.with_extension("srdf")).unwrap();
    RobotSetup::of(&urdf, &SetupOptions::default()).unwrap()
}

fn tip(robot: &Robot) -> Pose {
    let q: Vec<f64> = robot.limits().iter().map(|limits| limits.clamp(0.0)).collect();
    *robot.frames_at(&q).link(robot.tip())
}

#[test]
fn the_hand_and_its_frame_are_found() {
    for builtin in BUILTIN_ROBOTS {
        let setup = from_urdf_alone(builtin);
        let own = builtin.robot(&RobotOptions::default()).unwrap();
        let (found, known) = (setup.robot.hand().unwrap(), own.hand().unwrap());
        // Only the built-in robots have accelerations, in their limits.yaml.
        let of_urdf = |joints: &[HandJoint]| -> Vec<HandJoint> {
            joints.iter().map(|joint| HandJoint { acceleration: None, ..*joint }).collect()
        };
        assert_eq!(of_urdf(&found.joints), of_urdf(&known.joints), "{}", builtin.name);
        let (found, known) = (&found.description, &known.description);
        for (joint, range) in &found.fingers {
            assert!((range.open - known.fingers[joint].open).abs() < 1e-9, "{}: {joint}", builtin.name);
            assert!((range.closed - known.fingers[joint].closed).abs() < 0.02, "{}: {joint}", builtin.name);
        }
        assert!((found.opening_m - known.opening_m).abs() < 2e-3, "{}: {}", builtin.name, found.opening_m);
        let between = tip(&own).inv_mul(&tip(&setup.robot));
        assert!(between.translation.vector.norm() < 1e-9, "{}: {between}", builtin.name);
        assert!(between.rotation.angle() < 1e-9, "{}: {between}", builtin.name);
        assert_eq!(setup.robot.joint_names(), own.joint_names());
    }
}

#[test]
fn what_is_written_is_read_back_and_sound() {
    let folder = tempfile::tempdir().unwrap();
    for builtin in BUILTIN_ROBOTS {
        let setup = from_urdf_alone(builtin);
        let written = folder.path().join(builtin.name);
        setup.write(&written).unwrap();
        let robot = std::sync::Arc::new(Robot::load(&written, &RobotOptions::default()).unwrap());
        assert_eq!(robot.default_start(), setup.robot.default_start());
        assert_eq!(robot.hand(), setup.robot.hand());
        assert_eq!(robot.disabled_pairs(), setup.robot.disabled_pairs());
        assert!(robot.limits().iter().all(|limits| limits.acceleration.is_some() && limits.jerk.is_some()));
        let findings = RobotFindings::of(&robot).unwrap();
        assert!(findings.is_sound(), "{}: {findings:?}", builtin.name);
    }
}
