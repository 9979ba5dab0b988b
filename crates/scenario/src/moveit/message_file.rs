use std::path::{Path, PathBuf};

use cranny_file::TEXT;
use cranny_robot::Location;
use cranny_spatial::{Pose, Rotation, Vector};
use serde::de::DeserializeOwned;
use serde_json::Value;
use serde_saphyr::Spanned;

use crate::ScenarioError;
use crate::files::yaml;
use crate::moveit::file::{PoseEntry, Refused};

/// Message in a file or in memory, with the conversion of its entries and locations for errors.
pub(crate) struct MessageFile {
    /// Path of the file; name of a message in memory.
    pub path: PathBuf,
    pub text: String,
    /// Message in memory, of which `text` has each entry on a line of its own.
    value: Option<Value>,
}

impl MessageFile {
    pub fn read(path: &Path) -> Result<Self, ScenarioError> {
        Ok(Self { path: path.to_owned(), text: yaml::text(TEXT, path)?, value: None })
    }

    /// Wraps a message in memory; errors name its entries, such as `name.poses[3].position`.
    pub fn of_value(name: &str, value: Value) -> Self {
        Self { path: name.into(), text: format!("{value:#}"), value: Some(value) }
    }

    /// Returns the folder of the file; `None` for a message in memory.
    pub fn folder(&self) -> Option<&Path> {
        self.path.parent().filter(|_| self.value.is_none())
    }

    pub fn parse<T: DeserializeOwned>(&self) -> Result<T, ScenarioError> {
        yaml::parse_located(&self.path, &self.text, |line| self.line(line))
    }

    pub fn at(&self, location: serde_saphyr::Location) -> Location {
        self.line(yaml::line_of(location))
    }

    pub fn line(&self, line: usize) -> Location {
        match &self.value {
            Some(value) => {
                let mut left = line;
                let entry = entry_at(value, &mut left).unwrap_or_default();
                Location { file: format!("{}{entry}", self.path.display()), line: 0 }
            }
            None => yaml::line(&self.path, line),
        }
    }

    pub fn finite(&self, number: &Spanned<f64>) -> Result<f64, ScenarioError> {
        self.finite_at(number.value, number.referenced)
    }

    pub fn finite_at(&self, number: f64, location: serde_saphyr::Location) -> Result<f64, ScenarioError> {
        yaml::finite_at(number, || self.at(location))
    }

    /// Returns the pose of an entry in the frame that its message defines; a quaternion of zeros, the default, is the identity.
    pub fn pose(&self, entry: &Spanned<PoseEntry>) -> Result<Pose, ScenarioError> {
        let position = entry.value.position.map_or([0.0; 3], |position| position.0);
        let orientation = entry.value.orientation.map_or([0.0; 4], |orientation| orientation.0);
        for number in position.into_iter().chain(orientation) {
            self.finite_at(number, entry.referenced)?;
        }
        let rotation = if orientation.iter().all(|value| *value == 0.0) {
            Rotation::identity()
        } else {
            yaml::rotation_at(self.at(entry.referenced), orientation)?
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

/// Returns the name of the entry at a line of the indented text of `value`, which begins at line 1, and counts `line` down.
fn entry_at(value: &Value, line: &mut usize) -> Option<String> {
    *line = line.saturating_sub(1);
    if *line == 0 {
        return Some(String::new());
    }
    let inside = match value {
        Value::Object(entries) if !entries.is_empty() => {
            entries.iter().find_map(|(key, entry)| Some(format!(".{key}{}", entry_at(entry, line)?)))
        }
        Value::Array(entries) if !entries.is_empty() => {
            let mut numbered = entries.iter().enumerate();
            numbered.find_map(|(index, entry)| Some(format!("[{index}]{}", entry_at(entry, line)?)))
        }
        _ => return None,
    };
    // The closing bracket is on a line of its own.
    inside.or_else(|| entry_at(&Value::Null, line))
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn each_line_of_a_message_in_memory_is_named_by_its_entry() {
        let value = json!({"a": [1, {"b": [], "c": "x\ny"}], "d": {}, "e": [[2.5, 3]], "f": null});
        let file = MessageFile::of_value("scene", value);
        let names: Vec<String> =
            (1..=file.text.lines().count()).map(|line| file.line(line).to_string()).collect();
        let expected = [
            "", ".a", ".a[0]", ".a[1]", ".a[1].b", ".a[1].c", ".a[1]", ".a", ".d", ".e", ".e[0]", ".e[0][0]",
            ".e[0][1]", ".e[0]", ".e", ".f", "",
        ];
        assert_eq!(names, expected.map(|entry| format!("scene{entry}")));
        assert_eq!(file.line(99).to_string(), "scene");
    }
}
