use std::fmt;
use std::sync::Arc;

use cranny_spatial::Pose;

use crate::FailureReason;

/// A task's verdict on grasps, before a configuration is looked for at any: a pure function.
#[derive(Clone)]
pub struct GraspFilter(Arc<FaultOf>);

type FaultOf = dyn Fn(&Pose) -> Option<FailureReason> + Send + Sync;

impl GraspFilter {
    /// The filter that refuses a grasp, the tip at a pose in the planning frame, for the reason that a function gives.
    pub fn new(fault_of: impl Fn(&Pose) -> Option<FailureReason> + Send + Sync + 'static) -> Self {
        Self(Arc::new(fault_of))
    }

    /// Reason for which a grasp is refused with the tip at a pose in the planning frame, if it is.
    pub fn fault_of(&self, world_from_tip: &Pose) -> Option<FailureReason> {
        self.0(world_from_tip)
    }
}

impl fmt::Debug for GraspFilter {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("GraspFilter")
    }
}
