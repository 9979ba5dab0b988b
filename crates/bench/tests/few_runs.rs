//! Reports of few runs: random differences are not called significant, and too few runs are marked.

use cranny_bench::TrialOutcome;
use cranny_bench::report::{Enclosure, Finding, Summary};
use cranny_task::Criterion;

use crate::synthetic::{Campaign, Draw, Manner, add, empty};

const LIMIT_S: f64 = 10.0;

/// Distributions of the run times of planners, all with a time limit of ten seconds.
#[derive(Clone, Copy, Debug)]
enum Times {
    /// Exponential, far below the limit.
    Exponential,
    /// Log-normal over decades, as for sampling-based planners; some reach the limit.
    HeavyTail,
    /// Two thirds immediately, the others late or never.
    TwoModes,
    /// Rounded to seconds as by a coarse clock, with many ties.
    Ties,
    /// All equal.
    Constant,
    /// Nine of ten unsolved.
    Rare,
    /// A third stopped early by the user.
    CutShort,
}

const ALL_TIMES: [Times; 7] = [
    Times::Exponential,
    Times::HeavyTail,
    Times::TwoModes,
    Times::Ties,
    Times::Constant,
    Times::Rare,
    Times::CutShort,
];

impl Times {
    /// Returns the time of a run, and true if it was stopped then.
    fn draw(self, draw: &mut Draw) -> (f64, bool) {
        let exponential = |draw: &mut Draw| -(1.0 - draw.next()).ln();
        match self {
            Self::Exponential => (exponential(draw), false),
            Self::HeavyTail => {
                let normal =
                    (-2.0 * (1.0 - draw.next()).ln()).sqrt() * (std::f64::consts::TAU * draw.next()).cos();
                ((1.5 * normal).exp(), false)
            }
            Self::TwoModes if draw.next() < 2.0 / 3.0 => (0.01 + 0.01 * draw.next(), false),
            Self::TwoModes => (20.0 * draw.next(), false),
            Self::Ties => (exponential(draw).ceil(), false),
            Self::Constant => (0.5, false),
            Self::Rare => (100.0 * draw.next(), false),
            Self::CutShort => {
                let (time_s, stopped_s) = (3.0 * exponential(draw), 15.0 * draw.next());
                (time_s.min(stopped_s), stopped_s < time_s.min(LIMIT_S))
            }
        }
    }
}

fn add_runs(
    campaign: &mut Campaign,
    draw: &mut Draw,
    scenario: &str,
    planner: &str,
    runs: u64,
    times: Times,
) {
    let before = campaign.trials.len();
    let manner =
        Manner { planner, criterion: Criterion::Exact, mean_s: 1.0, limit_s: LIMIT_S, runs, goal: None };
    add(campaign, draw, scenario, &manner);
    for trial in &mut campaign.trials[before..] {
        let (time_s, is_stopped) = times.draw(draw);
        let record = &mut trial.record;
        record.outcome = match (is_stopped, time_s <= LIMIT_S) {
            (true, _) => TrialOutcome::Cancelled,
            (false, true) => TrialOutcome::Solved,
            (false, false) => TrialOutcome::BudgetExhausted,
        };
        record.statistics.planning_time_s = time_s.min(LIMIT_S);
        let is_solved = record.is_solved();
        record.path_length = is_solved.then_some(3.0);
        record.grasp_score = is_solved.then_some(0.5);
        record.clearance_m = is_solved.then_some(0.01);
    }
}

/// Returns true if any comparison of a report calls a difference significant, in any form.
fn calls_a_difference(summary: &Summary) -> bool {
    summary.comparisons.iter().any(|own| {
        let is_small = |p: Option<f64>| p.is_some_and(|p| p < 0.05);
        let interval = own.difference_low_s.zip(own.difference_high_s);
        own.faster().is_some()
            || own.finding == Finding::Differ
            || is_small(own.log_rank_p_holm)
            || is_small(own.difference_p_holm)
            || interval.is_some_and(|(low, high)| low > 0.0 || high < 0.0)
    })
}

/// Two to four copies of one planner on one to three scenarios, 2 to 30 runs each: at most one report in twenty may call a
/// difference significant, independently of its number of comparisons.
#[test]
fn copies_of_one_planner_are_rarely_found_to_differ() {
    let is_long = std::env::var_os("CRANNY_LONG").is_some();
    let reports = if is_long { 10_000_u32 } else { 100 };
    let mut draw = Draw::of_seed(if is_long { 7 } else { 1 });
    let mut draw_count = |least: u64, most: u64| {
        (least..=most).find(|count| draw.next() < 1.0 / (most - count + 1) as f64).unwrap_or(most)
    };
    let mut called = 0;
    for report in 0..reports {
        let (mut campaign, _) = empty();
        let mut times_draw = Draw::of_seed(u64::from(report) << 32);
        let times = ALL_TIMES[report as usize % ALL_TIMES.len()];
        // Many comparisons with many runs take the longest, so they are not more frequent than others.
        let (scenarios, planners) = (draw_count(1, 3), draw_count(2, 4));
        for scenario in 0..scenarios {
            let runs = draw_count(2, 30);
            for planner in 0..planners {
                // The numbers of runs may differ too.
                let runs = if report % 3 == 0 { draw_count(2, 30) } else { runs };
                let (scenario, planner) = (format!("02{}", scenario + 1), format!("copy-{planner}"));
                add_runs(&mut campaign, &mut times_draw, &scenario, &planner, runs, times);
            }
        }
        called += u32::from(calls_a_difference(&campaign.summary()));
    }
    // The bound is one in twenty, with three standard deviations added for few reports, and nearly none for many.
    let most = if is_long { 0.055 } else { 0.05 + 3.0 * (0.05 * 0.95 / f64::from(reports)).sqrt() };
    let share = f64::from(called) / f64::from(reports);
    eprintln!("{called} of {reports} reports call a difference significant");
    assert!(share <= most, "{called} of {reports} reports call a difference significant");
}

/// A test that never finds a difference would pass the one above.
#[test]
fn planners_that_differ_are_found_to_differ() {
    let mut found = 0;
    for seed in 0..50 {
        let (mut campaign, _) = empty();
        let mut draw = Draw::of_seed(seed);
        for (planner, times) in [("quick", Times::Exponential), ("rare", Times::Rare)] {
            add_runs(&mut campaign, &mut draw, "021", planner, 8, times);
        }
        let summary = campaign.summary();
        found += usize::from(summary.comparisons[0].faster() == Some("quick"));
        assert_ne!(summary.comparisons[0].faster(), Some("rare"));
    }
    assert!(found >= 45, "{found} of 50");
}

#[test]
fn three_runs_against_three_are_too_few_however_far_apart() {
    for runs in 1..=4 {
        let (mut campaign, _) = empty();
        let mut draw = Draw::of_seed(3);
        add_runs(&mut campaign, &mut draw, "021", "constant", runs, Times::Constant);
        add_runs(&mut campaign, &mut draw, "021", "rare", runs, Times::Rare);
        let summary = campaign.summary();
        let [comparison] = &summary.comparisons[..] else { panic!("{:?}", summary.comparisons) };
        assert_eq!(comparison.finding, Finding::TooFewRuns);
        let figures = [
            comparison.log_rank_p,
            comparison.log_rank_p_holm,
            comparison.difference_p,
            comparison.difference_p_holm,
            comparison.difference_low_s,
            comparison.difference_high_s,
        ];
        assert_eq!(figures, [None; 6]);
        for row in &summary.rows {
            assert_eq!((row.median_low_s, row.median_high_s), (None, None));
            assert!(row.planner != "constant" || row.restricted_mean_error_s.is_none(), "nothing varies");
            assert!(row.success_low < row.success_high);
        }
        assert!(summary.warnings.iter().any(|warning| {
            warning
                == "Too few runs: 2 of 2 rows have fewer than 6 and no interval of the median; 1 of 1 comparisons could find no \
                    difference whatever the times were."
        }));
        let page = summary.html(&Enclosure::default());
        assert!(page.contains("<td class=\"words\">too few runs</td>") && page.contains("[too few runs]"));
    }
}

/// Scenarios with few runs neither find a difference nor reduce the power for those with many.
#[test]
fn comparisons_of_too_few_runs_are_not_counted_in_the_family() {
    let (mut campaign, _) = empty();
    let mut draw = Draw::of_seed(5);
    for (scenario, runs) in [("021", 20), ("022", 3), ("023", 2)] {
        for (planner, times) in [("quick", Times::Exponential), ("rare", Times::Rare)] {
            add_runs(&mut campaign, &mut draw, scenario, planner, runs, times);
        }
    }
    let found: Vec<(Finding, usize)> =
        campaign.summary().comparisons.iter().map(|own| (own.finding, own.family)).collect();
    assert_eq!(found, [(Finding::FirstIsFaster, 1), (Finding::TooFewRuns, 1), (Finding::TooFewRuns, 1)]);
}
