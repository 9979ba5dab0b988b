use cranny_file::did_you_mean;

/// What can be wrong with a family of scenarios. The message is complete in itself: file and line where there is one.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FamilyError {
    /// A family is asked for that there is not.
    #[error("no family '{name}' (there are {known}){}", did_you_mean(name, known.split(", ")))]
    UnknownFamily {
        /// What was asked for.
        name: String,
        /// The families.
        known: String,
    },
    /// The parameter of a family is out of its range.
    #[error("{family}: the {parameter} must be from {low} to {high} m, but is {value}")]
    Parameter {
        /// The family.
        family: &'static str,
        /// What its parameter is.
        parameter: &'static str,
        /// The least value.
        low: f64,
        /// The greatest.
        high: f64,
        /// What was given.
        value: f64,
    },
}
