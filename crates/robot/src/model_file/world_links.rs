use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use cranny_shape::Solid;
use cranny_spatial::Pose;

use crate::chain::joint_group::{JointValue, Resolved, admits, range, unknown_joint};
use crate::description::assembly::{SolidSource, motions};
use crate::description::urdf_model::Urdf;
use crate::tree::Tree;
use crate::{Inertial, JointConstraint, ModelText, RobotError, RobotOptions};

/// Link of a world at rest.
#[derive(Clone, Debug)]
pub struct WorldLink {
    /// Name of the link.
    pub name: String,
    /// Names of the links above it, the nearest first.
    pub ancestors: Vec<String>,
    /// Its solids, each with its pose in the world.
    pub solids: Vec<(Pose, Solid)>,
    /// Mass and inertia, if the file states them.
    pub inertial: Option<Inertial>,
    /// Colour of each solid, if the file has one: red, green and blue, 0 to 1, sRGB.
    pub colours: Vec<Option<[f64; 3]>>,
}

impl ModelText {
    /// Returns the links with geometry or mass of the world at `path`, in the order of its tree, in the frame of its root.
    ///
    /// `values` (m, rad) are those of its joints, by name; a joint without one has the value of the file, or that nearest to it
    /// within its limits. `folders` are searched for `package://` and `model://` names.
    ///
    /// # Errors
    /// [`RobotError::UnknownName`] for a joint that the world lacks, [`RobotError::NotFree`] for one that is fixed or mimics
    /// another, [`RobotError::HeldOutsideLimits`]; any fault of the model.
    pub fn world_links(
        &self,
        path: &Path,
        folders: &[PathBuf],
        values: &BTreeMap<String, f64>,
    ) -> Result<Vec<WorldLink>, RobotError> {
        let file = self.name_of(path);
        let urdf = Urdf::parse(&self.urdf, &file)?;
        let tree = Tree::of(&urdf)?;
        for (name, &value) in values {
            let joint = tree.joint(name).ok_or_else(|| unknown_joint(&urdf, file.clone(), name))?;
            let joint = &urdf.joints[joint];
            let not_free = |constraint| {
                let (at, joint) = (joint.at.clone(), joint.name.clone());
                RobotError::NotFree { at, joint, wanted: "held at a value", constraint }
            };
            let motion = joint.motion.as_ref().ok_or_else(|| not_free(JointConstraint::Fixed))?;
            if let Some(mimic) = &motion.mimic {
                return Err(not_free(JointConstraint::Mimic { master: mimic.master.clone() }));
            }
            if !admits(motion, value) {
                let ((lower, upper), at) = (range(motion), joint.at.clone());
                return Err(RobotError::HeldOutsideLimits { at, joint: name.clone(), value, lower, upper });
            }
        }
        let offset = |index: usize| self.value_of(&urdf, &tree, values, index);
        let value = |index| JointValue { follows: None, offset: offset(index), stands: true };
        let values = (0..urdf.joints.len()).map(value).collect();
        let still = Resolved { group: Vec::new(), tip: 0, values, notes: Vec::new() };
        let (_, _, root_from_link) = motions(&urdf, &tree, &still);
        let options = RobotOptions { packages: folders.to_vec(), ..RobotOptions::default() };
        let source = SolidSource::new(path.parent(), &options);
        let mut links = Vec::new();
        for (node, root_from_link) in tree.nodes.iter().zip(&root_from_link) {
            let link = &urdf.links[node.link];
            let (mut solids, mut colours) = (Vec::new(), Vec::new());
            for collision in &link.collisions {
                let shape = source.shape(link, collision)?;
                solids.push((root_from_link * shape.link_from_shape, shape.solid));
                colours.push(source.colour(link, collision));
            }
            if !solids.is_empty() || link.inertial.is_some() {
                let name = link.name.clone();
                let above = std::iter::successors(node.above, |(above, _)| tree.nodes[*above].above);
                let above = above.map(|(above, _)| urdf.links[tree.nodes[above].link].name.clone());
                let inertial = link.inertial;
                links.push(WorldLink { name, ancestors: above.collect(), solids, inertial, colours });
            }
        }
        Ok(links)
    }

    /// Returns the value of a joint (m, rad); of one that mimics, that of its master at the end of the chain, converted.
    fn value_of(&self, urdf: &Urdf, tree: &Tree, values: &BTreeMap<String, f64>, joint: usize) -> f64 {
        let (mut factor, mut shift, mut joint) = (1.0, 0.0, joint);
        // A loop of mimic joints ends here too.
        for _ in 0..urdf.joints.len() {
            let described = &urdf.joints[joint];
            let Some(motion) = &described.motion else { break };
            let mimic = motion.mimic.as_ref().and_then(|mimic| Some((mimic, tree.joint(&mimic.master)?)));
            let Some((mimic, master)) = mimic else {
                let (lower, upper) = range(motion);
                let own = || self.references.get(&described.name).copied().unwrap_or(0.0);
                let value = values.get(&described.name).copied().unwrap_or_else(own);
                return factor * value.clamp(lower, upper) + shift;
            };
            shift += factor * mimic.offset;
            factor *= mimic.multiplier;
            joint = master;
        }
        shift
    }
}
