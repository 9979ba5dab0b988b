use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};

use crate::tally::Tally;
use crate::{BenchError, CampaignObserver, Results, TrialRecord};

/// How far a campaign, or a part of it, is: what it writes beside its results while it runs, so that nobody has to open
/// results that are being written, on another machine at that.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Standing {
    /// How many trials it has; nothing where only results are there to ask.
    pub trials: Option<usize>,
    /// How many ended and how many of them were solved, by planner.
    pub planners: BTreeMap<String, Tally>,
    /// How many ended in this run.
    pub run: usize,
    /// How long this run has taken, in seconds.
    pub elapsed_s: f64,
    /// How many trials at a time.
    pub workers: usize,
    /// When it was written, in seconds since 1970.
    pub written_s: u64,
    /// The machine.
    pub machine: String,
}

impl Standing {
    /// What results say, quickly.
    ///
    /// # Errors
    /// As [`Results::open`], but that the pages of the file are not looked through for damage.
    pub fn of_results(path: &Path) -> Result<Self, BenchError> {
        Ok(Self { planners: Results::glance(path)?, ..Self::default() })
    }

    /// Reads what [`StandingFile`] wrote; nothing where there is none, or none that can be read.
    pub fn read(path: &Path) -> Option<Self> {
        let text = cranny_file::TEXT.text(path).ok()?;
        serde_json::from_str(&text).ok()
    }

    /// All of its trials.
    pub fn tally(&self) -> Tally {
        self.planners.values().copied().fold(Tally::default(), Tally::plus)
    }

    /// Whether every trial has ended.
    pub fn is_done(&self) -> bool {
        self.trials.is_some_and(|trials| self.tally().ended >= trials)
    }

    /// How long the rest of it takes at the pace of this run, in seconds; nothing where nobody knows yet.
    pub fn left_s(&self) -> Option<f64> {
        let left = self.trials?.saturating_sub(self.tally().ended);
        (self.run > 0).then(|| self.elapsed_s / self.run as f64 * left as f64)
    }
}

/// Keeps a file with the [`Standing`] of a campaign up to date, and hands on what it hears.
pub struct StandingFile<'a> {
    path: &'a Path,
    standing: Standing,
    begin: Instant,
    written: Option<Instant>,
    heard: &'a mut dyn CampaignObserver,
}

/// It is written no more often.
const WRITE_EVERY: Duration = Duration::from_secs(2);

impl<'a> StandingFile<'a> {
    /// A file beside the results of a campaign that so many `workers` run on `machine`.
    pub fn new(path: &'a Path, workers: usize, machine: &str, heard: &'a mut dyn CampaignObserver) -> Self {
        let standing = Standing { workers, machine: machine.to_owned(), ..Standing::default() };
        Self { path, standing, begin: Instant::now(), written: None, heard }
    }

    /// Writes how it stands now.
    pub fn write(&mut self) {
        self.standing.elapsed_s = self.begin.elapsed().as_secs_f64();
        self.standing.written_s =
            SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
        self.written = Some(Instant::now());
        let Ok(text) = serde_json::to_string(&self.standing) else { return };
        // It says how far the campaign is, and must not end it.
        let partial = self.path.with_extension("partial");
        let _ = std::fs::write(&partial, text).and_then(|()| std::fs::rename(&partial, self.path));
    }
}

impl Standing {
    fn count(&mut self, record: &TrialRecord) {
        let tally = self.planners.entry(record.trial.planner.clone()).or_default();
        tally.ended += 1;
        tally.solved += usize::from(record.is_solved());
    }
}

impl CampaignObserver for StandingFile<'_> {
    fn begins(&mut self, to_run: usize, known: &[TrialRecord]) {
        self.standing.trials = Some(to_run + known.len());
        for record in known {
            self.standing.count(record);
        }
        self.write();
        self.heard.begins(to_run, known);
    }

    fn trial_ended(&mut self, record: &TrialRecord) {
        self.standing.count(record);
        self.standing.run += 1;
        if self.written.is_none_or(|written| written.elapsed() >= WRITE_EVERY) {
            self.write();
        }
        self.heard.trial_ended(record);
    }
}
