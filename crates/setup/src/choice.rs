use serde::Serialize;

/// Something that was chosen where nobody said it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Choice {
    /// What it is about.
    pub what: &'static str,
    /// What was chosen.
    pub chosen: String,
    /// Why.
    pub why: String,
    /// How to choose otherwise.
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
