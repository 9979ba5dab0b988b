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
