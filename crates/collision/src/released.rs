use std::sync::Arc;

use cranny_robot::{LinkFrames, Robot};
use cranny_shape::Surface;
use cranny_spatial::Pose;

use crate::body::link_body::LinkBody;
use crate::{CollisionError, World};

/// Collision check of the released planners, for comparison only (README, "What solved means").
///
/// It checks triangles of links against triangles of obstacles, surface against surface, at single configurations, only for
/// links on the chain from the root to the tip: hence no fingers, and no self-collision. Instead of a floor, the origins of
/// certain link frames must stay above a height.
#[derive(Clone, Debug)]
pub struct ReleasedCheck {
    robot: Arc<Robot>,
    links: Vec<(usize, Pose, Surface)>,
    obstacles: Vec<(Pose, Surface)>,
    floor_links: Vec<usize>,
    floor_height_m: f64,
}

/// Buffers for the computations of one thread with a [`ReleasedCheck`].
#[derive(Clone, Debug)]
pub struct ReleasedScratch {
    frames: LinkFrames,
}

impl ReleasedScratch {
    /// Returns the link frames of the configuration checked last.
    pub fn frames(&self) -> &LinkFrames {
        &self.frames
    }
}

impl ReleasedCheck {
    /// Creates a check of the links on the chain to the tip against `obstacles` (surfaces in the planning frame).
    ///
    /// A link with meshes is checked by their triangles, any other by one box around all its shapes. The origins of
    /// `floor_links` (by link index) must stay at or above `floor_height_m` (m).
    ///
    /// # Errors
    /// [`CollisionError::Link`] for a link whose triangles refer to missing vertices.
    pub fn new(
        robot: Arc<Robot>,
        obstacles: Vec<(Pose, Surface)>,
        floor_links: Vec<usize>,
        floor_height_m: f64,
    ) -> Result<Self, CollisionError> {
        let mut chain = vec![robot.tip()];
        while let Some(parent) = robot.links()[*chain.last().unwrap_or(&0)].parent {
            chain.push(parent);
        }
        let mut links = Vec::new();
        for &link in &chain {
            let shapes = &robot.links()[link].collisions;
            let soups: Option<Vec<_>> = shapes.iter().map(|shape| shape.soup.as_ref()).collect();
            if let Some(soups) = soups {
                for (shape, soup) in shapes.iter().zip(soups) {
                    let name = || robot.links()[link].name.clone();
                    let surface =
                        Surface::new(soup).map_err(|source| CollisionError::Link { link: name(), source })?;
                    links.push((link, shape.link_from_shape, surface));
                }
            } else {
                let boxed = LinkBody::new(&robot, link).map(|body| Surface::of_box(&body.bounds.aabb));
                links.extend(boxed.map(|surface| (link, Pose::identity(), surface)));
            }
        }
        Ok(Self { robot, links, obstacles, floor_links, floor_height_m })
    }

    /// Returns the surfaces of all bodies of a world, each with its `world_from_surface`; a solid that is no cuboid is replaced
    /// by its bounding box.
    pub fn surfaces_of(world: &World) -> Vec<(Pose, Surface)> {
        world
            .bodies()
            .iter()
            .flat_map(|body| &body.parts)
            .filter(|part| !part.solid.is_half_space())
            .map(|part| (part.world_from_solid, Surface::of_box(part.solid.aabb())))
            .collect()
    }

    /// Returns the checked robot.
    pub fn robot(&self) -> &Arc<Robot> {
        &self.robot
    }

    /// Creates a scratch, to be reused between calls.
    pub fn scratch(&self) -> ReleasedScratch {
        ReleasedScratch { frames: self.robot.frames() }
    }

    /// Returns true if the released check accepts `q` (m, rad; one per joint): limits, heights, surfaces.
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn is_free(&self, q: &[f64], scratch: &mut ReleasedScratch) -> bool {
        self.robot.within_limits(q) && {
            self.robot.forward_kinematics(q, &mut scratch.frames);
            self.holds(&scratch.frames)
        }
    }

    /// Returns true if the released check accepts these link frames; joint limits are not checked.
    pub fn holds(&self, frames: &LinkFrames) -> bool {
        self.floor_links.iter().all(|&link| frames.link(link).translation.z >= self.floor_height_m)
            && !self.links.iter().any(|(link, link_from_shape, surface)| {
                let world_from_shape = frames.link(*link) * link_from_shape;
                self.obstacles.iter().any(|(world_from_obstacle, obstacle)| {
                    surface.touches(&world_from_shape, obstacle, world_from_obstacle)
                })
            })
    }
}
