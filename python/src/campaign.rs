//! Campaigns, run in worker processes of this interpreter.

use std::io::{BufReader, stdin, stdout};
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread;
use std::time::Duration;

use cranny_bench::{
    Campaign, CampaignObserver, CampaignPlanner, CampaignSettings, PathDemand, PlannerCall, Results,
    RunInformation, Shard, TrialRecord, WorkerProgram,
};
use cranny_collision::Margins;
use cranny_grasp::ScoreKind;
use cranny_plan::Registry;
use cranny_solve::PoseRadius;
use pyo3::prelude::*;
use strum::VariantArray;

use crate::handover::fault::{bad_type, bad_value, fault};
use crate::handover::json::settings_of;
use crate::handover::names::criterion_of;
use crate::handover::whole;
use crate::planning::seconds;

/// Interval at which signals are checked and progress is reported.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// Parses the value of an argument that names a variant.
fn one_of<T>(argument: &str, word: &str) -> PyResult<T>
where
    T: FromStr + VariantArray + Copy + Into<&'static str>,
{
    let known = || T::VARIANTS.iter().map(|one| (*one).into()).collect::<Vec<&str>>().join(", ");
    word.parse().map_err(|_| bad_value(format!("{argument} is '{word}', but one of {} is expected", known())))
}

/// Runs the trials of a campaign that are not in `output` yet: `scenarios` × `planners` × `criteria` × seeds (see `bench.run`).
///
/// `planners`: tuples of a name, a call (the name of a built-in planner, or the words of a command that speaks the exec
/// protocol), and settings that differ from the defaults, or None. `worker`: the words of the command that serves trials.
/// `heard`: a function called with the numbers of ended, scheduled and solved trials whenever they change, or None.
#[pyfunction]
#[pyo3(signature = (scenarios, planners, output, worker, *, criteria, runs, first_seed, time_limit_s, iterations,
    memory_limit_mb, workers, judge_both, measure_clearance, carry, task, grasps, margin_m, grasp_margin_m, robust, hold, try_in_physics, sandbox, again, shard, command,
    heard=None))]
#[allow(clippy::too_many_arguments, reason = "what a campaign is")]
pub fn run_campaign(
    py: Python<'_>,
    scenarios: Vec<String>,
    planners: Vec<(String, Bound<'_, PyAny>, Option<Bound<'_, PyAny>>)>,
    output: PathBuf,
    worker: Vec<String>,
    criteria: Vec<String>,
    #[pyo3(from_py_with = whole::runs)] runs: u64,
    #[pyo3(from_py_with = whole::first_seed)] first_seed: u64,
    time_limit_s: f64,
    #[pyo3(from_py_with = whole::iterations)] iterations: Option<u64>,
    #[pyo3(from_py_with = whole::memory_limit_mb)] memory_limit_mb: u64,
    #[pyo3(from_py_with = whole::workers)] workers: usize,
    judge_both: bool,
    measure_clearance: bool,
    carry: Option<&str>,
    task: Option<String>,
    grasps: Option<&str>,
    margin_m: f64,
    grasp_margin_m: f64,
    robust: Option<(f64, f64)>,
    hold: Option<f64>,
    #[pyo3(from_py_with = whole::try_in_physics)] try_in_physics: Option<u64>,
    sandbox: &str,
    again: Vec<String>,
    shard: Option<(u64, u64)>,
    command: &str,
    heard: Option<Bound<'_, PyAny>>,
) -> PyResult<()> {
    let [program, arguments @ ..] = &worker[..] else {
        return Err(bad_value("worker is empty, but a command is expected"));
    };
    let campaign = Campaign {
        scenarios,
        planners: planners.iter().map(campaign_planner).collect::<PyResult<_>>()?,
        criteria: criteria.iter().map(|name| criterion_of(name)).collect::<PyResult<_>>()?,
        runs,
        first_seed,
        time_limit_s: seconds("time_limit_s", time_limit_s)?.as_secs_f64(),
        iteration_limit: iterations,
        memory_limit_bytes: memory_limit_mb.saturating_mul(cranny_bench::MEGABYTE),
        judge_both,
        measure_clearance,
        demand: PathDemand {
            carry: carry.map(|word| one_of("carry", word)).transpose()?,
            task,
            margins: Margins { margin_m, grasp_margin_m, ..Margins::default() },
            robust: robust.map(|(translation_m, rotation_rad)| PoseRadius { translation_m, rotation_rad }),
            hold,
            try_in_physics,
            without_grasp_set: grasps.map_or(Ok(false), without_grasp_set)?,
        },
        exceptions: Vec::new(),
    };
    let shard = shard.map(|(index, count)| {
        let wrong =
            || bad_value(format!("shard is ({index}, {count}), but the first must be from 1 to the second"));
        Shard::new(index, count).ok_or_else(wrong)
    });
    let shard = shard.transpose()?;
    let whole = py.detach(|| campaign.schedule(&Registry::default())).map_err(fault)?;
    let settings = CampaignSettings {
        worker: WorkerProgram { program: program.into(), arguments: arguments.to_vec() },
        workers,
        memory_limit_bytes: campaign.memory_limit_bytes,
        information: RunInformation::here(None, command, workers),
        sandbox: one_of("sandbox", sandbox)?,
        again: again.iter().map(|outcome| one_of("again", outcome)).collect::<PyResult<_>>()?,
    };
    let (stop, progress) = (AtomicBool::new(false), Progress::default());
    let heard = heard.map(Bound::unbind);
    let (ended, raised) = py.detach(|| {
        thread::scope(|scope| {
            let campaign = scope.spawn(|| -> Result<(), cranny_bench::BenchError> {
                let mut results = Results::create(&output)?;
                let schedule = match shard {
                    None => whole,
                    Some(shard) => {
                        shard.check(&whole, &results)?;
                        shard.of(whole)
                    }
                };
                cranny_bench::run_campaign(&schedule, &settings, &mut results, &mut &progress, &stop)
                    .map(drop)
            });
            let mut raised = None;
            while !campaign.is_finished() {
                thread::sleep(LOOK_EVERY);
                if raised.is_none() {
                    raised = Python::attach(|py| progress.tell(py, heard.as_ref())).err();
                    stop.store(raised.is_some(), Ordering::Relaxed);
                }
            }
            (campaign.join(), raised)
        })
    });
    if let Some(raised) = raised {
        return Err(raised);
    }
    progress.tell(py, heard.as_ref())?;
    match ended {
        Ok(ended) => ended.map_err(fault),
        Err(_) => Err(fault("the campaign ended unexpectedly, which is a bug in Cranny; please report it")),
    }
}

/// Parses the argument `grasps` of a campaign, for which only "none" is valid.
fn without_grasp_set(word: &str) -> PyResult<bool> {
    if word == "none" {
        Ok(true)
    } else {
        Err(bad_value(format!("grasps is '{word}', but \"none\" is expected")))
    }
}

/// Serves the trials of a campaign that arrives on standard input, then ends the process; `python -m cranny.worker` calls it.
#[pyfunction]
pub fn serve_trials(py: Python<'_>) -> PyResult<()> {
    py.detach(|| cranny_bench::serve(&Registry::default(), BufReader::new(stdin()), &mut stdout()))
        .map_err(fault)
}

fn campaign_planner(
    (name, call, settings): &(String, Bound<'_, PyAny>, Option<Bound<'_, PyAny>>),
) -> PyResult<CampaignPlanner> {
    let call = if let Ok(planner) = call.extract::<String>() {
        PlannerCall::BuiltIn {
            planner,
            settings: settings_of(settings.as_ref())?,
            score: ScoreKind::default(),
            min_score: None,
        }
    } else {
        let command = call.extract::<Vec<String>>().map_err(|_| {
            bad_type(format!(
                "planner '{name}': the name of a planner or the words of a command are expected"
            ))
        })?;
        PlannerCall::Exec { command }
    };
    let planner = CampaignPlanner::new(call.checked(&Registry::default()).map_err(fault)?);
    Ok(CampaignPlanner { name: name.clone(), ..planner })
}

/// Progress of a campaign.
#[derive(Debug, Default)]
struct Progress {
    to_run: AtomicUsize,
    ended: AtomicUsize,
    solved: AtomicUsize,
    /// Number of ended trials at the last report, plus one; 0 before the first report.
    told: AtomicUsize,
}

impl Progress {
    fn tell(&self, py: Python<'_>, heard: Option<&Py<PyAny>>) -> PyResult<()> {
        py.check_signals()?;
        let count = |counter: &AtomicUsize| counter.load(Ordering::Relaxed);
        let (ended, to_run) = (count(&self.ended), count(&self.to_run));
        if let Some(heard) = heard
            && to_run > 0
            && self.told.swap(ended + 1, Ordering::Relaxed) != ended + 1
        {
            heard.call1(py, (ended, to_run, count(&self.solved)))?;
        }
        Ok(())
    }
}

impl CampaignObserver for &Progress {
    fn begins(&mut self, to_run: usize, _known: &[TrialRecord]) {
        self.to_run.store(to_run, Ordering::Relaxed);
    }

    fn trial_ended(&mut self, record: &TrialRecord) {
        self.solved.fetch_add(usize::from(record.is_solved()), Ordering::Relaxed);
        self.ended.fetch_add(1, Ordering::Relaxed);
    }
}
