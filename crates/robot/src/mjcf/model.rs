use std::collections::HashSet;
use std::path::Path;

use cranny_spatial::Pose;

use crate::RobotError;
use crate::mjcf::assets::Assets;
use crate::mjcf::body_reader::BodyReader;
use crate::mjcf::compiler::Compiler;
use crate::mjcf::constraints::{filters_parents, read_pairs};
use crate::mjcf::defaults::Classes;
use crate::mjcf::documents::Sources;
use crate::model_file::body_tree::{BodyTree, TreeBody};
use crate::model_file::unread_list::UnreadList;

/// Name of the root link.
const WORLD: &str = "world";

/// Reads the MJCF model `text`, the content of `path`, with all files that it includes.
///
/// 1. The files; settings of the compiler; classes of defaults; meshes and materials.
/// 2. Bodies, joints and geoms.
/// 3. Exclusions of contacts, constraints of joints, keyframes.
pub(crate) fn read(text: String, path: &Path) -> Result<BodyTree, RobotError> {
    // 1.
    let file = path.display().to_string();
    let sources = Sources::read(text, path)?;
    let documents = sources.documents()?;
    let Some(root) = documents.root() else { return Err(RobotError::Empty { file }) };
    let mut unread = UnreadList::default();
    let compiler = Compiler::read(&documents, &mut unread)?;
    let classes = Classes::read(&documents, &mut unread)?;
    let assets = Assets::read(&documents, &classes, &compiler, &mut unread)?;
    let (pair_groups, included) = read_pairs(&documents)?;
    let filters_parents = filters_parents(&documents, &mut unread)?;
    // 2.
    let mut reader = BodyReader {
        documents: &documents,
        classes: &classes,
        compiler: &compiler,
        assets: &assets,
        pair_groups,
        unread: &mut unread,
        bodies: vec![TreeBody::bare(WORLD.to_owned(), None, Pose::identity())],
        planes: Vec::new(),
        points: 0,
        order: Vec::new(),
        names: HashSet::from([format!("body {WORLD}")]),
    };
    reader.note_other_sections(root)?;
    for world in documents.sections("worldbody") {
        reader.read_world(world)?;
    }
    let BodyReader { bodies, planes, order, .. } = reader;
    // 3.
    let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let name = root.optional_text("model").map_or(stem, str::to_owned);
    let mut tree = BodyTree {
        name,
        bodies,
        excluded: Vec::new(),
        included,
        filters_parents,
        planes,
        states: Vec::new(),
        notes: Vec::new(),
    };
    tree.read_exclusions(&documents)?;
    tree.read_equalities(&documents, &mut unread)?;
    tree.read_states(&documents, &order, &mut unread)?;
    tree.notes = unread.lines(&file);
    Ok(tree)
}
