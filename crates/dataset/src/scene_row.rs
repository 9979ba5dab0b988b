use cranny_robot::Robot;
use cranny_scenario::{Placement, RecipeBody, RecipeShape, SetMember};
use cranny_spatial::nalgebra::Quaternion;
use cranny_spatial::{Pose, Rotation, Vector};

/// Row of a scene: the drawn values, from which the scenario is made again, and its geometry for programs without Cranny.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SceneRow {
    /// Index of the scene.
    pub scene: u64,
    /// Family.
    pub family: String,
    /// Robot.
    pub robot: String,
    /// Difficulty parameter of the family, in metres.
    pub parameter_m: f64,
    /// Placement of the object in the scene: centre of its bounds along x and y (m), yaw (rad).
    pub placement: Vec<f64>,
    /// Clutter, eleven numbers for each object: 0 for a box or 1 for an upright cylinder; the sides of the box, or radius, length
    /// and 0 (m); position (m) and unit quaternion (w, x, y, z) in the scene.
    pub clutter: Vec<f64>,
    /// Boxes of the obstacles and of the clutter, ten numbers for each: sides (m); position (m) and unit quaternion (w, x, y, z)
    /// in the planning frame. A cylinder counts as the box around it.
    pub boxes: Vec<f32>,
    /// Pose of the target in the planning frame: position (m) and unit quaternion (w, x, y, z).
    pub target_pose: Vec<f64>,
    /// Start configuration of the robot's files (m, rad; one per joint).
    pub start: Vec<f64>,
    /// Result at each grasp, one byte each ([`GRASP_RESULTS`](crate::GRASP_RESULTS)).
    pub grasp_results: Vec<u8>,
    /// Number of goal configurations that the queries share.
    pub goals: u64,
    /// Number of draws that were rejected before this one.
    pub rejected: u64,
}

/// Numbers of a clutter object, and of a box.
const PER_CLUTTER: usize = 11;
const BOX: f64 = 0.0;
const CYLINDER: f64 = 1.0;

impl SceneRow {
    /// Creates the row of a drawn scene; results at the grasps are added later.
    pub(crate) fn of(scene: u64, family: &str, member: &SetMember) -> Self {
        let SetMember { recipe, parameter_m, placement, clutter } = member;
        let robot: &Robot = &recipe.robot.robot;
        let fixed = recipe.obstacles.len() - clutter;
        let planning_from_scene = recipe.robot.scene_from_root.inverse();
        let target = recipe.target.as_ref().map(|target| {
            let body_from_shape = target.shapes.first().map_or_else(Pose::identity, |(pose, _)| *pose);
            planning_from_scene * target.scene_from_body * body_from_shape
        });
        Self {
            scene,
            family: family.to_owned(),
            robot: robot.name().to_owned(),
            parameter_m: *parameter_m,
            placement: vec![placement.x_m, placement.y_m, placement.yaw_rad],
            clutter: recipe.obstacles[fixed..].iter().flat_map(clutter_numbers).collect(),
            boxes: recipe.obstacles.iter().flat_map(|body| boxes(&planning_from_scene, body)).collect(),
            target_pose: target.map(|pose| pose_numbers(&pose).to_vec()).unwrap_or_default(),
            start: recipe.start.clone(),
            grasp_results: vec![0; recipe.grasps.len()],
            goals: 0,
            rejected: 0,
        }
    }

    /// Returns true if the geometry of both rows is the same to the bit.
    pub(crate) fn has_geometry_of(&self, other: &Self) -> bool {
        let bits = |numbers: &[f64]| numbers.iter().map(|number| number.to_bits()).collect::<Vec<u64>>();
        let single = |numbers: &[f32]| numbers.iter().map(|number| number.to_bits()).collect::<Vec<u32>>();
        self.robot == other.robot
            && bits(&self.target_pose) == bits(&other.target_pose)
            && bits(&self.start) == bits(&other.start)
            && single(&self.boxes) == single(&other.boxes)
            && self.grasp_results.len() == other.grasp_results.len()
    }

    /// Returns true if a sound scene was drawn.
    pub fn is_drawn(&self) -> bool {
        self.parameter_m.is_finite()
    }

    /// Placement of the object; `None` for a damaged row.
    pub(crate) fn place(&self) -> Option<Placement> {
        let [x_m, y_m, yaw_rad] = self.placement[..] else { return None };
        Some(Placement { x_m, y_m, yaw_rad })
    }

    /// Clutter of the scene; `None` for a damaged row.
    pub(crate) fn clutter_bodies(&self) -> Option<Vec<RecipeBody>> {
        let (objects, rest) = self.clutter.as_chunks::<PER_CLUTTER>();
        let bodies = objects.iter().enumerate().map(|(index, numbers)| clutter_body(index, numbers));
        if rest.is_empty() { bodies.collect() } else { None }
    }
}

/// Returns position (m) and unit quaternion (w, x, y, z) of a pose.
pub(crate) fn pose_numbers(pose: &Pose) -> [f64; 7] {
    let (t, q) = (pose.translation.vector, pose.rotation.coords);
    [t.x, t.y, t.z, q.w, q.x, q.y, q.z]
}

fn clutter_numbers(body: &RecipeBody) -> Vec<f64> {
    let numbers = match body.shapes.first() {
        Some((_, RecipeShape::Cuboid(size))) => [BOX, size.x, size.y, size.z],
        Some((_, RecipeShape::Cylinder(radius_m, length_m))) => [CYLINDER, *radius_m, *length_m, 0.0],
        _ => return Vec::new(),
    };
    [&numbers[..], &pose_numbers(&body.scene_from_body)].concat()
}

fn clutter_body(index: usize, numbers: &[f64; PER_CLUTTER]) -> Option<RecipeBody> {
    let [kind, a, b, c, x, y, z, qw, qx, qy, qz] = *numbers;
    if !numbers.iter().all(|number| number.is_finite()) {
        return None;
    }
    let shape = if kind.total_cmp(&BOX).is_eq() {
        RecipeShape::Cuboid(Vector::new(a, b, c))
    } else if kind.total_cmp(&CYLINDER).is_eq() {
        RecipeShape::Cylinder(a, b)
    } else {
        return None;
    };
    // The components are those that were written, so that the scene is the same to the bit.
    let rotation = Rotation::new_unchecked(Quaternion::new(qw, qx, qy, qz));
    Some(RecipeBody {
        name: format!("clutter {}", index + 1),
        scene_from_body: Pose::from_parts(Vector::new(x, y, z).into(), rotation),
        shapes: vec![(Pose::identity(), shape)],
        tilt_rad: None,
    })
}

#[allow(clippy::cast_possible_truncation, reason = "single precision is the precision of the column")]
fn boxes(planning_from_scene: &Pose, body: &RecipeBody) -> Vec<f32> {
    let of_shape = |(body_from_shape, shape): &(Pose, RecipeShape)| {
        let size = match shape {
            RecipeShape::Cuboid(size) => *size,
            RecipeShape::Cylinder(radius_m, length_m) => {
                Vector::new(2.0 * radius_m, 2.0 * radius_m, *length_m)
            }
            _ => return Vec::new(),
        };
        let pose = planning_from_scene * body.scene_from_body * body_from_shape;
        size.iter().copied().chain(pose_numbers(&pose)).map(|number| number as f32).collect()
    };
    body.shapes.iter().flat_map(of_shape).collect()
}
