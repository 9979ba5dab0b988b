use std::collections::HashMap;
use std::path::Path;

use cranny_spatial::{Point, Pose, Rotation, Vector};

use crate::description::xml::Element;
use crate::mjcf::compiler::Compiler;
use crate::mjcf::defaults::Classes;
use crate::mjcf::documents::Documents;
use crate::model_file::orientation::rotation_from_wxyz;
use crate::model_file::unread_list::{UnreadList, not_supported};
use crate::{LinkForm, RobotError};

/// Attributes of `<mesh>` that are read.
const READ: [&str; 8] = ["name", "class", "file", "vertex", "scale", "refpos", "refquat", "face"];

/// Attributes of `<mesh>` that affect inertia and looks alone, or the number of corners of the hull.
const IGNORED: [&str; 9] = [
    "content_type",
    "normal",
    "texcoord",
    "smoothnormal",
    "inertia",
    "maxhullvert",
    "material",
    "octree_maxdepth",
    "needsdf",
];

/// Maximum count of numbers in the inline vertices of a mesh.
const MOST_NUMBERS: usize = 3_000_000;

/// Meshes and colours of materials, by name.
pub(crate) struct Assets {
    pub(crate) meshes: HashMap<String, MeshAsset>,
    pub(crate) colours: HashMap<String, [f64; 4]>,
}

/// A mesh: its shape, and the pose of that shape in the frame of a geom.
pub(crate) struct MeshAsset {
    pub(crate) geom_from_mesh: Pose,
    pub(crate) form: LinkForm,
}

impl Assets {
    pub(crate) fn read<'d>(
        documents: &'d Documents<'_>,
        classes: &Classes<'d>,
        compiler: &Compiler,
        unread: &mut UnreadList,
    ) -> Result<Self, RobotError> {
        let mut assets = Self { meshes: HashMap::new(), colours: HashMap::new() };
        for section in documents.sections("asset") {
            for asset in documents.children(section) {
                match &*asset.tag() {
                    "mesh" => {
                        let (name, mesh) = mesh(asset, classes, compiler, unread)?;
                        assets.meshes.insert(name, mesh);
                    }
                    "material" => {
                        let attributes = classes.of(asset, None)?;
                        let colour = attributes.numbers("rgba")?;
                        assets.colours.extend(asset.optional_text("name").map(str::to_owned).zip(colour));
                    }
                    "model" => {
                        let hint = "export the whole model, for example by mj_saveLastXML";
                        return Err(not_supported(asset, "<model>", hint));
                    }
                    _ => unread.add(section, asset),
                }
            }
        }
        Ok(assets)
    }
}

fn mesh<'d>(
    element: Element<'d>,
    classes: &Classes<'d>,
    compiler: &Compiler,
    unread: &mut UnreadList,
) -> Result<(String, MeshAsset), RobotError> {
    unread.check_attributes(element, &READ, &IGNORED)?;
    let attributes = classes.of(element, None)?;
    let file = element.optional_text("file").map(|file| file.replace('\\', "/"));
    let stem = || Some(Path::new(file.as_deref()?).file_stem()?.to_string_lossy().into_owned());
    let name = match element.optional_text("name") {
        Some(name) => name.to_owned(),
        None => stem().map_or_else(|| element.text("name").map(str::to_owned), Ok)?,
    };
    let scale = attributes.vector("scale")?.unwrap_or_else(|| Vector::repeat(1.0));
    let moved = attributes.vector("refpos")?.unwrap_or_default();
    let turned = match attributes.numbers("refquat")? {
        None => Rotation::identity(),
        Some(quaternion) => rotation_from_wxyz(quaternion)
            .ok_or_else(|| not_supported(element, "a `refquat` of length 0", "give a rotation"))?
            .inverse(),
    };
    // A vertex v of the file is at scale · turned · (v − moved).
    let Some(file) = file else {
        let Some(vertices) = element.list("vertex", MOST_NUMBERS)? else {
            return Err(not_supported(element, "a <mesh> without `file` and `vertex`", "give one of them"));
        };
        let placed = |v: &[f64]| (turned * (Vector::new(v[0], v[1], v[2]) - moved)).component_mul(&scale);
        let points = vertices.chunks_exact(3).map(|vertex| Point::from(placed(vertex))).collect();
        return Ok((name, MeshAsset { geom_from_mesh: Pose::identity(), form: LinkForm::Hull { points } }));
    };
    let is_uniform = (scale - Vector::repeat(scale.x)).amax() <= f64::EPSILON * scale.amax();
    if turned != Rotation::identity() && !is_uniform {
        let hint = "scale the mesh file";
        return Err(not_supported(element, "a `refquat` with a `scale` that differs between axes", hint));
    }
    let shift = -(turned * moved).component_mul(&scale);
    let form = LinkForm::Mesh { name: path(&file, compiler), candidates: Vec::new(), scale };
    Ok((name, MeshAsset { geom_from_mesh: Pose::from_parts(shift.into(), turned), form }))
}

/// Returns the path of a mesh file relative to the folder of the model.
fn path(file: &str, compiler: &Compiler) -> String {
    let name = Path::new(file);
    let name = match name.file_name().filter(|_| compiler.strips_paths) {
        Some(stripped) => Path::new(stripped),
        None => name,
    };
    Path::new(&compiler.mesh_folder.replace('\\', "/")).join(name).to_string_lossy().into_owned()
}
