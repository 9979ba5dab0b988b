//! Recipes as folders in Cranny's layout.

use std::fmt::Write as _;
use std::path::Path;

use cranny_collision::{ToolBound, ToolRegion};
use cranny_grasp::csv_text;
use cranny_spatial::{Point, Pose, Rotation};
use cranny_task::{PlaceGoal, PlaceRegion};

use crate::files::atomic_file::write_into;
use crate::layout::own;
use crate::layout::recipe::{Recipe, RecipeBody, RecipeShape};
use crate::robot::in_folder::{ROBOT, write_robot};
use crate::{Friction, NamedTask, ScenarioError, StatedSpeed, TargetPhysics};

/// Folder of a scenario's meshes.
const MESHES: &str = "meshes";

/// Folder of a scenario's objects.
const OBJECTS: &str = "objects";

impl Recipe {
    /// Writes the scenario as a new or existing folder, `scenario.yaml` last: a folder that contains this file is complete.
    ///
    /// # Errors
    /// [`ScenarioError::Unwritable`], [`ScenarioError::ShapeFile`].
    pub fn write_folder(&self, folder: &Path) -> Result<(), ScenarioError> {
        if let Some(files) = &self.robot.files {
            write_robot(&folder.join(ROBOT), files)?;
        }
        for body in self.obstacles.iter().chain(&self.target) {
            for (index, (_, shape)) in body.shapes.iter().enumerate() {
                match shape {
                    RecipeShape::Mesh(soup) | RecipeShape::Hull(soup) => {
                        write_into(folder, &mesh_file(body, index), soup.obj_text(1))?;
                    }
                    RecipeShape::Object(source) => {
                        if let Some(object) = source.own() {
                            object.write_folder(&folder.join(object_folder(body, index)))?;
                        }
                    }
                    _ => {}
                }
            }
        }
        if !self.grasps.is_empty() || self.target.is_none() {
            write_into(folder, "grasps.csv", csv_text(&self.grasps))?;
        }
        if !self.ik.is_empty() {
            write_into(folder, "ik.csv", configurations_text(&self.ik))?;
        }
        write_into(folder, own::FILE, self.yaml())
    }

    /// Returns the text of its `scenario.yaml`.
    pub fn yaml(&self) -> String {
        let mut text = format!("# {}\n", self.title.replace('\n', " "));
        let Pose { translation, rotation } = self.robot.scene_from_root;
        let yaw_deg = plain(rotation.euler_angles().2.to_degrees());
        let _ = writeln!(text, "robot: {}", self.robot.named_in_yaml());
        if !self.robot.unchecked_pairs.is_empty() {
            let pairs = serde_json::to_value(&self.robot.unchecked_pairs).unwrap_or_default();
            let _ = writeln!(text, "unchecked_pairs: {pairs}");
        }
        let _ = writeln!(
            text,
            "frame: {{position: {}, rotation_rpy_deg: [0, 0, {yaw_deg}]}}",
            list(translation.vector.as_slice())
        );
        let start: Vec<String> = self.start.iter().map(f64::to_string).collect();
        let _ = writeln!(text, "start: [{}]", start.join(", "));
        text.push_str("floor: 0\n");
        if !self.obstacles.is_empty() {
            text.push_str("obstacles:\n");
        }
        for body in &self.obstacles {
            body.write(&mut text, ["  - ", "    "], self.colours_of(body));
            let physics = self.physics.get(&body.name).copied().unwrap_or_default();
            write_physics(&mut text, "    ", physics);
            write_tilt(&mut text, "    ", body.tilt_rad);
        }
        if let Some(target) = &self.target {
            text.push_str("target:\n");
            target.write(&mut text, ["  ", "  "], self.colours_of(target));
            write_physics(&mut text, "  ", self.given_physics);
            write_tilt(&mut text, "  ", target.tilt_rad);
        }
        if !self.places.is_empty() {
            text.push_str("places:\n");
        }
        for place in &self.places {
            self.write_place(place, &mut text);
        }
        if !self.regions.is_empty() {
            text.push_str("regions:\n");
        }
        for (name, region) in &self.regions {
            let row = serde_json::to_value(region).unwrap_or_default();
            let _ = writeln!(text, "  {}: {row}", serde_json::Value::from(name.as_str()));
        }
        if !self.tasks.is_empty() {
            text.push_str("tasks:\n");
        }
        for NamedTask { name, stages } in &self.tasks {
            let _ = writeln!(text, "  - name: {}\n    stages:", serde_json::Value::from(name.as_str()));
            for stage in stages {
                let row = serde_json::to_value(stage).unwrap_or_default();
                let keys =
                    row.as_object().into_iter().flatten().map(|(key, value)| format!("{key}: {value}"));
                let _ = writeln!(text, "      - {{{}}}", keys.collect::<Vec<_>>().join(", "));
            }
        }
        if !self.tool_bounds.is_empty() {
            text.push_str("tool_bounds:\n");
        }
        for bound in &self.tool_bounds {
            write_bound(&mut text, bound);
        }
        if !self.joint_bounds.is_empty() {
            text.push_str("joint_bounds:\n");
        }
        for (joint, [lower, upper]) in &self.joint_bounds {
            let _ = writeln!(text, "  {}: [{lower}, {upper}]", serde_json::Value::from(joint.as_str()));
        }
        if !self.speeds.is_empty() {
            text.push_str("speeds:\n");
        }
        for speed in &self.speeds {
            let StatedSpeed { velocity, acceleration, tool_m_s, turn_deg_s, .. } = speed;
            let stated = [
                ("speed", velocity),
                ("acceleration", acceleration),
                ("tool_speed_m_s", tool_m_s),
                ("turn_speed_deg_s", turn_deg_s),
            ];
            let stated = stated.into_iter().filter_map(|(key, value)| Some(format!("{key}: {}", (*value)?)));
            let _ = writeln!(text, "  {}: {{{}}}", speed.key(), stated.collect::<Vec<_>>().join(", "));
        }
        text
    }

    /// Returns the colours of the shapes of a body; empty if it has none.
    fn colours_of(&self, body: &RecipeBody) -> &[Option<[f64; 3]>] {
        self.colours.get(&body.name).map_or(&[], Vec::as_slice)
    }

    fn write_place(&self, place: &PlaceGoal, text: &mut String) {
        let quoted = |name: &str| serde_json::Value::from(name);
        let _ = writeln!(text, "  - name: {}", quoted(&place.name));
        match &place.spot {
            PlaceRegion::Surface { on, pose, size_m } => {
                let _ = writeln!(text, "    on: {}", quoted(on));
                if let Some(pose) = pose_text(pose) {
                    let _ = writeln!(text, "    pose: {pose}");
                }
                let _ = writeln!(text, "    size: {}", list(size_m));
            }
            PlaceRegion::Target(pose) => {
                // The pose is that of the target's body, as in the target entry, not of its first shape.
                let first = self.target.as_ref().and_then(|target| target.shapes.first());
                let body_from_first = first.map_or_else(Pose::identity, |(pose, _)| *pose);
                let pose = pose_text(&(pose * body_from_first.inverse()));
                let _ = writeln!(text, "    target_pose: {}", pose.unwrap_or_else(|| "{}".to_owned()));
            }
        }
    }
}

/// Returns the text of configurations (one value per joint, m or rad), one per line.
pub fn configurations_text(configurations: &[Vec<f64>]) -> String {
    let line = |q: &Vec<f64>| q.iter().map(f64::to_string).collect::<Vec<_>>().join(",") + "\n";
    configurations.iter().map(line).collect()
}

fn object_folder(body: &RecipeBody, shape: usize) -> String {
    format!("{OBJECTS}/{}-{shape}", file_name(&body.name))
}

fn mesh_file(body: &RecipeBody, shape: usize) -> String {
    format!("{MESHES}/{}-{shape}.obj", file_name(&body.name))
}

impl RecipeBody {
    fn write(&self, text: &mut String, [first, rest]: [&str; 2], colours: &[Option<[f64; 3]>]) {
        // A JSON string is a YAML string.
        let name = serde_json::Value::from(self.name.as_str());
        let _ = writeln!(text, "{first}name: {name}");
        if let Some(pose) = pose_text(&self.scene_from_body) {
            let _ = writeln!(text, "{rest}pose: {pose}");
        }
        let _ = writeln!(text, "{rest}shapes:");
        for (index, (body_from_shape, shape)) in self.shapes.iter().enumerate() {
            let _ = writeln!(text, "{rest}  - {}", self.shape_text(index, shape));
            if let Some(pose) = pose_text(body_from_shape) {
                let _ = writeln!(text, "{rest}    pose: {pose}");
            }
            if let Some(Some(colour)) = colours.get(index) {
                let _ = writeln!(text, "{rest}    colour: {}", list(colour));
            }
        }
    }

    fn shape_text(&self, index: usize, shape: &RecipeShape) -> String {
        let round = |kind: &str, radius_m: &f64, length_m: &f64| {
            format!("{kind}: {{radius: {}, length: {}}}", plain(*radius_m), plain(*length_m))
        };
        match shape {
            RecipeShape::Cuboid(size) => format!("box: {{size: {}}}", list(size.as_slice())),
            RecipeShape::Sphere(radius_m) => format!("sphere: {{radius: {}}}", plain(*radius_m)),
            RecipeShape::Cylinder(radius_m, length_m) => round("cylinder", radius_m, length_m),
            RecipeShape::Capsule(radius_m, length_m) => round("capsule", radius_m, length_m),
            RecipeShape::Object(source) => match source.builtin_name() {
                Some(name) => format!("object: {name}"),
                None => format!("object: {}", object_folder(self, index)),
            },
            RecipeShape::Mesh(_) => format!("mesh: {{file: {}}}", mesh_file(self, index)),
            RecipeShape::Hull(_) => format!("hull: {{file: {}}}", mesh_file(self, index)),
        }
    }
}

/// Returns the text of a pose without its identity components; `None` for the identity.
fn pose_text(pose: &Pose) -> Option<String> {
    let mut keys = Vec::new();
    let position = list(pose.translation.vector.as_slice());
    if position != "[0, 0, 0]" {
        keys.push(format!("position: {position}"));
    }
    if pose.rotation.angle_to(&Rotation::identity()) > LEAST_TURN_RAD {
        keys.push(format!("quaternion_xyzw: {}", list(pose.rotation.coords.as_slice())));
    }
    (!keys.is_empty()).then(|| format!("{{{}}}", keys.join(", ")))
}

fn list(numbers: &[f64]) -> String {
    format!("[{}]", numbers.iter().map(|number| plain(*number).to_string()).collect::<Vec<_>>().join(", "))
}

/// Removes the rounding errors of frame changes: differences of a picometre or picoradian are insignificant.
fn plain(number: f64) -> f64 {
    const STEPS: f64 = 1e12;
    // Adding zero turns −0 into 0.
    if number.abs() < 1e3 { (number * STEPS).round() / STEPS + 0.0 } else { number }
}

/// Rotation below which a pose counts as unrotated, in radians: rounding.
const LEAST_TURN_RAD: f64 = 1e-12;

/// Returns the name with characters replaced that are unsuitable for a file name.
pub(crate) fn file_name(name: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "_-.".contains(c);
    name.chars().map(|c| if is_plain(c) { c } else { '_' }).collect()
}

fn write_tilt(text: &mut String, indent: &str, tilt_rad: Option<f64>) {
    let _ = tilt_rad.map(|tilt_rad| writeln!(text, "{indent}upright_deg: {}", plain(tilt_rad.to_degrees())));
}

fn write_bound(text: &mut String, bound: &ToolBound) {
    let _ = writeln!(text, "  - name: {}", serde_json::Value::from(bound.name.as_str()));
    if let Some(link) = &bound.link {
        let _ = writeln!(text, "    link: {}", serde_json::Value::from(link.as_str()));
    }
    let mut lines = |point: &Point, middle: &Pose, size: String| {
        let pose = pose_text(middle).unwrap_or_else(|| "{}".to_owned());
        let point = list(point.coords.as_slice());
        let _ = writeln!(text, "    point: {point}\n    pose: {pose}\n    {size}");
    };
    match &bound.region {
        ToolRegion::Box { point_in_link, world_from_box, half_m } => {
            lines(point_in_link, world_from_box, format!("size: {}", list((half_m * 2.0).as_slice())));
        }
        ToolRegion::Ball { point_in_link, center, radius_m } => {
            let middle = Pose::translation(center.x, center.y, center.z);
            lines(point_in_link, &middle, format!("radius: {}", plain(*radius_m)));
        }
        ToolRegion::Cone { axis_in_link, toward, most_rad } => {
            let [axis, toward] = [axis_in_link, toward].map(|direction| list(direction.as_slice()));
            let degrees = plain(most_rad.to_degrees());
            let _ = writeln!(text, "    axis: {axis}\n    toward: {toward}\n    within_deg: {degrees}");
        }
    }
}

fn write_physics(text: &mut String, indent: &str, physics: TargetPhysics) {
    let TargetPhysics { mass_kg, friction, rolling_m } = physics;
    let friction = friction.map(
        |Friction { low, high }| {
            if low < high { format!("[{low}, {high}]") } else { low.to_string() }
        },
    );
    let text_of = |number: Option<f64>| number.map(|number| number.to_string());
    for (key, value) in
        [("mass_kg", text_of(mass_kg)), ("friction", friction), ("rolling_m", text_of(rolling_m))]
    {
        let _ = value.map(|value| writeln!(text, "{indent}{key}: {value}"));
    }
}
