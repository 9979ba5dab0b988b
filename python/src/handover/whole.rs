//! Integers of Python, of any size and sign, and so possibly out of range.

use std::fmt::Display;
use std::ops::RangeInclusive;

use cranny_view::Picture;
use pyo3::exceptions::{PyOverflowError, PyTypeError};
use pyo3::prelude::*;

use crate::handover::fault::{bad_type, bad_value};

/// Maximum number of threads; more than any machine supports, so a larger number is a mistake.
const MOST_THREADS: usize = 1024;

/// Defines readers of arguments for `from_py_with`, each named like its argument, with the valid range.
macro_rules! arguments {
    ($($name:ident: $type:ty = $range:expr),* $(,)?) => {$(
        pub fn $name(value: &Bound<'_, PyAny>) -> PyResult<$type> {
            whole(value, stringify!($name), $range)
        }
    )*};
}

/// Defines such readers for arguments that may be None.
macro_rules! optional_arguments {
    ($($name:ident: $type:ty = $range:expr),* $(,)?) => {$(
        pub fn $name(value: &Bound<'_, PyAny>) -> PyResult<Option<$type>> {
            if value.is_none() { Ok(None) } else { whole(value, stringify!($name), $range).map(Some) }
        }
    )*};
}

arguments! {
    seed: u64 = 0..=u64::MAX,
    first_seed: u64 = 0..=u64::MAX,
    count: usize = 0..=usize::MAX,
    attempts: usize = 0..=usize::MAX,
    approaches: usize = 0..=usize::MAX,
    width: usize = Picture::SIDES,
    height: usize = Picture::SIDES,
    rate: u16 = 1..=50,
    runs: u64 = 0..=u64::MAX,
    memory_limit_mb: u64 = 0..=u64::MAX,
    workers: usize = 1..=1024,
    id: u64 = 0..=i64::MAX.cast_unsigned(),
}

optional_arguments! {
    iterations: u64 = 0..=u64::MAX,
    try_in_physics: u64 = 1..=1000,
    candidates: usize = 0..=usize::MAX,
    threads: usize = 1..=MOST_THREADS,
}

/// Reads an integer within a range; errors call it `what`.
fn whole<T>(value: &Bound<'_, PyAny>, what: &str, range: RangeInclusive<T>) -> PyResult<T>
where
    T: TryFrom<u64> + PartialOrd + Display,
{
    let number = match value.extract::<u64>() {
        Ok(number) => T::try_from(number).ok(),
        Err(reason) if reason.is_instance_of::<PyOverflowError>(value.py()) => None,
        Err(reason) if reason.is_instance_of::<PyTypeError>(value.py()) => {
            return Err(bad_type(format!("{what}: a whole number is expected, not {}", value.get_type())));
        }
        Err(reason) => return Err(reason),
    };
    number.filter(|number| range.contains(number)).ok_or_else(|| {
        // Python refuses to format integers of thousands of digits.
        let shown = value.str().map_or_else(|_| "huge".to_owned(), |text| text.to_string());
        let (low, high) = (range.start(), range.end());
        bad_value(format!("{what} is {shown}, but a whole number from {low} to {high} is expected"))
    })
}
