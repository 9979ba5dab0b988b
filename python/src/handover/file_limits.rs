use pyo3::prelude::*;

/// Lets this process read files of any size from now on, as `--large-files` does; the default limits are 1 GiB for a mesh or a
/// table, 256 MiB for a packed scenario and 64 MiB for any other file.
#[pyfunction]
pub fn lift_file_limits() {
    cranny_file::lift_limits();
}
