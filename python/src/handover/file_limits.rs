use pyo3::prelude::*;

/// From now on this process reads files of any size, as `--large-files` does: a mesh or a table may else hold 1 GiB, a
/// packed scenario 256 MiB, any other file 64 MiB.
#[pyfunction]
pub fn lift_file_limits() {
    cranny_file::lift_limits();
}
