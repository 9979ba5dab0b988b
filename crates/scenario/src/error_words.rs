//! What messages of errors are made of.

use std::path::PathBuf;

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
