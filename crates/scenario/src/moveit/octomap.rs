use cranny_collision::{Body, Part};
use cranny_sense::Octree;
use cranny_shape::{BoxUnion, Solid};
use serde_saphyr::Spanned;

use crate::ScenarioError;
use crate::moveit::file::{OctomapEntry, OctreeData, OctreeEntry};
use crate::moveit::frames::Frames;
use crate::moveit::message_file::MessageFile;

/// Name of the body, as in `MoveIt`, whose matrix of allowed collisions uses it.
const NAME: &str = "<octomap>";

/// Returns the occupied cells of an octomap as one body, in the root frame of the robot; `None` for an octomap without any.
/// Free and unknown cells are no obstacles, as in `MoveIt`.
pub(crate) fn octomap_body(
    file: &MessageFile,
    frames: &Frames,
    octomap: &Spanned<OctomapEntry>,
) -> Result<Option<Body>, ScenarioError> {
    let OctomapEntry { header, origin, octomap: octree } = &octomap.value;
    let Some(OctreeEntry { binary, id, resolution, data: Some(data), .. }) = octree else { return Ok(None) };
    let fault = |problem: String| ScenarioError::Octomap { at: file.at(octomap.referenced), problem };
    let bytes = match data {
        OctreeData::List(numbers) => numbers.iter().map(|number| byte(*number)).collect::<Option<Vec<u8>>>(),
        OctreeData::Text(text) => text.is_empty().then(Vec::new),
    };
    let bytes = bytes.ok_or_else(|| fault("its data is a list of bytes, -128 to 255".to_owned()))?;
    if bytes.is_empty() {
        return Ok(None);
    }
    if *binary != Some(true) {
        let hint = "publish it as a binary one, as octomap_server does under octomap_binary, or give its obstacles as objects";
        return Err(file.unsupported(octomap.referenced, "an octomap with probabilities", hint));
    }
    let id = id.as_deref().unwrap_or_default();
    if id != "OcTree" {
        return Err(fault(format!("its id is '{}', but only OcTree is read", cranny_file::excerpt(id))));
    }
    let resolution_m = resolution.as_ref().map_or(0.0, |resolution| resolution.value);
    let tree = Octree::of_data(resolution_m, &bytes).map_err(fault)?;
    if tree.occupied.is_empty() {
        return Ok(None);
    }
    let union =
        BoxUnion::of_boxes(tree.occupied.into_iter()).map_err(|problem| fault(problem.to_string()))?;
    let root_from_header = match header {
        Some(header) => frames.find(file, header)?,
        None => *frames.planning(),
    };
    let world_from_solid = root_from_header * file.optional_pose(origin.as_ref())?;
    let parts = vec![Part { world_from_solid, solid: Solid::union(union) }];
    Ok(Some(Body { name: NAME.to_owned(), parts, tilt_rad: None, center_of_mass: None }))
}

/// Returns a byte of a message, signed or unsigned.
fn byte(number: i64) -> Option<u8> {
    u8::try_from(number).ok().or_else(|| i8::try_from(number).ok().map(i8::cast_unsigned))
}
