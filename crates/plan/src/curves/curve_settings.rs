use serde::{Deserialize, Serialize};
use strum::IntoStaticStr;

use crate::{PlanError, Ranges};

/// First curve of a start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, IntoStaticStr)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum FirstCurve {
    /// Straight line to a goal ("cold"); with a random detour once every goal had its turn.
    #[default]
    Straight,
    /// Shortened path of the planner `reach` ("warm").
    Reach,
}

/// Settings of the starts of an optimiser.
// Unknown keys are refused when a planner is created; the planners flatten these settings into their own.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CurveSettings {
    /// Number of way points, ends included, from 5 to 1000. Default 30, as in the code of OMG-Planner.
    pub way_points: usize,
    /// Number of steps of a start. Default 50, as in the code of OMG-Planner.
    pub steps: u64,
    /// Number of steps after the first proven curve of a start; the last proven curve is the path. Default 5.
    pub settle: u64,
    /// Number of goal configurations sought before the first start. Default 30.
    pub goals: usize,
    /// First curve of a start. Default: a straight line.
    pub first: FirstCurve,
}

impl Default for CurveSettings {
    fn default() -> Self {
        Self { way_points: 30, steps: 50, settle: 5, goals: 30, first: FirstCurve::Straight }
    }
}

impl CurveSettings {
    /// Checks the ranges of the settings.
    pub(crate) fn check(&self, ranges: Ranges) -> Result<Ranges, PlanError> {
        const WAY_POINTS: [usize; 2] = [5, 1000];
        ranges
            .count_between("way_points", self.way_points, WAY_POINTS)?
            .positive("steps", self.steps as f64)?
            .count("goals", self.goals, usize::MAX)
    }
}
