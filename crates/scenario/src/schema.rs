use cranny_grasp::BoxHand;
use cranny_robot::{LimitsFile, RobotDescription};
use schemars::schema_for;
use strum::{EnumString, IntoStaticStr, VariantArray};

use crate::layout::own_file::ScenarioFile;

/// User-written file with a JSON Schema.
#[derive(Clone, Copy, Debug, PartialEq, Eq, EnumString, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "kebab-case")]
pub enum SchemaFile {
    /// `scenario.yaml`.
    Scenario,
    /// `robot.yaml`.
    Robot,
    /// `limits.yaml`.
    Limits,
    /// Gripper made of boxes, as read by `--gripper`.
    Gripper,
}

impl SchemaFile {
    /// Returns the name in flags and in the file name of the schema.
    pub fn name(self) -> &'static str {
        self.into()
    }

    /// Returns the JSON Schema, with which an editor completes and checks such a file, from the types that read the file.
    ///
    /// # Panics
    /// Never: a schema is JSON.
    pub fn schema(self) -> String {
        let mut schema = match self {
            Self::Scenario => schema_for!(ScenarioFile),
            Self::Robot => schema_for!(RobotDescription),
            Self::Limits => schema_for!(LimitsFile),
            Self::Gripper => schema_for!(BoxHand),
        };
        schema.insert("title".into(), format!("Cranny {}", self.name()).into());
        let mut text = serde_json::to_string_pretty(&schema).expect("a schema is JSON");
        text.push('\n');
        text
    }
}
