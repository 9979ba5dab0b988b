//! Names of criteria and geometries.

use cranny_scenario::Geometry;
use cranny_task::Criterion;
use pyo3::prelude::*;

use crate::handover::fault::bad_value;

/// Parses the name of a geometry.
pub fn geometry_of(name: &str) -> PyResult<Geometry> {
    let unknown = |_| bad_value(format!("geometry is '{name}', but \"scene\" or \"export\" is expected"));
    name.parse().map_err(unknown)
}

/// Parses the name of a criterion.
pub fn criterion_of(name: &str) -> PyResult<Criterion> {
    name.parse().map_err(|_| bad_value(format!("unknown criterion '{name}' (known: exact, paper)")))
}
