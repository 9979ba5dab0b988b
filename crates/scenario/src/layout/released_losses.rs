//! Content of a recipe that the paper's released layout cannot hold.

use crate::layout::recipe::{Recipe, RecipeShape};
use crate::layout::recipe_file::file_name;
use crate::robot::builtin::BUILTIN_ROBOTS;

impl Recipe {
    /// Returns what [`Recipe::write_released`] does not write, or writes otherwise, a line each; empty if nothing.
    pub fn released_losses(&self) -> Vec<String> {
        let mut losses = Vec::new();
        let bodies = || self.target.iter().chain(&self.obstacles);
        let shapes = bodies().flat_map(|body| &body.shapes);
        let inside_m = shapes.filter_map(|(_, shape)| shape.mesh_inside_m()).reduce(f64::max);
        if let Some(inside_m) = inside_m {
            losses.push(format!(
                "round shapes become meshes with their vertices on the surface, and faces up to {:.2} mm inside it: what \
                 is free of the meshes may touch the shapes",
                1e3 * inside_m
            ));
        }
        if self.robot.named != BUILTIN_ROBOTS[0].name {
            losses.push("not written: the robot, which the reader must name".to_owned());
        }
        let exempted = self.robot.unchecked_pairs.len();
        let renamed = bodies().filter(|body| file_name(&body.name) != body.name).count();
        for (count, what) in [
            (self.places.len(), "places"),
            (self.regions.len(), "goal regions"),
            (self.tasks.len(), "tasks"),
            (self.tool_bounds.len(), "bounds of the tool"),
            (self.joint_bounds.len(), "bounds of joints"),
            (self.speeds.len(), "speeds"),
            (self.colours.len(), "colours"),
            (self.physics.len(), "masses and friction of obstacles"),
            (bodies().filter(|body| body.tilt_rad.is_some()).count(), "limits of the tilt of an object"),
            (usize::from(self.given_physics.rolling_m.is_some()), "resistances to rolling"),
            (self.grasps.grasps().iter().filter(|grasp| grasp.width_m.is_some()).count(), "widths of grasps"),
            (exempted, "pairs of links that are not compared"),
            (renamed, "names that are no file names, which change"),
        ] {
            if count > 0 {
                losses.push(format!("not written: {what} ({count})"));
            }
        }
        losses
    }
}

impl RecipeShape {
    /// Returns the greatest distance of a face of the mesh of a round shape from the surface, in metres, to some hundredths;
    /// `None` for a shape with flat faces.
    fn mesh_inside_m(&self) -> Option<f64> {
        /// Share of the radius by which the faces of the geodesic sphere of 1280 triangles are inside it.
        const OF_SPHERE: f64 = 0.0046;
        /// Share of the radius by which the middle of a chord of 64 is inside the circle.
        const OF_CIRCLE: f64 = 0.0013;
        match self {
            Self::Sphere(radius_m) | Self::Capsule(radius_m, _) => Some(OF_SPHERE * radius_m),
            Self::Cylinder(radius_m, _) => Some(OF_CIRCLE * radius_m),
            Self::Cuboid(_) | Self::Object(_) | Self::Mesh(_) | Self::Hull(_) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The stated shares bound the distance of the middle of each face.
    #[test]
    fn faces_of_round_shapes_are_no_deeper_than_stated() {
        for shape in
            [RecipeShape::Sphere(1.0), RecipeShape::Capsule(1.0, 2.0), RecipeShape::Cylinder(1.0, 2.0)]
        {
            let soup = shape.soup().unwrap();
            let round = |z: f64| match shape {
                RecipeShape::Cylinder(..) => 0.0,
                RecipeShape::Capsule(..) => z.abs() - z.abs().min(1.0),
                _ => z,
            };
            let depths = soup.triangles.iter().filter_map(|face| {
                let middle = face
                    .iter()
                    .map(|index| soup.vertices[*index as usize].coords / 3.0)
                    .sum::<cranny_spatial::Vector>();
                let radius = middle.x.hypot(middle.y).hypot(round(middle.z));
                // The flat ends of a cylinder are exact.
                (!matches!(shape, RecipeShape::Cylinder(..)) || middle.z.abs() < 0.99).then_some(1.0 - radius)
            });
            let deepest = depths.fold(0.0, f64::max);
            let stated = shape.mesh_inside_m().unwrap();
            assert!(deepest <= stated && deepest > 0.5 * stated, "{shape:?}: {deepest}, stated {stated}");
        }
    }
}
