use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::{Path, PathBuf};

use cranny_robot::{Link, LinkForm, LinkVisual, Robot};
use cranny_shape::{PaintedMesh, Solid};
use cranny_spatial::nalgebra::Vector3;
use cranny_spatial::{Pose, Vector};

use crate::look::melted_body::{Primitive, melted};
use crate::{Colour, Material, MeshPiece, Scene, ViewError, look::rounded};

/// Colour of a link without a colour of its own.
const BARE: u32 = 0x00b8_bec6;

/// Maximum number of triangles of all visual meshes of a robot, each of which is kept as often as a link shows it: as many as one
/// mesh file may have.
const MOST_TRIANGLES: usize = 8_000_000;

/// Visual meshes that were read.
struct MeshFiles {
    /// By canonical path and scale: a file may have as many spellings as there are visuals.
    known: HashMap<(PathBuf, [u64; 3]), PaintedMesh>,
    /// Number of triangles that further visuals may have.
    left: usize,
}

impl MeshFiles {
    /// Returns a mesh for one more visual.
    fn read(&mut self, path: &Path, scale: &Vector) -> Result<&PaintedMesh, ViewError> {
        let file = std::fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        let mesh = match self.known.entry((file, scale.map(f64::to_bits).into())) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(new) => new.insert(PaintedMesh::load(path, *scale)?),
        };
        let triangles = mesh.pieces.iter().map(|piece| piece.triangles.len()).sum();
        self.left =
            self.left.checked_sub(triangles).ok_or(ViewError::ManyTriangles { most: MOST_TRIANGLES })?;
        Ok(mesh)
    }
}

/// Creates the meshes of the links of a robot, by link, of collision geometry if there are no visuals; `None` without any.
///
/// # Errors
/// [`ViewError::VisualNotFound`], [`ViewError::Shape`], [`ViewError::ManyTriangles`].
pub(crate) fn link_meshes(robot: &Robot, scene: &mut Scene) -> Result<Vec<Option<usize>>, ViewError> {
    let mut files = MeshFiles { known: HashMap::new(), left: MOST_TRIANGLES };
    robot.links().iter().map(|link| link_mesh(link, scene, &mut files)).collect()
}

fn link_mesh(link: &Link, scene: &mut Scene, files: &mut MeshFiles) -> Result<Option<usize>, ViewError> {
    let mut pieces = Vec::new();
    if link.visuals.is_empty() {
        let material = scene.material(plastic([0.0; 4], true));
        for shape in &link.collisions {
            pieces.push(placed(of_solid(&shape.solid, material), &shape.link_from_shape));
        }
    }
    let (melting, single): (Vec<_>, Vec<_>) = link
        .visuals
        .iter()
        .partition(|visual| visual.blend_m > 0.0 && !matches!(visual.form, LinkForm::Mesh { .. }));
    // There is one solid for each colour, in order of appearance.
    let mut solids: Vec<(Option<[f64; 4]>, Vec<Primitive>)> = Vec::new();
    let mut known: HashMap<Option<[u64; 4]>, usize> = HashMap::new();
    for visual in melting {
        let solid = *known.entry(visual.colour.map(|colour| colour.map(f64::to_bits))).or_insert_with(|| {
            solids.push((visual.colour, Vec::new()));
            solids.len() - 1
        });
        solids[solid].1.extend(Primitive::of(visual));
    }
    for (colour, primitives) in solids {
        let material = scene.material(plastic(colour.unwrap_or_default(), colour.is_none()));
        pieces.push(melted(&primitives, material));
    }
    for visual in single {
        pieces.extend(visual_pieces(link, visual, scene, files)?);
    }
    let merged = by_material(pieces);
    Ok((!merged.is_empty()).then(|| scene.mesh(link.name.clone(), merged)))
}

fn visual_pieces(
    link: &Link,
    visual: &LinkVisual,
    scene: &mut Scene,
    files: &mut MeshFiles,
) -> Result<Vec<MeshPiece>, ViewError> {
    let own = visual.colour;
    let material = scene.material(plastic(own.unwrap_or_default(), own.is_none()));
    let piece = match &visual.form {
        LinkForm::Mesh { name, candidates, scale } => {
            let Some(path) = candidates.iter().find(|path| path.is_file()) else {
                return Err(ViewError::VisualNotFound {
                    link: link.name.clone(),
                    mesh: name.clone(),
                    tried: candidates.clone(),
                });
            };
            let mesh = files.read(path, scale)?;
            let pieces = mesh.pieces.iter().map(|piece| {
                let colour = piece.colour.map(|colour| colour.map(f64::from));
                let material = match (colour, own) {
                    // Materials in the file are more detailed than the single colour of a URDF.
                    (Some(colour), _) => scene.material(plastic(colour, false)),
                    _ => material,
                };
                placed(MeshPiece::of_painted(piece, material), &visual.link_from_visual)
            });
            return Ok(pieces.collect());
        }
        LinkForm::Cuboid { size } if visual.rounding_m > 0.0 => {
            rounded::cuboid(&(size * 0.5), visual.rounding_m, material)
        }
        LinkForm::Cylinder { length_m, radius_m } if visual.rounding_m > 0.0 => {
            rounded::cylinder(0.5 * length_m, *radius_m, visual.rounding_m, material)
        }
        LinkForm::Cuboid { size } => of_solid(&Solid::cuboid(size * 0.5)?, material),
        LinkForm::Hull { points } => of_solid(&Solid::hull(points)?, material),
        LinkForm::Sphere { radius_m } => of_solid(&Solid::sphere(*radius_m)?, material),
        LinkForm::Cylinder { length_m, radius_m } => {
            of_solid(&Solid::cylinder(0.5 * length_m, *radius_m)?, material)
        }
        LinkForm::Capsule { length_m, radius_m } => {
            of_solid(&Solid::capsule(0.5 * length_m, *radius_m)?, material)
        }
    };
    Ok(vec![placed(piece, &visual.link_from_visual)])
}

fn of_solid(solid: &Solid, material: usize) -> MeshPiece {
    MeshPiece::of_soup(&solid.tessellation().unwrap_or_default(), material)
}

/// Returns the material for a colour of a robot: white and grey components are lacquered, dark ones closer to rubber.
fn plastic([red, green, blue, opacity]: [f64; 4], is_bare: bool) -> Material {
    if is_bare {
        return Material { roughness: 0.45, ..Material::matt("robot", Colour::hex(BARE)) };
    }
    let name = format!("robot {red:.2} {green:.2} {blue:.2}");
    let roughness = if red + green + blue < 1.2 { 0.5 } else { 0.32 };
    #[allow(clippy::cast_possible_truncation, reason = "the precision of graphics")]
    let opacity = opacity as f32;
    Material { opacity, roughness, ..Material::matt(name, Colour::srgb([red, green, blue])) }
}

/// Transforms a piece by a pose.
pub(crate) fn placed(mut piece: MeshPiece, target_from_piece: &Pose) -> MeshPiece {
    let pose = target_from_piece.cast::<f32>();
    for position in &mut piece.positions {
        *position = (pose.rotation * Vector3::from(*position) + pose.translation.vector).into();
    }
    for normal in &mut piece.normals {
        *normal = (pose.rotation * Vector3::from(*normal)).into();
    }
    piece
}

/// Merges pieces of one material and drops empty ones.
pub(crate) fn by_material(pieces: Vec<MeshPiece>) -> Vec<MeshPiece> {
    let mut merged: Vec<MeshPiece> = Vec::new();
    let mut known: HashMap<(usize, bool), usize> = HashMap::new();
    for piece in pieces.into_iter().filter(|piece| !piece.triangles.is_empty()) {
        match known.entry((piece.material, piece.colours.is_empty())) {
            Entry::Occupied(known) => merged[*known.get()].append(&piece),
            Entry::Vacant(new) => {
                new.insert(merged.len());
                merged.push(piece);
            }
        }
    }
    merged
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A mesh was read once for each spelling of its path, and had the scale of its first visual everywhere.
    #[test]
    fn a_mesh_is_read_once_for_each_scale_and_all_visuals_are_bounded() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.obj");
        std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
        let mut files = MeshFiles { known: HashMap::new(), left: 4 };
        for (spelling, factor) in [("a.obj", 1.0), ("./a.obj", 1.0), ("././a.obj", 2.0), ("a.obj", 2.0)] {
            let mesh = files.read(&folder.path().join(spelling), &Vector::repeat(factor)).unwrap();
            assert!((f64::from(mesh.pieces[0].vertices[1][0]) - factor).abs() < 1e-6);
        }
        assert_eq!(files.known.len(), 2);
        let fault = files.read(&path, &Vector::repeat(1.0)).unwrap_err();
        assert!(matches!(fault, ViewError::ManyTriangles { .. }), "{fault}");
    }
}
