//! Environments and their scenarios, in collapsible sections.

use std::fmt::Write as _;

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;

use crate::report::drawn::plot::Plot;
use crate::report::drawn::success_curve::MOST_CURVES;
use crate::report::enclosure::{Enclosure, Png};
use crate::report::pages::page_figures::{Markup, Shown, anchor, escape};
use crate::report::pages::page_overall::figures;
use crate::report::pages::page_tables::{self, Rows};
use cranny_file::counted;

/// Adds one environment: a section with its plots, then one for each scenario. A large environment has joint tables for all.
pub fn environment(page: &mut Markup, criterion: &str, name: &str, plots: &[&Plot], enclosure: &Enclosure) {
    let summary = page.summary;
    let is_here = |row: &crate::report::Row| row.criterion == criterion && row.environment == name;
    let rows: Rows = summary.rows.iter().enumerate().filter(|(_, row)| is_here(row)).collect();
    let mut scenarios: Vec<&str> = rows.iter().map(|(_, row)| row.scenario_name.as_str()).collect();
    scenarios.dedup();
    let id = anchor(&[criterion, name]);
    let _ = writeln!(page.text, "<h3 id=\"{id}\">{}</h3>", escape(name));
    let is_large = scenarios.len() > MOST_CURVES;
    let (of_one, of_all): (Vec<&Plot>, Vec<&Plot>) =
        plots.iter().partition(|plot| plot.scenario_name.is_some());
    let count = scenarios.len();
    page.open_fold(
        &anchor(&[criterion, name, "all"]),
        &match (is_large, count) {
            (true, _) => format!("All {}: plots and tables", counted(count, "scenario")),
            (false, 1) => "Plots by planner".to_owned(),
            (false, _) => format!("All {count} scenarios: plots by planner, difficulty and quartiles"),
        },
    );
    figures(page, &of_all);
    if is_large {
        gallery(page, &scenarios, enclosure);
        page_tables::rates_and_times(page, &rows);
        page_tables::paths(page, &rows);
    }
    page.close_fold();
    if is_large {
        return;
    }
    for scenario in scenarios {
        let own: Rows = rows.iter().copied().filter(|(_, row)| row.scenario_name == scenario).collect();
        let line = summary_line(page, scenario, &own);
        page.open_fold(&anchor(&[criterion, scenario]), &line);
        page.text.push_str("<div class=\"figures\">\n");
        picture(page, scenario, enclosure);
        for plot in of_one.iter().filter(|plot| plot.scenario_name.as_deref() == Some(scenario)) {
            let _ = writeln!(page.text, "<figure>{}</figure>", plot.page_svg());
        }
        page.text.push_str("</div>\n");
        page_tables::rates_and_times(page, &own);
        page_tables::paths(page, &own);
        page.close_fold();
    }
}

/// Returns the title line of a scenario: its name and the success rate of each planner.
fn summary_line(page: &Markup, scenario: &str, rows: &Rows) -> String {
    let rate = |(index, row): &(usize, &crate::report::Row)| {
        let rate = page.figure_as(&format!("rows.{index}.success_rate"), Shown::Percent);
        format!("<span class=\"rate\">{} {rate} %</span>", escape(&row.planner_name))
    };
    let rates: Vec<String> = rows.iter().map(rate).collect();
    format!("<b>{}</b> {}", escape(scenario), rates.join(" "))
}

/// Adds the pictures of many scenarios, small, and one note about missing ones.
fn gallery(page: &mut Markup, scenarios: &[&str], enclosure: &Enclosure) {
    let pictures = || scenarios.iter().filter_map(|name| Some((*name, enclosure.pictures.get(*name)?)));
    let missing: Vec<&str> =
        pictures().filter_map(|(_, picture)| picture.as_ref().err()).map(String::as_str).collect();
    if pictures().count() > missing.len() {
        page.text.push_str("<div class=\"gallery\">\n");
        for (name, _) in pictures().filter(|(_, picture)| picture.is_ok()) {
            picture(page, name, enclosure);
        }
        page.text.push_str("</div>\n");
    }
    if let [first, ..] = missing[..] {
        let _ = writeln!(
            page.text,
            "<p class=\"quiet\">No picture of {} of these scenarios: {}.</p>",
            missing.len(),
            escape(first)
        );
    }
}

fn picture(page: &mut Markup, scenario: &str, enclosure: &Enclosure) {
    let name = escape(scenario);
    let _ = match enclosure.pictures.get(scenario) {
        None => Ok(()),
        Some(Ok(Png { width, height, bytes })) => writeln!(
            page.text,
            "<figure class=\"scene\"><img width=\"{width}\" height=\"{height}\" alt=\"Scenario {name}, the robot at its \
             start\" src=\"data:image/png;base64,{}\"><figcaption class=\"quiet\">{name}, the robot at its \
             start</figcaption></figure>",
            BASE64_STANDARD.encode(bytes)
        ),
        Some(Err(reason)) => {
            writeln!(page.text, "<p class=\"quiet\">No picture of {name}: {}.</p>", escape(reason))
        }
    };
}
