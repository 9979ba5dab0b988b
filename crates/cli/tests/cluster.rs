//! Campaigns in shards: run manually, and in the long run as array tasks of a real Slurm of one node.

use std::path::{Path, PathBuf};
use std::process::{Command as Process, Output};
use std::time::{Duration, Instant};

use assert_cmd::Command;
use cranny_bench::Results;

const CAMPAIGN: &str = "scenarios: ['011', '041']\nplanners:\n  - planner: reach\nruns: 4\ntime_limit_s: 10\n\
                        memory_limit_mb: 512\n";

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(folder.path().join("campaign.yaml"), CAMPAIGN).expect("written");
    folder
}

/// Runs a command, checks its exit code and returns its output.
fn said(folder: &Path, words: &[&str], code: i32) -> String {
    let output = with(folder, words, &[]);
    assert_eq!(output.status.code(), Some(code), "{words:?}: {}", text(&output.stderr));
    text(&output.stdout) + &text(&output.stderr)
}

fn with(folder: &Path, words: &[&str], environment: &[(&str, PathBuf)]) -> Output {
    let mut command = Command::cargo_bin("cranny").expect("the program");
    command.current_dir(folder).args(words).envs(environment.iter().cloned()).output().expect("it runs")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Returns the machine-independent content of the results: trial, outcome, path.
fn trials(file: &Path) -> Vec<(String, Vec<Vec<f64>>)> {
    let results = Results::open(file).expect("results");
    let of_trial = |trial: cranny_bench::StoredTrial| {
        let path = results.path_of(trial.id).expect("a path");
        (format!("{} {}", trial.record.trial.key(), trial.record.outcome.name()), path)
    };
    let mut trials: Vec<_> = results.trials().expect("trials").into_iter().map(of_trial).collect();
    trials.sort_by(|a, b| a.0.cmp(&b.0));
    trials
}

#[test]
fn parts_that_are_run_one_by_one_give_the_same_whole() {
    let folder = folder();
    let path = folder.path();
    // The file of the progress replaces no other one.
    std::fs::write(path.join("notes.json"), "{\"mine\": 1}").expect("written");
    let run = ["bench", "run", "campaign.yaml", "--shard", "1/3"];
    let refused = said(path, &[&run[..], &["-o", "notes.db"]].concat(), 2);
    assert!(refused.contains("notes.json: exists already and is no progress"), "{refused}");
    let refused = said(path, &[&run[..], &["-o", "notes.db", "--standing", "./notes.db"]].concat(), 2);
    assert!(refused.contains("--standing") && !path.join("notes.db").exists(), "{refused}");
    for part in 1..=3 {
        let (shard, output) = (format!("{part}/3"), format!("part-{part}.db"));
        said(path, &["bench", "run", "campaign.yaml", "--shard", &shard, "-o", &output], 0);
        // One shard or two are not among the files.
        let status = said(path, &["bench", "status", "part-1.db", &output], 1);
        assert!(status.contains("100.0 %") && status.contains("  missing    "), "{status}");
    }
    let files = ["part-1.db", "part-2.db", "part-3.db"];
    let status = said(path, &[&["bench", "status"][..], &files].concat(), 0);
    assert!(status.contains("8 of 8 trials") && status.contains("done       3 of 3 tasks"), "{status}");
    let merged = said(path, &["bench", "merge", "part-1.db", "part-2.db", "-o", "two.db"], 0);
    assert!(merged.contains("No run of shard 3/3 is among these results"), "{merged}");
    let merged = said(path, &[&["bench", "merge"][..], &files, &["-o", "all.db"]].concat(), 0);
    assert!(!merged.contains("No run of shard"), "{merged}");
    said(path, &["bench", "run", "campaign.yaml", "-o", "one.db"], 0);
    assert_eq!(trials(&path.join("all.db")), trials(&path.join("one.db")));
    // The trials were run twice, with different times.
    let refused = said(path, &["bench", "merge", "one.db", "all.db"], 2);
    assert!(refused.contains("8 trials") && refused.contains("--keep-first"), "{refused}");
    said(path, &["bench", "merge", "one.db", "all.db", "--keep-first"], 0);
    // A shard without its progress file has an unknown number of trials.
    std::fs::remove_file(path.join("part-2.json")).expect("removed");
    let status = said(path, &["bench", "status", "part-1.db", "part-2.db"], 1);
    assert!(status.contains("unknown    1 of 3 tasks: part-2.db"), "{status}");
    assert!(status.contains("missing    1 of 3 tasks: 3/3"), "{status}");
}

#[test]
fn scripts_are_written_checked_and_never_written_over() {
    let folder = folder();
    let path = folder.path();
    let words = ["bench", "slurm", "campaign.yaml", "--array", "3", "--write-only", "-o", "it's here"];
    let page = said(path, &[&words[..], &["--", "--partition=short"]].concat(), 0);
    assert!(page.contains("--array=1-3 ") && page.contains("--partition=short"), "{page}");
    assert!(page.contains("afterany:JOB"), "{page}");
    let place = path.join("it's here");
    for script in ["task.sh", "report.sh"] {
        assert!(Process::new("sh").arg("-n").arg(place.join(script)).status().expect("sh").success());
    }
    // Runs an array task with the variables that Slurm sets.
    let task = |number: &str| {
        let mut task = Process::new("sh");
        task.arg(place.join("task.sh")).env("SLURM_ARRAY_TASK_ID", number).output().expect("it runs")
    };
    for number in ["1", "2", "3"] {
        let output = task(number);
        assert!(output.status.success(), "{}", text(&output.stderr));
    }
    assert!(Process::new("sh").arg(place.join("report.sh")).status().expect("sh").success());
    assert_eq!(Results::open(&place.join("results.db")).expect("results").count().expect("a count"), 8);
    assert!(place.join("report.html").exists());
    assert!(said(path, &words, 2).contains("contains a campaign already"));
    // The node refuses a campaign that differs from the submitted one.
    std::fs::write(path.join("campaign.yaml"), CAMPAIGN.replace("runs: 4", "runs: 5")).expect("written");
    let output = task("1");
    let refused = text(&output.stderr);
    assert!(output.status.code() == Some(2) && refused.contains("the list of trials"), "{refused}");
    assert!(
        said(path, &["bench", "slurm", "campaign.yaml", "--array", "99"], 2)
            .contains("at most as many tasks")
    );
    assert!(said(path, &["bench", "status", "."], 2).contains("campaign.json"));
}

/// Stands for sbatch and squeue: notes its arguments, and runs the script at once as the first array task.
const FAKE_SLURM: &str = "#!/bin/sh
case $0 in *squeue) exit 0 ;; esac
for word; do printf '%s\\n' \"$word\" >> \"$NOTES\"; script=$word; done
SLURM_ARRAY_TASK_ID=1 SLURM_JOB_ID=7 sh \"$script\" >> \"$NOTES.out\" 2>&1 || exit 1
echo 7
";

/// Creates the stand-in for Slurm; returns the search path of programs.
#[cfg(unix)]
fn fake_slurm(folder: &Path) -> PathBuf {
    use std::os::unix::fs::PermissionsExt as _;
    std::fs::create_dir(folder.join("bin")).expect("a folder");
    for name in ["sbatch", "squeue"] {
        let program = folder.join("bin").join(name);
        std::fs::write(&program, FAKE_SLURM).expect("written");
        std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o755)).expect("set");
    }
    let path = std::env::var("PATH").unwrap_or_default();
    PathBuf::from(format!("{}:{path}", folder.join("bin").display()))
}

#[cfg(unix)]
#[test]
fn a_name_that_a_shell_would_obey_is_a_name() {
    let folder = folder();
    let path = folder.path();
    let search = fake_slurm(path);
    let notes = path.join("notes");
    let environment = [("PATH", search), ("NOTES", notes.clone()), ("SCRATCH", path.join("node disk"))];
    std::fs::create_dir(path.join("node disk")).expect("a folder");
    let names = ["it's $HOME `touch stolen` 50%a \"x\" ;touch stolen", "-x", "größer 箱", "$(touch stolen)"];
    for name in names {
        let file = format!("{name}.yaml");
        std::fs::write(path.join(&file), CAMPAIGN.replace("runs: 4", "runs: 1")).expect("written");
        let file = format!("./{file}");
        let output = format!("--output={name}");
        let words = ["bench", "slurm", &file, "--array", "1", &output, "--local", "$SCRATCH/it's"];
        let submitted = with(path, &words, &environment);
        let said = text(&std::fs::read(notes.with_extension("out")).unwrap_or_default());
        assert_eq!(submitted.status.code(), Some(0), "{name}: {}{said}", text(&submitted.stderr));
        let results = Results::open(&path.join(name).join("results.db")).expect("results");
        assert_eq!(results.count().expect("a count"), 2, "{name}");
        assert!(path.join(name).join("report.html").exists(), "{name}");
        for place in [path, &path.join(name)] {
            assert!(!place.join("stolen").exists(), "{name} was obeyed");
        }
        let pattern = name.replace('%', "%%");
        let noted = std::fs::read_to_string(&notes).expect("notes");
        assert!(noted.contains(&format!("/{pattern}/log/%a.txt\n")), "{noted}");
    }
}

/// A campaign that is killed leaves a log, which is written back before the results are copied from the disk of the node.
#[cfg(unix)]
#[test]
fn results_on_the_disk_of_a_node_are_written_back_with_their_log() {
    let folder = folder();
    let path = folder.path();
    let words =
        ["bench", "slurm", "campaign.yaml", "--array", "1", "--write-only", "-o", "set", "--local", "$NODE"];
    let written = with(path, &words, &[]);
    assert_eq!(written.status.code(), Some(0), "{}", text(&written.stderr));
    let script = std::fs::read_to_string(path.join("set/task.sh")).expect("a script");
    let line = script.lines().find(|line| line.contains(" bench status ")).expect("a line");
    let program = line.split(" bench status ").next().unwrap_or_default();
    assert!(script.contains(&format!("{program} bench run ")), "{script}");
    assert!(!script.contains("{program}"), "{script}");
}

#[cfg(unix)]
#[test]
fn a_path_that_no_script_can_contain_is_refused_before_anything_is_written() {
    use std::os::unix::ffi::OsStrExt as _;
    let folder = folder();
    let bytes: [&[u8]; 4] = [b"a\ntouch stolen\n", b"a\r#SBATCH -x", b"a\xff", b"a\\b"];
    for name in bytes {
        let name = std::ffi::OsStr::from_bytes(name);
        let mut command = Command::cargo_bin("cranny").expect("the program");
        command.current_dir(folder.path()).args([
            "bench",
            "slurm",
            "campaign.yaml",
            "--array",
            "2",
            "--write-only",
            "-o",
        ]);
        let output = command.arg(name).output().expect("it runs");
        assert_eq!(output.status.code(), Some(2), "{name:?}: {}", text(&output.stderr));
        assert!(!folder.path().join(name).exists(), "{name:?}");
    }
    let words =
        ["bench", "slurm", "campaign.yaml", "--array", "2", "--write-only", "--local", "$(touch stolen)"];
    assert!(said(folder.path(), &words, 2).contains("the name of a variable"));
}

#[test]
fn without_slurm_it_is_said_what_to_do() {
    let folder = folder();
    let words = ["bench", "slurm", "campaign.yaml", "--array", "2"];
    let output = with(folder.path(), &words, &[("PATH", folder.path().to_owned())]);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("sbatch") && said.contains("--write-only"), "{said}");
}

/// Slurm of one node, stopped at the end of the test.
struct Slurm {
    folder: tempfile::TempDir,
}

impl Slurm {
    const SCRIPT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../xtask/slurm/one_node.sh");

    /// Starts Slurm; prints a note and returns `None` if it is not available.
    fn start() -> Option<Self> {
        let slurm = Self { folder: tempfile::tempdir().expect("a temporary folder") };
        let output = slurm.act("start");
        if output.status.success() {
            return Some(slurm);
        }
        let reason = text(&output.stderr);
        assert!(std::env::var_os("CRANNY_REQUIRE_ALL").is_none(), "no Slurm: {reason}");
        use std::io::Write as _;
        writeln!(std::io::stderr(), "SKIPPED, campaigns on a real Slurm: {reason}").expect("said");
        None
    }

    fn act(&self, action: &str) -> Output {
        let mut script = Process::new("sh");
        script.args([Self::SCRIPT, action]).arg(self.folder.path()).output().expect("sh")
    }

    fn environment(&self) -> [(&'static str, PathBuf); 1] {
        [("SLURM_CONF", self.folder.path().join("slurm.conf"))]
    }

    fn said(&self, folder: &Path, words: &[&str]) -> String {
        let output = with(folder, words, &self.environment());
        text(&output.stdout) + &text(&output.stderr)
    }

    fn cancel(&self, task: &str) {
        let mut scancel = Process::new("scancel");
        let status = scancel.arg(task).envs(self.environment()).status().expect("scancel");
        assert!(status.success());
    }
}

impl Drop for Slurm {
    fn drop(&mut self) {
        self.act("stop");
    }
}

/// Polls the status until it contains the expected text.
fn wait_for(slurm: &Slurm, folder: &Path, wanted: impl Fn(&str) -> bool) -> String {
    let begin = Instant::now();
    loop {
        let status = slurm.said(folder, &["bench", "status", "grid"]);
        if wanted(&status) {
            return status;
        }
        assert!(begin.elapsed() < Duration::from_mins(5), "{status}");
        std::thread::sleep(Duration::from_millis(200));
    }
}

#[test]
fn an_array_with_killed_tasks_and_a_restarted_controller_is_made_whole() {
    if std::env::var_os("CRANNY_LONG").is_none() {
        return;
    }
    let Some(slurm) = Slurm::start() else { return };
    let folder = folder();
    let path = folder.path();
    std::fs::write(path.join("campaign.yaml"), CAMPAIGN.replace("runs: 4", "runs: 200")).expect("written");
    let page = slurm.said(path, &["bench", "slurm", "campaign.yaml", "--array", "8", "-o", "grid"]);
    let job = page.split("job ").nth(1).and_then(|rest| rest.split(' ').next()).expect(&page).to_owned();
    wait_for(&slurm, path, |status| status.contains("done"));
    for task in [6, 7, 8] {
        slurm.cancel(&format!("{job}_{task}"));
    }
    assert!(slurm.act("restart").status.success());
    let is_over = |status: &str| !status.contains("running") && !status.contains("waiting");
    let status = wait_for(&slurm, path, is_over);
    assert!(status.contains("--resume"), "{status}");
    slurm.said(path, &["bench", "slurm", "--resume", "grid"]);
    wait_for(&slurm, path, |status| status.contains("8 of 8 tasks"));
    let begin = Instant::now();
    let results = path.join("grid/results.db");
    let is_whole = || {
        Results::glance(&results).is_ok_and(|all| all.values().map(|tally| tally.ended).sum::<usize>() == 400)
    };
    while !(is_whole() && path.join("grid/report.html").exists()) {
        assert!(begin.elapsed() < Duration::from_mins(2), "no report of all tasks");
        std::thread::sleep(Duration::from_millis(200));
    }
    said(path, &["bench", "run", "campaign.yaml", "-o", "one.db"], 0);
    assert_eq!(trials(&results), trials(&path.join("one.db")));
}
