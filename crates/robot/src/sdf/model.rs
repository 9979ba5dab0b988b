use std::collections::HashMap;
use std::path::{Path, PathBuf};

use cranny_spatial::Pose;

use crate::RobotError;
use crate::description::xml::XmlText;
use crate::model_file::body_tree::{BodyTree, Plane, TreeBody, TreeJoint, TreeShape};
use crate::model_file::unread_list::UnreadList;
use crate::sdf::collector::{Collector, SdfLink};
use crate::sdf::frames::{Frames, WORLD};
use crate::sdf::includes::ModelFolders;
use crate::sdf::joints::SdfJoint;

/// Reads the SDF `text`, the content of `path`: its world, or else its first model. Models named by `model://` are searched in
/// `folders`, in those of the environment, and in the folder of the file and those above it.
///
/// 1. Frames, links and joints of all models; included files are read as they occur.
/// 2. The tree of the links: each below the parent of its joint, others below the world.
/// 3. Poses with all joints at 0, relative to the parents; joint axes and shapes in the frames of their links.
pub(crate) fn read(text: &str, path: &Path, folders: &[PathBuf]) -> Result<BodyTree, RobotError> {
    // 1.
    let file = path.display().to_string();
    let xml = XmlText::parse(text, &file)?;
    let root = xml.root();
    let mut collector = Collector {
        frames: Frames::default(),
        links: Vec::new(),
        joints: Vec::new(),
        unread: UnreadList::default(),
        folders: ModelFolders::new(folders),
        points: 0,
    };
    let name = collector.read_root(root, path.parent().unwrap_or_else(|| Path::new("")))?;
    let Collector { frames, links, joints, unread, .. } = collector;
    // 2.
    let joint_above = joints_above(&frames, &joints)?;
    let order = ordered(&links, &joints, &joint_above)?;
    // 3.
    let is_taken = links.iter().any(|link| link.name == "world");
    let world = if is_taken { "world_frame" } else { "world" };
    let mut bodies = vec![TreeBody::bare(world.to_owned(), None, Pose::identity())];
    let mut index_of = HashMap::from([(WORLD, 0)]);
    let mut world_from = vec![Pose::identity()];
    let mut planes = Vec::new();
    for link in order.iter().map(|&link| &links[link]) {
        let joint = joint_above.get(link.name.as_str()).map(|(joint, parent)| (&joints[*joint], *parent));
        let parent = joint.and_then(|(_, parent)| index_of.get(parent).copied()).unwrap_or(0);
        let world_from_link = frames.world_from(&link.name, &link.at)?;
        let link_from = |frame: &str| -> Result<Pose, RobotError> {
            Ok(world_from_link.inverse() * frames.world_from(frame, &link.at)?)
        };
        let parent_from_body = world_from[parent].inverse() * world_from_link;
        let mut body = TreeBody::bare(link.name.clone(), Some(parent), parent_from_body);
        body.inertial = link.inertial;
        body.is_free = link.is_free && joint.is_none();
        if let Some((joint, _)) = joint {
            body.joints.extend(tree_joint(joint, &link_from)?);
        }
        for placed in &link.shapes {
            let TreeShape { body_from_shape, form, contacts, look } = &placed.shape;
            let body_from_shape = link_from(&placed.frame)? * body_from_shape;
            body.shapes.push(TreeShape {
                body_from_shape,
                form: form.clone(),
                contacts: *contacts,
                look: *look,
            });
        }
        for (name, frame, pose) in &link.planes {
            let world_from_plane = frames.world_from(frame, &link.at)? * pose;
            planes.push(Plane { name: name.clone(), world_from_plane });
        }
        // A link that is only a plane is no body.
        if link.shapes.is_empty() && !link.planes.is_empty() {
            body.is_free = false;
        }
        index_of.insert(&link.name, bodies.len());
        world_from.push(world_from_link);
        bodies.push(body);
    }
    Ok(BodyTree {
        name,
        bodies,
        excluded: Vec::new(),
        included: Vec::new(),
        filters_parents: false,
        planes,
        states: Vec::new(),
        notes: unread.lines(&file),
    })
}

/// Returns the joint above each link that has one, and the link above the joint.
fn joints_above<'f>(
    frames: &'f Frames,
    joints: &'f [SdfJoint],
) -> Result<HashMap<&'f str, (usize, &'f str)>, RobotError> {
    let mut above: HashMap<&str, (usize, &str)> = HashMap::new();
    for (index, joint) in joints.iter().enumerate() {
        let child = frames.link_of(&joint.child, &joint.at)?;
        let parent = frames.link_of(&joint.parent, &joint.at)?;
        if let Some((first, _)) = above.insert(child, (index, parent)) {
            return Err(RobotError::TwoParents {
                at: joint.at.clone(),
                link: child.to_owned(),
                first: joints[first].name.clone(),
                second: joint.name.clone(),
            });
        }
    }
    Ok(above)
}

/// Returns the links, each behind the one above it.
fn ordered(
    links: &[SdfLink],
    joints: &[SdfJoint],
    above: &HashMap<&str, (usize, &str)>,
) -> Result<Vec<usize>, RobotError> {
    let mut below: HashMap<&str, Vec<usize>> = HashMap::new();
    for (index, link) in links.iter().enumerate() {
        let parent = above.get(link.name.as_str()).map_or(WORLD, |(_, parent)| *parent);
        below.entry(parent).or_default().push(index);
    }
    let mut order = Vec::with_capacity(links.len());
    let mut open: Vec<usize> = below.get(WORLD).into_iter().flatten().rev().copied().collect();
    while let Some(link) = open.pop() {
        order.push(link);
        open.extend(below.get(links[link].name.as_str()).into_iter().flatten().rev());
    }
    match (0..links.len()).find(|link| !order.contains(link)) {
        None => Ok(order),
        Some(lost) => {
            let joint = above.get(links[lost].name.as_str()).map(|(joint, _)| joints[*joint].name.clone());
            Err(RobotError::Loop { at: links[lost].at.clone(), joints: joint.into_iter().collect() })
        }
    }
}

fn tree_joint(
    joint: &SdfJoint,
    link_from: &impl Fn(&str) -> Result<Pose, RobotError>,
) -> Result<Option<TreeJoint>, RobotError> {
    let Some(motion) = &joint.motion else { return Ok(None) };
    Ok(Some(TreeJoint {
        name: joint.name.clone(),
        kind: motion.kind,
        anchor: link_from(&joint.frame)?.translation.vector,
        axis: link_from(&motion.expressed_in)?.rotation * motion.axis,
        range: motion.range,
        reference: 0.0,
        rule: motion.rule.clone(),
        velocity: motion.velocity,
        effort: motion.effort,
    }))
}
