//! Tests of bounds on the tool, proven along edges and curves.

use std::sync::Arc;

use cranny_collision::{Body, Cell, CollisionError, Margins, Motion, ToolBound, ToolRegion, World};
use cranny_robot::{Robot, RobotOptions, between};
use cranny_shape::Solid;
use cranny_spatial::{Point, Pose, Rotation, Stream, Vector};

const ARM: &str = r#"<robot name="arm">
  <link name="base"/><link name="cart"/><link name="a"/><link name="b"/><link name="c"/><link name="tip"/>
  <joint name="slide" type="prismatic"><parent link="base"/><child link="cart"/><axis xyz="0 1 0"/>
    <limit lower="-0.5" upper="0.5" velocity="1" effort="1"/></joint>
  <joint name="turn" type="revolute"><parent link="cart"/><child link="a"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" velocity="1" effort="1"/></joint>
  <joint name="lift" type="revolute"><parent link="a"/><child link="b"/><origin xyz="0.1 0 0.2"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
  <joint name="reach" type="prismatic"><parent link="b"/><child link="c"/><origin xyz="0.3 0 0"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="0.2" velocity="1" effort="1"/></joint>
  <joint name="wrist" type="revolute"><parent link="c"/><child link="tip"/><origin xyz="0.2 0.05 0"/>
    <axis xyz="0.6 0.8 0"/><limit lower="-2.5" upper="2.5" velocity="1" effort="1"/></joint>
</robot>"#;

fn region(stream: &mut Stream, kind: usize) -> ToolRegion {
    let mut draw = || stream.uniform_between(-1.0, 1.0);
    let point_in_link = Point::new(0.1 * draw(), 0.1 * draw(), 0.1 * draw());
    let direction = |draw: &mut dyn FnMut() -> f64| Vector::new(draw(), draw(), draw()).normalize();
    match kind % 3 {
        0 => ToolRegion::Cone {
            axis_in_link: direction(&mut draw),
            toward: direction(&mut draw),
            most_rad: 0.8 + 0.6 * draw(),
        },
        1 => ToolRegion::Box {
            point_in_link,
            world_from_box: Pose::from_parts(
                Vector::new(0.4 * draw(), 0.4 * draw(), 0.2 * draw()).into(),
                Rotation::new(direction(&mut draw)),
            ),
            half_m: Vector::new(0.35 + 0.15 * draw(), 0.35 + 0.15 * draw(), 0.35 + 0.15 * draw()),
        },
        _ => ToolRegion::Ball {
            point_in_link,
            center: Point::new(0.4 * draw(), 0.4 * draw(), 0.2 * draw()),
            radius_m: 0.45 + 0.2 * draw(),
        },
    }
}

fn cell(robot: &Arc<Robot>, link: Option<&str>, region: ToolRegion) -> Cell {
    let bound = ToolBound { name: "bound".to_owned(), link: link.map(str::to_owned), region };
    let world = World::new(Vec::new()).and_then(|world| world.with_tool_bounds(vec![bound])).expect("bounds");
    Cell::new(robot.clone(), world, Margins::default()).expect("no margin")
}

fn at(points: &[Vec<f64>], t: f64) -> Vec<f64> {
    let mut row = points.to_vec();
    while row.len() > 1 {
        row = row.windows(2).map(|pair| between(&pair[0], &pair[1], t).collect()).collect();
    }
    row.remove(0)
}

/// Checks random edges, curves of degree 1 to 4 and bounds: a proven motion keeps its bound at every sample, the greatest
/// excess is an upper bound of the samples, and a refused motion exceeds the bound somewhere.
#[test]
fn a_proven_motion_keeps_its_bound_and_a_refused_one_does_not() {
    let robot =
        Arc::new(Robot::from_urdf_text(ARM, "arm.urdf", None, &RobotOptions::default()).expect("a URDF"));
    let mut stream = Stream::new(11, 0);
    let (mut proven, mut refused) = ([0; 3], [0; 3]);
    for round in 0..900 {
        let kind = round % 3;
        let link = [None, Some("c"), Some("tip")][round % 7 % 3];
        let cell = cell(&robot, link, region(&mut stream, kind));
        let degree = 1 + (round / 3) % 4;
        let middle = robot.random_configuration(&mut stream);
        let points: Vec<Vec<f64>> = (0..=degree)
            .map(|_| between(&middle, &robot.random_configuration(&mut stream), 0.25).collect())
            .collect();
        let (reach, mut scratch) = (cell.reach(), cell.scratch());
        let excess = |t: f64, scratch: &mut _| cell.tool_excess(0, &at(&points, t), scratch);
        let seen =
            (0..=300).map(|k| excess(f64::from(k) / 300.0, &mut scratch)).fold(f64::NEG_INFINITY, f64::max);
        let motion = match &points[..] {
            [a, b] => cell.motion_is_free(a, b, &mut scratch),
            points => cell.curve_is_free(points, &reach, &mut scratch),
        };
        let greatest = cell.greatest_excess_on_curve(0, &points, &reach, &mut scratch);
        assert!(greatest >= seen - 1e-9 && greatest <= seen + 5e-3, "{greatest} for {seen}");
        match motion {
            Motion::Proven => {
                assert!(seen <= 0.0, "round {round}: {seen}");
                proven[kind] += 1;
            }
            Motion::OutOfBounds { bound: 0, .. } => {
                assert!(seen > -1e-4, "round {round}: {seen}");
                refused[kind] += 1;
            }
            other => panic!("{other:?}"),
        }
    }
    assert!(proven.iter().chain(&refused).all(|&count| count > 10), "{proven:?} {refused:?}");
}

/// A way point at 10⁷ rad would take more than 10¹⁰ intervals.
#[test]
fn the_greatest_excess_of_a_motion_of_very_many_turns_takes_bounded_time() {
    let robot =
        Arc::new(Robot::from_urdf_text(ARM, "arm.urdf", None, &RobotOptions::default()).expect("a URDF"));
    let region = ToolRegion::Ball { point_in_link: Point::origin(), center: Point::origin(), radius_m: 0.1 };
    let cell = cell(&robot, None, region);
    let (a, b) = ([0.0; 5], [0.0, 1e7, 1e7, 0.1, 1e7]);
    let mut scratch = cell.scratch();
    let greatest = cell.greatest_excess(0, &a, &b, &mut scratch);
    for sample in 0..1000 {
        let q: Vec<f64> = between(&a, &b, f64::from(sample) / 1000.0).collect();
        assert!(cell.tool_excess(0, &q, &mut scratch) <= greatest);
    }
}

#[test]
fn a_configuration_out_of_bounds_is_moved_to_one_within_or_given_up() {
    let robot =
        Arc::new(Robot::from_urdf_text(ARM, "arm.urdf", None, &RobotOptions::default()).expect("a URDF"));
    let mut stream = Stream::new(12, 0);
    let mut moved = 0;
    for round in 0..300 {
        let link = [None, Some("c")][round % 2];
        let cell = cell(&robot, link, region(&mut stream, round));
        let mut scratch = cell.scratch();
        let mut q = robot.random_configuration(&mut stream);
        let was_within = cell.is_free(&q, &mut scratch);
        if cell.project_to_bounds(&mut q, &mut scratch) {
            assert!(cell.is_free(&q, &mut scratch), "round {round}");
            moved += u32::from(!was_within);
        }
    }
    assert!(moved > 100, "{moved}");
}

#[test]
fn a_bound_that_bounds_nothing_is_refused_by_its_name() {
    let cone = |axis_in_link, most_rad| ToolRegion::Cone { axis_in_link, toward: Vector::z(), most_rad };
    let cuboid = |x| ToolRegion::Box {
        point_in_link: Point::origin(),
        world_from_box: Pose::identity(),
        half_m: Vector::new(x, 1.0, 1.0),
    };
    let ball =
        |radius_m| ToolRegion::Ball { point_in_link: Point::origin(), center: Point::origin(), radius_m };
    for region in [
        cone(Vector::zeros(), 1.0),
        cone(Vector::z(), 0.0),
        cone(Vector::z(), f64::NAN),
        cuboid(-1.0),
        cuboid(f64::NAN),
        ball(0.0),
        ball(f64::INFINITY),
    ] {
        let bound = ToolBound { name: "lane".to_owned(), link: None, region };
        let fault = World::default().with_tool_bounds(vec![bound]).expect_err("no bound");
        assert!(matches!(fault, CollisionError::ToolBound { name } if name == "lane"));
    }
}

#[test]
fn a_bound_of_a_link_that_there_is_not_is_refused_by_its_name() {
    let robot =
        Arc::new(Robot::from_urdf_text(ARM, "arm.urdf", None, &RobotOptions::default()).expect("a URDF"));
    let region = region(&mut Stream::new(1, 0), 2);
    let bound = ToolBound { name: "ball".to_owned(), link: Some("elbow".to_owned()), region };
    let world = World::default().with_tool_bounds(vec![bound]).expect("a bound");
    let fault = Cell::new(robot, world, Margins::default()).expect_err("no such link");
    assert!(matches!(fault, CollisionError::UnknownLink { name } if name == "elbow"));
}

#[test]
fn other_bodies_keep_the_bounds() {
    let bound = ToolBound { name: "ball".to_owned(), link: None, region: region(&mut Stream::new(1, 0), 2) };
    let world = World::default().with_tool_bounds(vec![bound.clone()]).expect("a bound");
    let ball = Body::new("thing", Pose::identity(), Solid::sphere(0.1).expect("a radius"));
    assert_eq!(world.with_bodies(vec![ball]).expect("a pose").tool_bounds(), [bound]);
}
