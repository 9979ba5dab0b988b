use crate::JointKind;

/// How far rounding takes a computed frame from where it is, and any point that is fixed to it.
///
/// With a unit roundoff `u`, a frame is that of its parent, moved on and turned: constants, products and sums
/// are each off by `u` of their size. To first order, in the operator norm:
///
/// - a turned frame is off by that of its parent, by the rounding of the constant rotation (√3 u), of the
///   product with it (three columns of three products each: 9 u) and of the turn (4 u), together [`PER_TURN`],
///   by the sine and the cosine, and by the rounding of the angle itself;
/// - its origin by that of its parent, by the parent's turn times the way to it, by the rounding of that
///   way and the products with it (√3 · 3 u + u, [`PER_WAY`]) and of the sum (u of how far it is from the root);
/// - a point of it likewise.
///
/// What is beyond first order is covered by [`HIGHER_ORDERS`], as long as no frame is turned by more than
/// [`MOST_TURNED`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct FrameError {
    rotation_rad: f64,
    origin_m: f64,
    /// The frame's origin is never farther from the root's, in metres.
    farthest_m: f64,
    unit: f64,
}

/// A joint as far as its rounding depends on it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MovedBy {
    pub kind: JointKind,
    /// Its greatest value, either way (m, rad).
    pub most: f64,
    /// How often that is rounded before it is used.
    pub roundings: f64,
    /// The error of its sine and of its cosine.
    pub sine: f64,
}

const PER_TURN: f64 = 15.0;
const PER_WAY: f64 = 6.2;
const HIGHER_ORDERS: f64 = 1.1;
const MOST_TURNED: f64 = 1e-2;

impl FrameError {
    /// The root's own frame.
    pub fn root(unit: f64) -> Self {
        Self { rotation_rad: 0.0, origin_m: 0.0, farthest_m: 0.0, unit }
    }

    /// A frame `way_m` from the origin of this one, and beyond a joint, if there is one.
    pub fn beyond(self, way_m: f64, joint: Option<MovedBy>) -> Self {
        let Self { unit, .. } = self;
        let (mut turn, mut slide_m, mut slide_error_m) = (PER_TURN * unit, 0.0, 0.0);
        match joint {
            Some(MovedBy { kind: JointKind::Revolute, most, roundings, sine }) => {
                turn += roundings * unit * most + std::f64::consts::SQRT_2 * sine;
            }
            Some(MovedBy { kind: JointKind::Prismatic, most, roundings, .. }) => {
                slide_m = most;
                slide_error_m = (roundings + PER_WAY) * unit * most;
            }
            None => {}
        }
        let farthest_m = self.farthest_m + way_m + slide_m;
        let origin_m = self.origin_m
            + self.rotation_rad * (way_m + slide_m)
            + PER_WAY * unit * way_m
            + slide_error_m
            + 2.0 * unit * farthest_m;
        Self { rotation_rad: self.rotation_rad + turn, origin_m, farthest_m, unit }
    }

    /// A bound on the error of a point that lies at most `from_frame_m` from the origin of the frame, in metres;
    /// infinite where there is none.
    pub fn of_point_m(&self, from_frame_m: f64) -> f64 {
        if self.rotation_rad.is_nan() || self.rotation_rad > MOST_TURNED {
            return f64::INFINITY;
        }
        let Self { rotation_rad, origin_m, farthest_m, unit } = self;
        let own = (rotation_rad + PER_WAY * unit) * from_frame_m + unit * (farthest_m + from_frame_m);
        HIGHER_ORDERS * (origin_m + own)
    }

    /// How far the frame's origin can be from the root's, in metres.
    pub fn farthest_m(&self) -> f64 {
        self.farthest_m
    }
}
