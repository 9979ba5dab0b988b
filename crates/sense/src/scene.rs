use cranny_collision::{Cell, Part, World};
use cranny_robot::Robot;
use cranny_shape::Solid;
use cranny_spatial::Pose;
use serde::{Deserialize, Serialize};

use crate::SenseError;
use crate::rendering::surface::Surface;

/// Solids that cameras see, each part of a numbered segment.
#[derive(Clone, Debug, Default)]
pub struct SensedScene {
    segments: Vec<Segment>,
    /// Solids with the index of their segment, in the order of the segments.
    surfaces: Vec<(u16, Surface)>,
}

/// Body that segment images number.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Segment {
    /// Name of the body or the robot.
    pub name: String,
    /// Kind of the segment.
    pub kind: SegmentKind,
}

/// Kinds of segments.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum SegmentKind {
    /// A body of the world.
    Body,
    /// All links of the robot.
    Robot,
}

/// Maximum number of segments; 0 is no segment.
const MOST_SEGMENTS: usize = u16::MAX as usize;

impl SensedScene {
    /// Returns the bodies of a world as segments in their order.
    ///
    /// # Errors
    /// [`SenseError::TooManyBodies`], [`SenseError::NoSurface`].
    pub fn of_world(world: &World) -> Result<Self, SenseError> {
        let mut scene = Self::default();
        for body in world.bodies() {
            let solids = body.parts.iter().map(|Part { world_from_solid, solid }| (*world_from_solid, solid));
            scene.add(Segment { name: body.name.clone(), kind: SegmentKind::Body }, solids)?;
        }
        Ok(scene)
    }

    /// Returns the bodies of the world of a cell, and its robot at `q` (m, rad; one per joint) as the last segment.
    ///
    /// # Errors
    /// As [`Self::of_world`].
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn of_cell(cell: &Cell, q: &[f64]) -> Result<Self, SenseError> {
        Self::of_world(cell.world())?.with_robot(cell.robot(), q)
    }

    /// Returns this scene with the collision solids of a robot at `q` (m, rad; one per joint) as the last segment.
    ///
    /// # Errors
    /// As [`Self::of_world`].
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn with_robot(mut self, robot: &Robot, q: &[f64]) -> Result<Self, SenseError> {
        let frames = robot.frames_at(q);
        let solids = robot.links().iter().enumerate().flat_map(|(index, link)| {
            let world_from_link = *frames.link(index);
            link.collisions.iter().map(move |shape| (world_from_link * shape.link_from_shape, &shape.solid))
        });
        self.add(Segment { name: "robot".to_owned(), kind: SegmentKind::Robot }, solids)?;
        Ok(self)
    }

    /// Adds a segment of solids with their poses in the planning frame.
    ///
    /// # Errors
    /// As [`Self::of_world`].
    pub fn add<'a>(
        &mut self,
        segment: Segment,
        solids: impl IntoIterator<Item = (Pose, &'a Solid)>,
    ) -> Result<(), SenseError> {
        let too_many = |actual| SenseError::TooManyBodies { most: MOST_SEGMENTS, actual };
        let number = self.segments.len() + 1;
        let number = u16::try_from(number).map_err(|_| too_many(number))?;
        let pieces = solids.into_iter().flat_map(|(world_from_solid, solid)| {
            solid.pieces().into_iter().map(move |(pose, piece)| (world_from_solid * pose, piece))
        });
        for (world_from_solid, solid) in pieces {
            let surface = Surface::new(world_from_solid, &solid)
                .ok_or_else(|| SenseError::NoSurface { name: segment.name.clone() })?;
            self.surfaces.push((number, surface));
        }
        self.segments.push(segment);
        Ok(())
    }

    /// Returns the segments; the first has number 1 in a segment image.
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// Returns the number of the segment of a body in segment images.
    pub fn number_of_body(&self, name: &str) -> Option<u16> {
        let is_meant = |segment: &Segment| segment.kind == SegmentKind::Body && segment.name == name;
        let index = self.segments.iter().position(is_meant)?;
        u16::try_from(index + 1).ok()
    }

    pub(crate) fn surfaces(&self) -> impl Iterator<Item = (u16, &Surface)> {
        self.surfaces.iter().map(|(number, surface)| (*number, surface))
    }

    /// Returns a scene with the solids of one segment alone, under its number.
    pub(crate) fn only(&self, number: u16) -> Self {
        let surfaces = self.surfaces.iter().filter(|(of, _)| *of == number).cloned().collect();
        Self { segments: self.segments.clone(), surfaces }
    }
}
