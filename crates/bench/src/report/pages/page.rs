use std::fmt::Write as _;

use crate::report::drawn::plot::Plot;
use crate::report::drawn::plots::plots;
use crate::report::pages::page_excerpt::Excerpt;
use crate::report::pages::page_figures::{Markup, anchor, escape};
use crate::report::pages::{page_overall, page_scenarios, page_tables};
use crate::report::paper_table::PaperTable;
use crate::report::{Enclosure, Summary};

const STYLE: &str = include_str!("page.css");

/// Explanation of the figures for the reader.
const MEANING: &str = include_str!("page_meaning.html");

/// Script that opens every fold for printing, in browsers whose style sheets cannot.
const SCRIPT: &str = "for (const [name, open] of [['beforeprint', true], ['afterprint', false]]) {
  addEventListener(name, () => {
    for (const fold of document.querySelectorAll(open ? 'details:not([open])' : 'details[data-printed]')) {
      fold.open = open;
      fold.toggleAttribute('data-printed', open);
    }
  });
}";

impl Summary {
    /// Returns a self-contained page, with pictures and style: it opens from a file without a network. Each figure is in an
    /// element with its path (`data-path`) in the JSON document, which the page contains too, with all digits, as
    /// `<script type="application/json" id="summary">`.
    ///
    /// A page has less than 3 MB with pictures of 20 scenarios: at most 360 rows, 240 comparisons, 0.9 MB of plots and 3000 jumps of
    /// curves. Of more, it and its document contain an excerpt: the rows of the best planners on evenly chosen scenarios, the first comparisons, and as many
    /// plots of each environment; the page states what is left out.
    pub fn html(&self, enclosure: &Enclosure) -> String {
        let all_plots = plots(self);
        let Excerpt { summary, plots, notes } = Excerpt::of(self, &all_plots);
        let mut page = Markup::new(&summary);
        let title = format!("Benchmark report: {}", self.results);
        let _ = write!(
            page.text,
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n",
            title = escape(&title)
        );
        head(&mut page, &notes);
        for criterion in summary.criteria() {
            let of_criterion: Vec<&Plot> =
                plots.iter().copied().filter(|plot| plot.criterion == criterion).collect();
            section(&mut page, criterion, &of_criterion, enclosure);
        }
        page_tables::worst(&mut page, enclosure);
        page_tables::machines(&mut page);
        page.text.push_str(MEANING);
        let json = page.json.replace('<', "\\u003c");
        let _ = write!(
            page.text,
            "<script type=\"application/json\" id=\"summary\">{json}</script>\n<script>{SCRIPT}</script>\n</body>\n</html>\n"
        );
        page.text
    }
}

/// Maximum number of planners that the first sentence names.
const MOST_NAMES: usize = 20;

fn head(page: &mut Markup, notes: &[String]) {
    let summary = page.summary;
    let names = summary.planner_names();
    let mut planners = escape(&names[..names.len().min(MOST_NAMES)].join(", "));
    if names.len() > MOST_NAMES {
        let _ = write!(planners, " and {} others", names.len() - MOST_NAMES);
    }
    let trials = page.figure("trials");
    let _ = writeln!(
        page.text,
        "<p>{trials} trials of {planners}; judged under the {} {}. Made by Cranny {}.</p>",
        if summary.criteria().len() == 1 { "criterion" } else { "criteria" },
        summary.criteria().join(" and "),
        escape(summary.version)
    );
    for warning in &summary.warnings {
        let _ = writeln!(page.text, "<p class=\"warning\">{}</p>", escape(warning));
    }
    if !notes.is_empty() {
        let _ = writeln!(
            page.text,
            "<p class=\"warning\">This page is an excerpt, so that a browser opens it at once: it shows {}. The formats json \
             and csv of the report have every row.</p>",
            escape(&notes.join("; "))
        );
    }
    page.text.push_str("<nav aria-label=\"Contents\"><ul>\n");
    for criterion in summary.criteria() {
        let _ = writeln!(page.text, "<li><a href=\"#{criterion}\">Criterion {criterion}</a></li>");
        for environment in summary.environments(criterion) {
            // This is the short name of an environment of the paper: `02x: ball under a table`.
            let short = environment.split_once(": ").map_or(environment, |(short, _)| short);
            let place = anchor(&[criterion, environment]);
            let _ = writeln!(page.text, "<li><a href=\"#{place}\">{}</a></li>", escape(short));
        }
    }
    page.text.push_str(
        "<li><a href=\"#worst\">Worst trials</a></li>\n<li><a href=\"#machines\">Machines</a></li>\n\
         <li><a href=\"#meaning\">What the figures mean</a></li>\n</ul></nav>\n",
    );
}

fn section(page: &mut Markup, criterion: &str, plots: &[&Plot], enclosure: &Enclosure) {
    let summary = page.summary;
    let _ = writeln!(page.text, "<section id=\"{criterion}\">\n<h2>Criterion {criterion}</h2>");
    if criterion == "paper" {
        page.text.push_str(
            "<p>The released planners' own loose measure, for comparison with published results only.</p>\n",
        );
    }
    let of = |environment: Option<&str>| -> Vec<&Plot> {
        plots.iter().copied().filter(|plot| plot.environment.as_deref() == environment).collect()
    };
    page_overall::overall(page, criterion, &of(None));
    page_tables::paper(page, &PaperTable::of(summary, criterion));
    for environment in summary.environments(criterion) {
        page_scenarios::environment(page, criterion, environment, &of(Some(environment)), enclosure);
    }
    page_tables::comparisons(page, criterion);
    page_tables::goals(page, criterion);
    page.text.push_str("</section>\n");
}
