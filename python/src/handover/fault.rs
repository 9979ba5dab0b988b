//! Exceptions for bad input.

use std::fmt::Display;

use pyo3::PyErr;
use pyo3::exceptions::{PyTypeError, PyValueError};

pyo3::create_exception!(
    cranny,
    CrannyError,
    PyValueError,
    "What is wrong with a file, a scene, a robot or a call. The message is complete in itself: file and line \
     where there is one, and a hint. A `ValueError`."
);

/// Converts the error of another crate.
pub fn fault(reason: impl Display) -> PyErr {
    CrannyError::new_err(reason.to_string())
}

/// Returns an error for a value of the right type that is invalid.
pub fn bad_value(message: impl Into<String>) -> PyErr {
    PyValueError::new_err(message.into())
}

/// Returns an error for a value of the wrong type.
pub fn bad_type(message: impl Into<String>) -> PyErr {
    PyTypeError::new_err(message.into())
}
