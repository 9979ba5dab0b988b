//! Any behaviour of a worker is an outcome of its trial, and the campaign continues. The workers here are scripts.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use cranny_bench::{
    BenchError, Campaign, CampaignObserver, CampaignPlanner, CampaignSettings, NoObserver, PlannerCall,
    Results, RunInformation, Sandbox, Schedule, TrialOutcome, TrialRecord, WorkerProgram, run_campaign,
};
use cranny_plan::Registry;

/// Creates a campaign of `runs` short trials.
fn schedule(runs: u64) -> Schedule {
    let campaign = Campaign {
        scenarios: vec!["021".into()],
        planners: vec![CampaignPlanner::new(
            PlannerCall::parse("reach", &Registry::default()).expect("a planner"),
        )],
        runs,
        time_limit_s: 0.5,
        ..Campaign::default()
    };
    campaign.schedule(&Registry::default()).expect("a schedule")
}

/// Creates settings with workers that a shell runs.
fn settings(script: &str) -> CampaignSettings {
    CampaignSettings {
        worker: WorkerProgram { program: "/bin/sh".into(), arguments: vec!["-c".into(), script.into()] },
        workers: 1,
        memory_limit_bytes: 100 << 20,
        information: RunInformation::here(None, "cranny bench run", 1),
        // The workers of these tests are shells.
        sandbox: Sandbox::Off,
        again: Vec::new(),
    }
}

fn results(folder: &Path) -> Results {
    Results::create(&folder.join("results.db")).expect("results")
}

/// Returns the outcomes and details of two trials served by `script`.
fn outcomes(script: &str) -> Vec<(TrialOutcome, String)> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut results = results(folder.path());
    let ended =
        run_campaign(&schedule(2), &settings(script), &mut results, &mut NoObserver, &AtomicBool::new(false));
    assert_eq!(ended.expect("a campaign").run, 2);
    let told = |record: TrialRecord| (record.outcome, record.detail.unwrap_or_default());
    results.records().expect("records").into_iter().map(told).collect()
}

#[test]
fn a_worker_that_crashes_takes_one_trial_with_it_and_is_replaced() {
    for (outcome, detail) in outcomes("read line; echo out of luck >&2; exit 3") {
        assert_eq!(outcome, TrialOutcome::Crashed);
        assert_eq!(detail, "ended with exit code 3: out of luck");
    }
    for (outcome, detail) in outcomes("read line; echo '\"opened\"'; kill -9 $$") {
        assert_eq!(outcome, TrialOutcome::Killed);
        assert_eq!(detail, "ended by signal 9");
    }
}

#[test]
fn a_worker_that_hangs_is_ended() {
    for (outcome, detail) in outcomes("read line; echo '\"opened\"'; sleep 1000") {
        assert_eq!(outcome, TrialOutcome::Hung, "{detail}");
        assert!(detail.starts_with("ended after 10."), "{detail}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_worker_that_eats_memory_is_ended() {
    for (outcome, detail) in outcomes(
        "read line; echo '\"opened\"'; exec awk 'BEGIN {s = \"xxxxxxxxxxxxxxxx\"; while (1) s = s s}'",
    ) {
        assert_eq!(outcome, TrialOutcome::OutOfMemory, "{detail}");
    }
}

/// Time and memory of the judge are not those of the planner.
#[test]
fn a_worker_that_is_lost_while_it_judges_leaves_its_trial_undecided() {
    let searched = "read line; echo '\"opened\"'; echo '\"planned\"'; sleep 0.3; ";
    for (outcome, detail) in outcomes(&format!("{searched}echo out of luck >&2; exit 3")) {
        assert_eq!(outcome, TrialOutcome::Undecided, "{detail}");
        assert_eq!(detail, "the judge gave no verdict: ended with exit code 3: out of luck");
    }
    for (outcome, detail) in outcomes(&format!("{searched}kill -9 $$")) {
        assert_eq!(outcome, TrialOutcome::Killed, "{detail}");
    }
    #[cfg(target_os = "linux")]
    {
        let eating = "exec awk 'BEGIN {s = \"xxxxxxxxxxxxxxxx\"; while (1) s = s s}'";
        for (outcome, detail) in outcomes(&format!("{searched}{eating}")) {
            assert_eq!(outcome, TrialOutcome::Undecided, "{detail}");
            assert!(detail.starts_with("the judge gave no verdict: held "), "{detail}");
        }
    }
}

#[test]
fn a_worker_that_talks_nonsense_is_ended() {
    for (outcome, detail) in outcomes("read line; echo hello; sleep 1000") {
        assert_eq!(outcome, TrialOutcome::Garbled);
        assert!(detail.contains("the worker's answer is not valid"), "{detail}");
    }
}

/// A passing shortage of processes, memory or disk space costs the campaign nothing, and a lasting one the trial alone.
#[test]
fn a_trial_that_cannot_be_started_is_tried_again_and_then_left_undecided() {
    let short = "read line; echo '{\"not-started\": \"no space left\"}'; ";
    for (outcome, detail) in outcomes(&format!("{short} read line; echo out of luck >&2; exit 3")) {
        assert_eq!(outcome, TrialOutcome::Crashed, "{detail}");
    }
    for (outcome, detail) in outcomes(&format!("while true; do {short} done")) {
        assert_eq!(outcome, TrialOutcome::Undecided);
        assert!(detail.contains("could not be started") && detail.ends_with("no space left"), "{detail}");
    }
}

#[test]
fn a_question_that_makes_no_sense_ends_the_campaign_and_leaves_what_is_there() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut results = results(folder.path());
    let refusal = "read line; echo '{\"refused\": \"no such planet\"}'; sleep 1000";
    let ended = run_campaign(
        &schedule(2),
        &settings(refusal),
        &mut results,
        &mut NoObserver,
        &AtomicBool::new(false),
    );
    let message = ended.expect_err("a fault").to_string();
    assert!(message.contains("scenario 021, planner reach: no such planet"), "{message}");
    assert_eq!(results.records().expect("records"), []);
    let ended = run_campaign(
        &schedule(1),
        &CampaignSettings {
            worker: WorkerProgram { program: "/no/such/program".into(), arguments: Vec::new() },
            ..settings("")
        },
        &mut results,
        &mut NoObserver,
        &AtomicBool::new(false),
    );
    assert!(matches!(ended, Err(BenchError::NotRunnable { .. })));
}

#[test]
fn a_stop_ends_the_campaign_without_the_trial_under_way() {
    /// Observer that stops the campaign after the first trial.
    struct Impatient<'a>(&'a AtomicBool);
    impl CampaignObserver for Impatient<'_> {
        fn trial_ended(&mut self, _: &TrialRecord) {
            self.0.store(true, Ordering::Relaxed);
        }
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut results = results(folder.path());
    let stop = AtomicBool::new(false);
    let script = "read line; exit 3";
    let ended = run_campaign(&schedule(50), &settings(script), &mut results, &mut Impatient(&stop), &stop)
        .expect("ended");
    assert!(ended.is_stopped && ended.run < 50, "{ended:?}");
    let stored = results.records().expect("records").len();
    assert_eq!(stored, ended.run);
    let again = run_campaign(
        &schedule(50),
        &settings(script),
        &mut results,
        &mut NoObserver,
        &AtomicBool::new(false),
    )
    .expect("a campaign");
    assert_eq!((again.known, again.run, again.is_stopped), (stored, 50 - stored, false));
}

/// Observer that does something to the results file when a trial is stored.
struct Meddler<'a> {
    path: &'a Path,
    act: fn(&Path),
    after: usize,
}

impl CampaignObserver for Meddler<'_> {
    fn trial_ended(&mut self, _: &TrialRecord) {
        self.after -= 1;
        if self.after == 0 {
            (self.act)(self.path);
        }
    }
}

/// Runs three short trials, and does something to the results file after one of them.
fn meddled(folder: &Path, act: fn(&Path), after: usize) -> Result<usize, BenchError> {
    let path = folder.join("results.db");
    let mut results = Results::create(&path).expect("results");
    let mut observer = Meddler { path: &path, act, after };
    let settings = settings("read line; exit 3");
    let stop = AtomicBool::new(false);
    run_campaign(&schedule(3), &settings, &mut results, &mut observer, &stop).map(|summary| summary.run)
}

#[test]
fn results_that_are_taken_away_end_the_campaign_and_are_saved() {
    let acts: [fn(&Path); 3] = [
        |path| std::fs::remove_file(path).expect("removed"),
        |path| std::fs::rename(path, path.with_extension("old")).expect("renamed"),
        |path| {
            let other = path.with_file_name("other.db");
            drop(Results::create(&other).expect("results"));
            std::fs::rename(other, path).expect("replaced");
        },
    ];
    for (act, after) in acts.into_iter().flat_map(|act| [(act, 1), (act, 3)]) {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let fault = meddled(folder.path(), act, after).expect_err("an error");
        assert!(matches!(fault, BenchError::ResultsGone { .. }), "{fault}");
        let entries =
            std::fs::read_dir(folder.path()).expect("a folder").map(|entry| entry.expect("an entry"));
        let saved = entries.map(|entry| entry.path()).find(|path| path.to_string_lossy().contains("-saved-"));
        let saved = saved.expect("a saved file");
        assert!(fault.to_string().contains(&saved.display().to_string()), "{fault}");
        // The trial after the act is stored before the next check.
        let count = Results::open(&saved).expect("results").count().expect("a count");
        assert_eq!(count, 3.min(after + 1));
    }
}

#[test]
fn results_that_are_cut_or_written_over_end_the_campaign() {
    let acts: [fn(&Path); 4] = [
        |path| std::fs::write(path, "").expect("truncated"),
        |path| {
            let file = std::fs::File::options().write(true).open(path).expect("opened");
            file.set_len(5000).expect("truncated");
        },
        |path| {
            let other = path.with_file_name("other.db");
            drop(Results::create(&other).expect("results"));
            std::fs::copy(other, path).expect("copied");
        },
        |path| std::fs::remove_dir_all(path.parent().expect("a folder")).expect("removed"),
    ];
    for (act, after) in acts.into_iter().flat_map(|act| [(act, 1), (act, 3)]) {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let inside = folder.path().join("campaign");
        std::fs::create_dir(&inside).expect("a folder");
        // A file that the database repairs from its log is as good as untouched.
        if let Ok(run) = meddled(&inside, act, after) {
            let stored =
                Results::open(&inside.join("results.db")).expect("results").count().expect("a count");
            assert_eq!((stored, run), (3, 3), "after {after}");
        }
    }
    let nothing: fn(&Path) = |_| ();
    let folder = tempfile::tempdir().expect("a temporary folder");
    assert_eq!(meddled(folder.path(), nothing, 1).expect("a campaign"), 3);
}
