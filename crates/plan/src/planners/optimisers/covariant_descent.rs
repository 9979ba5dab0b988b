use cranny_collision::Cell;
use cranny_robot::JointLimits;
use serde::{Deserialize, Serialize};

use crate::curves::curve::clamp;
use crate::curves::obstacle_cost::{CostRange, ObstacleCost};
use crate::curves::smoothness::{GoalEnd, Smoothness};
use crate::curves::starts::Improver;
use crate::search::connector::Path;
use crate::search::search_state::Search;
use crate::wall_clock::now;
use crate::{PlanError, Ranges};

/// Settings of the covariant descent.
// Unknown keys are refused when a planner is created; the planners flatten these settings into their own.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Descent {
    /// Factor η of a step. Default 0.1.
    pub rate: f64,
    /// Weight of the nearness of obstacles. Default 1.
    pub obstacle_weight: f64,
    /// Weight of the smoothness in the first step. Default 0.1.
    pub smooth_weight: f64,
    /// Factor by which the weight of the smoothness grows with each step. Default 1.02.
    pub smooth_growth: f64,
    /// Time between two way points, in seconds. Default 0.1.
    pub step_s: f64,
    /// Greatest derivative of the cost of obstacles by one joint value. Default 10.
    pub most_slope: f64,
}

impl Default for Descent {
    fn default() -> Self {
        Self {
            rate: 0.1,
            obstacle_weight: 1.0,
            smooth_weight: 0.1,
            smooth_growth: 1.02,
            step_s: 0.1,
            most_slope: 10.0,
        }
    }
}

impl Descent {
    /// Checks the ranges of the settings.
    pub(crate) fn check(&self, ranges: Ranges) -> Result<Ranges, PlanError> {
        ranges
            .positive("rate", self.rate)?
            .positive("obstacle_weight", self.obstacle_weight)?
            .positive("smooth_weight", self.smooth_weight)?
            .positive("smooth_growth", self.smooth_growth)?
            .positive("step_s", self.step_s)?
            .positive("most_slope", self.most_slope)
    }
}

/// State of a covariant descent of a curve.
pub(crate) struct CovariantDescent<'a> {
    pub limits: &'a [JointLimits],
    pub settings: Descent,
    pub obstacles: ObstacleCost<'a>,
    pub path: Path,
    pub smooth_weight: f64,
    smoothness: Option<Smoothness>,
    costs: Vec<f64>,
}

impl<'a> CovariantDescent<'a> {
    pub fn new(cell: &'a Cell, range: CostRange, settings: Descent) -> Self {
        Self {
            limits: cell.robot().limits(),
            settings,
            obstacles: ObstacleCost::new(cell, range, settings.step_s),
            path: Path::new(),
            smooth_weight: settings.smooth_weight,
            smoothness: None,
            costs: Vec::new(),
        }
    }

    /// Returns the gradient of the whole cost by the way points (m, rad; one value per joint) from 1 on, as many as the metric has.
    pub fn gradient(&mut self, smoothness: &Smoothness, search: &mut Search) -> Vec<Vec<f64>> {
        let begin = now();
        let Descent { obstacle_weight, most_slope, .. } = self.settings;
        let mut rows = vec![vec![0.0; self.limits.len()]; smoothness.free()];
        self.obstacles.measure(&self.path, &mut self.costs, Some((obstacle_weight, &mut rows[..])));
        for value in rows.iter_mut().flatten() {
            *value = value.clamp(-most_slope, most_slope);
        }
        smoothness.add_gradient(&self.path, self.smooth_weight, &mut rows);
        search.statistics.collision_checks += self.path.len() as u64;
        search.statistics.collision_time_s += begin.elapsed().as_secs_f64();
        rows
    }

    /// Moves the way points from 1 on by `scale` times the rows (m, rad; one value per joint).
    pub fn move_by(&mut self, rows: &[Vec<f64>], scale: f64) {
        for (q, row) in self.path.iter_mut().skip(1).zip(rows) {
            for (value, row) in q.iter_mut().zip(row) {
                *value += scale * row;
            }
        }
    }

    /// Performs 3 of [`Chomp`](crate::Chomp).
    pub fn keep_limits(&mut self, smoothness: &Smoothness) {
        const ROUNDS: usize = 10;
        /// Norm of the violations below which clamping changes little (m, rad).
        const ENOUGH: f64 = 1e-2;
        let free = smoothness.free();
        for joint in 0..self.limits.len() {
            for _ in 0..ROUNDS {
                let limits = &self.limits[joint];
                let over = |q: &Vec<f64>| limits.clamp(q[joint]) - q[joint];
                let violations: Vec<f64> = self.path.iter().skip(1).take(free).map(over).collect();
                let norm = violations.iter().map(|v| v * v).fold(0.0, |sum, v| sum + v).sqrt();
                if norm <= ENOUGH {
                    break;
                }
                let mut rows: Vec<Vec<f64>> = violations.iter().map(|v| vec![*v]).collect();
                smoothness.spread(&mut rows);
                let at = |a: &usize, b: &usize| violations[*a].abs().total_cmp(&violations[*b].abs());
                let Some(worst) = (0..free).max_by(at) else { break };
                let reach = rows[worst][0].abs();
                if reach <= 0.0 {
                    break;
                }
                let scale = violations[worst].abs() / reach;
                for (q, row) in self.path.iter_mut().skip(1).zip(&rows) {
                    q[joint] += scale * row[0];
                }
            }
        }
        let end = (free + 1).min(self.path.len());
        clamp(&mut self.path[1..end], self.limits);
    }
}

impl Improver for CovariantDescent<'_> {
    fn begin(&mut self, path: Path, _goals: &[Vec<f64>], _goal: usize, _search: &mut Search) {
        self.smooth_weight = self.settings.smooth_weight;
        let free = path.len().saturating_sub(2).max(1);
        if self.smoothness.as_ref().is_none_or(|smoothness| smoothness.free() != free) {
            self.smoothness = Smoothness::new(free, 1, self.settings.step_s, GoalEnd::Fixed);
        }
        self.path = path;
    }

    fn step(&mut self, search: &mut Search) -> bool {
        let Some(smoothness) = self.smoothness.take() else { return false };
        // 2.
        let mut rows = self.gradient(&smoothness, search);
        smoothness.spread(&mut rows);
        self.move_by(&rows, -self.settings.rate);
        self.smooth_weight *= self.settings.smooth_growth;
        // 3.
        self.keep_limits(&smoothness);
        self.smoothness = Some(smoothness);
        true
    }

    fn path(&self) -> &Path {
        &self.path
    }
}
