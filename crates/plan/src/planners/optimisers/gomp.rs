use cranny_collision::{Cell, PairDistance, Scratch};
use cranny_robot::{IkSettings, IkSolver, Robot};
use cranny_spatial::Pose;
use cranny_task::Problem;
use serde::{Deserialize, Serialize};
use strum::IntoStaticStr;

use crate::curves::curve::{clamp, resampled};
use crate::curves::curve_settings::CurveSettings;
use crate::curves::starts::{Improver, improve};
use crate::planners::optimisers::trajectory_program::{
    Plane, SolvedTrajectory, StepLimits, TrajectoryEnd, TrajectoryProgram,
};
use crate::search::connector::Path;
use crate::search::search_state::Search;
use crate::wall_clock::now;
use crate::{Budget, Observer, PlanError, PlanReport, Planner, Ranges, Reach};

/// Limits that a trajectory of [`Gomp`] keeps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, IntoStaticStr)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum LimitUse {
    /// Velocity and acceleration, as far as the robot states them (GOMP).
    #[default]
    Acceleration,
    /// Jerk too (DJ-GOMP).
    Jerk,
}

/// GOMP and DJ-GOMP (Ichnowski et al. 2020, "GOMP: Grasp-optimized motion planning for bin picking", §IV, and "Deep learning can
/// accelerate grasp-optimized motion planning", §Materials and Methods): the fastest trajectory by sequential quadratic programs.
///
/// 1. A start begins with a straight line to a goal, or with a shortened path of `reach` (`first: reach`), at the spacing of a motion
///    from rest to rest (the starts are those of `curves/starts.rs`, which also proves the curves).
/// 2. A step solves one program about the known trajectory: least jerk, within the limits of the joints and `trust` of the known
///    trajectory, at rest at both ends. Each pair of a link with an obstacle or another link that is near gives a plane, from its
///    certified distance and gradient; its violation costs a price.
/// 3. At a grasp the last configuration is free as long as the pose of the hand stays; inverse kinematics makes it exact.
/// 4. The trajectory is taken if the cost fell by at least a quarter of the prediction, and `trust` grows; otherwise it shrinks.
///    Where nothing improves, the price grows tenfold if planes are violated.
/// 5. Otherwise the time between two way points shrinks by a tenth, from the least one that the trajectory permits, until a program
///    has no solution. The last proven trajectory is the path.
///
/// One iteration is one program, or one batch of inverse kinematics. Steps and prices are those of `TrajOpt` (Schulman et al. 2014,
/// §IV), of which GOMP is a kind. Differences: the publication shortens the horizon by way points, here by their time, so that way
/// points keep their spacing; its obstacles are a height field. The rotation of the grasp about the line of contacts is not free, as a
/// goal here is an exact grasp.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
// Unknown keys are refused when a planner is created.
pub struct Gomp {
    /// Way points, steps and starts.
    #[serde(flatten)]
    pub curve: CurveSettings,
    /// Limits that a trajectory keeps. Default: those of velocity and acceleration.
    pub limit_use: LimitUse,
    /// Greatest change of a joint in the first step (m, rad). Default 0.1.
    pub trust: f64,
    /// Price of a violated plane in the first step, per metre. Default 10.
    pub price: f64,
    /// Distance that the planes demand beyond the demanded one, in metres, for the motion between way points; less near the ends.
    /// Default 0.01.
    pub reserve_m: f64,
}

impl Default for Gomp {
    fn default() -> Self {
        Self {
            curve: CurveSettings { settle: 50, ..CurveSettings::default() },
            limit_use: LimitUse::Acceleration,
            trust: 0.1,
            price: 10.0,
            reserve_m: 0.01,
        }
    }
}

impl Planner for Gomp {
    fn name(&self) -> &'static str {
        "gomp"
    }

    fn settings(&self) -> serde_json::Value {
        serde_json::json!(self)
    }

    fn check(&self) -> Result<(), PlanError> {
        self.curve
            .check(Ranges::of(self.name()))?
            .positive("trust", self.trust)?
            .positive("price", self.price)?
            .positive("reserve_m", self.reserve_m)?;
        Ok(())
    }

    fn plan(
        &self,
        problem: &Problem,
        budget: &Budget,
        seed: u64,
        observer: &mut dyn Observer,
    ) -> Result<PlanReport, PlanError> {
        self.check()?;
        let cell = problem.exact_cell(self.name())?;
        let mut programs = Programs::new(self, problem, cell);
        let guide = Reach::default();
        improve(self.name(), self.curve, &mut programs, &guide, problem, (budget, seed), observer)
    }
}

/// Share of the predicted improvement above which a trajectory is taken, and the factors of the trust otherwise and then.
const TAKEN_SHARE: f64 = 0.25;
const SHRINK: f64 = 0.1;
const GROW: f64 = 1.5;
/// Least trust, least improvement, and greatest violation of a plane that is none (m).
const LEAST_TRUST: f64 = 1e-4;
const LEAST_IMPROVEMENT: f64 = 1e-4;
const TOLERANCE_M: f64 = 1e-4;
/// Factor of the price, and the number of its uses.
const DEARER: f64 = 10.0;
const MOST_PRICES: u32 = 5;
/// Factor of the time between way points.
const FASTER: f64 = 0.9;
/// Distance within which pairs give planes, in metres.
const PLANE_WITHIN_M: f64 = 0.1;

struct Programs<'a> {
    settings: &'a Gomp,
    robot: &'a Robot,
    cell: &'a Cell,
    has_grasps: bool,
    solver: IkSolver<'a>,
    scratch: Scratch,
    pairs: Vec<PairDistance>,
    path: Path,
    /// Cost of the known trajectory without planes; infinite if it was not solved for.
    jerk_cost: f64,
    /// Pose of the gripper at the goal, and the goal.
    goal: (Pose, Vec<f64>),
    step_s: f64,
    trust: f64,
    price: f64,
    prices: u32,
    /// True if a trajectory was found at this time between way points.
    is_feasible: bool,
    /// Planes about the known trajectory.
    planes: Vec<Plane>,
}

impl<'a> Programs<'a> {
    fn new(settings: &'a Gomp, problem: &'a Problem, cell: &'a Cell) -> Self {
        Self {
            settings,
            robot: problem.robot(),
            cell,
            has_grasps: problem.grasps().is_some(),
            solver: IkSolver::new(problem.robot(), IkSettings::default()),
            scratch: cell.scratch(),
            pairs: Vec::new(),
            path: Path::new(),
            jerk_cost: f64::INFINITY,
            goal: (Pose::identity(), Vec::new()),
            step_s: 0.0,
            trust: settings.trust,
            price: settings.price,
            prices: 0,
            is_feasible: false,
            planes: Vec::new(),
        }
    }

    fn has_jerk(&self) -> bool {
        self.settings.limit_use == LimitUse::Jerk
    }

    /// Returns the planes of all near pairs along a path, and the sum of their violations (m).
    fn planes_of(&mut self, path: &[Vec<f64>], search: &mut Search) -> (Vec<Plane>, f64) {
        /// Number of way points near an end at which the reserve is less.
        const ENDS: f64 = 5.0;
        let begin = now();
        let last = path.len() - 1;
        let inner = if self.has_grasps { 1..path.len() } else { 1..last };
        let (mut planes, mut violations) = (Vec::new(), 0.0);
        for way_point in inner {
            let q = &path[way_point];
            let from_end = way_point.min(last - way_point) as f64;
            let reserve_m = self.settings.reserve_m * (from_end / ENDS).min(1.0);
            self.cell.pair_distances(q, PLANE_WITHIN_M + reserve_m, &mut self.scratch, &mut self.pairs);
            for pair in &self.pairs {
                let mut gradient = vec![0.0; q.len()];
                pair.add_gradient(self.robot, self.scratch.frames(), 1.0, &mut gradient);
                let short = pair.required_m + reserve_m - pair.distance_m;
                violations += short.max(0.0);
                let here = gradient.iter().zip(q).map(|(slope, q)| slope * q).fold(0.0, |sum, x| sum + x);
                planes.push(Plane { way_point, gradient, bound: here + short });
            }
        }
        search.statistics.collision_checks += path.len() as u64;
        search.statistics.collision_time_s += begin.elapsed().as_secs_f64();
        (planes, violations)
    }

    /// Returns the end of the next trajectory (3 of [`Gomp`]).
    fn end(&self) -> TrajectoryEnd {
        let Some(q) = self.path.last().filter(|_| self.has_grasps) else {
            return TrajectoryEnd::At(self.goal.1.clone());
        };
        let frames = self.robot.frames_at(q);
        let mut jacobian = self.robot.empty_jacobian();
        self.robot.jacobian(&frames, self.robot.tip(), &mut jacobian);
        let gripper = frames.link(self.robot.tip());
        let translation = self.goal.0.translation.vector - gripper.translation.vector;
        let rotation = (self.goal.0.rotation * gripper.rotation.inverse()).scaled_axis();
        let row = |index: usize| {
            let gradient: Vec<f64> = jacobian.row(index).iter().copied().collect();
            let off = if index < 3 { translation[index] } else { rotation[index - 3] };
            let here = gradient.iter().zip(q).map(|(slope, q)| slope * q).fold(0.0, |sum, x| sum + x);
            (gradient, here + off)
        };
        TrajectoryEnd::On((0..6).map(row).collect())
    }

    /// Weight of the squared jerks: the cost then is about the squared distance from start to goal, whatever the number of way points.
    fn jerk_weight(&self) -> f64 {
        /// Integral of the squared jerk of the smoothest motion from rest to rest over the unit of time and length.
        const OF_UNIT: f64 = 720.0;
        let steps = self.path.len() as f64 - 1.0;
        steps * steps * steps * steps * steps / OF_UNIT
    }

    /// Takes a trajectory as the known one.
    fn take(&mut self, found: &SolvedTrajectory, (planes, jerk_cost): (Vec<Plane>, f64)) {
        let [positions, velocities, accelerations, jerks] = &found.kinds;
        self.path.clone_from(positions);
        (self.planes, self.jerk_cost, self.is_feasible) = (planes, jerk_cost, true);
        let most =
            |rows: &[Vec<f64>], joint: usize| rows.iter().map(|row| row[joint].abs()).fold(0.0, f64::max);
        let has_jerk = self.has_jerk();
        let least_s = self.robot.limits().iter().enumerate().map(|(joint, limits)| {
            let changes = [velocities, accelerations, jerks].map(|rows| most(rows, joint));
            StepLimits::least_step_s(limits, has_jerk, changes)
        });
        self.step_s = self.step_s.min(least_s.fold(0.0, f64::max)).max(f64::MIN_POSITIVE);
    }

    /// Performs 5 of [`Gomp`].
    fn hurry(&mut self) {
        self.step_s *= FASTER;
        (self.trust, self.price, self.prices) = (self.settings.trust, self.settings.price, 0);
        (self.is_feasible, self.jerk_cost) = (false, f64::INFINITY);
    }
}

impl Improver for Programs<'_> {
    fn begin(&mut self, path: Path, goals: &[Vec<f64>], goal: usize, search: &mut Search) {
        /// Points of the resampled first curve for each way point.
        const DENSE: usize = 16;
        let end = goals[goal].clone();
        self.goal = (*self.robot.frames_at(&end).link(self.robot.tip()), end);
        let last = path.len() - 1;
        let dense = resampled(&path, DENSE * last + 1);
        let at = |index: usize| {
            let s = index as f64 / last as f64;
            let share = s * s * s * (10.0 - s * (15.0 - 6.0 * s));
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "it lies in [0, DENSE·last]"
            )]
            let place = (share * (DENSE * last) as f64).round() as usize;
            dense[place].clone()
        };
        self.path = (0..=last).map(at).collect();
        // A first trajectory may change by the trust at each way point, and a path with corners needs more than a straight one.
        const RESERVE: f64 = 2.0;
        let peaks = [1.875, 5.774, 60.0];
        let steps = last as f64;
        let has_jerk = self.has_jerk();
        let least_s = self.robot.limits().iter().enumerate().map(|(joint, limits)| {
            let values = self.path.windows(2).map(|edge| (edge[1][joint] - edge[0][joint]).abs());
            let length = values.fold(0.0, |sum, value| sum + value);
            let change = [
                peaks[0] * length / steps,
                peaks[1] * length / (steps * steps),
                peaks[2] * length / (steps * steps * steps),
            ];
            StepLimits::least_step_s(limits, has_jerk, change)
        });
        self.step_s = RESERVE * least_s.fold(1e-3, f64::max);
        (self.trust, self.price, self.prices) = (self.settings.trust, self.settings.price, 0);
        (self.is_feasible, self.jerk_cost) = (false, f64::INFINITY);
        let known = std::mem::take(&mut self.path);
        self.planes = self.planes_of(&known, search).0;
        self.path = known;
    }

    fn step(&mut self, search: &mut Search) -> bool {
        let jerk_weight = self.jerk_weight();
        let has_jerk = self.has_jerk();
        let limits: Vec<StepLimits> =
            self.robot.limits().iter().map(|limits| StepLimits::of(limits, self.step_s, has_jerk)).collect();
        let end = self.end();
        // 2.
        let program = TrajectoryProgram {
            path: &self.path,
            limits: &limits,
            trust: self.trust,
            planes: &self.planes,
            end: &end,
            price: self.price,
            jerk_weight,
        };
        let Some(mut found) = program.solve() else {
            // A wider trust may make it feasible, unless the time is too short.
            self.trust *= GROW * GROW;
            return !self.is_feasible && self.trust <= 1.0 && self.jerk_cost.is_infinite();
        };
        // The program keeps its equalities and boxes up to rounding.
        clamp(&mut found.kinds[0], self.robot.limits());
        found.kinds[0][0].clone_from(&self.path[0]);
        // 3.
        if let Some(last) = found.kinds[0].last_mut() {
            if self.has_grasps {
                let Some(exact) = self.solver.solve_from(&self.goal.0, last) else { return false };
                *last = exact.q;
            } else {
                last.clone_from(&self.goal.1);
            }
        }
        let short = |planes: &[Plane], path: &[Vec<f64>]| {
            let violation = |plane: &Plane| {
                let here = plane.gradient.iter().zip(&path[plane.way_point]).map(|(a, q)| a * q);
                (plane.bound - here.fold(0.0, |sum, x| sum + x)).max(0.0)
            };
            planes.iter().map(violation).fold(0.0, |sum, x| sum + x)
        };
        let before = self.jerk_cost + self.price * short(&self.planes, &self.path);
        let squares = found.kinds[3].iter().flatten().map(|jerk| jerk * jerk).fold(0.0, |sum, x| sum + x);
        let jerk_cost = 0.5 * jerk_weight * squares;
        let path = found.kinds[0].clone();
        let (planes, violations) = self.planes_of(&path, search);
        // 4.
        let (predicted, gained) = (before - found.value, before - jerk_cost - self.price * violations);
        let is_first = self.jerk_cost.is_infinite();
        if is_first || gained >= TAKEN_SHARE * predicted {
            self.take(&found, (planes, jerk_cost));
            self.trust *= if is_first { 1.0 } else { GROW };
        } else {
            self.trust *= SHRINK;
        }
        let is_settled = !is_first && (predicted < LEAST_IMPROVEMENT || self.trust < LEAST_TRUST);
        if is_settled {
            if short(&self.planes, &self.path) > TOLERANCE_M {
                if self.prices >= MOST_PRICES {
                    return false;
                }
                self.price *= DEARER;
                self.prices += 1;
                self.trust = self.settings.trust;
            } else {
                // 5.
                self.hurry();
            }
        }
        true
    }

    fn path(&self) -> &Path {
        &self.path
    }
}
