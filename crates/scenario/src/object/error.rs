use std::path::PathBuf;

use cranny_file::did_you_mean_here;

/// What can be wrong with an object to be grasped. The message is complete in itself: file and line where there is one.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ObjectError {
    /// Nothing says what the target weighs.
    #[error(
        "scenario '{id}' does not say what its target '{target}' weighs (write mass_kg beneath target in scenario.yaml)"
    )]
    NoMass {
        /// The scenario.
        id: String,
        /// The body to be grasped.
        target: String,
    },
    /// A mesh is too large or too small for an object that a hand grasps.
    #[error(
        "{file}the object is {} long, so its mesh is hardly in metres (if it is in {unit}, scale it by {scale}: \
         --scale {scale})",
        length(*size_m)
    )]
    Size {
        /// The mesh file and a colon, if it is from a file.
        file: String,
        /// Its greatest extent as read, in metres.
        size_m: f64,
        /// The unit that the mesh may be in.
        unit: &'static str,
        /// The scale that would then be right.
        scale: f64,
    },
    /// A number that describes an object is none.
    #[error("the {what} of an object must be a positive number, but is {value}")]
    Number {
        /// Which number.
        what: &'static str,
        /// The offending value.
        value: f64,
    },
    /// A figure of an `object.yaml` is not that of the meshes.
    #[error(
        "{}: {figures} (`cranny object add` with --mass writes the folder anew)",
        path.display()
    )]
    Stated {
        /// The file.
        path: PathBuf,
        /// The key, its value in the file, and the one that was measured or those that can be.
        figures: String,
    },
    /// No built-in object has that name.
    #[error(
        "there is no built-in object '{name}' (there are: {known}) and no folder of that name with object.yaml{}",
        did_you_mean_here(name, known.split(", "))
    )]
    Unknown {
        /// The name.
        name: String,
        /// The names that there are.
        known: String,
    },
}

/// A length as a person says it.
fn length(metres: f64) -> String {
    if metres >= 1.0 { format!("{metres:.3} m") } else { format!("{:.4} mm", metres * 1000.0) }
}
