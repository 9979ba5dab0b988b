use cranny_spatial::Point;

/// A member of a collision pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Collider {
    /// A link of the robot, by index.
    Link(usize),
    /// A body of the world, by index.
    Body(usize),
}

/// A pair that is closer than allowed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// A link.
    pub first: Collider,
    /// Another link, or a body of the world.
    pub second: Collider,
    /// Their distance, in metres; 0 if they overlap.
    pub clearance_m: f64,
    /// Demanded clearance, in metres.
    pub required_m: f64,
    /// Penetration depth, in metres; 0 if they only come too close.
    pub depth_m: f64,
    /// A point in the overlap, in the planning frame; `None` if they only come too close.
    pub point: Option<Point>,
}
