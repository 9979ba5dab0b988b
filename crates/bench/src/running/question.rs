use serde::{Deserialize, Serialize};

use crate::{PlannerCall, Trial};

/// A trial with what it takes to run it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Question {
    /// The trial.
    pub trial: Trial,
    /// What its scenario is opened by: a built-in id or a path.
    pub source: String,
    /// How its planner is called.
    pub call: PlannerCall,
    /// Whether the path is judged under the other criterion too.
    pub judge_both: bool,
    /// Whether the least clearance along the path is measured.
    pub measure_clearance: bool,
}
