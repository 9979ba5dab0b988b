use cranny_collision::Collider;
use cranny_plan::Problem;

use crate::text::millimetres;

/// At most so many reasons are listed.
const MOST: usize = 8;

/// Why the start of a problem is not free, a line each; nothing if it is.
pub fn faults(problem: &Problem) -> Vec<String> {
    if problem.start_is_free() {
        return Vec::new();
    }
    if let Some(violation) = problem.robot().first_limit_violation(problem.start()) {
        let name = &problem.robot().joint_names()[violation.joint];
        return vec![format!(
            "{name} is {:.4}, outside its limits [{:.4}, {:.4}]",
            violation.value, violation.lower, violation.upper
        )];
    }
    let Some(cell) = problem.cell() else {
        return vec![
            "the released check refuses it: a link touches, or is below the floor height".to_owned(),
        ];
    };
    let contacts = cell.contacts(problem.start(), &mut cell.scratch());
    let describe = |contact: &cranny_collision::Contact| {
        let [first, second] = contact.names(cell);
        if contact.clearance_m < cranny_spatial::CONTACT_M {
            format!("{first} touches {second}, {} deep", millimetres(contact.depth_m))
        } else {
            let (is, demanded) = (millimetres(contact.clearance_m), millimetres(contact.required_m));
            format!("{first} is {is} from {second}, but {demanded} is demanded")
        }
    };
    let mut faults: Vec<String> = contacts.iter().take(MOST).map(describe).collect();
    if contacts.len() > MOST {
        faults.push(format!("and {} more pairs", contacts.len() - MOST));
    }
    let is_of_links = |contact: &cranny_collision::Contact| matches!(contact.second, Collider::Link(_));
    if contacts.iter().any(is_of_links) {
        faults.push(
            "links that may touch each other are declared in an SRDF or as unchecked_pairs in scenario.yaml; \
             `cranny robot add` proposes them"
                .to_owned(),
        );
    }
    faults
}
