//! Task space regions as goals of planners, and paths projected onto bounds of the tool.

use std::f64::consts::FRAC_PI_2;

use cranny_collision::{Body, Margins, Motion, ToolBound, ToolRegion, World};
use cranny_path::audit;
use cranny_plan::{Outcome, PlanReport, Registry, search};
use cranny_robot::between;
use cranny_spatial::{Point, Pose, PoseDifference, Stream, Vector};
use cranny_task::{Goal, Moved, PoseBounds, Problem, Region, RegionFrame, TaskError};

use crate::fixture::{GANTRY_START, block, exact, gantry, makes_grasps, plan};

/// Returns the pose at which the gripper of the gantry points forwards at a position.
fn forwards(x: f64, y: f64, z: f64) -> Pose {
    Pose::translation(x, y, z) * Pose::rotation(Vector::y() * FRAC_PI_2)
}

/// Returns the region of the poses within these bounds (m, °) of a position, with a gripper that points forwards.
fn region(at: [f64; 3], [x, y, yaw]: [f64; 3]) -> Region {
    let bounds = PoseBounds::Intervals {
        position_m: [[-x, x], [-y, y], [0.0, 0.0]],
        rpy_deg: [[0.0; 2], [0.0; 2], [-yaw, yaw]],
    };
    let frame =
        RegionFrame { pose: Pose::translation(at[0], at[1], at[2]), bounds, end: forwards(0.0, 0.0, 0.0) };
    Region { moved: Moved::Hand, frames: vec![frame] }
}

fn problem_to(regions: Vec<Region>) -> Problem {
    let wall = || vec![block("wall", [0.0, 0.0, 0.0], [0.02, 0.5, 0.55])];
    exact(&gantry(), wall(), &GANTRY_START, Goal::Regions(regions))
}

/// Returns the names of the planners whose goals may be regions.
fn take_regions() -> Vec<&'static str> {
    let names = Registry::default().names().into_iter();
    names.filter(|name| !name.starts_with("j-plus") && !makes_grasps(name)).collect()
}

const OPTIMISERS: [&str; 4] = ["chomp", "stomp", "omg", "gomp"];

/// Returns true if a pose is within 1 mm and 1° of a region, by roll, pitch and yaw of the gantry itself: its joints are x, y, z,
/// yaw, pitch and roll, with the gripper 0.105 m ahead.
fn is_in(q: &[f64], at: [f64; 3], [x, y, yaw]: [f64; 3]) -> bool {
    let tip = Vector::new(q[0], q[1], q[2])
        + 0.105 * Vector::new(q[3].cos() * q[4].cos(), q[3].sin() * q[4].cos(), -q[4].sin());
    let beyond = [(tip.x - at[0], x), (tip.y - at[1], y), (tip.z - at[2], 0.0)];
    let beyond_m = beyond.iter().map(|(off, most)| (off.abs() - most).max(0.0).powi(2)).sum::<f64>().sqrt();
    let off_deg =
        (q[3].to_degrees().abs() - yaw).max(0.0) + q[4].to_degrees().abs() + q[5].to_degrees().abs();
    beyond_m < 1e-3 && off_deg < 1.0
}

#[test]
fn planners_reach_a_region_and_the_judge_agrees() {
    let (at, widths) = ([0.5, 0.2, 0.4], [0.1, 0.2, 40.0]);
    let goal = || Goal::Regions(vec![region(at, widths)]);
    let [walled, open] =
        [problem_to(vec![region(at, widths)]), exact(&gantry(), Vec::new(), &GANTRY_START, goal())];
    for name in take_regions() {
        // Optimisers do not find the way around a wall.
        let problem = if OPTIMISERS.contains(&name) { &open } else { &walled };
        let report = plan(name, problem, 100_000, 1);
        assert_eq!(report.outcome, Outcome::Solved, "{name}");
        let judged = audit(problem, &report.path).expect("way points of the robot");
        assert!(judged.valid, "{name}: {:?}", judged.violations);
        assert!(is_in(report.path.last().expect("a path"), at, widths), "{name}");
    }
    for name in Registry::default().names().into_iter().filter(|name| name.starts_with("j-plus")) {
        let planner = Registry::default().planner(name).expect("a planner");
        let refused = planner.plan(&open, &cranny_plan::Budget::default(), 0, &mut cranny_plan::Unobserved);
        assert!(refused.is_err_and(|fault| fault.to_string().contains("grasps")), "{name}");
    }
}

#[test]
fn the_judge_refuses_an_end_outside_the_region() {
    let problem = problem_to(vec![region([-0.5, 0.0, 0.5], [0.05, 0.05, 10.0])]);
    let judge = |end: Vec<f64>| audit(&problem, &[GANTRY_START.to_vec(), end]).expect("way points").valid;
    assert!(judge(vec![-0.605, 0.0, 0.5, 0.0, 0.0, 0.0]));
    assert!(judge(vec![-0.605, 0.0505, 0.5, 0.0, 0.0, 0.0]), "half a millimetre counts as in the region");
    assert!(!judge(vec![-0.605, 0.052, 0.5, 0.0, 0.0, 0.0]));
    assert!(!judge(vec![-0.605, 0.0, 0.5, 0.0, 0.0, 0.02]), "1.15° of roll");
    assert!(judge(vec![-0.605, 0.0, 0.5, 0.0, 0.0, 0.015]), "0.86° of roll");
}

#[test]
fn a_seed_gives_the_same_path_and_another_region_another_one() {
    let problem =
        problem_to(vec![region([0.5, 0.2, 0.4], [0.1, 0.2, 40.0]), region([0.5, -0.3, 0.6], [0.0; 3])]);
    let bits = |report: PlanReport| -> Vec<u64> {
        report.path.iter().flatten().map(|value| value.to_bits()).collect()
    };
    for name in ["reach", "cbirrt2", "rrt-connect", "ik-rrt"] {
        let run = |seed| bits(plan(name, &problem, 100_000, seed));
        assert_eq!(run(3), run(3), "{name}");
        assert_ne!(run(3), run(4), "{name}");
    }
}

#[test]
fn a_region_out_of_reach_an_invalid_one_and_none_are_distinct() {
    let far = problem_to(vec![region([0.5, 9.0, 0.4], [0.1; 3])]);
    let of_wall = problem_to(vec![region([0.0, 0.0, 0.3], [0.0; 3])]);
    for name in take_regions() {
        let planner = Registry::default().planner(name).expect("a planner");
        let budget = cranny_plan::Budget { iterations: 100, ..cranny_plan::Budget::default() };
        let run = |problem: &Problem| {
            search(planner.as_ref(), problem, &budget, 0, &mut cranny_plan::Unobserved)
                .expect("a problem")
                .outcome
        };
        assert_eq!(run(&far), Outcome::RegionOutOfReach, "{name}");
        assert!(matches!(run(&of_wall), Outcome::BudgetExhausted | Outcome::GaveUp), "{name}");
    }
    let refused =
        |goal: Goal| problem_to(Vec::new()).with_goal(goal).expect_err("an invalid region").to_string();
    let mut empty = region([0.0; 3], [0.0; 3]);
    empty.frames[0].bounds =
        PoseBounds::Intervals { position_m: [[0.1, -0.1], [0.0; 2], [0.0; 2]], rpy_deg: [[0.0; 2]; 3] };
    assert!(refused(Goal::Regions(vec![empty])).contains("empty"));
    let nan = region([0.0; 3], [f64::NAN, 0.0, 0.0]);
    assert!(refused(Goal::Regions(vec![nan])).contains("'x' is [NaN, NaN]"));
    let of_object = Region { moved: Moved::Object, ..region([0.0; 3], [0.0; 3]) };
    assert!(refused(Goal::Regions(vec![of_object])).contains("object in the hand"));
    assert!(matches!(problem_to(Vec::new()).some_goal(), Err(TaskError::NoGoal)));
}

#[test]
fn frames_in_series_contain_what_they_draw_and_nothing_far_from_it() {
    let hinge =
        PoseBounds::Intervals { position_m: [[0.0; 2]; 3], rpy_deg: [[0.0; 2], [0.0; 2], [0.0, 90.0]] };
    let handle = PoseBounds::Intervals {
        position_m: [[0.0; 2], [0.0; 2], [-0.1, 0.1]],
        rpy_deg: [[0.0; 2], [-30.0, 30.0], [0.0; 2]],
    };
    let door = Region {
        moved: Moved::Hand,
        frames: vec![
            RegionFrame {
                pose: Pose::translation(0.5, 0.0, 0.0),
                bounds: hinge,
                end: Pose::translation(0.4, 0.0, 0.5),
            },
            RegionFrame { pose: Pose::identity(), bounds: handle, end: forwards(0.05, 0.0, 0.0) },
        ],
    };
    let mut random = Stream::new(9, 0);
    let (center, radius_m) = door.ball();
    for _ in 0..100 {
        let pose = door.draw(&mut random);
        let off = door.off(&pose);
        assert!(off.is_exact(), "{off:?}");
        assert!((Point::from(pose.translation.vector) - center).norm() <= radius_m + 1e-9);
        let away = pose * Pose::translation(0.0, 0.0, 0.0) * Pose::rotation(Vector::z() * 0.05);
        assert!(door.off(&away).rotation_rad > 0.04, "no hinge turns the hand about its own z axis");
        let lifted = Pose::translation(0.0, 0.0, 0.3) * pose;
        assert!(door.off(&lifted).translation_m > 0.05);
    }
}

#[test]
fn several_regions_are_drawn_in_proportion_to_their_widths() {
    let regions = [region([0.0; 3], [0.1, 0.0, 0.0]), region([1.0, 0.0, 0.0], [0.3, 0.0, 0.0])];
    let mut random = Stream::new(2, 0);
    let second = (0..4000).filter(|_| Region::choose(&regions, &mut random) == 1).count();
    // Expected 3000, with a standard deviation of 27.
    assert!((2890..3110).contains(&second), "{second}");
}

/// Returns the problem of moving past a post with the hand upright within 8°, in a layer of 8 cm.
fn in_a_layer(start: &[f64], goal: Goal) -> Problem {
    let bounds = vec![
        ToolBound {
            name: "upright".to_owned(),
            link: None,
            region: ToolRegion::Cone { axis_in_link: Vector::x(), toward: -Vector::z(), most_rad: 0.14 },
        },
        ToolBound {
            name: "layer".to_owned(),
            link: None,
            region: ToolRegion::Box {
                point_in_link: Point::origin(),
                world_from_box: Pose::translation(0.0, 0.0, 0.5),
                half_m: Vector::new(2.0, 2.0, 0.04),
            },
        },
    ];
    let bodies: Vec<Body> = vec![block("post", [0.0, 0.0, 0.5], [0.05, 0.4, 0.6])];
    let world = World::new(bodies).and_then(|world| world.with_tool_bounds(bounds)).expect("good bounds");
    Problem::exact(gantry(), world, None, start.to_vec(), goal, Margins::default()).expect("a good problem")
}

#[test]
fn every_edge_of_a_projected_path_is_within_the_bounds() {
    let goal = || Goal::Regions(vec![region([0.6, 0.1, 0.5], [0.05, 0.05, 60.0])]);
    let problem = in_a_layer(&GANTRY_START, goal());
    let cell = problem.cell().expect("an exact problem");
    let robot = problem.robot();
    for seed in 0..5 {
        let report = plan("cbirrt2", &problem, 20_000, seed);
        assert_eq!(report.outcome, Outcome::Solved, "{seed}");
        assert!(audit(&problem, &report.path).expect("way points").valid, "{seed}");
        let mut scratch = cell.scratch();
        for edge in report.path.windows(2) {
            assert_eq!(cell.motion_is_free(&edge[0], &edge[1], &mut scratch), Motion::Proven);
            for step in 0..=200 {
                let q: Vec<f64> = between(&edge[0], &edge[1], f64::from(step) / 200.0).collect();
                let pose = *robot.frames_at(&q).link(robot.tip());
                let tilt = (pose.rotation * Vector::x()).dot(&-Vector::z()).clamp(-1.0, 1.0).acos();
                assert!(tilt <= 0.14 && (pose.translation.z - 0.5).abs() <= 0.04, "{tilt}, {pose}");
            }
        }
    }
    let tilted = [-0.6, 0.0, 0.5, 0.0, 0.0, 0.3];
    assert_eq!(plan("cbirrt2", &in_a_layer(&tilted, goal()), 100, 0).outcome, Outcome::StartInvalid);
    let above = Goal::Configurations(vec![vec![0.6, 0.1, 0.7, 0.0, 0.0, 0.0]]);
    assert_eq!(plan("cbirrt2", &in_a_layer(&GANTRY_START, above), 100, 0).outcome, Outcome::GoalsInvalid);
}

#[test]
fn a_region_of_one_pose_is_that_pose() {
    let at = forwards(0.5, 0.1, 0.4);
    let only = Region {
        moved: Moved::Hand,
        frames: vec![RegionFrame {
            pose: at,
            bounds: PoseBounds::Within { within_m: [0.0; 3], within_deg: 0.0 },
            end: Pose::identity(),
        }],
    };
    let problem = problem_to(vec![only]);
    let report = plan("reach", &problem, 10_000, 0);
    let end = *problem.robot().frames_at(report.path.last().expect("a path")).link(problem.robot().tip());
    assert!(PoseDifference::between(&at, &end).is_exact());
}
