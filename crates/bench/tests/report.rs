//! Reports: summaries of trials whose figures can be computed by hand, and the agreement of tables and plots with them.

#![allow(clippy::float_cmp, reason = "figures that are copied must be the same to the last bit")]

use cranny_bench::report::{
    Comparison, Finding, Measure, Overall, ScenarioClass, SuccessCurve, Summary, plots,
};
use cranny_bench::{BenchError, Run, StoredTrial, TrialOutcome};
use cranny_task::Criterion;
use proptest::prelude::*;
use strum::VariantArray as _;

use crate::synthetic::{Campaign, Manner, add, campaign, empty};

/// Creates twenty runs of one planner on 021 with a time limit of 10 s, to be modified.
pub fn plain() -> Campaign {
    let (mut campaign, mut draw) = empty();
    let manner = Manner {
        planner: "reach",
        criterion: Criterion::Exact,
        mean_s: 1.0,
        limit_s: 10.0,
        runs: 20,
        goal: None,
    };
    add(&mut campaign, &mut draw, "021", &manner);
    campaign
}

/// Ends a trial with an outcome after a time.
pub fn end(trial: &mut StoredTrial, outcome: TrialOutcome, time_s: f64) {
    trial.record.outcome = outcome;
    trial.record.statistics.planning_time_s = time_s;
}

#[track_caller]
fn assert_near(actual: f64, expected: f64) {
    assert!((actual - expected).abs() < 1e-9, "{actual} is not {expected}");
}

#[test]
fn a_failure_counts_as_the_limit_in_the_papers_convention() {
    let mut campaign = plain();
    campaign.trials.truncate(4);
    for (trial, time_s) in campaign.trials.iter_mut().zip([1.0, 2.0, 3.0]) {
        end(trial, TrialOutcome::Solved, time_s);
    }
    end(&mut campaign.trials[3], TrialOutcome::NoReachableGrasp, 0.1);
    let row = &campaign.summary().rows[0];
    assert_eq!((row.runs, row.solved), (4, 3));
    assert_near(row.success_rate, 0.75);
    assert_near(row.mean_s, 4.0);
    assert_near(row.std_s.unwrap(), (50.0_f64 / 3.0).sqrt());
    assert_eq!(row.median_s, Some(2.0));
    assert_near(row.restricted_mean_s.unwrap(), 4.0);
    assert_eq!(row.outcomes["no-reachable-grasp"], 1);
}

#[test]
fn a_planner_gains_nothing_by_giving_up_early() {
    let mut slow = plain();
    for (index, trial) in slow.trials.iter_mut().enumerate() {
        let outcome = if index < 10 { TrialOutcome::Solved } else { TrialOutcome::BudgetExhausted };
        end(trial, outcome, if index < 10 { 5.0 } else { 10.0 });
    }
    let mut quitter = plain();
    for (index, trial) in quitter.trials.iter_mut().enumerate() {
        let outcome = if index < 10 { TrialOutcome::Solved } else { TrialOutcome::Crashed };
        end(trial, outcome, if index < 10 { 5.0 } else { 0.5 });
    }
    let (slow, quitter) = (slow.summary(), quitter.summary());
    assert_eq!(slow.curves[0].success, quitter.curves[0].success);
    assert_eq!(slow.rows[0].restricted_mean_s, quitter.rows[0].restricted_mean_s);
    assert_eq!(slow.rows[0].mean_s, quitter.rows[0].mean_s);
}

#[test]
fn a_search_that_iterations_cut_short_is_censored_where_it_stopped() {
    let mut campaign = plain();
    campaign.trials.truncate(4);
    for (trial, time_s) in campaign.trials.iter_mut().zip([1.0, 1.0, 3.0, 3.0]) {
        let solved = time_s > 2.0;
        end(trial, if solved { TrialOutcome::Solved } else { TrialOutcome::BudgetExhausted }, time_s);
        trial.record.trial.iteration_limit = Some(100);
        trial.record.statistics.iterations = if solved { 40 } else { 100 };
    }
    let row = &campaign.summary().rows[0];
    // Both runs that were still searching at 3 s were solved then.
    assert_eq!(row.median_s, Some(3.0));
    assert_near(row.success_rate, 0.5);
    assert_eq!(row.median_iterations, Some(40.0));
}

/// With three of nine solved, a median would be that of the solved trials alone.
#[test]
fn what_a_program_states_of_its_iterations_or_does_to_its_worker_is_not_censored() {
    for (outcome, iterations, says) in [
        (TrialOutcome::BudgetExhausted, 1_000_000, None),
        (TrialOutcome::GaveUp, 100, Some("whatever the program states about its iterations")),
        (TrialOutcome::Killed, 0, Some("a signal killed their worker")),
        (TrialOutcome::Undecided, 0, Some("the judge reached none")),
        (TrialOutcome::Cancelled, 0, None),
        (TrialOutcome::Crashed, 0, None),
    ] {
        let mut campaign = plain();
        campaign.trials.truncate(9);
        for (index, trial) in campaign.trials.iter_mut().enumerate() {
            let time_s = [0.02, 0.05, 0.07].get(index).copied();
            end(trial, time_s.map_or(outcome, |_| TrialOutcome::Solved), time_s.unwrap_or(0.01));
            trial.record.trial.settings = r#"{"exec":["sh","x.sh"],"files":{}}"#.to_owned();
            trial.record.trial.iteration_limit = Some(100);
            trial.record.statistics.iterations = if time_s.is_some() { 1 } else { iterations };
        }
        let summary = campaign.summary();
        let row = &summary.rows[0];
        assert_eq!((row.solved, row.median_s, row.median_iterations), (3, None, None), "{outcome:?}");
        assert_near(row.restricted_mean_s.unwrap(), (0.14 + 60.0) / 9.0);
        let warning = summary.warnings.iter().find(|warning| warning.starts_with("6 of 9 trials of reach "));
        assert_eq!(warning.is_some(), says.is_some(), "{:?}", summary.warnings);
        assert!(says.is_none_or(|says| warning.is_some_and(|warning| warning.contains(says))));
    }
}

#[test]
fn a_planner_that_counts_no_iterations_has_no_curve_over_them() {
    let mut campaign = plain();
    campaign.trials.iter_mut().for_each(|trial| trial.record.statistics.iterations = 0);
    let summary = campaign.summary();
    assert_eq!(summary.rows[0].median_iterations, None);
    assert!(summary.curves.iter().all(|curve| curve.over == Measure::Time));
    assert!(summary.rows[0].iterations.is_none());
}

#[test]
fn a_solved_run_without_an_iteration_counts_in_their_median() {
    let mut campaign = plain();
    for (index, trial) in campaign.trials.iter_mut().enumerate() {
        end(trial, TrialOutcome::Solved, 1.0);
        trial.record.statistics.iterations = if index < 15 { 0 } else { 9 };
    }
    let iterations = campaign.summary().rows[0].iterations.expect("counts");
    assert_eq!((iterations.count, iterations.median, iterations.greatest), (20, 0.0, 9.0));
}

#[test]
fn the_best_goal_stands_in_the_row_and_all_goals_below() {
    let summary = campaign().summary();
    let row = summary.rows.iter().find(|row| row.planner == "ik-rrt" && row.scenario == "023").unwrap();
    assert_eq!((row.goals, row.goal, row.runs), (Some(3), Some(0), 5));
    let goals: Vec<_> = summary.goals.iter().filter(|goal| goal.scenario_name == "023").collect();
    assert_eq!(goals.len(), 3);
    assert_eq!(goals.iter().filter(|goal| goal.best).count(), 1);
    assert_eq!(row.mean_s, goals[0].mean_s);
    assert!(goals.iter().all(|goal| goal.success_rate <= row.success_rate));
    let unsolved = summary.rows.iter().find(|row| row.planner == "ik-rrt" && row.scenario == "024").unwrap();
    assert_eq!((unsolved.goals, unsolved.goals_solved), (Some(4), Some(0)));
}

#[test]
fn the_papers_table_has_the_papers_layout() {
    let summary = campaign().summary();
    let markdown = summary.markdown();
    let paper = markdown.split("\n\n").find(|table| table.contains("| goals |")).expect("a table with goals");
    let lines: Vec<&str> = paper.lines().collect();
    assert_eq!(lines[0], "| scenario | goals | j-plus-rrt | ik-rrt (best goal) |");
    // The first has no solved goal, the second has no goals, and the third has another limit.
    let line = |id: &str| *lines.iter().find(|line| line.starts_with(&format!("| {id} |"))).unwrap();
    let ends = |id: &str, start: &str, end: &str| {
        assert!(line(id).starts_with(start) && line(id).ends_with(end), "{}", line(id));
    };
    ends("024", "| 024 | 4/0 | ", " | – |");
    ends("041", "| 041 | 0/0 | ", " | – |");
    assert!(line("045").contains(" (limit 90 s) | 100: "), "{}", line("045"));

    let latex = summary.latex();
    assert_eq!(latex.matches("\\begin{tabular}").count(), 2);
    assert!(latex.contains("$|G_{\\mathrm{IK}}|$/solved & j-plus-rrt & ik-rrt (best goal) \\\\"), "{latex}");
    assert!(latex.lines().all(|line| line.starts_with('%') || !line.contains("0%")));

    let csv = summary.csv();
    let header: Vec<&str> = csv.lines().next().unwrap().split(',').collect();
    assert!(csv.lines().all(|line| line.split(',').count() == header.len()));
    let row = summary.rows.iter().find(|row| row.criterion == "paper" && row.scenario == "021").unwrap();
    assert!(
        csv.contains(&format!(",{},{},10\n", row.mean_s, row.std_s.unwrap()))
            || csv.contains(&row.mean_s.to_string())
    );
    assert_eq!(csv.lines().count(), 1 + summary.rows.len());
}

#[test]
fn comparisons_of_enough_runs_are_adjusted_over_the_report() {
    let summary = campaign().summary();
    let tested: Vec<_> =
        summary.comparisons.iter().filter(|comparison| comparison.finding != Finding::TooFewRuns).collect();
    assert_eq!(tested.len(), 3 * 8 + 12);
    for comparison in &tested {
        assert_eq!(comparison.family, tested.len());
        assert!(comparison.log_rank_p <= comparison.log_rank_p_holm);
        assert!(comparison.difference_p <= comparison.difference_p_holm);
        assert!(comparison.difference_low_s <= Some(comparison.difference_s));
        assert!(Some(comparison.difference_s) <= comparison.difference_high_s);
    }
    let is_hard = |own: &&&Comparison| {
        (&*own.scenario_name, &*own.first, &*own.second) == ("025", "j-plus-rrt", "reach")
    };
    let hard = tested.iter().find(is_hard).unwrap();
    assert_eq!(hard.faster(), Some("reach"));
    assert!(hard.difference_s > 0.0, "the first minus the second");
    assert!(summary.comparisons.iter().all(|comparison| !comparison.first.contains("best goal")));
    assert!(summary.comparisons.iter().all(|comparison| !comparison.second.contains("best goal")));
}

#[test]
fn what_should_never_happen_stands_first_with_its_replay() {
    let summary = campaign().summary();
    let outcomes: Vec<&str> = summary.worst.iter().map(|trial| trial.outcome).collect();
    assert_eq!(outcomes[..2], ["crashed", "hung"]);
    // The slowest solved trials are listed for inspection of their paths, at most one for each planner and scenario.
    let solved: Vec<_> = summary.worst.iter().filter(|trial| trial.outcome == "solved").collect();
    assert!(solved.len() == 20 && solved.is_sorted_by(|a, b| a.planning_time_s >= b.planning_time_s));
    for trial in &summary.worst {
        assert_eq!(trial.replay, format!("cranny bench replay results.db {}", trial.trial));
    }
}

#[test]
fn a_large_set_is_one_curve_a_planner_and_a_small_one_a_curve_a_scenario() {
    let summary = campaign().summary();
    let environment = ScenarioClass::of("gap-0.3").environment;
    let sweep: Vec<_> =
        summary.curves.iter().filter(|curve| curve.environment.as_ref() == Some(&environment)).collect();
    assert_eq!(sweep.len(), 4, "two planners, over time and over iterations");
    assert!(sweep.iter().all(|curve| curve.scenario_name.is_none() && curve.runs == 240));
    assert!(summary.curves.iter().any(|curve| curve.scenario_name.as_deref() == Some("021")));
}

/// Two planners on four scenarios, a third on three of them, with times chosen by hand.
#[test]
fn all_scenarios_together_are_those_that_the_planners_share() {
    let (mut campaign, mut draw) = empty();
    type Times = &'static [(&'static str, [f64; 3])];
    let times: [(&str, Times); 3] = [
        (
            "fast",
            &[
                ("021", [1.0, 1.0, 2.0]),
                ("022", [2.0, 4.0, 9.0]),
                ("023", [3.0, 3.0, 3.0]),
                ("024", [1.0; 3]),
            ],
        ),
        (
            "slow",
            &[
                ("021", [2.0, 3.0, 4.0]),
                ("022", [2.0, 2.0, 2.0]),
                ("023", [11.0, 11.0, 5.0]),
                ("024", [1.0; 3]),
            ],
        ),
        ("third", &[("021", [8.0, 10.0, 10.0]), ("022", [2.0, 2.0, 2.0]), ("023", [11.0; 3])]),
    ];
    for (planner, times_s) in times {
        for (scenario, times_s) in times_s {
            let manner = Manner {
                planner,
                criterion: Criterion::Exact,
                mean_s: 1.0,
                limit_s: 10.0,
                runs: 3,
                goal: None,
            };
            add(&mut campaign, &mut draw, scenario, &manner);
            let first = campaign.trials.len() - 3;
            for (trial, &time_s) in campaign.trials[first..].iter_mut().zip(times_s) {
                let solved = time_s <= 10.0;
                end(
                    trial,
                    if solved { TrialOutcome::Solved } else { TrialOutcome::BudgetExhausted },
                    time_s.min(10.0),
                );
                trial.record.path_length = solved.then_some(1.0 + time_s);
            }
        }
    }
    let summary = campaign.summary();
    let [fast, slow, third] = &summary.overall[..] else { panic!("{:?}", summary.overall) };
    assert_eq!((fast.scenarios, fast.scenarios_in_all, fast.runs, fast.solved), (3, 4, 9, 9));
    assert_eq!((slow.solved, third.solved), (7, 6));
    // The medians are: fast 1, 4, 3; slow 3, 2, none; third 10, 2, none.
    let ratios = |overall: &Overall| overall.ratios.values().copied().collect::<Vec<_>>();
    assert_eq!(ratios(fast), [Some(1.0), Some(2.0), Some(1.0)]);
    assert_eq!(ratios(slow), [Some(3.0), Some(1.0), None]);
    assert_eq!(ratios(third), [Some(10.0), Some(1.0), None]);
    assert_near(fast.best, 2.0 / 3.0);
    assert_near(slow.best, 1.0 / 3.0);
    assert_near(fast.within_2, 1.0);
    assert_near(third.within_2, 1.0 / 3.0);
    assert_near(third.within_10, 2.0 / 3.0);
    // The pooled times of `fast` are, sorted: 1 1 2 2 3 3 3 4 9.
    assert_eq!((fast.median_s, fast.followed_to_s), (Some(3.0), 10.0));
    let pooled = |planner: &str| {
        let of = |curve: &&SuccessCurve| curve.environment.is_none() && curve.planner_name == planner;
        summary.curves.iter().find(of).expect("a pooled curve")
    };
    assert_eq!(pooled("fast").at, [1.0, 2.0, 3.0, 4.0, 9.0]);
    assert_near(pooled("slow").success.last().copied().unwrap(), 7.0 / 9.0);
}

#[test]
fn the_median_is_one_figure_in_tables_boxes_and_curves() {
    let summary = campaign().summary();
    for row in &summary.rows {
        let quartiles = [row.least_s, row.lower_quartile_s, row.median_s, row.upper_quartile_s];
        let seen: Vec<f64> = quartiles.into_iter().flatten().collect();
        assert!(seen.is_sorted(), "{seen:?}");
        let curve = summary.curves.iter().find(|curve| {
            (curve.over, &curve.criterion, &curve.planner_name)
                == (Measure::Time, &row.criterion, &row.planner_name)
                && curve.scenario_name.as_ref() == Some(&row.scenario_name)
        });
        if let Some(curve) = curve {
            let half = curve.success.iter().position(|&share| share >= 0.5 - 1e-12);
            assert_eq!(
                row.median_s,
                half.map(|step| curve.at[step]),
                "{} {}",
                row.scenario_name,
                row.planner_name
            );
        }
    }
}

#[test]
fn runs_that_only_their_times_tell_apart_are_one_machine() {
    let mut campaign = plain();
    let first = campaign.runs[0].clone();
    let mut second = Run { id: 2, began: "2026-11-20T08:00:00Z".to_owned(), ..first.clone() };
    second.information.command = "cranny bench run --runs 40 -o results.db".to_owned();
    let mut third = Run { id: 3, ..first.clone() };
    third.information.workers = 2;
    let idle = Run { id: 4, ..first };
    campaign.runs.extend([second, third, idle]);
    for (index, trial) in campaign.trials.iter_mut().enumerate() {
        trial.run = [1, 2, 2, 3][index % 4];
    }
    let machines = campaign.summary().machines;
    let counts: Vec<_> =
        machines.iter().map(|own| (own.workers, own.runs, own.trials, own.commands.len())).collect();
    assert_eq!(counts, [(1, 2, 15, 2), (2, 1, 5, 1)]);
    assert_eq!(
        (&*machines[0].first_began, &*machines[0].last_began),
        ("2026-11-20T08:00:00Z", "2026-11-21T18:00:00Z")
    );
    // Some rows also contain trials of a run with two workers: the report splits these rows.
    let summary = campaign.summary();
    assert!(!summary.split_rows.is_empty());
    for shares in summary.split_rows.chunks(2) {
        assert!(shares[0].on.contains(", 2 workers, Cranny 0.1.0") && !shares[1].on.contains("workers"));
        let is_whole = |row: &&cranny_bench::report::Row| {
            (&row.planner_name, &row.scenario_name) == (&shares[0].planner_name, &shares[0].scenario_name)
        };
        let whole = summary.rows.iter().find(is_whole).expect("the row");
        assert_eq!(shares[0].trials + shares[1].trials, whole.runs);
        assert_eq!(shares[0].solved + shares[1].solved, whole.solved);
    }
    assert!(plain().summary().split_rows.is_empty());
}

#[test]
fn plots_have_names_of_their_own_and_all_formats() {
    let plots = plots(&campaign().summary());
    let mut names: Vec<&str> = plots.iter().map(|plot| plot.name.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), plots.len());
    assert!(
        names
            .iter()
            .all(|name| name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-'))
    );
    for wanted in [
        "02x-ball-under-a-table-j-plus-rrt-iterations-paper",
        "gap-sweep-difficulty-success-exact",
        "02x-ball-under-a-table-memory-exact",
        "all-scenarios-together-time-exact",
        "all-scenarios-profile-exact",
    ] {
        assert!(names.contains(&wanted), "{wanted} is not among {names:?}");
    }
    let plot = &plots[0];
    assert!(plot.svg().starts_with("<svg xmlns") && plot.svg().ends_with("</svg>"));
    assert!(plot.png().expect("it can be drawn").starts_with(b"\x89PNG"));
    assert!(plot.pdf().expect("it can be drawn").starts_with(b"%PDF-"));
}

#[test]
fn rows_have_the_promised_keys() {
    let json = serde_json::to_value(plain().summary()).expect("JSON");
    for key in [
        "scenario",
        "planner",
        "criterion",
        "runs",
        "solved",
        "success_rate",
        "success_low",
        "success_high",
        "mean_s",
        "std_s",
        "median_s",
        "median_iterations",
    ] {
        assert!(json["rows"][0].get(key).is_some(), "no key '{key}'");
    }
}

#[test]
fn no_trials_and_impossible_figures_are_refused_by_name() {
    let (nothing, _) = empty();
    assert!(matches!(Summary::of(&nothing.source()), Err(BenchError::NoTrials { .. })));
    let mut campaign = plain();
    for value in [f64::NAN, f64::INFINITY, -1.0] {
        campaign.trials[7].record.statistics.planning_time_s = value;
        let message = Summary::of(&campaign.source()).expect_err("no trial has it").to_string();
        assert!(message.starts_with("trial 8: its planning time is "), "{message}");
    }
    let mut campaign = plain();
    end(&mut campaign.trials[7], TrialOutcome::Solved, 10.5);
    let message = Summary::of(&campaign.source()).expect_err("no campaign records it").to_string();
    assert_eq!(message, "trial 8: it is solved after 10.5 s, but its time limit is 10 s");
    end(&mut campaign.trials[7], TrialOutcome::Solved, 10.0);
    assert!(Summary::of(&campaign.source()).is_ok());
}

#[test]
fn settings_and_limits_are_never_mixed() {
    let mut campaign = plain();
    campaign.trials[3].record.trial.settings = r#"{"goal_bias":0.5}"#.to_owned();
    campaign.trials[4].record.trial.time_limit_s = 20.0;
    campaign.trials[5].record.trial.scenario_hash = "f".repeat(64);
    campaign.trials[6].record.trial.criterion = Criterion::Paper;
    let summary = campaign.summary();
    assert_eq!(summary.rows.len(), 5);
    assert_eq!(summary.rows.iter().map(|row| row.runs).sum::<usize>(), 20);
    let mut names: Vec<_> =
        summary.rows.iter().map(|row| (&*row.criterion, &*row.scenario_name, &*row.planner_name)).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), 5, "no two rows have one name: {names:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn the_order_of_the_trials_changes_nothing(order in Just((0..40_usize).collect::<Vec<_>>()).prop_shuffle()) {
        let mut campaign = campaign();
        campaign.trials.truncate(40);
        let ordered = campaign.summary();
        let shuffled = order.into_iter().map(|index| campaign.trials[index].clone()).collect();
        campaign.trials = shuffled;
        prop_assert_eq!(campaign.summary(), ordered);
    }

    #[test]
    fn the_curve_ends_at_the_success_rate_where_nothing_is_cut_short_by_iterations(
        ends in prop::collection::vec((0..TrialOutcome::VARIANTS.len(), 0.0..10.0_f64), 20),
    ) {
        let mut campaign = plain();
        for (trial, (outcome, time_s)) in campaign.trials.iter_mut().zip(ends) {
            end(trial, TrialOutcome::VARIANTS[outcome], time_s);
        }
        let summary = campaign.summary();
        let curve = summary.curves.iter().find(|curve| curve.over == Measure::Time).expect("a curve over time");
        let end = curve.success.last().copied().unwrap_or(0.0);
        prop_assert!((end - summary.rows[0].success_rate).abs() < 1e-9);
    }
}
