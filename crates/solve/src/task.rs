use std::sync::Arc;
use std::time::{Duration, Instant};

use cranny_plan::{
    Budget, Carrier, CarryEnd, FailureReason, GraspFailure, GraspFilter, Grip, LiftOffSettings, Observer,
    Outcome, PlanError, PlanReport, Planner, Problem, ShortcutSettings, begin_search, shortcut,
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

/// A piece of a path, and the problem that it solves where it can be shortened.
pub(crate) type Piece = (Segment, Option<Problem>);

/// The task of grasping an object and carrying it on: a search for ways to grasps, and from each grasp that it reaches one
/// for the way on. A grasp from which there is none is left out.
pub(crate) struct Task {
    pub carrier: Carrier,
    end: CarryEnd,
    ways_out: WaysOut,
    /// Where the object is put down, if it is.
    put_down: Option<Arc<PutDown>>,
    /// The tip where a way on failed, and why.
    failures: Vec<(Pose, FailureReason)>,
}

impl Task {
    pub fn new(problem: &Problem, carry: &Carry, (seed, time): (u64, Duration)) -> Result<Self, PlanError> {
        let carrier = Carrier::new(problem, carry.lift_off)?;
        let ways_out = WaysOut::new(problem, &carrier, &carry.end, (seed, time))?;
        let put_down = match &carry.end {
            CarryEnd::Place(place) => Some(Arc::new(PutDown::new(problem, &carrier, place, seed)?)),
            _ => None,
        };
        Ok(Self { carrier, end: carry.end.clone(), ways_out, put_down, failures: Vec::new() })
    }

    /// Searches with a planner: the report of the way to a grasp, and the way on from there, if there are any.
    pub fn search(
        &mut self,
        planner: &dyn Planner,
        problem: &Problem,
        (budget, seed): (&Budget, u64),
        observer: &mut dyn Observer,
    ) -> Result<(PlanReport, Vec<Piece>), PlanError> {
        let begin = Instant::now();
        let filtered = problem.clone().with_grasp_filter(self.grasp_filter());
        let mut search = begin_search(planner, &filtered, budget, seed)?;
        loop {
            let mut report = search.next(observer)?;
            if report.outcome != Outcome::Solved {
                self.tell_failures(problem, &mut report.failures);
                return Ok((report, Vec::new()));
            }
            match self.find_onward(&report.path, observer) {
                Ok(onward) => {
                    report.statistics.planning_time_s = begin.elapsed().as_secs_f64();
                    return Ok((report, onward));
                }
                Err(reason) => {
                    let grasp = report.path.last();
                    self.failures.extend(grasp.map(|grasp| (self.carrier.gripper(grasp), reason)));
                    search.reject();
                }
            }
        }
    }

    /// The filter of grasps with which the object cannot be where it is to go.
    fn grasp_filter(&self) -> GraspFilter {
        let (carrier, put_down, ends) =
            (self.carrier.clone(), self.put_down.clone(), self.carrier.ends(&self.end));
        GraspFilter::new(move |world_from_tip| {
            put_down.as_ref().and_then(|put_down| put_down.blocked_at(world_from_tip)).or_else(|| {
                let [first, second] = carrier.blocked_at(world_from_tip, ends.as_deref()?)?;
                Some(FailureReason::EndBlocked { first, second })
            })
        })
    }

    /// Where the object is to go, home as the configuration that this is.
    pub fn end(&self) -> CarryEnd {
        self.carrier.ends(&self.end).map_or_else(|| self.end.clone(), CarryEnd::Configurations)
    }

    /// Gives each grasp from which there is no way on the reason.
    fn tell_failures(&self, problem: &Problem, failures: &mut Vec<GraspFailure>) {
        let Some(grasps) = problem.grasps() else { return };
        for (gripper, reason) in &self.failures {
            let Some((grasp, _)) = grasps.nearest(gripper) else { continue };
            match failures.iter_mut().find(|failure| failure.grasp == grasp) {
                Some(failure) => failure.reason = reason.clone(),
                None => failures.push(GraspFailure { grasp, reason: reason.clone(), attempts: 0 }),
            }
        }
    }

    /// The segments of a way on, its free ones shortened.
    pub fn shortened(&self, onward: Vec<Piece>) -> Result<Vec<Segment>, PlanError> {
        let settings = ShortcutSettings { seed: self.ways_out.seed, ..ShortcutSettings::default() };
        let pieces = onward.into_iter().map(|(segment, problem)| match problem {
            Some(problem) => {
                let waypoints = shortcut(&problem, &segment.waypoints, settings)?.path;
                Ok(Segment { waypoints, ..segment })
            }
            None => Ok(segment),
        });
        pieces.collect()
    }

    /// The way on from a grasp, proven.
    fn find_onward(
        &mut self,
        reach: &[Vec<f64>],
        observer: &mut dyn Observer,
    ) -> Result<Vec<Piece>, FailureReason> {
        let grasp = reach.last().ok_or(FailureReason::NotTried)?;
        let grip = self.carrier.close(grasp)?;
        let lift_off = self.carrier.lift_off(&grip, grasp)?;
        let off = lift_off[lift_off.len() - 1].clone();
        let lift_off = (self.held(&grip, Mode::LiftOff, lift_off), None);
        let Some(put_down) = &self.put_down else {
            let (carry, problem) = self.ways_out.find(&grip, &off, reach, observer)?;
            return Ok(vec![lift_off, (self.held(&grip, Mode::Carry, carry), Some(problem))]);
        };
        let way = put_down.find(&mut self.ways_out, &grip, &off, reach, observer)?;
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
