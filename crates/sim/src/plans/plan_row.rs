use serde::Serialize;

use crate::{GraspOutcome, PickRun, PlacedError, PlanContact, PlanOutcome, PlanRun};

/// What came of an executed plan, without what was recorded. The names of the fields are those of files.
#[derive(Clone, Debug, Serialize)]
pub struct PlanRow {
    /// What became of the object.
    pub outcome: PlanOutcome,
    /// True if it was in the hand up to where the plan ends or releases it, and slipped no farther than the limit.
    pub is_kept: bool,
    /// See [`crate::GraspRun`].
    pub is_in_hand: bool,
    /// See [`PlanRun`].
    pub reach_s: f64,
    /// See [`PlanRun`].
    pub contacts: Vec<PlanContact>,
    /// See [`PlanRun`].
    pub pushed_m: f64,
    /// See [`PlanRun`].
    pub lift_m: f64,
    /// See [`PlanRun::rose_m`].
    pub rose_m: f64,
    /// See [`PlanRun`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub released: Option<Released>,
    /// See [`PlanRun`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub placed: Option<PlacedError>,
    /// See [`crate::GraspRun`], as all that follows.
    pub translation_error_m: f64,
    /// How far the object is turned in the hand.
    pub rotation_error_rad: f64,
    /// How long it was where it should be.
    pub held_s: f64,
    /// What a finger pressed with.
    pub contact_force_n: f64,
    /// Where the object ended, in the planning frame.
    pub position_m: [f64; 3],
    /// How it lay there, of unit length.
    pub quaternion_xyzw: [f64; 4],
    /// What was simulated, in seconds.
    pub simulated_s: f64,
}

/// What came of a plan: with one pick its row, with several one for each. The names of the fields are those of files.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub enum ExecutedPlan {
    /// A plan with one pick.
    One {
        /// Id of the scenario.
        scenario: String,
        /// What came of it.
        #[serde(flatten)]
        row: Box<PlanRow>,
    },
    /// A plan with several.
    Several {
        /// Id of the scenario.
        scenario: String,
        /// True if all objects are where the plan has them.
        as_planned: bool,
        /// Number of times that the rest was planned anew, if that was allowed.
        #[serde(skip_serializing_if = "Option::is_none")]
        new_plans: Option<usize>,
        /// Up to the first pick whose object is not let go where another follows.
        steps: Vec<ExecutedPick>,
    },
}

/// What came of a pick of a plan with several.
#[derive(Clone, Debug, Serialize)]
pub struct ExecutedPick {
    /// Name of the object.
    pub object: String,
    /// What came of it.
    #[serde(flatten)]
    pub row: PlanRow,
}

impl ExecutedPlan {
    /// What came of the runs of a plan with so many picks; `None` if it has one, of nothing.
    pub fn of(scenario: &str, count: usize, runs: &[PickRun]) -> Option<Self> {
        let scenario = scenario.to_owned();
        if let [pick] = runs
            && count == 1
        {
            return Some(Self::One { scenario, row: Box::new(PlanRow::of(&pick.run)) });
        }
        let pick = |pick: &PickRun| ExecutedPick { object: pick.object.clone(), row: PlanRow::of(&pick.run) };
        let steps: Vec<ExecutedPick> = runs.iter().map(pick).collect();
        let as_planned = steps.len() == count && steps.iter().all(|pick| pick.row.is_as_planned());
        (count > 1).then_some(Self::Several { scenario, as_planned, new_plans: None, steps })
    }

    /// True if all objects are where the plan has them.
    pub fn is_as_planned(&self) -> bool {
        match self {
            Self::One { row, .. } => row.is_as_planned(),
            Self::Several { as_planned, .. } => *as_planned,
        }
    }
}

/// Pose of the object in the planning frame when the hand let it go.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Released {
    /// Its origin, in metres.
    pub position_m: [f64; 3],
    /// Its orientation, of unit length.
    pub quaternion_xyzw: [f64; 4],
    /// Its error against the pose at which it was to be put down.
    #[serde(flatten)]
    pub off: PlacedError,
}

impl PlanRow {
    /// True if the object is held to the end, or stands where it was to be put down.
    pub fn is_as_planned(&self) -> bool {
        matches!(self.outcome, PlanOutcome::Placed | PlanOutcome::Grasped(GraspOutcome::Held))
    }

    /// That of a run.
    pub fn of(run: &PlanRun) -> Self {
        let (grasp, ended) = (&run.grasp, &run.grasp.world_from_object);
        Self {
            outcome: run.outcome(),
            is_kept: grasp.outcome == GraspOutcome::Held,
            is_in_hand: grasp.is_in_hand,
            reach_s: run.reach_s,
            contacts: run.contacts.clone(),
            pushed_m: run.pushed_m,
            lift_m: run.lift_m,
            rose_m: run.rose_m(),
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
