use std::time::Duration;

use cranny_plan::{
    Carrier, CarryEnd, FailureReason, GraspFailure, Grip, LiftOffSettings, Observer, PlanError, Problem,
    ShortcutSettings, shortcut,
};
use cranny_spatial::Pose;

use crate::Segment;
use crate::put_down::PutDown;
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
    /// Where the object is put down, if it is.
    put_down: Option<PutDown>,
    observer: &'a mut dyn Observer,
    /// The way on from the grasp that was taken: off what the object rests on, and to where it is to go, each piece with the
    /// problem that it solves where it can be shortened.
    onward: Option<Vec<Piece>>,
    /// With the gripper where the others failed, and why.
    failures: Vec<(Pose, FailureReason)>,
}

/// A piece of a path, and the problem that it solves where it can be shortened.
pub(crate) type Piece = (Segment, Option<Problem>);

impl<'a> Task<'a> {
    pub fn new(
        problem: &Problem,
        carry: &Carry,
        (seed, time): (u64, Duration),
        observer: &'a mut dyn Observer,
    ) -> Result<Self, PlanError> {
        let carrier = Carrier::new(problem, carry.lift_off)?;
        let ways_out = WaysOut::new(problem, &carrier, &carry.end, (seed, time))?;
        let put_down = match &carry.end {
            CarryEnd::Place(place) => Some(PutDown::new(problem, &carrier, place, seed)?),
            _ => None,
        };
        let (end, onward, failures) = (carry.end.clone(), None, Vec::new());
        Ok(Self { carrier, end, ways_out, put_down, observer, onward, failures })
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

    /// The way on from the grasp that was taken, its free pieces shortened from this seed; nothing if no grasp was.
    pub fn into_onward(self, shortened: bool) -> Result<Vec<Segment>, PlanError> {
        let settings = ShortcutSettings { seed: self.ways_out.seed, ..ShortcutSettings::default() };
        let pieces = self.onward.into_iter().flatten().map(|(segment, problem)| match problem {
            Some(problem) if shortened => {
                let waypoints = shortcut(&problem, &segment.waypoints, settings)?.path;
                Ok(Segment { waypoints, ..segment })
            }
            _ => Ok(segment),
        });
        pieces.collect()
    }

    /// The way on from a grasp, proven.
    fn find_onward(&mut self, reach: &[Vec<f64>]) -> Result<Vec<Piece>, FailureReason> {
        let grasp = reach.last().ok_or(FailureReason::NotTried)?;
        let grip = self.carrier.close(grasp)?;
        let lift_off = self.carrier.lift_off(&grip, grasp)?;
        let off = lift_off[lift_off.len() - 1].clone();
        let lift_off = (self.held(&grip, Mode::LiftOff, lift_off), None);
        let Some(put_down) = &mut self.put_down else {
            let (carry, problem) = self.ways_out.find(&grip, &off, reach, self.observer)?;
            return Ok(vec![lift_off, (self.held(&grip, Mode::Carry, carry), Some(problem))]);
        };
        let way = put_down.find(&mut self.ways_out, &grip, &off, reach, self.observer)?;
        let mut pieces = vec![
            lift_off,
            (self.held(&grip, Mode::Carry, way.carry.0), Some(way.carry.1)),
            (self.held(&grip, Mode::SetDown, way.set_down), None),
            (Segment::empty(Mode::Retreat, way.retreat), None),
        ];
        pieces.extend(way.back.map(|(path, problem)| (Segment::empty(Mode::Return, path), Some(problem))));
        Ok(pieces)
    }

    /// A piece of the path with the object in the hand.
    fn held(&self, grip: &Grip, mode: Mode, waypoints: Vec<Vec<f64>>) -> Segment {
        Segment {
            attached: Some(self.carrier.object().to_owned()),
            opening_m: Some(grip.opening_m),
            uneven_m: Some(grip.uneven_m),
            ..Segment::empty(mode, waypoints)
        }
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
        if let Some(reason) = self.put_down.as_ref().and_then(|put_down| put_down.blocked_at(world_from_tip))
        {
            self.failures.push((*world_from_tip, reason));
            return false;
        }
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
