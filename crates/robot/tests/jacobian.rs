//! Jacobians against central differences of the pose, and the laws of the pseudo-inverse.

use cranny_robot::{DampedInverse, Robot, Twist, damped_pseudo_inverse_step};
use cranny_spatial::nalgebra::DVector;
use proptest::prelude::*;

/// Increment of the central difference: its error is of the order of its square, that of rounding of 10⁻¹⁶ / STEP.
const STEP: f64 = 1e-5;

fn assert_is_derivative(robot: &Robot, q: &[f64], link: usize) {
    let mut frames = robot.frames();
    robot.forward_kinematics(q, &mut frames);
    let mut jacobian = robot.empty_jacobian();
    robot.jacobian(&frames, link, &mut jacobian);
    for joint in 0..robot.dof() {
        let mut moved = q.to_vec();
        let [(before, _), (after, rotation)] = [-STEP, STEP].map(|step| {
            moved[joint] = q[joint] + step;
            robot.forward_kinematics(&moved, &mut frames);
            (*frames.link(link), frames.link(link).rotation)
        });
        let linear = (after.translation.vector - before.translation.vector) / (2.0 * STEP);
        let angular = (rotation * before.rotation.conjugate()).scaled_axis() / (2.0 * STEP);
        let column = jacobian.column(joint);
        assert!((column.fixed_rows::<3>(0) - linear).norm() < 1e-8, "{joint} {column} {linear}");
        assert!((column.fixed_rows::<3>(3) - angular).norm() < 1e-8, "{joint} {column} {angular}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn jacobian_is_the_derivative_of_the_pose(parts in prop::collection::vec(0.0..1.0, 9), link in 0usize..16) {
        let arm = crate::fixture::mobile_arm();
        assert_is_derivative(&arm, &crate::fixture::within_limits(&arm, &parts), link);
        let mimic = crate::fixture::mimic();
        assert_is_derivative(&mimic, &crate::fixture::within_limits(&mimic, &parts), link % 5);
    }

    #[test]
    fn damped_step_minimises_residual_and_length(
        parts in prop::collection::vec(0.0..1.0, 9),
        twist in prop::array::uniform6(-1.0..1.0),
        damping in 0.01..1.0,
    ) {
        // The oracle is the equivalent formula over joints: (JᵀJ + λ²I) dq = Jᵀ v.
        let robot = crate::fixture::mobile_arm();
        let frames = robot.frames_at(&crate::fixture::within_limits(&robot, &parts));
        let mut jacobian = robot.empty_jacobian();
        robot.jacobian(&frames, robot.tip(), &mut jacobian);
        let twist = Twist::from(twist);
        let mut step = vec![0.0; 9];
        prop_assert!(damped_pseudo_inverse_step(&jacobian, &twist, damping, &mut step));
        let mut normal = jacobian.transpose() * &jacobian;
        (0..9).for_each(|i| normal[(i, i)] += damping * damping);
        let expected = normal.lu().solve(&(jacobian.transpose() * twist)).unwrap();
        prop_assert!((DVector::from(step) - expected).norm() < 1e-9);
    }

    #[test]
    fn null_space_motion_does_not_move_the_frame(
        parts in prop::collection::vec(0.0..1.0, 9),
        motion in prop::collection::vec(-1.0..1.0, 9),
    ) {
        let robot = crate::fixture::mobile_arm();
        let frames = robot.frames_at(&crate::fixture::within_limits(&robot, &parts));
        let mut jacobian = robot.empty_jacobian();
        robot.jacobian(&frames, robot.tip(), &mut jacobian);
        let mut projected = motion.clone();
        let inverse = DampedInverse::new(&jacobian, 1e-6).unwrap();
        inverse.project_to_null_space(&jacobian, &mut projected);
        let moved = &jacobian * DVector::from(projected.clone());
        prop_assert!(moved.norm() < 1e-6, "{moved}");
        // A projection is idempotent.
        let mut twice = projected.clone();
        inverse.project_to_null_space(&jacobian, &mut twice);
        prop_assert!((DVector::from(twice) - DVector::from(projected)).norm() < 1e-6);
    }
}

#[test]
fn an_undamped_step_at_a_singularity_is_refused() {
    let robot = crate::fixture::mobile_arm();
    let mut jacobian = robot.empty_jacobian();
    let mut step = vec![7.0; 9];
    assert!(!damped_pseudo_inverse_step(&jacobian, &Twist::repeat(1.0), 0.0, &mut step));
    assert_eq!(step, vec![7.0; 9]);
    jacobian[(0, 0)] = 1.0;
    assert!(damped_pseudo_inverse_step(&jacobian, &Twist::repeat(1.0), 0.1, &mut step));
}
