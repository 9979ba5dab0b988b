//! Tests that proven motions are free everywhere, and that too small a bound on motion is detected. The oracle is dense
//! sampling of single configurations.

use std::sync::Arc;

use cranny_robot::{Robot, RobotOptions};
use cranny_shape::Solid;
use cranny_spatial::{LANES, Pose, Stream, Vector};
use fearless_simd::Level;
use proptest::prelude::*;

use crate::lane::lane_bits::first_lanes;
use crate::lane::lanes::Interest;
use crate::proof::joint_curve::{JointCurve, Rates};
use crate::proof::motion::Demand;
use crate::proof::travel::Travel;
use crate::{Body, Cell, Margins, MeasureOptions, Motion, World};

/// A slide carrying an arm of two thin links with a small ball at its end.
const ARM: &str = r#"<robot name="arm">
  <link name="rail"/>
  <link name="cart"><collision><geometry><box size="0.1 0.1 0.02"/></geometry></collision></link>
  <link name="upper"><collision><origin xyz="0 0 0.2"/>
    <geometry><capsule radius="0.01" length="0.4"/></geometry></collision></link>
  <link name="lower"><collision><origin xyz="0 0 0.15"/>
    <geometry><cylinder radius="0.008" length="0.3"/></geometry></collision></link>
  <link name="tool"><collision><geometry><sphere radius="0.012"/></geometry></collision></link>
  <joint name="slide" type="prismatic"><parent link="rail"/><child link="cart"/><axis xyz="1 0 0"/>
    <limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
  <joint name="turn" type="revolute"><parent link="cart"/><child link="upper"/><origin xyz="0 0 0.1"/>
    <axis xyz="0 0.6 0.8"/><limit lower="-3" upper="3" velocity="1" effort="1"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/><origin xyz="0 0 0.45"/>
    <axis xyz="1 0 0"/><limit lower="-2.5" upper="2.5" velocity="1" effort="1"/></joint>
  <joint name="reach" type="prismatic"><parent link="lower"/><child link="tool"/><origin xyz="0 0 0.35"/>
    <axis xyz="0 0 1"/><limit lower="0" upper="0.5" velocity="1" effort="1"/></joint>
</robot>"#;

fn arm() -> Arc<Robot> {
    Arc::new(Robot::from_urdf_text(ARM, "arm.urdf", None, &RobotOptions::default()).expect("a good URDF"))
}

fn between(a: &[f64], b: &[f64], at: f64) -> Vec<f64> {
    cranny_robot::between(a, b, at).collect()
}

fn cell(robot: &Arc<Robot>, bodies: Vec<Body>, margin_m: f64) -> Cell {
    let margins = Margins { margin_m, ..Margins::default() };
    Cell::new(robot.clone(), World::new(bodies).expect("finite poses"), margins).expect("a good margin")
}

/// Creates a plate of 1 mm × 6 cm × 6 cm that the tool hits at `at`.
fn plate_in_the_way(robot: &Robot, a: &[f64], b: &[f64], at: f64, random: &mut Stream) -> Body {
    let frames = robot.frames_at(&between(a, b, at));
    let tool = frames.link(robot.tip()).translation;
    let plate = Solid::cuboid(Vector::new(0.0005, 0.03, 0.03)).expect("a positive size");
    Body::new("plate", Pose::from_parts(tool, random.rotation()), plate)
}

fn boxes_on_a_floor(random: &mut Stream) -> Vec<Body> {
    let mut bodies: Vec<Body> = (0..3)
        .map(|i| {
            let size = Vector::new(random.uniform(), random.uniform(), random.uniform()) * 0.1;
            let place = Vector::new(random.uniform(), random.uniform(), random.uniform()) * 1.6;
            let place = place - Vector::new(0.8, 0.8, 0.4);
            let solid = Solid::cuboid(size.add_scalar(0.01)).expect("a positive size");
            Body::new(format!("box {i}"), Pose::from_parts(place.into(), random.rotation()), solid)
        })
        .collect();
    bodies.push(Body::floor(-0.2));
    bodies
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn a_thin_plate_in_the_way_is_never_missed(seed in any::<u64>(), at in 0.0..1.0) {
        let (robot, mut random) = (arm(), Stream::new(seed, 0));
        let (a, b) = (robot.random_configuration(&mut random), robot.random_configuration(&mut random));
        let plate = plate_in_the_way(&robot, &a, &b, at, &mut random);
        let cell = cell(&robot, vec![plate], 0.0);
        let motion = cell.motion_is_free(&a, &b, &mut cell.scratch());
        prop_assert!(matches!(motion, Motion::Contact { .. }), "{motion:?}");
    }

    #[test]
    fn what_is_proven_keeps_its_margin_at_every_sample(seed in any::<u64>(), margin_m in 0.0..0.02) {
        let (robot, mut random) = (arm(), Stream::new(seed, 1));
        let (a, b) = (robot.random_configuration(&mut random), robot.random_configuration(&mut random));
        let cell = cell(&robot, boxes_on_a_floor(&mut random), margin_m);
        let mut scratch = cell.scratch();
        let motion = cell.motion_is_free(&a, &b, &mut scratch);
        let required = margin_m.max(cranny_spatial::CONTACT_M);
        let clearances: Vec<f64> =
            (0..=400).map(|i| cell.clearance(&between(&a, &b, f64::from(i) / 400.0), &mut scratch)).collect();
        let sampled = clearances.iter().copied().fold(f64::INFINITY, f64::min);
        match motion {
            Motion::Proven => {
                prop_assert!(sampled >= required - 1e-9);
                let least = cell.least_clearance(&a, &b, &mut scratch);
                prop_assert!(least <= sampled + 1e-9 && least >= required - 1.1e-5, "{least} {sampled}");
            }
            Motion::Contact { at, contact } => {
                let clearance = cell.clearance(&between(&a, &b, at), &mut scratch);
                prop_assert!(clearance <= required && contact.clearance_m <= required);
                prop_assert!(!cell.is_clear(&between(&a, &b, at), &mut scratch));
            }
            Motion::Unresolved { at, .. } => {
                prop_assert!(cell.clearance(&between(&a, &b, at), &mut scratch) < required + 1e-5);
            }
            Motion::OutOfLimits { .. } | Motion::OutOfBounds { .. } => {
                prop_assert!(false, "both ends are within limits, and nothing is bounded");
            }
        }
    }

    #[test]
    fn a_bubble_ends_before_what_is_in_the_way(seed in any::<u64>(), at in 0.0..1.0) {
        let (robot, mut random) = (arm(), Stream::new(seed, 2));
        let (a, b) = (robot.random_configuration(&mut random), robot.random_configuration(&mut random));
        let plate = plate_in_the_way(&robot, &a, &b, at, &mut random);
        let cell = cell(&robot, vec![plate], 0.0);
        let mut scratch = cell.scratch();
        let share = cell.bubble(&a, 0.0, &mut scratch).map_or(0.0, |found| cell.free_share(&found, &b, &mut scratch));
        prop_assert!(share < at, "{share} of the way is said to be free, but {at} is in the plate");
    }

    #[test]
    fn what_a_bubble_proves_keeps_its_margin_at_every_sample(seed in any::<u64>(), margin_m in 0.0..0.02) {
        let (robot, mut random) = (arm(), Stream::new(seed, 3));
        let cell = cell(&robot, boxes_on_a_floor(&mut random), margin_m);
        let mut scratch = cell.scratch();
        let a = robot.random_configuration(&mut random);
        let Some(bubble) = cell.bubble(&a, 0.0, &mut scratch) else {
            prop_assert!(cell.clearance(&a, &mut scratch) < margin_m + 1e-6);
            return Ok(());
        };
        for _ in 0..5 {
            let b = robot.random_configuration(&mut random);
            let share = cell.free_share(&bubble, &b, &mut scratch);
            for sample in 0..=100 {
                let q = between(&a, &b, share * f64::from(sample) / 100.0);
                prop_assert!(cell.is_clear(&q, &mut scratch), "{sample} % of a spine of {share}");
            }
        }
    }

    #[test]
    fn no_point_of_a_link_moves_farther_than_its_bound(seed in any::<u64>(), half_width in 0.001..0.5) {
        prop_assert!(!bound_is_broken(seed, half_width, 1.0));
        prop_assert!(!bound_of_lanes_is_broken(seed, half_width / 8.0, 1.0));
    }
}

/// Returns the points of a random motion: the ends of a line, or the control points of a curve of up to fourth degree.
fn random_points(robot: &Robot, seed: u64, random: &mut Stream) -> Vec<Vec<f64>> {
    (0..2 + seed % 4).map(|_| robot.random_configuration(random)).collect()
}

fn curve_of(points: &[Vec<f64>]) -> JointCurve<'_> {
    if let [a, b] = points { JointCurve::Line([a, b]) } else { JointCurve::Curve(points) }
}

/// Returns true if a point of a link moves farther than `factor` times its bound within `half_width` of a random motion's
/// middle.
fn bound_is_broken(seed: u64, half_width: f64, factor: f64) -> bool {
    let (robot, mut random) = (arm(), Stream::new(seed, 2));
    let cell = cell(&robot, Vec::new(), 0.0);
    let points = random_points(&robot, seed, &mut random);
    let curve = curve_of(&points);
    let (mut rates, mut middle) = (Rates::still(robot.dof()), vec![0.0; robot.dof()]);
    rates.set(curve);
    curve.place(0.5, &mut middle);
    let mut travel = Travel::new(&robot, &cell.bodies);
    travel.update(&robot, &cell.bodies, &robot.frames_at(&middle), &rates, half_width, factor);
    (0..cell.bodies.len())
        .any(|body| most_moved_m(&cell, body, curve, 0.5, half_width) > travel.of(body) + 1e-12)
}

/// Returns true if a bound of [`bound_is_broken`] is exceeded in one of the intervals that the lanes check at once.
fn bound_of_lanes_is_broken(seed: u64, half_width: f64, factor: f64) -> bool {
    let (robot, mut random) = (arm(), Stream::new(seed, 2));
    // The floor gives the lanes something to check.
    let cell = cell(&robot, vec![Body::floor(-9.0)], 0.0);
    let points = random_points(&robot, seed, &mut random);
    let curve = curve_of(&points);
    let middles = (0..LANES).map(|lane| (lane as f64 + 0.5) / LANES as f64);
    let mut scratch = cell.scratch();
    scratch.rates.set(curve);
    cell.check_at(curve, 0.5, 0.5, &mut scratch, factor);
    cell.set_travel(2.0 * half_width, Demand { factor, ..Demand::default() }, &mut scratch);
    scratch.lanes.set_lanes_along(curve, middles.clone());
    cell.lanes.check(Level::new(), &mut scratch.lanes, first_lanes(LANES), Interest::Each);
    (0..cell.bodies.len()).any(|body| {
        let travels_m = &scratch.lanes.travel.bodies[body];
        middles.clone().zip(travels_m).any(|(middle, travel_m)| {
            most_moved_m(&cell, body, curve, middle, half_width) > f64::from(*travel_m)
        })
    })
}

/// Returns the greatest distance of a point of a link from its position in the middle of an interval of a motion, at samples.
fn most_moved_m(cell: &Cell, body: usize, curve: JointCurve<'_>, middle: f64, half_width: f64) -> f64 {
    let (robot, link) = (cell.robot(), &cell.bodies[body]);
    let mut q = vec![0.0; robot.dof()];
    let mut at = |t: f64| {
        curve.place(t, &mut q);
        *robot.frames_at(&q).link(link.link)
    };
    let here = at(middle);
    let mut most_m: f64 = 0.0;
    // Bounds on the rates of a curve are valid between its ends.
    let places = (0..=20).map(|i| (middle + half_width * (f64::from(i) / 10.0 - 1.0)).clamp(0.0, 1.0));
    for there in places {
        let there = at(there);
        for (link_from_shape, solid) in &link.shapes {
            let (points, _) = solid.bounding_points().expect("links are bounded");
            let moved = points.iter().map(|p| link_from_shape * p).map(|p| (here * p - there * p).norm());
            most_m = moved.fold(most_m, f64::max);
        }
    }
    most_m
}

#[test]
fn half_of_the_bound_is_not_a_bound() {
    assert!((0..200).any(|seed| bound_is_broken(seed, 0.1, 0.5)));
    assert!((0..200).any(|seed| bound_of_lanes_is_broken(seed, 0.01, 0.9)));
}

#[test]
fn half_of_the_bound_lets_thin_plates_through() {
    let (robot, mut random) = (arm(), Stream::new(11, 3));
    let missed = (0..400).filter(|_| {
        let a = robot.random_configuration(&mut random);
        // Only the slide moves: its bound is exact, so half of it leaves gaps.
        let mut b = a.clone();
        b[0] = -a[0].signum() * 0.9;
        let at = random.uniform_between(0.1, 0.9);
        let plate = plate_in_the_way(&robot, &a, &b, at, &mut random);
        let cell = cell(&robot, vec![plate], 0.0);
        assert!(!cell.motion_is_free(&a, &b, &mut cell.scratch()).is_proven());
        cell.prove(
            JointCurve::Line([&a, &b]),
            &mut cell.scratch(),
            Demand { factor: 0.5, ..Demand::default() },
        )
        .is_proven()
    });
    assert!(missed.count() > 0);
}

#[test]
fn a_link_inside_an_obstacle_is_in_contact() {
    let robot = arm();
    let block = Solid::cuboid(Vector::repeat(5.0)).expect("a positive size");
    let cell = cell(&robot, vec![Body::new("block", Pose::identity(), block)], 0.0);
    let mut scratch = cell.scratch();
    assert!(!cell.is_free(&[0.0; 4], &mut scratch));
    let contact = cell.first_contact(&[0.0; 4], &mut scratch).expect("a contact");
    assert!(contact.depth_m > 1.0 && contact.clearance_m <= 0.0);
    assert_eq!(cell.name(contact.second), "block");
}

#[test]
fn an_end_outside_the_limits_is_named() {
    let robot = arm();
    let cell = cell(&robot, Vec::new(), 0.0);
    let motion = cell.motion_is_free(&[0.0; 4], &[0.0, 0.0, 2.6, 0.0], &mut cell.scratch());
    assert_eq!(motion, Motion::OutOfLimits { joint: 2 });
}

/// In an empty world rays are long; NaN gives no certain result.
#[test]
fn a_bubble_is_as_large_as_the_room_that_there_is() {
    let robot = arm();
    let cell = cell(&robot, vec![Body::floor(-10.0)], 0.0);
    let mut scratch = cell.scratch();
    let a = [0.0; 4];
    let bubble = cell.bubble(&a, 0.1, &mut scratch).expect("nothing is near");
    assert!(cell.free_share(&bubble, &[0.4, 0.0, 0.0, 0.0], &mut scratch) >= 1.0);
    assert!(cell.free_share(&bubble, &[1.0, 0.0, 0.0, 0.0], &mut scratch) < 1.0);
    assert!(cell.free_share(&bubble, &[f64::NAN, 0.0, 0.0, 0.0], &mut scratch) <= 0.0);
    assert!(cell.bubble(&[f64::NAN; 4], 0.0, &mut scratch).is_none());
    assert!(cell.bubble(&a, 20.0, &mut scratch).is_none());
}

/// The measurement does not depend on the data of the proof: tables of another world let the proof pass, and the measurement
/// contradicts it.
#[test]
fn a_proof_on_wrong_tables_is_contradicted_by_what_is_measured() {
    let robot = arm();
    let mut random = Stream::new(11, 0);
    let mut contradicted = 0;
    for _ in 0..200 {
        let (a, b) = (robot.random_configuration(&mut random), robot.random_configuration(&mut random));
        let at = random.uniform_between(0.2, 0.8);
        let plate = plate_in_the_way(&robot, &a, &b, at, &mut random);
        let mut elsewhere = plate.clone();
        elsewhere.parts[0].world_from_solid.translation.x += 50.0;
        let sound = cell(&robot, vec![elsewhere], 0.0);
        let mut wrong = cell(&robot, vec![plate], 0.0);
        let mut scratch = wrong.scratch();
        if sound.motion_is_free(&a, &b, &mut sound.scratch()) != Motion::Proven
            || !wrong.contacts(&a, &mut scratch).is_empty()
        {
            continue;
        }
        wrong.lanes = sound.lanes;
        if wrong.motion_is_free(&a, &b, &mut scratch) == Motion::Proven {
            let (place, contact) = wrong
                .measure_motion([&a, &b], MeasureOptions::default(), &mut scratch)
                .contradiction
                .expect("the plate");
            assert!(wrong.contacts(&between(&a, &b, place), &mut scratch).contains(&contact));
            assert!(contact.clearance_m < cranny_spatial::CONTACT_M);
            contradicted += 1;
        }
    }
    assert!(contradicted > 20, "{contradicted}");
}
