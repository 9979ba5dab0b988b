use cranny_grasp::BoxHand;
use cranny_robot::{LimitsFile, RobotDescription};
use schemars::schema_for;
use strum::{EnumString, IntoStaticStr, VariantArray};

use crate::layout::own_file::ScenarioFile;

/// A file that people write, of which there is a JSON Schema.
#[derive(Clone, Copy, Debug, PartialEq, Eq, EnumString, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "kebab-case")]
pub enum SchemaFile {
    /// `scenario.yaml`.
    Scenario,
    /// `robot.yaml`.
    Robot,
    /// `limits.yaml`.
    Limits,
    /// A gripper of boxes, as `--gripper` reads it.
    Gripper,
}

impl SchemaFile {
    /// What flags and the schema's own file call it.
    pub fn name(self) -> &'static str {
        self.into()
    }

    /// The JSON Schema, with which an editor completes and checks such a file. Generated from the types that read it, so
    /// that the two cannot differ.
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
