//! Pointers from C, and the guard around each exported function. All `unsafe` code of the crate is here, apart from the
//! attribute that exports a function under its name.
//!
//! The types of this module have the layout of one pointer. Only C makes a value of them, as an argument of a call, and
//! promises the rules at the head of `cranny.h`: the pointer is NULL, or it points to as many values as the length that is
//! passed with it, until the call returns.

use std::ffi::{CStr, c_char};
use std::marker::PhantomData;
use std::mem::MaybeUninit;
use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::error::{CrannyStatus, Fault, remember};

/// Text that ends with a zero byte, or NULL.
#[repr(transparent)]
#[derive(Clone, Copy)]
pub struct Text<'a>(*const c_char, PhantomData<&'a c_char>);

/// First of an array of numbers, or NULL.
#[repr(transparent)]
#[derive(Clone, Copy)]
pub struct Numbers<'a>(*const f64, PhantomData<&'a f64>);

/// First of an array of indices, or NULL.
#[repr(transparent)]
#[derive(Clone, Copy)]
pub struct Indices<'a>(*const u32, PhantomData<&'a u32>);

/// First of an array that receives numbers, or NULL.
#[repr(transparent)]
pub struct NumberBuffer<'a>(*mut f64, PhantomData<&'a mut f64>);

/// First of an array that receives verdicts, or NULL.
#[repr(transparent)]
pub struct FlagBuffer<'a>(*mut bool, PhantomData<&'a mut bool>);

impl<'a> Text<'a> {
    /// Returns the text, or `None` for NULL.
    pub fn optional(self, what: &'static str) -> Result<Option<&'a str>, Fault> {
        if self.0.is_null() {
            return Ok(None);
        }
        // SAFETY: the pointer is not NULL, and C promises a text that ends with a zero byte and lasts until the call returns.
        let text = unsafe { CStr::from_ptr(self.0) };
        text.to_str().map(Some).map_err(|_| Fault::NotUtf8 { what })
    }

    /// Returns the text.
    pub fn read(self, what: &'static str) -> Result<&'a str, Fault> {
        self.optional(what)?.ok_or(Fault::Null { what })
    }
}

impl<'a> Numbers<'a> {
    /// Returns true for NULL.
    pub fn is_null(&self) -> bool {
        self.0.is_null()
    }

    /// Returns `rows` × `columns` numbers (m, rad or others; one for each column of each row), finite or not.
    pub fn values(self, what: &'static str, rows: usize, columns: usize) -> Result<&'a [f64], Fault> {
        // SAFETY: C promises that many values, until the call returns.
        unsafe { array(self.0, what, rows, columns) }
    }

    /// Returns `rows` × `columns` finite numbers (m, rad or others; one for each column of each row).
    pub fn finite(self, what: &'static str, rows: usize, columns: usize) -> Result<&'a [f64], Fault> {
        let values = self.values(what, rows, columns)?;
        match values.iter().position(|value| !value.is_finite()) {
            None => Ok(values),
            Some(index) => Err(Fault::NotFinite { what, index, value: values[index] }),
        }
    }
}

impl<'a> Indices<'a> {
    /// Returns `rows` rows of `columns` indices.
    pub fn values(self, what: &'static str, rows: usize, columns: usize) -> Result<&'a [u32], Fault> {
        // SAFETY: C promises that many values, until the call returns.
        unsafe { array(self.0, what, rows, columns) }
    }
}

impl NumberBuffer<'_> {
    /// Writes `values` (m, rad or others; one for each number for which C promises memory).
    pub fn write(&mut self, what: &'static str, values: &[f64]) -> Result<(), Fault> {
        // SAFETY: C promises memory for that many values, which nothing else uses during the call.
        unsafe { copy(values, self.0, what) }
    }

    /// Writes `values` (m, rad or others; one for each number for which C promises memory), unless the buffer is NULL.
    pub fn write_if_asked(&mut self, what: &'static str, values: &[f64]) -> Result<(), Fault> {
        if self.0.is_null() { Ok(()) } else { self.write(what, values) }
    }
}

impl FlagBuffer<'_> {
    /// Writes `values`, for which C promises memory.
    pub fn write(&mut self, what: &'static str, values: &[bool]) -> Result<(), Fault> {
        // SAFETY: C promises memory for that many values, which nothing else uses during the call.
        unsafe { copy(values, self.0, what) }
    }
}

/// Returns the array that begins at `first`.
///
/// # Safety
/// `first` is NULL or begins `rows` × `columns` values that last for `'a` and do not change.
unsafe fn array<'a, T>(
    first: *const T,
    what: &'static str,
    rows: usize,
    columns: usize,
) -> Result<&'a [T], Fault> {
    let count = rows.checked_mul(columns).filter(|count| *count <= isize::MAX as usize / size_of::<T>());
    let count = count.ok_or(Fault::TooLong { what, rows, columns })?;
    if count == 0 {
        return Ok(&[]);
    }
    check_address(first, what)?;
    // SAFETY: not NULL, aligned, at most `isize::MAX` bytes; the caller promises the rest.
    Ok(unsafe { std::slice::from_raw_parts(first, count) })
}

/// Copies `values` to the array that begins at `first`.
///
/// # Safety
/// `first` is NULL or begins memory for as many values, which nothing else uses during the call.
unsafe fn copy<T: Copy>(values: &[T], first: *mut T, what: &'static str) -> Result<(), Fault> {
    if values.is_empty() {
        return Ok(());
    }
    check_address(first, what)?;
    // SAFETY: not NULL and aligned; the caller promises the memory, which therefore does not overlap `values`.
    unsafe { std::ptr::copy_nonoverlapping(values.as_ptr(), first, values.len()) };
    Ok(())
}

fn check_address<T>(first: *const T, what: &'static str) -> Result<(), Fault> {
    if first.is_null() {
        Err(Fault::Null { what })
    } else if !first.is_aligned() {
        Err(Fault::Misaligned { what })
    } else {
        Ok(())
    }
}

/// Returns an argument that must not be NULL.
pub fn given<T>(argument: Option<T>, what: &'static str) -> Result<T, Fault> {
    argument.ok_or(Fault::Null { what })
}

/// Writes one value to a place of the caller, whose old content is not read.
pub fn put<T>(place: Option<&mut MaybeUninit<T>>, what: &'static str, value: T) -> Result<(), Fault> {
    given(place, what)?.write(value);
    Ok(())
}

/// Runs the body of an exported function: a failure or a panic becomes a status and the text of `cranny_last_error`.
pub fn guarded(work: impl FnOnce() -> Result<(), Fault>) -> CrannyStatus {
    match outcome(work) {
        Ok(()) => CrannyStatus::Ok,
        Err(fault) => remember(&fault),
    }
}

/// Runs the body of an exported function that returns a value: `otherwise` stands for a failure or a panic.
pub fn answered<T>(otherwise: T, work: impl FnOnce() -> Result<T, Fault>) -> T {
    outcome(work).unwrap_or_else(|fault| {
        remember(&fault);
        otherwise
    })
}

fn outcome<T>(work: impl FnOnce() -> Result<T, Fault>) -> Result<T, Fault> {
    // A handle holds nothing that changes except the scratch of a cell, which is made anew after a panic.
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
        let text = text.or_else(|| panic.downcast_ref::<String>().cloned());
        Err(Fault::Panic { text: text.unwrap_or_else(|| "no text".to_owned()) })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(values: &[f64]) -> Numbers<'_> {
        Numbers(values.as_ptr(), PhantomData)
    }

    #[test]
    fn null_is_an_error_unless_nothing_is_expected_there() {
        let null = Numbers(std::ptr::null(), PhantomData);
        assert!(matches!(null.values("q", 1, 9), Err(Fault::Null { what: "q" })));
        assert_eq!(null.values("q", 0, 9).expect("nothing").len(), 0);
        assert!(matches!(Text(std::ptr::null(), PhantomData).read("name"), Err(Fault::Null { .. })));
    }

    #[test]
    fn impossible_lengths_and_addresses_are_errors() {
        let values = [0.0; 4];
        assert!(matches!(numbers(&values).values("q", usize::MAX, 2), Err(Fault::TooLong { .. })));
        assert!(matches!(numbers(&values).values("q", usize::MAX / 8, 1), Err(Fault::TooLong { .. })));
        let odd = Numbers(values.as_ptr().wrapping_byte_add(1), PhantomData);
        assert!(matches!(odd.values("q", 1, 2), Err(Fault::Misaligned { what: "q" })));
    }

    #[test]
    fn a_number_that_is_not_finite_is_named() {
        let fault = numbers(&[0.0, f64::NAN]).finite("q", 1, 2).expect_err("not finite");
        assert_eq!(fault.to_string(), "q: value 1 is NaN, but must be finite");
    }

    #[test]
    fn a_panic_becomes_a_status() {
        let status = guarded(|| panic!("on purpose"));
        assert_eq!(status, CrannyStatus::Internal);
        assert_eq!(answered(7, || panic!("on purpose")), 7);
    }
}
