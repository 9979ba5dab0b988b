use crate::asked::trial::TrialRecord;

/// A trial as the results keep it.
#[derive(Clone, Debug, PartialEq)]
pub struct StoredTrial {
    /// Its number in these results, from 1: what `cranny bench replay` is given.
    pub id: u64,
    /// The [`Run`](crate::Run) that it was part of, by number.
    pub run: u64,
    /// The trial and how it went.
    pub record: TrialRecord,
}
