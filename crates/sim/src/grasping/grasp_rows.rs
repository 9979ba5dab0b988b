use cranny_collision::Body;
use cranny_grasp::{Grasp, Hand, Load, RobustScore, ShakeTest};
use cranny_scenario::{ObjectType, Scenario, TargetObject, TargetPhysics};
use cranny_shape::Solid;
use cranny_spatial::Pose;
use serde::{Deserialize, Serialize};

use crate::{Disturbance, GraspOutcome, GraspRun, GraspTest, Physics, SimError, Uncertainty};

/// Result of one grasp of a set. The field names are those of files and tables.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GraspRow {
    /// Index of the grasp, from 0.
    pub grasp: usize,
    /// See [`GraspRun`].
    pub outcome: GraspOutcome,
    /// See [`GraspRun`].
    pub translation_error_m: f64,
    /// See [`GraspRun`].
    pub rotation_error_rad: f64,
    /// See [`GraspRun`].
    pub held_s: f64,
    /// See [`GraspRun`].
    pub contact_force_n: f64,
    /// Geometric score, if the grasp has one.
    pub score: Option<f64>,
    /// Computed load, for a hand with two flat pads.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub load: Option<Load>,
    /// Robust score under small disturbances, if computed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robust: Option<RobustScore>,
}

impl GraspTest {
    /// Creates a test of the target of a scenario, with all surrounding bodies or only its supports. Mass and friction are
    /// those of [`Scenario::target_object`].
    ///
    /// # Errors
    /// [`SimError::NoTarget`], [`SimError::Scenario`] for a target of unknown mass, and those of [`Self::new`].
    pub fn of_scenario(
        scenario: &Scenario,
        hand: &Hand,
        instead: &TargetPhysics,
        support_only: bool,
    ) -> Result<Self, SimError> {
        let (Some(target), Some(found)) = (scenario.target, scenario.target_object(instead)?) else {
            return Err(SimError::NoTarget { id: scenario.id.clone() });
        };
        let TargetObject { object, world_from_object } = found;
        let bodies = scenario.world.bodies();
        let around: Vec<Body> = if support_only {
            scenario.world.supports_of(target).into_iter().map(|body| bodies[body].clone()).collect()
        } else {
            let others = bodies.iter().enumerate().filter(|(body, _)| *body != target);
            others.map(|(_, body)| body.clone()).collect()
        };
        let rolling_m = instead.or(scenario.target_physics()).rolling_m.unwrap_or_default();
        let physics = Physics { rolling_m, up: scenario.world.up(), ..Physics::default() };
        Self::new(hand, &object, world_from_object, &around, physics, ShakeTest::default())
    }

    /// Creates a test of an object in one of its stable poses on level ground at z = 0, or floating in its own frame.
    ///
    /// # Errors
    /// [`SimError::NoPose`], and those of [`Self::new`].
    pub fn of_object(object: &ObjectType, hand: &Hand, pose: Option<usize>) -> Result<Self, SimError> {
        let (world_from_object, around) = match pose {
            None => (Pose::identity(), Vec::new()),
            Some(index) => {
                let stable = object.stable_poses.get(index).ok_or_else(|| SimError::NoPose {
                    object: object.name.clone(),
                    index,
                    count: object.stable_poses.len(),
                })?;
                (stable.ground_from_body, vec![Body::new("floor", Pose::identity(), Solid::half_space())])
            }
        };
        Self::new(hand, object, world_from_object, &around, Physics::default(), ShakeTest::default())
    }

    /// Returns the load of a grasp at a pose in the planning frame; `None` for a hand without two flat pads.
    pub fn load_of(&self, world_from_gripper: &Pose) -> Option<Load> {
        let object_from_gripper = self.world_from_object().inverse() * world_from_gripper;
        self.load.as_ref().map(|measure| measure.of(&object_from_gripper))
    }

    /// Runs the `chosen` of these grasps, whose poses are in the planning frame: each undisturbed, and in `trials` further runs
    /// with small disturbances that are the same for all grasps ([`Uncertainty::design`]). `on_done` is called after each of
    /// the (1 + trials) · chosen runs. Once `stop` returns true, no further run begins; incomplete grasps have no row.
    pub fn rows(
        &self,
        grasps: &[Grasp],
        chosen: &[usize],
        (trials, seed): (usize, u64),
        on_done: &(dyn Fn() + Sync),
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Vec<GraspRow> {
        let errors = Uncertainty::default().design(trials, seed);
        let each = || std::iter::once(Disturbance::default()).chain(errors.iter().copied());
        let pose = |grasp: usize| grasps[grasp].world_from_gripper;
        let runs: Vec<(Pose, Disturbance)> =
            chosen.iter().flat_map(|&grasp| each().map(move |error| (pose(grasp), error))).collect();
        let runs = self.run_all(&runs, on_done, stop);
        let row = |(&grasp, runs): (&usize, &[Option<GraspRun>])| {
            let runs = runs.iter().map(Option::as_ref).collect::<Option<Vec<&GraspRun>>>()?;
            let (first, others) = runs.split_first()?;
            let held = others.iter().filter(|run| run.outcome == GraspOutcome::Held).count();
            Some(GraspRow {
                grasp,
                outcome: first.outcome,
                translation_error_m: first.translation_error_m,
                rotation_error_rad: first.rotation_error_rad,
                held_s: first.held_s,
                contact_force_n: first.contact_force_n,
                score: grasps[grasp].score,
                load: self.load_of(&grasps[grasp].world_from_gripper),
                robust: (trials > 0).then_some(RobustScore { trials, held }),
            })
        };
        chosen.iter().zip(runs.chunks(1 + trials)).filter_map(row).collect()
    }
}
