use std::collections::{HashMap, HashSet};
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread;
use std::time::{Duration, Instant};

use cranny_plan::Statistics;

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

    /// Reports a fact about this machine that affects the trials, as a sentence for a person.
    fn notes(&mut self, _note: &str) {}

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
/// 2. Each worker takes the next trial. A worker lost in a trial is replaced, and its trial gets the matching outcome. A trial
///    that cannot be started for lack of resources is tried again a few times; then it is undecided.
/// 3. Store each answer before the next one is processed. While another program locks the results, wait.
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
    if settings.sandbox == Sandbox::Auto
        && let Some(note) = isolation.and_then(Isolation::weakness)
    {
        observer.notes(&note);
    }
    let isolation = isolation.unwrap_or_default();
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
    let results_path = results.path().to_owned();
    let (next, is_over) = (AtomicUsize::new(0), AtomicBool::new(false));
    let is_stopped = || stop.load(Ordering::Relaxed) || is_over.load(Ordering::Relaxed);
    let exports = exports.path();
    let conditions =
        Conditions { settings, isolation, exports, results: &results_path, is_stopped: &is_stopped };
    thread::scope(|scope| {
        let (sender, answers) = mpsc::channel();
        for _ in 0..settings.workers.max(1) {
            let (sender, open, next) = (sender.clone(), &open, &next);
            let is_stopped = &is_stopped;
            let serve = move || {
                let mut worker = None;
                while !is_stopped() {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let Some(question) = open.get(index) else { return };
                    // 2.
                    let asked = ask(&mut worker, question, conditions);
                    let is_end = !matches!(asked, Ok(Some(_)));
                    if sender.send(asked).is_err() || is_end {
                        return;
                    }
                }
            };
            if let Err(reason) = thread::Builder::new().spawn_scoped(scope, serve) {
                is_over.store(true, Ordering::Relaxed);
                return Err(BenchError::NotRunnable { program: "a campaign".to_owned(), reason });
            }
        }
        drop(sender);
        // 3.
        let mut store = || -> Result<(), BenchError> {
            for asked in &answers {
                let Some((record, path)) = asked? else { continue };
                store_trial(results, run, (&record, &path), stop)?;
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

/// Conditions of the trials of a run.
#[derive(Clone, Copy)]
struct Conditions<'a> {
    settings: &'a CampaignSettings,
    isolation: Isolation,
    /// Folder for the folders of workers.
    exports: &'a Path,
    /// File of the results.
    results: &'a Path,
    is_stopped: &'a (dyn Fn() -> bool + Sync),
}

/// Number of attempts to start a trial, and interval between them.
const ATTEMPTS: u32 = 4;
const ATTEMPT_EVERY: Duration = Duration::from_secs(1);

/// Runs a trial on `worker`, or on a new one if there is none. Returns its record and path; `None` if the campaign was stopped.
fn ask(
    worker: &mut Option<WorkerProcess>,
    question: &Question,
    conditions: Conditions,
) -> Result<Option<TrialRun>, BenchError> {
    let mut detail = None;
    for attempt in 0..ATTEMPTS {
        if attempt > 0 && !pause(ATTEMPT_EVERY, conditions.is_stopped) {
            return Ok(None);
        }
        match ask_now(worker, question, conditions) {
            Err(fault) if fault.is_shortage() => detail = Some(fault.to_string()),
            asked => return asked,
        }
    }
    let statistics = Statistics::default();
    let record = TrialRecord::without_path(&question.trial, TrialOutcome::Undecided, detail, statistics);
    Ok(Some((record, Vec::new())))
}

/// Waits, and returns false if the campaign was stopped meanwhile.
fn pause(time: Duration, is_stopped: &dyn Fn() -> bool) -> bool {
    const STEP: Duration = Duration::from_millis(20);
    let begin = Instant::now();
    while begin.elapsed() < time && !is_stopped() {
        thread::sleep(STEP);
    }
    !is_stopped()
}

/// Runs a trial as [`ask`], without repetition.
fn ask_now(
    worker: &mut Option<WorkerProcess>,
    question: &Question,
    conditions: Conditions,
) -> Result<Option<TrialRun>, BenchError> {
    let Conditions { settings, isolation, exports, results, is_stopped } = conditions;
    // A worker that ended between two trials is replaced without losing a trial.
    if !worker.as_mut().is_some_and(WorkerProcess::is_alive) {
        *worker = Some(WorkerProcess::start(&settings.worker, exports)?);
    }
    let Some(serving) = worker else { return Ok(None) };
    let request = Request {
        question: question.clone(),
        exports: serving.exports().to_owned(),
        results: results.to_owned(),
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
        Served::NotStarted(reason) => Err(BenchError::NotStarted { reason }),
        Served::Lost(record) => {
            *worker = None;
            Ok(Some((record, Vec::new())))
        }
        Served::Stopped => Ok(None),
    }
}

/// Stores a trial. While another program locks the results longer than the database waits, it tries again: the program may be one
/// of a trial, which ends.
fn store_trial(
    results: &mut Results,
    run: u64,
    (record, path): (&TrialRecord, &[Vec<f64>]),
    stop: &AtomicBool,
) -> Result<(), BenchError> {
    /// Longer than any trial of usual campaigns takes.
    const PATIENCE: Duration = Duration::from_mins(10);
    let begin = Instant::now();
    loop {
        // A stored trial is in the schedule only if it must run again.
        match results.replace(run, record, path) {
            Err(fault)
                if fault.is_locked() && begin.elapsed() < PATIENCE && !stop.load(Ordering::Relaxed) => {}
            stored => return stored,
        }
    }
}

/// Runs one trial on a worker of its own.
///
/// # Errors
/// As [`run_campaign`].
pub(crate) fn ask_once(
    question: &Question,
    settings: &CampaignSettings,
    results: &Path,
    stop: &AtomicBool,
) -> Result<Option<TrialRun>, BenchError> {
    let exports = Exports::new()?;
    let isolation = isolation(std::iter::once(question), settings)?.unwrap_or_default();
    let is_stopped = || stop.load(Ordering::Relaxed);
    let conditions =
        Conditions { settings, isolation, exports: exports.path(), results, is_stopped: &is_stopped };
    ask(&mut None, question, conditions)
}

/// Returns the isolation of the trials; `None` if all planners are built in.
fn isolation<'a>(
    mut questions: impl Iterator<Item = &'a Question>,
    settings: &CampaignSettings,
) -> Result<Option<Isolation>, BenchError> {
    let is_foreign = |question: &Question| !matches!(question.call, PlannerCall::BuiltIn { .. });
    let isolation = || Isolation::of(settings.sandbox, &settings.worker);
    questions.any(is_foreign).then(isolation).transpose()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Trial;

    #[test]
    fn a_lock_on_the_results_delays_the_campaign_and_does_not_end_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("results.db");
        let mut results = Results::create(&path).unwrap();
        results.connection.busy_timeout(Duration::from_millis(1)).unwrap();
        let run = results.begin_run(&RunInformation::here(None, "", 1)).unwrap();
        let trial = Trial {
            scenario: "021".into(),
            scenario_hash: String::new(),
            planner: "x".into(),
            settings: "{}".into(),
            criterion: cranny_task::Criterion::Exact,
            seed: 0,
            time_limit_s: 1.0,
            iteration_limit: None,
            goal: None,
        };
        let record = TrialRecord::without_path(&trial, TrialOutcome::GaveUp, None, Statistics::default());
        let other = rusqlite::Connection::open(&path).unwrap();
        other.execute_batch("BEGIN IMMEDIATE").unwrap();
        let (stop, free) = (AtomicBool::new(true), AtomicBool::new(false));
        assert!(store_trial(&mut results, run, (&record, &[]), &stop).unwrap_err().is_locked());
        thread::scope(|scope| {
            scope.spawn(move || {
                thread::sleep(Duration::from_millis(200));
                other.execute_batch("COMMIT").unwrap();
            });
            store_trial(&mut results, run, (&record, &[]), &free).unwrap();
        });
        assert_eq!(results.count().unwrap(), 1);
    }
}
