use std::fmt::Write as _;
use std::path::Path;

use cranny_scenario::write_whole_file;
use cranny_solve::TaskTrajectory;

use crate::RecordError;

/// Writes a trajectory as a table, sampled at `rate_hz` and at its end: a header, then one line for each instant.
///
/// The columns are `time_s`, then `q_<joint>` (m, rad), then `v_<joint>` (m/s, rad/s), then `a_<joint>` (m/s², rad/s²), each in
/// the order of the joints; if the hand closes on an object, `opening_m` last, the distance between the fingers. Numbers are
/// read back bit by bit.
///
/// # Errors
/// [`PathError::SampleRate`](cranny_path::PathError::SampleRate) for an invalid rate,
/// [`ScenarioError::Unwritable`](cranny_scenario::ScenarioError::Unwritable); an existing file is then untouched.
pub fn write_trajectory_csv(
    path: &Path,
    trajectory: &TaskTrajectory,
    rate_hz: f64,
) -> Result<(), RecordError> {
    let mut text = "time_s".to_owned();
    for column in ["q", "v", "a"] {
        for joint in trajectory.joint_names() {
            let _ = write!(text, ",{}", field(&format!("{column}_{joint}")));
        }
    }
    if trajectory.openings_m().is_some() {
        text.push_str(",opening_m");
    }
    text.push('\n');
    for sample in trajectory.samples(rate_hz)? {
        let _ = write!(text, "{}", sample.time_s);
        for value in sample.position.iter().chain(&sample.velocity).chain(&sample.acceleration) {
            // Adding zero drops the sign of a negative zero.
            let _ = write!(text, ",{}", value + 0.0);
        }
        if let Some(opening_m) = trajectory.opening_m(sample.time_s) {
            let _ = write!(text, ",{opening_m}");
        }
        text.push('\n');
    }
    Ok(write_whole_file(path, text.as_bytes())?)
}

/// Formats a field of the table; names with a separator in them are quoted (RFC 4180, §2).
fn field(name: &str) -> String {
    if name.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", name.replace('"', "\"\""))
    } else {
        name.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use cranny_path::{MotionLimits, TimingMethod, Trajectory};
    use cranny_robot::{JointLimits, JointUnit};
    use cranny_solve::HandMotion;

    use super::*;

    fn trajectory(path: &[Vec<f64>]) -> Trajectory {
        let joint = JointLimits {
            lower: -1.0,
            upper: 1.0,
            velocity: 1.0,
            acceleration: Some(2.0),
            jerk: None,
            unit: JointUnit::Metre,
        };
        let names = ["lift".to_owned(), "turn, \"main\"".to_owned()];
        let limits = MotionLimits::new(&names, &[joint; 2], TimingMethod::TimeOptimal).unwrap();
        Trajectory::along(path, &limits).unwrap()
    }

    fn reach() -> TaskTrajectory {
        TaskTrajectory::of_reach(trajectory(&[vec![0.0, 0.1], vec![0.5, -0.2]]))
    }

    #[test]
    fn where_the_hand_closes_the_table_says_how_far() {
        let [a, b, c] = [[0.0, 0.1], [0.5, -0.2], [0.1, 0.0]].map(|q| q.to_vec());
        let onward = trajectory(&[b.clone(), c.clone()]);
        let task = TaskTrajectory::of_reach(trajectory(&[a, b.clone()])).then([0.08, 0.02], onward);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.trajectory.csv");
        write_trajectory_csv(&path, &task, 50.0).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        let (header, rows) = text.split_once('\n').unwrap();
        assert!(header.ends_with(",opening_m"), "{header}");
        let HandMotion { from_s: begin_s, until_s: end_s, .. } = task.hand_motions()[0];
        let mut seen = [false; 3];
        for row in rows.lines() {
            let values: Vec<f64> = row.split(',').map(|x| x.parse().unwrap()).collect();
            let (time_s, opening_m) = (values[0], values[values.len() - 1]);
            let share = ((time_s - begin_s) / (end_s - begin_s)).clamp(0.0, 1.0);
            assert!((opening_m - (0.08 - 0.06 * share)).abs() < 1e-12, "{row}");
            seen[usize::from(time_s > begin_s) + usize::from(time_s >= end_s)] = true;
            if time_s > begin_s && time_s < end_s {
                assert_eq!((&values[1..3], &values[3..7]), (&b[..], &[0.0; 4][..]), "it stands: {row}");
            }
        }
        assert_eq!(seen, [true; 3]);
        let times_s = task.waypoint_times_s();
        assert_eq!((times_s.len(), times_s[1], times_s[2]), (3, begin_s, task.duration_s()));
        assert_eq!(task.sample(task.duration_s()).position, c);
    }

    #[test]
    fn a_trajectory_is_a_table_that_is_read_back_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.trajectory.csv");
        write_trajectory_csv(&path, &reach(), 10.0).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        let (header, rows) = text.split_once('\n').unwrap();
        let turn = |column: &str| format!("\"{column}_turn, \"\"main\"\"\"");
        let (q, v, a) = (turn("q"), turn("v"), turn("a"));
        assert_eq!(header, format!("time_s,q_lift,{q},v_lift,{v},a_lift,{a}"));
        for (row, sample) in rows.lines().zip(reach().samples(10.0).unwrap()) {
            let values: Vec<f64> = row.split(',').map(|x| x.parse().unwrap()).collect();
            let expected = [vec![sample.time_s], sample.position, sample.velocity, sample.acceleration];
            assert_eq!(values, expected.concat());
        }
        assert_eq!(rows.lines().count(), reach().samples(10.0).unwrap().count());
    }

    #[test]
    fn a_rate_that_is_none_leaves_the_earlier_table_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.trajectory.csv");
        std::fs::write(&path, "earlier").unwrap();
        for rate_hz in [0.0, f64::NAN, f64::INFINITY] {
            assert!(write_trajectory_csv(&path, &reach(), rate_hz).is_err());
        }
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "earlier");
    }
}
