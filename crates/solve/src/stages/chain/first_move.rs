use cranny_plan::{Budget, Observer, Outcome, Planner, begin_search};
use cranny_task::{FailureReason, Mode, Move, Segment, State};

use crate::SolveError;
use crate::stages::chain::{Chain, Through};
use crate::stages::onward::Towards;

impl Chain<'_> {
    /// Searches a move as the first stage with the planner, and from there all others.
    pub(super) fn first_move(
        &mut self,
        goal: &Move,
        (planner, budget): (&dyn Planner, Budget),
        state: &State,
        observer: &mut dyn Observer,
    ) -> Result<Through, SolveError> {
        let drawn = |towards: Towards| towards.goals(&self.effort, state);
        let drawn = || Towards::of(goal, None, self.problem).map_or_else(Vec::new, drawn);
        let problem = match goal.regions(self.problem)? {
            Some(regions) => state.moving_into(regions)?,
            None => state.moving(goal.ends(self.problem).unwrap_or_else(drawn))?,
        };
        let seed = self.next_seed(0);
        let mut search = begin_search(planner, &problem, &budget, seed)?;
        let (mut stuck, mut tried) = (None, 0);
        loop {
            let report = search.next(observer)?;
            if report.outcome != Outcome::Solved {
                self.effort.count(&report.statistics, Outcome::Solved);
                let is_over = self.effort.left().is_zero()
                    || self.effort.spent.iterations >= self.request.budget.iterations;
                match (&stuck, report.outcome) {
                    // Every goal was reached, but the stages after it failed. They are searched again from there, unless they
                    // failed without any search.
                    (Some(_), Outcome::GoalsInvalid) if !is_over && tried > 0 => {
                        let budget = Budget { time: self.effort.left(), ..budget };
                        let seed = self.next_seed(0);
                        search = begin_search(planner, &problem, &budget, seed)?;
                        tried = 0;
                        continue;
                    }
                    (Some(_), Outcome::GoalsInvalid) => {
                        self.outcome = if is_over { Outcome::BudgetExhausted } else { Outcome::GaveUp };
                    }
                    _ => (self.outcome, self.refused) = (report.outcome, report.refused),
                }
                return Ok(Err(stuck.unwrap_or(FailureReason::NotMoved)));
            }
            let there = state.at(report.path.last().map_or(&[], |q| &q[..]));
            let before = self.effort.spent.iterations;
            let through = self.through(1, &there, None, observer)?;
            tried += self.effort.spent.iterations - before;
            match through {
                Ok(onward) => {
                    self.effort.count(&report.statistics, Outcome::Solved);
                    // The end of the last motion may move within its goal.
                    let solved =
                        if self.stages.len() == 1 { problem.clone() } else { state.moving(vec![there.q])? };
                    let moved = (Segment::empty(0, Mode::REACH, report.path), Some(solved));
                    return Ok(Ok([vec![moved], onward].concat()));
                }
                Err(reason) => {
                    stuck = Some(reason);
                    search.reject();
                }
            }
        }
    }
}
