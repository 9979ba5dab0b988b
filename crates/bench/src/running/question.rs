use serde::{Deserialize, Serialize};

use crate::{PlannerCall, Trial};

/// Trial with everything needed to run it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Question {
    /// The trial.
    pub trial: Trial,
    /// Source of its scenario: a built-in id or a path.
    pub source: String,
    /// Call of its planner.
    pub call: PlannerCall,
    /// True if the path is also judged under the other criterion.
    pub judge_both: bool,
    /// True if the minimum clearance along the path is measured.
    pub measure_clearance: bool,
}
