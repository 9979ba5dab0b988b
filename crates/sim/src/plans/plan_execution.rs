use cranny_collision::Body;
use cranny_grasp::Hand;
use cranny_plan::PlanError;
use cranny_record::PlanFile;
use cranny_scenario::{Scenario, TargetPhysics};
use cranny_solve::TaskTrajectory;
use cranny_spatial::Pose;
use cranny_task::{Problem, Segment, picks_apart};

use crate::{Disturbance, GraspTest, PlanExperiment, PlanRun, PlanTest, SimError};

/// Execution of a plan in physics: each pick, with the motions after it, begins where the previous one ended.
#[derive(Clone, Debug)]
pub struct PlanExecution<'a> {
    /// Scenario in which the plan begins.
    pub scenario: &'a Scenario,
    /// Hand of the robot.
    pub hand: Hand,
    /// Mass and friction of every picked object, which override those of the scenario.
    pub instead: TargetPhysics,
    /// Distance of the vertical lift if the plan ends at its grasp, in metres.
    pub lift_m: f64,
    /// Errors of hand, mass, friction and closing force, equal in each pick.
    pub disturbance: Disturbance,
    /// True if the motions are recorded.
    pub is_recorded: bool,
}

/// Executed pick.
#[derive(Clone, Debug)]
pub struct PickRun {
    /// Name of the object.
    pub object: String,
    /// Index of the body in the scenario.
    pub body: usize,
    /// Pose of the object frame before the pick, in the planning frame.
    pub world_from_object: Pose,
    /// Surrounding bodies.
    pub surroundings: Vec<Body>,
    /// Result of the execution.
    pub run: PlanRun,
}

/// Path of a pick, and of the motions up to the next one.
#[derive(Clone, Debug)]
pub struct PickPath {
    /// Name of the object; `None`: the target.
    pub object: Option<String>,
    /// Timed path.
    pub timed: TaskTrajectory,
    /// Last configuration (m, rad).
    pub end: Vec<f64>,
}

impl PickPath {
    /// Collects the paths of all picks of a plan in its problem.
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
    /// Returns the scenario with the object of a pick as target.
    fn at_pick(now: &Scenario, pick: &PickPath) -> Result<Scenario, SimError> {
        Ok(match &pick.object {
            Some(object) => now.with_target(object)?,
            None => now.clone(),
        })
    }

    /// Returns the first object without a mass, if there is one, before any expensive computation.
    ///
    /// # Errors
    /// [`ScenarioError`](cranny_scenario::ScenarioError) for an object that the scenario does not contain.
    pub fn massless<'p>(&self, picks: &'p [PickPath]) -> Result<Option<&'p PickPath>, SimError> {
        for pick in picks {
            let physics = self.instead.or(Self::at_pick(self.scenario, pick)?.target_physics());
            if physics.mass_kg.is_none() {
                return Ok(Some(pick));
            }
        }
        Ok(None)
    }

    /// Exports a plan with one pick for another engine; `None` for several picks, because each begins at the previous result.
    ///
    /// # Errors
    /// Those of [`GraspTest::of_scenario`] and [`PlanExperiment::new`].
    pub fn experiment(&self, picks: &[PickPath]) -> Result<Option<PlanExperiment>, SimError> {
        let [pick] = picks else { return Ok(None) };
        let of_pick = Self::at_pick(self.scenario, pick)?;
        let test = GraspTest::of_scenario(&of_pick, &self.hand, &self.instead, false)?;
        PlanExperiment::new(&test, &of_pick.robot, &pick.timed, self.lift_m).map(Some)
    }

    /// Executes picks up to the first whose object is not released; `done` is called after each.
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
