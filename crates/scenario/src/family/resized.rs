use cranny_shape::TriangleSoup;

use crate::layout::recipe::RecipeShape;
use crate::object::physics::TargetPhysics;

/// Returns the scaled shape, and its physics with the mass scaled by the volume.
pub(crate) fn resized(
    shape: &RecipeShape,
    physics: &TargetPhysics,
    mesh: &TriangleSoup,
    scale: f64,
) -> (RecipeShape, TargetPhysics) {
    let shape = match shape {
        RecipeShape::Cuboid(size) => RecipeShape::Cuboid(size * scale),
        RecipeShape::Sphere(radius_m) => RecipeShape::Sphere(radius_m * scale),
        _ => RecipeShape::Mesh(scaled(mesh, scale)),
    };
    let mass_kg = physics.mass_kg.map(|mass_kg| mass_kg * scale.powi(3));
    (shape, TargetPhysics { mass_kg, ..*physics })
}

pub(crate) fn scaled(mesh: &TriangleSoup, scale: f64) -> TriangleSoup {
    let mut mesh = mesh.clone();
    for vertex in &mut mesh.vertices {
        *vertex *= scale;
    }
    mesh
}
