//! The problems that the benchmarks of this crate share.

use std::path::Path;

use cranny_collision::Margins;
use cranny_scenario::{OpenOptions, Scenario};
use cranny_task::Problem;

/// Returns the built-in 021, and released 011 and 044 if `CRANNY_DATA` names the data folder.
pub fn all() -> Vec<(String, Problem)> {
    let mut names = vec!["021".to_owned()];
    if let Some(data) = std::env::var_os("CRANNY_DATA") {
        // Benchmarks run in the folder of the package; a relative folder refers to that of the workspace.
        let scenarios =
            Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(data).join("jogramop/scenarios");
        names.extend(["011", "044"].map(|id| scenarios.join(id).display().to_string()));
    } else {
        eprintln!("released 011 and 044 need the data folder in CRANNY_DATA");
    }
    let open = |name: String| {
        let scenario = Scenario::open(&name, &OpenOptions::default()).expect("a scenario");
        let problem = scenario.problem(Margins::default()).expect("a problem");
        (scenario.id, problem)
    };
    names.into_iter().map(open).collect()
}
