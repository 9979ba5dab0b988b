use cranny_shape::{Surface, TriangleSoup};
use cranny_spatial::nalgebra::{Matrix3, Rotation3};
use cranny_spatial::{Point, Pose, Vector};

use crate::{HeldObject, Load, LoadMeasure, LoadState, Pads, ShakeTest};

/// Rubber tips of a Franka hand.
const FRANKA: Pads =
    Pads { middle_m: [0.0, 0.0], half_m: [0.00875, 0.00925], opening_m: 0.08, faces_m: [0.04, -0.04] };

/// Load of a bar along x, 30 mm wide, of 0.3 kg, held beside its centre of mass with 20 N.
fn bar(beside_m: f64, friction: f64, states: Vec<LoadState>) -> Load {
    let half = Vector::new(0.15, 0.015, 0.015);
    let object = HeldObject {
        surface: Surface::new(&Surface::cuboid_soup(&half)).unwrap(),
        mass_kg: 0.3,
        center: Point::origin(),
        inertia_kg_m2: Matrix3::from_diagonal(&Vector::new(4.5e-5, 2.3e-3, 2.3e-3)),
        friction,
    };
    let measure = LoadMeasure::new(object, FRANKA, 20.0, Vector::z(), states);
    measure.of(&Pose::translation(beside_m, 0.0, 0.0))
}

/// Least friction from statics: the maximum over centres of turning of |M − f c| by F · mean distance.
#[test]
fn a_bar_held_beside_its_centre_needs_the_friction_of_statics() {
    for (beside_m, least) in [(0.0, 0.0736), (0.02, 0.231), (0.04, 0.436), (0.06, 0.647)] {
        // The factor is proportional to friction, except for the share that a turn during closing would take.
        let found = least / bar(beside_m, least, Vec::new()).at_rest;
        assert!((found / least - 1.0).abs() < 0.03, "{beside_m} m: {found}, not {least}");
    }
}

/// A wedge that widens along x is squeezed out unless friction exceeds the slope of its sides. A slope leaves less friction
/// across it, and still less in its direction, but more against it. A roof whose ridge lies under the pads is not squeezed out.
#[test]
fn a_wedge_slips_out_where_its_slope_exceeds_friction() {
    let slope = 0.3;
    let load = |widths: [f64; 3], friction: f64, up: Vector| {
        // Below the centre of pressure: a wedge bears on the last of four columns of cells.
        let is_wedge = widths[2] > widths[1];
        let center = Point::new(if is_wedge { 0.75 * FRANKA.half_m[0] } else { 0.0 }, 0.0, 0.0);
        let mut outline = Vec::new();
        for (x, width_m) in [-0.06, 0.0, 0.06].into_iter().zip(widths) {
            outline.push(Point::new(x, 0.5 * width_m, 0.0));
        }
        for (x, width_m) in [0.06, 0.0, -0.06].into_iter().zip([widths[2], widths[1], widths[0]]) {
            outline.push(Point::new(x, -0.5 * width_m, 0.0));
        }
        let at = |z: f64| outline.iter().map(move |corner| corner + Vector::z() * z);
        let vertices: Vec<Point> = at(-0.03).chain(at(0.03)).collect();
        let mut triangles = vec![[0, 1, 4], [0, 4, 5], [1, 2, 3], [1, 3, 4]];
        triangles.extend([[6, 10, 7], [6, 11, 10], [7, 9, 8], [7, 10, 9]]);
        for side in 0..6 {
            let next = (side + 1) % 6;
            triangles.extend([[side, side + 6, next], [next, side + 6, next + 6]]);
        }
        let object = HeldObject {
            surface: Surface::new(&TriangleSoup { vertices, triangles }).unwrap(),
            mass_kg: 0.1,
            center,
            inertia_kg_m2: Matrix3::identity() * 1e-4,
            friction,
        };
        LoadMeasure::new(object, FRANKA, 40.0, up, Vec::new()).of(&Pose::identity()).at_rest
    };
    let rise = 2.0 * slope * 0.06;
    let wedge = |friction: f64, up: Vector| load([0.04 - rise, 0.04, 0.04 + rise], friction, up);
    assert!(wedge(0.99 * slope, Vector::z()) < 1e-9);
    let friction = 0.5;
    let flat = load([0.04; 3], friction, Vector::z());
    // Gravity pulls across, with the push towards the thick end, and against it.
    for (up, share) in [
        (Vector::z(), (1.0 - (slope / friction).powi(2)).sqrt()),
        (-Vector::x(), 1.0 - slope / friction),
        (Vector::x(), 1.0 + slope / friction),
    ] {
        let found = wedge(friction, up) / flat;
        assert!((found / share - 1.0).abs() < 0.03, "{up}: {found}, not {share}");
    }
    assert!(load([0.04 - rise, 0.04, 0.04 - rise], 0.2, Vector::z()) > 1.0);
}

/// A bar that is level at rest is held least on end or across; held at its middle, gravity has no lever.
#[test]
fn no_attitude_holds_less_than_the_worst() {
    let half = Vector::new(0.15, 0.015, 0.015);
    let object = HeldObject {
        surface: Surface::new(&Surface::cuboid_soup(&half)).unwrap(),
        mass_kg: 0.3,
        center: Point::origin(),
        inertia_kg_m2: Matrix3::from_diagonal(&Vector::new(4.5e-5, 2.3e-3, 2.3e-3)),
        friction: 0.5,
    };
    let measure = LoadMeasure::new(object, FRANKA, 20.0, Vector::z(), Vec::new());
    let worst = [0.0, 0.02, 0.04].map(|beside_m| {
        let grip = measure.grip(&Pose::translation(beside_m, 0.0, 0.0)).unwrap();
        let worst = grip.factor_in_any_attitude();
        for turn in [Vector::zeros(), Vector::x(), Vector::y() * 2.0, Vector::new(1.0, -1.0, 0.5)] {
            // The attitudes are at most 28° from one of those that are tried.
            let turn = Rotation3::new(turn);
            let other = grip.factor(&LoadState { turn, ..LoadState::GRAVITY });
            assert!(other > 0.85 * worst, "{beside_m} m, {turn}: {other} below {worst}");
        }
        assert!(worst <= grip.factor(&LoadState::GRAVITY));
        worst
    });
    assert!(worst[0] > worst[1] && worst[1] > worst[2], "{worst:?}");
}

#[test]
fn a_lift_costs_as_much_as_it_accelerates() {
    let lift = LoadState { lift: 2.31, ..LoadState::GRAVITY };
    for beside_m in [0.0, 0.04] {
        let Load { at_rest, in_motion, .. } = bar(beside_m, 0.5, vec![LoadState::GRAVITY, lift]);
        let alone = bar(beside_m, 0.5, vec![LoadState::GRAVITY]).in_motion;
        assert!((alone / in_motion - (9.81 + 2.31) / 9.81).abs() < 1e-6, "{beside_m}");
        assert!((alone / at_rest - 1.0).abs() < 0.08, "{alone} by the ellipsoid, {at_rest}");
    }
}

#[test]
fn hands_that_close_on_nothing_hold_nothing() {
    assert_eq!(
        bar(0.5, 0.5, LoadState::along(&ShakeTest::default())),
        Load { at_rest: 0.0, in_motion: 0.0, turn_rad: 0.0, shift_m: 0.0, width_m: 0.0 }
    );
}

#[test]
fn the_twin_of_a_grasp_holds_as_firmly() {
    let states = LoadState::along(&ShakeTest::default());
    let soup = TriangleSoup::geodesic_sphere(0.03, 3);
    let object = HeldObject {
        surface: Surface::new(&soup).unwrap(),
        mass_kg: 0.2,
        center: Point::new(0.004, 0.001, -0.003),
        inertia_kg_m2: Matrix3::identity() * 7e-5,
        friction: 0.4,
    };
    let measure = LoadMeasure::new(object, FRANKA, 30.0, Vector::z(), states);
    let pose = Pose::new(Vector::new(0.003, -0.002, 0.004), Vector::new(0.3, -0.2, 0.1));
    let twin = pose * Pose::rotation(Vector::z() * std::f64::consts::PI);
    let (first, second) = (measure.of(&pose), measure.of(&twin));
    assert!((first.at_rest / second.at_rest - 1.0).abs() < 1e-3, "{first:?} {second:?}");
    assert!(first.in_motion < first.at_rest);
}

/// Motions of the hand are the derivatives of its pose during the shake test.
#[test]
fn the_states_of_a_course_are_its_derivatives() {
    let shake_test = ShakeTest::default();
    let states = LoadState::along(&shake_test);
    // 0.5 s of lifting, and two periods of 0.2 s on each of three axes.
    assert_eq!(states.len(), 25 + 3 * 100);
    let closed = Pose::new(Vector::new(0.1, 0.2, 0.3), Vector::new(0.4, -0.3, 0.2));
    let step_s = 1e-4;
    for (index, state) in states.iter().enumerate() {
        let time_s = if index < 25 {
            (index as f64 + 0.5) * 0.02
        } else {
            shake_test.lift_s + ((index - 25) as f64 + 0.5) * 0.004
        };
        let at = |offset: f64| {
            shake_test.world_from_hand(&closed, &Vector::z(), time_s + offset).translation.vector
        };
        let found = (at(step_s) - 2.0 * at(0.0) + at(-step_s)) / (step_s * step_s);
        let expected = Vector::z() * state.lift + closed.rotation * state.acceleration;
        assert!((found - expected).norm() < 2e-2, "{index}: {found} {expected}");
    }
}
