use cranny_collision::Cell;
use cranny_robot::JointLimits;
use cranny_spatial::nalgebra::{Cholesky, DMatrix};
use cranny_task::Problem;
use serde::{Deserialize, Serialize};

use crate::curves::curve::clamp;
use crate::curves::curve_settings::CurveSettings;
use crate::curves::obstacle_cost::{CostRange, ObstacleCost};
use crate::curves::smoothness::{GoalEnd, Smoothness};
use crate::curves::starts::{Improver, improve};
use crate::search::connector::Path;
use crate::search::search_state::Search;
use crate::wall_clock::now;
use crate::{Budget, Observer, PlanError, PlanReport, Planner, Ranges, Reach};

/// STOMP (Kalakrishnan, Chitta, Theodorou, Pastor & Schaal 2011, "STOMP: Stochastic trajectory optimization for motion planning",
/// §III): a curve moves towards those of its random neighbours that cost less, without a gradient.
///
/// 1. A start begins with a straight line to a goal (the starts are those of `curves/starts.rs`, which also proves the curves).
/// 2. A step draws `rollouts` curves `ξ + ε_k` with `ε_k ~ N(0, σ²·R⁻¹)`, R the metric of accelerations, scaled so that σ is the
///    greatest standard deviation of a way point.
/// 3. `S_ki` is the cost of way point i of curve k. Each way point has the probabilities `P_ki ∝ exp(−h·(S_ki − min)/(max − min))`
///    over the curves.
/// 4. `ξ ← ξ + M·Σ_k P_ki·ε_ki`, with M the matrix `R⁻¹` whose columns are scaled to a maximum of 1/n. Joint limits are clamped. σ
///    shrinks by `decay`.
///
/// One iteration is one step, or one batch of inverse kinematics. The cost of a way point is that of `chomp` with certified
/// distances, which the publication computes in a distance field. `noise` and `decay` are ours, since the publication gives no value
/// for them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
// Unknown keys are refused when a planner is created.
pub struct Stomp {
    /// Way points, steps and starts.
    #[serde(flatten)]
    pub curve: CurveSettings,
    /// Distances that cost.
    #[serde(flatten)]
    pub range: CostRange,
    /// Number of random curves in a step. Default 10.
    pub rollouts: usize,
    /// Sensitivity h of the probabilities to the cost. Default 10, the published value.
    pub sensitivity: f64,
    /// Greatest standard deviation σ of a way point in the first step (m, rad). Default 0.3.
    pub noise: f64,
    /// Factor of σ from one step to the next, in [0, 1]. Default 0.97.
    pub decay: f64,
    /// Time between two way points, in seconds. Default 0.1, as in `chomp`.
    pub step_s: f64,
}

impl Default for Stomp {
    fn default() -> Self {
        Self {
            curve: CurveSettings::default(),
            range: CostRange::default(),
            rollouts: 10,
            sensitivity: 10.0,
            noise: 0.3,
            decay: 0.97,
            step_s: 0.1,
        }
    }
}

impl Planner for Stomp {
    fn name(&self) -> &'static str {
        "stomp"
    }

    fn settings(&self) -> serde_json::Value {
        serde_json::json!(self)
    }

    fn check(&self) -> Result<(), PlanError> {
        const MOST_ROLLOUTS: usize = 1000;
        let ranges = self.curve.check(Ranges::of(self.name()))?;
        self.range
            .check(ranges)?
            .count("rollouts", self.rollouts, MOST_ROLLOUTS)?
            .positive("sensitivity", self.sensitivity)?
            .positive("noise", self.noise)?
            .share("decay", self.decay)?
            .positive("step_s", self.step_s)?;
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
        let mut neighbours = Neighbours::new(cell, self);
        let guide = Reach::default();
        improve(self.name(), self.curve, &mut neighbours, &guide, problem, (budget, seed), observer)
    }
}

struct Neighbours<'a> {
    settings: &'a Stomp,
    limits: &'a [JointLimits],
    obstacles: ObstacleCost<'a>,
    path: Path,
    /// Factor of the covariance, with the greatest standard deviation 1.
    spread: DMatrix<f64>,
    /// Matrix M of the publication.
    smoother: DMatrix<f64>,
    noise: f64,
}

impl<'a> Neighbours<'a> {
    fn new(cell: &'a Cell, settings: &'a Stomp) -> Self {
        let none = || DMatrix::zeros(0, 0);
        Self {
            settings,
            limits: cell.robot().limits(),
            obstacles: ObstacleCost::new(cell, settings.range, settings.step_s),
            path: Path::new(),
            spread: none(),
            smoother: none(),
            noise: settings.noise,
        }
    }

    /// Sets the matrices for a number of free way points.
    fn set_metric(&mut self, free: usize) {
        let Some(smoothness) = Smoothness::new(free, 2, 1.0, GoalEnd::Fixed) else { return };
        let inverse = smoothness.inverse();
        let greatest = inverse.diagonal().max();
        let Some(factor) = Cholesky::new(inverse / greatest) else { return };
        self.spread = factor.l();
        self.smoother = inverse.clone();
        for mut column in self.smoother.column_iter_mut() {
            let most = column.max() * free as f64;
            column /= most;
        }
    }
}

impl Improver for Neighbours<'_> {
    fn begin(&mut self, path: Path, _goals: &[Vec<f64>], _goal: usize, _search: &mut Search) {
        let free = path.len().saturating_sub(2).max(1);
        if self.spread.nrows() != free {
            self.set_metric(free);
        }
        self.path = path;
        self.noise = self.settings.noise;
    }

    fn step(&mut self, search: &mut Search) -> bool {
        let (free, joints) = (self.spread.nrows(), self.limits.len());
        if free == 0 || self.path.len() != free + 2 {
            return false;
        }
        let begin = now();
        // 2.
        let mut rollouts: Vec<(DMatrix<f64>, Vec<f64>)> = Vec::with_capacity(self.settings.rollouts);
        for _ in 0..self.settings.rollouts {
            let normal = DMatrix::from_fn(free, joints, |_, _| search.random.normal());
            let noise = (&self.spread * normal) * self.noise;
            let mut path = self.path.clone();
            for (index, q) in path[1..=free].iter_mut().enumerate() {
                for (joint, value) in q.iter_mut().enumerate() {
                    *value += noise[(index, joint)];
                }
            }
            clamp(&mut path[1..=free], self.limits);
            let mut costs = Vec::new();
            self.obstacles.measure(&path, &mut costs, None);
            rollouts.push((noise, costs));
        }
        search.statistics.collision_checks += (self.settings.rollouts * self.path.len()) as u64;
        search.statistics.collision_time_s += begin.elapsed().as_secs_f64();
        // 3.
        let mut update = DMatrix::zeros(free, joints);
        for index in 0..free {
            let costs = || rollouts.iter().map(|(_, costs)| costs[index + 1]);
            let (least, most) = (costs().fold(f64::INFINITY, f64::min), costs().fold(0.0, f64::max));
            let range = (most - least).max(f64::MIN_POSITIVE);
            let weights: Vec<f64> =
                costs().map(|cost| libm::exp(-self.settings.sensitivity * (cost - least) / range)).collect();
            let total = weights.iter().fold(0.0, |sum, weight| sum + weight);
            for ((noise, _), weight) in rollouts.iter().zip(&weights) {
                for joint in 0..joints {
                    update[(index, joint)] += weight / total * noise[(index, joint)];
                }
            }
        }
        // 4.
        let smooth = &self.smoother * update;
        for (index, q) in self.path[1..=free].iter_mut().enumerate() {
            for (joint, value) in q.iter_mut().enumerate() {
                *value += smooth[(index, joint)];
            }
        }
        clamp(&mut self.path[1..=free], self.limits);
        self.noise *= self.settings.decay;
        true
    }

    fn path(&self) -> &Path {
        &self.path
    }
}
