use crate::RobotError;
use crate::description::xml::Element;
use crate::mjcf::documents::Documents;
use crate::model_file::body_tree::{BodyTree, JointRule};
use crate::model_file::unread_list::not_supported;

impl BodyTree {
    /// Applies the constraint c₁ (q₁ − r₁) + c₂ (q₂ − r₂) = a₀ on the length of a fixed tendon over two joints, where r are their
    /// reference values: the joint that is named last follows the other (XML reference, equality: tendon).
    ///
    /// # Errors
    /// [`RobotError::NotSupported`] for a tendon of another kind, over another number of joints, or coupled to another tendon.
    pub(crate) fn add_tendon_equality(
        &mut self,
        documents: &Documents<'_>,
        element: Element<'_>,
    ) -> Result<(), RobotError> {
        let name = element.text("tendon1")?;
        let hint = "only a fixed tendon over two joints is read: a mimic joint";
        let refuse = |what: &str| not_supported(element, format!("{what} `{name}`"), hint);
        if element.optional_text("tendon2").is_some() {
            return Err(refuse("a constraint between two tendons, of"));
        }
        let tendons = documents.sections("tendon").flat_map(|section| documents.children(section));
        let mut named = tendons.filter(|tendon| tendon.optional_text("name") == Some(name));
        let tendon = named.next().ok_or_else(|| refuse("a constraint of the unknown tendon"))?;
        let joints = documents.children(tendon);
        let [first, second] = joints[..] else { return Err(refuse("a constraint of tendon")) };
        if tendon.tag() != "fixed" {
            return Err(refuse("a constraint of the spatial tendon"));
        }
        let polynomial = element.list("polycoef", 5)?.unwrap_or_default();
        self.couple([first, second], polynomial.first().copied().unwrap_or(0.0))
    }

    fn couple(&mut self, joints: [Element<'_>; 2], constant: f64) -> Result<(), RobotError> {
        let mut ends = Vec::new();
        for element in joints {
            let place = self.joint_index(element, element.text("joint")?)?;
            let factor = element.number("coef")?;
            if factor == 0.0 {
                return Err(not_supported(element, "a `coef` of 0", "leave the joint out"));
            }
            ends.push((place, factor));
        }
        let joint = |(body, index): (usize, usize)| &self.bodies[body].joints[index];
        // A joint that follows another already leads here.
        if joint(ends[1].0).rule != JointRule::Free {
            ends.swap(0, 1);
        }
        let [(leading, c1), (following, c2)] = ends[..] else { return Ok(()) };
        let multiplier = -c1 / c2;
        let offset = constant / c2 + joint(following).reference - multiplier * joint(leading).reference;
        let rule = JointRule::Mimic { master: joint(leading).name.clone(), multiplier, offset };
        self.bodies[following.0].joints[following.1].rule = rule;
        Ok(())
    }
}
