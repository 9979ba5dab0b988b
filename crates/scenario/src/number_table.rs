use std::path::Path;

use cranny_robot::Location;

use crate::{ScenarioError, yaml};

/// The lines of a file of comma-separated numbers, each with where it stands; blank lines are left out.
pub(crate) fn read(path: &Path) -> Result<Vec<(Location, Vec<f64>)>, ScenarioError> {
    parse(path, &yaml::text(path)?)
}

/// The same of a text; errors name `path`.
pub(crate) fn parse(path: &Path, text: &str) -> Result<Vec<(Location, Vec<f64>)>, ScenarioError> {
    let mut rows = Vec::new();
    for (index, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
        let at = yaml::line(path, index + 1);
        let mut row = Vec::new();
        for field in line.split(',').map(str::trim) {
            let number = field.parse().ok().filter(|x: &f64| x.is_finite());
            let text = || field.to_owned();
            row.push(number.ok_or_else(|| ScenarioError::NotANumber { at: at.clone(), text: text() })?);
        }
        rows.push((at, row));
    }
    Ok(rows)
}

/// The configurations of a file, one a line; there may be none.
pub(crate) fn read_configurations(path: &Path, dof: usize) -> Result<Vec<Vec<f64>>, ScenarioError> {
    parse_configurations(path, &yaml::text(path)?, dof)
}

/// The same of a text; errors name `path`.
pub(crate) fn parse_configurations(
    path: &Path,
    text: &str,
    dof: usize,
) -> Result<Vec<Vec<f64>>, ScenarioError> {
    let check = |(at, row): (Location, Vec<f64>)| match row.len() {
        actual if actual == dof => Ok(row),
        actual => Err(ScenarioError::NumberCount { at, expected: dof, actual }),
    };
    parse(path, text)?.into_iter().map(check).collect()
}
