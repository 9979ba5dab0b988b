use std::cell::RefCell;
use std::collections::HashMap;
use std::path::PathBuf;

use cranny_shape::{ShapeError, Solid, TriangleSoup};
use cranny_spatial::Vector;

/// Function that makes a solid of a mesh file: [`Solid::mesh`] for a target, [`Solid::mesh_with_small_holes`] for an obstacle.
pub(crate) type SolidOfMesh = fn(&TriangleSoup) -> Result<Solid, ShapeError>;

/// Solids of the mesh files of a scenario: a file that several bodies name is read once, and they share its solid.
#[derive(Default)]
pub(crate) struct MeshSolids {
    known: RefCell<HashMap<Key, Solid>>,
}

/// Path, bits of the scale, and kind of a solid.
type Key = (PathBuf, u64, Option<SolidOfMesh>);

impl MeshSolids {
    /// Returns the solid of a mesh file, scaled, or of its convex hull without `of_mesh`.
    ///
    /// # Errors
    /// Those of reading the file, and of `of_mesh`.
    pub fn solid(
        &self,
        path: PathBuf,
        scale: Option<f64>,
        of_mesh: Option<SolidOfMesh>,
    ) -> Result<Solid, ShapeError> {
        let scale = scale.unwrap_or(1.0);
        let key = (path, scale.to_bits(), of_mesh);
        if let Some(known) = self.known.borrow().get(&key) {
            return Ok(known.clone());
        }
        let soup = TriangleSoup::load(&key.0, Vector::repeat(scale))?;
        let solid = of_mesh.map_or_else(|| Solid::hull(&soup.vertices), |of_mesh| of_mesh(&soup));
        let solid = solid.map_err(|fault| fault.in_file(&key.0))?;
        self.known.borrow_mut().insert(key, solid.clone());
        Ok(solid)
    }
}
