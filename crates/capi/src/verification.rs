//! `CrannyVerification`: the verdict on a path.

use std::ffi::{CString, c_char};
use std::ptr::null;

use cranny::Audit;

use crate::boundary::{answered, given};
use crate::robot::named;
use crate::text::c_text;

/// Verdict on a path. It never changes.
#[derive(Debug)]
pub struct CrannyVerification {
    audit: Audit,
    violations: Vec<CString>,
    json: CString,
}

impl CrannyVerification {
    /// Wraps a verdict.
    pub fn of(audit: Audit) -> Box<Self> {
        let violations = audit.violations.iter().map(|violation| c_text(&violation.to_string())).collect();
        let json = c_text(&serde_json::to_string(&audit).unwrap_or_default());
        Box::new(Self { audit, violations, json })
    }
}

/// Frees a verification. NULL is ignored.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_verification_free(verification: Option<Box<CrannyVerification>>) {
    drop(verification);
}

/// Returns whether the path meets the criterion; false for NULL.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_verification_is_valid(verification: Option<&CrannyVerification>) -> bool {
    answered(false, || Ok(given(verification, "verification")?.audit.valid))
}

/// Returns the least distance along the whole path in metres, a certified lower bound; NaN under the criterion "paper", or
/// without pairs to check.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_verification_clearance_m(verification: Option<&CrannyVerification>) -> f64 {
    answered(f64::NAN, || Ok(given(verification, "verification")?.audit.clearance_m.unwrap_or(f64::NAN)))
}

/// Returns the number of violations; 0 for NULL.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_verification_violation_count(verification: Option<&CrannyVerification>) -> usize {
    answered(0, || Ok(given(verification, "verification")?.violations.len()))
}

/// Returns a violation as a sentence, in the order of the path, valid as long as the verification; NULL for an index that is
/// too large.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_verification_violation(
    verification: Option<&CrannyVerification>,
    violation: usize,
) -> *const c_char {
    answered(null(), || named(&given(verification, "verification")?.violations, "violation", violation))
}

/// Returns everything that was found as JSON, as `cranny verify --json` writes it, valid as long as the verification.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_verification_json(verification: Option<&CrannyVerification>) -> *const c_char {
    answered(null(), || Ok(given(verification, "verification")?.json.as_ptr()))
}
