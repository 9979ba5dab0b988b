use std::collections::{HashMap, HashSet};
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread;

use crate::foreign::sandbox::Isolation;
use crate::running::worker_message::{Request, TrialRun};
use crate::running::worker_process::{Served, WorkerProcess};
use crate::store::exports::Exports;
use crate::{
    BenchError, PlannerCall, Question, Results, RunInformation, Sandbox, Schedule, TrialOutcome, TrialRecord,
    WorkerProgram,
};

/// Settings of the execution of a campaign.
#[derive(Clone, Debug)]
pub struct CampaignSettings {
    /// Program of the workers.
    pub worker: WorkerProgram,
    /// Number of simultaneous workers; more than one compete for processor time.
    pub workers: usize,
    /// Memory limit of a search, in bytes.
    pub memory_limit_bytes: u64,
    /// Information stored with the run.
    pub information: RunInformation,
    /// Isolation of external programs. Default: the mechanisms that the machine supports.
    pub sandbox: Sandbox,
    /// Outcomes whose trials are run again and replaced. Default: none.
    pub again: Vec<TrialOutcome>,
}

/// Summary of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RunSummary {
    /// Number of trials of the campaign.
    pub trials: usize,
    /// Number of trials stored before.
    pub known: usize,
    /// Number of trials run now.
    pub run: usize,
    /// Number of solved trials among those run now.
    pub solved: usize,
    /// True if the run was stopped before the end.
    pub is_stopped: bool,
}

/// Observer of a running campaign.
pub trait CampaignObserver {
    /// Reports the number of trials to run and the trials stored before.
    fn begins(&mut self, _to_run: usize, _known: &[TrialRecord]) {}

    /// Reports a trial that has ended and is stored.
    fn trial_ended(&mut self, _record: &TrialRecord) {}
}

/// Observer that does nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoObserver;

impl CampaignObserver for NoObserver {}

/// Runs the trials of a campaign that are not in `results` yet, and stores every trial as it ends.
///
/// 1. Skip the known trials.
/// 2. Each worker takes the next trial. A worker lost in a trial is replaced, and its trial gets the matching outcome.
/// 3. Store each answer before the next one is processed.
///
/// `stop` ends the campaign; the trials in progress are then not stored.
///
/// # Errors
/// [`BenchError::InUse`] if another campaign writes the same results, [`BenchError::Refused`] if a trial cannot be run at
/// all, [`BenchError::NotRunnable`] if no worker starts, [`BenchError::NoSandbox`], [`BenchError::ResultsGone`] if the
/// results file is removed, replaced or truncated meanwhile, and errors of [`Results`]; stored trials remain stored.
pub fn run_campaign(
    schedule: &Schedule,
    settings: &CampaignSettings,
    results: &mut Results,
    observer: &mut dyn CampaignObserver,
    stop: &AtomicBool,
) -> Result<RunSummary, BenchError> {
    // 1.
    results.claim()?;
    let stays = |record: &TrialRecord| !settings.again.contains(&record.outcome);
    let stored = results.records()?.into_iter().filter(stays);
    let mut stored: HashMap<String, TrialRecord> =
        stored.map(|record| (record.trial.key(), record)).collect();
    let (mut known, mut open) = (Vec::new(), Vec::new());
    for question in &schedule.questions {
        match stored.remove(&question.trial.key()) {
            Some(record) => known.push(record),
            None => open.push(question),
        }
    }
    drop(stored);
    let mut summary =
        RunSummary { trials: schedule.questions.len(), known: known.len(), ..RunSummary::default() };
    observer.begins(open.len(), &known);
    drop(known);
    if open.is_empty() {
        return Ok(summary);
    }
    let isolation = isolation(open.iter().copied(), settings)?;
    let information = RunInformation {
        memory_limit_bytes: Some(settings.memory_limit_bytes),
        sandbox: isolation.text(),
        ..settings.information.clone()
    };
    let run = results.begin_run(&information)?;
    for source in &schedule.scenarios {
        results.note_scenario(source)?;
    }
    let mut noted = HashSet::new();
    for Question { trial, call, .. } in &open {
        if noted.insert((&trial.planner, &trial.settings)) {
            let source = serde_json::to_string(call).map_err(|reason| BenchError::message(&reason))?;
            results.note_planner(&trial.planner, &trial.settings, &source)?;
        }
    }
    let exports = Exports::new()?;
    let (next, is_over) = (AtomicUsize::new(0), AtomicBool::new(false));
    let is_stopped = || stop.load(Ordering::Relaxed) || is_over.load(Ordering::Relaxed);
    thread::scope(|scope| {
        let (sender, answers) = mpsc::channel();
        for _ in 0..settings.workers.max(1) {
            let (sender, open, next, exports) = (sender.clone(), &open, &next, exports.path());
            let is_stopped = &is_stopped;
            scope.spawn(move || {
                let mut worker = None;
                while !is_stopped() {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let Some(question) = open.get(index) else { return };
                    // 2.
                    let asked = ask(&mut worker, question, settings, isolation, exports, is_stopped);
                    let is_end = !matches!(asked, Ok(Some(_)));
                    if sender.send(asked).is_err() || is_end {
                        return;
                    }
                }
            });
        }
        drop(sender);
        // 3.
        let mut store = || -> Result<(), BenchError> {
            for asked in &answers {
                let Some((record, path)) = asked? else { continue };
                // A stored trial is in the schedule only if it must run again.
                results.replace(run, &record, &path)?;
                results.check_in_place()?;
                summary.run += 1;
                summary.solved += usize::from(record.is_solved());
                observer.trial_ended(&record);
            }
            Ok(())
        };
        let stored = store();
        is_over.store(true, Ordering::Relaxed);
        stored
    })?;
    summary.is_stopped = stop.load(Ordering::Relaxed);
    results.end_run(run)?;
    results.check_stored(run, summary.run)?;
    Ok(summary)
}

/// Runs a trial on `worker`, or on a new one if there is none. Returns its record and path; `None` if the campaign was stopped.
fn ask(
    worker: &mut Option<WorkerProcess>,
    question: &Question,
    settings: &CampaignSettings,
    isolation: Isolation,
    exports: &Path,
    is_stopped: &dyn Fn() -> bool,
) -> Result<Option<TrialRun>, BenchError> {
    // A worker that ended between two trials is replaced without losing a trial.
    if !worker.as_mut().is_some_and(WorkerProcess::is_alive) {
        *worker = Some(WorkerProcess::start(&settings.worker, exports)?);
    }
    let Some(serving) = worker else { return Ok(None) };
    let request = Request {
        question: question.clone(),
        exports: serving.exports().to_owned(),
        memory_limit_bytes: settings.memory_limit_bytes,
        isolation,
        worker: settings.worker.clone(),
    };
    match serving.serve(&request, is_stopped) {
        Served::Answered(record, path) => Ok(Some((record, path))),
        Served::Refused(reason) => Err(BenchError::Refused {
            scenario: question.trial.scenario.clone(),
            planner: question.trial.planner.clone(),
            reason,
        }),
        Served::Lost(record) => {
            *worker = None;
            Ok(Some((record, Vec::new())))
        }
        Served::Stopped => Ok(None),
    }
}

/// Runs one trial on a worker of its own.
///
/// # Errors
/// As [`run_campaign`].
pub(crate) fn ask_once(
    question: &Question,
    settings: &CampaignSettings,
    stop: &AtomicBool,
) -> Result<Option<TrialRun>, BenchError> {
    let exports = Exports::new()?;
    let isolation = isolation(std::iter::once(question), settings)?;
    ask(&mut None, question, settings, isolation, exports.path(), &|| stop.load(Ordering::Relaxed))
}

/// Returns the isolation of the trials; none if all planners are built in.
fn isolation<'a>(
    mut questions: impl Iterator<Item = &'a Question>,
    settings: &CampaignSettings,
) -> Result<Isolation, BenchError> {
    let is_foreign = |question: &Question| !matches!(question.call, PlannerCall::BuiltIn { .. });
    if questions.any(is_foreign) {
        Isolation::of(settings.sandbox, &settings.worker)
    } else {
        Ok(Isolation::default())
    }
}
