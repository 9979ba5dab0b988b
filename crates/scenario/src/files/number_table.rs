use std::path::Path;

use cranny_file::{TABLE, excerpt};

use crate::ScenarioError;
use crate::files::yaml;

/// The numbers of a file of comma-separated ones, line after line.
pub(crate) fn read(path: &Path) -> Result<Vec<f64>, ScenarioError> {
    let rows = parse(path, &yaml::text(TABLE, path)?, |_| Ok(()))?;
    Ok(rows.into_iter().flatten().collect())
}

/// The configurations of a file, one a line, each of `dof` values (m, rad); there may be none. The file may be a pipe.
///
/// # Errors
/// [`ScenarioError`] with file and line for a wrong count or what is no finite number.
pub fn read_configurations(path: &Path, dof: usize) -> Result<Vec<Vec<f64>>, ScenarioError> {
    parse_configurations(path, &yaml::text(TABLE.argument(), path)?, dof)
}

/// The same of a text; errors name `path`.
pub(crate) fn parse_configurations(
    path: &Path,
    text: &str,
    dof: usize,
) -> Result<Vec<Vec<f64>>, ScenarioError> {
    parse(path, text, |actual| if actual == dof { Ok(()) } else { Err(dof) })
}

/// What is wrong with a line by itself.
pub(crate) fn fault_of_line(
    path: &Path,
    index: usize,
    line: &str,
    dof: Option<usize>,
) -> Option<ScenarioError> {
    let check = |actual| dof.filter(|dof| *dof != actual).map_or(Ok(()), Err);
    parse_line(path, index, line, check).err()
}

/// The lines of a text but the blank ones. `check` says how many numbers a line must have if it has not; a line
/// is not read before that.
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
