//! Recipes as folders in the paper's released layout.

use std::fmt::Write as _;
use std::path::Path;

use cranny_grasp::rows_of_pose;
use cranny_shape::{ShapeError, Surface, TriangleSoup, VolumeMoments};
use cranny_spatial::Vector;

use crate::files::atomic_file::write_into;
use crate::layout::recipe::{Recipe, RecipeBody, RecipeShape};
use crate::layout::recipe_file::{configurations_text, file_name};
use crate::layout::released;
use crate::layout::released_frame::planning_from_scene;
use crate::layout::released_grasps;
use crate::robot::builtin::BUILTIN_ROBOTS;
use crate::{DEFAULT_FRICTION, ScenarioError};

/// Object library of the folder, relative to it.
const LIBRARY: &str = "object_library";

/// Default mass of an object to grasp, in kilograms: that of most objects in the released library.
const OBJECT_MASS_KG: f64 = 0.2;

impl Recipe {
    /// Writes the scenario as a folder in the paper's released layout, with its own object library, so that the released
    /// programs run on it: `scene.yaml`, `grasps.npy`, `object_library/` and `export/` with grasps, start, IK solutions and
    /// `obstacles.obj`. The latter contains the true shapes, target first. Spheres, cylinders and capsules become meshes with
    /// their vertices on the surface. `scene.yaml` is written last. [`Self::released_losses`] lists what the layout cannot hold.
    ///
    /// # Errors
    /// [`ScenarioError::Unwritable`], [`ScenarioError::ShapeFile`], and [`ScenarioError::TargetCount`] for a
    /// recipe without a target.
    pub fn write_released(&self, folder: &Path) -> Result<(), ScenarioError> {
        let Some(target) = &self.target else {
            return Err(ScenarioError::TargetCount { path: folder.to_owned(), actual: 0 });
        };
        let write = |name: &str, text: &str| write_into(folder, name, text);
        // The layout supports one robot only, and everything is in its frame.
        let paper_from_scene = planning_from_scene();
        let is_elsewhere = self.robot.scene_from_root != paper_from_scene.inverse();
        let paper_from_planning = paper_from_scene * self.robot.scene_from_root;
        let grasps = if is_elsewhere { self.grasps.moved(&paper_from_planning) } else { self.grasps.clone() };
        let mut merged = TriangleSoup::default();
        let mut library = String::from("description: no description available\nname: cranny\nobjects:\n");
        let physics = self.target_physics();
        let of_target =
            (physics.mass_kg.unwrap_or(OBJECT_MASS_KG), physics.least_friction().unwrap_or(DEFAULT_FRICTION));
        // A simulator fixes an object without mass in space.
        let of_obstacle = (0.0, DEFAULT_FRICTION);
        for (body, (mass_kg, friction)) in
            std::iter::once((target, of_target)).chain(self.obstacles.iter().map(|body| (body, of_obstacle)))
        {
            let soup = body.soup()?;
            let name = file_name(&body.name);
            write(&format!("{LIBRARY}/meshes/{name}.obj"), &soup.obj_text(1))?;
            // A simulator uses the convex hull of each group.
            write(&format!("{LIBRARY}/vhacd/{name}_vhacd.obj"), &body.grouped_obj()?)?;
            write(&format!("{LIBRARY}/urdf/{name}.urdf"), &urdf(&name, &soup, mass_kg, friction)?)?;
            library.push_str(&library_entry(&name, mass_kg, friction));
            merged.append(&soup, &(paper_from_scene * body.scene_from_body));
        }
        library.push_str("yaml_file_type: ObjectLibrary\nyaml_file_version: '1.0'\n");
        write("object_library/object_library.yaml", &library)?;
        write("export/obstacles.obj", &merged.obj_text(1))?;
        let start: Vec<Vec<f64>> = self.start.iter().map(|value| vec![*value]).collect();
        write("export/robot_start_conf.csv", &configurations_text(&start))?;
        write("export/grasp_IK_solutions.csv", &configurations_text(&self.ik))?;
        let rows = grasps.grasps().iter().map(|grasp| rows_of_pose(&grasp.world_from_gripper).to_vec());
        let rows: Vec<Vec<f64>> = rows.collect();
        write("export/grasps.csv", &configurations_text(&rows))?;
        released_grasps::write(&folder.join(released_grasps::FILE), &grasps)?;
        write(released::FILE, &self.scene_yaml(target))
    }

    fn scene_yaml(&self, target: &RecipeBody) -> String {
        let mut text =
            String::from(if self.obstacles.is_empty() { "bg_objects: []\n" } else { "bg_objects:\n" });
        for body in &self.obstacles {
            text.push_str(&placed(body));
        }
        let _ = write!(text, "ground_area_x: 2\nground_area_y: 2\n");
        let _ =
            write!(text, "object_library_fn: {LIBRARY}/object_library.yaml\nobjects:\n{}", placed(target));
        text.push_str("printout: null\nyaml_file_type: Scene\nyaml_file_version: '1.0'\n");
        text
    }
}

fn placed(body: &RecipeBody) -> String {
    let mut text = format!("- object_type: {}\n  pose:\n", file_name(&body.name));
    for row in rows_of_pose(&body.scene_from_body).chunks_exact(4) {
        let _ = writeln!(text, "  - [{:?}, {:?}, {:?}, {:?}]", row[0], row[1], row[2], row[3]);
    }
    text
}

fn library_entry(name: &str, mass_kg: f64, friction: f64) -> String {
    format!(
        "- friction_coeff: {friction:?}\n  identifier: {name}\n  mass: {mass_kg:?}\n  \
         mesh_fn: meshes/{name}.obj\n  name: {name}\n  scale: 1.0\n  stable_poses:\n    poses: []\n    \
         probabilities: []\n  thumbnail_fn: null\n  urdf_fn: urdf/{name}.urdf\n  \
         vhacd_fn: vhacd/{name}_vhacd.obj\n"
    )
}

fn urdf(name: &str, soup: &TriangleSoup, mass_kg: f64, friction: f64) -> Result<String, ShapeError> {
    let moments = VolumeMoments::of_mesh(soup)?;
    let i = moments.inertia_per_mass_m2 * mass_kg;
    let c = moments.center;
    let mesh = format!("<geometry><mesh filename=\"../vhacd/{name}_vhacd.obj\" scale=\"1 1 1\"/></geometry>");
    Ok(format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<robot name=\"{name}\">\n  <link name=\"base\">\n    \
         <collision>{mesh}<contact_coefficients mu=\"{friction}\"/></collision>\n    \
         <visual>{mesh}</visual>\n    <inertial>\n      <origin xyz=\"{} {} {}\"/>\n      \
         <mass value=\"{mass_kg}\"/>\n      <inertia ixx=\"{}\" ixy=\"{}\" ixz=\"{}\" iyy=\"{}\" iyz=\"{}\" \
         izz=\"{}\"/>\n    </inertial>\n  </link>\n</robot>\n",
        c.x, c.y, c.z, i.m11, i.m12, i.m13, i.m22, i.m23, i.m33
    ))
}

impl RecipeBody {
    /// Returns all shapes as one mesh, in the body's frame; each cuboid has twelve consecutive faces.
    fn soup(&self) -> Result<TriangleSoup, ScenarioError> {
        let mut soup = TriangleSoup::default();
        for (body_from_shape, shape) in &self.shapes {
            soup.append(&shape.soup()?, body_from_shape);
        }
        Ok(soup)
    }

    /// Returns that mesh in the scene.
    pub(crate) fn placed_soup(&self) -> Result<TriangleSoup, ScenarioError> {
        let mut soup = TriangleSoup::default();
        soup.append(&self.soup()?, &self.scene_from_body);
        Ok(soup)
    }

    /// Returns that mesh as an OBJ file with a group per shape.
    fn grouped_obj(&self) -> Result<String, ScenarioError> {
        let mut text = String::new();
        let mut first = 1;
        for (index, (body_from_shape, shape)) in self.shapes.iter().enumerate() {
            let mut soup = TriangleSoup::default();
            soup.append(&shape.soup()?, body_from_shape);
            let _ = write!(text, "o part_{index}\n{}", soup.obj_text(first));
            first += u32::try_from(soup.vertices.len()).unwrap_or(u32::MAX);
        }
        Ok(text)
    }
}

impl RecipeShape {
    /// Returns the surface of the shape: closed, normals outwards; round shapes have their vertices on the surface.
    pub(crate) fn soup(&self) -> Result<TriangleSoup, ScenarioError> {
        /// Number of subdivisions: 1280 triangles.
        const DIVISIONS: u32 = 3;
        Ok(match self {
            Self::Cuboid(size) => Surface::cuboid_soup(&(size * 0.5)),
            Self::Object(source) => source.mesh()?,
            Self::Mesh(soup) => soup.clone(),
            Self::Hull(soup) => TriangleSoup::convex_hull(&soup.vertices)?,
            Self::Sphere(radius_m) => TriangleSoup::geodesic_sphere(*radius_m, DIVISIONS),
            Self::Cylinder(radius_m, length_m) => {
                let rim = |z: f64| {
                    let angle = |k: u32| std::f64::consts::TAU * f64::from(k) / f64::from(RIM_POINTS);
                    (0..RIM_POINTS).map(move |k| {
                        let (sine, cosine) = cranny_spatial::sin_cos(angle(k));
                        cranny_spatial::Point::new(radius_m * cosine, radius_m * sine, z)
                    })
                };
                let points: Vec<_> = rim(-0.5 * length_m).chain(rim(0.5 * length_m)).collect();
                TriangleSoup::convex_hull(&points)?
            }
            Self::Capsule(radius_m, length_m) => {
                let ball = TriangleSoup::geodesic_sphere(*radius_m, DIVISIONS);
                let end = |sign: f64| {
                    let shift = Vector::new(0.0, 0.0, 0.5 * sign * length_m);
                    ball.vertices.iter().map(move |vertex| vertex + shift)
                };
                let points: Vec<_> = end(-1.0).chain(end(1.0)).collect();
                TriangleSoup::convex_hull(&points)?
            }
        })
    }
}

/// Number of points around a cylinder: the mesh is at most a thousandth of the radius inside it.
const RIM_POINTS: u32 = 64;

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
        let physics = self.target_physics();
        if physics.mass_kg.is_none() && self.target.is_some() {
            losses.push(format!("the mass of the target is not known, and written as {OBJECT_MASS_KG} kg"));
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
            (usize::from(physics.rolling_m.is_some()), "resistances to rolling"),
            (self.grasps.grasps().iter().filter(|grasp| grasp.score.is_some()).count(), "scores of grasps"),
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
                let middle =
                    face.iter().map(|index| soup.vertices[*index as usize].coords / 3.0).sum::<Vector>();
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
