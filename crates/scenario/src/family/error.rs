use cranny_file::did_you_mean;

/// Errors of scenario families. Each message is self-contained and names file and line if there are any.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FamilyError {
    /// The requested family does not exist.
    #[error("no family '{name}' (there are {known}){}", did_you_mean(name, known.split(", ")))]
    UnknownFamily {
        /// Requested name.
        name: String,
        /// Names of the families.
        known: String,
    },
    /// The parameter of a family is out of its range.
    #[error("{family}: the {parameter} must be from {low} to {high} m, but is {value}")]
    Parameter {
        /// Name of the family.
        family: &'static str,
        /// Name of its parameter.
        parameter: &'static str,
        /// Minimum value, in metres.
        low: f64,
        /// Maximum value, in metres.
        high: f64,
        /// Requested value, in metres.
        value: f64,
    },
}
