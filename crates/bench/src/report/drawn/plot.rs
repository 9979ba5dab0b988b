use cranny_chart::{Axis, ChartError, Drawing};

use crate::BenchError;
use crate::report::{Measure, Row, Summary};

/// Plot of a report.
#[derive(Clone, Debug, PartialEq)]
pub struct Plot {
    /// Title above the plot.
    pub title: String,
    /// Name of its files, without extension: small letters, digits and hyphens.
    pub name: String,
    /// Criterion of its runs, by which the page sorts.
    pub criterion: String,
    /// Environment of its scenarios; `None` if it covers all scenarios.
    pub environment: Option<String>,
    /// The only scenario of the plot, as in [`Row::scenario_name`].
    pub scenario_name: Option<String>,
    drawing: Drawing,
}

/// Selection of the rows that a plot covers.
#[derive(Clone, Copy)]
pub struct Scope<'a> {
    pub summary: &'a Summary,
    pub criterion: &'a str,
    /// Environment; `None` selects all scenarios.
    pub environment: Option<&'a str>,
    /// The planners that the report draws, in the order of their names; the index of a planner is that of its colour.
    pub drawn: &'a [&'a str],
    /// Number of all planners.
    pub planners_in_all: usize,
}

impl<'a> Scope<'a> {
    /// Returns the name in titles.
    pub fn name(self) -> &'a str {
        self.environment.unwrap_or("all scenarios")
    }

    /// Returns the rows of one environment, or of all, under one criterion, of the planners that are drawn.
    pub fn rows(self) -> impl Iterator<Item = &'a Row> + Clone {
        let is_here = move |row: &&Row| {
            row.criterion == self.criterion
                && self.environment.is_none_or(|name| row.environment == name)
                && self.drawn.binary_search(&&*row.planner_name).is_ok()
        };
        self.summary.rows.iter().filter(is_here)
    }

    /// Returns the axis of times, the same in all plots of a report: logarithmic, from the power of ten below the shortest time
    /// to the longest limit.
    pub fn time_axis(self, label: &str) -> Axis {
        let rows = &self.summary.rows;
        let times_s = rows.iter().filter_map(|row| row.least_s).filter(|time_s| *time_s > 0.0);
        let limit_s = rows.iter().map(|row| row.time_limit_s).fold(0.0, f64::max);
        Axis::decades(label, times_s.min_by(f64::total_cmp), limit_s).with_tick_at_end()
    }

    /// Returns the axis of iterations, identical in all plots of a report.
    pub fn iteration_axis(self, label: &str) -> Axis {
        let curves = || self.summary.curves.iter().filter(|curve| curve.over == Measure::Iterations);
        let least = curves().filter_map(|curve| curve.at.first().copied()).filter(|count| *count > 0.0);
        Axis::decades(
            label,
            least.min_by(f64::total_cmp),
            curves().map(|curve| curve.until).fold(0.0, f64::max),
        )
    }

    /// Returns the names of the planners of these rows, in order, each with the index of its colour, the same in all plots.
    pub fn planners(self) -> Vec<(usize, &'a str)> {
        let names = self.drawn.iter().copied().enumerate();
        names.filter(|(_, name)| self.rows().any(|row| row.planner_name == *name)).collect()
    }

    /// Returns a title, with a note if some planners are not drawn.
    pub fn title(self, title: String) -> String {
        let (drawn, all) = (self.drawn.len(), self.planners_in_all);
        if drawn == all { title } else { format!("{title} ({drawn} of {all} planners)") }
    }

    /// Returns the names of the scenarios, in order.
    pub fn scenarios(self) -> Vec<&'a str> {
        let mut names: Vec<&str> = self.rows().map(|row| row.scenario_name.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        names
    }

    /// Creates a plot of this scope; the words of `subject` distinguish it from other plots.
    pub fn plot(self, title: String, subject: &[&str], drawing: Drawing) -> Plot {
        let mut words = vec![self.name()];
        words.extend_from_slice(subject);
        words.push(self.criterion);
        Plot {
            title,
            name: file_name(&words.join(" ")),
            criterion: self.criterion.to_owned(),
            environment: self.environment.map(str::to_owned),
            scenario_name: None,
            drawing,
        }
    }
}

impl Plot {
    /// Returns the plot assigned to one scenario.
    pub(crate) fn of_scenario(self, scenario_name: &str) -> Self {
        Self { scenario_name: Some(scenario_name.to_owned()), ..self }
    }

    /// Returns the plot as SVG within a page, whose style sheet defines the colours.
    pub(crate) fn page_svg(&self) -> String {
        self.drawing.page_svg(&self.title)
    }

    /// Returns the plot as an SVG file.
    pub fn svg(&self) -> String {
        self.drawing.svg()
    }

    /// Returns the plot as a PDF file of lines, areas and outlines of letters, which needs no font.
    ///
    /// # Errors
    /// [`BenchError::Picture`].
    pub fn pdf(&self) -> Result<Vec<u8>, BenchError> {
        self.drawing.pdf().map_err(|reason| self.fault(reason))
    }

    /// Returns the plot as a PNG file, 960 pixels wide.
    ///
    /// # Errors
    /// [`BenchError::Picture`].
    pub fn png(&self) -> Result<Vec<u8>, BenchError> {
        self.drawing.png().map_err(|reason| self.fault(reason))
    }

    fn fault(&self, reason: ChartError) -> BenchError {
        BenchError::Picture { plot: self.name.clone(), reason }
    }
}

fn file_name(words: &str) -> String {
    let letters = words.to_lowercase().replace('⁺', "plus");
    let parts: Vec<&str> =
        letters.split(|c: char| !c.is_ascii_alphanumeric()).filter(|part| !part.is_empty()).collect();
    parts.join("-")
}
