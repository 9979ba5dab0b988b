use std::path::Path;

use cranny_robot::Location;
use cranny_spatial::{Pose, Rotation, Vector};
use serde_saphyr::Spanned;

use crate::ScenarioError;
use crate::files::yaml;
use crate::moveit::file::{PoseEntry, Refused};

/// Message file, with the conversion of its entries and locations for errors.
pub(crate) struct MessageFile<'a> {
    pub path: &'a Path,
}

impl MessageFile<'_> {
    pub fn at(&self, location: serde_saphyr::Location) -> Location {
        yaml::at(self.path, location)
    }

    pub fn line(&self, line: usize) -> Location {
        yaml::line(self.path, line)
    }

    pub fn finite(&self, number: &Spanned<f64>) -> Result<f64, ScenarioError> {
        yaml::finite(self.path, number.value, number.referenced)
    }

    /// Returns the pose of an entry in the frame that its message defines; a quaternion of zeros, the default, is the identity.
    pub fn pose(&self, entry: &Spanned<PoseEntry>) -> Result<Pose, ScenarioError> {
        let position = entry.value.position.map_or([0.0; 3], |position| position.0);
        let orientation = entry.value.orientation.map_or([0.0; 4], |orientation| orientation.0);
        for number in position.into_iter().chain(orientation) {
            yaml::finite(self.path, number, entry.referenced)?;
        }
        let rotation = if orientation.iter().all(|value| *value == 0.0) {
            Rotation::identity()
        } else {
            yaml::rotation(self.path, orientation, entry.referenced)?
        };
        Ok(Pose::from_parts(Vector::from(position).into(), rotation))
    }

    /// Returns a pose as [`Self::pose`], in the same frame; the identity without an entry.
    pub fn optional_pose(&self, entry: Option<&Spanned<PoseEntry>>) -> Result<Pose, ScenarioError> {
        entry.map_or_else(|| Ok(Pose::identity()), |entry| self.pose(entry))
    }

    pub fn unsupported(
        &self,
        location: serde_saphyr::Location,
        what: &'static str,
        hint: &'static str,
    ) -> ScenarioError {
        ScenarioError::Unsupported { at: self.at(location), what, hint }
    }

    /// Refuses a list that is not empty.
    pub fn refuse(
        &self,
        list: &Refused,
        what: &'static str,
        hint: &'static str,
    ) -> Result<(), ScenarioError> {
        match list {
            Some(list) if !list.value.is_empty() => Err(self.unsupported(list.referenced, what, hint)),
            _ => Ok(()),
        }
    }
}
