//! Excerpt of a summary that a browser opens at once, however many planners, scenarios and runs there are.

use std::collections::{BTreeMap, BTreeSet};

use cranny_file::counted;

use crate::report::drawn::plot::Plot;
use crate::report::planner_rank::ranked_planners;
use crate::report::{Row, Summary};

/// Maximum number of rows; a row takes about 4 kB, so that a page stays below 3 MB.
const MOST_ROWS: usize = 360;

/// Maximum number of entries of any other list, each of about 1 kB.
const MOST_ENTRIES: usize = 240;

/// Number of planners that have rows, if there are as many, before scenarios are left out.
const LEAST_PLANNERS: usize = 8;

/// Maximum number of machines, and of rows that are split by machine.
const MOST_MACHINES: usize = 100;

/// Maximum number of warnings.
const MOST_WARNINGS: usize = 50;

/// Maximum number of jumps of all curves in the document of a page; the figures of its tables do not need them.
const MOST_JUMPS: usize = 3_000;

/// Maximum size of all plots of a page, in bytes.
const MOST_PLOT_BYTES: usize = 900_000;

/// Content of a page.
pub struct Excerpt<'a> {
    /// The summary with the rows that fit: those of the best planners, on evenly chosen scenarios.
    pub summary: Summary,
    /// Plots that fit: as many of each environment.
    pub plots: Vec<&'a Plot>,
    /// Sentences about what is left out.
    pub notes: Vec<String>,
}

impl<'a> Excerpt<'a> {
    /// Selects the content of a page from a summary and its plots.
    pub fn of(summary: &Summary, plots: &'a [Plot]) -> Self {
        let mut notes = Vec::new();
        let whole = summary.rows.len() <= MOST_ROWS;
        let rows = if whole { summary.rows.clone() } else { chosen_rows(summary, &mut notes) };
        let scenarios: BTreeSet<&str> = rows.iter().map(|row| &*row.scenario_name).collect();
        let cells: BTreeSet<(&str, &str, &str)> = rows.iter().map(cell).collect();
        let listed: BTreeSet<&str> = ranked_planners(&summary.rows).into_iter().take(MOST_ROWS).collect();

        let mut overall: Vec<_> =
            summary.overall.iter().filter(|own| listed.contains(&*own.planner_name)).cloned().collect();
        if !whole {
            for own in &mut overall {
                // Only plots show them.
                own.ratios.clear();
                own.profile_at.clear();
                own.profile_share.clear();
            }
        }
        note(&mut notes, overall.len(), summary.overall.len(), "lines over all scenarios");
        let jumps: usize = summary.curves.iter().map(|curve| curve.at.len()).sum();
        let curves = if jumps <= MOST_JUMPS { summary.curves.clone() } else { Vec::new() };
        note(&mut notes, curves.len(), summary.curves.len(), "curves in its document");
        let goals = summary.goals.iter();
        let goals = goals
            .filter(|goal| cells.contains(&(&*goal.criterion, &*goal.scenario_name, &*goal.planner_name)));
        let goals: Vec<_> = goals.take(MOST_ENTRIES).cloned().collect();
        note(&mut notes, goals.len(), summary.goals.len(), "goals");
        let comparisons = first(&summary.comparisons, MOST_ENTRIES, &mut notes, "comparisons");
        let machines = first(&summary.machines, MOST_MACHINES, &mut notes, "machines");
        let split_rows = first(&summary.split_rows, MOST_MACHINES, &mut notes, "rows split by machine");
        let warnings = first(&summary.warnings, MOST_WARNINGS, &mut notes, "warnings");
        let known_goals = summary.known_goals.iter().filter(|(name, _)| scenarios.contains(&***name));
        let known_goals = known_goals.map(|(name, goals)| (name.clone(), *goals)).collect();

        let fitting = fitting_plots(plots);
        if fitting.len() < plots.len() {
            notes.push(format!("{} of {} plots; `--plots FOLDER` writes all", fitting.len(), plots.len()));
        }
        let summary = Summary {
            results: summary.results.clone(),
            version: summary.version,
            trials: summary.trials,
            warnings,
            machines,
            split_rows,
            overall,
            rows,
            goals,
            known_goals,
            comparisons,
            curves,
            worst: summary.worst.clone(),
        };
        Self { summary, plots: fitting, notes }
    }
}

/// Returns plots of at most [`MOST_PLOT_BYTES`], in their order: the first ones of each environment.
fn fitting_plots(plots: &[Plot]) -> Vec<&Plot> {
    let mut counts: BTreeMap<(&str, Option<&str>), usize> = BTreeMap::new();
    let mut ranked: Vec<(usize, usize)> = Vec::new();
    for (index, plot) in plots.iter().enumerate() {
        let rank = counts.entry((&plot.criterion, plot.environment.as_deref())).or_default();
        ranked.push((*rank, index));
        *rank += 1;
    }
    ranked.sort_unstable();
    let mut bytes = 0;
    let fits = |(_, index): &(usize, usize)| {
        bytes += plots[*index].page_svg().len();
        bytes <= MOST_PLOT_BYTES
    };
    let mut fitting: Vec<usize> = ranked.into_iter().take_while(fits).map(|(_, index)| index).collect();
    fitting.sort_unstable();
    fitting.into_iter().map(|index| &plots[index]).collect()
}

fn cell(row: &Row) -> (&str, &str, &str) {
    (&row.criterion, &row.scenario_name, &row.planner_name)
}

/// Returns the rows of the best planners on evenly chosen scenarios, at most [`MOST_ROWS`].
fn chosen_rows(summary: &Summary, notes: &mut Vec<String>) -> Vec<Row> {
    let scenarios: BTreeSet<(&str, &str)> =
        summary.rows.iter().map(|row| (&*row.criterion, &*row.scenario_name)).collect();
    let scenarios: Vec<(&str, &str)> = scenarios.into_iter().collect();
    let ranked = ranked_planners(&summary.rows);
    let planners = ranked.len().min(LEAST_PLANNERS.max(MOST_ROWS / scenarios.len()));
    let kept: BTreeSet<&str> = ranked.iter().copied().take(planners).collect();
    let count = scenarios.len().min(MOST_ROWS / planners);
    let of_scenarios: BTreeSet<(&str, &str)> =
        (0..count).map(|index| scenarios[index * scenarios.len() / count]).collect();
    let is_chosen = |row: &&Row| {
        kept.contains(&*row.planner_name) && of_scenarios.contains(&(&*row.criterion, &*row.scenario_name))
    };
    let rows: Vec<Row> = summary.rows.iter().filter(is_chosen).cloned().collect();
    notes.push(format!(
        "the rows of the best {} of {} planners on {} of {}",
        planners,
        ranked.len(),
        count,
        counted(scenarios.len(), "scenario")
    ));
    rows
}

/// Returns the first entries of a list, and notes if there are more.
fn first<T: Clone>(list: &[T], most: usize, notes: &mut Vec<String>, what: &str) -> Vec<T> {
    let count = list.len().min(most);
    note(notes, count, list.len(), what);
    list[..count].to_vec()
}

fn note(notes: &mut Vec<String>, count: usize, all: usize, what: &str) {
    if count < all {
        notes.push(format!("{count} of {all} {what}"));
    }
}
