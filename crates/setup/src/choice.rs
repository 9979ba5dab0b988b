use serde::Serialize;

/// Choice made for a setting that was not given.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Choice {
    /// Subject of the choice.
    pub what: &'static str,
    /// Chosen value.
    pub chosen: String,
    /// Reason for the choice.
    pub why: String,
    /// Instruction to choose differently.
    pub otherwise: String,
}

impl Choice {
    pub(crate) fn new(what: &'static str, chosen: impl Into<String>, why: &str, otherwise: &str) -> Self {
        Self { what, chosen: chosen.into(), why: why.to_owned(), otherwise: otherwise.to_owned() }
    }

    pub(crate) fn line(&self) -> String {
        format!("{}: {} ({})", self.what, self.chosen, self.why)
    }
}
