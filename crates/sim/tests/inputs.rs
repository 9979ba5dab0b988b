//! Tests of default inputs and of rejected ones.

use cranny_grasp::{BoxHand, ShakeTest};
use cranny_scenario::{Friction, builtin_object};
use cranny_sim::{Disturbance, GraspTest, Physics, SimError, Uncertainty};
use cranny_spatial::{Pose, PoseDifference, Vector};

fn fault(change: impl Fn(&mut cranny_grasp::Hand, &mut Physics, &mut ShakeTest)) -> SimError {
    let mut hand = BoxHand::default().hand().unwrap();
    let (mut physics, mut shake_test) = (Physics::default(), ShakeTest::default());
    change(&mut hand, &mut physics, &mut shake_test);
    let ball = builtin_object("tennis_ball").unwrap();
    GraspTest::new(&hand, &ball, Pose::identity(), &[], physics, shake_test).unwrap_err()
}

#[test]
fn a_hand_that_cannot_close_is_refused() {
    assert!(fault(|hand, _, _| hand.fingers.clear()).to_string().contains("no fingers that slide"));
    assert!(fault(|hand, _, _| hand.fingers[1].stroke_m *= 0.0).to_string().contains("finger 2"));
    for force_n in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(fault(|hand, _, _| hand.closing_force_n = force_n).to_string().contains("closing force"));
    }
}

#[test]
fn constants_out_of_their_range_are_refused() {
    for (figure, said) in [
        (fault(|_, physics, _| physics.step_s = 0.01), "step"),
        (fault(|_, physics, _| physics.solver_iterations = 0), "iterations"),
        (fault(|_, physics, _| physics.gravity = f64::NAN), "gravity"),
        (fault(|_, physics, _| physics.drive_stiffness = 1e6), "stiffness"),
        (fault(|_, _, shake_test| shake_test.lift_s = 0.0), "time of the lift"),
        (fault(|_, _, shake_test| shake_test.shake_hz = f64::INFINITY), "frequency"),
        (fault(|_, _, shake_test| shake_test.slip_m = -1.0), "limit of slip"),
    ] {
        assert!(figure.to_string().contains(said), "{figure}");
    }
}

#[test]
fn the_hand_goes_up_and_to_and_fro_without_a_jump() {
    let shake_test = ShakeTest::default();
    let closed = Pose::translation(0.3, 0.0, 0.5);
    let at = |time_s| shake_test.world_from_hand(&closed, &Vector::z(), time_s);
    assert!(PoseDifference::between(&closed, &at(0.0)).translation_m < 1e-12);
    let end = PoseDifference::between(&Pose::translation(0.3, 0.0, 0.6), &at(shake_test.duration_s()));
    assert!(end.translation_m < 1e-12 && end.rotation_rad < 1e-9);
    let (mut farthest_m, mut farthest_rad, mut time_s) = (0.0_f64, 0.0_f64, 0.0);
    while time_s < shake_test.duration_s() {
        let step = PoseDifference::between(&at(time_s), &at(time_s + 1e-4));
        // The limits are 0.5 m/s and 6 rad/s.
        assert!(step.translation_m < 5e-5 && step.rotation_rad < 6e-4, "at {time_s} s");
        let off = PoseDifference::between(&Pose::translation(0.3, 0.0, 0.6), &at(time_s));
        if time_s > shake_test.lift_s {
            farthest_m = farthest_m.max(off.translation_m);
            farthest_rad = farthest_rad.max(off.rotation_rad);
        }
        time_s += 1e-4;
    }
    assert!(farthest_m > 0.85 * shake_test.shake_m && farthest_m <= shake_test.shake_m, "{farthest_m} m");
    assert!(
        farthest_rad > 0.85 * shake_test.shake_rad && farthest_rad <= shake_test.shake_rad,
        "{farthest_rad} rad"
    );
}

#[test]
fn disturbances_fill_their_ranges_evenly() {
    let uncertainty = Uncertainty::default();
    let design = uncertainty.design(32, 7);
    assert_eq!(design, uncertainty.design(32, 7));
    assert_ne!(design, uncertainty.design(32, 8));
    let mut parts: Vec<f64> =
        design.iter().map(|d| ((d.friction - 1.0) / uncertainty.friction * 16.0).floor()).collect();
    parts.sort_by(f64::total_cmp);
    assert_eq!(parts, (-16..16).map(f64::from).collect::<Vec<f64>>());
    let range = Friction { low: 0.35, high: 0.6 };
    let mut drawn: Vec<f64> = design.iter().map(|d| (d.friction_of(&range) - 0.35) / 0.25 * 32.0).collect();
    drawn.sort_by(f64::total_cmp);
    assert!(
        drawn.iter().enumerate().all(|(part, value)| (value - part as f64 - 0.5).abs() < 0.5),
        "{drawn:?}"
    );
    assert!(
        (Disturbance::default().friction_of(&range) - 0.35).abs() < 1e-12,
        "the lower end without errors"
    );
    for disturbance in design {
        let [x, y, z] = disturbance.grasp_from_hand.translation.vector.into();
        assert!([x, y, z].iter().all(|m: &f64| m.abs() <= uncertainty.position_m));
        assert!((disturbance.mass - 1.0).abs() <= uncertainty.mass);
    }
}
