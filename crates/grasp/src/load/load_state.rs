use std::f64::consts::{PI, TAU};

use cranny_spatial::nalgebra::Rotation3;
use cranny_spatial::{Vector, sin_cos};

use crate::ShakeTest;

/// Motion of the hand, with the object in it, at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadState {
    /// Upward acceleration, against gravity, in m/s².
    pub lift: f64,
    /// Acceleration in the gripper frame at the instant of closing, in m/s².
    pub acceleration: Vector,
    /// Angular velocity in the gripper frame, in rad/s.
    pub rate: Vector,
    /// Angular acceleration, in rad/s².
    pub rate_acceleration: Vector,
    /// Rotation of the gripper frame since the hand closed.
    pub turn: Rotation3<f64>,
}

impl LoadState {
    /// Gravity alone, in the attitude of the grasp.
    pub const GRAVITY: Self = Self {
        lift: 0.0,
        acceleration: Vector::new(0.0, 0.0, 0.0),
        rate: Vector::new(0.0, 0.0, 0.0),
        rate_acceleration: Vector::new(0.0, 0.0, 0.0),
        turn: Rotation3::from_matrix_unchecked(cranny_spatial::nalgebra::Matrix3::new(
            1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0,
        )),
    };

    /// Motions of the hand along a shake test: every 20 ms while it lifts, every 4 ms while it shakes.
    pub fn along(shake_test: &ShakeTest) -> Vec<Self> {
        let middles = |step_s: f64, duration_s: f64| {
            let times = (0u32..).map(move |step| (f64::from(step) + 0.5) * step_s);
            times.take_while(move |time_s| *time_s < duration_s)
        };
        let lifting = middles(0.02, shake_test.lift_s).map(|time_s| {
            let share = time_s / shake_test.lift_s;
            let curve = share * (60.0 - share * (180.0 - 120.0 * share));
            Self { lift: shake_test.lift_m * curve / shake_test.lift_s.powi(2), ..Self::GRAVITY }
        });
        let span_s = shake_test.shake_periods / shake_test.shake_hz;
        let (a, b) = (PI / span_s, TAU * shake_test.shake_hz);
        let shaking = move |axis: usize| {
            middles(0.004, span_s).map(move |time_s| {
                let (sine, cosine) = sin_cos(b * time_s);
                let (window_sine, _) = sin_cos(a * time_s);
                let (double_sine, double_cosine) = sin_cos(2.0 * a * time_s);
                let window = window_sine * window_sine;
                let value = window * sine;
                let first = a * double_sine * sine + b * window * cosine;
                let second = 2.0 * a * a * double_cosine * sine + 2.0 * a * b * double_sine * cosine
                    - b * b * window * sine;
                let along = |size: f64| Vector::ith(axis, size);
                Self {
                    lift: 0.0,
                    acceleration: along(second * shake_test.shake_m),
                    rate: along(first * shake_test.shake_rad),
                    rate_acceleration: along(second * shake_test.shake_rad),
                    turn: Rotation3::from_scaled_axis(along(value * shake_test.shake_rad)),
                }
            })
        };
        lifting.chain((0..3).flat_map(shaking)).collect()
    }
}
