use std::sync::Arc;

use cranny_sense::{SeenMap, SensorModel, Unseen};
use cranny_shape::Aabb;

/// Space that cameras have seen, as obstacles of a scenario.
#[derive(Clone, Debug)]
pub struct SeenSpace {
    /// Map of the space.
    pub map: Arc<SeenMap>,
    /// Sensors of the views, in order.
    pub sensors: Vec<SensorModel>,
    /// Options with which the map was made.
    pub options: SeenOptions,
}

/// Options of a map of the space that cameras have seen.
#[derive(Clone, Debug, PartialEq)]
pub struct SeenOptions {
    /// Treatment of unseen space.
    pub unseen: Unseen,
    /// Side of the smallest cells, in metres.
    pub cell_m: f64,
    /// Region that is mapped, in the planning frame; `None`: around robot, target and the space between them.
    pub region: Option<Aabb>,
    /// Distance from the robot at its start within which unseen space counts as free, in metres.
    pub robot_reach_m: f64,
    /// The same for the floor.
    pub floor_reach_m: f64,
    /// Error of the pose of the target, in metres: measured surfaces and unseen cells within it are those of the target.
    pub target_tolerance_m: f64,
}

impl Default for SeenOptions {
    /// Cells of 1 cm; the robot's shell covers the noise of a camera in front of its links.
    fn default() -> Self {
        Self {
            unseen: Unseen::Solid,
            cell_m: 0.01,
            region: None,
            robot_reach_m: 0.06,
            floor_reach_m: 0.06,
            target_tolerance_m: 0.002,
        }
    }
}
