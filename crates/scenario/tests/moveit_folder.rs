//! Problem in `MoveIt`'s files with every key of every message, in a folder whose files can be modified.

use std::fs;
use std::path::PathBuf;

use cranny_scenario::{MoveItOptions, MoveItProblem, ScenarioError};

pub const URDF: &str = r#"<robot name="bot">
<link name="base_link"><collision><origin xyz="0 0 0.05"/><geometry><cylinder length="0.1" radius="0.08"/></geometry></collision></link>
<link name="arm"><collision><origin xyz="0 0 0.3"/><geometry><box size="0.05 0.05 0.5"/></geometry></collision></link>
<link name="fore"><collision><origin xyz="0 0 0.15"/><geometry><box size="0.04 0.04 0.28"/></geometry></collision></link>
<link name="flag"><collision><origin xyz="0.2 0 0"/><geometry><box size="0.1 0.02 0.02"/></geometry></collision></link>
<link name="slide"/>
<joint name="j1" type="revolute"><origin xyz="0 0 0.1"/><parent link="base_link"/><child link="arm"/><axis xyz="0 1 0"/><limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
<joint name="j2" type="revolute"><origin xyz="0 0 0.57"/><parent link="arm"/><child link="fore"/><axis xyz="0 1 0"/><limit lower="-2.6" upper="2.6" velocity="1" effort="1"/></joint>
<joint name="roll" type="continuous"><origin xyz="0 0 0.33"/><parent link="fore"/><child link="flag"/><axis xyz="0 0 1"/><limit velocity="1" effort="1"/></joint>
<joint name="lower" type="prismatic"><parent link="fore"/><child link="slide"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" velocity="1" effort="1"/><mimic joint="j1" multiplier="0.5"/></joint>
</robot>"#;

pub const SRDF: &str = r#"<robot name="bot"><virtual_joint name="stand" type="floating" parent_frame="world" child_link="base_link"/>
<group name="arm"><joint name="j1"/><joint name="j2"/></group></robot>"#;

/// Scene with every key of its messages.
pub const SCENE: &str = "name: ''
robot_model_name: bot
robot_state:
  joint_state: {name: [j1, j2, roll], position: [0, 0, 0], velocity: [0, 0, 0], effort: [], header: {seq: 0, stamp: 0, frame_id: base_link}}
  multi_dof_joint_state: {header: {frame_id: world}, joint_names: [stand], transforms: [{translation: [0, 0, 0], rotation: [0, 0, 0, 1]}], twist: [], wrench: []}
  attached_collision_objects: []
  is_diff: false
fixed_frame_transforms:
  - {header: {frame_id: world}, child_frame_id: shelf, transform: {translation: [0, 0, 1], rotation: [0, 0, 0, 1]}}
allowed_collision_matrix:
  entry_names: [base_link, arm]
  entry_values: [{enabled: [false, true]}, [true, false]]
  default_entry_names: []
  default_entry_values: []
link_padding: [{link_name: arm, padding: 0}]
link_scale: [{link_name: arm, scale: 1}]
object_colors: [{id: wall, color: {r: 1, g: 0, b: 0, a: 1}}]
world:
  collision_objects:
    - header: {frame_id: world}
      pose: {position: [0.4, 0, 0.5], orientation: [0, 0, 0, 1]}
      id: wall
      type: {key: '', db: ''}
      primitives: [{type: box, dimensions: [0.02, 1.0, 1.2], polygon: {points: []}}]
      primitive_poses: [{position: [0, 0, 0], orientation: [0, 0, 0, 1]}]
      meshes: [{vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], triangles: [{vertex_indices: [0, 2, 1]}, [0, 1, 3], [0, 3, 2], [1, 2, 3]]}]
      mesh_poses: [{position: {x: 9, y: 0, z: 0}, orientation: {x: 0, y: 0, z: 0, w: 1}}]
      planes: []
      plane_poses: []
      subframe_names: []
      subframe_poses: []
      operation: 0
  octomap: {header: {}, origin: {}, octomap: {header: {}, binary: false, id: '', resolution: 0, data: []}}
is_diff: false
";

/// Request with every key of its messages.
pub const REQUEST: &str = "workspace_parameters: {header: {frame_id: world}}
start_state:
  joint_state: {name: [j1, j2], position: [0, 0]}
  is_diff: true
goal_constraints:
  - name: ''
    joint_constraints:
      - {joint_name: j1, position: 0.1, tolerance_above: 0.01, tolerance_below: 0.01, weight: 1}
      - {joint_name: j2, position: 0.3}
    position_constraints: []
    orientation_constraints: []
    visibility_constraints: []
path_constraints: {name: '', joint_constraints: []}
trajectory_constraints: {constraints: []}
reference_trajectories: []
pipeline_id: ompl
planner_id: ''
group_name: arm
num_planning_attempts: 1
allowed_planning_time: 5
max_velocity_scaling_factor: 0.5
max_acceleration_scaling_factor: 0
cartesian_speed_end_effector_link: ''
cartesian_speed_limited_link: ''
max_cartesian_speed: 0
";

pub struct Folder(tempfile::TempDir);

impl Folder {
    pub fn new() -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        for (file, text) in
            [("bot.urdf", URDF), ("bot.srdf", SRDF), ("scene.yaml", SCENE), ("request.yaml", REQUEST)]
        {
            folder.write(file, text);
        }
        folder
    }

    pub fn path(&self, file: &str) -> PathBuf {
        self.0.path().join(file)
    }

    pub fn write(&self, file: &str, text: &str) -> &Self {
        fs::create_dir_all(self.path(file).parent().unwrap()).unwrap();
        fs::write(self.path(file), text).unwrap();
        self
    }

    pub fn changed(&self, file: &str, from: &str, to: &str) -> &Self {
        let text = fs::read_to_string(self.path(file)).unwrap();
        assert!(text.contains(from), "{from}");
        self.write(file, &text.replacen(from, to, 1))
    }

    pub fn open(&self) -> Result<MoveItProblem, ScenarioError> {
        self.open_scene("scene.yaml")
    }

    pub fn open_scene(&self, scene: &str) -> Result<MoveItProblem, ScenarioError> {
        let options = MoveItOptions { robot: Some(self.path("bot.urdf")), ..MoveItOptions::default() };
        MoveItProblem::open(&self.path(scene), &self.path("request.yaml"), &options)
    }

    pub fn fault(&self) -> String {
        self.open().unwrap_err().to_string()
    }

    pub fn deviations(&self) -> Vec<String> {
        self.open().unwrap().deviations.iter().map(ToString::to_string).collect()
    }
}
