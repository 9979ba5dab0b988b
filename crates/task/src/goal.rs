use cranny_grasp::GraspSet;

use crate::{Moved, Region};

/// Goal of a path.
#[derive(Clone, Debug)]
pub enum Goal {
    /// Any of these grasps; empty for a problem without a set, which has a [`Problem::grasp_measure`](crate::Problem::grasp_measure).
    Grasps(GraspSet),
    /// Any of these configurations (m, rad; one value per joint).
    Configurations(Vec<Vec<f64>>),
    /// A pose of the gripper frame in any of these regions, within 1 mm and 1°.
    Regions(Vec<Region>),
}

impl Goal {
    /// Returns true for a goal without elements.
    pub(crate) fn is_empty(&self) -> bool {
        match self {
            Self::Grasps(grasps) => grasps.is_empty(),
            Self::Configurations(goals) => goals.is_empty(),
            Self::Regions(regions) => regions.is_empty(),
        }
    }

    /// Returns the fault, in words, of its regions.
    pub(crate) fn region_fault(&self) -> Option<String> {
        let Self::Regions(regions) = self else { return None };
        let of_object = regions.iter().any(|region| region.moved == Moved::Object);
        let of_object = of_object.then(|| "a region of the object needs an object in the hand".to_owned());
        of_object.or_else(|| regions.iter().find_map(Region::fault))
    }
}
