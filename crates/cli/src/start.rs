use std::sync::Arc;

use cranny_collision::{Cell, Collider};
use cranny_task::Problem;

/// Maximum number of reasons listed.
const MOST: usize = 8;

/// Returns the reasons why the start of a problem is not free, one per line; empty if it is free.
pub fn faults(problem: &Problem) -> Vec<String> {
    if problem.start_is_free() {
        return Vec::new();
    }
    let faults = problem.configuration_faults(problem.start());
    let mut lines: Vec<String> = faults.iter().take(MOST).map(ToString::to_string).collect();
    if faults.len() > MOST {
        lines.push(format!("and {} more", faults.len() - MOST));
    }
    let is_of_links = |cell: &Arc<Cell>| {
        let contacts = cell.contacts(problem.start(), &mut cell.scratch());
        contacts.iter().any(|contact| matches!(contact.second, Collider::Link(_)))
    };
    if problem.cell().is_some_and(is_of_links) {
        lines.push(
            "declare links that may touch each other in an SRDF or as unchecked_pairs in scenario.yaml; \
             `cranny robot add` proposes them"
                .to_owned(),
        );
    }
    lines
}
