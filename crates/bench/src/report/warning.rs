use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use crate::report::comparison::{Comparison, Finding};
use crate::report::configuration::NO_GRASP_SET;
use crate::report::row::Group;
use crate::statistics::LEAST_FOR_MEDIAN;
use crate::store::run_information::UNKNOWN;
use crate::{Isolation, MEGABYTE, Run, RunInformation, StoredTrial, TrialOutcome};
use cranny_file::counted;

/// Returns the warnings about the validity of the figures, in one sentence each.
pub fn warnings(groups: &[Group], runs: &[Run]) -> Vec<String> {
    let used: BTreeSet<u64> = groups.iter().flat_map(|group| &group.runs).map(|trial| trial.run).collect();
    let runs: BTreeMap<u64, &RunInformation> =
        runs.iter().filter(|run| used.contains(&run.id)).map(|run| (run.id, &run.information)).collect();
    let mut warnings = Vec::new();
    if let Some(most) = runs.values().map(|run| run.workers).max().filter(|workers| *workers > 1) {
        warnings.push(format!(
            "Up to {most} trials ran at a time on one machine, so times are longer than those of a machine at rest."
        ));
    }
    let machine =
        |run: &RunInformation| format!("{} ({}, {})", run.machine, run.processor, known(run.cores, "core"));
    warnings.extend(pooled(groups, &runs, "machines", machine));
    let built = |run: &RunInformation| {
        run.commit.as_ref().map_or(run.version.clone(), |commit| format!("{} ({commit})", run.version))
    };
    warnings.extend(pooled(groups, &runs, "versions of Cranny", built));
    warnings.extend(pooled(groups, &runs, "numbers of workers", |run| known(run.workers, "worker")));
    let limit = |run: &RunInformation| {
        run.memory_limit_bytes.map_or_else(|| UNKNOWN.to_owned(), |bytes| format!("{} MB", bytes / MEGABYTE))
    };
    warnings.extend(pooled(groups, &runs, "memory limits", limit));
    let sandbox = |run: &RunInformation| {
        let absent = if run.is_older() { UNKNOWN } else { "none" };
        run.sandbox.clone().unwrap_or_else(|| absent.to_owned())
    };
    warnings.extend(pooled(groups, &runs, "sandboxes", sandbox));
    warnings.extend(without_namespaces(groups, &runs));
    warnings.extend(unknown_sandbox(groups, &runs));
    warnings.extend(other_problem(groups));
    warnings.extend(same_paths(groups));
    warnings.extend(unsolved_for_other_reasons(groups));
    warnings
}

/// Returns a warning about figures without intervals and comparisons without tests, because of too few runs.
pub fn few_runs(groups: &[Group], comparisons: &[Comparison]) -> Option<String> {
    let untested = comparisons.iter().filter(|own| own.finding == Finding::TooFewRuns).count();
    let rows = groups.iter().filter(|group| group.row.runs < LEAST_FOR_MEDIAN).count();
    if untested == 0 && rows == 0 {
        return None;
    }
    let mut sentence = "Too few runs:".to_owned();
    if rows > 0 {
        let of = groups.len();
        let _ = write!(
            sentence,
            " {rows} of {of} rows have fewer than {LEAST_FOR_MEDIAN} and no interval of the median;"
        );
    }
    if untested > 0 {
        let of = comparisons.len();
        let _ = write!(
            sentence,
            " {untested} of {of} comparisons could find no difference whatever the times were;"
        );
    }
    sentence.pop();
    sentence.push('.');
    Some(sentence)
}

/// Returns a warning about rows that pool trials of different `what`.
fn pooled(
    groups: &[Group],
    runs: &BTreeMap<u64, &RunInformation>,
    what: &str,
    of: impl Fn(&RunInformation) -> String,
) -> Option<String> {
    let kinds = |group: &Group| -> BTreeSet<String> {
        group.runs.iter().filter_map(|trial| runs.get(&trial.run)).map(|run| of(run)).collect()
    };
    let mixed: Vec<(&Group, BTreeSet<String>)> =
        groups.iter().map(|group| (group, kinds(group))).filter(|(_, kinds)| kinds.len() > 1).collect();
    let (first, kinds) = mixed.first()?;
    let kinds: Vec<&str> = kinds.iter().map(String::as_str).collect();
    Some(format!(
        "{} of {} rows pool trials of different {what}: that of {} in {} those of {}. Their times are not a \
         sample of one distribution.",
        mixed.len(),
        groups.len(),
        first.row.planner_name,
        first.row.scenario_name,
        kinds.join(" and ")
    ))
}

/// Formats a count of a run, of which 0 stands for an unknown one.
fn known(count: usize, noun: &str) -> String {
    if count == 0 { format!("an unknown number of {noun}s") } else { counted(count, noun) }
}

/// Returns the number of rows of external programs with a trial whose run `is_met`; `None` stands for a missing run.
fn rows_of_programs(
    groups: &[Group],
    runs: &BTreeMap<u64, &RunInformation>,
    is_met: impl Fn(Option<&RunInformation>) -> bool,
) -> usize {
    // All trials of a row have the same planner.
    let is_of_program = |group: &Group| group.runs.iter().any(|trial| !trial.record.trial.is_built_in());
    let has = |group: &Group| group.runs.iter().any(|trial| is_met(runs.get(&trial.run).copied()));
    groups.iter().filter(|group| is_of_program(group) && has(group)).count()
}

/// Returns a warning about rows of external programs that ran without namespaces.
fn without_namespaces(groups: &[Group], runs: &BTreeMap<u64, &RunInformation>) -> Option<String> {
    let rows = rows_of_programs(groups, runs, |run| {
        run.is_some_and(|run| !run.is_older() && !Isolation::text_has_namespaces(run.sandbox.as_deref()))
    });
    (rows > 0).then(|| {
        format!(
            "{rows} of {} rows are of external programs that ran without namespaces: such a program can slow down other \
             trials, and leave notes for its next one.",
            groups.len()
        )
    })
}

/// Returns a warning about rows of external programs whose sandbox is not recorded.
fn unknown_sandbox(groups: &[Group], runs: &BTreeMap<u64, &RunInformation>) -> Option<String> {
    let rows = rows_of_programs(groups, runs, |run| run.is_none_or(RunInformation::is_older));
    (rows > 0).then(|| {
        format!(
            "{rows} of {} rows are of external programs whose sandbox is unknown: their runs are missing, or were recorded by \
             an older version.",
            groups.len()
        )
    })
}

/// Returns a warning if some planners had a grasp set and others had none.
fn other_problem(groups: &[Group]) -> Option<String> {
    let without = groups.iter().filter(|group| group.row.planner_name.contains(NO_GRASP_SET)).count();
    (without > 0 && without < groups.len()).then(|| {
        format!(
            "Planners marked{NO_GRASP_SET} sampled grasps of their own, which is a different problem from \
             that of the others: their figures do not show which planner is better."
        )
    })
}

/// Returns true for a trial of an external program that ended without a path before its limit.
fn is_ended_by_program(trial: &StoredTrial) -> bool {
    let record = &trial.record;
    let has_time_left = record.statistics.planning_time_s < record.trial.time_limit_s;
    !record.trial.is_built_in() && record.outcome.is_stated_without_path() && has_time_left
}

/// Returns warnings for each planner about trials that count as unsolved up to their limit although their search did not show
/// that they are.
fn unsolved_for_other_reasons(groups: &[Group]) -> Vec<String> {
    type Kind = (fn(&StoredTrial) -> bool, &'static str);
    const KINDS: [Kind; 3] = [
        (
            is_ended_by_program,
            "ended without a path before the time limit; whatever the program states about its iterations, they count as \
             unsolved up to the limit",
        ),
        (
            |trial| trial.record.outcome == TrialOutcome::Killed,
            "ended when a signal killed their worker, which a program can do itself; they count as unsolved up to the limit, \
             unless `cranny bench run --again killed` runs them again",
        ),
        (
            |trial| trial.record.outcome == TrialOutcome::Undecided,
            "have no verdict: the judge reached none within its limits, or the program could not be started for lack of resources; they count \
             as unsolved up to the limit",
        ),
    ];
    let mut planners: BTreeMap<&str, (usize, [usize; KINDS.len()])> = BTreeMap::new();
    for group in groups {
        let (all, of_kinds) = planners.entry(&group.row.planner_name).or_default();
        *all += group.runs.len();
        for (count, (is_of_kind, _)) in of_kinds.iter_mut().zip(KINDS) {
            *count += group.runs.iter().filter(|trial| is_of_kind(trial)).count();
        }
    }
    let sentences = |(planner, (all, of_kinds)): (&str, (usize, [usize; KINDS.len()]))| {
        let found = of_kinds.into_iter().zip(KINDS).filter(|(count, _)| *count > 0);
        let sentence = |(count, (_, text)): (usize, Kind)| {
            format!("{count} of {} of {planner} {text}.", counted(all, "trial"))
        };
        found.map(sentence).collect::<Vec<_>>()
    };
    planners.into_iter().flat_map(sentences).collect()
}

/// Returns a warning for each planner that gave the same path under different seeds.
fn same_paths(groups: &[Group]) -> Vec<String> {
    let mut places: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for group in groups {
        let mut seeds: BTreeMap<(u64, Option<usize>), BTreeSet<u64>> = BTreeMap::new();
        for trial in group.runs.iter().filter(|trial| trial.record.is_solved()) {
            // Two paths to the same grasp with exactly the same length count as one path.
            if let Some(length) = trial.record.path_length {
                seeds
                    .entry((length.to_bits(), trial.record.grasp))
                    .or_default()
                    .insert(trial.record.trial.seed);
            }
        }
        let solved: usize = seeds.values().map(BTreeSet::len).sum();
        let same: usize = seeds.values().map(BTreeSet::len).filter(|seeds| *seeds > 1).sum();
        if same > 0 {
            let place = format!("{same} of {solved} in {}", group.row.scenario_name);
            places.entry(&group.row.planner_name).or_default().push(place);
        }
    }
    let sentence = |(planner, places): (&str, Vec<String>)| {
        /// Maximum number of scenarios that are named.
        const MOST: usize = 5;
        let others = places.len().saturating_sub(MOST);
        let others = if others > 0 {
            format!(", and in {}", counted(others, "other scenario"))
        } else {
            String::new()
        };
        let places = &places[..places.len().min(MOST)];
        format!(
            "Paths of {planner} are the same as under another seed: {}{others}. It ignores the seed, caches answers, \
             or, if they are few, the path is obvious.",
            places.join(", ")
        )
    };
    places.into_iter().map(sentence).collect()
}
