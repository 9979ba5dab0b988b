use std::fmt;
use std::sync::Arc;

use cranny_spatial::Pose;

use crate::FailureReason;

/// A task's verdict on grasps before any IK: a pure function.
#[derive(Clone)]
pub struct GraspFilter(Arc<FaultOf>);

type FaultOf = dyn Fn(&Pose) -> Option<FailureReason> + Send + Sync;

impl GraspFilter {
    /// Creates a filter from `fault_of`, the reason for refusing a grasp with the tip at a pose in the planning frame.
    pub fn new(fault_of: impl Fn(&Pose) -> Option<FailureReason> + Send + Sync + 'static) -> Self {
        Self(Arc::new(fault_of))
    }

    /// Returns the reason for refusing a grasp with the tip at a pose in the planning frame; `None` if it passes.
    pub fn fault_of(&self, world_from_tip: &Pose) -> Option<FailureReason> {
        self.0(world_from_tip)
    }
}

impl fmt::Debug for GraspFilter {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("GraspFilter")
    }
}
