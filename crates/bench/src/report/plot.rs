use crate::BenchError;
use crate::report::drawing::Drawing;
use crate::report::{Summary, box_plot, difficulty_plot, picture, success_plot};

/// A picture of a report.
#[derive(Clone, Debug, PartialEq)]
pub struct Plot {
    /// What stands above it.
    pub title: String,
    /// Name of its files, without ending: small letters, digits and hyphens.
    pub name: String,
    /// What it is about, which the page sorts by.
    pub criterion: String,
    /// The environment of its scenarios.
    pub environment: String,
    drawing: Drawing,
}

/// All plots of a summary, in the order of the page: by criterion, then by environment.
pub fn plots(summary: &Summary) -> Vec<Plot> {
    let mut plots = Vec::new();
    for criterion in summary.criteria() {
        let mut environments: Vec<&str> = summary
            .rows
            .iter()
            .filter(|row| row.criterion == criterion)
            .map(|row| row.environment.as_str())
            .collect();
        environments.sort_unstable();
        environments.dedup();
        for environment in environments {
            let scope = Scope { summary, criterion, environment };
            plots.extend(success_plot::plots(scope));
            plots.extend(difficulty_plot::plots(scope));
            plots.extend(box_plot::plots(scope));
        }
    }
    let mut taken = std::collections::BTreeMap::<String, usize>::new();
    for plot in &mut plots {
        // Two planners may differ in characters that a file name does not have.
        let count = taken.entry(plot.name.clone()).or_default();
        *count += 1;
        if *count > 1 {
            plot.name = format!("{}-{count}", plot.name);
        }
    }
    plots
}

/// What a plot may be about.
#[derive(Clone, Copy)]
pub struct Scope<'a> {
    pub summary: &'a Summary,
    pub criterion: &'a str,
    pub environment: &'a str,
}

impl<'a> Scope<'a> {
    /// The rows of one environment under one criterion.
    pub fn rows(self) -> impl Iterator<Item = &'a crate::report::Row> + Clone {
        self.summary
            .rows
            .iter()
            .filter(move |row| row.criterion == self.criterion && row.environment == self.environment)
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
        let mut words = vec![self.environment];
        words.extend_from_slice(subject);
        words.push(self.criterion);
        Plot {
            title,
            name: file_name(&words.join(" ")),
            criterion: self.criterion.to_owned(),
            environment: self.environment.to_owned(),
            drawing,
        }
    }
}

impl Plot {
    /// The picture within a page, whose style sheet gives the colours.
    pub(crate) fn page_svg(&self) -> String {
        picture::page_svg(&self.drawing, &self.title)
    }

    /// The picture as an SVG file.
    pub fn svg(&self) -> String {
        picture::svg(&self.drawing)
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
