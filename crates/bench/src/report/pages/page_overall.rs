//! Section of the page on all scenarios of a criterion.

use std::fmt::Write as _;

use crate::report::drawn::plot::Plot;
use crate::report::pages::page_figures::{Markup, Shown};
use crate::report::pages::page_tables::estimate;

/// Place of the column of claims among the cells, if there is one: after the solved runs.
const OF_CLAIMS: usize = 2;

/// Adds a table with one line for each planner, the mean curves and the performance profile.
pub fn overall(page: &mut Markup, criterion: &str, plots: &[&Plot]) {
    let summary = page.summary;
    let of_criterion = || summary.overall.iter().enumerate().filter(|(_, own)| own.criterion == criterion);
    let Some((first, _)) = of_criterion().next() else {
        let rows = summary.rows.iter().filter(|row| row.criterion == criterion);
        let names: std::collections::BTreeSet<_> = rows.map(|row| &row.scenario_name).collect();
        if names.len() > 1 {
            page.text.push_str(
                "<p>The planners share fewer than two scenarios: there are no figures over all \
                 scenarios.</p>\n",
            );
        }
        return;
    };
    page.text.push_str("<h3>Over all scenarios</h3>\n");
    let at = |key: &str| format!("overall.{first}.{key}");
    let caption = format!(
        "The {} of {} scenarios that every planner has runs on. Each scenario counts the same, however many runs it has; times are followed \
         to the shortest limit, {} s. Shares of scenarios by the median time on each: fastest, and within twice and ten times the fastest.",
        page.figure(&at("scenarios")),
        page.figure(&at("scenarios_in_all")),
        page.figure(&at("followed_to_s")),
    );
    let has_claims = of_criterion().any(|(_, own)| own.claimed > 0);
    let mut heads = vec![
        "<planner",
        "success, %",
        "solved",
        "runs",
        "median time, s",
        "fastest, %",
        "≤ 2×, %",
        "≤ 10×, %",
    ];
    if has_claims {
        heads.insert(OF_CLAIMS + 1, "claimed, not proven");
    }
    page.open_table(&caption, &heads);
    for (index, own) in of_criterion() {
        let at = |key: &str| format!("overall.{index}.{key}");
        let mut cells = vec![
            estimate(page, &at("success_rate"), &at("success_low"), &at("success_high"), Shown::Percent),
            page.figure(&at("solved")),
            page.figure(&at("runs")),
            estimate(page, &at("median_s"), &at("median_low_s"), &at("median_high_s"), Shown::Plain),
            page.figure_as(&at("best"), Shown::Percent),
            page.figure_as(&at("within_2"), Shown::Percent),
            page.figure_as(&at("within_10"), Shown::Percent),
        ];
        if has_claims {
            cells.insert(OF_CLAIMS, page.figure(&at("claimed")));
        }
        page.table_line(&own.planner_name, &cells);
    }
    page.close_table();
    figures(page, plots);
}

/// Adds plots beside each other, as many as fit.
pub fn figures(page: &mut Markup, plots: &[&Plot]) {
    if plots.is_empty() {
        return;
    }
    page.text.push_str("<div class=\"figures\">\n");
    for plot in plots {
        let _ = writeln!(page.text, "<figure>{}</figure>", plot.page_svg());
    }
    page.text.push_str("</div>\n");
}
