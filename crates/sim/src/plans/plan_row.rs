use serde::Serialize;

use crate::{GraspOutcome, PickRun, PlacedError, PlanContact, PlanOutcome, Rest};

#[cfg(doc)]
use crate::PlanRun;

/// Result of an executed plan, without the recording. The field names are those of files.
#[derive(Clone, Debug, Serialize)]
pub struct PlanRow {
    /// Outcome for the object.
    pub outcome: PlanOutcome,
    /// True if the object stayed in the hand within the slip limits up to the end of the plan or the release.
    pub is_kept: bool,
    /// See [`crate::GraspRun`].
    pub is_in_hand: bool,
    /// Displacement of the object from its pose in the scenario to where it came to rest before the plan, in metres, if it is more
    /// than [`Rest::MOST_M`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub settled_m: Option<f64>,
    /// See [`PlanRun`].
    pub reach_s: f64,
    /// See [`PlanRun`].
    pub contacts: Vec<PlanContact>,
    /// See [`PlanRun`].
    pub pushed_m: f64,
    /// See [`PlanRun`].
    pub lift_m: f64,
    /// See [`PlanRun`].
    pub rose_m: f64,
    /// See [`PlanRun`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub released: Option<Released>,
    /// See [`PlanRun`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub placed: Option<PlacedError>,
    /// See [`crate::GraspRun`], also for the following fields.
    pub translation_error_m: f64,
    /// Rotation of the object in the hand, in radians.
    pub rotation_error_rad: f64,
    /// Time for which the object stayed in the hand within the slip limits, in seconds.
    pub held_s: f64,
    /// Mean force of a finger, in newtons.
    pub contact_force_n: f64,
    /// Final position of the object, in metres in the planning frame.
    pub position_m: [f64; 3],
    /// Final orientation of the object, a unit quaternion.
    pub quaternion_xyzw: [f64; 4],
    /// Simulated time, in seconds.
    pub simulated_s: f64,
}

/// Result of a plan: its row for one pick, one row per pick for several. The field names are those of files.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub enum ExecutedPlan {
    /// Plan with one pick.
    One {
        /// Id of the scenario.
        scenario: String,
        /// Result of the pick.
        #[serde(flatten)]
        row: Box<PlanRow>,
    },
    /// Plan with several picks.
    Several {
        /// Id of the scenario.
        scenario: String,
        /// True if all objects are at their planned poses.
        as_planned: bool,
        /// Number of times the remaining task was replanned, if replanning was enabled.
        #[serde(skip_serializing_if = "Option::is_none")]
        new_plans: Option<usize>,
        /// Reason why the remaining picks were not executed, if there are any.
        #[serde(skip_serializing_if = "Option::is_none")]
        stopped: Option<StopReason>,
        /// Results of the executed picks.
        steps: Vec<ExecutedPick>,
    },
}

/// Reason why the remaining picks of a plan were not executed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum StopReason {
    /// An object was not released.
    NotReleased,
    /// No plan was found from where the objects are.
    NoPlan,
    /// A pick failed as often as it may be repeated.
    TooManyRepeats,
}

/// Result of one pick of a plan with several.
#[derive(Clone, Debug, Serialize)]
pub struct ExecutedPick {
    /// Name of the object.
    pub object: String,
    /// Result of the pick.
    #[serde(flatten)]
    pub row: PlanRow,
}

impl ExecutedPlan {
    /// Collects the result of the runs of a plan with `count` picks; `None` for at most one pick without a run.
    pub fn of(scenario: &str, count: usize, runs: &[PickRun]) -> Option<Self> {
        let scenario = scenario.to_owned();
        if let [pick] = runs
            && count == 1
        {
            return Some(Self::One { scenario, row: Box::new(PlanRow::of(pick)) });
        }
        let pick = |pick: &PickRun| ExecutedPick { object: pick.object.clone(), row: PlanRow::of(pick) };
        let steps: Vec<ExecutedPick> = runs.iter().map(pick).collect();
        let as_planned = steps.len() == count && steps.iter().all(|pick| pick.row.is_as_planned());
        let stopped = (runs.len() < count).then_some(StopReason::NotReleased);
        (count > 1).then_some(Self::Several { scenario, as_planned, new_plans: None, stopped, steps })
    }

    /// Returns true if all objects are at their planned poses.
    pub fn is_as_planned(&self) -> bool {
        match self {
            Self::One { row, .. } => row.is_as_planned(),
            Self::Several { as_planned, .. } => *as_planned,
        }
    }
}

/// Pose of the object in the planning frame at the release.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Released {
    /// Origin of the object, in metres.
    pub position_m: [f64; 3],
    /// Orientation of the object, a unit quaternion.
    pub quaternion_xyzw: [f64; 4],
    /// Error relative to the planned set-down pose.
    #[serde(flatten)]
    pub off: PlacedError,
}

impl PlanRow {
    /// Returns true if the object is held to the end, or stands at its planned set-down pose.
    pub fn is_as_planned(&self) -> bool {
        matches!(self.outcome, PlanOutcome::Placed | PlanOutcome::Grasped(GraspOutcome::Held))
    }

    /// Extracts the row of a pick.
    pub fn of(pick: &PickRun) -> Self {
        let run = &pick.run;
        let (grasp, ended) = (&run.grasp, &run.grasp.world_from_object);
        let sank = run.world_from_resting.translation.vector - pick.world_from_object.translation.vector;
        let settled_m = Some(sank.norm()).filter(|settled_m| *settled_m > Rest::MOST_M);
        Self {
            settled_m,
            outcome: run.outcome(),
            is_kept: grasp.outcome == GraspOutcome::Held,
            is_in_hand: grasp.is_in_hand,
            reach_s: run.reach_s,
            contacts: run.contacts.clone(),
            pushed_m: run.pushed_m,
            lift_m: run.lift_m,
            rose_m: run.rose_m,
            released: run.released.zip(grasp.world_from_released).map(|(off, at)| Released {
                position_m: at.translation.vector.into(),
                quaternion_xyzw: at.rotation.coords.into(),
                off,
            }),
            placed: run.placed,
            translation_error_m: grasp.translation_error_m,
            rotation_error_rad: grasp.rotation_error_rad,
            held_s: grasp.held_s,
            contact_force_n: grasp.contact_force_n,
            position_m: ended.translation.vector.into(),
            quaternion_xyzw: ended.rotation.coords.into(),
            simulated_s: grasp.simulated_s,
        }
    }
}
