use serde::Serialize;

use crate::{PlacedError, PlanContact, PlanOutcome, PlanRun, TrackingError};

/// What came of an executed plan, without what was recorded. The names of the fields are those of files.
#[derive(Clone, Debug, Serialize)]
pub struct PlanRow {
    /// What became of the object.
    pub outcome: PlanOutcome,
    /// See [`crate::GraspRun`].
    pub is_in_hand: bool,
    /// See [`PlanRun`].
    pub reach_s: f64,
    /// Worst on the way to the grasp.
    pub tracking_on_the_way: TrackingError,
    /// At its end.
    pub tracking_at_the_end: TrackingError,
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
    /// That of a run.
    pub fn of(run: &PlanRun) -> Self {
        let (grasp, ended) = (&run.grasp, &run.grasp.world_from_object);
        Self {
            outcome: run.outcome(),
            is_in_hand: grasp.is_in_hand,
            reach_s: run.reach_s,
            tracking_on_the_way: run.on_the_way,
            tracking_at_the_end: run.at_the_end,
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
