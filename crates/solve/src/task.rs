use cranny_plan::{
    Budget, Carrier, FailureReason, Goal, GraspFailure, Grip, LiftOffSettings, Observer, Outcome, PlanError,
    Problem, ShortcutSettings, search, shortcut,
};

use crate::Segment;
use crate::answer::Mode;

/// What is to be done with the object once it is grasped.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Carry {
    /// Where to.
    pub end: CarryEnd,
    /// How it leaves what it rests on.
    pub lift_off: LiftOffSettings,
}

/// Where an object is carried to.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum CarryEnd {
    /// The configuration that the robot started from.
    #[default]
    Home,
    /// Any of these configurations (m, rad; one value per joint each).
    Configurations(Vec<Vec<f64>>),
}

/// Iterations of the first searches for a way out of a grasp that was reached: most need fewer than a hundred.
const FIRST_ITERATIONS: u64 = 500;
/// After so many that found none the next ones may take twice as many.
const SEARCHES_PER_DOUBLING: u32 = 8;

/// Looks at every grasp that a search has reached whether the object can be carried from there to where it is to go: a
/// grasp that is good for nothing is none.
pub(crate) struct Task<'a> {
    pub carrier: Carrier,
    pub ends: Vec<Vec<f64>>,
    is_home: bool,
    seed: u64,
    /// Searches for a way out that ended without one.
    exhausted: u32,
    observer: &'a mut dyn Observer,
    /// The way on from the grasp that was taken: off what the object rests on, and to where it is to go, with the problem
    /// that this second piece solves.
    onward: Option<([Segment; 2], Problem)>,
    /// Where the others failed, and why.
    pub failures: Vec<(Vec<f64>, FailureReason)>,
}

impl<'a> Task<'a> {
    pub fn new(
        problem: &Problem,
        carry: &Carry,
        seed: u64,
        observer: &'a mut dyn Observer,
    ) -> Result<Self, PlanError> {
        let ends = match &carry.end {
            CarryEnd::Home => vec![problem.start().to_vec()],
            CarryEnd::Configurations(ends) => ends.clone(),
        };
        // They fit the robot.
        problem.with_goal(Goal::Configurations(ends.clone()))?;
        Ok(Self {
            carrier: Carrier::new(problem, carry.lift_off)?,
            ends,
            is_home: carry.end == CarryEnd::Home,
            seed,
            exhausted: 0,
            observer,
            onward: None,
            failures: Vec::new(),
        })
    }

    /// Says of each grasp that was reached in vain why it would not do.
    pub fn tell_failures(&self, problem: &Problem, failures: &mut Vec<GraspFailure>) {
        let Some(grasps) = problem.grasps().filter(|_| self.onward.is_none()) else { return };
        for (q, reason) in &self.failures {
            let gripper = *problem.robot().frames_at(q).link(problem.robot().tip());
            let Some((grasp, _)) = grasps.nearest(&gripper) else { continue };
            match failures.iter_mut().find(|failure| failure.grasp == grasp) {
                Some(failure) => failure.reason = reason.clone(),
                None => failures.push(GraspFailure { grasp, reason: reason.clone(), attempts: 0 }),
            }
        }
    }

    /// The way on from the grasp that was taken, the second piece shortened from this seed; nothing if no grasp was.
    pub fn into_onward(self, shortened: bool) -> Result<Vec<Segment>, PlanError> {
        let Some(([lift_off, mut carry], problem)) = self.onward else { return Ok(Vec::new()) };
        if shortened {
            let settings = ShortcutSettings { seed: self.seed, ..ShortcutSettings::default() };
            carry.waypoints = shortcut(&problem, &carry.waypoints, settings)?.path;
        }
        Ok(vec![lift_off, carry])
    }

    /// The way on from a grasp, proven.
    fn find_onward(&mut self, reach: &[Vec<f64>]) -> Result<([Segment; 2], Problem), FailureReason> {
        let grasp = reach.last().ok_or(FailureReason::NotTried)?;
        let grip = self.carrier.close(grasp)?;
        let lift_off = self.carrier.lift_off(&grip, grasp)?;
        let (carry, problem) = self.carry(&grip, &lift_off[lift_off.len() - 1], reach)?;
        let segment = |mode, waypoints| Segment {
            mode,
            attached: Some(self.carrier.object().to_owned()),
            opening_m: Some(grip.opening_m),
            waypoints,
            clearances_m: Vec::new(),
        };
        Ok(([segment(Mode::LiftOff, lift_off), segment(Mode::Carry, carry)], problem))
    }

    /// The way on from the end of a lift-off. Home it may join the way that led to the grasp, from wherever that is proven
    /// to be free with the object in the hand too: often what is left to find is the way out of the narrow.
    fn carry(
        &mut self,
        grip: &Grip,
        from: &[f64],
        reach: &[Vec<f64>],
    ) -> Result<(Vec<Vec<f64>>, Problem), FailureReason> {
        let not_carried = |_: PlanError| FailureReason::NotCarried;
        let problem = grip.carrying(from, self.ends.clone()).map_err(not_carried)?;
        let back = if self.is_home { grip.free_along(reach) } else { Vec::new() };
        // The nearest to the grasp first.
        let joints: Vec<Vec<f64>> = back.iter().rev().chain(&self.ends).cloned().collect();
        let mut narrow = grip.carrying(from, joints).map_err(not_carried)?;
        let planner = cranny_plan::default_planner(problem.criterion());
        let doublings = (self.exhausted / SEARCHES_PER_DOUBLING).min(u64::BITS / 2);
        let budget = Budget { iterations: FIRST_ITERATIONS << doublings, ..Budget::default() };
        let report = search(planner.as_ref(), &mut narrow, &budget, self.seed, &mut Stop(self.observer))
            .map_err(not_carried)?;
        if report.outcome != Outcome::Solved {
            self.exhausted += u32::from(report.outcome == Outcome::BudgetExhausted);
            return Err(FailureReason::NotCarried);
        }
        let mut path = report.path;
        let joined = back.iter().position(|q| path.last() == Some(q)).unwrap_or(0);
        path.extend(back[..joined].iter().rev().cloned());
        Ok((path, problem))
    }
}

impl Observer for Task<'_> {
    fn node_added(&mut self, tree: usize, q: &[f64], parent: Option<usize>) {
        self.observer.node_added(tree, q, parent);
    }

    fn progress(&mut self, iterations: u64) {
        self.observer.progress(iterations);
    }

    fn search_ended(&mut self) {
        self.observer.search_ended();
    }

    fn accepts_goal(&mut self, path: &[Vec<f64>]) -> bool {
        match self.find_onward(path) {
            Ok(onward) => self.onward = Some(onward),
            Err(reason) => self.failures.extend(path.last().map(|grasp| (grasp.clone(), reason))),
        }
        self.onward.is_some()
    }

    fn should_stop(&self) -> bool {
        self.observer.should_stop()
    }
}

/// Passes on nothing but that the search should stop.
struct Stop<'a>(&'a dyn Observer);

impl Observer for Stop<'_> {
    fn should_stop(&self) -> bool {
        self.0.should_stop()
    }
}
