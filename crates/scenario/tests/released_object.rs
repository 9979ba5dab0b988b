//! Object of a released scenario: its scan, its pose, and its released grasps in its own frame.

use std::path::Path;

use cranny_grasp::{Grasp, SamplerSettings, pose_of_rows, read_csv};
use cranny_scenario::panda_hand;
use cranny_shape::TriangleSoup;
use cranny_spatial::{Pose, Rotation, Vector};
use serde::Deserialize;

/// Any error.
pub type Failure = Box<dyn std::error::Error>;

/// Number of grasps that are kept for an object.
pub const KEPT: usize = 2000;

/// Number of grasps from which those are selected: ten times as many, as in `cranny grasps sample`.
pub const CANDIDATES: usize = 20_000;

#[derive(Deserialize)]
struct Scene {
    objects: Vec<Placed>,
}

#[derive(Deserialize)]
struct Placed {
    object_type: String,
    pose: [[f64; 4]; 4],
}

/// Object of a released scenario.
pub struct ReleasedObject {
    /// Name of the object.
    pub object: String,
    /// Scan of the object, in its own frame.
    pub mesh: TriangleSoup,
    /// Pose of the object in the scene.
    pub scene_from_object: Pose,
    /// Released grasps, in the object's frame.
    pub grasps: Vec<Grasp>,
}

impl ReleasedObject {
    /// Opens the object of scenario `id` below `data`, the folder `jogramop`.
    pub fn open(data: &Path, id: &str) -> Result<Self, Failure> {
        let folder = data.join("scenarios").join(id);
        let scene: Scene = serde_saphyr::from_str(&std::fs::read_to_string(folder.join("scene.yaml"))?)?;
        let [placed] = &scene.objects[..] else { return Err("there is not one object to grasp".into()) };
        let rows: [f64; 16] = std::array::from_fn(|index| placed.pose[index / 4][index % 4]);
        let scene_from_object = pose_of_rows(&rows)?;
        let quarter_turn = Rotation::from_axis_angle(&Vector::z_axis(), std::f64::consts::FRAC_PI_2);
        let scene_from_planning = Pose::from_parts(Vector::new(1.0, 0.0, 0.05).into(), quarter_turn);
        let object_from_planning = scene_from_object.inverse() * scene_from_planning;
        let in_object = |grasp: &Grasp| Grasp {
            world_from_gripper: object_from_planning * grasp.world_from_gripper,
            ..*grasp
        };
        let mesh = data.join(format!("object_library/meshes/{}.obj", placed.object_type));
        Ok(Self {
            object: placed.object_type.clone(),
            mesh: TriangleSoup::load(&mesh, Vector::repeat(1.0))?,
            scene_from_object,
            grasps: read_csv(&folder.join("export/grasps.csv"))?.grasps().iter().map(in_object).collect(),
        })
    }

    /// Returns settings to sample grasps like the released ones: from the side or from above, twelve approaches from level on,
    /// open pads above the support of the object, the object no deeper between the fingers than to the palm, friction 0.24.
    pub fn settings(&self, count: usize, seed: u64) -> SamplerSettings {
        let up = self.scene_from_object.rotation.inverse() * Vector::z();
        let heights = self.mesh.vertices.iter().map(|vertex| vertex.coords.dot(&up));
        SamplerSettings {
            count,
            up,
            steepest_rise_rad: 0.0,
            ground_m: Some(heights.fold(f64::INFINITY, f64::min)),
            finger_depth_m: Some(panda_hand().expect("the built-in hand").finger_depth_m),
            seed,
            ..SamplerSettings::default()
        }
    }
}
