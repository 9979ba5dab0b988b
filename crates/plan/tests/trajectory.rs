//! Guarantees of a trajectory: limits, rest at both ends, and the proven edges.

#![allow(clippy::float_cmp, reason = "the ends of a trajectory are exact")]

use std::path::Path;

use cranny_path::{MAX_SAMPLE_RATE_HZ, MotionLimits, PathError, TimingMethod, Trajectory, sample_times};
use cranny_robot::{JointLimits, JointUnit, Robot, RobotOptions};
use cranny_spatial::Stream;
use cranny_task::TaskError;
use proptest::prelude::*;

const METHODS: [TimingMethod; 2] = [TimingMethod::TimeOptimal, TimingMethod::JerkLimited];

/// Returns the built-in robot with its own limits.
fn panda() -> Robot {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenario/robots/panda_mobile");
    let text = std::fs::read_to_string(folder.join("panda_mobile.urdf")).expect("the URDF");
    Robot::from_urdf_text(&text, "panda_mobile.urdf", Some(&folder), &options(&folder)).expect("the robot")
}

fn options(folder: &Path) -> RobotOptions {
    let source = |name: &str| Some(cranny_robot::TextSource::Path(folder.join(name)));
    RobotOptions {
        srdf: source("panda_mobile.srdf"),
        limits: source("limits.yaml"),
        tip: Some("panda_grasptarget".to_owned()),
        fixed: [("panda_finger_joint1".to_owned(), 0.04), ("panda_finger_joint2".to_owned(), 0.04)].into(),
        ..RobotOptions::default()
    }
}

/// Returns way points of all kinds: far and near, repeated, on one line, there and back.
fn polyline(robot: &Robot, seed: u64, count: usize) -> Vec<Vec<f64>> {
    let mut stream = Stream::new(seed, 0);
    let anywhere = |stream: &mut Stream| -> Vec<f64> { robot.random_configuration(stream) };
    let towards = |a: &[f64], b: &[f64], part: f64| -> Vec<f64> {
        a.iter().zip(b).map(|(a, b)| a + (b - a) * part).collect()
    };
    let mut path = vec![anywhere(&mut stream)];
    while path.len() < count {
        let last = path[path.len() - 1].clone();
        let target = anywhere(&mut stream);
        match stream.index(6) {
            0 => path.push(last),
            1 => path.push(towards(&last, &target, 10.0_f64.powf(stream.uniform_between(-9.0, -1.0)))),
            2 => path.extend([0.3, 0.5, 1.0].map(|part| towards(&last, &target, part))),
            3 => path.extend([towards(&last, &target, 0.5), last]),
            4 => {
                let mut one_joint = last;
                let joint = stream.index(one_joint.len());
                one_joint[joint] = target[joint];
                path.push(one_joint);
            }
            _ => path.push(target),
        }
    }
    path
}

fn limit(limits: &[JointLimits], of: impl Fn(&JointLimits) -> Option<f64>) -> Vec<f64> {
    limits.iter().map(|l| of(l).expect("the limit is known")).collect()
}

/// Returns the greatest distance per joint from `q` to the nearest point of the polyline.
fn distance_to(path: &[Vec<f64>], q: &[f64]) -> f64 {
    let to_edge = |a: &[f64], b: &[f64]| {
        let dot = |x: &[f64], y: &[f64]| -> f64 {
            x.iter().zip(y).zip(a).map(|((x, y), a)| (x - a) * (y - a)).sum()
        };
        let part = if dot(b, b) > 0.0 { (dot(q, b) / dot(b, b)).clamp(0.0, 1.0) } else { 0.0 };
        let off = |((q, a), b): ((&f64, &f64), &f64)| (q - (a + (b - a) * part)).abs();
        q.iter().zip(a).zip(b).map(off).fold(0.0, f64::max)
    };
    path.windows(2).map(|pair| to_edge(&pair[0], &pair[1])).fold(f64::INFINITY, f64::min)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, failure_persistence: None, ..Default::default() })]

    /// Checks limits twice: in the derivatives that the trajectory states, and in differences of its positions, which no error
    /// in a derivative can hide.
    #[test]
    fn every_limit_holds_at_1_khz(seed in any::<u64>(), count in 2usize..12) {
        let robot = panda();
        let path = polyline(&robot, seed, count);
        let velocity = limit(robot.limits(), |l| Some(l.velocity));
        let acceleration = limit(robot.limits(), |l| l.acceleration);
        let jerk = limit(robot.limits(), |l| l.jerk);
        for method in METHODS {
            let limits = MotionLimits::of(&robot, method).expect("limits");
            let trajectory = Trajectory::along(&path, &limits).expect("a trajectory");
            let samples: Vec<_> = trajectory.samples(1000.0).expect("samples").collect();
            for sample in &samples {
                prop_assert!(robot.within_limits(&sample.position));
                for joint in 0..robot.dof() {
                    prop_assert!(sample.velocity[joint].abs() <= velocity[joint]);
                    prop_assert!(sample.acceleration[joint].abs() <= acceleration[joint]);
                }
                prop_assert!(distance_to(&path, &sample.position) < 1e-9);
            }
            // The last interval is shorter.
            let even = &samples[..samples.len() - 1];
            for joint in 0..robot.dof() {
                let derivative = |values: &[f64]| -> Vec<f64> {
                    values.windows(2).map(|pair| (pair[1] - pair[0]) * 1000.0).collect()
                };
                let greatest = |values: &[f64]| values.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
                let position: Vec<f64> = even.iter().map(|sample| sample.position[joint]).collect();
                let rates = derivative(&position);
                let second = derivative(&rates);
                prop_assert!(greatest(&rates) <= velocity[joint]);
                prop_assert!(greatest(&second) <= acceleration[joint]);
                if method == TimingMethod::JerkLimited {
                    prop_assert!(greatest(&derivative(&second)) <= jerk[joint]);
                    let stated: Vec<f64> = even.iter().map(|sample| sample.acceleration[joint]).collect();
                    prop_assert!(greatest(&derivative(&stated)) <= jerk[joint]);
                }
            }
        }
    }

    #[test]
    fn a_trajectory_begins_and_ends_at_rest_and_passes_every_way_point(
        seed in any::<u64>(),
        count in 2usize..12,
    ) {
        let robot = panda();
        let path = polyline(&robot, seed, count);
        for method in METHODS {
            let limits = MotionLimits::of(&robot, method).expect("limits");
            let trajectory = Trajectory::along(&path, &limits).expect("a trajectory");
            let end_s = trajectory.duration_s();
            for (time_s, q) in [(-1.0, 0), (0.0, 0), (end_s, path.len() - 1), (end_s + 1.0, path.len() - 1)] {
                let sample = trajectory.sample(time_s);
                prop_assert_eq!(&sample.position, &path[q]);
                prop_assert!(sample.velocity.iter().all(|v| *v == 0.0));
            }
            let just_before = trajectory.sample(end_s * (1.0 - 1e-15));
            prop_assert!(just_before.velocity.iter().all(|v| v.abs() < 1e-6));
            let times = trajectory.waypoint_times_s();
            prop_assert_eq!(times.len(), path.len());
            prop_assert!(times.is_sorted() && times[0] == 0.0 && times[times.len() - 1] == end_s);
            for (time_s, q) in times.iter().zip(&path) {
                let sample = trajectory.sample(*time_s);
                let off = sample.position.iter().zip(q).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                prop_assert!(off < 1e-9, "{off} at {time_s}");
            }
        }
    }

    /// Compares with the trapezoid `T = L/v + v/a`, or the triangle `T = 2√(L/a)`, of the slowest joint. On a straight line the
    /// joints share one profile, so the bounds of velocity and acceleration may come from two of them.
    #[test]
    fn a_straight_motion_takes_as_long_as_the_closed_form_says(seed in any::<u64>()) {
        let robot = panda();
        let path = polyline(&robot, seed, 2);
        let limits = MotionLimits::of(&robot, TimingMethod::TimeOptimal).expect("limits");
        let trajectory = Trajectory::along(&path[..2], &limits).expect("a trajectory");
        let lengths = path[0].iter().zip(&path[1]).map(|(a, b)| (a - b).abs());
        let (mut v, mut a) = (f64::INFINITY, f64::INFINITY);
        for (length, limit) in lengths.zip(robot.limits()).filter(|(length, _)| *length > 0.0) {
            v = v.min(limit.velocity / length);
            a = a.min(limit.acceleration.expect("known") / length);
        }
        let expected = if path[0] == path[1] {
            0.0
        } else if v * v < a {
            1.0 / v + v / a
        } else {
            2.0 * (1.0 / a).sqrt()
        };
        prop_assert!((trajectory.duration_s() - expected).abs() <= 2e-6 * expected);
    }
}

#[test]
fn one_joint_is_moved_bang_bang() {
    let joint = JointLimits {
        lower: -10.0,
        upper: 10.0,
        velocity: 2.0,
        acceleration: Some(4.0),
        jerk: None,
        unit: JointUnit::Metre,
    };
    let limits = MotionLimits::new(&["slide".to_owned()], &[joint], TimingMethod::TimeOptimal).expect("fine");
    let trajectory = Trajectory::along(&[vec![0.0], vec![3.0]], &limits).expect("a trajectory");
    // The joint accelerates for half a second, moves at 2 m/s for a second, and decelerates for half a second.
    assert!((trajectory.duration_s() - 2.0).abs() < 1e-5);
    for (time_s, q, v, a) in
        [(0.0, 0.0, 0.0, 4.0), (0.25, 0.125, 1.0, 4.0), (1.0, 1.5, 2.0, 0.0), (1.75, 2.875, 1.0, -4.0)]
    {
        let sample = trajectory.sample(time_s);
        let off = [sample.position[0] - q, sample.velocity[0] - v, sample.acceleration[0] - a];
        assert!(off.iter().all(|x| x.abs() < 1e-5), "{sample:?}");
    }
}

#[test]
fn samples_are_evenly_spaced_and_include_the_end() {
    let robot = panda();
    let limits = MotionLimits::of(&robot, TimingMethod::TimeOptimal).expect("limits");
    let trajectory = Trajectory::along(&polyline(&robot, 3, 5), &limits).expect("a trajectory");
    for rate_hz in [0.001, 1.0, 30.0, 100.0, 1000.0] {
        let times: Vec<f64> = trajectory.samples(rate_hz).expect("fine").map(|s| s.time_s).collect();
        assert_eq!(times[0], 0.0);
        assert_eq!(times[times.len() - 1], trajectory.duration_s());
        let (last, even) = times.split_last().expect("some");
        assert!(even.iter().enumerate().all(|(k, t)| (t - k as f64 / rate_hz).abs() < 1e-12));
        assert!(*last > even[even.len() - 1] && last - even[even.len() - 1] <= 1.000_002 / rate_hz);
    }
    for rate_hz in [0.0, -1.0, f64::NAN, f64::INFINITY, 2.0 * MAX_SAMPLE_RATE_HZ] {
        assert!(matches!(trajectory.samples(rate_hz).err(), Some(PathError::SampleRate { .. })));
    }
    assert!(matches!(sample_times(1e6, 100.0).err(), Some(PathError::TooManySamples { .. })));
}

#[test]
fn what_is_no_path_of_the_robot_is_refused() {
    let robot = panda();
    let limits = MotionLimits::of(&robot, TimingMethod::JerkLimited).expect("limits");
    let refused = |path: &[Vec<f64>]| Trajectory::along(path, &limits).expect_err("no path");
    assert!(matches!(refused(&[]), PathError::EmptyPath));
    let short = [vec![0.0; 9], vec![0.0; 8]];
    assert!(matches!(refused(&short), PathError::Task(TaskError::JointCount { expected: 9, actual: 8, .. })));
    for value in [f64::NAN, f64::INFINITY] {
        assert!(matches!(refused(&[vec![value; 9]]), PathError::Task(TaskError::NotFinite { .. })));
    }
    let still = Trajectory::along(&[vec![0.1; 9]], &limits).expect("a robot that stays");
    assert_eq!(still.duration_s(), 0.0);
    assert_eq!(still.waypoint_times_s(), [0.0]);
    let samples: Vec<_> = still.samples(100.0).expect("fine").collect();
    assert_eq!(samples.len(), 1);
    assert_eq!(samples[0].position, vec![0.1; 9]);
}

#[test]
fn way_points_on_a_straight_line_cost_no_time() {
    let robot = panda();
    let (a, b) = (vec![0.0; 9], vec![0.3; 9]);
    let dense: Vec<Vec<f64>> = (0..=60).map(|k| vec![0.3 * f64::from(k) / 60.0; 9]).collect();
    for method in METHODS {
        let limits = MotionLimits::of(&robot, method).expect("limits");
        let direct = Trajectory::along(&[a.clone(), b.clone()], &limits).expect("a trajectory");
        let chopped = Trajectory::along(&dense, &limits).expect("a trajectory");
        assert!((direct.duration_s() - chopped.duration_s()).abs() < 1e-9 * direct.duration_s());
    }
}
