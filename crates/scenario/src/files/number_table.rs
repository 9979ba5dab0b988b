use std::path::Path;

use cranny_file::{TABLE, excerpt};

use crate::ScenarioError;
use crate::files::yaml;

/// Reads the comma-separated numbers of a file, line by line.
pub(crate) fn read(path: &Path) -> Result<Vec<f64>, ScenarioError> {
    let rows = parse(path, &yaml::text(TABLE, path)?, |_| Ok(()))?;
    Ok(rows.into_iter().flatten().collect())
}

/// Reads the configurations of a file, one per line, each of `dof` values (m, rad); the file may be empty.
///
/// # Errors
/// [`ScenarioError`] with file and line for a wrong count or a value that is not a finite number.
pub fn read_configurations(path: &Path, dof: usize) -> Result<Vec<Vec<f64>>, ScenarioError> {
    parse_configurations(path, &yaml::text(TABLE, path)?, dof)
}

/// Parses configurations of `dof` values (m, rad) from a text; errors name `path`.
pub(crate) fn parse_configurations(
    path: &Path,
    text: &str,
    dof: usize,
) -> Result<Vec<Vec<f64>>, ScenarioError> {
    parse(path, text, |actual| if actual == dof { Ok(()) } else { Err(dof) })
}

/// Returns the fault of a single line, if it has one.
pub(crate) fn fault_of_line(
    path: &Path,
    index: usize,
    line: &str,
    dof: Option<usize>,
) -> Option<ScenarioError> {
    let check = |actual| dof.filter(|dof| *dof != actual).map_or(Ok(()), Err);
    parse_line(path, index, line, check).err()
}

/// Parses the non-blank lines of a text. `check` receives the count of numbers of a line before they are parsed, and returns
/// the expected count if it differs.
fn parse(
    path: &Path,
    text: &str,
    check: impl Fn(usize) -> Result<(), usize>,
) -> Result<Vec<Vec<f64>>, ScenarioError> {
    let lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    lines.map(|(index, line)| parse_line(path, index, line, &check)).collect()
}

fn parse_line(
    path: &Path,
    index: usize,
    line: &str,
    check: impl Fn(usize) -> Result<(), usize>,
) -> Result<Vec<f64>, ScenarioError> {
    let at = || yaml::line(path, index + 1);
    let actual = line.split(',').count();
    check(actual).map_err(|expected| ScenarioError::NumberCount { at: at(), expected, actual })?;
    let number = |field: &str| {
        let number = field.trim().parse().ok().filter(|x: &f64| x.is_finite());
        number.ok_or_else(|| ScenarioError::NotANumber { at: at(), text: excerpt(field.trim()) })
    };
    line.split(',').map(number).collect()
}
