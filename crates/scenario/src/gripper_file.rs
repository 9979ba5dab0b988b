use std::path::Path;

use cranny_grasp::Gripper;

use crate::{ScenarioError, yaml};

/// A gripper from a YAML file, which gives every field of [`Gripper`] by its name.
///
/// # Errors
/// [`ScenarioError::Yaml`] with file and line, [`ScenarioError::Unreadable`], or
/// [`ScenarioError::GripperSize`] for a size that is none.
pub fn read_gripper(path: &Path) -> Result<Gripper, ScenarioError> {
    let gripper: Gripper = yaml::read_argument(path)?;
    let size = |reason| ScenarioError::GripperSize { path: path.to_owned(), reason };
    gripper.parts().map_err(size)?;
    let opening = cranny_shape::ShapeError::Size { what: "the opening", value: gripper.opening_m };
    if gripper.opening_m > 0.0 && gripper.tip_ahead_m.is_finite() { Ok(gripper) } else { Err(size(opening)) }
}
