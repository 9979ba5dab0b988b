use std::fs;
use std::path::Path;

use crate::{ScenarioError, own_layout};

/// Begins a scenario of one's own: a folder with a commented `scenario.yaml` and a `grasps.csv`, which opens
/// and can be planned as it is.
///
/// # Errors
/// [`ScenarioError::Exists`] if something is there already, [`ScenarioError::Unwritable`].
pub fn write_template(folder: &Path) -> Result<(), ScenarioError> {
    if folder.exists() {
        return Err(ScenarioError::Exists { path: folder.to_owned() });
    }
    let unwritable = |path: &Path, reason| ScenarioError::Unwritable { path: path.to_owned(), reason };
    fs::create_dir_all(folder).map_err(|reason| unwritable(folder, reason))?;
    for (name, text) in [(own_layout::GRASPS_FILE, GRASPS), (own_layout::FILE, SCENARIO)] {
        let path = folder.join(name);
        fs::write(&path, text).map_err(|reason| unwritable(&path, reason))?;
    }
    Ok(())
}

const SCENARIO: &str = include_str!("template/scenario.yaml");

const GRASPS: &str = include_str!("template/grasps.csv");
