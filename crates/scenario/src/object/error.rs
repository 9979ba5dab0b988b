use std::path::PathBuf;

use cranny_file::did_you_mean_here;

/// Errors of objects to be grasped. Each message is self-contained and names file and line if there are any.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ObjectError {
    /// The mass of a body to be held is not given.
    #[error(
        "scenario '{id}' does not state the mass of '{target}' (add mass_kg to its entry in scenario.yaml)"
    )]
    NoMass {
        /// The scenario.
        id: String,
        /// Name of the body.
        target: String,
    },
    /// A mesh is too large or too small for an object to grasp.
    #[error(
        "{file}the object is {} long, so its mesh is probably not in metres (if it is in {unit}, scale it by \
         {scale}: --scale {scale})",
        length(*size_m)
    )]
    Size {
        /// Mesh file and a colon, if the mesh is from a file.
        file: String,
        /// Maximum extent as read, in metres.
        size_m: f64,
        /// Unit that the mesh is likely in.
        unit: &'static str,
        /// Scale that converts that unit to metres.
        scale: f64,
    },
    /// A number that describes an object is invalid.
    #[error("the {what} of an object must be a positive number, but is {value}")]
    Number {
        /// Description of the number.
        what: &'static str,
        /// Invalid value.
        value: f64,
    },
    /// The ends of a range of friction are exchanged.
    #[error("a range of friction goes from its lower end to its upper one, not from {low} to {high}")]
    Friction {
        /// First end.
        low: f64,
        /// Second end.
        high: f64,
    },
    /// A figure of an `object.yaml` disagrees with the meshes.
    #[error(
        "{}: {figures} (`cranny object add` with --mass writes the folder anew)",
        path.display()
    )]
    Stated {
        /// The file.
        path: PathBuf,
        /// Key, its value in the file, and the measured or valid values.
        figures: String,
    },
    /// No built-in object has that name.
    #[error(
        "there is no built-in object '{name}' (there are: {known}) and no folder of that name with object.yaml{}",
        did_you_mean_here(name, known.split(", "))
    )]
    Unknown {
        /// Requested name.
        name: String,
        /// Names of the built-in objects.
        known: String,
    },
}

/// Checks that a number of an object is positive.
pub(crate) fn check_number(what: &'static str, value: f64) -> Result<(), ObjectError> {
    if value > 0.0 && value.is_finite() { Ok(()) } else { Err(ObjectError::Number { what, value }) }
}

/// Returns a length as text in a readable unit.
fn length(metres: f64) -> String {
    if metres >= 1.0 { format!("{metres:.3} m") } else { format!("{:.4} mm", metres * 1000.0) }
}
