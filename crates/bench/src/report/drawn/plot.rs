use crate::BenchError;
use crate::report::drawn::axis::Axis;
use crate::report::drawn::drawing::Drawing;
use crate::report::drawn::picture;
use crate::report::{Measure, Row, Summary};

/// A picture of a report.
#[derive(Clone, Debug, PartialEq)]
pub struct Plot {
    /// What stands above it.
    pub title: String,
    /// Name of its files, without ending: small letters, digits and hyphens.
    pub name: String,
    /// What it is about, which the page sorts by.
    pub criterion: String,
    /// The environment of its scenarios; none where it is about all scenarios.
    pub environment: Option<String>,
    /// The one scenario that it is about, as in [`Row::scenario_name`].
    pub scenario_name: Option<String>,
    drawing: Drawing,
}

/// What a plot may be about.
#[derive(Clone, Copy)]
pub struct Scope<'a> {
    pub summary: &'a Summary,
    pub criterion: &'a str,
    /// None: all scenarios.
    pub environment: Option<&'a str>,
}

impl<'a> Scope<'a> {
    /// What a title calls it.
    pub fn name(self) -> &'a str {
        self.environment.unwrap_or("all scenarios")
    }

    /// The rows of one environment, or of all, under one criterion.
    pub fn rows(self) -> impl Iterator<Item = &'a Row> + Clone {
        let is_here = move |row: &&Row| {
            row.criterion == self.criterion && self.environment.is_none_or(|name| row.environment == name)
        };
        self.summary.rows.iter().filter(is_here)
    }

    /// The axis of times, the same in all plots of a report, so that they can be compared by eye: logarithmic, from the
    /// power of ten below the shortest time to the longest limit.
    pub fn time_axis(self, label: &str) -> Axis {
        let rows = &self.summary.rows;
        let times_s = rows.iter().filter_map(|row| row.least_s).filter(|time_s| *time_s > 0.0);
        let limit_s = rows.iter().map(|row| row.time_limit_s).fold(0.0, f64::max);
        Axis::decades(label, times_s.min_by(f64::total_cmp), limit_s).with_tick_at_end()
    }

    /// The axis of iterations, the same in all plots of a report.
    pub fn iteration_axis(self, label: &str) -> Axis {
        let curves = || self.summary.curves.iter().filter(|curve| curve.over == Measure::Iterations);
        let least = curves().filter_map(|curve| curve.at.first().copied()).filter(|count| *count > 0.0);
        Axis::decades(
            label,
            least.min_by(f64::total_cmp),
            curves().map(|curve| curve.until).fold(0.0, f64::max),
        )
    }

    /// The names of those rows' planners, in order, each with the index of its colour, which is the same in
    /// all plots.
    pub fn planners(self) -> Vec<(usize, &'a str)> {
        let names = self.summary.planner_names().into_iter().enumerate();
        names.filter(|(_, name)| self.rows().any(|row| row.planner_name == *name)).collect()
    }

    /// The names of the scenarios, in order.
    pub fn scenarios(self) -> Vec<&'a str> {
        let mut names: Vec<&str> = self.rows().map(|row| row.scenario_name.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        names
    }

    /// A plot about it; `subject` are the words that tell it from the other plots.
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
    /// The same plot, said to be about one scenario alone.
    pub(crate) fn of_scenario(self, scenario_name: &str) -> Self {
        Self { scenario_name: Some(scenario_name.to_owned()), ..self }
    }

    /// The picture within a page, whose style sheet gives the colours.
    pub(crate) fn page_svg(&self) -> String {
        picture::page_svg(&self.drawing, &self.title)
    }

    /// The picture as an SVG file.
    pub fn svg(&self) -> String {
        picture::svg(&self.drawing)
    }

    /// The picture as a PDF file: lines and letters, in a font that it holds.
    ///
    /// # Errors
    /// [`BenchError::Picture`].
    pub fn pdf(&self) -> Result<Vec<u8>, BenchError> {
        picture::pdf(&self.drawing)
            .map_err(|problem| BenchError::Picture { plot: self.name.clone(), problem })
    }

    /// The picture as a PNG file, 960 pixels wide.
    ///
    /// # Errors
    /// [`BenchError::Picture`].
    pub fn png(&self) -> Result<Vec<u8>, BenchError> {
        picture::png(&self.drawing)
            .map_err(|problem| BenchError::Picture { plot: self.name.clone(), problem })
    }
}

fn file_name(words: &str) -> String {
    let letters = words.to_lowercase().replace('⁺', "plus");
    let parts: Vec<&str> =
        letters.split(|c: char| !c.is_ascii_alphanumeric()).filter(|part| !part.is_empty()).collect();
    parts.join("-")
}
