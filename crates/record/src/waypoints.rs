use std::path::Path;

use cranny_scenario::{configurations_text, read_configurations, write_whole_file};

use crate::reading::some;
use crate::{PlanFile, RecordError};

/// Reads the way points (m, rad; one value per joint) of a plan file (`.plan.json`) or of a file with one configuration per
/// line (`.csv`, `.try`: comma-separated, no header), each of `joints` values.
///
/// # Errors
/// [`RecordError`] with file and line for a wrong count or a value that is not a finite number, and for a file without way
/// points or with an unknown ending.
pub fn read_waypoints(path: &Path, joints: usize) -> Result<Vec<Vec<f64>>, RecordError> {
    let waypoints = match path.extension().and_then(|extension| extension.to_str()) {
        Some("json") => PlanFile::read(path)?.into_waypoints(path, joints)?,
        Some("csv" | "try") => read_configurations(path, joints)?,
        _ => return Err(RecordError::WaypointFormat { path: path.to_owned() }),
    };
    some(path, waypoints)
}

/// Writes way points (m, rad; one value per joint) in the format of the released `.csv` and `.try` files: one configuration per
/// line. Numbers are read back bit by bit.
///
/// # Errors
/// [`ScenarioError::Unwritable`](cranny_scenario::ScenarioError::Unwritable); an existing file is then untouched.
pub fn write_waypoints_csv(path: &Path, waypoints: &[Vec<f64>]) -> Result<(), RecordError> {
    Ok(write_whole_file(path, configurations_text(waypoints).as_bytes())?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fault(name: &str, text: &str) -> String {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        read_waypoints(&path, 2).unwrap_err().to_string()
    }

    #[test]
    fn waypoints_are_read_back_bit_by_bit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("path.csv");
        let waypoints = vec![vec![0.1 + 0.2, -1e-300], vec![std::f64::consts::PI, 2.0]];
        write_waypoints_csv(&path, &waypoints).unwrap();
        assert_eq!(read_waypoints(&path, 2).unwrap(), waypoints);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn faults_name_file_and_line() {
        assert!(fault("a.csv", "1,2\n\n1,2,3\n").contains("a.csv:3: 3 numbers instead of 2"));
        assert!(fault("a.try", "1,2\n1,nan\n").contains("a.try:2: 'nan' is not a finite number"));
        assert!(fault("a.try", "1,2\n1,\n").contains("a.try:2: '' is not a finite number"));
        assert!(fault("a.csv", "\n").contains("a.csv: the file is empty"));
        assert!(fault("a.txt", "1,2\n").contains("known endings"));
    }
}
