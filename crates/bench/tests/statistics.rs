//! Statistics against published examples, against other programs, and against their mathematical properties.

#![allow(clippy::float_cmp, reason = "figures that are copied or counted must be the same to the last bit")]

use cranny_bench::statistics::{
    FiveNumbers, Followed, KaplanMeier, MeanSurvival, SampleMoments, TwoSampleTest, holm, least_p, log_rank,
    mean_rate, median_interval, performance_profiles, wilson,
};
use cranny_spatial::Stream;
use proptest::prelude::*;
use serde_json::Value;

/// Returns the reference values made by `fixtures/survival.py`; the file contains the versions used.
fn fixture() -> Value {
    serde_json::from_str(include_str!("fixtures/survival.json")).expect("the fixture is JSON")
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is a number"))
}

fn followed(group: &Value) -> Vec<Followed> {
    let (times, solved) = (group["times"].as_array().unwrap(), group["solved"].as_array().unwrap());
    let trial = |(time, solved): (&Value, &Value)| Followed {
        until: number(time),
        solved: solved.as_bool().expect("solved or not"),
    };
    times.iter().zip(solved).map(trial).collect()
}

#[track_caller]
fn assert_near(actual: f64, expected: f64, tolerance: f64) {
    assert!((actual - expected).abs() <= tolerance, "{actual} is not {expected} within {tolerance}");
}

/// Remission of acute leukaemia in weeks: Freireich et al. 1963, "The effect of 6-mercaptopurine on the
/// duration of steroid-induced remissions in acute leukemia"; a negative number is censored.
const MERCAPTOPURINE: [i32; 21] =
    [6, 6, 6, -6, 7, -9, 10, -10, -11, 13, 16, -17, -19, -20, 22, 23, -25, -32, -32, -34, -35];
const PLACEBO: [i32; 21] = [1, 1, 2, 2, 3, 4, 4, 5, 5, 8, 8, 8, 8, 11, 11, 12, 12, 15, 17, 22, 23];

fn weeks(weeks: &[i32]) -> Vec<Followed> {
    weeks.iter().map(|&week| Followed { until: f64::from(week.abs()), solved: week > 0 }).collect()
}

#[test]
fn the_leukaemia_trial_has_its_published_curve() {
    // Survival and Greenwood's standard error are from Kleinbaum & Klein 2012, "Survival Analysis", chapter 2; Klein &
    // Moeschberger 2003, table 4.1A.
    let published = [
        (6.0, 0.857, 0.0764),
        (7.0, 0.807, 0.0869),
        (10.0, 0.753, 0.0963),
        (13.0, 0.690, 0.1068),
        (16.0, 0.627, 0.1141),
        (22.0, 0.538, 0.1282),
        (23.0, 0.448, 0.1346),
    ];
    let curve = KaplanMeier::of(&weeks(&MERCAPTOPURINE));
    assert_eq!(curve.steps().len(), published.len());
    for (step, (at, survival, error)) in curve.steps().iter().zip(published) {
        assert_eq!(step.at, at);
        assert_near(step.survival, survival, 5e-4);
        assert_near(step.survival * step.greenwood.sqrt(), error, 5e-5);
    }
    assert_eq!(curve.median(), Some(23.0));
    assert_eq!(KaplanMeier::of(&weeks(&PLACEBO)).median(), Some(8.0));
}

#[test]
fn the_leukaemia_trial_has_its_published_restricted_means_and_log_rank_test() {
    // The means to 35 weeks are from Klein & Moeschberger 2003, example 4.2; chi-square 16.79 is in many textbooks.
    let treated = KaplanMeier::of(&weeks(&MERCAPTOPURINE)).restricted_mean(35.0).unwrap();
    assert_near(treated.mean, 23.29, 5e-3);
    assert_near(treated.standard_error.unwrap(), 2.83, 5e-3);
    let control = KaplanMeier::of(&weeks(&PLACEBO)).restricted_mean(35.0).unwrap();
    assert_near(control.mean, 8.67, 5e-3);
    assert_near(control.standard_error.unwrap(), 1.38, 5e-3);
    assert_near(treated.mean - control.mean, 14.62, 5e-3);
    let test = log_rank(&weeks(&MERCAPTOPURINE), &weeks(&PLACEBO)).unwrap();
    assert_near(test.chi_square, 16.79, 5e-3);
    assert_near(test.observed, 9.0, 0.0);
    assert_near(test.expected, 19.25, 5e-3);
}

#[test]
fn curves_medians_and_tests_are_those_of_lifelines() {
    for case in fixture()["survival"].as_array().unwrap() {
        for group in [&case["first"], &case["second"]] {
            let curve = KaplanMeier::of(&followed(group));
            let expected = group["steps"].as_array().unwrap();
            assert_eq!(curve.steps().len(), expected.len(), "{}", case["name"]);
            for (step, expected) in curve.steps().iter().zip(expected) {
                assert_near(step.at, number(&expected[0]), 0.0);
                assert_eq!(step.at_risk as u64, expected[1].as_u64().unwrap());
                assert_eq!(step.solved as u64, expected[2].as_u64().unwrap());
                assert_near(step.survival, number(&expected[3]), 1e-12);
                // lifelines gives the band no width once all are solved; this implementation keeps the upper end.
                if step.survival > 0.0 {
                    assert_near(step.band.low, number(&expected[4]), 1e-9);
                    assert_near(step.band.high, number(&expected[5]), 1e-9);
                }
            }
            assert_eq!(curve.median(), group["median"].as_f64());
            let mean = curve.restricted_mean(number(&group["tau"])).unwrap();
            assert_near(mean.mean, number(&group["restricted_mean"]), 1e-9);
        }
        let test = log_rank(&followed(&case["first"]), &followed(&case["second"])).unwrap();
        assert_near(test.chi_square, number(&case["chi_square"]), 1e-9);
    }
}

#[test]
fn wilson_intervals_are_newcombes_and_scipys() {
    // The values are from Newcombe 1998, table I, method 3.
    for (successes, trials, low, high) in
        [(81, 263, 0.2553, 0.3662), (15, 148, 0.0624, 0.1605), (0, 20, 0.0, 0.1611), (1, 29, 0.0061, 0.1718)]
    {
        let interval = wilson(successes, trials).unwrap();
        assert_near(interval.low, low, 5e-5);
        assert_near(interval.high, high, 5e-5);
    }
    for expected in fixture()["wilson"].as_array().unwrap() {
        let count = |index: usize| usize::try_from(expected[index].as_u64().unwrap()).unwrap();
        let interval = wilson(count(0), count(1)).unwrap();
        assert_near(interval.low, number(&expected[2]), 1e-12);
        assert_near(interval.high, number(&expected[3]), 1e-12);
    }
    assert_eq!(wilson(0, 0), None);
}

#[test]
fn holm_adjusts_as_statsmodels_does() {
    let numbers = |value: &Value| value.as_array().unwrap().iter().map(number).collect::<Vec<_>>();
    for case in fixture()["holm"].as_array().unwrap() {
        for (actual, expected) in holm(&numbers(&case["p"])).into_iter().zip(numbers(&case["adjusted"])) {
            assert_near(actual, expected, 1e-12);
        }
    }
    assert!(holm(&[]).is_empty());
}

fn solved(times: &[f64]) -> Vec<Followed> {
    times.iter().map(|&until| Followed { until, solved: true }).collect()
}

/// Published ranks of the 95 % interval of the median for 6, 10, 20, 50 and 100 values (David & Nagaraja 2003, table 7.1;
/// Conover 1999, "Practical Nonparametric Statistics", table A3).
#[test]
fn intervals_of_the_median_have_the_ranks_of_the_tables() {
    for (count, low, high) in
        [(6, 1, 6), (8, 1, 8), (9, 2, 8), (10, 2, 9), (20, 6, 15), (50, 18, 33), (100, 40, 61)]
    {
        let times: Vec<f64> = (1..=count).rev().map(f64::from).collect();
        assert_eq!(median_interval(&solved(&times)), Some((f64::from(low), Some(f64::from(high)))));
    }
    assert_eq!(median_interval(&solved(&[1.0, 2.0, 3.0, 4.0, 5.0])), None);
    assert_eq!(median_interval(&[]), None);
}

#[test]
fn permutation_tests_of_small_groups_are_exact() {
    // The groups are completely separated: twice one of C(6, 3) and of C(10, 5) divisions.
    let times: Vec<f64> = (1..=10).map(|time| f64::from(time * time)).collect();
    for (first, second, p) in [(3, 3, 0.1), (5, 5, 2.0 / 252.0), (2, 5, 2.0 / 21.0)] {
        let (early, late) = (solved(&times[..first]), solved(&times[first..first + second]));
        let test = TwoSampleTest::of(&early, &late, 200.0, 1);
        assert_near(test.log_rank_p, p, 1e-12);
        assert_near(least_p(first, second), p, 1e-12);
        assert!(test.difference_p >= p - 1e-12 && test.difference < 0.0 && test.log_rank_excess > 0.0);
        assert_eq!(test.interval.is_some(), p < 0.05, "{first} against {second}");
    }
    assert!(least_p(1, 1000) >= 1.0);
    // Without variation there is no error, and no interval without width.
    let same = TwoSampleTest::of(&solved(&[2.0; 8]), &solved(&[2.0; 8]), 9.0, 1);
    assert_eq!((same.log_rank_p, same.difference_p, same.interval), (1.0, 1.0, None));
    let apart = TwoSampleTest::of(&solved(&[2.0; 8]), &solved(&[3.0; 8]), 9.0, 1);
    assert_eq!(apart.interval, None);
    assert_near(apart.difference_p, 2.0 / 12870.0, 1e-12);
}

#[test]
fn random_divisions_of_large_groups_agree_with_the_normal_approximation() {
    // For Freireich 1963, 21 against 21, lifelines has p = 4.2e-5; no p-value is below two of the divisions drawn.
    let test = TwoSampleTest::of(&weeks(&MERCAPTOPURINE), &weeks(&PLACEBO), 35.0, 1);
    assert!(test.log_rank_p <= 1e-3 && test.log_rank_p >= 2.0 / 10_000.0);
    assert_near(test.log_rank_excess, 9.0 - 19.25, 5e-3);
    // Pseudo-values estimate the difference of the areas under the curves.
    assert_near(test.difference, 14.62, 0.5);
    let interval = test.interval.unwrap();
    assert!(
        6.0 < interval.low && interval.low < 9.0 && 20.0 < interval.high && interval.high < 23.0,
        "{interval:?}"
    );
    assert_eq!(test, TwoSampleTest::of(&weeks(&MERCAPTOPURINE), &weeks(&PLACEBO), 35.0, 1), "the same draws");
}

#[test]
fn moments_and_quartiles_of_a_known_sample() {
    // The values are from NumPy: std(ddof=1) and quantile(method="inverted_cdf") of [2, 4, 4, 4, 5, 5, 7, 9].
    let sample = [2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0];
    let moments = SampleMoments::of(&sample).unwrap();
    assert_near(moments.mean, 5.0, 0.0);
    assert_near(moments.standard_deviation.unwrap(), 2.138089935299395, 1e-12);
    let spread = FiveNumbers::of(sample).unwrap();
    assert_eq!((spread.lower_quartile, spread.median, spread.upper_quartile), (4.0, 4.0, 5.0));
    assert_eq!(SampleMoments::of(&[3.0]).unwrap().standard_deviation, None);
    assert_eq!(SampleMoments::of(&[]), None);
    assert_eq!(FiveNumbers::of([]), None);
}

#[test]
fn equal_values_have_no_deviation() {
    // The rounded mean of fifty times 0.2 is not 0.2.
    let moments = SampleMoments::of(&[0.2; 50]).unwrap();
    assert_eq!((moments.mean, moments.standard_deviation), (0.2, Some(0.0)));
}

#[test]
fn a_performance_profile_worked_out_by_hand() {
    // Of three solvers on four problems, none solves the last problem, and two solve the third.
    let costs = [
        vec![Some(1.0), Some(4.0), Some(3.0), None],
        vec![Some(2.0), Some(2.0), None, None],
        vec![Some(10.0), Some(2.0), Some(6.0), None],
    ];
    let profiles = performance_profiles(&costs, 1e-6);
    assert_eq!(profiles[0].ratios, [Some(1.0), Some(2.0), Some(1.0), None]);
    assert_eq!((&profiles[0].at[..], &profiles[0].share[..]), (&[1.0, 2.0][..], &[0.5, 0.75][..]));
    assert_eq!((&profiles[1].at[..], &profiles[1].share[..]), (&[1.0, 2.0][..], &[0.25, 0.5][..]));
    assert_eq!(
        (&profiles[2].at[..], &profiles[2].share[..]),
        (&[1.0, 2.0, 10.0][..], &[0.25, 0.5, 0.75][..])
    );
    assert_eq!([0.9, 1.0, 9.9, 1e9].map(|bound| profiles[2].share_within(bound)), [0.0, 0.25, 0.5, 0.75]);
    // Times below the resolution of the clock are equally good.
    let tied = performance_profiles(&[vec![Some(0.0)], vec![Some(1e-9)]], 1e-6);
    assert_eq!((tied[0].ratios[0], tied[1].ratios[0]), (Some(1.0), Some(1.0)));
    assert!(performance_profiles(&[], 1.0).is_empty());
    assert_eq!(performance_profiles(&[vec![]], 1.0)[0].share_within(2.0), 0.0);
}

#[test]
fn what_was_never_seen_has_no_figure() {
    let unsolved = [Followed { until: 3.0, solved: false }; 4];
    let curve = KaplanMeier::of(&unsolved);
    assert_eq!(curve.median(), None);
    assert_eq!(median_interval(&unsolved), None);
    assert_eq!(median_interval(&[unsolved[0]; 6]), Some((3.0, None)), "longer than the limit");
    assert_eq!(curve.restricted_mean(3.0).unwrap().mean, 3.0);
    assert_eq!(curve.restricted_mean(3.1), None, "nobody knows what comes after the limit");
    assert_eq!(log_rank(&unsolved, &unsolved), None);
    assert_eq!(log_rank(&[], &unsolved), None);
    assert_eq!(KaplanMeier::of(&[]).restricted_mean(0.0), None);
    let all_solved = [Followed { until: 1.0, solved: true }; 4];
    assert_eq!(KaplanMeier::of(&all_solved).restricted_mean(9.0).unwrap().mean, 1.0);
}

#[test]
#[should_panic(expected = "times are finite")]
fn a_time_that_is_no_number_is_refused() {
    KaplanMeier::of(&[Followed { until: f64::NAN, solved: true }]);
}

#[test]
#[should_panic(expected = "3 successes in 2 trials")]
fn more_successes_than_trials_are_refused() {
    wilson(3, 2);
}

fn trials() -> impl Strategy<Value = Vec<Followed>> {
    // A few distinct times give many ties.
    let trial =
        (0_u32..20, any::<bool>()).prop_map(|(time, solved)| Followed { until: f64::from(time), solved });
    prop::collection::vec(trial, 1..40)
}

proptest! {
    #[test]
    fn without_censoring_the_curve_is_the_share_of_later_times(
        times in prop::collection::vec(0_u32..30, 1..40),
        at in 0_u32..30,
    ) {
        let solved = |&time: &u32| Followed { until: f64::from(time), solved: true };
        let curve = KaplanMeier::of(&times.iter().map(solved).collect::<Vec<_>>());
        let later = times.iter().filter(|&&time| time > at).count() as f64 / times.len() as f64;
        prop_assert!((curve.survival_at(f64::from(at)) - later).abs() < 1e-12);
    }

    #[test]
    fn without_censoring_quantiles_are_those_of_the_sample(times in prop::collection::vec(0_u32..30, 1..40)) {
        let solved = |&time: &u32| Followed { until: f64::from(time), solved: true };
        let curve = KaplanMeier::of(&times.iter().map(solved).collect::<Vec<_>>());
        let spread = FiveNumbers::of(times.iter().map(|&time| f64::from(time))).unwrap();
        let quartiles = [spread.lower_quartile, spread.median, spread.upper_quartile];
        prop_assert_eq!([0.25, 0.5, 0.75].map(|share| curve.quantile(share)), quartiles.map(Some));
    }

    #[test]
    fn the_best_solver_of_a_problem_has_ratio_one_and_profiles_rise(
        costs in (1_usize..5, 1_usize..10).prop_flat_map(|(solvers, problems)| {
            let cost = prop::option::weighted(0.8, 0.001..100.0_f64);
            prop::collection::vec(prop::collection::vec(cost, problems), solvers)
        }),
    ) {
        let profiles = performance_profiles(&costs, 1e-6);
        for problem in 0..costs[0].len() {
            let best = profiles.iter().filter_map(|profile| profile.ratios[problem]).fold(f64::INFINITY, f64::min);
            prop_assert!(best == 1.0 || best.is_infinite());
        }
        for (profile, row) in profiles.iter().zip(&costs) {
            prop_assert!(profile.at.is_sorted() && profile.share.is_sorted() && profile.at.iter().all(|&at| at >= 1.0));
            let solved = row.iter().flatten().count() as f64 / row.len() as f64;
            prop_assert!((profile.share.last().copied().unwrap_or(0.0) - solved).abs() < 1e-12);
        }
    }

    #[test]
    fn with_one_limit_for_all_the_restricted_mean_is_the_mean_of_times_cut_at_it(
        times in prop::collection::vec(0.0..10.0_f64, 1..40),
        limit in 1.0..10.0_f64,
    ) {
        let cut = |&time: &f64| Followed { until: time.min(limit), solved: time <= limit };
        let followed: Vec<Followed> = times.iter().map(cut).collect();
        prop_assume!(followed.iter().any(|trial| !trial.solved));
        let mean = KaplanMeier::of(&followed).restricted_mean(limit).unwrap();
        let n = times.len() as f64;
        let expected = followed.iter().map(|trial| trial.until).sum::<f64>() / n;
        let variance = followed.iter().map(|trial| (trial.until - expected).powi(2)).sum::<f64>() / n;
        prop_assert!((mean.mean - expected).abs() < 1e-9);
        prop_assert!((mean.standard_error.unwrap_or(0.0) - (variance / n).sqrt()).abs() < 1e-9);
    }

    #[test]
    fn the_band_holds_the_curve_and_lies_between_zero_and_one(trials in trials()) {
        let curve = KaplanMeier::of(&trials);
        for step in curve.steps() {
            prop_assert!(0.0 <= step.band.low && step.band.low <= step.survival + 1e-12);
            prop_assert!(step.survival <= step.band.high + 1e-12 && step.band.high <= 1.0);
        }
        if let (Some((low, high)), Some(median)) = (median_interval(&trials), curve.median()) {
            prop_assert!(low <= median && high.is_none_or(|high| median <= high));
        }
    }

    #[test]
    fn exchanging_the_groups_changes_no_log_rank_test(first in trials(), second in trials()) {
        match (log_rank(&first, &second), log_rank(&second, &first)) {
            (Some(test), Some(exchanged)) => {
                prop_assert!((test.chi_square - exchanged.chi_square).abs() <= 1e-9 * (1.0 + test.chi_square));
            }
            (test, exchanged) => prop_assert_eq!(test, exchanged),
        }
        // Groups with equal times show no difference.
        if let Some(same) = log_rank(&first, &first) {
            prop_assert!(same.chi_square < 1e-9);
        }
    }

    #[test]
    fn an_exact_p_value_is_a_share_of_all_divisions_and_its_interval_agrees(
        first in prop::collection::vec((0_u32..6, prop::bool::weighted(0.8)), 2..6),
        second in prop::collection::vec((0_u32..6, prop::bool::weighted(0.8)), 2..6),
    ) {
        let followed = |trials: &[(u32, bool)]| -> Vec<Followed> {
            trials.iter().map(|&(time, solved)| Followed { until: f64::from(time), solved }).collect()
        };
        let all = followed(&[&first[..], &second[..]].concat());
        let test = TwoSampleTest::of(&all[..first.len()], &all[first.len()..], 6.0, 1);
        // Every division, as the bits of a number, is evaluated by the log-rank test itself.
        let excess = |bits: u32| {
            let is_first = |trial: &usize| bits >> trial & 1 == 1;
            let (one, other): (Vec<usize>, Vec<usize>) = (0..all.len()).partition(is_first);
            let group = |trials: Vec<usize>| trials.into_iter().map(|trial| all[trial]).collect::<Vec<_>>();
            log_rank(&group(one), &group(other)).map_or(0.0, |test| test.observed - test.expected)
        };
        let divisions = (0_u32..1 << all.len()).filter(|bits| bits.count_ones() as usize == first.len());
        let excesses: Vec<f64> = divisions.map(excess).collect();
        let observed = excess((1 << first.len()) - 1);
        let above = excesses.iter().filter(|excess| **excess >= observed - 1e-9).count();
        let below = excesses.iter().filter(|excess| **excess <= observed + 1e-9).count();
        let p = (2.0 * above.min(below) as f64 / excesses.len() as f64).min(1.0);
        prop_assert!((test.log_rank_p - p).abs() < 1e-12, "{} is not {p}", test.log_rank_p);
        prop_assert!(test.difference_p >= least_p(first.len(), second.len()) - 1e-12);
        if let Some(interval) = test.interval {
            prop_assert!(interval.low < interval.high);
            let excludes_zero = interval.low > 1e-6 || interval.high < -1e-6;
            prop_assert!(!excludes_zero || test.difference_p < 0.05, "{test:?}");
        }
    }

    #[test]
    fn a_wilson_interval_contains_the_rate_and_mirrors(trials in 1_usize..500, share in 0.0..=1.0_f64) {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count that is not negative and small")]
        let successes = (share * trials as f64).round() as usize;
        let (interval, rate) = (wilson(successes, trials).unwrap(), successes as f64 / trials as f64);
        prop_assert!(0.0 <= interval.low && interval.low <= rate && rate <= interval.high && interval.high <= 1.0);
        let mirrored = wilson(trials - successes, trials).unwrap();
        prop_assert!((1.0 - interval.low - mirrored.high).abs() < 1e-12);
    }

    #[test]
    fn holm_keeps_the_order_and_stays_below_bonferroni(p in prop::collection::vec(0.0..=1.0_f64, 1..20)) {
        let adjusted = holm(&p);
        for (i, (&a, &raw)) in adjusted.iter().zip(&p).enumerate() {
            prop_assert!(raw <= a && a <= (p.len() as f64 * raw).min(1.0) + 1e-15);
            for (&b, &other) in adjusted.iter().zip(&p).take(i) {
                prop_assert!(raw == other || (raw < other) == (a < b) || a == b);
            }
        }
    }
}

#[test]
fn the_mean_of_one_group_is_that_group_and_the_number_of_its_trials_gives_no_weight() {
    let (treated, placebo) = (KaplanMeier::of(&weeks(&MERCAPTOPURINE)), KaplanMeier::of(&weeks(&PLACEBO)));
    let alone = MeanSurvival::of(std::slice::from_ref(&treated));
    for (step, own) in alone.steps().iter().zip(treated.steps()) {
        assert_eq!(step.at, own.at);
        assert_near(step.survival, own.survival, 1e-12);
        assert_near(step.band.low, own.band.low, 1e-9);
        assert_near(step.band.high, own.band.high, 1e-9);
    }
    assert_eq!((alone.median(), alone.last()), (treated.median(), treated.last()));
    // Ten times the trials of a group have the same curve, so the mean is the same.
    let many = KaplanMeier::of(&weeks(&PLACEBO.repeat(10)));
    let means = [placebo.clone(), many].map(|placebo| MeanSurvival::of(&[treated.clone(), placebo]));
    for (a, b) in means[0].steps().iter().zip(means[1].steps()) {
        assert_near(a.survival, b.survival, 1e-12);
        assert_near(a.survival, f64::midpoint(treated.survival_at(a.at), placebo.survival_at(a.at)), 1e-12);
        assert!(b.band.high - b.band.low <= a.band.high - a.band.low + 1e-12, "more trials, a narrower band");
    }
    assert_eq!(means[0].median(), Some(12.0));
    let (low, high) = means[0].median_interval();
    assert!(low < Some(12.0) && high > Some(12.0), "{low:?} to {high:?}");
    // Exactly zero where all trials of all groups are solved.
    let solved =
        KaplanMeier::of(&[Followed { until: 0.1, solved: true }, Followed { until: 0.3, solved: true }]);
    let all = MeanSurvival::of(&[solved.clone(), placebo, solved]);
    assert_eq!(all.steps().last().map(|step| step.survival), Some(0.0));
}

/// Groups of known exponential times, of which one is far slower: the interval of the median must not end where the fast group
/// is solved.
#[test]
fn the_interval_of_a_mean_median_keeps_its_level() {
    for (runs, factors) in
        [(8, vec![1.0, 30.0]), (6, vec![1.0, 100.0]), (8, vec![1.0, 3.0, 9.0, 27.0, 81.0, 243.0])]
    {
        let count = factors.len() as f64;
        let survival = |t: f64| factors.iter().map(|factor| libm::exp(-t / factor)).sum::<f64>() / count;
        let (mut low, mut high) = (0.0, 1e4);
        for _ in 0..200 {
            let middle = f64::midpoint(low, high);
            if survival(middle) > 0.5 { low = middle } else { high = middle }
        }
        let mut random = Stream::new(7, runs);
        let mut contained = 0;
        for _ in 0..400 {
            let group = |factor: &f64| {
                let time = |_| Followed { until: -factor * libm::log(random.uniform()), solved: true };
                KaplanMeier::of(&(0..runs).map(time).collect::<Vec<_>>())
            };
            let groups: Vec<KaplanMeier> = factors.iter().map(group).collect();
            let mean = MeanSurvival::of(&groups);
            let (from, to) = mean.median_interval();
            contained += usize::from(from.is_some_and(|from| from <= low) && to.is_none_or(|to| to >= low));
            let falls = |ends: [&cranny_bench::statistics::Interval; 2]| {
                ends[1].low <= ends[0].low && ends[1].high <= ends[0].high
            };
            assert!(mean.steps().windows(2).all(|pair| falls([&pair[0].band, &pair[1].band])));
        }
        assert!(contained >= 368, "{contained} of 400 with {runs} runs and factors {factors:?}");
    }
}

#[test]
fn the_mean_rate_of_one_group_has_the_wilson_interval() {
    let (mean, interval) = mean_rate(&[(7, 10)]).expect("a rate");
    let alone = wilson(7, 10).expect("an interval");
    assert_near(mean, 0.7, 1e-12);
    assert_near(interval.low, alone.low, 1e-12);
    assert_near(interval.high, alone.high, 1e-12);
    let (mean, interval) = mean_rate(&[(10, 10), (0, 1000)]).expect("a rate");
    assert_near(mean, 0.5, 1e-12);
    assert!(interval.low < 0.5 && interval.high > 0.5 && interval.high < 0.51);
    assert_eq!((mean_rate(&[]), mean_rate(&[(1, 1), (0, 0)])), (None, None));
}
