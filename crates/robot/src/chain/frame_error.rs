use crate::JointKind;

/// Bound on the rounding error of a computed frame, and of any point fixed to it.
///
/// With a unit roundoff `u`, a frame is computed from that of its parent by a translation and a rotation; each constant,
/// product and sum has a relative error of `u`. To first order, in the operator norm:
///
/// - the rotation error of a frame is that of its parent, plus the rounding of the constant rotation (√3 u), of the product
///   with it (three columns of three products each: 9 u) and of the turn (4 u), together [`PER_TURN`], plus the errors of the
///   sine and the cosine, and of the angle itself;
/// - the error of its origin is that of its parent's origin, plus the parent's rotation error times the offset to it, plus the
///   rounding of that offset and the products with it (√3 · 3 u + u, [`PER_WAY`]) and of the sum (u times its distance from the
///   root);
/// - the error of a point of the frame has the same terms.
///
/// [`HIGHER_ORDERS`] covers the higher-order terms, as long as the rotation error of no frame exceeds [`MOST_TURNED`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct FrameError {
    rotation_rad: f64,
    origin_m: f64,
    /// Maximum distance of the frame's origin from the root's, in metres.
    farthest_m: f64,
    unit: f64,
}

/// Data of a joint that determine its rounding error.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MovedBy {
    pub kind: JointKind,
    /// Maximum absolute value (m, rad).
    pub most: f64,
    /// Number of roundings of that value before its use.
    pub roundings: f64,
    /// Absolute error of its sine and of its cosine.
    pub sine: f64,
}

const PER_TURN: f64 = 15.0;
const PER_WAY: f64 = 6.2;
const HIGHER_ORDERS: f64 = 1.1;
const MOST_TURNED: f64 = 1e-2;

impl FrameError {
    /// Returns the error of the root frame, which is zero.
    pub fn root(unit: f64) -> Self {
        Self { rotation_rad: 0.0, origin_m: 0.0, farthest_m: 0.0, unit }
    }

    /// Returns the error of a frame at the distance `way_m` from the origin of this one, beyond a joint if there is one.
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

    /// Bounds the error of a point that lies at most `from_frame_m` from the origin of the frame, in metres; infinite if the
    /// rotation error exceeds [`MOST_TURNED`].
    pub fn of_point_m(&self, from_frame_m: f64) -> f64 {
        if self.rotation_rad.is_nan() || self.rotation_rad > MOST_TURNED {
            return f64::INFINITY;
        }
        let Self { rotation_rad, origin_m, farthest_m, unit } = self;
        let own = (rotation_rad + PER_WAY * unit) * from_frame_m + unit * (farthest_m + from_frame_m);
        HIGHER_ORDERS * (origin_m + own)
    }

    pub fn farthest_m(&self) -> f64 {
        self.farthest_m
    }
}
