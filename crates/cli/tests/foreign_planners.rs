//! External planners beside the built-in ones: their behaviour is recorded correctly.

use std::path::{Path, PathBuf};
use std::process::Output;

use assert_cmd::Command;
use cranny_bench::{Results, StoredTrial, TrialOutcome};

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

fn run(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::cargo_bin("cranny").expect("the program");
    command
        .current_dir(folder)
        .args(["bench", "run", "-o", "results.db"])
        .args(arguments)
        .output()
        .expect("it runs")
}

/// Runs planners that are shell scripts in 031, two seeds each, and returns the trials.
fn trials_of(scripts: &[&str], limits: &[&str]) -> Vec<StoredTrial> {
    let folder = folder();
    let mut arguments: Vec<String> = ["--scenarios", "031", "--runs", "2"].map(str::to_owned).into();
    for (index, script) in scripts.iter().enumerate() {
        let name = format!("script-{index}.sh");
        std::fs::write(folder.path().join(&name), script).expect("written");
        arguments.push("--planner".into());
        arguments.push(format!("p{index}=exec:sh {name} {{start}}"));
    }
    let words: Vec<&str> = arguments.iter().map(String::as_str).chain(limits.iter().copied()).collect();
    let output = run(folder.path(), &words);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let trials = Results::open(&folder.path().join("results.db")).expect("results").trials().expect("trials");
    assert_eq!(trials.len(), 2 * scripts.len());
    trials
}

fn assert_each(trials: &[StoredTrial], planner: &str, outcome: TrialOutcome, word: &str) {
    let own: Vec<&StoredTrial> =
        trials.iter().filter(|trial| trial.record.trial.planner == planner).collect();
    assert_eq!(own.len(), 2);
    for trial in own {
        let detail = trial.record.detail.as_deref().unwrap_or_default();
        assert_eq!(trial.record.outcome, outcome, "{planner}: {detail}");
        assert!(detail.contains(word), "{planner}: no '{word}' in '{detail}'");
        assert!(trial.record.path_length.is_none() && trial.record.statistics.planning_time_s > 0.0);
    }
}

/// Within namespaces each worker is process 1, so its process id does not identify a folder.
#[test]
fn workers_beside_each_other_do_not_write_over_each_others_files() {
    let folder = folder();
    let script = "cat \"$2\" > /dev/null || exit 3\npaste -sd, \"$1\"\n";
    std::fs::write(folder.path().join("reader.sh"), script).expect("written");
    let program = "reader=exec:sh reader.sh {start} {obstacles}";
    let limits = ["--runs", "4", "--workers", "4", "--time-limit", "10"];
    let output = run(folder.path(), &[&["--scenarios", "01x", "--planner", program][..], &limits].concat());
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let trials = Results::open(&folder.path().join("results.db")).expect("results").trials().expect("trials");
    assert_eq!(trials.len(), 20);
    // Each planner read its files, and its path was judged.
    assert!(trials.iter().all(|trial| trial.record.outcome == TrialOutcome::Rejected), "{trials:?}");
}

#[test]
fn a_planner_that_misbehaves_is_recorded_as_what_it_does() {
    let start = "paste -sd, \"$1\"\n";
    let far = format!("{start}echo 0.6,1,-0.0178,-0.7601,0.0198,-2.3421,0.0298,1.5412,0.7534\n");
    // A duration that no other process uses.
    let sleep = format!("sleep {}", 1_000_000 + u64::from(std::process::id()));
    let elsewhere = "echo 0,0,0,0,0,0,0,0,0\n";
    // Answers only a program that requests it.
    let segments = |mode: &str| {
        let segment = format!(
            r#"{{"kind": "polyline", "mode": "{mode}", "waypoints": [[0, 0, 0, 0, 0, 0, 0, 0, 0]]}}"#
        );
        format!(
            "grep -q '\"protocols\":\\[1,2\\]' && echo '{{\"protocol\": 2, \"segments\": [{segment}]}}'\n"
        )
    };
    let trials = trials_of(
        &[
            "echo cannot load >&2; exit 3\n",
            "kill -SEGV $$\n",
            &format!("{sleep}\n"),
            &format!("sh -c '{sleep}' & wait\n"),
            "echo once upon a time\n",
            "echo 1,2,3\n",
            "yes 0,0,0,0,0,0,0,0,0\n",
            &far,
            elsewhere,
            "exit 0\n",
            "cat > /dev/null; echo '{\"outcome\": \"no-reachable-grasp\", \"statistics\": {\"iterations\": 5}}'\n",
            &segments("reach"),
            &segments("carry"),
            "sleep 0.6; echo '{\"outcome\": \"no-reachable-grasp\"}'\n",
            "echo '{\"outcome\": \"gave-up\", \"waypoints\": [[0, 0, 0, 0, 0, 0, 0, 0, 0]]}'\n",
        ],
        &["--time-limit", "0.5"],
    );
    assert_each(&trials, "p0", TrialOutcome::Crashed, "exit code 3: cannot load");
    assert_each(&trials, "p1", TrialOutcome::Crashed, "signal 11");
    assert_each(&trials, "p2", TrialOutcome::Hung, "ended after 1.5");
    assert_each(&trials, "p3", TrialOutcome::Hung, "ended after 1.5");
    assert_each(&trials, "p4", TrialOutcome::Garbled, "line 1: 'once upon a time'");
    assert_each(&trials, "p5", TrialOutcome::Garbled, "3 numbers instead of 9");
    // Endless output: any of the limits may end it.
    assert!(trials.iter().filter(|trial| trial.record.trial.planner == "p6").all(|trial| matches!(
        trial.record.outcome,
        TrialOutcome::Garbled | TrialOutcome::Hung | TrialOutcome::Crashed
    )));
    assert_each(&trials, "p7", TrialOutcome::Rejected, "deep in left wall");
    assert_each(&trials, "p8", TrialOutcome::Rejected, "off the start");
    assert_each(&trials, "p9", TrialOutcome::GaveUp, "without a path");
    assert_each(&trials, "p10", TrialOutcome::NoReachableGrasp, "it states 'no-reachable-grasp'");
    assert_each(&trials, "p11", TrialOutcome::Rejected, "off the start");
    assert_each(&trials, "p12", TrialOutcome::Garbled, "holds an object that was not picked");
    assert_each(&trials, "p13", TrialOutcome::BudgetExhausted, "it states 'no-reachable-grasp'");
    assert_each(&trials, "p14", TrialOutcome::Garbled, "'gave-up', but there are way points");
    assert!(trials.iter().any(|trial| trial.record.statistics.iterations == 5));
    // No process is left running.
    let listing = std::process::Command::new("ps").args(["-eo", "args"]).output().expect("ps");
    let listing = String::from_utf8_lossy(&listing.stdout).into_owned();
    assert!(!listing.lines().any(|line| line == sleep), "a planner's child is still there");
}

#[test]
fn a_planner_may_carry_the_target_home_and_is_believed_nothing() {
    let folder = folder();
    let plan = Command::cargo_bin("cranny")
        .expect("the program")
        .current_dir(folder.path())
        .args(["plan", "031", "--carry", "home", "-q", "-o", "031.plan.json"])
        .output()
        .expect("it runs");
    assert_eq!(plan.status.code(), Some(0), "{}", String::from_utf8_lossy(&plan.stderr));
    let plan: serde_json::Value =
        serde_json::from_slice(&std::fs::read(folder.path().join("031.plan.json")).expect("a plan"))
            .expect("JSON");
    let answer = |change: &dyn Fn(&mut serde_json::Value)| {
        let mut segments = plan["segments"].clone();
        change(&mut segments);
        // Answers only a program that requests a carry and describes it.
        format!(
            "grep -q '\"carry\":{{\"clear_m\":null.*\"to\":\"home\".*\"target\":\"box\"' && echo '{}'\n",
            serde_json::json!({"protocol": 2, "segments": segments})
        )
    };
    let reach = format!("echo '{}'\n", serde_json::json!({"waypoints": plan["segments"][0]["waypoints"]}));
    let trials = trials_of(
        &[
            &answer(&|_| {}),
            &answer(&|segments| segments[1]["opening_m"] = 0.001.into()),
            &answer(&|segments| {
                let carry = segments[2].as_object_mut().expect("a segment");
                carry.remove("corners");
                carry["waypoints"].as_array_mut().expect("way points").truncate(1);
            }),
            &reach,
        ],
        &["--carry", "home"],
    );
    for trial in trials.iter().filter(|trial| trial.record.trial.planner == "p0") {
        assert_eq!(trial.record.outcome, TrialOutcome::Solved, "{:?}", trial.record.detail);
        assert!(trial.record.grasp.is_some() && trial.record.trial.settings.contains(r#""carry":"home""#));
    }
    assert_each(&trials, "p1", TrialOutcome::Rejected, "the hand holds");
    assert_each(&trials, "p2", TrialOutcome::Rejected, "off the nearest goal");
    assert_each(&trials, "p3", TrialOutcome::Garbled, "the task continues with the target in the hand");
}

#[cfg(target_os = "linux")]
#[test]
fn a_planner_that_eats_memory_is_ended() {
    let trials = trials_of(
        &["awk 'BEGIN {s = \"xxxxxxxxxxxxxxxx\"; while (1) s = s s}'\n"],
        &["--memory-limit", "100", "--time-limit", "20"],
    );
    assert_each(&trials, "p0", TrialOutcome::OutOfMemory, " MB");
}

#[test]
fn the_released_program_s_command_line_and_files_are_understood() {
    // A stand-in that checks its command line and moves straight from the start to the given goal.
    let script = "#!/bin/sh
[ \"$1\" = test ] || exit 9
shift
while [ $# -gt 1 ]; do
  case $1 in
    -start_config) start=$2 ;; -target_prefix) prefix=$2 ;; -grasp) grasp=$2 ;; -urdf) urdf=$2 ;;
    -obstacle) obstacle=$2 ;; -target_configs) ik=$2 ;; -planner) planner=$2 ;; -seed) seed=$2 ;;
  esac
  shift 2
done
for file in \"$start\" \"$grasp\" \"$urdf\" \"$obstacle\" \"$ik\"; do [ -s \"$file\" ] || exit 8; done
[ \"$planner\" = 5 ] || exit 7
paste -sd, \"$start\" > $prefix.try
echo \"{\\\"sr\\\": $((seed == 0)), \\\"dtg\\\": 1.5, \\\"time\\\": 0.1, \\\"iters\\\": 12, \\\"treesize\\\": 10}\" > $prefix.txt
";
    let folder = folder();
    let program = folder.path().join("burs_of_free_space");
    std::fs::write(&program, script).expect("written");
    let mode = std::os::unix::fs::PermissionsExt::from_mode(0o755);
    std::fs::set_permissions(&program, mode).expect("executable");
    let arguments = [
        "--scenarios",
        "011",
        "--planner",
        "released:./burs_of_free_space -planner 5",
        "--criterion",
        "paper",
        "--runs",
        "2",
    ];
    let output = run(folder.path(), &arguments);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let trials = Results::open(&folder.path().join("results.db")).expect("results").trials().expect("trials");
    let told: Vec<_> =
        trials.iter().map(|trial| (trial.record.outcome, trial.record.statistics.iterations)).collect();
    // The first gave a path that does not end at a grasp; the second gave none.
    assert_eq!(told, [(TrialOutcome::Rejected, 12), (TrialOutcome::GaveUp, 12)], "{trials:?}");
    assert_eq!(trials[0].record.trial.planner, "released:burs_of_free_space");
}

/// Folder of `examples/`.
fn example(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/exec_planner").join(name)
}

/// Returns true if a tool is installed; if not, the test prints a note and is skipped, unless skipping is forbidden.
fn has(program: &str, arguments: &[&str]) -> bool {
    let is_there = std::process::Command::new(program)
        .args(arguments)
        .output()
        .is_ok_and(|output| output.status.success());
    if !is_there {
        assert!(std::env::var_os("CRANNY_REQUIRE_ALL").is_none(), "{program} {arguments:?} does not run");
        eprintln!("SKIPPED: {program} {arguments:?} does not run, so its example is not tried");
    }
    is_there
}

/// Runs an example in a scenario, twice; every path must be valid. Returns its reported number of iterations.
fn assert_solves(scenario: &str, planner: &str, criterion: &str) -> u64 {
    let folder = folder();
    let limits = ["--criterion", criterion, "--runs", "2", "--time-limit", "120"];
    let arguments = [&["--scenarios", scenario, "--planner", planner][..], &limits[..]].concat();
    let output = run(folder.path(), &arguments);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let results = Results::open(&folder.path().join("results.db")).expect("results");
    let trials = results.trials().expect("trials");
    for trial in &trials {
        assert_eq!(trial.record.outcome, TrialOutcome::Solved, "{trial:?}");
    }
    trials.iter().map(|trial| trial.record.statistics.iterations).sum()
}

#[test]
fn the_example_in_python_solves_under_both_criteria() {
    // `cargo xtask test` sets up a Python with NumPy.
    let python = std::env::var("CRANNY_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    if !has(&python, &["-c", "import numpy"]) {
        return;
    }
    let planner = format!("exec:{python} {}", example("plain_rrt.py").display());
    let can = example("can").display().to_string();
    assert_solves(&can, &planner, "exact");
    assert_solves(&can, &planner, "paper");
    // With a beam above the can there is no straight path, so that a tree must grow.
    let folder = folder();
    let beam = "  - name: beam\n    pose: {position: [0.55, 0.0, 0.7]}\n    shapes: [{box: {size: [0.05, 1.0, 0.05]}}]\n";
    let yaml = std::fs::read_to_string(example("can/scenario.yaml")).expect("a scenario");
    std::fs::write(folder.path().join("scenario.yaml"), yaml.replace("target:", &format!("{beam}target:")))
        .expect("written");
    std::fs::copy(example("can/grasps.csv"), folder.path().join("grasps.csv")).expect("copied");
    assert!(assert_solves(&folder.path().display().to_string(), &planner, "paper") > 0);
}

#[test]
fn the_example_in_c_plus_plus_solves_a_gate() {
    if !has("c++", &["--version"]) {
        return;
    }
    let folder = folder();
    let program = folder.path().join("plain_rrt").display().to_string();
    let compiled = std::process::Command::new("c++")
        .args(["-O2", "-std=c++17", "-Wall", "-Wextra", "-Werror", "-o", &program])
        .arg(example("plain_rrt.cpp"))
        .output()
        .expect("a compiler");
    assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
    let planner = format!("exec:{program} {{start}} {{ik}} {{obstacles}} {{seed}} {{time_limit_s}}");
    assert_solves("041", &planner, "exact");
}
