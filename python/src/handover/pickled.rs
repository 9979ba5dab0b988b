//! What a pickle holds of a thing: what it was made by and of, and for what comes from files a fingerprint, so that
//! who opens it elsewhere gets the same thing or an error.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use pyo3::call::PyCallArgs;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::handover::fault::fault;

/// How a thing was made: a function of Python that can be pickled, and its arguments.
#[derive(Clone)]
pub struct Made(pub Option<Arc<Call>>);

pub struct Call {
    pub function: Py<PyAny>,
    pub arguments: Py<PyTuple>,
    /// Whether files were read, which may be others by then.
    pub is_of_files: bool,
}

/// A function and its arguments: what `__reduce__` returns.
pub type Reduced<'py> = (Bound<'py, PyAny>, Bound<'py, PyTuple>);

impl Made {
    /// By nothing that could be called again.
    pub const UNKNOWN: Self = Self(None);

    /// By `function(*arguments)`.
    pub fn by<'py>(
        function: Bound<'py, PyAny>,
        arguments: impl IntoPyObject<'py, Target = PyTuple, Output = Bound<'py, PyTuple>, Error: Into<PyErr>>,
    ) -> PyResult<Self> {
        let arguments = arguments.into_pyobject(function.py()).map_err(Into::<PyErr>::into)?.unbind();
        Ok(Self(Some(Arc::new(Call { function: function.unbind(), arguments, is_of_files: false }))))
    }

    /// By `class(*arguments, **keywords)` or a static method of it, from files or from what the package has.
    pub fn opened<'py>(
        function: &Bound<'py, PyAny>,
        arguments: impl IntoPyObject<'py, Target = PyTuple, Output = Bound<'py, PyTuple>, Error: Into<PyErr>>,
        keywords: &Bound<'py, PyDict>,
    ) -> PyResult<Self> {
        let arguments = arguments.into_pyobject(function.py()).map_err(Into::<PyErr>::into)?.unbind();
        let function = partial(function, keywords)?.unbind();
        Ok(Self(Some(Arc::new(Call { function, arguments, is_of_files: true }))))
    }

    /// By `owner.method(*arguments, **keywords)`.
    pub fn by_method<'py>(
        owner: &Bound<'py, PyAny>,
        arguments: impl PyCallArgs<'py>,
        keywords: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Self> {
        let caller = owner.py().import("operator")?.getattr("methodcaller")?.call(arguments, keywords)?;
        Self::by(caller, (owner,))
    }

    /// By `owner.name`.
    pub fn by_attribute(owner: &Bound<'_, PyAny>, name: &str) -> PyResult<Self> {
        Self::by(owner.py().import("operator")?.getattr("attrgetter")?.call1((name,))?, (owner,))
    }
}

/// `functools.partial(function, **keywords)`.
pub fn partial<'py>(
    function: &Bound<'py, PyAny>,
    keywords: &Bound<'py, PyDict>,
) -> PyResult<Bound<'py, PyAny>> {
    function.py().import("functools")?.getattr("partial")?.call((function,), Some(keywords))
}

/// What `__reduce__` returns for what a function of this module makes anew.
pub fn restored_by<'py>(
    py: Python<'py>,
    function: &str,
    arguments: impl IntoPyObject<'py, Target = PyTuple, Output = Bound<'py, PyTuple>, Error: Into<PyErr>>,
) -> PyResult<Reduced<'py>> {
    let function = py.import("cranny._cranny")?.getattr(function)?;
    Ok((function, arguments.into_pyobject(py).map_err(Into::into)?))
}

/// A path that means the same in another folder.
pub fn absolute(path: &Path) -> PyResult<PathBuf> {
    std::path::absolute(path).map_err(fault)
}
