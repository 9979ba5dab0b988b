//! Built-in objects, generated from published dimensions of the YCB object set (Calli et al. 2015, "The YCB object and model
//! set", whole); the origin is at the centre of their bounds.

mod banana;
mod object_shape;
mod screwdriver;
mod sugar_box;
mod tennis_ball;

use std::sync::OnceLock;

use cranny_shape::{ConvexParts, ShapeError, Solid, TriangleSoup};
use cranny_spatial::Pose;

use self::object_shape::ObjectShape;
use crate::ObjectError;
use crate::{ObjectSettings, ObjectType, ScenarioError};

/// Recipe of a built-in object.
#[derive(Debug)]
pub(crate) struct Recipe {
    pub name: &'static str,
    /// Published mass, in kilograms.
    pub mass_kg: f64,
    shape: fn() -> Result<ObjectShape, ShapeError>,
    /// Volume of the mesh, made at its first use: with its hulls and trees, that takes milliseconds.
    volume: OnceLock<Solid>,
}

static RECIPES: [Recipe; 4] = [
    Recipe::new("flat_screwdriver", 0.0984, screwdriver::shape),
    Recipe::new("tennis_ball", 0.058, || Ok(tennis_ball::shape())),
    Recipe::new("sugar_box", 0.514, || Ok(sugar_box::shape())),
    Recipe::new("banana", 0.066, banana::shape),
];

/// Returns the names of the built-in objects.
pub fn builtin_object_names() -> Vec<&'static str> {
    RECIPES.iter().map(|recipe| recipe.name).collect()
}

/// Returns the built-in object of that name: mesh, convex parts, mass, friction, stable poses.
///
/// # Errors
/// [`ObjectError::Unknown`], which lists the names of the built-in objects.
pub fn builtin_object(name: &str) -> Result<ObjectType, ScenarioError> {
    recipe(name)?.object()
}

/// Returns the mesh of the built-in object of that name.
///
/// # Errors
/// As [`builtin_object`].
pub(crate) fn mesh(name: &str) -> Result<TriangleSoup, ScenarioError> {
    recipe(name)?.mesh()
}

/// Returns the recipe of the built-in object of that name.
///
/// # Errors
/// As [`builtin_object`].
pub(crate) fn recipe(name: &str) -> Result<&'static Recipe, ScenarioError> {
    RECIPES.iter().find(|recipe| recipe.name == name).ok_or_else(|| {
        let known = builtin_object_names().join(", ");
        ObjectError::Unknown { name: name.to_owned(), known }.into()
    })
}

impl Recipe {
    const fn new(name: &'static str, mass_kg: f64, shape: fn() -> Result<ObjectShape, ShapeError>) -> Self {
        Self { name, mass_kg, shape, volume: OnceLock::new() }
    }

    /// Returns the volume of the mesh.
    pub fn solid(&self) -> Result<Solid, ScenarioError> {
        if let Some(known) = self.volume.get() {
            return Ok(known.clone());
        }
        let solid = Solid::mesh(&self.mesh()?)?;
        Ok(self.volume.get_or_init(|| solid).clone())
    }

    /// Returns the object, with convex parts and stable poses.
    pub fn object(&self) -> Result<ObjectType, ScenarioError> {
        let ObjectShape { mesh, parts, solid } = (self.shape)()?.centred();
        let parts = ConvexParts::measured(&mesh, parts)?;
        let solids = solid.map(|solid| (Pose::identity(), solid)).into_iter().collect();
        let object = ObjectType::of_parts(mesh, parts, &ObjectSettings::new(self.name, self.mass_kg))?;
        Ok(ObjectType { solids, ..object })
    }

    /// Returns the mesh only.
    pub fn mesh(&self) -> Result<TriangleSoup, ScenarioError> {
        Ok((self.shape)()?.centred().mesh)
    }
}

impl ObjectShape {
    /// Returns the shape with the origin at the centre of its bounds.
    fn centred(mut self) -> Self {
        let first = self.mesh.vertices[0];
        let (low, high) = self.mesh.vertices.iter().fold((first, first), |(l, h), p| (l.inf(p), h.sup(p)));
        let middle = (low.coords + high.coords) * 0.5;
        for soup in std::iter::once(&mut self.mesh).chain(&mut self.parts) {
            for vertex in &mut soup.vertices {
                *vertex -= middle;
            }
        }
        self
    }
}
