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
    /// Names of the views without a usable pixel.
    pub blind: Vec<String>,
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
    /// Side of the smallest cells around the target, in metres.
    pub fine_m: f64,
    /// Region that is mapped, in the planning frame; `None`: around robot, target and the space between them.
    pub region: Option<Aabb>,
    /// Distance from the robot at its start within which unseen space counts as free, in metres.
    pub robot_reach_m: f64,
    /// The same for the floor.
    pub floor_reach_m: f64,
    /// Error of the poses of the target and of known obstacles, in metres: measured surfaces and unseen cells within it are theirs.
    pub tolerance_m: f64,
}

impl Default for SeenOptions {
    /// Cells as wide as the details that a camera of 320 × 240 pixels resolves at 1.5 m; the robot's shell covers the noise of a camera in
    /// front of its links.
    fn default() -> Self {
        Self {
            unseen: Unseen::Solid,
            cell_m: 0.02,
            fine_m: 0.005,
            region: None,
            robot_reach_m: 0.1,
            floor_reach_m: 0.0,
            tolerance_m: 0.002,
        }
    }
}
