use cranny_collision::World;
use cranny_robot::{Link, Robot};

use crate::{Scenario, mesh_repairs};

/// From the pads of a hand at a grasp to what it grasps there is no way farther than this, in metres: half of what the
/// widest two-finger hands open.
const FARTHEST_GRASP_M: f64 = 0.1;

/// What whoever opens a robot among bodies should know of them: meshes that had to be repaired, and links that are seen
/// and not checked, because the URDF says how they look and not what they collide with.
pub fn model_notes(robot: &Robot, world: &World) -> Vec<String> {
    let is_unseen = |link: &&Link| link.collisions.is_empty() && !link.visuals.is_empty();
    let unseen = robot.links().iter().filter(is_unseen).map(|link| {
        format!(
            "link '{}' has a <visual> and no <collision>: no proof keeps it from touching anything",
            link.name
        )
    });
    mesh_repairs(robot, world).into_iter().chain(unseen).collect()
}

impl Scenario {
    /// What is wrong with the set of grasps, if it is of another place than the target: none of them has anything of it
    /// between the pads.
    pub fn misplaced_grasps(&self) -> Option<String> {
        let target = &self.world.bodies()[self.target?];
        let distance_m = |grasp: &cranny_grasp::Grasp| {
            let point = cranny_spatial::Point::from(grasp.world_from_gripper.translation.vector);
            let to_part = |part: &cranny_collision::Part| {
                let world_from_solid = &part.world_from_solid;
                part.solid.aabb().distance_to(&world_from_solid.inverse_transform_point(&point))
            };
            target.parts.iter().map(to_part).fold(f64::INFINITY, f64::min)
        };
        let nearest_m = self.grasps.grasps().iter().map(distance_m).reduce(f64::min)?;
        (nearest_m > FARTHEST_GRASP_M).then(|| {
            let millimetres = nearest_m * 1e3;
            format!(
                "none of the {} grasps is at {}, the nearest {millimetres:.0} mm away: they are of another place; \
                 `cranny grasps sample` makes new ones",
                self.grasps.len(),
                target.name
            )
        })
    }
}
