use cranny_plan::{
    Carrier, CarryEnd, FailureReason, GraspFailure, LiftOffSettings, Observer, PlanError, Problem,
    ShortcutSettings, shortcut,
};
use cranny_spatial::Pose;

use crate::Segment;
use crate::segment::Mode;
use crate::ways_out::WaysOut;

/// What is to be done with the object once it is grasped.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Carry {
    /// Where to.
    pub end: CarryEnd,
    /// How it leaves what it rests on.
    pub lift_off: LiftOffSettings,
}

/// Looks at every grasp that a search has reached whether the object can be carried from there to where it is to go: a
/// grasp that is good for nothing is none.
pub(crate) struct Task<'a> {
    pub carrier: Carrier,
    end: CarryEnd,
    ways_out: WaysOut,
    observer: &'a mut dyn Observer,
    /// The way on from the grasp that was taken: off what the object rests on, and to where it is to go, with the problem
    /// that this second piece solves.
    onward: Option<([Segment; 2], Problem)>,
    /// With the gripper where the others failed, and why.
    failures: Vec<(Pose, FailureReason)>,
}

impl<'a> Task<'a> {
    pub fn new(
        problem: &Problem,
        carry: &Carry,
        seed: u64,
        observer: &'a mut dyn Observer,
    ) -> Result<Self, PlanError> {
        let carrier = Carrier::new(problem, carry.lift_off)?;
        let ways_out = WaysOut::new(problem, &carrier, &carry.end, seed)?;
        Ok(Self { carrier, end: carry.end.clone(), ways_out, observer, onward: None, failures: Vec::new() })
    }

    /// Where the object is to go, home as the configuration that this is.
    pub fn end(&self) -> CarryEnd {
        self.carrier.ends(&self.end).map_or_else(|| self.end.clone(), CarryEnd::Configurations)
    }

    /// Says of each grasp that will not do why that is so.
    pub fn tell_failures(&self, problem: &Problem, failures: &mut Vec<GraspFailure>) {
        let Some(grasps) = problem.grasps().filter(|_| self.onward.is_none()) else { return };
        for (gripper, reason) in &self.failures {
            let Some((grasp, _)) = grasps.nearest(gripper) else { continue };
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
            let settings = ShortcutSettings { seed: self.ways_out.seed, ..ShortcutSettings::default() };
            carry.waypoints = shortcut(&problem, &carry.waypoints, settings)?.path;
        }
        Ok(vec![lift_off, carry])
    }

    /// The way on from a grasp, proven.
    fn find_onward(&mut self, reach: &[Vec<f64>]) -> Result<([Segment; 2], Problem), FailureReason> {
        let grasp = reach.last().ok_or(FailureReason::NotTried)?;
        let grip = self.carrier.close(grasp)?;
        let lift_off = self.carrier.lift_off(&grip, grasp)?;
        let off = &lift_off[lift_off.len() - 1];
        let (carry, problem) = self.ways_out.find(&grip, off, reach, self.observer)?;
        let segment = |mode, waypoints| Segment {
            mode,
            attached: Some(self.carrier.object().to_owned()),
            opening_m: Some(grip.opening_m),
            uneven_m: Some(grip.uneven_m),
            waypoints,
            clearances_m: Vec::new(),
        };
        Ok(([segment(Mode::LiftOff, lift_off), segment(Mode::Carry, carry)], problem))
    }
}

impl Observer for Task<'_> {
    fn node_added(&mut self, tree: usize, q: &[f64], parent: Option<usize>) {
        self.observer.node_added(tree, q, parent);
    }

    fn node_cut(&mut self, tree: usize, node: usize) {
        self.observer.node_cut(tree, node);
    }

    fn progress(&mut self, iterations: u64) {
        self.observer.progress(iterations);
    }

    fn search_ended(&mut self) {
        self.observer.search_ended();
    }

    fn accepts_grasp(&mut self, world_from_tip: &Pose) -> bool {
        let Some(ends) = self.carrier.ends(&self.end) else { return true };
        let Some([first, second]) = self.carrier.blocked_at(world_from_tip, &ends) else { return true };
        self.failures.push((*world_from_tip, FailureReason::EndBlocked { first, second }));
        false
    }

    fn accepts_goal(&mut self, path: &[Vec<f64>]) -> bool {
        match self.find_onward(path) {
            Ok(onward) => self.onward = Some(onward),
            Err(reason) => {
                self.failures.extend(path.last().map(|grasp| (self.carrier.gripper(grasp), reason)));
            }
        }
        self.onward.is_some()
    }

    fn should_stop(&self) -> bool {
        self.observer.should_stop()
    }
}
