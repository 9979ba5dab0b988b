//! Tables of the page.

use std::fmt::Write as _;

use crate::report::comparison::Finding;
use crate::report::pages::page_figures::{Markup, Shown, escape, words};
use crate::report::paper_table::{PaperTable, shown};
use crate::report::{Enclosure, Row};
use crate::store::run_information::UNKNOWN;
use cranny_file::counted;

/// Rows with their indices in the summary.
pub type Rows<'a> = Vec<(usize, &'a Row)>;

/// Adds a table in the layout of the paper's Table I.
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

/// Adds rates with their intervals, and times as censored data.
pub fn rates_and_times(page: &mut Markup, rows: &Rows) {
    page.text.push_str("<h4>Success and time</h4>\n");
    open_table_of_rows(
        page,
        rows,
        "Times in seconds, with 95 % intervals; the restricted mean with its standard error. Fewer than six runs are too few for an \
         interval of the median.",
        &[
            "success, %",
            "solved",
            "runs",
            "median time",
            "restricted mean",
            "median iterations",
            "<not solved",
        ],
    );
    for (index, row) in rows {
        let at = |key: &str| format!("rows.{index}.{key}");
        let cells = [
            estimate(page, &at("success_rate"), &at("success_low"), &at("success_high"), Shown::Percent),
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
        line_of_row(page, rows, row, &cells);
    }
    page.close_table();
}

/// Opens a table with a line for each row; lines name the scenario only if there are several.
fn open_table_of_rows(page: &mut Markup, rows: &Rows, caption: &str, heads: &[&str]) {
    let subject: &[&str] = if are_of_one(rows) { &["<planner"] } else { &["<scenario", "<planner"] };
    page.open_table(caption, &[subject, heads].concat());
}

fn line_of_row(page: &mut Markup, rows: &Rows, row: &Row, cells: &[String]) {
    if are_of_one(rows) {
        page.table_line(&row.planner_name, cells);
    } else {
        page.table_line(&row.scenario_name, &[&[words(&row.planner_name)], cells].concat());
    }
}

fn are_of_one(rows: &Rows) -> bool {
    rows.windows(2).all(|pair| pair[0].1.scenario_name == pair[1].1.scenario_name)
}

/// Returns the number of runs by outcome without the solved ones, and the verdicts under the other criterion.
fn failures(row: &Row) -> String {
    let failed = row.outcomes.iter().filter(|(outcome, _)| **outcome != "solved");
    let mut parts: Vec<String> = failed.map(|(outcome, count)| format!("{outcome} {count}")).collect();
    if row.also_judged > 0 {
        parts.push(format!("other criterion met by {} of {}", row.also_solved, row.also_judged));
    }
    parts.join(", ")
}

/// Adds the search effort and the properties of the paths.
pub fn paths(page: &mut Markup, rows: &Rows) {
    page.text.push_str("<h4>Search and paths</h4>\n");
    open_table_of_rows(
        page,
        rows,
        "Medians and quartiles of the solved runs, and the most memory that any run took; path length in the plain norm of q. \
         “–” was not measured.",
        &["iterations", "nodes", "path length", "clearance, mm", "grasp score", "memory, MB"],
    );
    for (index, row) in rows {
        let spread = |key: &str, shown: Shown| {
            let at = |part: &str| format!("rows.{index}.{key}.{part}");
            let median = page.figure_as(&at("median"), shown);
            if median == "–" {
                return median;
            }
            format!("{median} {}", page.interval(&at("lower_quartile"), &at("upper_quartile"), shown))
        };
        let cells = [
            spread("iterations", Shown::Count),
            spread("nodes", Shown::Count),
            spread("path_length", Shown::Plain),
            spread("clearance_m", Shown::Millimetres),
            spread("grasp_score", Shown::Plain),
            page.figure_as(&format!("rows.{index}.memory_bytes.greatest"), Shown::Megabytes),
        ];
        line_of_row(page, rows, row, &cells);
    }
    page.close_table();
}

/// Adds the comparisons of pairs of planners.
pub fn comparisons(page: &mut Markup, criterion: &str) {
    let summary = page.summary;
    let of_criterion = || summary.comparisons.iter().enumerate().filter(|(_, c)| c.criterion == criterion);
    if of_criterion().next().is_none() {
        return;
    }
    page.text.push_str("<h3>Planner by planner</h3>\n");
    let count = of_criterion().count();
    page.open_fold(
        &format!("{criterion}-comparisons"),
        &format!("<b>{count} comparisons</b> <span>of two planners on a scenario</span>"),
    );
    page.open_table(
        "Difference of restricted means in seconds, first minus second, with its interval. Permutation tests, adjusted by Holm's \
         method over all comparisons of the report; intervals hold together with 95 %. “Too few runs”: no outcome of so many \
         runs would be significant at 5 %.",
        &[
            "<scenario",
            "<first",
            "<second",
            "<found",
            "runs",
            "log-rank χ²",
            "p (adjusted)",
            "difference, s",
            "p (adjusted)",
            "up to, s",
        ],
    );
    for (index, comparison) in of_criterion() {
        let at = |key: &str| format!("comparisons.{index}.{key}");
        let found = match comparison.finding {
            Finding::TooFewRuns => TOO_FEW_RUNS.to_owned(),
            Finding::NoDifference => "no difference".to_owned(),
            Finding::Differ => "pace and mean differ in opposite senses".to_owned(),
            Finding::FirstIsFaster | Finding::SecondIsFaster => {
                format!("{} is faster", comparison.faster().unwrap_or_default())
            }
        };
        let cells = [
            words(&comparison.first),
            words(&comparison.second),
            words(&found),
            format!("{} / {}", page.figure(&at("first_runs")), page.figure(&at("second_runs"))),
            page.figure(&at("log_rank_chi_square")),
            page.figure_as(&at("log_rank_p_holm"), Shown::Probability),
            match comparison.difference_low_s {
                None => page.figure(&at("difference_s")),
                Some(_) => format!(
                    "{} {}",
                    page.figure(&at("difference_s")),
                    page.interval(&at("difference_low_s"), &at("difference_high_s"), Shown::Plain)
                ),
            },
            page.figure_as(&at("difference_p_holm"), Shown::Probability),
            page.figure(&at("restricted_to_s")),
        ];
        page.table_line(&comparison.scenario_name, &cells);
    }
    page.close_table();
    page.close_fold();
}

/// Adds every goal of planners that aim at one.
pub fn goals(page: &mut Markup, criterion: &str) {
    let summary = page.summary;
    let of_criterion = || summary.goals.iter().enumerate().filter(|(_, goal)| goal.criterion == criterion);
    if of_criterion().next().is_none() {
        return;
    }
    page.text.push_str("<h3>Goal by goal</h3>\n");
    let count = of_criterion().count();
    page.open_fold(
        &format!("{criterion}-goals"),
        &format!("<b>{}</b> <span>of planners that aim at one</span>", counted(count, "goal")),
    );
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
    page.close_fold();
}

/// Adds the trials to inspect first.
pub fn worst(page: &mut Markup, enclosure: &Enclosure) {
    let summary = page.summary;
    page.text.push_str("<section id=\"worst\">\n<h2>Worst trials</h2>\n");
    let count = summary.worst.len();
    page.open_fold(
        "worst-trials",
        &format!("<b>{}</b> <span>what failed, and what took longest</span>", counted(count, "trial")),
    );
    let hint = if enclosure.paths.is_empty() {
        " <code>cranny bench report --paths</code> writes pages that show their paths beside this one."
    } else {
        " “path” links to a page that shows it; most failed trials have none."
    };
    let caption = format!(
        "Unexpected failures first, then unsolved trials, then the slowest solved ones; of a planner on a \
         scenario at most two failures and one solved trial. The command runs a trial again.{hint}"
    );
    page.open_table(
        &caption,
        &[
            "<trial",
            "<scenario",
            "<planner",
            "<criterion",
            "seed",
            "<outcome",
            "time, s",
            "iterations",
            "<again",
            "<detail",
        ],
    );
    for (index, trial) in summary.worst.iter().enumerate() {
        let at = |key: &str| format!("worst.{index}.{key}");
        let goal = trial.goal.map_or_else(String::new, |goal| format!(", goal {goal}"));
        let detail = escape(trial.detail.as_deref().unwrap_or(""));
        let path = enclosure.paths.get(&trial.trial);
        let path = path.map_or_else(String::new, |path| format!("<a href=\"{}\">path</a> ", escape(path)));
        let cells = [
            words(&trial.scenario_name),
            words(&format!("{}{goal}", trial.planner_name)),
            words(&trial.criterion),
            page.figure(&at("seed")),
            words(trial.outcome),
            page.figure(&at("planning_time_s")),
            page.figure(&at("iterations")),
            format!("<td class=\"words\">{path}<code>{}</code></td>", escape(&trial.replay)),
            format!("<td class=\"words long\">{detail}</td>"),
        ];
        page.table_line(&trial.trial.to_string(), &cells);
    }
    page.close_table();
    page.close_fold();
    page.text.push_str("</section>\n");
}

/// Adds the machines on which the times were measured.
pub fn machines(page: &mut Markup) {
    let summary = page.summary;
    page.text.push_str("<section id=\"machines\">\n<h2>Machines</h2>\n");
    page.open_table(
        "On what the trials ran; runs of the same machine, workers, version and commit are one line.",
        &["<machine", "<processor", "workers", "runs", "trials", "<Cranny", "<began (UTC)", "<commands"],
    );
    for (index, machine) in summary.machines.iter().enumerate() {
        let at = |key: &str| format!("machines.{index}.{key}");
        let commit: String = machine.commit.iter().flat_map(|commit| commit.chars().take(10)).collect();
        let began = if machine.runs == 1 {
            machine.first_began.clone()
        } else {
            format!("{} to {}", machine.first_began, machine.last_began)
        };
        let commands: Vec<String> =
            machine.commands.iter().map(|command| format!("<code>{}</code>", escape(command))).collect();
        let (first, others) = commands.split_at(commands.len().min(MOST_COMMANDS));
        let mut cell = first.join("<br>");
        if !others.is_empty() {
            let count = others.len();
            let _ = write!(cell, "<details><summary>{count} more</summary>{}</details>", others.join("<br>"));
        }
        let cells = [
            words(&machine.processor),
            if machine.workers == 0 { words(UNKNOWN) } else { page.figure(&at("workers")) },
            page.figure(&at("runs")),
            page.figure(&at("trials")),
            words(format!("{} {commit}", machine.version).trim()),
            words(&began),
            format!("<td class=\"words long\">{cell}</td>"),
        ];
        page.table_line(&machine.machine, &cells);
    }
    page.close_table();
    split_rows(page);
    page.text.push_str("</section>\n");
}

/// Maximum number of commands of one machine that are visible without opening the fold.
const MOST_COMMANDS: usize = 3;

/// Returns a figure with its interval, or the reason for a missing one; "–" if there is no figure.
pub fn estimate(page: &Markup, value: &str, low: &str, high: &str, shown: Shown) -> String {
    let text = page.figure_as(value, shown);
    if text == "–" {
        text
    } else if page.figure_as(low, shown) == "–" {
        format!("{text} <span class=\"interval\">[{TOO_FEW_RUNS}]</span>")
    } else {
        format!("{text} {}", page.interval(low, high, shown))
    }
}

/// Text instead of tests for which there are too few runs.
const TOO_FEW_RUNS: &str = "too few runs";

/// Adds the rows that pool different conditions, split by condition.
fn split_rows(page: &mut Markup) {
    let summary = page.summary;
    if summary.split_rows.is_empty() {
        return;
    }
    page.text.push_str("<h3>Rows that pool several of them</h3>\n");
    page.open_table(
        "Each share of a row whose times are no sample of one distribution.",
        &["<planner", "<scenario", "<criterion", "<on", "trials", "solved", "median, s"],
    );
    for (index, row) in summary.split_rows.iter().enumerate() {
        let at = |key: &str| format!("split_rows.{index}.{key}");
        let cells = [
            words(&row.scenario_name),
            words(&row.criterion),
            words(&row.on),
            page.figure(&at("trials")),
            page.figure(&at("solved")),
            page.figure_as(&at("median_s"), Shown::TableSeconds),
        ];
        page.table_line(&row.planner_name, &cells);
    }
    page.close_table();
}
