use std::collections::HashMap;

use cranny_spatial::Pose;

use crate::Grasp;

/// Filter that detects grasps equal to an earlier one or its twin.
#[derive(Default)]
pub(crate) struct TwinFilter {
    cells: HashMap<[i64; 3], Vec<Pose>>,
}

/// Distance below which grasps are equal, in metres: a tenth of what counts as exact.
const SAME_M: f64 = 1e-4;

/// Angle below which grasps are equal, in radians.
const SAME_RAD: f64 = 0.1 * cranny_spatial::EXACT_ROTATION_RAD;

impl TwinFilter {
    pub fn is_new(&mut self, grasp: &Grasp) -> bool {
        let origin = grasp.world_from_gripper.translation.vector;
        #[allow(
            clippy::cast_possible_truncation,
            reason = "objects are within a few metres, so a cell number stays far below the limits of i64"
        )]
        let [x, y, z] = [origin.x, origin.y, origin.z].map(|x| (x / SAME_M).floor() as i64);
        let around = (-1..=1).flat_map(|i| (-1..=1).flat_map(move |j| (-1..=1).map(move |k| [i, j, k])));
        let is_known = around.filter_map(|[i, j, k]| self.cells.get(&[x + i, y + j, z + k])).flatten().any(
            |known: &Pose| {
                let difference = grasp.difference(known);
                difference.translation_m <= SAME_M && difference.rotation_rad <= SAME_RAD
            },
        );
        if !is_known {
            self.cells.entry([x, y, z]).or_default().push(grasp.world_from_gripper);
        }
        !is_known
    }
}
