use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use cranny_scenario::write_whole_file;
use serde::{Deserialize, Serialize};

use crate::store::shard::shards_at;
use crate::tally::Tally;
use crate::{BenchError, CampaignObserver, Results, Shard, TrialRecord};

/// Progress of a campaign or of one of its shards. The campaign writes it beside its results while it runs, so that its
/// progress is readable without opening results in use, possibly on another machine.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CampaignProgress {
    /// Number of its trials; `None` if only results are available.
    pub trials: Option<usize>,
    /// Numbers of ended and of solved trials, by planner.
    pub planners: BTreeMap<String, Tally>,
    /// Number of trials that ended in this run.
    pub run: usize,
    /// Duration of this run, in seconds.
    pub elapsed_s: f64,
    /// Number of simultaneous trials.
    pub workers: usize,
    /// Time of writing, in seconds since 1970.
    pub written_s: u64,
    /// Name of the machine.
    pub machine: String,
    /// Shards of the campaign that are here; empty for a whole campaign, or if unknown.
    #[serde(default)]
    pub shards: Vec<Shard>,
}

impl CampaignProgress {
    /// Computes the progress from results, quickly.
    ///
    /// # Errors
    /// As [`Results::open`], except that the pages of the file are not checked for damage.
    pub fn of_results(path: &Path) -> Result<Self, BenchError> {
        Ok(Self { planners: Results::glance(path)?, shards: shards_at(path)?, ..Self::default() })
    }

    /// Reads the file of a [`ProgressFile`]; `None` if it is missing or unreadable.
    pub fn read(path: &Path) -> Option<Self> {
        let text = cranny_file::TEXT.text(path).ok()?;
        serde_json::from_str(&text).ok()
    }

    /// Returns the tally of all planners together.
    pub fn tally(&self) -> Tally {
        self.planners.values().copied().fold(Tally::default(), Tally::plus)
    }

    /// Returns true if every trial has ended.
    pub fn is_done(&self) -> bool {
        self.trials.is_some_and(|trials| self.tally().ended >= trials)
    }

    /// Estimates the remaining time at the pace of this run, in seconds; `None` if unknown.
    pub fn left_s(&self) -> Option<f64> {
        let left = self.trials?.saturating_sub(self.tally().ended);
        (self.run > 0).then(|| self.elapsed_s / self.run as f64 * left as f64)
    }
}

/// Observer that updates a file with the [`CampaignProgress`] of a campaign, and forwards all events.
pub struct ProgressFile<'a> {
    path: &'a Path,
    progress: CampaignProgress,
    begin: Instant,
    written: Option<Instant>,
    observer: &'a mut dyn CampaignObserver,
}

/// Minimum interval between two updates.
const WRITE_EVERY: Duration = Duration::from_secs(2);

impl<'a> ProgressFile<'a> {
    /// Creates the observer of a campaign with this number of `workers` on `machine`, for a file beside the results.
    pub fn new(
        path: &'a Path,
        workers: usize,
        machine: &str,
        observer: &'a mut dyn CampaignObserver,
    ) -> Self {
        let progress =
            CampaignProgress { workers, machine: machine.to_owned(), ..CampaignProgress::default() };
        Self { path, progress, begin: Instant::now(), written: None, observer }
    }

    /// States the shard that the campaign runs; `None` for the whole.
    #[must_use]
    pub fn of_shard(mut self, shard: Option<Shard>) -> Self {
        self.progress.shards = shard.into_iter().collect();
        self
    }

    /// Writes the current progress.
    pub fn write(&mut self) {
        self.progress.elapsed_s = self.begin.elapsed().as_secs_f64();
        self.progress.written_s =
            SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
        self.written = Some(Instant::now());
        let Ok(text) = serde_json::to_string(&self.progress) else { return };
        // A failure is ignored, because the file only informs and must not end the campaign.
        let _ = write_whole_file(self.path, text.as_bytes());
    }
}

impl CampaignProgress {
    fn count(&mut self, record: &TrialRecord) {
        let tally = self.planners.entry(record.trial.planner.clone()).or_default();
        tally.ended += 1;
        tally.solved += usize::from(record.is_solved());
    }
}

impl CampaignObserver for ProgressFile<'_> {
    fn begins(&mut self, to_run: usize, known: &[TrialRecord]) {
        self.progress.trials = Some(to_run + known.len());
        for record in known {
            self.progress.count(record);
        }
        self.write();
        self.observer.begins(to_run, known);
    }

    fn notes(&mut self, note: &str) {
        self.observer.notes(note);
    }

    fn trial_ended(&mut self, record: &TrialRecord) {
        self.progress.count(record);
        self.progress.run += 1;
        if self.written.is_none_or(|written| written.elapsed() >= WRITE_EVERY) {
            self.write();
        }
        self.observer.trial_ended(record);
    }
}
