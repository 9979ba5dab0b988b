use std::collections::{HashMap, HashSet};

use crate::mjcf::assets::Assets;
use crate::mjcf::compiler::Compiler;
use crate::mjcf::defaults::Classes;
use crate::mjcf::documents::Documents;
use crate::model_file::body_tree::{Plane, TreeBody};
use crate::model_file::unread_list::UnreadList;

/// Reader of the bodies of a model.
pub(crate) struct BodyReader<'d, 'r> {
    pub(crate) documents: &'d Documents<'d>,
    pub(crate) classes: &'r Classes<'d>,
    pub(crate) compiler: &'r Compiler,
    pub(crate) assets: &'r Assets,
    /// Contact group of each geom that a `<pair>` names.
    pub(crate) pair_groups: HashMap<String, usize>,
    pub(crate) unread: &'r mut UnreadList,
    pub(crate) bodies: Vec<TreeBody>,
    pub(crate) planes: Vec<Plane>,
    /// Number of points of all hulls so far.
    pub(crate) points: usize,
    /// Joints in the order of `qpos`, each with its number of values there; `None` for that of a free body.
    pub(crate) order: Vec<(Option<String>, usize)>,
    /// Names that the file gives to bodies and joints.
    pub(crate) names: HashSet<String>,
}
