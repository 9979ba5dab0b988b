use std::path::PathBuf;

use cranny_file::did_you_mean;

use crate::csv_columns::COLUMNS;

const EXPECTED_COLUMNS: &str =
    "t00 to t33 (the pose, row by row), score, width_m, robust_score, robust_trials and load";

/// Error of grasps or of a file of them. The message contains file and line if there are any.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GraspError {
    /// A pose has a number that is infinite or not a number.
    #[error("the pose of grasp {grasp} has a number that is not finite")]
    NotFinite {
        /// Index of the grasp, from 0.
        grasp: usize,
    },
    /// A setting of the sampler is out of its range.
    #[error("the {setting} of a sampling must be {range}, but is {value}")]
    Setting {
        /// Name of the setting.
        setting: &'static str,
        /// The offending value.
        value: f64,
        /// Valid range.
        range: &'static str,
    },
    /// A parameter of a hand is out of its range.
    #[error("the {figure} of a hand must be between {least} and {greatest}, but is {value}")]
    HandFigure {
        /// Name of the parameter, with its unit.
        figure: &'static str,
        /// The offending value.
        value: f64,
        /// Minimum.
        least: f64,
        /// Maximum.
        greatest: f64,
    },
    /// An object has no surface to sample on.
    #[error("the object's triangles have no area, so there is nothing to grasp")]
    NoArea,
    /// A score lies outside its range.
    #[error("the score of grasp {grasp} is {score}, but scores lie in [0, 1]")]
    Score {
        /// Index of the grasp, from 0.
        grasp: usize,
        /// The offending value.
        score: f64,
    },
    /// A width is negative or not finite.
    #[error("the width of grasp {grasp} must be a finite number of metres, at least 0, but is {width_m}")]
    Width {
        /// Index of the grasp, from 0.
        grasp: usize,
        /// The offending value, in metres.
        width_m: f64,
    },
    /// A load is negative or not finite.
    #[error("the load of grasp {grasp} must be a finite factor, at least 0, but is {load}")]
    Load {
        /// Index of the grasp, from 0.
        grasp: usize,
        /// The offending value.
        load: f64,
    },
    /// A robust score is no share of its trials.
    #[error(
        "the robust score of grasp {grasp} is {score} of {trials} trials, but it is the share that held, in [0, 1], of \
         a whole number of them"
    )]
    Robust {
        /// Index of the grasp, from 0.
        grasp: usize,
        /// The offending score.
        score: f64,
        /// Number of trials given with it.
        trials: f64,
    },
    /// A grasp lacks a robust score where one is required.
    #[error(
        "grasp {grasp} has no robust score (`cranny simulate grasps ID --trials 32 -o FILE` writes the grasps with theirs; --min-score leaves out those without)"
    )]
    NoRobustScore {
        /// Index of the grasp, from 0.
        grasp: usize,
    },
    /// A line has a robust score without its number of trials, or vice versa.
    #[error(
        "of robust score and robust trials (without a header numbers 19 and 20) there is only one; give both, or leave both empty"
    )]
    HalfRobust,
    /// A line has too few or too many numbers.
    #[error(
        "{actual} numbers instead of 16 (the pose, row by row; score, width, robust score and robust trials may \
         follow)"
    )]
    NumberCount {
        /// Number of numbers in the line.
        actual: usize,
    },
    /// A header names an unknown column.
    #[error(
        "column {column} of the header is '{name}', which is none of {}{}",
        EXPECTED_COLUMNS,
        did_you_mean(name, COLUMNS)
    )]
    UnknownColumn {
        /// Number of the column, from 1.
        column: usize,
        /// Name of the column.
        name: String,
    },
    /// Two columns of a header have the same name.
    #[error(
        "columns {first} and {column} of the header are both '{name}'; it names each of {} once at the most",
        EXPECTED_COLUMNS
    )]
    RepeatedColumn {
        /// Name of both columns.
        name: &'static str,
        /// Number of the first column, from 1.
        first: usize,
        /// Number of the second column, from 1.
        column: usize,
    },
    /// A header names some columns of the pose, but not all.
    #[error("the header has no column '{name}'; it must name t00 to t33 (the pose, row by row)")]
    MissingColumn {
        /// First missing column.
        name: &'static str,
    },
    /// A line has more numbers than its header names, or too few for a pose.
    #[error("{actual} numbers under a header of {named} columns")]
    ColumnCount {
        /// Number of numbers in the line.
        actual: usize,
        /// Number of columns in the header.
        named: usize,
    },
    /// A field is not a finite number.
    #[error("number {column} is '{text}', which is not a finite number")]
    NotANumber {
        /// Number of the field, from 1.
        column: usize,
        /// Text of the field.
        text: String,
    },
    /// The last row of a pose is not 0 0 0 1.
    #[error(
        "the last row of the pose is {row:?} instead of [0, 0, 0, 1] (are the numbers row by row, one pose a \
         line?)"
    )]
    LastRow {
        /// The row.
        row: [f64; 4],
    },
    /// The rotation of a pose scales or shears.
    #[error(
        "the rotation part of the pose is no rotation: RᵀR differs from the identity by {deviation:.2e}, \
         more than {tolerance:.0e}"
    )]
    NotARotation {
        /// Maximum deviation of an element of `RᵀR` from the identity.
        deviation: f64,
        /// Tolerance of the deviation.
        tolerance: f64,
    },
    /// The rotation of a pose mirrors.
    #[error("the axes of the pose are left-handed (is one of them mirrored?)")]
    LeftHanded,
    /// A file contains no grasps.
    #[error("{}: the file holds no grasps", path.display())]
    Empty {
        /// Path of the file.
        path: PathBuf,
    },
    /// A file cannot be read.
    #[error("{}: cannot read the grasps: {reason}", path.display())]
    Unreadable {
        /// Path of the file.
        path: PathBuf,
        /// Error of the operating system.
        reason: std::io::Error,
    },
    /// A file of grasps of another project cannot be read.
    #[error("{}: {problem}", path.display())]
    Import {
        /// Path of the file.
        path: PathBuf,
        /// The problem, with the number of the grasp if it concerns one.
        problem: String,
    },
    /// A line of a file is wrong.
    #[error("{}:{line}: {fault}", path.display())]
    Line {
        /// Path of the file.
        path: PathBuf,
        /// Number of the line, from 1.
        line: usize,
        /// Fault of the line.
        fault: Box<GraspError>,
    },
}
