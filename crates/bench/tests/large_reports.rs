//! Reports of many planners, scenarios and runs stay small, and no scenario counts more than another.

use cranny_bench::report::{Enclosure, Finding, plots};
use cranny_task::Criterion;

use crate::synthetic::{Campaign, Manner, add, empty};

/// Creates runs of many settings of one planner on some scenarios.
fn sweep(settings: usize, scenarios: usize, runs: u64) -> Campaign {
    let (mut campaign, mut draw) = empty();
    for scenario in 0..scenarios {
        for setting in 0..settings {
            let mean_s = 0.5 + setting as f64 / settings as f64;
            let manner = Manner {
                planner: "planner",
                criterion: Criterion::Exact,
                mean_s,
                limit_s: 10.0,
                runs,
                goal: None,
            };
            let first = campaign.trials.len();
            add(&mut campaign, &mut draw, &format!("shelf-{scenario:04}"), &manner);
            for trial in &mut campaign.trials[first..] {
                trial.record.trial.settings = format!(r#"{{"goal_bias":0.{setting:05},"step":0.1}}"#);
            }
        }
    }
    campaign
}

/// A page of every pair had 62 MB for one scenario of these.
#[test]
fn a_page_of_many_settings_or_scenarios_is_small_and_states_what_it_leaves_out() {
    for (settings, scenarios) in [(500, 1), (400, 3), (2, 600), (30, 30)] {
        let summary = sweep(settings, scenarios, 3).summary();
        assert_eq!(summary.rows.len(), settings * scenarios);
        assert!(summary.comparisons.len() <= 500, "{} comparisons", summary.comparisons.len());
        let page = summary.html(&Enclosure::default());
        assert!(page.len() < 3_000_000, "{settings} settings, {scenarios} scenarios: {} bytes", page.len());
        assert!(page.contains("This page is an excerpt"));
        assert_eq!(summary.csv().lines().count(), 1 + settings * scenarios);
    }
}

/// Each of these curves had a jump for each solved run.
#[test]
fn curves_of_many_runs_have_few_jumps() {
    let summary = sweep(2, 2, 3000).summary();
    for curve in &summary.curves {
        assert!(curve.at.len() <= 200 && curve.at.is_sorted() && curve.success.is_sorted());
    }
    let row = &summary.rows[0];
    let end = summary.curves[0].success.last().expect("a jump");
    assert!((end - row.success_rate).abs() < 1e-9, "the last jump stays");
    assert!(summary.html(&Enclosure::default()).len() < 3_000_000);
}

#[test]
fn a_report_of_too_many_pairs_compares_each_planner_with_one_that_no_result_chooses() {
    let summary = sweep(40, 1, 2).summary();
    assert_eq!(summary.comparisons.len(), 39);
    let mut names: Vec<&str> = summary.planner_names();
    names.sort_unstable();
    assert!(summary.comparisons.iter().all(|own| own.first == names[0] && own.second != names[0]));
    assert!(summary.comparisons.iter().all(|own| own.finding == Finding::TooFewRuns));
    let note = "39 of 780 pairs of planners on a scenario are compared";
    assert!(summary.warnings.iter().any(|warning| warning.starts_with(note)), "{:?}", summary.warnings);
    // Up to 500 pairs, all are compared, without a note.
    let summary = sweep(32, 1, 2).summary();
    assert_eq!(summary.comparisons.len(), 496);
    assert!(!summary.warnings.iter().any(|warning| warning.contains("pairs of planners")));
}

#[test]
fn plots_draw_the_best_eight_of_many_planners() {
    let summary = sweep(20, 2, 4).summary();
    for plot in plots(&summary) {
        let svg = plot.svg();
        assert!(!svg.contains("goal_bias=0.00019"), "{}: the slowest of twenty is drawn", plot.name);
    }
    let names: Vec<String> = plots(&summary).into_iter().map(|plot| plot.title).collect();
    assert!(names.iter().any(|title| title.contains("(8 of 20 planners)")), "{names:?}");
}

/// A planner with most of its runs on an easy scenario gains nothing by them.
#[test]
fn every_scenario_counts_the_same_over_all() {
    let (mut campaign, mut draw) = empty();
    for (scenario, runs, mean_s) in [("021", 300, 1e-3), ("022", 10, 1e9)] {
        for (planner, runs) in [("even", 10), ("uneven", runs)] {
            let manner =
                Manner { planner, criterion: Criterion::Exact, mean_s, limit_s: 10.0, runs, goal: None };
            add(&mut campaign, &mut draw, scenario, &manner);
        }
    }
    let summary = campaign.summary();
    let [even, uneven] = &summary.overall[..] else { panic!("{:?}", summary.overall) };
    assert_eq!((even.runs, even.solved, uneven.runs, uneven.solved), (20, 10, 310, 300));
    for own in [even, uneven] {
        assert!((own.success_rate - 0.5).abs() < 1e-12, "{}: {}", own.planner_name, own.success_rate);
        assert!(own.success_low < 0.5 && own.success_high > 0.5);
        let of = |curve: &&cranny_bench::report::SuccessCurve| {
            curve.environment.is_none() && curve.planner_name == own.planner_name
        };
        let curve = summary.curves.iter().find(of).expect("a curve over all scenarios");
        assert!((curve.success.last().expect("a jump") - 0.5).abs() < 1e-12);
    }
    // More runs make the interval narrower.
    assert!(uneven.success_high - uneven.success_low < even.success_high - even.success_low);
}
