//! The tables of the page.

use std::fmt::Write as _;

use crate::report::Row;
use crate::report::page_figures::{Markup, Shown, escape, words};
use crate::report::paper_table::{PaperTable, shown};

/// The layout of the paper's Table I.
pub fn paper(page: &mut Markup, table: &PaperTable) {
    page.text.push_str("<h3>The paper's table</h3>\n");
    let mut heads = vec!["<scenario"];
    if table.has_goals() {
        heads.push("goals / solved");
    }
    heads.extend(table.columns.iter().map(|column| column.planner_name));
    page.open_table(&escape(&table.note()), &heads);
    for line in &table.lines {
        let mut cells = Vec::new();
        if table.has_goals() {
            cells.push(escape(&line.goals_text()));
        }
        for (column, cell) in table.columns.iter().zip(&line.cells) {
            cells.push(match cell {
                Some((index, row)) if shown(row) => format!(
                    "{}: {}/{}{}",
                    page.figure_as(&format!("rows.{index}.success_rate"), Shown::Percent),
                    page.figure_as(&format!("rows.{index}.mean_s"), Shown::TableSeconds),
                    page.figure_as(&format!("rows.{index}.std_s"), Shown::TableSeconds),
                    column.other_limit(row)
                ),
                _ => "–".to_owned(),
            });
        }
        page.table_line(line.scenario_name, &cells);
    }
    page.close_table();
}

/// Rates with their intervals, times as censored data.
pub fn rates_and_times(page: &mut Markup, criterion: &str) {
    page.text.push_str("<h3>Success and time</h3>\n");
    page.open_table(
        "Times in seconds, with 95 % intervals; the restricted mean with its standard error.",
        &[
            "<scenario",
            "<planner",
            "success, %",
            "solved",
            "runs",
            "median time",
            "restricted mean",
            "median iterations",
            "<not solved",
        ],
    );
    for (index, row) in rows(page, criterion) {
        let at = |key: &str| format!("rows.{index}.{key}");
        let cells = [
            words(&row.planner_name),
            format!(
                "{} {}",
                page.figure_as(&at("success_rate"), Shown::Percent),
                page.interval(&at("success_low"), &at("success_high"), Shown::Percent)
            ),
            page.figure(&at("solved")),
            page.figure(&at("runs")),
            estimate(page, &at("median_s"), &at("median_low_s"), &at("median_high_s"), Shown::Plain),
            format!(
                "{} <span class=\"interval\">± {}</span>",
                page.figure(&at("restricted_mean_s")),
                page.figure(&at("restricted_mean_error_s"))
            ),
            estimate(
                page,
                &at("median_iterations"),
                &at("median_iterations_low"),
                &at("median_iterations_high"),
                Shown::Count,
            ),
            format!("<td class=\"words long\">{}</td>", escape(&failures(row))),
        ];
        page.table_line(&row.scenario_name, &cells);
    }
    page.close_table();
}

/// How many runs ended in which way, the solved ones left out; what the other criterion says of the paths.
fn failures(row: &Row) -> String {
    let failed = row.outcomes.iter().filter(|(outcome, _)| **outcome != "solved");
    let mut parts: Vec<String> = failed.map(|(outcome, count)| format!("{outcome} {count}")).collect();
    if row.also_judged > 0 {
        parts.push(format!("other criterion met by {} of {}", row.also_solved, row.also_judged));
    }
    parts.join(", ")
}

/// What the search cost and what its paths are like.
pub fn paths(page: &mut Markup, criterion: &str) {
    page.text.push_str("<h3>Search and paths</h3>\n");
    page.open_table(
        "Medians and quartiles of the solved runs; path length in the plain norm of q, clearance in millimetres.",
        &["<scenario", "<planner", "solved", "iterations", "nodes", "path length", "clearance, mm", "grasp score"],
    );
    for (index, row) in rows(page, criterion) {
        let spread = |key: &str, shown: Shown| {
            let at = |part: &str| format!("rows.{index}.{key}.{part}");
            let median = page.figure_as(&at("median"), shown);
            if median == "–" {
                return median;
            }
            format!("{median} {}", page.interval(&at("lower_quartile"), &at("upper_quartile"), shown))
        };
        let cells = [
            words(&row.planner_name),
            page.figure(&format!("rows.{index}.solved")),
            spread("iterations", Shown::Count),
            spread("nodes", Shown::Count),
            spread("path_length", Shown::Plain),
            spread("clearance_m", Shown::Millimetres),
            spread("grasp_score", Shown::Plain),
        ];
        page.table_line(&row.scenario_name, &cells);
    }
    page.close_table();
}

/// Pairs of planners.
pub fn comparisons(page: &mut Markup, criterion: &str) {
    let summary = page.summary;
    let of_criterion = || summary.comparisons.iter().enumerate().filter(|(_, c)| c.criterion == criterion);
    if of_criterion().next().is_none() {
        return;
    }
    page.text.push_str("<h3>Planners compared</h3>\n");
    page.open_table(
        "Difference of restricted means in seconds, first minus second, with its 95 % interval. p-values adjusted by Holm's \
         method over the scenarios of each pair; “faster” where the log-rank test finds a difference at 5 %.",
        &[
            "<scenario",
            "<first",
            "<second",
            "log-rank χ²",
            "p (adjusted)",
            "difference, s",
            "p (adjusted)",
            "up to, s",
            "<faster",
        ],
    );
    for (index, comparison) in of_criterion() {
        let at = |key: &str| format!("comparisons.{index}.{key}");
        let cells = [
            words(&comparison.first),
            words(&comparison.second),
            page.figure(&at("log_rank_chi_square")),
            page.figure_as(&at("log_rank_p_holm"), Shown::Probability),
            estimate(
                page,
                &at("difference_s"),
                &at("difference_low_s"),
                &at("difference_high_s"),
                Shown::Plain,
            ),
            page.figure_as(&at("difference_p_holm"), Shown::Probability),
            page.figure(&at("restricted_to_s")),
            words(comparison.faster().unwrap_or("–")),
        ];
        page.table_line(&comparison.scenario_name, &cells);
    }
    page.close_table();
}

/// Every goal of planners that aim at one.
pub fn goals(page: &mut Markup, criterion: &str) {
    let summary = page.summary;
    let of_criterion = || summary.goals.iter().enumerate().filter(|(_, goal)| goal.criterion == criterion);
    if of_criterion().next().is_none() {
        return;
    }
    page.text.push_str("<h3>Goal by goal</h3>\n");
    page.open_table(
        "Each goal by its index in the scenario's IK set; times in seconds, a failure counted as the limit.",
        &["<scenario", "<planner", "goal", "runs", "solved", "success, %", "mean", "std", "<"],
    );
    for (index, goal) in of_criterion() {
        let at = |key: &str| format!("goals.{index}.{key}");
        let cells = [
            words(&goal.planner_name),
            page.figure(&at("goal")),
            page.figure(&at("runs")),
            page.figure(&at("solved")),
            format!(
                "{} {}",
                page.figure_as(&at("success_rate"), Shown::Percent),
                page.interval(&at("success_low"), &at("success_high"), Shown::Percent)
            ),
            page.figure(&at("mean_s")),
            page.figure(&at("std_s")),
            words(if goal.best { "best" } else { "" }),
        ];
        page.table_line(&goal.scenario_name, &cells);
    }
    page.close_table();
}

/// The trials to look at first.
pub fn worst(page: &mut Markup) {
    let summary = page.summary;
    page.text.push_str("<section id=\"worst\">\n<h2>Worst trials</h2>\n");
    page.open_table(
        "What should never happen first, then what was not solved, then what took longest; at most two of a planner on a \
         scenario. The command runs a trial again.",
        &["<trial", "<scenario", "<planner", "<criterion", "seed", "<outcome", "time, s", "iterations", "<again", "<detail"],
    );
    for (index, trial) in summary.worst.iter().enumerate() {
        let at = |key: &str| format!("worst.{index}.{key}");
        let goal = trial.goal.map_or_else(String::new, |goal| format!(", goal {goal}"));
        let detail = escape(trial.detail.as_deref().unwrap_or(""));
        let cells = [
            words(&trial.scenario_name),
            words(&format!("{}{goal}", trial.planner_name)),
            words(&trial.criterion),
            page.figure(&at("seed")),
            words(trial.outcome),
            page.figure(&at("planning_time_s")),
            page.figure(&at("iterations")),
            format!("<td class=\"words\"><code>{}</code></td>", escape(&trial.replay)),
            format!("<td class=\"words long\">{detail}</td>"),
        ];
        page.table_line(&trial.trial.to_string(), &cells);
    }
    page.close_table();
    page.text.push_str("</section>\n");
}

/// Where the times were taken.
pub fn runs(page: &mut Markup) {
    let summary = page.summary;
    page.text.push_str("<section id=\"runs\">\n<h2>Machines</h2>\n");
    page.open_table(
        "The runs that gave the trials.",
        &["<machine", "<processor", "workers", "trials", "<Cranny", "<began (UTC)", "<command"],
    );
    for (index, run) in summary.runs.iter().enumerate() {
        let commit: String = run.commit.iter().flat_map(|commit| commit.chars().take(10)).collect();
        let mut command = String::new();
        let _ = write!(command, "<td class=\"words long\"><code>{}</code></td>", escape(&run.command));
        let cells = [
            words(&run.processor),
            page.figure(&format!("runs.{index}.workers")),
            page.figure(&format!("runs.{index}.trials")),
            words(format!("{} {commit}", run.version).trim()),
            words(&run.began),
            command,
        ];
        page.table_line(&run.machine, &cells);
    }
    page.close_table();
    page.text.push_str("</section>\n");
}

/// A figure with its interval; "–" alone where there is none.
fn estimate(page: &Markup, value: &str, low: &str, high: &str, shown: Shown) -> String {
    let text = page.figure_as(value, shown);
    if text == "–" { text } else { format!("{text} {}", page.interval(low, high, shown)) }
}

fn rows<'a>(page: &Markup<'a>, criterion: &'a str) -> impl Iterator<Item = (usize, &'a Row)> + use<'a> {
    page.summary.rows.iter().enumerate().filter(move |(_, row)| row.criterion == criterion)
}
