use cranny_collision::{Body, Part};
use cranny_shape::Solid;
use cranny_spatial::{Pose, Vector};

use crate::ScenarioError;

/// A parametric obstacle, made of boxes; all sizes in metres. Its frame has its origin on the floor at a
/// corner, x along its width, y along its depth, z up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Obstacle {
    /// Two legs that stand on the floor and a slab, as thick as the legs, that lies on them: a table, an open
    /// shelf.
    InvertedU {
        /// Of legs and slab.
        thickness_m: f64,
        /// Outside, along x.
        width_m: f64,
        /// Along y.
        depth_m: f64,
        /// Of the legs, without the slab.
        leg_height_m: f64,
    },
    /// A cuboid that stands on the floor: a segment of a wall, a pedestal.
    Block {
        /// Along x.
        width_m: f64,
        /// Along y.
        depth_m: f64,
        /// Along z.
        height_m: f64,
    },
}

impl Obstacle {
    /// The paper's table.
    pub const TABLE: Self =
        Self::InvertedU { thickness_m: 0.1, width_m: 2.0, depth_m: 0.8, leg_height_m: 0.4 };

    /// The paper's open shelf, which stands on a table.
    pub const SHELF: Self =
        Self::InvertedU { thickness_m: 0.03, width_m: 0.46, depth_m: 0.5, leg_height_m: 0.4 };

    /// The paper's segment of a wall.
    pub const WALL_SEGMENT: Self = Self::Block { width_m: 0.8, depth_m: 0.1, height_m: 1.0 };

    /// The paper's pedestal.
    pub const PEDESTAL: Self = Self::Block { width_m: 0.4, depth_m: 0.4, height_m: 0.5 };

    /// The paper's gate: 2 m wide, its opening as high as it is wide, its legs filling the rest.
    pub fn gate(opening_m: f64) -> Self {
        const WIDTH_M: f64 = 2.0;
        Self::InvertedU {
            thickness_m: 0.5 * (WIDTH_M - opening_m),
            width_m: WIDTH_M,
            depth_m: 0.1,
            leg_height_m: opening_m,
        }
    }

    /// The boxes: where each one's middle is in the obstacle's frame, and its size.
    pub fn boxes(&self) -> Vec<(Vector, Vector)> {
        let placed = |low: Vector, size: Vector| (low + size * 0.5, size);
        match *self {
            Self::InvertedU { thickness_m, width_m, depth_m, leg_height_m } => {
                let leg = Vector::new(thickness_m, depth_m, leg_height_m);
                vec![
                    placed(Vector::zeros(), leg),
                    placed(Vector::new(width_m - thickness_m, 0.0, 0.0), leg),
                    placed(Vector::new(0.0, 0.0, leg_height_m), Vector::new(width_m, depth_m, thickness_m)),
                ]
            }
            Self::Block { width_m, depth_m, height_m } => {
                vec![placed(Vector::zeros(), Vector::new(width_m, depth_m, height_m))]
            }
        }
    }

    /// The obstacle as a body of a world.
    ///
    /// # Errors
    /// [`ScenarioError::ShapeFile`] for a size that is none, or legs that leave no room between them.
    pub fn body(&self, name: &str, world_from_obstacle: &Pose) -> Result<Body, ScenarioError> {
        if let Self::InvertedU { thickness_m, width_m, .. } = *self
            && 2.0 * thickness_m >= width_m
        {
            let (what, value) = ("the room between two legs", width_m - 2.0 * thickness_m);
            return Err(cranny_shape::ShapeError::Size { what, value }.into());
        }
        let part = |(middle, size): (Vector, Vector)| -> Result<Part, ScenarioError> {
            Ok(Part {
                world_from_solid: world_from_obstacle * Pose::translation(middle.x, middle.y, middle.z),
                solid: Solid::cuboid(size * 0.5)?,
            })
        };
        let parts = self.boxes().into_iter().map(part).collect::<Result<_, _>>()?;
        Ok(Body { name: name.to_owned(), parts, tilt_rad: None })
    }
}
