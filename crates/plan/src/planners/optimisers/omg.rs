use cranny_collision::Cell;
use cranny_robot::{IkSettings, IkSolver, distance};
use cranny_spatial::Pose;
use cranny_spatial::nalgebra::{Cholesky, DMatrix};
use cranny_task::Problem;
use serde::{Deserialize, Serialize};

use crate::curves::curve::{resampled, straight};
use crate::curves::curve_settings::CurveSettings;
use crate::curves::obstacle_cost::CostRange;
use crate::curves::smoothness::{GoalEnd, Smoothness};
use crate::curves::starts::{Improver, improve};
use crate::planners::optimisers::covariant_descent::{CovariantDescent, Descent};
use crate::planners::optimisers::goal_learner::{GoalChoice, GoalLearner};
use crate::search::connector::Path;
use crate::search::search_state::Search;
use crate::{Budget, Observer, PlanError, PlanReport, Planner, Ranges, Reach};

/// OMG-Planner (Wang, Xiang & Fox 2020, "Manipulation trajectory optimization with online grasp synthesis and selection", §IV): the
/// covariant descent of `chomp` towards a set of goals, one of which it chooses as it descends.
///
/// 1. A goal ends in a tail: `tail` way points over `standoff_m` along the approach of the hand, by inverse kinematics. Goals
///    without one, or with one of length 2 or more, are dropped; so are goals nearer than `apart` to an earlier one.
/// 2. In each of the first `goal_steps` steps every goal gets a cost: `F_obs` of the straight line to it from a way point that
///    advances with the steps, and its squared distance from there. A distribution learns from the costs; its greatest goal is the
///    next (`GoalLearner`).
/// 3. The step of the descent keeps the tail at the goal: `Δξ = −ηA⁻¹g + ηMCA⁻¹g − M(Cξ − goal)`, `M = A⁻¹Cᵀ(CA⁻¹Cᵀ)⁻¹`, with C the
///    rows of the tail. Limits are kept as in `chomp`.
/// 4. The starts are those of `curves/starts.rs`, which also proves the curves. The first curve has the spacing of a cubic.
///
/// One iteration is one step, or one batch of inverse kinematics. Values are those of the code (`liruiw/OMG-Planner` 53e899c), with
/// these differences: certified distances instead of a distance field of points, links against each other too, `line_points` on a
/// line to a goal, at most `most_goals` goals (100 in the code, on a graphics card), and a squared distance where the code takes
/// differences along the joints.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
// Unknown keys are refused when a planner is created.
pub struct Omg {
    /// Way points, steps and starts.
    #[serde(flatten)]
    pub curve: CurveSettings,
    /// Distances that cost.
    #[serde(flatten)]
    pub range: CostRange,
    /// Covariant descent.
    #[serde(flatten)]
    pub descent: Descent,
    /// Choice of the goal. Default: mirror descent.
    pub choice: GoalChoice,
    /// Number of steps in which the goal may change. Default 50; 20 without a change follow.
    pub goal_steps: u64,
    /// Number of way points of the tail, the goal included. Default 5.
    pub tail: usize,
    /// Length of the tail at the hand, in metres. Default 0.08.
    pub standoff_m: f64,
    /// Least distance between two goals, in the plain norm of `q` (m and rad alike). Default 0.5.
    pub apart: f64,
    /// Greatest number of goals in a start. Default 20.
    pub most_goals: usize,
    /// Number of points at which a straight line to a goal is measured. Default 8.
    pub line_points: usize,
}

impl Default for Omg {
    fn default() -> Self {
        Self {
            curve: CurveSettings { steps: 70, ..CurveSettings::default() },
            range: CostRange::default(),
            descent: Descent::default(),
            choice: GoalChoice::Mirror,
            goal_steps: 50,
            tail: 5,
            standoff_m: 0.08,
            apart: 0.5,
            most_goals: 20,
            line_points: 8,
        }
    }
}

impl Planner for Omg {
    fn name(&self) -> &'static str {
        "omg"
    }

    fn settings(&self) -> serde_json::Value {
        serde_json::json!(self)
    }

    fn check(&self) -> Result<(), PlanError> {
        /// Way points that remain besides start and tail.
        const BODY: usize = 3;
        const MOST_POINTS: usize = 1000;
        let ranges = self.curve.check(Ranges::of(self.name()))?;
        self.descent
            .check(self.range.check(ranges)?)?
            .positive("goal_steps", self.goal_steps as f64)?
            .count("tail", self.tail, self.curve.way_points.saturating_sub(BODY))?
            .positive("standoff_m", self.standoff_m)?
            .positive("apart", self.apart)?
            .count("most_goals", self.most_goals, usize::MAX)?
            .count("line_points", self.line_points, MOST_POINTS)?;
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
        let mut descent = GoalSetDescent::new(self, problem, cell);
        let guide = Reach::default();
        improve(self.name(), self.curve, &mut descent, &guide, problem, (budget, seed), observer)
    }
}

struct GoalSetDescent<'a> {
    settings: &'a Omg,
    problem: &'a Problem,
    solver: IkSolver<'a>,
    descent: CovariantDescent<'a>,
    /// Tail of each known goal, the goal last; `None` for a dropped one.
    known: Vec<Option<Path>>,
    /// Tails of the goals of this start.
    tails: Vec<Path>,
    goal: usize,
    learner: GoalLearner,
    steps: u64,
    /// Metric of all way points after the start, and of those before the tail.
    metrics: Option<[Smoothness; 2]>,
    /// Matrix M.
    pull: DMatrix<f64>,
    costs: Vec<f64>,
}

impl<'a> GoalSetDescent<'a> {
    fn new(settings: &'a Omg, problem: &'a Problem, cell: &'a Cell) -> Self {
        let (free, tail) = (settings.curve.way_points - 1, settings.tail);
        let step_s = settings.descent.step_s;
        let whole = Smoothness::new(free, 1, step_s, GoalEnd::Free);
        let body = Smoothness::new(free - tail, 1, step_s, GoalEnd::Fixed);
        let metrics = whole.zip(body).map(|(whole, body)| [whole, body]);
        let pull = metrics.as_ref().and_then(|[whole, _]| {
            let columns = whole.inverse().columns(free - tail, tail);
            let inner = Cholesky::new(columns.rows(free - tail, tail).into_owned())?;
            Some(columns * inner.inverse())
        });
        Self {
            settings,
            problem,
            solver: IkSolver::new(problem.robot(), IkSettings::default()),
            descent: CovariantDescent::new(cell, settings.range, settings.descent),
            known: Vec::new(),
            tails: Vec::new(),
            goal: 0,
            learner: GoalLearner::new(settings.choice, 0, settings.goal_steps),
            steps: 0,
            metrics: metrics.filter(|_| pull.is_some()),
            pull: pull.unwrap_or_else(|| DMatrix::zeros(0, 0)),
            costs: Vec::new(),
        }
    }

    /// Returns the tail of a goal; `None` if there is none, or it is too long.
    fn tail_of(&mut self, goal: &[f64]) -> Option<Path> {
        const MOST_LENGTH: f64 = 2.0;
        let robot = self.problem.robot();
        let count = self.settings.tail;
        let world_from_goal = *robot.frames_at(goal).link(robot.tip());
        let mut back = vec![goal.to_vec()];
        for index in 1..count {
            let off_m = self.settings.standoff_m * index as f64 / (count - 1) as f64;
            let pose = world_from_goal * Pose::translation(0.0, 0.0, -off_m);
            let next = self.solver.solve_from(&pose, back.last()?)?.q;
            back.push(next);
        }
        let length =
            back.windows(2).map(|edge| distance(&edge[0], &edge[1])).fold(0.0, |sum, step| sum + step);
        back.reverse();
        (length < MOST_LENGTH).then_some(back)
    }

    /// Performs 1 of [`Omg`] for the goals of a start, with `first` as the first of them.
    fn set_goals(&mut self, goals: &[Vec<f64>], first: usize) {
        let has_approach = self.problem.grasps().is_some();
        for goal in goals.iter().skip(self.known.len()) {
            let tail = if has_approach { self.tail_of(goal) } else { None };
            self.known.push(tail);
        }
        let still = |goal: &[f64]| vec![goal.to_vec(); self.settings.tail];
        self.tails = vec![self.known[first].clone().unwrap_or_else(|| still(&goals[first]))];
        for (goal, tail) in goals.iter().zip(&self.known) {
            let Some(tail) = tail.clone().or_else(|| (!has_approach).then(|| still(goal))) else { continue };
            let is_apart =
                |other: &Path| other.last().is_some_and(|other| distance(other, goal) >= self.settings.apart);
            if self.tails.len() < self.settings.most_goals && self.tails.iter().all(is_apart) {
                self.tails.push(tail);
            }
        }
    }

    /// Performs 2 of [`Omg`].
    fn choose_goal(&mut self, search: &mut Search) {
        /// Weight of the squared distance, relative to that of the smoothness.
        const OF_DISTANCE: f64 = 0.1;
        let Omg { curve, goal_steps, tail, line_points, .. } = self.settings;
        let body = curve.way_points - tail - 1;
        let share = self.steps as f64 / *goal_steps as f64;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "it lies in [0, body]")]
        let place = (share * body as f64).floor() as usize;
        let from = self.descent.path[place.min(body)].clone();
        let mut costs = Vec::with_capacity(self.tails.len());
        for tail in &self.tails {
            let line = straight(&from, &tail[0], line_points + 2);
            self.descent.obstacles.measure(&line, &mut self.costs, None);
            search.statistics.collision_checks += line.len() as u64;
            let nearness = self.costs.iter().fold(0.0, |sum, cost| sum + cost);
            let length = distance(&from, &tail[0]);
            let of_distance = OF_DISTANCE * self.descent.smooth_weight * length * length;
            costs.push(self.settings.descent.obstacle_weight * nearness + of_distance);
        }
        self.goal = self.learner.next(&costs, self.goal);
    }
}

impl Improver for GoalSetDescent<'_> {
    fn begin(&mut self, path: Path, goals: &[Vec<f64>], goal: usize, _search: &mut Search) {
        self.set_goals(goals, goal);
        (self.goal, self.steps) = (0, 0);
        self.learner = GoalLearner::new(self.settings.choice, self.tails.len(), self.settings.goal_steps);
        self.descent.smooth_weight = self.settings.descent.smooth_weight;
        let tail = &self.tails[0];
        // 4. The body of the first curve ends where the tail begins.
        let count = path.len() - tail.len();
        let dense = resampled(&path, DENSE * count);
        let last = dense.len() - 1;
        let end = &dense[last];
        let body = (0..count).map(|index| {
            let share = index as f64 / count as f64;
            let cubic = share * share * (3.0 - 2.0 * share);
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "it lies in [0, last]"
            )]
            let place = (cubic * last as f64).round() as usize;
            let shifted = dense[place].iter().zip(end).zip(&tail[0]);
            shifted.map(|((value, end), tail)| value + cubic * (tail - end)).collect()
        });
        self.descent.path = body.chain(tail.iter().cloned()).collect();
    }

    fn step(&mut self, search: &mut Search) -> bool {
        let Some(metrics) = self.metrics.take() else { return false };
        let [whole, body] = &metrics;
        // 2.
        if self.steps < self.settings.goal_steps && self.tails.len() > 1 {
            self.choose_goal(search);
        }
        self.steps += 1;
        // 3.
        let mut rows = self.descent.gradient(whole, search);
        whole.spread(&mut rows);
        let rate = self.settings.descent.rate;
        let tail = &self.tails[self.goal];
        let begin = rows.len() - tail.len();
        let joints = tail[0].len();
        let pulled = DMatrix::from_fn(tail.len(), joints, |index, joint| {
            let off = self.descent.path[begin + 1 + index][joint] - tail[index][joint];
            rate * rows[begin + index][joint] - off
        });
        let back = &self.pull * pulled;
        for (index, row) in rows.iter_mut().enumerate() {
            for (joint, value) in row.iter_mut().enumerate() {
                *value = back[(index, joint)] - rate * *value;
            }
        }
        self.descent.move_by(&rows, 1.0);
        self.descent.smooth_weight *= self.settings.descent.smooth_growth;
        // The tail is exact, whatever the rounding of M.
        for (q, exact) in self.descent.path[begin + 1..].iter_mut().zip(tail) {
            q.clone_from(exact);
        }
        self.descent.keep_limits(body);
        self.metrics = Some(metrics);
        true
    }

    fn path(&self) -> &Path {
        &self.descent.path
    }
}

/// Points of the resampled first curve for each way point.
const DENSE: usize = 16;
