//! What messages of errors are made of.

use std::path::{Path, PathBuf};

use crate::ScenarioError;

/// The names that may be meant, or else a hint.
pub(crate) fn meant(near: &[&str], hint: &str) -> String {
    if near.is_empty() { hint.to_owned() } else { format!("did you mean {}?", near.join(" or ")) }
}

/// Paths as a list.
pub(crate) fn listed(paths: &[PathBuf]) -> String {
    paths.iter().map(|path| path.display().to_string()).collect::<Vec<_>>().join(", ")
}

/// A length as a person says it.
pub(crate) fn length(metres: f64) -> String {
    if metres >= 1.0 { format!("{metres:.3} m") } else { format!("{:.4} mm", metres * 1000.0) }
}

impl ScenarioError {
    /// The same fault, said of the mesh file that it was found in.
    #[must_use]
    pub fn in_mesh(self, path: &Path) -> Self {
        match self {
            Self::ShapeFile(fault) => Self::ShapeFile(fault.in_file(path)),
            Self::ObjectSize { size_m, unit, scale, .. } => {
                Self::ObjectSize { file: format!("{}: ", path.display()), size_m, unit, scale }
            }
            fault => fault,
        }
    }
}
