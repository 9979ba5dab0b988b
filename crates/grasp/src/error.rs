use std::path::PathBuf;

use cranny_file::did_you_mean;

use crate::csv_columns::COLUMNS;

const EXPECTED_COLUMNS: &str =
    "t00 to t33 (the pose, row by row), score, width_m, robust_score, robust_trials and load";

/// What can be wrong with grasps or a file of them. The message is complete in itself: file and line where
/// there is one.
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
        /// Which setting.
        setting: &'static str,
        /// The offending value.
        value: f64,
        /// What would fit.
        range: &'static str,
    },
    /// A figure of a hand is out of its range.
    #[error("the {figure} of a hand must be between {least} and {greatest}, but is {value}")]
    HandFigure {
        /// Which figure; its name says the unit.
        figure: &'static str,
        /// The offending value.
        value: f64,
        /// The least that fits.
        least: f64,
        /// The greatest that fits.
        greatest: f64,
    },
    /// There is no surface to sample on.
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
        /// The number of trials that it is said to be of.
        trials: f64,
    },
    /// A grasp has no robust score, where it counts.
    #[error(
        "grasp {grasp} has no robust score (`cranny simulate grasps ID --trials 32 -o FILE` writes the grasps with theirs; --min-score leaves out those without)"
    )]
    NoRobustScore {
        /// Index of the grasp, from 0.
        grasp: usize,
    },
    /// A line has a robust score without its number of trials, or the other way round.
    #[error(
        "of robust score and robust trials (without a header numbers 19 and 20) there is only one; give both, or leave both empty"
    )]
    HalfRobust,
    /// A line holds too few or too many numbers.
    #[error(
        "{actual} numbers instead of 16 (the pose, row by row; score, width, robust score and robust trials may \
         follow)"
    )]
    NumberCount {
        /// Count of the numbers.
        actual: usize,
    },
    /// A column of a header has a name that no column has.
    #[error(
        "column {column} of the header is '{name}', which is none of {}{}",
        EXPECTED_COLUMNS,
        did_you_mean(name, COLUMNS)
    )]
    UnknownColumn {
        /// Its number, from 1.
        column: usize,
        /// Its name.
        name: String,
    },
    /// Two columns of a header have one name.
    #[error(
        "columns {first} and {column} of the header are both '{name}'; it names each of {} once at the most",
        EXPECTED_COLUMNS
    )]
    RepeatedColumn {
        /// Their names.
        name: &'static str,
        /// The first one, from 1.
        first: usize,
        /// The second one.
        column: usize,
    },
    /// A header names only a part of the pose.
    #[error("the header has no column '{name}'; it must name t00 to t33 (the pose, row by row)")]
    MissingColumn {
        /// The first that is missing.
        name: &'static str,
    },
    /// A line holds more numbers than its header names, or too few for a pose.
    #[error("{actual} numbers under a header of {named} columns")]
    ColumnCount {
        /// Count of the numbers.
        actual: usize,
        /// Count of the header's columns.
        named: usize,
    },
    /// What should be a number is none, or none that is finite.
    #[error("number {column} is '{text}', which is not a finite number")]
    NotANumber {
        /// Its number, from 1.
        column: usize,
        /// What stands there.
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
    /// The rotation part of a pose scales or shears.
    #[error(
        "the rotation part of the pose is no rotation: RᵀR differs from the identity by {deviation:.2e}, \
         more than {tolerance:.0e}"
    )]
    NotARotation {
        /// The greatest difference of an element of `RᵀR` from the identity.
        deviation: f64,
        /// How much is let pass.
        tolerance: f64,
    },
    /// The rotation part of a pose mirrors.
    #[error("the axes of the pose are left-handed (is one of them mirrored?)")]
    LeftHanded,
    /// There is no grasp in a file.
    #[error("{}: the file holds no grasps", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// A file cannot be read.
    #[error("{}: cannot read the grasps: {reason}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        reason: std::io::Error,
    },
    /// A file cannot be written.
    #[error("{}: cannot write the grasps: {reason}", path.display())]
    Unwritable {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        reason: std::io::Error,
    },
    /// A file of grasps of another project cannot be read.
    #[error("{}: {problem}", path.display())]
    Import {
        /// The file.
        path: PathBuf,
        /// The problem, with the number of the grasp if it concerns one.
        problem: String,
    },
    /// A line of a file is wrong.
    #[error("{}:{line}: {fault}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What is wrong with it.
        fault: Box<GraspError>,
    },
}
