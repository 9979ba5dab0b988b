use crate::BenchError;
use crate::asked::trial::TrialRecord;

/// A trial in the results.
#[derive(Clone, Debug, PartialEq)]
pub struct StoredTrial {
    /// Number of the trial in these results, from 1, as for `cranny bench replay`.
    pub id: u64,
    /// Number of its [`Run`](crate::Run).
    pub run: u64,
    /// The trial and its result.
    pub record: TrialRecord,
}

impl StoredTrial {
    /// Checks that no figure is negative or not finite, that the time limit is above 0, and that a solved trial is within it.
    ///
    /// # Errors
    /// [`BenchError::Figure`], [`BenchError::Late`].
    pub(crate) fn check(&self) -> Result<(), BenchError> {
        let record = &self.record;
        let figures = [
            ("planning time", Some(record.statistics.planning_time_s)),
            ("time limit", Some(record.trial.time_limit_s)),
            ("path length", record.path_length),
            ("score", record.grasp_score),
            // Under the paper's criterion a path may penetrate an obstacle.
            ("clearance", record.clearance_m.map(f64::abs)),
        ];
        for (figure, value) in figures {
            if let Some(value) = value
                && !(value.is_finite() && value >= 0.0)
            {
                return Err(BenchError::Figure { trial: self.id, figure, value });
            }
        }
        let (time_s, limit_s) = (record.statistics.planning_time_s, record.trial.time_limit_s);
        if limit_s <= 0.0 {
            return Err(BenchError::Figure { trial: self.id, figure: "time limit", value: limit_s });
        }
        // A path that comes later does not count, by however little.
        if record.is_solved() && time_s > limit_s {
            return Err(BenchError::Late { trial: self.id, time_s, limit_s });
        }
        Ok(())
    }
}
