use std::path::Path;

use cranny_grasp::{BoxHand, Hand};

use crate::ScenarioError;
use crate::files::yaml;

/// Reads a hand from a YAML file, which gives every field of [`BoxHand`] by its name.
///
/// # Errors
/// [`ScenarioError::Yaml`] with file and line, [`ScenarioError::Unreadable`], or
/// [`ScenarioError::GripperFigure`] for a figure out of range.
pub fn read_gripper(path: &Path) -> Result<Hand, ScenarioError> {
    let boxes: BoxHand = yaml::read(path)?;
    boxes.hand().map_err(|reason| ScenarioError::GripperFigure { path: path.to_owned(), reason })
}
