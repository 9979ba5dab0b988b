use std::sync::atomic::{AtomicBool, AtomicI32, AtomicU32, Ordering};
use std::sync::{Arc, OnceLock};

use cranny_grasp::GraspSet;
use cranny_spatial::Pose;
use cranny_task::{FailureReason, Firmness, GraspFailure, GraspFilter, Problem, gripper_poses};

/// Number of grasps after whose refusal, one and all, a later object is given up: another placement before it may allow some.
const MOST_REFUSED: u32 = 24;

/// Verdicts on the grasps of a pick, counted.
#[derive(Default)]
pub(crate) struct Refusals {
    refused: AtomicU32,
    is_any_left: AtomicBool,
    /// The firmness that is demanded, if any is.
    firm: OnceLock<Demanded>,
    /// Number of grasps of the planner's own that were refused as unsteady.
    unsteady: AtomicI32,
    /// True if no grasp of the set is firm, once that was asked.
    is_each_weak: OnceLock<bool>,
}

/// The firmness that is demanded of a grasp.
#[derive(Clone)]
pub(crate) struct Demanded {
    pub firmness: Arc<Firmness>,
    /// Factor by which gravity may grow, at least.
    pub factor: f64,
    /// True if the object is put down again.
    pub is_put_down: bool,
    /// True if the planner makes grasps of its own: of these it takes steady ones first, near the centre of mass, with which
    /// the hand holds its object in any attitude.
    pub is_own: bool,
}

/// The factor in any attitude that is demanded of own grasps at first …
const STEADY: f64 = 1.0;
/// … and of that, the share that is left after each refusal: where none is to be had, others do soon.
const LEFT_PER_REFUSAL: f64 = 0.98;

impl Refusals {
    /// A filter, whose verdicts are counted, of grasps that are left out, too weak, or of no use for what follows; each by
    /// the pose of the tip in the planning frame (`world_from_tip`).
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

    /// Refuses an own grasp that is not steady, of many each time fewer.
    fn unsteady(&self, own: &Demanded, world_from_tip: &Pose) -> Option<FailureReason> {
        let least = STEADY * LEFT_PER_REFUSAL.powi(self.unsteady.load(Ordering::Relaxed));
        let is_steady =
            own.firmness.grip(world_from_tip).is_some_and(|grip| grip.factor_in_any_attitude() >= least);
        (!is_steady).then(|| {
            self.unsteady.fetch_add(1, Ordering::Relaxed);
            FailureReason::Unsteady
        })
    }

    /// True if the set of grasps of a problem has none that is firm: no search finds what follows.
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

    /// True if many were refused, and none was not.
    pub fn are_all(&self) -> bool {
        self.refused.load(Ordering::Relaxed) >= MOST_REFUSED && !self.is_any_left.load(Ordering::Relaxed)
    }
}

/// Replaces what is known of grasps of a set by the reasons why nothing led on from the poses of the gripper at which they
/// were reached.
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
