use cranny_path::{AuditSettings, audit_task};
use cranny_solve::Answer;
use cranny_task::Problem;

use crate::ExploreError;

/// Returns the first fault of the path of an answer in the problem of the true scenario, in words: a contact, or a missed grasp;
/// `None` if the path is valid there.
///
/// # Errors
/// Those of [`audit_task`].
pub fn true_contact(truth: &Problem, answer: &Answer) -> Result<Option<String>, ExploreError> {
    let audit = audit_task(truth, &answer.stages, &answer.segments, AuditSettings::default())?;
    Ok(match audit.violations.first() {
        Some(violation) => Some(violation.to_string()),
        None => (!audit.valid).then(|| "the audit is not complete".to_owned()),
    })
}
