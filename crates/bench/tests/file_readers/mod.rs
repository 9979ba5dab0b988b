//! The ways in for what a campaign reads: its file, the answers of other people's programs, stored results. The fuzz
//! targets (`fuzz/`) and `any_bytes.rs` both feed them with what is none of these; a reader may refuse it, but must
//! come back. Those of scenarios are listed in `crates/scenario/tests/file_readers`.

use std::fs;
use std::path::{Path, PathBuf};

use cranny_bench::{
    Campaign, Results, RunInformation, ScenarioSource, Trial, TrialOutcome, TrialRecord, read_output,
    read_released,
};
use cranny_plan::{Criterion, Statistics};

/// A reader of one kind of file.
pub struct FileReader {
    /// What its fuzz target is called.
    pub name: &'static str,
    /// Input that it takes.
    pub sound: &'static [u8],
    /// Reads the input, in a folder of its own.
    read: fn(&Path, &[u8]),
}

/// All of them.
pub const FILE_READERS: [FileReader; 4] = [
    FileReader { name: "campaign", sound: include_bytes!("sound/campaign"), read: read_campaign },
    FileReader { name: "exec_answer", sound: include_bytes!("sound/exec_answer"), read: read_answer },
    FileReader {
        name: "released_answer",
        sound: include_bytes!("sound/released_answer"),
        read: read_released_answer,
    },
    FileReader { name: "results", sound: include_bytes!("sound/results"), read: read_results },
];

fn read_campaign(folder: &Path, bytes: &[u8]) {
    let path = folder.join("campaign.yaml");
    fs::write(&path, bytes).expect("a file to read");
    let _ = Campaign::read(&path);
}

fn read_answer(_: &Path, bytes: &[u8]) {
    let _ = read_output(bytes, 2);
}

/// The summary, and after a line `===` the way points.
fn read_released_answer(folder: &Path, bytes: &[u8]) {
    let separator = b"===\n";
    let at = bytes.windows(separator.len()).position(|window| window == separator);
    let (summary, path) = at.map_or((bytes, &b""[..]), |at| (&bytes[..at], &bytes[at + separator.len()..]));
    fs::write(folder.join("trial.txt"), summary).expect("a file to read");
    fs::write(folder.join("trial.try"), path).expect("a file to read");
    let _ = read_released(&folder.join("trial"), 2);
}

/// Every three bytes change the sound results: two say where, in 65 536ths of the file, one what stands there then.
fn read_results(folder: &Path, bytes: &[u8]) {
    let (sound, path) = (folder.join("sound.db"), folder.join("results.db"));
    if !sound.is_file() {
        write_results(&sound);
    }
    for ending in ["-wal", "-shm"] {
        let _ = fs::remove_file(folder.join(format!("results.db{ending}")));
    }
    let mut content = fs::read(&sound).expect("sound results");
    for change in bytes.chunks_exact(3) {
        let share = usize::from(u16::from_le_bytes([change[0], change[1]]));
        let at = (share * content.len()) >> 16;
        content[at] = change[2];
    }
    fs::write(&path, content).expect("a file to read");
    let Ok(results) = Results::open(&path) else { return };
    let _ = (results.records(), results.known(), results.runs(), results.scenarios());
    for stored in results.trials().unwrap_or_default() {
        let _ = (results.trial(stored.id), results.path_of(stored.id));
    }
    let _ = results.planner_source("reach", "{}");
}

fn write_results(path: &Path) {
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
        };
        assert!(
            results.append(run, &record, Some(true), &[vec![0.0, 1.0], vec![0.5, 0.25]]).expect("appended")
        );
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

/// A reader, with a folder of its own.
pub struct ReaderAtWork {
    reader: &'static FileReader,
    folder: tempfile::TempDir,
}

impl ReaderAtWork {
    /// # Panics
    /// If there is no such reader, or no folder can be made.
    pub fn new(name: &str) -> Self {
        let reader = FILE_READERS.iter().find(|reader| reader.name == name).expect("a reader of this name");
        Self { reader, folder: tempfile::tempdir().expect("a folder of its own") }
    }

    /// Has `bytes` read.
    ///
    /// # Panics
    /// If the reader does.
    pub fn read(&self, bytes: &[u8]) {
        (self.reader.read)(self.folder.path(), bytes);
    }
}

/// The folder of the cases that fuzzing has found, one for each reader.
pub fn cases() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(super::HERE).join("cases")
}
