use copp::diag::PathError;
use copp::path::{Path, PathEvaluator2nd};
use copp::solver::topp2_ra::{ReachSet2OptionsBuilder, Topp2ProblemBuilder, s_to_t_topp2, topp2_ra};
use cranny_robot::{JointLimits, JointUnit};
use cranny_spatial::Stream;
use proptest::prelude::*;

use crate::timing::motion_limits::{MotionLimits, TimingMethod};
use crate::timing::path_curve::{Cuts, PathCurve};
use crate::timing::piece_limits::{EdgePace, PieceLimits};
use crate::timing::rounding::{CurveProof, CurvedPath};
use crate::timing::time_optimal::{on_grid, time_optimal};
use crate::timing::trajectory::{Trajectory, TrajectorySample};

const JOINTS: usize = 5;

fn limits() -> Vec<JointLimits> {
    let joint = |(velocity, acceleration)| JointLimits {
        lower: -3.0,
        upper: 3.0,
        velocity,
        acceleration: Some(acceleration),
        jerk: Some(20.0 * acceleration),
        unit: JointUnit::Radian,
    };
    [(1.0, 1.0), (1.0, 2.0), (2.2, 15.0), (2.2, 7.5), (2.6, 20.0)].map(joint).into()
}

fn limits_by(method: TimingMethod) -> MotionLimits {
    let names: Vec<String> = (0..JOINTS).map(|j| format!("joint{j}")).collect();
    MotionLimits::new(&names, &limits(), method).expect("limits")
}

fn motion_limits() -> MotionLimits {
    limits_by(TimingMethod::TimeOptimal)
}

/// Returns the cuts of a path: `wanted` at each corner, in seconds at full speed, or its reverse, at most almost half an edge.
fn cuts(path: &[Vec<f64>], limits: &MotionLimits, wanted: Cuts) -> Vec<Cuts> {
    let mut cuts = vec![[0.0; 2]; path.len()];
    for corner in PathCurve::corners(path, &limits.velocity) {
        let mut of = wanted;
        // Without alternation, they would multiply to a scale of ten thousands, and amplify rounding errors.
        of.rotate_left(corner.waypoint % 2);
        cuts[corner.waypoint] = [0, 1].map(|side| of[side].min(0.49 * corner.lengths[side]));
    }
    cuts
}

fn rounded(path: &[Vec<f64>], limits: &MotionLimits, wanted: Cuts) -> Trajectory {
    let cuts = cuts(path, limits, wanted);
    let corners = PathCurve::corners(path, &limits.velocity);
    let corners: Vec<_> = corners.iter().map(|corner| corner.rounded(cuts[corner.waypoint])).collect();
    let curved = CurvedPath { corners: &corners, ..CurvedPath::stopping(path) };
    Trajectory::along_curve(&curved, limits).expect("a trajectory")
}

/// Returns the limits of each piece of a curve, from the joint limits alone.
fn of_pieces(curve: &PathCurve, limits: &MotionLimits) -> Vec<PieceLimits> {
    PieceLimits::all_of(curve, limits, &[], None)
}

fn polyline(seed: u64, count: usize) -> Vec<Vec<f64>> {
    let mut stream = Stream::new(seed, 0);
    (0..count).map(|_| (0..JOINTS).map(|_| stream.uniform_between(-3.0, 3.0)).collect()).collect()
}

/// Returns the first joint that exceeds a limit along a rounded path sampled at 1 kHz, and the time (s).
fn exceeded(method: TimingMethod, seed: u64, count: usize, wanted: Cuts) -> Option<(usize, f64)> {
    let path = polyline(seed, count);
    let trajectory = rounded(&path, &limits_by(method), wanted);
    let samples: Vec<_> = trajectory.samples(1000.0).expect("samples").collect();
    for (joint, limits) in limits().iter().enumerate() {
        let acceleration = limits.acceleration.expect("known");
        let stated = |s: &&TrajectorySample| {
            s.velocity[joint].abs() > limits.velocity || s.acceleration[joint].abs() > acceleration
        };
        let jerk = limits.jerk.filter(|_| method == TimingMethod::JerkLimited);
        let is_jerky = |[a, b]: [&TrajectorySample; 2]| {
            jerk.is_some_and(|jerk| (b.acceleration[joint] - a.acceleration[joint]).abs() > jerk * 1e-3)
        };
        // The last interval is shorter.
        let differences = |three: &&[TrajectorySample]| {
            let [a, b, c] = [0, 1, 2].map(|k| three[k].position[joint]);
            let of_velocity = (three[2].velocity[joint] - three[0].velocity[joint]) * 500.0;
            ((b - a) * 1000.0).abs() > limits.velocity
                || (((c - b) - (b - a)) * 1e6).abs() > acceleration
                || of_velocity.abs() > acceleration
                || is_jerky([&three[0], &three[1]])
        };
        let found = samples.iter().find(stated).map(|sample| sample.time_s);
        let even = &samples[..samples.len() - 1];
        if let Some(time_s) = found.or_else(|| even.windows(3).find(differences).map(|t| t[1].time_s)) {
            return Some((joint, time_s));
        }
    }
    None
}

/// Returns the greatest used share of the acceleration limits at the ends of the stages; between them it is less.
fn greatest_use(curve: &PathCurve, limits: &MotionLimits, stages: u32) -> f64 {
    let mut most = 0.0_f64;
    for phase in on_grid(curve, &of_pieces(curve, limits), stages).phases {
        let piece = &curve.pieces[phase.pieces.start];
        for state in [phase.state, phase.state.after(phase.duration_s, phase.jerk)] {
            for (joint, limit) in limits.acceleration.iter().enumerate() {
                let q = piece.derivatives(joint, state.s);
                let acceleration = q.first * state.acceleration + q.second * state.speed * state.speed;
                most = most.max(acceleration.abs() / limit);
            }
        }
    }
    most
}

/// Checks a corner in whose middle a joint turns back exactly at the edge of a stage, up to rounding. The slope of its row is
/// 1e-17 there, so that bounds of u from it would be noise.
#[test]
fn a_joint_may_turn_back_on_the_edge_of_a_stage() {
    let (limits, path) = (motion_limits(), polyline(15229711017748495913, 4));
    let cuts = cuts(&path, &limits, [10.0_f64.powf(-0.38683405671710996); 2]);
    let curve = PathCurve::along(&path, &limits.velocity, &cuts);
    for stages in [2, 16, 32, 64, 100, 128, 256, 1024] {
        let most = greatest_use(&curve, &limits, stages);
        assert!(most < 1.0 + 1e-6, "{stages} stages: {most}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, failure_persistence: None, ..Default::default() })]

    /// Checks curves as `every_limit_holds_at_1_khz` checks straight paths.
    #[test]
    fn every_limit_holds_on_rounded_paths(seed in any::<u64>(), count in 3usize..8, size in -4.0..0.5, ratio in -1.0..1.0) {
        for method in [TimingMethod::TimeOptimal, TimingMethod::JerkLimited] {
            let exceeded = exceeded(method, seed, count, [size, size + ratio].map(|size| 10.0_f64.powf(size)));
            prop_assert!(exceeded.is_none(), "{method:?}: {exceeded:?}");
        }
    }

    /// Checks for any proven sizes, at full and at reduced pace, that rounding is never slower than a stop at each corner, and
    /// that only accepted sizes are used.
    #[test]
    fn rounding_is_never_slower_than_stopping(seed in any::<u64>(), count in 3usize..8, share in 0.1..1.0) {
        let path = polyline(seed, count);
        let pace = EdgePace { share, ..EdgePace::default() };
        let paces = vec![pace; count];
        for method in [TimingMethod::TimeOptimal, TimingMethod::JerkLimited] {
            let limits = limits_by(method);
            let stopping = CurvedPath { paces: &paces, ..CurvedPath::stopping(&path) };
            let mut accepted = Vec::new();
            let corners = stopping.rounded(&limits, |at, points| {
                let is_small = points[0].iter().zip(&points[2]).all(|(a, b)| (a - b).abs() < 1.5 * share);
                if is_small {
                    accepted.push((at, points.clone()));
                }
                is_small
            });
            prop_assert!(corners.iter().all(|corner| accepted.contains(&(corner.waypoint, corner.control_points.clone()))));
            let round = CurvedPath { corners: &corners, ..stopping };
            let [round_s, stopping_s] =
                [round, stopping].map(|path| Trajectory::along_curve(&path, &limits).expect("a trajectory").duration_s());
            prop_assert!(round_s <= stopping_s, "{round_s} against {stopping_s}");
            let full_s = Trajectory::along(&path, &limits).expect("a trajectory").duration_s();
            prop_assert!((stopping_s * share / full_s - 1.0).abs() < 1e-9);
        }
    }

    /// Checks that the result is never slower than the rounded path, that fixed way points stay, and that edges and corners are
    /// accepted or unchanged.
    #[test]
    fn way_points_move_only_where_that_is_proven_and_saves_time(seed in any::<u64>(), count in 3usize..7, share in 0.1..1.0) {
        let path = polyline(seed, count);
        for method in [TimingMethod::TimeOptimal, TimingMethod::JerkLimited] {
            let limits = limits_by(method);
            let path = CurvedPath::stopping(&path);
            let mut proof = Recorded { share, accepted: Vec::new() };
            let corners = path.rounded(&limits, |at, points| proof.corner(at, points));
            let mut proof = Recorded { share, accepted: Vec::new() };
            let refined = path.refined(&limits, |at| at % 2 == 1, &mut proof);
            for (at, (before, after)) in path.waypoints.iter().zip(&refined.waypoints).enumerate() {
                prop_assert!(at % 2 == 1 && at + 1 < path.waypoints.len() || before == after);
            }
            for corner in &refined.corners {
                prop_assert!(proof.accepted.contains(&corner.control_points.to_vec()));
            }
            for edge in refined.waypoints.windows(2) {
                prop_assert!(path.waypoints.windows(2).any(|was| was == edge) || proof.accepted.contains(&edge.to_vec()));
            }
            let rounded = CurvedPath { corners: &corners, ..path };
            let moved = CurvedPath { waypoints: &refined.waypoints, corners: &refined.corners, ..path };
            let [moved_s, rounded_s] =
                [moved, rounded].map(|path| Trajectory::along_curve(&path, &limits).expect("a trajectory").duration_s());
            prop_assert!(moved_s <= rounded_s * (1.0 + 1e-9), "{moved_s} against {rounded_s}");
        }
    }

    #[test]
    fn a_finer_grid_hardly_shortens_the_time(seed in any::<u64>(), count in 3usize..8, size in -3.0..0.5) {
        let (path, limits) = (polyline(seed, count), motion_limits());
        let cuts = cuts(&path, &limits, [10.0_f64.powf(size); 2]);
        let curve = PathCurve::along(&path, &limits.velocity, &cuts);
        let taken = time_optimal(&curve, &of_pieces(&curve, &limits)).duration_s;
        let fine = on_grid(&curve, &of_pieces(&curve, &limits), 2048).duration_s;
        prop_assert!(fine <= taken * (1.0 + 1e-5) && taken <= fine * 1.01, "{taken} against {fine}");
    }

    #[test]
    fn a_line_taken_as_a_corner_takes_as_long(seed in any::<u64>()) {
        let limits = motion_limits();
        let mut curve = PathCurve::along(&polyline(seed, 2), &limits.velocity, &[]);
        let exact = time_optimal(&curve, &of_pieces(&curve, &limits)).duration_s;
        curve.pieces[0].turn = Some(vec![0.0; JOINTS]);
        let staged = on_grid(&curve, &of_pieces(&curve, &limits), 1000).duration_s;
        prop_assert!(staged >= exact * (1.0 - 1e-9) && staged <= exact * 1.0001, "{staged} against {exact}");
    }
}

/// Proof that accepts small changes and records them.
struct Recorded {
    share: f64,
    accepted: Vec<Vec<Vec<f64>>>,
}

impl Recorded {
    fn accept(&mut self, points: &[Vec<f64>]) -> bool {
        let (first, last) = (&points[0], &points[points.len() - 1]);
        let is_small = first.iter().zip(last).all(|(a, b)| (a - b).abs() < 3.0 * self.share);
        if is_small {
            self.accepted.push(points.to_vec());
        }
        is_small
    }
}

impl CurveProof for Recorded {
    fn edge(&mut self, _: usize, ends: [&[f64]; 2]) -> bool {
        self.accept(&ends.map(<[f64]>::to_vec))
    }

    fn corner(&mut self, _: usize, control_points: &[Vec<f64>; 5]) -> bool {
        self.accept(control_points)
    }
}

/// Curve in one parameter, for the other implementation.
struct Evaluator(PathCurve);

impl PathEvaluator2nd for Evaluator {
    fn dim(&self) -> usize {
        JOINTS
    }

    fn evaluate_up_to_2nd(
        &self,
        s: &[f64],
        q: &mut [f64],
        dq: &mut [f64],
        ddq: &mut [f64],
    ) -> Result<(), PathError> {
        let pieces = &self.0.pieces;
        for (column, s) in s.iter().enumerate() {
            let piece = pieces.partition_point(|piece| piece.end_s() <= *s).min(pieces.len() - 1);
            let position = pieces[piece].position(*s);
            for (joint, value) in position.iter().enumerate() {
                let at = column * JOINTS + joint;
                q[at] = *value;
                let of_joint = pieces[piece].derivatives(joint, *s);
                (dq[at], ddq[at]) = (of_joint.first, of_joint.second);
            }
        }
        Ok(())
    }
}

/// Returns the duration that `copp`, another implementation of TOPP-RA, finds on an even grid.
fn other_duration_s(curve: PathCurve, limits: &MotionLimits, stations: usize) -> f64 {
    let end = curve.pieces.last().expect("a path").end_s();
    let s: Vec<f64> = (0..stations).map(|k| end * k as f64 / (stations - 1) as f64).collect();
    let path = Path::from_evaluator_2nd(Evaluator(curve), 0.0, end).expect("a path");
    let negative = |values: &[f64]| -> Vec<f64> { values.iter().map(|x| -x).collect() };
    let (velocity, acceleration) = (&limits.velocity[..], &limits.acceleration[..]);
    let (least_velocity, least_acceleration) = (negative(velocity), negative(acceleration));
    let mut robot = copp::robot::Robot::with_capacity(JOINTS, stations);
    robot
        .with_s(s.as_slice())
        .expect("stations")
        .with_q_from_path_2nd(&path, 0, stations)
        .expect("the path")
        .with_axial_velocity((velocity, stations), (&least_velocity[..], stations), 0)
        .expect("velocities")
        .with_axial_acceleration((acceleration, stations), (&least_acceleration[..], stations), 0)
        .expect("accelerations");
    let problem = Topp2ProblemBuilder::new(&robot, (0, stations - 1), (0.0, 0.0)).build().expect("a problem");
    let options = ReachSet2OptionsBuilder::new().build().expect("options");
    let profile = topp2_ra(&problem, &options).expect("a solution");
    s_to_t_topp2(&s, &profile, 0.0).expect("times").0
}

#[test]
fn rounded_paths_take_as_long_as_another_implementation_says() {
    const STATIONS: usize = 20_001;
    let limits = motion_limits();
    for (seed, size) in (0..12).zip([0.05, 0.3, 10.0].into_iter().cycle()) {
        let path = polyline(seed, 5);
        let cuts = cuts(&path, &limits, [size, 1.5 * size]);
        let curve = PathCurve::along(&path, &limits.velocity, &cuts);
        let ours = on_grid(&curve, &of_pieces(&curve, &limits), 1024).duration_s;
        let other = other_duration_s(curve, &limits, STATIONS);
        assert!((ours / other - 1.0).abs() < 2e-3, "seed {seed}: {ours} s, copp {other} s");
    }
}
