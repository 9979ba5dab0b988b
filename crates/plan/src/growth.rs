use std::time::Instant;

use cranny_collision::Bubble;
use cranny_robot::{Robot, between};

use crate::Problem;
use crate::baseline_check::BaselineCheck;
use crate::search::Search;
use crate::step::Stepper;

/// How a tree grows from one of its nodes.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Growth {
    /// By a step in which the origin of no link frame moves farther than so many metres.
    Step { step_m: f64 },
    /// By a bur: so many spines, of which the first goes towards the target and the others towards random configurations,
    /// each as far as the bubble about the node is free; by a step where the world is nearer than the critical distance, or the
    /// first spine would be shorter.
    Bur { spines: usize, critical_m: f64, step_m: f64 },
}

/// What a tree grows by, from one of its nodes.
pub(crate) struct Grown {
    /// Towards the target: where that ends, unless it is blocked, and whether that is the target.
    pub ahead: Option<(Vec<f64>, bool)>,
    /// The ends of the other spines.
    pub aside: Vec<Vec<f64>>,
}

/// Grows trees along ways that are free by the criterion of a problem.
pub(crate) struct Grower<'a> {
    pub check: BaselineCheck<'a>,
    stepper: Stepper,
    robot: &'a Robot,
    growth: Growth,
}

impl<'a> Grower<'a> {
    pub fn new(problem: &'a Problem, growth: Growth) -> Self {
        let robot = problem.robot().as_ref();
        Self { check: BaselineCheck::of(problem), stepper: Stepper::new(robot), robot, growth }
    }

    /// Grows from `q` towards `target`, another configuration; a bur has its random spines only where it `explores`.
    pub fn grow(&mut self, q: &[f64], target: &[f64], explores: bool, search: &mut Search) -> Grown {
        let (bubble, step_m, spines) = match self.growth {
            Growth::Step { step_m } => (None, step_m, 0),
            Growth::Bur { spines, critical_m, step_m } => {
                let begin = Instant::now();
                let bubble = self.check.bubble(q, critical_m);
                search.statistics.collision_time_s += begin.elapsed().as_secs_f64();
                (bubble, step_m, if explores { spines } else { 1 })
            }
        };
        let bur = bubble.and_then(|bubble| self.bur(q, &bubble, target, (spines, step_m), search));
        bur.unwrap_or_else(|| Grown { ahead: self.step(q, target, step_m, search), aside: Vec::new() })
    }

    /// A step from `q` towards `target`, unless it is blocked: where it ends, and whether that is the target.
    pub fn step(
        &mut self,
        q: &[f64],
        target: &[f64],
        step_m: f64,
        search: &mut Search,
    ) -> Option<(Vec<f64>, bool)> {
        let (_, is_target) = self.stepper.towards(self.robot, q, target, step_m);
        let (to, frames) = (self.stepper.q(), self.stepper.frames());
        let begin = Instant::now();
        let is_free = self.check.edge_to_frames_is_free(q, to, frames);
        search.statistics.collision_checks += 1;
        search.statistics.collision_time_s += begin.elapsed().as_secs_f64();
        is_free.then(|| (to.to_vec(), is_target))
    }

    /// Whether the whole edge between two configurations is free.
    pub fn edge(&mut self, from: &[f64], to: &[f64], search: &mut Search) -> bool {
        let begin = Instant::now();
        search.statistics.collision_checks += 1;
        let is_free = self.check.edge_is_free(from, to);
        search.statistics.collision_time_s += begin.elapsed().as_secs_f64();
        is_free
    }

    /// The bur about `q`, unless its first spine is shorter than a step. Its spines are proven by the bubble that they begin
    /// in.
    fn bur(
        &mut self,
        q: &[f64],
        bubble: &Bubble,
        target: &[f64],
        (spines, step_m): (usize, f64),
        search: &mut Search,
    ) -> Option<Grown> {
        let begin = Instant::now();
        search.statistics.collision_checks += spines as u64;
        let check = &mut self.check;
        let mut spine = |target: &[f64]| {
            let share = check.free_share(bubble, target);
            (between(q, target, share).collect::<Vec<f64>>(), share >= 1.0)
        };
        let (end, is_target) = spine(target);
        let is_long = is_target || self.stepper.displacement_between(self.robot, q, &end) >= step_m;
        let grown = is_long.then(|| {
            let aside = (1..spines).map(|_| spine(&search.sample()).0).filter(|end| end != q).collect();
            Grown { ahead: Some((end, is_target)), aside }
        });
        search.statistics.collision_time_s += begin.elapsed().as_secs_f64();
        grown
    }
}
