use std::collections::{HashMap, HashSet};

use cranny_file::counted;

use crate::description::xml::Element;
use crate::mjcf::body_reader::BodyReader;
use crate::mjcf::compiler::flag;
use crate::mjcf::documents::Documents;
use crate::model_file::body_tree::{BodyTree, JointRule, KeyState, TreeJoint};
use crate::model_file::unread_list::{UnreadList, not_supported};
use crate::{Location, RobotError};

/// Maximum number of keyframes that are read.
const MOST_STATES: usize = 100;

/// Geoms of a `<pair>`, each with its contact group.
pub(crate) type Pairs = (HashMap<String, usize>, Vec<[usize; 2]>);

/// Reads the pairs of geoms that collide regardless of their masks.
pub(crate) fn read_pairs(documents: &Documents<'_>) -> Result<Pairs, RobotError> {
    let mut groups: HashMap<String, usize> = HashMap::new();
    let mut pairs = Vec::new();
    for section in documents.sections("contact") {
        for pair in documents.children(section).into_iter().filter(|element| element.tag() == "pair") {
            let mut group = |name: &'static str| -> Result<usize, RobotError> {
                let next = groups.len();
                Ok(*groups.entry(pair.text(name)?.to_owned()).or_insert(next))
            };
            pairs.push([group("geom1")?, group("geom2")?]);
        }
    }
    Ok((groups, pairs))
}

/// Returns true if a moving body and its parent have no contacts, the default (XML reference, flag: filterparent).
pub(crate) fn filters_parents(
    documents: &Documents<'_>,
    unread: &mut UnreadList,
) -> Result<bool, RobotError> {
    /// Settings of the integrator, of the solver and of the medium.
    const IGNORED: [&str; 31] = [
        "timestep",
        "apirate",
        "impratio",
        "gravity",
        "wind",
        "magnetic",
        "density",
        "viscosity",
        "o_margin",
        "o_solref",
        "o_solimp",
        "o_friction",
        "integrator",
        "cone",
        "jacobian",
        "solver",
        "iterations",
        "tolerance",
        "ls_iterations",
        "ls_tolerance",
        "noslip_iterations",
        "noslip_tolerance",
        "ccd_iterations",
        "ccd_tolerance",
        "sdf_iterations",
        "sdf_initpoints",
        "sleep_tolerance",
        "actuatorgroupdisable",
        "mpr_iterations",
        "mpr_tolerance",
        "collision",
    ];
    let mut filters = true;
    for section in documents.sections("option") {
        unread.check_attributes(section, &[], &IGNORED)?;
        for element in documents.children(section) {
            if element.tag() != "flag" {
                unread.add(section, element);
                continue;
            }
            filters = flag(element, "filterparent", filters)?;
            if !flag(element, "contact", true)? {
                unread.note(format!("{}: contacts are switched off, but checked here", element.at()));
            }
            if !flag(element, "equality", true)? {
                let at = element.at();
                unread.note(format!(
                    "{at}: equality constraints are switched off, but joints stay coupled here"
                ));
            }
        }
    }
    Ok(filters)
}

impl BodyTree {
    fn body_index(&self, element: Element<'_>, attribute: &'static str) -> Result<usize, RobotError> {
        let name = element.text(attribute)?;
        let found = self.bodies.iter().position(|body| body.name == name);
        found.ok_or_else(|| {
            unknown(&element.at(), "body", name, self.bodies.iter().map(|body| body.name.as_str()))
        })
    }

    /// Returns the place of a joint: its body, and its index there.
    pub(crate) fn joint_index(&self, element: Element<'_>, name: &str) -> Result<(usize, usize), RobotError> {
        let bodies = self.bodies.iter().enumerate();
        let mut places =
            bodies.flat_map(|(body, of)| of.joints.iter().enumerate().map(move |joint| (body, joint)));
        let found = places.find(|(_, (_, joint))| joint.name == name);
        let known = || self.joints().map(|joint| joint.name.as_str());
        found
            .map(|(body, (index, _))| (body, index))
            .ok_or_else(|| unknown(&element.at(), "joint", name, known()))
    }

    fn joints(&self) -> impl Iterator<Item = &TreeJoint> {
        self.bodies.iter().flat_map(|body| &body.joints)
    }

    /// Reads the pairs of bodies without contacts.
    pub(crate) fn read_exclusions(&mut self, documents: &Documents<'_>) -> Result<(), RobotError> {
        for section in documents.sections("contact") {
            for element in documents.children(section).into_iter().filter(|child| child.tag() == "exclude") {
                let pair = [self.body_index(element, "body1")?, self.body_index(element, "body2")?];
                self.excluded.push(pair);
            }
        }
        Ok(())
    }

    /// Reads the constraints between joints. A linear one makes a joint mimic another; those between bodies are noted.
    pub(crate) fn read_equalities(
        &mut self,
        documents: &Documents<'_>,
        unread: &mut UnreadList,
    ) -> Result<(), RobotError> {
        for section in documents.sections("equality") {
            for element in documents.children(section) {
                let is_active = flag(element, "active", true)?;
                match &*element.tag() {
                    _ if !is_active => {
                        unread.note(format!("{}: an inactive <{}> is not read", element.at(), element.tag()));
                    }
                    "joint" => self.add_equality(element)?,
                    "tendon" => self.add_tendon_equality(documents, element)?,
                    "connect" | "weld" => unread.note(format!(
                        "{}: <{}> is not read: the joints between its bodies move independently",
                        element.at(),
                        element.tag()
                    )),
                    tag => {
                        let what = format!("an equality constraint of kind <{tag}>");
                        return Err(not_supported(element, what, "give <joint>, or remove it"));
                    }
                }
            }
        }
        Ok(())
    }

    /// Applies y − y₀ = a₀ + a₁ (x − x₀), where x₀ and y₀ are the reference values (XML reference, equality: joint).
    fn add_equality(&mut self, element: Element<'_>) -> Result<(), RobotError> {
        let mut polynomial = [0.0, 1.0, 0.0, 0.0, 0.0];
        let given = element.list("polycoef", 5)?.unwrap_or_default();
        polynomial[..given.len()].copy_from_slice(&given);
        let (name, master) = (element.text("joint1")?, element.optional_text("joint2"));
        let x0 = match master {
            Some(master) => {
                let (body, index) = self.joint_index(element, master)?;
                Some(self.bodies[body].joints[index].reference)
            }
            None => None,
        };
        if polynomial[2..].iter().any(|factor| *factor != 0.0) && master.is_some() {
            let hint = "only a linear one is read: a mimic joint";
            return Err(not_supported(element, format!("a curved constraint of joint `{name}`"), hint));
        }
        let [constant, factor, ..] = polynomial;
        let (body, index) = self.joint_index(element, name)?;
        let joint = &mut self.bodies[body].joints[index];
        let y0 = joint.reference;
        joint.rule = match (master, x0) {
            (Some(master), Some(x0)) if factor != 0.0 => JointRule::Mimic {
                master: master.to_owned(),
                multiplier: factor,
                offset: constant + y0 - factor * x0,
            },
            _ => JointRule::Constant(constant + y0),
        };
        Ok(())
    }

    /// Reads the joint values of keyframes.
    pub(crate) fn read_states(
        &mut self,
        documents: &Documents<'_>,
        order: &[(Option<String>, usize)],
        unread: &mut UnreadList,
    ) -> Result<(), RobotError> {
        let count: usize = order.iter().map(|(_, count)| count).sum();
        let is_free = |joint: &&TreeJoint| joint.rule == JointRule::Free;
        let free: HashSet<String> = self.joints().filter(is_free).map(|joint| joint.name.clone()).collect();
        let keys = documents.sections("keyframe").flat_map(|section| documents.children(section));
        for (index, key) in keys.enumerate() {
            if self.states.len() == MOST_STATES {
                unread.note(format!(
                    "{}: keyframes from the {}th on are not read",
                    key.at(),
                    MOST_STATES + 1
                ));
                break;
            }
            let Some(values) = key.list("qpos", count.max(1))? else { continue };
            if values.len() != count {
                let found = counted(values.len(), "value");
                unread
                    .note(format!("{}: a keyframe of {found} is not read: the model has {count}", key.at()));
                continue;
            }
            let mut places = 0;
            let mut state = KeyState {
                name: key.optional_text("name").map_or_else(|| format!("key_{index}"), str::to_owned),
                values: Vec::new(),
            };
            for (joint, count) in order {
                let joint = joint.as_ref().filter(|joint| free.contains(*joint));
                state.values.extend(joint.map(|joint| (joint.clone(), values[places])));
                places += count;
            }
            if !state.values.is_empty() {
                self.states.push(state);
            }
        }
        Ok(())
    }
}

fn unknown<'n>(
    at: &Location,
    kind: &'static str,
    name: &str,
    known: impl Iterator<Item = &'n str>,
) -> RobotError {
    let nearest = cranny_file::nearest_names(name, known);
    RobotError::UnknownName { place: at.to_string(), kind, name: name.to_owned(), nearest }
}

impl BodyReader<'_, '_> {
    /// Adds the sections of the model that no motion depends on.
    pub(crate) fn note_other_sections(&mut self, root: Element<'_>) -> Result<(), RobotError> {
        const READ: [&str; 9] = [
            "compiler",
            "option",
            "default",
            "asset",
            "worldbody",
            "contact",
            "equality",
            "keyframe",
            "include",
        ];
        for section in self.documents.root().map(|root| self.documents.children(root)).unwrap_or_default() {
            match &*section.tag() {
                tag if READ.contains(&tag) => {}
                "size" | "visual" | "statistic" | "custom" | "tendon" | "actuator" | "sensor"
                | "extension" => {
                    self.unread.add(root, section);
                }
                tag => {
                    let what = format!("<{tag}>");
                    let hint = match tag {
                        "deformable" => "leave it out: soft bodies are not modelled",
                        _ => "leave it out, or correct its name",
                    };
                    return Err(not_supported(section, what, hint));
                }
            }
        }
        Ok(())
    }
}
