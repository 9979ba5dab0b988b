//! Options as JSON objects, with the names of the Python package's keywords.

use cranny::grasp::pose_of_rows;
use cranny::spatial::Pose;
use serde::de::{DeserializeOwned, Error as _};

use crate::boundary::{Numbers, Text};
use crate::error::Fault;

/// Parses options; NULL stands for the defaults.
pub fn parsed<T: Default + DeserializeOwned>(text: Text<'_>) -> Result<T, Fault> {
    text.optional("options")?.map_or_else(|| Ok(T::default()), |text| Ok(serde_json::from_str(text)?))
}

/// Returns the failure of an option whose value is wrong.
pub fn refused(problem: impl std::fmt::Display) -> Fault {
    Fault::Options(serde_json::Error::custom(problem))
}

/// Parses a word of a closed set; `known` lists it.
pub fn word<T: std::str::FromStr>(what: &str, word: Option<&str>, known: &str) -> Result<Option<T>, Fault> {
    let parsed = |word: &str| {
        word.parse().map_err(|_| refused(format!("`{what}` is '{word}', but {known} is expected")))
    };
    word.map(parsed).transpose()
}

/// Reads a pose in the planning frame: 16 numbers of a homogeneous matrix, row by row, in metres.
pub fn pose_of(rows: Numbers<'_>, what: &'static str) -> Result<Pose, Fault> {
    let values = rows.finite(what, 4, 4)?;
    let mut matrix = [0.0; 16];
    matrix.copy_from_slice(values);
    Ok(pose_of_rows(&matrix)?)
}

/// Reads a pose in the planning frame, or the identity for NULL.
pub fn pose_or_identity(rows: Numbers<'_>, what: &'static str) -> Result<Pose, Fault> {
    if rows.is_null() { Ok(Pose::identity()) } else { pose_of(rows, what) }
}
