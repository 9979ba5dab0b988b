use cranny_path::{AuditSettings, audit_task};
use cranny_solve::Answer;
use cranny_task::{Problem, Stage};

use crate::ExploreError;

/// Returns the first fault of the path of an answer in the problem of the true scenario, in words: a contact, or a missed grasp;
/// `None` if the path is valid there.
///
/// # Errors
/// Those of [`audit_task`].
pub fn true_contact(truth: &Problem, answer: &Answer) -> Result<Option<String>, ExploreError> {
    let of_goal = Stage::of_goal(truth);
    let stages = if answer.stages.is_empty() { &of_goal } else { &answer.stages };
    let audit = audit_task(truth, stages, &answer.segments, AuditSettings::default())?;
    Ok(match audit.violations.first() {
        Some(violation) => Some(violation.to_string()),
        None => (!audit.valid).then(|| "the audit is not complete".to_owned()),
    })
}
