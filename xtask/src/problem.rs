//! Finding of a check.

use std::fmt;

/// Violation of a rule in the checkout, with its location and a remedy.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problem {
    /// Path relative to the root of the checkout, with `:line` if a line is at fault.
    pub place: String,
    /// Description of the violation.
    pub message: String,
    /// Remedy.
    pub hint: String,
}

impl Problem {
    /// Creates a finding at `place`.
    pub fn new(place: impl Into<String>, message: impl Into<String>, hint: impl Into<String>) -> Self {
        Self { place: place.into(), message: message.into(), hint: hint.into() }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}: {}\n    hint: {}", self.place, self.message, self.hint)
    }
}
