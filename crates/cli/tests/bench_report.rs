//! `cranny bench report` and `cranny bench export` from the command line.

use std::fs;
use std::path::Path;
use std::process::Output;

use assert_cmd::Command;
use cranny_bench::{Results, RunInformation, Trial, TrialOutcome, TrialRecord};
use cranny_plan::Statistics;
use cranny_scenario::Identity;
use cranny_task::Criterion;
use serde_json::Value;

fn cranny(folder: &Path, arguments: &[&str]) -> Output {
    Command::cargo_bin("cranny")
        .expect("the program")
        .current_dir(folder)
        .args(arguments)
        .output()
        .expect("it runs")
}

fn said(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Writes results of two planners on two scenarios, ten runs each, one in five not solved.
fn results(folder: &Path) {
    let mut results = Results::create(&folder.join("results.db")).expect("results");
    let run = results.begin_run(&RunInformation::here(None, "cranny bench run", 1)).expect("a run");
    for scenario in ["021", "022"] {
        for planner in ["reach", "j-plus-rrt"] {
            for seed in 0..10 {
                let solved = seed % 5 != 0;
                let time_s = if planner == "reach" { 0.01 } else { 1.0 } * (1.0 + seed as f64);
                let record = TrialRecord {
                    trial: Trial {
                        scenario: scenario.to_owned(),
                        scenario_hash: scenario.repeat(10),
                        planner: planner.to_owned(),
                        settings: "{}".to_owned(),
                        criterion: Criterion::Exact,
                        seed,
                        time_limit_s: 30.0,
                        iteration_limit: None,
                        goal: None,
                    },
                    outcome: if solved { TrialOutcome::Solved } else { TrialOutcome::BudgetExhausted },
                    detail: None,
                    statistics: Statistics {
                        iterations: 10 + seed,
                        planning_time_s: if solved { time_s } else { 30.0 },
                        ..Statistics::default()
                    },
                    path_length: solved.then_some(4.0),
                    clearance_m: solved.then_some(0.01),
                    grasp: None,
                    grasp_score: None,
                    also_solved: None,
                    memory_bytes: None,
                };
                let path = if solved { vec![vec![0.0], vec![1.0]] } else { Vec::new() };
                results.append(run, &record, &path).expect("a trial");
            }
        }
    }
}

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    results(folder.path());
    folder
}

#[test]
fn a_report_is_a_page_beside_you_whose_figures_are_those_of_json() {
    let folder = folder();
    let made = cranny(folder.path(), &["bench", "report", "results.db"]);
    assert_eq!(made.status.code(), Some(0), "{}", said(&made.stderr));
    assert!(said(&made.stdout).contains("results.html: 40 trials in 4 rows"), "{}", said(&made.stdout));
    let page = fs::read_to_string(folder.path().join("results.html")).expect("the page");
    let listed = cranny(folder.path(), &["bench", "report", "results.db", "--format", "json"]);
    let document: Value = serde_json::from_slice(&listed.stdout).expect("one JSON document");
    let start = page.find("id=\"summary\">").expect("the document") + "id=\"summary\">".len();
    let end = start + page[start..].find("</script>").expect("its end");
    assert_eq!(serde_json::from_str::<Value>(&page[start..end]).expect("JSON"), document);
    let row = &document["rows"][0];
    assert_eq!((row["planner"].as_str(), row["runs"].as_u64()), (Some("j-plus-rrt"), Some(10)));
    assert_eq!(row["success_rate"].as_f64(), Some(0.8));
    assert!(page.contains("cranny bench replay results.db "));
}

#[test]
fn json_is_one_document_on_standard_output_and_writes_nothing_unasked() {
    let folder = folder();
    let listed = cranny(folder.path(), &["bench", "report", "results.db", "--json"]);
    assert_eq!(listed.status.code(), Some(0));
    let document: Value = serde_json::from_slice(&listed.stdout).expect("one JSON document");
    assert_eq!(document["trials"].as_u64(), Some(40));
    assert!(!folder.path().join("results.html").exists());
}

#[test]
fn the_papers_table_comes_in_three_formats() {
    let folder = folder();
    let table = |format: &str| {
        let output = cranny(folder.path(), &["bench", "report", "results.db", "--format", format]);
        assert_eq!(output.status.code(), Some(0));
        said(&output.stdout)
    };
    assert!(
        table("markdown").contains("| 021 | 80: 10.80/10.44 | 80: 6.05/12.62 |"),
        "{}",
        table("markdown")
    );
    assert!(table("latex").contains("021 & 80: 10.80/10.44 & 80: 6.05/12.62 \\\\"), "{}", table("latex"));
    assert!(table("csv").starts_with("criterion,scenario,goals,goals_solved,planner,"));
    // The file extension selects the same format.
    let written = cranny(folder.path(), &["bench", "report", "results.db", "-o", "table.tex"]);
    assert_eq!(written.status.code(), Some(0));
    assert_eq!(fs::read_to_string(folder.path().join("table.tex")).expect("the table"), table("latex"));
}

#[test]
fn plots_are_written_as_svg_pdf_and_png() {
    let folder = folder();
    let made = cranny(folder.path(), &["bench", "report", "results.db", "--plots", "plots", "--quiet"]);
    assert_eq!(made.status.code(), Some(0), "{}", said(&made.stderr));
    let names: Vec<String> = fs::read_dir(folder.path().join("plots"))
        .expect("the folder")
        .map(|entry| entry.expect("a file").file_name().to_string_lossy().into_owned())
        .collect();
    let ending = |ending: &str| names.iter().filter(|name| name.ends_with(ending)).count();
    assert!(ending(".svg") >= 8, "{names:?}");
    assert_eq!(
        (ending(".svg"), ending(".pdf"), 3 * ending(".png")),
        (ending(".png"), ending(".png"), names.len())
    );
}

/// The trials name scenarios with another content hash, so they are given the current hashes of 021 and 022.
#[test]
fn scenarios_are_drawn_and_paths_of_worst_trials_are_a_click_away() {
    let folder = folder();
    let report = |arguments: &[&str]| {
        let arguments =
            [&["bench", "report", "results.db", "-o", "my page.html", "--quiet"], arguments].concat();
        let made = cranny(folder.path(), &arguments);
        assert_eq!(made.status.code(), Some(0), "{}", said(&made.stderr));
        fs::read_to_string(folder.path().join("my page.html")).expect("the page")
    };
    let page = report(&[]);
    assert!(
        page.contains("No picture of 021: ") && !page.contains("<img "),
        "its scenario is another by now"
    );
    assert!(page.contains("<code>cranny bench report --paths</code>"));

    let database = rusqlite::Connection::open(folder.path().join("results.db")).expect("a database");
    let hash = Identity::of("021").expect("built in").sha256;
    let plan = cranny(folder.path(), &["plan", "021", "-o", "plan.json", "--json"]);
    let plan: Value = serde_json::from_slice(&plan.stdout).expect("JSON");
    let path: Vec<Vec<f64>> = serde_json::from_value(plan["waypoints"].clone()).expect("way points");
    let mut bytes = u32::try_from(path[0].len()).expect("few joints").to_le_bytes().to_vec();
    bytes.extend(path.iter().flatten().flat_map(|value| value.to_le_bytes()));
    let sql = "UPDATE trials SET scenario_hash = ?1, path = iif(outcome = 'solved', ?2, NULL) WHERE scenario = '021'";
    assert_eq!(database.execute(sql, rusqlite::params![hash, bytes]).expect("updated"), 20);
    drop(database);
    let page = report(&["--paths"]);
    assert_eq!(page.matches("src=\"data:image/png;base64,").count(), 1, "021 alone is there");
    let links: Vec<&str> = page.split("<a href=\"my%20page-paths/").skip(1).collect();
    assert_eq!(links.len(), 2, "the slowest solved trial of each planner on 021");
    for link in links {
        let file = folder.path().join("my page-paths").join(link.split('"').next().expect("a name"));
        let viewer = fs::read_to_string(&file).expect("the page of the path");
        assert!(viewer.contains("<title>Cranny</title>") && viewer.len() > 500_000, "{}", viewer.len());
    }
    let no_page = cranny(folder.path(), &["bench", "report", "results.db", "--paths", "--format", "json"]);
    assert_eq!(no_page.status.code(), Some(2));
    assert!(
        said(&no_page.stderr).contains("--paths: only the HTML page links to paths"),
        "{}",
        said(&no_page.stderr)
    );
}

#[test]
fn trials_are_exported_as_one_log_or_one_a_scenario() {
    let folder = folder();
    let one = cranny(folder.path(), &["bench", "export", "results.db", "--format", "ompl", "-o", "all.log"]);
    assert_eq!(one.status.code(), Some(0), "{}", said(&one.stderr));
    let log = fs::read_to_string(folder.path().join("all.log")).expect("the log");
    assert!(log.contains("\n4 planners\n") && log.contains("\nreach @ 021 exact\n"), "{log}");
    let each = cranny(folder.path(), &["bench", "export", "results.db", "-o", "logs/", "--json"]);
    let document: Value = serde_json::from_slice(&each.stdout).expect("one JSON document");
    assert_eq!(document["files"], serde_json::json!(["logs/021-exact.log", "logs/022-exact.log"]));
    assert!(folder.path().join("logs/021-exact.log").is_file());
}

#[test]
fn bad_input_is_said_once_and_leaves_what_was_there() {
    let folder = folder();
    fs::write(folder.path().join("page.html"), "earlier").expect("written");
    fs::write(folder.path().join("no.db"), "no database at all, but long enough to look like one")
        .expect("written");
    Results::create(&folder.path().join("empty.db")).expect("results");
    for (arguments, wanted) in [
        (&["report", "missing.db", "-o", "page.html"][..], "missing.db: results file not found"),
        (&["report", "no.db", "-o", "page.html"], "no.db: not a results file"),
        (&["report", "empty.db", "-o", "page.html"], "empty.db: the results contain no trial"),
        (
            &["report", "results.db", "-o", "nowhere/page.html"],
            "nowhere/page.html: the folder does not exist",
        ),
        (&["report", "results.db", "--format", "pdf"], "invalid value 'pdf'"),
        (&["export", "empty.db", "-o", "page.html"], "empty.db: the results contain no trial"),
        (&["export", "results.db"], "--output <FILE>"),
    ] {
        let arguments: Vec<&str> = ["bench"].into_iter().chain(arguments.iter().copied()).collect();
        let output = cranny(folder.path(), &arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(said(&output.stderr).contains(wanted), "{arguments:?}: {}", said(&output.stderr));
    }
    assert_eq!(fs::read_to_string(folder.path().join("page.html")).expect("still there"), "earlier");
}
