use cranny_shape::Ball;

use crate::lane::lane_vector::lanes;

#[derive(Clone, Copy, Debug)]
pub(crate) struct LaneBall {
    pub center: [f32; 3],
    pub radius: f32,
}

impl LaneBall {
    #[allow(
        clippy::cast_possible_truncation,
        reason = "lanes are `f32` by design; the slack of the body covers it"
    )]
    pub fn new(ball: &Ball) -> Self {
        Self { center: lanes(&ball.center.coords), radius: ball.radius_m as f32 }
    }
}
