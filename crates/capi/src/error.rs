//! Failures of a call: a status, and a text that the thread keeps.

use std::cell::RefCell;
use std::ffi::{CString, c_char};

use cranny::collision::CollisionError;
use cranny::grasp::GraspError;
use cranny::path::PathError;
use cranny::plan::PlanError;
use cranny::record::RecordError;
use cranny::robot::RobotError;
use cranny::scenario::ScenarioError;
use cranny::shape::ShapeError;
use cranny::solve::SolveError;
use cranny::task::TaskError;

use crate::text::c_text;

/// Result of a call. After any other than CRANNY_STATUS_OK, cranny_last_error gives the reason as text, and nothing that the
/// call should write may be used. A negative result (not free, not found, not valid) is no failure.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CrannyStatus {
    /// The call did what it promises.
    Ok = 0,
    /// An argument is NULL, has a wrong length, is not finite, or names something that does not exist.
    Argument = 1,
    /// A file, a text or a problem is refused; the text names its place and gives a hint.
    Refused = 2,
    /// A fault of Cranny itself. The handles stay usable; please report the text.
    Internal = 3,
}

/// Reason why a call failed.
#[derive(Debug, thiserror::Error)]
pub enum Fault {
    /// A required pointer is NULL.
    #[error("{what} is NULL")]
    Null {
        /// Name of the argument.
        what: &'static str,
    },
    /// A pointer is not aligned for its type.
    #[error("{what} is not aligned for its type")]
    Misaligned {
        /// Name of the argument.
        what: &'static str,
    },
    /// A text is not UTF-8.
    #[error("{what} is not UTF-8")]
    NotUtf8 {
        /// Name of the argument.
        what: &'static str,
    },
    /// Two lengths multiply to more than fits into memory.
    #[error("{what}: {rows} rows of {columns} values do not fit into memory")]
    TooLong {
        /// Name of the argument.
        what: &'static str,
        /// Number of rows.
        rows: usize,
        /// Number of columns.
        columns: usize,
    },
    /// A length does not fit.
    #[error("{what} is {actual}, but {expected} is expected{}", hint(reason))]
    Length {
        /// Name of the argument.
        what: &'static str,
        /// Length that fits.
        expected: usize,
        /// Given length.
        actual: usize,
        /// Source of the expected length; may be empty.
        reason: &'static str,
    },
    /// A number is not finite.
    #[error("{what}: value {index} is {value}, but must be finite")]
    NotFinite {
        /// Name of the argument.
        what: &'static str,
        /// Position in the array.
        index: usize,
        /// The number.
        value: f64,
    },
    /// A number is out of its range.
    #[error("{what} is {value}, but {expected}")]
    Range {
        /// Name of the argument.
        what: &'static str,
        /// The number.
        value: f64,
        /// Allowed range.
        expected: &'static str,
    },
    /// There is nothing of that name.
    #[error("{what} '{name}' is unknown (known: {known})")]
    Unknown {
        /// Kind of the thing.
        what: &'static str,
        /// Name that was given.
        name: String,
        /// Names that exist.
        known: String,
    },
    /// An index is too large.
    #[error("{what} is {index}, but there are {count}")]
    Index {
        /// Name of the argument.
        what: &'static str,
        /// The index.
        index: usize,
        /// Number of things.
        count: usize,
    },
    /// Two bodies have one name.
    #[error("there is a body '{name}' already, but names must be unique")]
    NamedTwice {
        /// The name.
        name: String,
    },
    /// Options that are not the expected JSON.
    #[error("options: {0}")]
    Options(#[from] serde_json::Error),
    /// A handle lacks what a call needs.
    #[error("{what}: {problem}")]
    Lacking {
        /// Name of the argument.
        what: &'static str,
        /// Missing part, with a hint.
        problem: &'static str,
    },
    /// Failure of the robot's files.
    #[error(transparent)]
    Robot(#[from] RobotError),
    /// Failure of a scenario's files.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// Failure of a shape.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// Failure of a cell.
    #[error(transparent)]
    Collision(#[from] CollisionError),
    /// Failure of a grasp.
    #[error(transparent)]
    Grasp(#[from] GraspError),
    /// Failure of a problem.
    #[error(transparent)]
    Task(#[from] TaskError),
    /// Failure of a path.
    #[error(transparent)]
    Path(#[from] PathError),
    /// Failure of a planner.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// Failure of a request.
    #[error(transparent)]
    Solve(#[from] SolveError),
    /// Failure of a plan file.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// Panic within a call.
    #[error("a fault of Cranny itself, please report it: {text}")]
    Panic {
        /// Text of the panic.
        text: String,
    },
}

fn hint(reason: &str) -> String {
    if reason.is_empty() { String::new() } else { format!(" ({reason})") }
}

impl Fault {
    fn status(&self) -> CrannyStatus {
        match self {
            Self::Null { .. }
            | Self::Misaligned { .. }
            | Self::NotUtf8 { .. }
            | Self::TooLong { .. }
            | Self::Length { .. }
            | Self::NotFinite { .. }
            | Self::Range { .. }
            | Self::Unknown { .. }
            | Self::Index { .. }
            | Self::NamedTwice { .. }
            | Self::Options(_)
            | Self::Lacking { .. } => CrannyStatus::Argument,
            Self::Panic { .. } => CrannyStatus::Internal,
            _ => CrannyStatus::Refused,
        }
    }
}

thread_local! {
    static LAST: RefCell<CString> = RefCell::default();
}

/// Keeps the text of a failure for [`cranny_last_error`], and returns its status.
pub fn remember(fault: &Fault) -> CrannyStatus {
    LAST.replace(c_text(&fault.to_string()));
    fault.status()
}

/// Returns the reason of the last failure in this thread, in one line or a few: UTF-8, empty before the first failure. It is
/// valid until the next failure in this thread.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_last_error() -> *const c_char {
    LAST.with_borrow(|text| text.as_ptr())
}
