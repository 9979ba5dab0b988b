use std::sync::atomic::{AtomicBool, AtomicI32, AtomicU32, Ordering};
use std::sync::{Arc, OnceLock};

use cranny_grasp::GraspSet;
use cranny_spatial::Pose;
use cranny_task::{FailureReason, Firmness, GraspFailure, GraspFilter, Problem, gripper_poses};

/// Number of refused grasps, without an accepted one, after which a later object is given up for another placement.
const MOST_REFUSED: u32 = 24;

/// Counts of the verdicts on the grasps of a pick.
#[derive(Default)]
pub(crate) struct Refusals {
    refused: AtomicU32,
    is_any_left: AtomicBool,
    /// Required firmness, if any.
    firm: OnceLock<Demanded>,
    /// Number of grasps of the planner's own that were refused as unsteady.
    unsteady: AtomicI32,
    /// True if no grasp of the set is firm; computed on first use.
    is_each_weak: OnceLock<bool>,
}

/// Required firmness of a grasp.
#[derive(Clone)]
pub(crate) struct Demanded {
    pub firmness: Arc<Firmness>,
    /// Least factor by which gravity may grow.
    pub factor: f64,
    /// True if the object is put down again.
    pub is_put_down: bool,
    /// True if the planner generates its own grasps. It then starts with steady ones, near the centre of mass, with which the
    /// hand holds the object in any orientation.
    pub is_own: bool,
}

/// Initial factor in any orientation that is required of own grasps …
const STEADY: f64 = 1.0;
/// … and the share of it that remains after each refusal: if no steady grasp exists, others soon pass.
const LEFT_PER_REFUSAL: f64 = 0.98;

impl Refusals {
    /// Creates a filter that counts its verdicts. It refuses grasps that are excluded, too weak, or useless for the next
    /// stages, by the pose of the tip in the planning frame (`world_from_tip`).
    pub fn filter(
        self: &Arc<Self>,
        left_out: Option<impl Fn(&Pose) -> bool + Send + Sync + 'static>,
        firm: Option<Demanded>,
        blocked: impl Fn(&Pose) -> Option<FailureReason> + Send + Sync + 'static,
    ) -> GraspFilter {
        let counts = self.clone();
        if let Some(firm) = &firm {
            self.firm.get_or_init(|| firm.clone());
        }
        GraspFilter::new(move |world_from_tip| {
            let is_left_out = left_out.as_ref().is_some_and(|is_left_out| is_left_out(world_from_tip));
            let weak = || {
                let Demanded { firmness, factor, is_put_down, .. } = firm.as_ref()?;
                firmness.fault_of(world_from_tip, *factor, *is_put_down)
            };
            let fault = is_left_out.then_some(FailureReason::LeftOut).or_else(weak);
            let fault = counts.counted(fault.or_else(|| blocked(world_from_tip)));
            let own = firm.as_ref().filter(|firm| firm.is_own && fault.is_none());
            fault.or_else(|| counts.unsteady(own?, world_from_tip))
        })
    }

    /// Refuses an own grasp that is not steady; the criterion relaxes with each refusal.
    fn unsteady(&self, own: &Demanded, world_from_tip: &Pose) -> Option<FailureReason> {
        let least = STEADY * LEFT_PER_REFUSAL.powi(self.unsteady.load(Ordering::Relaxed));
        let is_steady =
            own.firmness.grip(world_from_tip).is_some_and(|grip| grip.factor_in_any_attitude() >= least);
        (!is_steady).then(|| {
            self.unsteady.fetch_add(1, Ordering::Relaxed);
            FailureReason::Unsteady
        })
    }

    /// Returns true if no grasp in the set of a problem is firm: then no search finds a continuation.
    pub fn is_each_weak(&self, picking: &Problem) -> bool {
        *self.is_each_weak.get_or_init(|| {
            let set = picking.grasps().filter(|_| picking.grasp_measure().is_none());
            let (Some(Demanded { firmness, factor, is_put_down, .. }), Some(set)) = (self.firm.get(), set)
            else {
                return false;
            };
            let is_weak = |pose: &Pose| firmness.fault_of(pose, *factor, *is_put_down).is_some();
            set.grasps().iter().all(|grasp| gripper_poses(grasp).iter().all(is_weak))
        })
    }

    fn counted(&self, fault: Option<FailureReason>) -> Option<FailureReason> {
        match &fault {
            Some(_) => _ = self.refused.fetch_add(1, Ordering::Relaxed),
            None => self.is_any_left.store(true, Ordering::Relaxed),
        }
        fault
    }

    /// Returns true if many grasps were refused, and none was accepted.
    pub fn are_all(&self) -> bool {
        self.refused.load(Ordering::Relaxed) >= MOST_REFUSED && !self.is_any_left.load(Ordering::Relaxed)
    }
}

/// Replaces the reasons for grasps of a set by those why nothing followed from the poses of the gripper at which they were
/// reached.
pub(crate) fn add_failed(
    failures: &mut Vec<GraspFailure>,
    grasps: &GraspSet,
    failed: &[(Pose, FailureReason)],
) {
    for (gripper, reason) in failed {
        let Some((grasp, _)) = grasps.nearest(gripper) else { continue };
        match failures.iter_mut().find(|failure| failure.grasp == grasp) {
            Some(failure) => failure.reason = reason.clone(),
            None => failures.push(GraspFailure { grasp, reason: reason.clone(), attempts: 0 }),
        }
    }
}
