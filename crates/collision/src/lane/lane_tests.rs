//! Tests that the verdict of the lanes is that of the exact check under every instruction set, and that too small a slack is
//! detected.

use std::sync::Arc;

use cranny_robot::{Robot, RobotOptions};
use cranny_shape::{BoxUnion, Solid};
use cranny_spatial::{LANES, Pose, Stream, Vector, simd_levels};
use cranny_test_robots::ball;
use fearless_simd::Level;
use proptest::prelude::*;

use crate::lane::lane_bits::{first_lanes, lanes_of};
use crate::lane::lane_vector::narrow;
use crate::lane::lanes::Interest;
use crate::{Body, Cell, Margins, World};

/// A slide carrying an arm with links of every shape, and two fingers.
const ARM: &str = r#"<robot name="arm">
  <link name="rail"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
  <link name="cart"><collision><origin xyz="0 0 0.1"/><geometry><box size="0.2 0.1 0.04"/></geometry></collision></link>
  <link name="upper"><collision><origin xyz="0 0 0.2"/>
    <geometry><capsule radius="0.03" length="0.4"/></geometry></collision></link>
  <link name="lower"><collision><origin xyz="0 0 0.15"/>
    <geometry><cylinder radius="0.03" length="0.3"/></geometry></collision></link>
  <link name="palm"><collision><geometry><sphere radius="0.05"/></geometry></collision></link>
  <link name="left"><collision><origin xyz="0 0.04 0.08"/><geometry><box size="0.02 0.01 0.06"/></geometry></collision></link>
  <link name="right"><collision><origin xyz="0 -0.04 0.08"/><geometry><box size="0.02 0.01 0.06"/></geometry></collision></link>
  <joint name="slide" type="prismatic"><parent link="rail"/><child link="cart"/><axis xyz="1 0 0"/>
    <limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
  <joint name="turn" type="revolute"><parent link="cart"/><child link="upper"/><origin xyz="0 0 0.2"/>
    <axis xyz="0 0.6 0.8"/><limit lower="-3" upper="3" velocity="1" effort="1"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/><origin xyz="0 0 0.45" rpy="0.3 0 0"/>
    <axis xyz="1 0 0"/><limit lower="-2.8" upper="2.8" velocity="1" effort="1"/></joint>
  <joint name="wrist" type="revolute"><parent link="lower"/><child link="palm"/><origin xyz="0 0 0.4"/>
    <axis xyz="0 1 0"/><limit lower="-2.9" upper="2.9" velocity="1" effort="1"/></joint>
  <joint name="to_left" type="fixed"><parent link="palm"/><child link="left"/></joint>
  <joint name="to_right" type="fixed"><parent link="palm"/><child link="right"/></joint>
</robot>"#;

fn robot(urdf: &str) -> Arc<Robot> {
    Arc::new(Robot::from_urdf_text(urdf, "test.urdf", None, &RobotOptions::default()).expect("a good URDF"))
}

/// Returns a cloud of points on an ellipsoid.
fn cloud(draw: &mut impl FnMut(f64, f64) -> f64) -> Solid {
    let size = [draw(0.1, 0.4), draw(0.1, 0.4), draw(0.1, 0.4)];
    let points: Vec<[f32; 3]> = (0..2000)
        .map(|_| {
            let way = Vector::new(draw(-1.0, 1.0), draw(-1.0, 1.0), draw(-1.0, 1.0));
            let way = way.try_normalize(0.0).unwrap_or_else(Vector::x);
            [0, 1, 2].map(|axis| narrow(size[axis] * way[axis]))
        })
        .collect();
    Solid::union(BoxUnion::of_points(&points, draw(0.001, 0.02)).expect("good points"))
}

/// Returns a union of random cells.
fn cells(draw: &mut impl FnMut(f64, f64) -> f64) -> Solid {
    let cell = |_| cranny_shape::Aabb {
        center: cranny_spatial::Point::new(draw(-0.3, 0.3), draw(-0.3, 0.3), draw(-0.3, 0.3)),
        half_extents: Vector::repeat(draw(0.002, 0.03)),
    };
    Solid::union(BoxUnion::of_boxes((0..500).map(cell)).expect("good boxes"))
}

/// Scatters a solid of every kind around the robot, in random orientations, above a floor.
fn world(random: &mut Stream) -> World {
    let mut draw = |low: f64, high: f64| random.uniform_between(low, high);
    let corners: Vec<cranny_spatial::Point> = (0..12)
        .map(|_| cranny_spatial::Point::new(draw(-0.2, 0.2), draw(-0.1, 0.1), draw(-0.2, 0.2)))
        .collect();
    let solids = [
        Solid::cuboid(Vector::new(draw(0.01, 0.4), draw(0.01, 0.2), draw(0.01, 0.2))),
        Solid::cuboid(Vector::new(draw(0.01, 0.4), draw(0.01, 0.2), draw(0.01, 0.2))),
        Solid::sphere(draw(0.02, 0.3)),
        Solid::capsule(draw(0.02, 0.3), draw(0.02, 0.1)),
        Solid::cylinder(draw(0.02, 0.3), draw(0.02, 0.2)),
        Solid::hull(&corners),
        Ok(cloud(&mut draw)),
        Ok(cells(&mut draw)),
    ];
    let mut bodies = vec![Body::floor(-0.3)];
    for (index, solid) in solids.into_iter().enumerate() {
        let place = Vector::new(draw(-1.2, 1.2), draw(-1.0, 1.0), draw(-0.3, 1.2));
        // The first solid is parallel to the axes of the planning frame.
        let turn =
            if index == 0 { Vector::zeros() } else { Vector::new(draw(-3.0, 3.0), draw(-3.0, 3.0), 0.0) };
        bodies.push(Body::new(
            format!("body {index}"),
            Pose::new(place, turn),
            solid.expect("positive sizes"),
        ));
    }
    World::new(bodies).expect("good poses")
}

/// Samples configurations: half of them are uniform, the others bisected between a free one and one in contact until no joint
/// differs by more than `tolerance`.
fn configurations(cell: &Cell, random: &mut Stream, count: usize, tolerance: f64) -> Vec<Vec<f64>> {
    let mut scratch = cell.scratch();
    let mut draw = || -> Vec<f64> { cell.robot().random_configuration(random) };
    let mut all: Vec<Vec<f64>> = Vec::new();
    while all.len() < count {
        let mut ends = [draw(), draw()];
        all.push(ends[0].clone());
        let free = ends.each_ref().map(|q| cell.is_clear(q, &mut scratch));
        if free[0] == free[1] {
            continue;
        }
        while ends[0].iter().zip(&ends[1]).any(|(a, b)| (a - b).abs() > tolerance) {
            let middle: Vec<f64> = ends[0].iter().zip(&ends[1]).map(|(a, b)| 0.5 * (a + b)).collect();
            let is_free = cell.is_clear(&middle, &mut scratch);
            ends[usize::from(is_free != free[0])] = middle;
        }
        all.extend(ends);
    }
    all
}

/// Counts the verdicts of the lanes that differ from those of the exact check.
fn disagreements(cell: &Cell, configurations: &[Vec<f64>], level: Level) -> usize {
    let mut scratch = cell.scratch();
    let exact: Vec<bool> = configurations.iter().map(|q| cell.is_clear(q, &mut scratch)).collect();
    let mut verdicts = Vec::new();
    cell.are_free_with(level, &configurations.concat(), &mut scratch, &mut verdicts);
    exact.iter().zip(&verdicts).filter(|(exact, lanes)| exact != lanes).count()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn lanes_and_exact_check_agree(seed in any::<u64>(), margin_m in prop_oneof![Just(0.0), 0.001..0.03]) {
        let mut random = Stream::new(seed, 0);
        let margins = Margins { margin_m, ..Margins::default() };
        // On a turning base some links never come near some bodies.
        for urdf in [ARM, &ball(2.0), &ARM.replacen("prismatic", "revolute", 1)] {
            let cell = Cell::new(robot(urdf), world(&mut random), margins).expect("a good margin");
            let configurations = configurations(&cell, &mut random, 400, 1e-6);
            for (_, level) in simd_levels() {
                prop_assert_eq!(disagreements(&cell, &configurations, level), 0, "{:?}", level);
            }
        }
    }
}

#[test]
fn a_look_ahead_ends_at_the_first_contact() {
    let mut random = Stream::new(7, 0);
    let cell = Cell::new(robot(ARM), world(&mut random), Margins::default()).expect("no margin");
    let mut scratch = cell.scratch();
    for _ in 0..500 {
        let [a, b]: [Vec<f64>; 2] = std::array::from_fn(|_| cell.robot().random_configuration(&mut random));
        let places = (1..=11).map(|index| f64::from(index) / 11.0);
        let mut is_free = |place: f64| {
            cell.is_clear(&cranny_robot::between(&a, &b, place).collect::<Vec<_>>(), &mut scratch)
        };
        let expected = places.clone().position(|place| !is_free(place)).unwrap_or(11);
        assert_eq!(cell.free_ahead(&a, &b, &places.collect::<Vec<_>>(), &mut scratch), expected);
    }
}

/// Returns the doubts and the lanes in contact after a first check of a batch, and after a second one of its doubts alone.
fn looks(cell: &Cell, rows: &[Vec<f64>], interest: Interest, travel_m: f32) -> [(Vec<(u32, u32)>, u32); 2] {
    let mut lanes = cell.scratch().lanes;
    rows.iter().enumerate().for_each(|(lane, q)| lanes.set_lane(lane, q));
    lanes.travel.bodies.fill([travel_m; LANES]);
    lanes.travel.link_pairs.fill(travel_m);
    let asked = first_lanes(rows.len());
    let mut check = |again: bool| {
        let contact = if again {
            cell.lanes.check_again(Level::new(), &mut lanes, asked, interest)
        } else {
            cell.lanes.check(Level::new(), &mut lanes, asked, interest)
        };
        if !again {
            lanes.wanted.clone_from(&lanes.doubts);
        }
        (lanes.doubts.clone(), contact)
    };
    [check(false), check(true)]
}

#[test]
fn a_second_look_at_what_is_in_doubt_agrees_with_the_exact_check() {
    let mut random = Stream::new(11, 0);
    for urdf in [ARM, &ball(2.0)] {
        let cell = Cell::new(robot(urdf), world(&mut random), Margins::default()).expect("no margin");
        let mut scratch = cell.scratch();
        for rows in configurations(&cell, &mut random, 1600, 1e-6).chunks(LANES) {
            let [(first, first_contact), (second, contact)] = looks(&cell, rows, Interest::Each, 0.0);
            let within =
                |(pair, lanes): &(u32, u32)| first.iter().any(|f| f.0 == *pair && f.1 & lanes == *lanes);
            assert!(second.iter().all(within), "{second:?} of {first:?}");
            let doubt = second.iter().fold(0, |all, (_, lanes)| all | lanes);
            for lane in lanes_of(first_lanes(rows.len()) & !first_contact & !doubt) {
                assert_eq!(cell.is_clear(&rows[lane], &mut scratch), contact >> lane & 1 == 0);
            }
        }
    }
}

#[test]
fn a_look_that_contact_ends_names_where_it_is() {
    let mut random = Stream::new(12, 0);
    let cell = Cell::new(robot(ARM), world(&mut random), Margins::default()).expect("no margin");
    let mut scratch = cell.scratch();
    for rows in configurations(&cell, &mut random, 1600, 1e-2).chunks(LANES) {
        let [(_, contact), _] = looks(&cell, rows, Interest::AllOrNothing, 0.02);
        for lane in lanes_of(contact) {
            assert!(!cell.is_clear(&rows[lane], &mut scratch), "lane {lane} of {contact:b}");
        }
    }
}

/// Without slack, the rounding of `f32` decides within micrometres of contact: the test above must detect that.
#[test]
fn lanes_without_slack_are_caught() {
    let mut caught = 0;
    for seed in 0..20 {
        let mut random = Stream::new(seed, 1);
        let mut cell =
            Cell::new(robot(&ball(2.0)), world(&mut random), Margins::default()).expect("no margin");
        let configurations = configurations(&cell, &mut random, 300, 1e-9);
        assert_eq!(disagreements(&cell, &configurations, Level::new()), 0);
        Arc::make_mut(&mut cell.lanes).forget_slack();
        caught += disagreements(&cell, &configurations, Level::new());
    }
    assert!(caught > 0, "no verdict hung on the slack");
}
