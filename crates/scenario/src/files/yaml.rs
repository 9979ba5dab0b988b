use std::path::Path;

use cranny_file::{Readable, TEXT};
use cranny_robot::Location;
use cranny_spatial::{Rotation, rotation_from_xyzw};

use serde::de::DeserializeOwned;

use crate::object::error::check_number;
use crate::{Friction, ObjectError, ScenarioError};

/// Reads a YAML file.
pub(crate) fn read<T: DeserializeOwned>(path: &Path) -> Result<T, ScenarioError> {
    parse(path, &text(TEXT, path)?)
}

/// Reads the text of a file of some kind.
pub(crate) fn text(kind: Readable, path: &Path) -> Result<String, ScenarioError> {
    kind.text(path).map_err(|reason| ScenarioError::Unreadable { path: path.to_owned(), reason })
}

/// Parses a YAML text; errors name `path`.
pub(crate) fn parse<T: DeserializeOwned>(path: &Path, text: &str) -> Result<T, ScenarioError> {
    parse_located(path, text, |number| line(path, number))
}

/// Parses a YAML text; errors name `path`, or the location that `at` gives for their line.
pub(crate) fn parse_located<T: DeserializeOwned>(
    path: &Path,
    text: &str,
    at: impl FnOnce(usize) -> Location,
) -> Result<T, ScenarioError> {
    if text.trim().is_empty() {
        return Err(ScenarioError::Empty { path: path.to_owned() });
    }
    cranny_file::yaml(text).map_err(|reason| ScenarioError::Yaml { at: at(reason.line), reason })
}

/// Returns a location in a YAML file, as errors report it.
pub(crate) fn at(path: &Path, location: serde_saphyr::Location) -> Location {
    line(path, line_of(location))
}

/// Returns the line of a location, counted from 1.
pub(crate) fn line_of(location: serde_saphyr::Location) -> usize {
    usize::try_from(location.line()).unwrap_or(0).max(1)
}

/// Returns a number of a file if it is finite.
pub(crate) fn finite(
    path: &Path,
    number: f64,
    location: serde_saphyr::Location,
) -> Result<f64, ScenarioError> {
    finite_at(number, || at(path, location))
}

/// Returns a number at a location if it is finite.
pub(crate) fn finite_at(number: f64, at: impl FnOnce() -> Location) -> Result<f64, ScenarioError> {
    let fault = || ScenarioError::NotANumber { at: at(), text: number.to_string() };
    number.is_finite().then_some(number).ok_or_else(fault)
}

/// Returns a number of a file that describes an object if it is positive and finite.
pub(crate) fn positive(
    path: &Path,
    what: &'static str,
    number: f64,
    location: serde_saphyr::Location,
) -> Result<f64, ScenarioError> {
    finite(path, number, location)?;
    check_number(what, number).map_err(|fault| at_line(path, location, fault))?;
    Ok(number)
}

fn at_line(path: &Path, location: serde_saphyr::Location, fault: ObjectError) -> ScenarioError {
    ScenarioError::At { at: at(path, location), fault: Box::new(fault.into()) }
}

/// Returns a coefficient of friction of a file, or its range, if it is positive and finite.
pub(crate) fn friction(
    path: &Path,
    friction: Friction,
    location: serde_saphyr::Location,
) -> Result<Friction, ScenarioError> {
    finite(path, friction.low, location)?;
    finite(path, friction.high, location)?;
    friction.check().map_err(|fault| at_line(path, location, fault))
}

/// Returns the rotation of a unit quaternion (x, y, z, w).
pub(crate) fn rotation(
    path: &Path,
    quaternion: [f64; 4],
    location: serde_saphyr::Location,
) -> Result<Rotation, ScenarioError> {
    rotation_at(at(path, location), quaternion)
}

/// Returns the rotation of the unit quaternion (x, y, z, w) at location `at`.
pub(crate) fn rotation_at(at: Location, quaternion: [f64; 4]) -> Result<Rotation, ScenarioError> {
    rotation_from_xyzw(quaternion).map_err(|norm| ScenarioError::Quaternion { at, norm })
}

/// Returns the location of a line of a file, counted from 1, as errors report it.
pub(crate) fn line(path: &Path, line: usize) -> Location {
    Location { file: path.display().to_string(), line: u32::try_from(line).unwrap_or(u32::MAX) }
}
