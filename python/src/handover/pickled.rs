//! Contents of pickles: the constructor call of an object, and for files a fingerprint, which reveals changes at unpickling.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use pyo3::call::PyCallArgs;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::handover::fault::fault;

/// Constructor call of an object: a picklable function of Python, and its arguments.
#[derive(Clone)]
pub struct Made(pub Option<Arc<Call>>);

pub struct Call {
    pub function: Py<PyAny>,
    pub arguments: Py<PyTuple>,
    /// True if files were read, which may have changed since.
    pub is_of_files: bool,
}

/// Result of `__reduce__`: a function and its arguments.
pub type Reduced<'py> = (Bound<'py, PyAny>, Bound<'py, PyTuple>);

impl Made {
    /// Object without a constructor call that can be repeated.
    pub const UNKNOWN: Self = Self(None);

    /// Object made by `function(*arguments)`.
    pub fn by<'py>(
        function: Bound<'py, PyAny>,
        arguments: impl IntoPyObject<'py, Target = PyTuple, Output = Bound<'py, PyTuple>, Error: Into<PyErr>>,
    ) -> PyResult<Self> {
        let arguments = arguments.into_pyobject(function.py()).map_err(Into::<PyErr>::into)?.unbind();
        Ok(Self(Some(Arc::new(Call { function: function.unbind(), arguments, is_of_files: false }))))
    }

    /// Object made by `class(*arguments, **keywords)` or a static method of it, from files or from data of the package.
    pub fn opened<'py>(
        function: &Bound<'py, PyAny>,
        arguments: impl IntoPyObject<'py, Target = PyTuple, Output = Bound<'py, PyTuple>, Error: Into<PyErr>>,
        keywords: &Bound<'py, PyDict>,
    ) -> PyResult<Self> {
        let arguments = arguments.into_pyobject(function.py()).map_err(Into::<PyErr>::into)?.unbind();
        let function = partial(function, keywords)?.unbind();
        Ok(Self(Some(Arc::new(Call { function, arguments, is_of_files: true }))))
    }

    /// Object made by `owner.method(*arguments, **keywords)`.
    pub fn by_method<'py>(
        owner: &Bound<'py, PyAny>,
        arguments: impl PyCallArgs<'py>,
        keywords: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Self> {
        let caller = owner.py().import("operator")?.getattr("methodcaller")?.call(arguments, keywords)?;
        Self::by(caller, (owner,))
    }

    /// Object made by `owner.name`.
    pub fn by_attribute(owner: &Bound<'_, PyAny>, name: &str) -> PyResult<Self> {
        Self::by(owner.py().import("operator")?.getattr("attrgetter")?.call1((name,))?, (owner,))
    }
}

/// Returns `functools.partial(function, **keywords)`.
pub fn partial<'py>(
    function: &Bound<'py, PyAny>,
    keywords: &Bound<'py, PyDict>,
) -> PyResult<Bound<'py, PyAny>> {
    function.py().import("functools")?.getattr("partial")?.call((function,), Some(keywords))
}

/// Returns the result of `__reduce__` that calls a function of this module.
pub fn restored_by<'py>(
    py: Python<'py>,
    function: &str,
    arguments: impl IntoPyObject<'py, Target = PyTuple, Output = Bound<'py, PyTuple>, Error: Into<PyErr>>,
) -> PyResult<Reduced<'py>> {
    let function = py.import("cranny._cranny")?.getattr(function)?;
    Ok((function, arguments.into_pyobject(py).map_err(Into::into)?))
}

/// Returns a path that is independent of the current folder.
pub fn absolute(path: &Path) -> PyResult<PathBuf> {
    std::path::absolute(path).map_err(fault)
}
