use std::collections::BTreeSet;
use std::fmt::Write as _;

use cranny_file::counted;

use crate::description::urdf_text::escaped;
use crate::model_file::body_tree::BodyTree;
use crate::model_file::urdf_writer::{BodyLink, LinkPlan};

/// Reason for pairs whose masks do not meet.
const MASKS: &str = "contype and conaffinity";

impl BodyTree {
    /// Returns a note if links are not checked against each other because their masks do not meet.
    pub(crate) fn mask_note(srdf: &str, file: &str) -> Option<String> {
        let count = srdf.matches(MASKS).count();
        let pairs = counted(count, "pair");
        let note = format!(
            "{file}: {pairs} of links not checked, because contype and conaffinity exclude them (an SRDF beside the model \
             replaces this choice)"
        );
        (count > 0).then_some(note)
    }

    /// Returns an SRDF with the pairs of links that have no contacts in the model, those that have contacts although they are
    /// adjacent, and the named states.
    ///
    /// Two links have no contacts if their masks do not meet, if the model excludes their bodies, or if one body is the parent
    /// of the other and moves; bodies without a joint between them count as one (`MuJoCo`, XML reference, Collision detection).
    pub(crate) fn srdf(&self, plan: &LinkPlan) -> String {
        let mut text = format!("<robot name=\"{}\">\n", escaped(&self.name));
        let joints: BTreeSet<&String> =
            self.states.iter().flat_map(|state| state.values.iter().map(|(joint, _)| joint)).collect();
        if !joints.is_empty() {
            text.push_str("  <group name=\"keyframes\">\n");
            for joint in joints {
                let _ = writeln!(text, "    <joint name=\"{}\"/>", escaped(joint));
            }
            text.push_str("  </group>\n");
        }
        for state in &self.states {
            let _ = writeln!(text, "  <group_state name=\"{}\" group=\"keyframes\">", escaped(&state.name));
            for (joint, value) in &state.values {
                let _ = writeln!(text, "    <joint name=\"{}\" value=\"{value}\"/>", escaped(joint));
            }
            text.push_str("  </group_state>\n");
        }
        let [excluded, included] = [&self.excluded, &self.included]
            .map(|pairs| pairs.iter().map(|pair| sorted(*pair)).collect::<BTreeSet<[usize; 2]>>());
        let welded = self.welded();
        let links: Vec<(usize, &BodyLink)> = plan.colliding().collect();
        for (index, (body, link)) in links.iter().enumerate() {
            for (other_body, other) in &links[index + 1..] {
                if welded[*body] == welded[*other_body] {
                    continue;
                }
                let groups = link.mask.pair.zip(other.mask.pair);
                let reason = if groups.is_some_and(|(a, b)| included.contains(&sorted([a, b]))) {
                    continue;
                } else if excluded.contains(&sorted([*body, *other_body])) {
                    "excluded"
                } else if !link.mask.meets(other.mask) {
                    MASKS
                } else if self.filters_parents && self.is_parent(&welded, *body, *other_body) {
                    "parent and child"
                } else {
                    continue;
                };
                let _ = writeln!(
                    text,
                    "  <disable_collisions link1=\"{}\" link2=\"{}\" reason=\"{reason}\"/>",
                    escaped(&link.name),
                    escaped(&other.name)
                );
            }
        }
        text + "</robot>\n"
    }

    /// Returns the topmost body that each body is rigid with.
    fn welded(&self) -> Vec<usize> {
        let mut welded: Vec<usize> = Vec::with_capacity(self.bodies.len());
        for (index, body) in self.bodies.iter().enumerate() {
            let moves = !body.joints.is_empty() || body.is_free;
            welded.push(match body.parent {
                Some(parent) if !moves => welded[parent],
                _ => index,
            });
        }
        welded
    }

    /// Returns true if one of two bodies is the parent of the other, and neither is part of the world.
    fn is_parent(&self, welded: &[usize], one: usize, other: usize) -> bool {
        let above = |body: usize| self.bodies[welded[body]].parent.map(|parent| welded[parent]);
        let (first, second) = (welded[one], welded[other]);
        first != 0 && second != 0 && (above(one) == Some(second) || above(other) == Some(first))
    }
}

fn sorted([a, b]: [usize; 2]) -> [usize; 2] {
    [a.min(b), a.max(b)]
}
