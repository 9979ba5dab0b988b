use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, OnceLock};

use cranny_spatial::Pose;
use cranny_task::{FailureReason, Firmness, GraspFilter, Problem, gripper_poses};

/// Number of grasps after whose refusal, one and all, a later object is given up: another placement before it may allow some.
const MOST_REFUSED: u32 = 24;

/// Verdicts on the grasps of a pick, counted.
#[derive(Default)]
pub(crate) struct Refusals {
    refused: AtomicU32,
    is_any_left: AtomicBool,
    /// The firmness that is demanded, if any is.
    firm: OnceLock<Demanded>,
    /// True if no grasp of the set is firm, once that was asked.
    is_each_weak: OnceLock<bool>,
}

/// The firmness that is demanded of a grasp: by which factor, and whether its object is put down again.
pub(crate) type Demanded = (Arc<Firmness>, f64, bool);

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
                let (firmness, factor, is_put_down) = firm.as_ref()?;
                firmness.fault_of(world_from_tip, *factor, *is_put_down)
            };
            let fault = is_left_out.then_some(FailureReason::LeftOut).or_else(weak);
            counts.counted(fault.or_else(|| blocked(world_from_tip)))
        })
    }

    /// True if the set of grasps of a problem has none that is firm: no search finds what follows.
    pub fn is_each_weak(&self, picking: &Problem) -> bool {
        *self.is_each_weak.get_or_init(|| {
            let set = picking.grasps().filter(|_| picking.grasp_measure().is_none());
            let (Some((firmness, factor, is_put_down)), Some(set)) = (self.firm.get(), set) else {
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
