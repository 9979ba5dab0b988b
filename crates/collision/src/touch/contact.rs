use cranny_spatial::Point;

/// One of the two things that touch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Collider {
    /// A link of the robot, by index.
    Link(usize),
    /// A body of the world, by index.
    Body(usize),
}

/// Two things that are closer than they may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// A link.
    pub first: Collider,
    /// Another link, or a body.
    pub second: Collider,
    /// Their distance, in metres; 0 where they overlap.
    pub clearance_m: f64,
    /// The clearance that was asked for, in metres.
    pub required_m: f64,
    /// How deep they overlap, in metres; 0 where they only come too close.
    pub depth_m: f64,
    /// A point in the overlap, in the planning frame; `None` where they only come too close.
    pub point: Option<Point>,
}
