use std::path::PathBuf;

/// What can be wrong with a plan file or a file of way points. The message is complete in itself: file and line where there is one.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PlanFileError {
    /// A way point of a plan has the wrong number of values.
    #[error("{}: way point {waypoint} has {actual} values instead of {expected}", path.display())]
    Waypoint {
        /// The plan file.
        path: PathBuf,
        /// Index of the way point, from 0.
        waypoint: usize,
        /// How many values there should be.
        expected: usize,
        /// How many there are.
        actual: usize,
    },
    /// A plan of a search that found nothing.
    #[error("{}: the plan has no path; as stated, its search ended as {outcome}", path.display())]
    NoPath {
        /// The plan file.
        path: PathBuf,
        /// How its search ended.
        outcome: &'static str,
    },
    /// A file's ending says nothing about how to read it.
    #[error("{}: cannot tell what this file is (known endings: .plan.json, .csv, .try)", path.display())]
    WaypointFormat {
        /// The file.
        path: PathBuf,
    },
    /// A plan to be written holds a number that JSON cannot: infinite, or not a number.
    #[error("{}: not written, because '{field}' holds a number that is not finite", path.display())]
    NotFinite {
        /// The file.
        path: PathBuf,
        /// Which field of the plan.
        field: &'static str,
    },
}
