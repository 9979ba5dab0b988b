use std::collections::HashMap;

use cranny_file::nearest_names;

use crate::description::urdf_model::Urdf;
use crate::{Location, RobotError};

/// Tree of the links of a URDF, parents before children, each link's children in the order of the file.
pub(crate) struct Tree {
    pub(crate) nodes: Vec<TreeNode>,
    /// Maps the index of a link in the file to its index in `nodes`.
    node_of_link: Vec<usize>,
    /// Maps the index of a joint in the file to the index in `nodes` of its child link.
    pub(crate) node_of_joint: Vec<usize>,
    links_by_name: HashMap<String, usize>,
    joints_by_name: HashMap<String, usize>,
}

pub(crate) struct TreeNode {
    /// Index of the link in the file.
    pub(crate) link: usize,
    /// Parent node, and the index in the file of the joint between the two; `None` for the root.
    pub(crate) above: Option<(usize, usize)>,
}

/// Maximum number of links, and of joints, of a robot: five times those of a humanoid with two hands. The lists of the
/// joints above each link and of the pairs of links to check both grow with its square.
pub const MAX_LINKS: usize = 1000;

/// Maximum number of collision shapes of a robot, ten for each possible link: each is tested against the joints above it, and
/// against the shapes of other links.
const MAX_SHAPES: usize = 10_000;

/// Content limited to [`MAX_LINKS`], for errors.
pub(crate) const LINKS: &str = "links in one robot";
/// Content limited to [`MAX_LINKS`], for errors.
pub(crate) const JOINTS: &str = "joints in one robot";

impl Tree {
    /// Orders the links of `urdf`:
    ///
    /// 1. Names are unique, and joints name links that exist.
    /// 2. No link has two parents, one link has none.
    /// 3. All other links are reached from that link; a link that is not lies on a loop or below one.
    pub(crate) fn of(urdf: &Urdf) -> Result<Self, RobotError> {
        if urdf.links.is_empty() {
            return Err(RobotError::NoLinks { file: urdf.file.clone() });
        }
        let shapes = urdf.links.iter().map(|link| link.collisions.len()).sum();
        for (what, actual, most) in [
            // A joint of several degrees of freedom counts as one for each of them here, and as one in the file.
            (LINKS, urdf.links.len(), MAX_LINKS),
            (JOINTS, urdf.joints.len(), MAX_LINKS),
            ("collision shapes in one robot", shapes, MAX_SHAPES),
        ] {
            if actual > most {
                return Err(RobotError::TooMany { at: urdf.links[0].at.clone(), what, most, actual });
            }
        }
        // 1.
        let links_by_name = unique("link", urdf.links.iter().map(|link| (&link.name, &link.at)))?;
        let joints_by_name = unique("joint", urdf.joints.iter().map(|joint| (&joint.name, &joint.at)))?;
        let find = |joint: usize, name: &String| {
            links_by_name.get(name).copied().ok_or_else(|| RobotError::UnknownName {
                place: format!("{}: joint `{}`", urdf.joints[joint].at, urdf.joints[joint].name),
                kind: "link",
                name: name.clone(),
                nearest: nearest_names(name, urdf.links.iter().map(|link| link.name.as_str())),
            })
        };
        // 2.
        let mut joint_above: Vec<Option<usize>> = vec![None; urdf.links.len()];
        let mut joints_below: Vec<Vec<usize>> = vec![Vec::new(); urdf.links.len()];
        let mut ends = Vec::with_capacity(urdf.joints.len());
        for (index, joint) in urdf.joints.iter().enumerate() {
            let (parent, child) = (find(index, &joint.parent)?, find(index, &joint.child)?);
            if let Some(first) = joint_above[child].replace(index) {
                return Err(RobotError::TwoParents {
                    at: joint.at.clone(),
                    link: joint.child.clone(),
                    first: urdf.joints[first].name.clone(),
                    second: joint.name.clone(),
                });
            }
            joints_below[parent].push(index);
            ends.push((parent, child));
        }
        let roots: Vec<usize> = (0..urdf.links.len()).filter(|&link| joint_above[link].is_none()).collect();
        if let [_, second, ..] = roots[..] {
            let links = roots.iter().map(|&root| urdf.links[root].name.clone()).collect();
            return Err(RobotError::ManyRoots { at: urdf.links[second].at.clone(), links });
        }
        // 3.
        let mut nodes = Vec::with_capacity(urdf.links.len());
        let mut node_of_link = vec![usize::MAX; urdf.links.len()];
        let mut node_of_joint = vec![usize::MAX; urdf.joints.len()];
        let mut open: Vec<(usize, Option<(usize, usize)>)> = roots.iter().map(|&root| (root, None)).collect();
        while let Some((link, above)) = open.pop() {
            let node = nodes.len();
            node_of_link[link] = node;
            if let Some((_, joint)) = above {
                node_of_joint[joint] = node;
            }
            nodes.push(TreeNode { link, above });
            let below = joints_below[link].iter().rev();
            open.extend(below.map(|&joint| (ends[joint].1, Some((node, joint)))));
        }
        if let Some(lost) = node_of_link.iter().position(|&node| node == usize::MAX) {
            return Err(loop_above(urdf, lost, &joint_above, &ends));
        }
        Ok(Self { nodes, node_of_link, node_of_joint, links_by_name, joints_by_name })
    }

    pub(crate) fn node(&self, link: &str) -> Option<usize> {
        self.links_by_name.get(link).map(|&link| self.node_of_link[link])
    }

    /// Returns the index in the file of the joint named `joint`.
    pub(crate) fn joint(&self, joint: &str) -> Option<usize> {
        self.joints_by_name.get(joint).copied()
    }

    /// Returns the joints above `node`, the nearest first.
    pub(crate) fn joints_above(&self, node: usize) -> impl Iterator<Item = usize> {
        std::iter::successors(self.nodes[node].above, |&(above, _)| self.nodes[above].above)
            .map(|(_, joint)| joint)
    }
}

fn unique<'a>(
    kind: &'static str,
    named: impl Iterator<Item = (&'a String, &'a Location)>,
) -> Result<HashMap<String, usize>, RobotError> {
    let mut by_name = HashMap::new();
    let mut lines = Vec::new();
    for (index, (name, at)) in named.enumerate() {
        lines.push(at.line);
        if let Some(first) = by_name.insert(name.clone(), index) {
            let first_line = lines[first];
            return Err(RobotError::DefinedTwice { at: at.clone(), kind, name: name.clone(), first_line });
        }
    }
    Ok(by_name)
}

/// Returns the error for the loop on or above `link`, which is not reachable from any root.
fn loop_above(
    urdf: &Urdf,
    link: usize,
    joint_above: &[Option<usize>],
    ends: &[(usize, usize)],
) -> RobotError {
    // Every link from `link` upwards has a parent, so a walk over as many parents as there are links ends on the loop.
    let up = |link: usize| joint_above[link].map_or(link, |joint| ends[joint].0);
    let on_loop = (0..urdf.links.len()).fold(link, |link, _| up(link));
    let mut joints: Vec<usize> = Vec::new();
    let mut current = on_loop;
    while let Some(joint) = joint_above[current].filter(|joint| !joints.contains(joint)) {
        joints.push(joint);
        current = ends[joint].0;
    }
    joints.reverse();
    // The error lists the loop from the joint that comes first in the file.
    let first = (0..joints.len()).min_by_key(|&position| joints[position]).unwrap_or(0);
    joints.rotate_left(first);
    let at =
        joints.first().map_or_else(|| urdf.links[link].at.clone(), |&joint| urdf.joints[joint].at.clone());
    RobotError::Loop { at, joints: joints.iter().map(|&joint| urdf.joints[joint].name.clone()).collect() }
}
