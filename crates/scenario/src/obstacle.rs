use cranny_collision::{Body, Part};
use cranny_shape::Solid;
use cranny_spatial::{Pose, Vector};

use crate::ScenarioError;

/// Parametric obstacle made of boxes; all sizes in metres. The frame has its origin on the floor at a corner, x along the
/// width, y along the depth, z up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Obstacle {
    /// Two legs on the floor and a slab of the same thickness on top of them: a table, an open shelf.
    InvertedU {
        /// Thickness of legs and slab.
        thickness_m: f64,
        /// Outer width, along x.
        width_m: f64,
        /// Depth, along y.
        depth_m: f64,
        /// Height of the legs, without the slab.
        leg_height_m: f64,
    },
    /// Cuboid on the floor: a wall segment, a pedestal.
    Block {
        /// Width, along x.
        width_m: f64,
        /// Depth, along y.
        depth_m: f64,
        /// Height, along z.
        height_m: f64,
    },
}

impl Obstacle {
    /// Table of the paper.
    pub const TABLE: Self =
        Self::InvertedU { thickness_m: 0.1, width_m: 2.0, depth_m: 0.8, leg_height_m: 0.4 };

    /// Open shelf of the paper, which stands on a table.
    pub const SHELF: Self =
        Self::InvertedU { thickness_m: 0.03, width_m: 0.46, depth_m: 0.5, leg_height_m: 0.4 };

    /// Wall segment of the paper.
    pub const WALL_SEGMENT: Self = Self::Block { width_m: 0.8, depth_m: 0.1, height_m: 1.0 };

    /// Pedestal of the paper.
    pub const PEDESTAL: Self = Self::Block { width_m: 0.4, depth_m: 0.4, height_m: 0.5 };

    /// Returns the gate of the paper: 2 m wide, with an opening as high as it is wide; the legs fill the remaining width.
    pub fn gate(opening_m: f64) -> Self {
        const WIDTH_M: f64 = 2.0;
        Self::InvertedU {
            thickness_m: 0.5 * (WIDTH_M - opening_m),
            width_m: WIDTH_M,
            depth_m: 0.1,
            leg_height_m: opening_m,
        }
    }

    /// Returns the boxes: centre in the obstacle's frame, and size, in metres.
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

    /// Returns the obstacle as a body of a world.
    ///
    /// # Errors
    /// [`ScenarioError::ShapeFile`] for an invalid size, or legs without space between them.
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
        Ok(Body { name: name.to_owned(), parts, tilt_rad: None, center_of_mass: None })
    }
}
