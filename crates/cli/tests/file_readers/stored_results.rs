use std::fs;
use std::path::Path;

use cranny_bench::{Results, RunInformation, ScenarioSource, Trial, TrialOutcome, TrialRecord};
use cranny_plan::Statistics;
use cranny_task::Criterion;

/// Reads modified sound results. Three bytes of the file are a change: a position in 65 536ths of the results, and a new byte.
pub fn read(folder: &Path) {
    let (sound, path) = (folder.join("sound.db"), folder.join("results.db"));
    if !sound.is_file() {
        write(&sound);
    }
    for ending in ["-wal", "-shm"] {
        let _ = fs::remove_file(folder.join(format!("results.db{ending}")));
    }
    let mut content = fs::read(&sound).expect("sound results");
    for change in fs::read(folder.join("results.changes")).unwrap_or_default().chunks_exact(3) {
        let share = usize::from(u16::from_le_bytes([change[0], change[1]]));
        let at = (share * content.len()) >> 16;
        content[at] = change[2];
    }
    fs::write(&path, content).expect("a file to read");
    let Ok(results) = Results::open(&path) else { return };
    let _ = (results.records(), results.count(), results.runs(), results.scenarios());
    for stored in results.trials().unwrap_or_default() {
        let _ = (results.trial(stored.id), results.path_of(stored.id));
    }
    let _ = results.planner_source("reach", "{}");
}

fn write(path: &Path) {
    let mut results = Results::create(path).expect("results");
    let run =
        results.begin_run(&RunInformation::here(Some("0123abcd"), "cranny bench run", 1)).expect("a run");
    for seed in 0..3 {
        let record = TrialRecord {
            trial: Trial {
                scenario: "021".into(),
                scenario_hash: "ab".repeat(32),
                planner: "reach".into(),
                settings: "{}".into(),
                criterion: Criterion::Exact,
                seed,
                time_limit_s: 120.0,
                iteration_limit: None,
                goal: None,
            },
            outcome: TrialOutcome::Solved,
            detail: Some("edge 3".into()),
            statistics: Statistics::default(),
            path_length: Some(1.5),
            clearance_m: None,
            grasp: Some(17),
            grasp_score: Some(0.9),
            also_solved: Some(true),
            memory_bytes: Some(1 << 30),
        };
        assert!(results.append(run, &record, &[vec![0.0, 1.0], vec![0.5, 0.25]]).expect("appended"));
    }
    let source = ScenarioSource {
        scenario: "021".into(),
        scenario_hash: "ab".repeat(32),
        source: "021".into(),
        goals: None,
    };
    results.note_scenario(&source).expect("noted");
    results.note_planner("reach", "{}", "\"reach\"").expect("noted");
    results.end_run(run).expect("ended");
}
