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

/// Iterations of the first search for a way out of a grasp that was reached. Most need fewer than a hundred; each further
/// one may take twice as many as the one before.
const FIRST_ITERATIONS: u64 = 2000;

/// Looks at every grasp that a search has reached whether the object can be carried from there to where it is to go: a
/// grasp that is good for nothing is none.
pub(crate) struct Task<'a> {
    pub carrier: Carrier,
    pub ends: Vec<Vec<f64>>,
    seed: u64,
    iterations: u64,
    observer: &'a mut dyn Observer,
    /// The way on from the grasp that was taken.
    pub onward: Option<[Segment; 2]>,
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
            seed,
            iterations: FIRST_ITERATIONS,
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

    /// The way on from a grasp: off what the object rests on, and to where it is to go; shortened, and proven.
    fn find_onward(&mut self, grasp: &[f64]) -> Result<[Segment; 2], FailureReason> {
        let grip = self.carrier.close(grasp)?;
        let lift_off = self.carrier.lift_off(&grip, grasp)?;
        let carry = self.carry(&grip, &lift_off[lift_off.len() - 1])?;
        let segment = |mode, waypoints| Segment {
            mode,
            attached: Some(self.carrier.object().to_owned()),
            opening_m: Some(grip.opening_m),
            waypoints,
            clearances_m: Vec::new(),
        };
        Ok([segment(Mode::LiftOff, lift_off), segment(Mode::Carry, carry)])
    }

    fn carry(&mut self, grip: &Grip, from: &[f64]) -> Result<Vec<Vec<f64>>, FailureReason> {
        let not_carried = |_: PlanError| FailureReason::NotCarried;
        let mut problem = grip.carrying(from, self.ends.clone()).map_err(not_carried)?;
        let planner = cranny_plan::default_planner(problem.criterion());
        let budget = Budget { iterations: self.iterations, ..Budget::default() };
        let report = search(planner.as_ref(), &mut problem, &budget, self.seed, &mut Stop(self.observer))
            .map_err(not_carried)?;
        if report.outcome != Outcome::Solved {
            self.iterations = self.iterations.saturating_mul(2);
            return Err(FailureReason::NotCarried);
        }
        let settings = ShortcutSettings { seed: self.seed, ..ShortcutSettings::default() };
        Ok(shortcut(&problem, &report.path, settings).map_err(not_carried)?.path)
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
        let Some(grasp) = path.last() else { return false };
        match self.find_onward(grasp) {
            Ok(onward) => self.onward = Some(onward),
            Err(reason) => self.failures.push((grasp.clone(), reason)),
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
