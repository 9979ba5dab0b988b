use std::time::{Duration, Instant};

use cranny_plan::{
    Budget, Carrier, CarryEnd, FailureReason, Goal, Grip, Observer, Outcome, PlanError, Problem, search,
};
use cranny_robot::{between, distance};
use cranny_spatial::Stream;

/// Iterations of the first searches for a way out of a grasp that was reached: most need fewer than a hundred.
const FIRST_ITERATIONS: u64 = 250;
/// After so many that found none the next ones may take twice as many.
const SEARCHES_PER_DOUBLING: u32 = 8;
/// Of the shortest searches for a way to a place. From most grasps there is none, and from some it is found soon: to look
/// long from few is worse than to look shortly from many.
const PLACE_ITERATIONS: u64 = 500;

/// Random configurations that are looked at for one in which an object is out …
const MOST_DRAWS: u32 = 2000;
/// … until there are so many of them.
const ENOUGH_OUT: usize = 8;
/// How far from where it begins each joint of the first of them may be (m, rad) …
const NEAREST_DRAW: f64 = 0.1;
/// … and of the last.
const FARTHEST_DRAW: f64 = 3.0;
/// Along a way out an object is looked for to be out every so far (m, rad).
const LOOK_EVERY: f64 = 0.05;

/// Looks for ways from where an object is off what it rested on to where it is to go.
pub(crate) struct WaysOut {
    end: CarryEnd,
    /// The ends, where they are counted.
    ends: Vec<Vec<f64>>,
    /// Whether it is to go to where the robot started from.
    is_home: bool,
    limits: Vec<[f64; 2]>,
    pub seed: u64,
    /// When all of it has to end.
    begin: Instant,
    time: Duration,
    /// Searches that ended without a way.
    exhausted: u32,
}

impl WaysOut {
    /// Ways of this problem's target, for so long from now on.
    pub fn new(
        problem: &Problem,
        carrier: &Carrier,
        end: &CarryEnd,
        (seed, time): (u64, Duration),
    ) -> Result<Self, PlanError> {
        let ends = carrier.ends(end).unwrap_or_default();
        if !ends.is_empty() {
            // They fit the robot.
            problem.with_goal(Goal::Configurations(ends.clone()))?;
        }
        let is_home = ends.iter().any(|end| end == problem.start());
        let limits = problem.robot().limits().iter().map(|limits| [limits.lower, limits.upper]).collect();
        Ok(Self { end: end.clone(), ends, is_home, limits, seed, begin: Instant::now(), time, exhausted: 0 })
    }

    /// A way from the end of a lift-off, and the problem that it solves. It may join the way that led to the grasp, from
    /// wherever that is proven to be free with the object in the hand too: often what is left to find is the way out of the
    /// narrow.
    pub fn find(
        &mut self,
        grip: &Grip,
        from: &[f64],
        reach: &[Vec<f64>],
        observer: &mut dyn Observer,
    ) -> Result<(Vec<Vec<f64>>, Problem), FailureReason> {
        let not_carried = |_: PlanError| FailureReason::NotCarried;
        let (back, others) = match self.end {
            CarryEnd::Out { clear_m } => self.ways_to_be_out(grip, from, reach, clear_m),
            // Where the robot started from is where all ways to a place begin that are not found directly.
            CarryEnd::Place(_) => (grip.free_along(reach), Vec::new()),
            _ if self.is_home => (grip.free_along(reach), self.ends.clone()),
            _ => (Vec::new(), self.ends.clone()),
        };
        // The nearest to the grasp first.
        let joints: Vec<Vec<f64>> = back.iter().rev().chain(&others).cloned().collect();
        let narrow = grip.carrying(from, joints).map_err(not_carried)?;
        let mut path =
            self.search(&narrow, observer).map_err(not_carried)?.ok_or(FailureReason::NotCarried)?;
        let joined = back.iter().position(|q| path.last() == Some(q)).unwrap_or(0);
        path.extend(back[..joined].iter().rev().cloned());
        let ends = match self.end {
            CarryEnd::Out { clear_m } => {
                until_out(grip, &mut path, clear_m);
                path[path.len() - 1..].to_vec()
            }
            CarryEnd::Place(_) => path[path.len() - 1..].to_vec(),
            _ => self.ends.clone(),
        };
        let problem = grip.carrying(from, ends).map_err(not_carried)?;
        Ok((path, problem))
    }

    /// What is left of the time.
    pub fn left(&self) -> Duration {
        self.time.saturating_sub(self.begin.elapsed())
    }

    /// A way that solves a problem, if a search finds it that is as long as is worth it here.
    pub fn search(
        &mut self,
        problem: &Problem,
        observer: &dyn Observer,
    ) -> Result<Option<Vec<Vec<f64>>>, PlanError> {
        let planner = cranny_plan::default_planner(problem);
        let iterations = match self.end {
            CarryEnd::Place(_) => PLACE_ITERATIONS * luby(self.exhausted + 1),
            _ => FIRST_ITERATIONS << (self.exhausted / SEARCHES_PER_DOUBLING).min(u64::BITS / 2),
        };
        let budget = Budget { iterations, time: self.left() };
        let report = search(planner.as_ref(), problem, &budget, self.seed, &mut Stop(observer))?;
        self.exhausted += u32::from(report.outcome == Outcome::BudgetExhausted);
        Ok((report.outcome == Outcome::Solved).then_some(report.path))
    }

    /// The way that led to the grasp, from where the object is out on it; where it nowhere is, random configurations in
    /// which it is.
    fn ways_to_be_out(
        &self,
        grip: &Grip,
        from: &[f64],
        reach: &[Vec<f64>],
        clear_m: f64,
    ) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
        let mut scratch = grip.carrying_scratch();
        let mut back = grip.free_along(reach);
        if let Some(out) = back.iter().rposition(|q| grip.clearance_m(q, clear_m, &mut scratch) >= clear_m) {
            return (back.split_off(out), Vec::new());
        }
        let mut random = Stream::new(self.seed, u64::from(self.exhausted));
        let mut found = Vec::new();
        for draw in 0..MOST_DRAWS {
            let share = f64::from(draw) / f64::from(MOST_DRAWS);
            let wide = NEAREST_DRAW + share * (FARTHEST_DRAW - NEAREST_DRAW);
            let joints = from.iter().zip(&self.limits);
            let q: Vec<f64> = joints
                .map(|(value, [lower, upper])| {
                    random.uniform_between(lower.max(value - wide), upper.min(value + wide))
                })
                .collect();
            if grip.is_free(&q, &mut scratch) && grip.clearance_m(&q, clear_m, &mut scratch) >= clear_m {
                found.push(q);
                if found.len() == ENOUGH_OUT {
                    break;
                }
            }
        }
        (Vec::new(), found)
    }
}

/// The term of this number, from 1 on, of 1, 1, 2, 1, 1, 2, 4, 1, 1, 2, 1, 1, 2, 4, 8, …: how much longer than the first each
/// of many searches may take, of which nobody knows how long they need (Luby, Sinclair & Zuckerman 1993, §3).
fn luby(number: u32) -> u64 {
    let mut number = u64::from(number);
    loop {
        // Of the run of terms that it stands in, as long as 2ᵏ − 1, the last is 2ᵏ⁻¹; before it the last run comes twice.
        let run = (number + 1).next_power_of_two();
        if run == number + 1 {
            return run / 2;
        }
        number -= run / 2 - 1;
    }
}

/// Ends a path where the object is out for the first time.
fn until_out(grip: &Grip, path: &mut Vec<Vec<f64>>, clear_m: f64) {
    let mut scratch = grip.carrying_scratch();
    for edge in 1..path.len() {
        let [a, b] = [&path[edge - 1], &path[edge]];
        let pieces = (distance(a, b) / LOOK_EVERY).ceil().max(1.0);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "A way of so many metres or radians is none"
        )]
        let places = (1..=pieces.min(1e6) as u32).map(|piece| (f64::from(piece) / pieces).min(1.0));
        let mut looks = places.map(|at| between(a, b, at).collect::<Vec<f64>>());
        if let Some(out) = looks.find(|q| grip.clearance_m(q, clear_m, &mut scratch) >= clear_m) {
            path.truncate(edge);
            path.push(out);
            return;
        }
    }
}

/// Passes on nothing but that the search should stop.
struct Stop<'a>(&'a dyn Observer);

impl Observer for Stop<'_> {
    fn should_stop(&self) -> bool {
        self.0.should_stop()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn searches_take_twice_as_long_half_as_often() {
        let terms: Vec<u64> = (1..=15).map(luby).collect();
        assert_eq!(terms, [1, 1, 2, 1, 1, 2, 4, 1, 1, 2, 1, 1, 2, 4, 8]);
    }
}
