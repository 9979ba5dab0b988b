use schemars::schema_for;

use crate::scenario_file::ScenarioFile;

/// The JSON Schema of `scenario.yaml`, with which an editor completes and checks it. Generated from the types
/// that read the file, so that the two cannot differ.
///
/// # Panics
/// Never: a schema is JSON.
pub fn scenario_schema() -> String {
    let mut schema = schema_for!(ScenarioFile);
    schema.insert("title".into(), "Cranny scenario".into());
    let mut text = serde_json::to_string_pretty(&schema).expect("a schema is JSON");
    text.push('\n');
    text
}
