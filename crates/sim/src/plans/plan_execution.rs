use cranny_collision::Body;
use cranny_grasp::Hand;
use cranny_plan::PlanError;
use cranny_record::PlanFile;
use cranny_scenario::{Scenario, TargetPhysics};
use cranny_solve::TaskTrajectory;
use cranny_spatial::Pose;
use cranny_task::{Problem, Segment, picks_apart};

use crate::{Disturbance, GraspTest, PlanExperiment, PlanRun, PlanTest, SimError};

/// A plan in physics: each pick, with what follows it, where the one before has left things.
#[derive(Clone, Debug)]
pub struct PlanExecution<'a> {
    /// The world in which the plan begins.
    pub scenario: &'a Scenario,
    /// The hand.
    pub hand: Hand,
    /// Mass and friction of every object that is picked, before those that the scenario gives.
    pub instead: TargetPhysics,
    /// Distance by which an object is lifted straight up where the plan ends at its grasp, in metres.
    pub lift_m: f64,
    /// Errors of the hand, of mass, friction and closing force, the same in each pick.
    pub disturbance: Disturbance,
    /// Records what moves.
    pub is_recorded: bool,
}

/// A pick that was executed.
#[derive(Clone, Debug)]
pub struct PickRun {
    /// Name of the object.
    pub object: String,
    /// Its body in the scenario, by index.
    pub body: usize,
    /// Pose of its frame before the pick.
    pub world_from_object: Pose,
    /// Bodies that stood around.
    pub surroundings: Vec<Body>,
    /// Outcome.
    pub run: PlanRun,
}

/// The path of a pick, and of what follows up to the next.
#[derive(Clone, Debug)]
pub struct PickPath {
    /// Name of the object; `None`: the target.
    pub object: Option<String>,
    /// The path in time.
    pub timed: TaskTrajectory,
    /// Its last configuration (m, rad).
    pub end: Vec<f64>,
}

impl PickPath {
    /// The paths of all picks of a plan in its problem.
    ///
    /// # Errors
    /// [`SimError::NoTimes`] for a robot without the limits for a trajectory, and those of [`PlanFile::states`].
    pub fn all_of(plan: &PlanFile, problem: &Problem) -> Result<Vec<Self>, SimError> {
        let along = plan.states(problem).map_err(PlanError::from)?;
        let picks = along.map_or_else(Vec::new, |along| along.picks);
        let object = |picking: &Problem| {
            let (cell, target) = picking.cell().zip(picking.target())?;
            Some(cell.world().bodies()[target].name.clone())
        };
        let of_pick = |(index, segments): (usize, &[Segment])| {
            let timed = TaskTrajectory::of(plan.timing_asked(), problem.robot(), segments)?;
            let timed = timed.ok_or(SimError::NoTimes)?;
            let end = segments.last().and_then(|last| last.waypoints.last()).cloned().unwrap_or_default();
            Ok(Self { object: picks.get(index).and_then(object), timed, end })
        };
        picks_apart(&plan.stages(problem), &plan.segments).into_iter().enumerate().map(of_pick).collect()
    }
}

impl PlanExecution<'_> {
    /// The scenario in which a pick has its object as target.
    fn at_pick(now: &Scenario, pick: &PickPath) -> Result<Scenario, SimError> {
        Ok(match &pick.object {
            Some(object) => now.with_target(object)?,
            None => now.clone(),
        })
    }

    /// The first object without a mass, if there is one, before anything takes its time.
    ///
    /// # Errors
    /// [`ScenarioError`](cranny_scenario::ScenarioError) for an object that the scenario does not have.
    pub fn massless<'p>(&self, picks: &'p [PickPath]) -> Result<Option<&'p PickPath>, SimError> {
        for pick in picks {
            let physics = self.instead.or(Self::at_pick(self.scenario, pick)?.target_physics());
            if physics.mass_kg.is_none() {
                return Ok(Some(pick));
            }
        }
        Ok(None)
    }

    /// A plan with one pick as a document for another engine; `None` for one with several, each of which begins where the
    /// one before has left things.
    ///
    /// # Errors
    /// Those of [`GraspTest::of_scenario`] and [`PlanExperiment::new`].
    pub fn experiment(&self, picks: &[PickPath]) -> Result<Option<PlanExperiment>, SimError> {
        let [pick] = picks else { return Ok(None) };
        let of_pick = Self::at_pick(self.scenario, pick)?;
        let test = GraspTest::of_scenario(&of_pick, &self.hand, &self.instead, false)?;
        PlanExperiment::new(&test, &of_pick.robot, &pick.timed, self.lift_m).map(Some)
    }

    /// Executes picks up to the first whose object is not let go; `done` is called after each.
    ///
    /// # Errors
    /// Those of [`GraspTest::of_scenario`] and [`PlanTest::run`].
    pub fn run(&self, picks: &[PickPath], mut done: impl FnMut()) -> Result<Vec<PickRun>, SimError> {
        let (mut now, mut runs) = (self.scenario.clone(), Vec::new());
        for pick in picks {
            let of_pick = Self::at_pick(&now, pick)?;
            let test = GraspTest::of_scenario(&of_pick, &self.hand, &self.instead, false)?;
            let surroundings = test.surroundings().to_vec();
            let test = PlanTest::new(test, now.robot.clone())?;
            let run = test.run(&pick.timed, self.lift_m, &self.disturbance, self.is_recorded)?;
            done();
            let (Some(body), Some(stood)) = (of_pick.target, of_pick.target_object(&self.instead)?) else {
                break;
            };
            let (object, world_from_object) =
                (of_pick.world.bodies()[body].name.clone(), stood.world_from_object);
            let motion = run.grasp.world_from_object * world_from_object.inverse();
            let is_let_go = run.released.is_some();
            runs.push(PickRun { object, body, world_from_object, surroundings, run });
            if !is_let_go {
                break;
            }
            now = now.with_moved(body, &motion, &pick.end)?;
        }
        Ok(runs)
    }
}
