//! Planners that cheat, accidentally or on purpose: each is recorded correctly, and no other trial is affected.

use std::io::Write as _;
use std::path::Path;
use std::process::{Child, Command as Process, Output, Stdio};
use std::time::{Duration, Instant};

use assert_cmd::Command;
use cranny_bench::{Results, StoredTrial, TrialOutcome};

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

fn script(folder: &Path, name: &str, text: &str) -> String {
    std::fs::write(folder.join(name), text).expect("written");
    format!("{}=exec:sh {name}", name.trim_end_matches(".sh"))
}

/// Words of `bench run` of one planner in 031, two seeds, without a sandbox; `more` overrides them.
fn words<'a>(planner: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let usual = [["-o", "results.db"], ["--scenarios", "031"], ["--runs", "2"], ["--sandbox", "off"]];
    let usual = usual.iter().filter(|[flag, _]| !more.contains(flag)).flatten();
    ["bench", "run", "--planner", planner].iter().chain(usual).chain(more).copied().collect()
}

fn run(folder: &Path, words: &[&str]) -> Output {
    let mut command = Command::cargo_bin("cranny").expect("the program");
    command.current_dir(folder).args(words).output().expect("it runs")
}

fn begin(folder: &Path, words: &[&str]) -> Child {
    let program = assert_cmd::cargo::cargo_bin("cranny");
    let mut command = Process::new(program);
    command.current_dir(folder).args(words).stdout(Stdio::piped()).stderr(Stdio::piped());
    command.spawn().expect("it runs")
}

fn error(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn stored(folder: &Path) -> Vec<StoredTrial> {
    Results::open(&folder.join("results.db")).expect("results").trials().expect("trials")
}

/// Runs a script as a planner and returns its trials.
fn trials(text: &str, more: &[&str]) -> Vec<StoredTrial> {
    let folder = folder();
    let planner = script(folder.path(), "cheat.sh", text);
    let output = run(folder.path(), &words(&planner, more));
    assert_eq!(output.status.code(), Some(0), "{}", error(&output));
    stored(folder.path())
}

fn said(trial: &StoredTrial) -> &str {
    trial.record.detail.as_deref().unwrap_or_default()
}

/// Returns a sleep command with a duration that no other process uses.
fn sleep(offset: u64) -> String {
    format!("sleep {}", 2_000_000 + 10 * u64::from(std::process::id()) + offset)
}

/// Command that ends the worker, which is the parent of the process that encloses the program.
const KILL_WORKER: &str = "kill -9 $(ps -o ppid= -p $PPID)";

fn is_running(line: &str) -> bool {
    let listing = Process::new("ps").args(["-eo", "args"]).output().expect("ps");
    String::from_utf8_lossy(&listing.stdout).lines().any(|running| running == line)
}

#[test]
fn whoever_computes_on_behind_an_end_is_neither_waited_for_nor_believed() {
    let late = "setsid sh -c 'sleep 1; paste -sd, START' &\nexit 0\n".replace("START", "\"$1\"");
    for trial in trials(&late, &["--time-limit", "2"]) {
        assert_eq!(trial.record.outcome, TrialOutcome::GaveUp, "{}", said(&trial));
        assert!(
            trial.record.statistics.planning_time_s >= 0.2,
            "{}",
            trial.record.statistics.planning_time_s
        );
    }
}

#[test]
fn counts_that_no_program_counts_are_garbled_and_end_no_campaign() {
    let answer = "echo '{\"statistics\": {\"iterations\": 18446744073709551615}}'\n";
    for trial in trials(answer, &[]) {
        assert_eq!(trial.record.outcome, TrialOutcome::Garbled);
        assert!(said(&trial).contains("which is too large"), "{}", said(&trial));
    }
}

#[test]
fn a_scenario_or_a_program_that_changes_ends_the_campaign_before_its_next_trial() {
    let folder = folder();
    let path = folder.path();
    assert_eq!(run(path, &["scenario", "new", "mine"]).status.code(), Some(0));
    let scenario = path.join("mine/scenario.yaml");
    let edit = format!("echo '# edited' >> {}\n", scenario.display());
    let planner = script(path, "editor.sh", &edit);
    let output = run(path, &words(&planner, &["--scenarios", "./mine"]));
    assert_eq!(output.status.code(), Some(2), "{}", error(&output));
    assert!(error(&output).contains("has changed since the campaign began"), "{}", error(&output));
    assert_eq!(stored(path).len(), 1);
    let planner = script(path, "self.sh", "echo '# edited' >> \"$0\"\n");
    let output = run(path, &words(&planner, &["-o", "other.db"]));
    assert_eq!(output.status.code(), Some(2), "{}", error(&output));
    assert!(error(&output).contains("differs from that of the trial"), "{}", error(&output));
}

#[test]
fn results_of_somebody_else_run_no_command_unasked() {
    let folder = folder();
    let path = folder.path();
    let planner = script(path, "touch.sh", &format!("touch {}\n", path.join("touched").display()));
    assert_eq!(run(path, &words(&planner, &[])).status.code(), Some(0));
    std::fs::remove_file(path.join("touched")).expect("it ran");
    let output = run(path, &["bench", "replay", "results.db", "1"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        error(&output).contains("--allow-exec") && error(&output).contains("touch.sh"),
        "{}",
        error(&output)
    );
    assert!(!path.join("touched").exists());
    let again = ["bench", "replay", "results.db", "1", "--allow-exec", "--sandbox", "off"];
    assert_eq!(run(path, &again).status.code(), Some(0));
    assert!(path.join("touched").exists());
    script(path, "touch.sh", "exit 0\n");
    let output = run(path, &again);
    assert!(output.status.code() == Some(2) && error(&output).contains("has changed"), "{}", error(&output));
}

#[test]
fn nothing_that_one_trial_writes_is_there_for_the_next() {
    let memo = "for place in . \"$TMPDIR\" \"$1\"; do test -e \"$place/memo\" && echo found; done\n\
                for place in . \"$TMPDIR\" \"$1\"; do touch \"$place/memo\"; done\n";
    let folder = folder();
    let planner = script(folder.path(), "memo.sh", memo) + " {scratch}";
    assert_eq!(run(folder.path(), &words(&planner, &["--runs", "3"])).status.code(), Some(0));
    for trial in stored(folder.path()) {
        assert_eq!(trial.record.outcome, TrialOutcome::GaveUp, "{}", said(&trial));
    }
    let folder = self::folder();
    let vandal = script(folder.path(), "vandal.sh", "chmod u+w \"$1\"; echo 1,2,3 > \"$1\"\n") + " {grasps}";
    let reader = script(folder.path(), "reader.sh", "head -1 \"$1\" | tr ',' '\\n' | wc -l >&2; exit 3\n")
        + " {grasps}";
    let output = run(folder.path(), &words(&vandal, &["--planner", &reader]));
    assert_eq!(output.status.code(), Some(0), "{}", error(&output));
    for trial in stored(folder.path()) {
        if trial.record.trial.planner == "vandal" {
            assert_eq!(trial.record.outcome, TrialOutcome::Garbled, "{}", said(&trial));
            assert!(said(&trial).contains("changed a file that it was given"), "{}", said(&trial));
        } else {
            let columns: u64 =
                said(&trial).rsplit(' ').next().and_then(|word| word.parse().ok()).unwrap_or(0);
            assert!(columns >= 16, "{}", said(&trial));
        }
    }
}

#[test]
fn nothing_that_a_planner_starts_outlives_its_trial_however_often_it_forks() {
    let (daemon, grandchild) = (sleep(1), sleep(2));
    let text = format!(
        "(setsid sh -c '{daemon} > /dev/null 2>&1 < /dev/null &' &)\nsetsid {grandchild} &\nexit 0\n"
    );
    trials(&text, &[]);
    assert!(!is_running(&daemon) && !is_running(&grandchild));
    // The same applies to a worker that is killed.
    let orphan = sleep(3);
    let text = format!("setsid {orphan} > /dev/null 2>&1 &\nsleep 0.3\n{KILL_WORKER}\n{orphan}\n");
    for trial in trials(&text, &[]) {
        assert_eq!(trial.record.outcome, TrialOutcome::Killed, "{}", said(&trial));
    }
    assert!(!is_running(&orphan));
}

#[test]
fn memory_counts_wherever_it_is_held() {
    let hog = "import os, time\nos.fork() and os._exit(0)\nos.setsid()\nheld = bytearray(400 << 20)\ntime.sleep(60)\n";
    let folder = folder();
    std::fs::write(folder.path().join("hog.py"), hog).expect("written");
    let planner =
        script(folder.path(), "hog.sh", &format!("python3 {}/hog.py &\nsleep 60\n", folder.path().display()));
    let output = run(folder.path(), &words(&planner, &["--memory-limit", "200", "--runs", "1"]));
    assert_eq!(output.status.code(), Some(0), "{}", error(&output));
    let trials = stored(folder.path());
    assert_eq!(trials[0].record.outcome, TrialOutcome::OutOfMemory, "{}", said(&trials[0]));
}

#[test]
fn trials_of_killed_workers_are_run_again_when_asked() {
    let folder = folder();
    let path = folder.path();
    let text = format!("test -e {0} || {KILL_WORKER}\nexit 0\n", path.join("calm").display());
    let planner = script(path, "fragile.sh", &text);
    let outcomes = || stored(path).iter().map(|trial| trial.record.outcome).collect::<Vec<_>>();
    assert_eq!(run(path, &words(&planner, &[])).status.code(), Some(0));
    assert_eq!(outcomes(), [TrialOutcome::Killed; 2]);
    std::fs::write(path.join("calm"), "").expect("written");
    assert_eq!(run(path, &words(&planner, &[])).status.code(), Some(0));
    assert_eq!(outcomes(), [TrialOutcome::Killed; 2]);
    assert_eq!(run(path, &words(&planner, &["--again", "killed,crashed"])).status.code(), Some(0));
    assert_eq!(outcomes(), [TrialOutcome::GaveUp; 2]);
    let output = run(path, &words(&planner, &["--again", "kiled"]));
    assert!(
        output.status.code() == Some(2) && error(&output).contains("out-of-memory"),
        "{}",
        error(&output)
    );
}

/// Reports of a planner that solves some trials, and otherwise pretends that its iterations are spent, or kills its worker.
#[test]
fn nothing_is_gained_by_a_spent_budget_or_a_killed_worker() {
    let pretence = "echo '{\"outcome\": \"budget-exhausted\", \"statistics\": {\"iterations\": 1000}}'\n";
    for (text, outcome, says) in [
        (pretence, TrialOutcome::GaveUp, "whatever the program states about its iterations"),
        (&format!("{KILL_WORKER}\nsleep 5\n"), TrialOutcome::Killed, "a signal killed their worker"),
    ] {
        let folder = folder();
        let path = folder.path();
        let planner = script(path, "cheat.sh", text);
        let limits = ["--runs", "3", "--iterations", "1000", "--time-limit", "5"];
        assert_eq!(run(path, &words(&planner, &limits)).status.code(), Some(0));
        assert!(stored(path).iter().all(|trial| trial.record.outcome == outcome), "{:?}", stored(path));
        let output = run(path, &["bench", "report", "results.db", "-o", "report.json"]);
        assert_eq!(output.status.code(), Some(0), "{}", error(&output));
        let report = std::fs::read_to_string(path.join("report.json")).expect("a report");
        let report: serde_json::Value = serde_json::from_str(&report).expect("JSON");
        assert_eq!(report["rows"][0]["restricted_mean_s"], 5.0, "{report}");
        assert!(report["warnings"].to_string().contains(says), "{report}");
    }
}

/// Judging such paths takes longer than all trials of a campaign.
#[test]
fn a_path_that_is_expensive_to_judge_is_refused_at_once() {
    let many = "yes 0,0,0,0,0,0,0,0,0 | head -150000\n";
    for trial in trials(many, &["--time-limit", "5"]) {
        assert_eq!(trial.record.outcome, TrialOutcome::Garbled, "{}", said(&trial));
        assert!(said(&trial).contains("150000 way points, but at most 10000"), "{}", said(&trial));
    }
    let far = "paste -sd, \"$1\"\necho 1000000,0,0,0,0,0,0,0,0\npaste -sd, \"$1\"\n";
    let folder = folder();
    let planner = script(folder.path(), "far.sh", far) + " {start}";
    let output = run(folder.path(), &words(&planner, &["--time-limit", "5"]));
    assert_eq!(output.status.code(), Some(0), "{}", error(&output));
    for trial in stored(folder.path()) {
        assert_eq!(trial.record.outcome, TrialOutcome::Rejected, "{}", said(&trial));
        assert!(said(&trial).contains("beyond its limit"), "{}", said(&trial));
    }
}

#[test]
fn two_campaigns_do_not_write_one_file_and_either_can_be_told_to_end() {
    let folder = folder();
    let path = folder.path();
    let planner = script(path, "slow.sh", &format!("touch {}\nsleep 30\n", path.join("begun").display()));
    let mut first = begin(path, &words(&planner, &[]));
    let waiting = Instant::now();
    while !path.join("begun").exists() && waiting.elapsed() < Duration::from_mins(1) {
        std::thread::sleep(Duration::from_millis(20));
    }
    let second = run(path, &words(&planner, &[]));
    assert_eq!(second.status.code(), Some(2), "{}", error(&second));
    assert!(error(&second).contains("another campaign is writing"), "{}", error(&second));
    let id = first.id().to_string();
    assert!(Process::new("kill").args(["-TERM", &id]).status().expect("kill").success());
    let status = first.wait().expect("it ends");
    assert_eq!(status.code(), Some(1), "stopped, and said so");
    assert_eq!(stored(path).len(), 0);
}

#[test]
fn paths_that_are_the_same_under_other_seeds_are_said() {
    let folder = folder();
    let path = folder.path();
    assert_eq!(run(path, &["plan", "031", "-q", "-o", "031.plan.json"]).status.code(), Some(0));
    let plan = std::fs::read(path.join("031.plan.json")).expect("a plan");
    let plan: serde_json::Value = serde_json::from_slice(&plan).expect("JSON");
    let answer = serde_json::json!({"waypoints": plan["waypoints"]});
    let planner = script(path, "memory.sh", &format!("echo '{answer}'\n"));
    assert_eq!(run(path, &words(&planner, &["--runs", "4"])).status.code(), Some(0));
    assert!(stored(path).iter().all(|trial| trial.record.is_solved()));
    let output = run(path, &["bench", "report", "results.db", "-o", "report.json"]);
    assert_eq!(output.status.code(), Some(0), "{}", error(&output));
    let report = std::fs::read_to_string(path.join("report.json")).expect("a report");
    assert!(
        report.contains("Paths of memory are the same as under another seed: 4 of 4 in 031."),
        "{report}"
    );
}

/// Runs a script in the full sandbox and returns its trials; prints a note and returns `None` if the kernel lacks a mechanism.
fn trials_within_walls(text: &str, more: &[&str]) -> Option<Vec<StoredTrial>> {
    let folder = folder();
    let planner = script(folder.path(), "cheat.sh", text);
    let output = run(folder.path(), &words(&planner, &[&["--sandbox", "require"], more].concat()));
    if error(&output).contains("this machine has no") {
        writeln!(std::io::stderr(), "SKIPPED, walls around planners: {}", error(&output)).expect("said");
        return None;
    }
    assert_eq!(output.status.code(), Some(0), "{}", error(&output));
    Some(stored(folder.path()))
}

#[test]
fn within_walls_a_planner_writes_in_its_own_folder_alone() {
    let elsewhere = folder();
    let place = elsewhere.path().join("memo");
    let text =
        format!("touch scratch \"$TMPDIR/too\" || echo no scratch\ntouch {}\nexit 3\n", place.display());
    for trial in trials_within_walls(&text, &[]).unwrap_or_default() {
        assert_eq!(trial.record.outcome, TrialOutcome::Crashed, "{}", said(&trial));
        assert!(
            said(&trial).contains("ead-only file system") && said(&trial).contains("--sandbox off"),
            "{}",
            said(&trial)
        );
    }
    assert!(!place.exists());
}

#[test]
fn within_walls_a_planner_sees_no_process_but_its_own_and_ends_none() {
    let text = "test \"$(ls -d /proc/[0-9]* | wc -l)\" -lt 6 || echo sees others\nkill -9 $PPID 1\nexit 0\n";
    for trial in trials_within_walls(text, &[]).unwrap_or_default() {
        assert_eq!(trial.record.outcome, TrialOutcome::GaveUp, "{}", said(&trial));
    }
}

#[test]
fn within_walls_shared_memory_is_counted_and_gone_after_the_trial() {
    let text = "test -e /dev/shm/memo && echo found\ntouch /dev/shm/memo || echo no shared memory\nexit 0\n";
    for trial in trials_within_walls(text, &[]).unwrap_or_default() {
        assert_eq!(trial.record.outcome, TrialOutcome::GaveUp, "{}", said(&trial));
    }
    let text = "head -c 150M /dev/zero > /dev/shm/one\nhead -c 40M /dev/zero > /dev/shm/two\nsleep 30\n";
    for trial in trials_within_walls(text, &["--memory-limit", "180"]).unwrap_or_default() {
        assert_eq!(trial.record.outcome, TrialOutcome::OutOfMemory, "{}", said(&trial));
        assert!(trial.record.memory_bytes.is_some_and(|bytes| bytes > 180_000_000));
    }
}
