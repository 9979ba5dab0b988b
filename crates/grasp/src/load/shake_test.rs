use std::f64::consts::{PI, TAU};

use cranny_spatial::nalgebra::Translation3;
use cranny_spatial::{Pose, Rotation, Vector, sin_cos};
use serde::Serialize;

/// Motion of the hand with an object between its closed fingers, and the criterion of a held object.
///
/// The hand lifts the object straight up and smoothly (fifth-degree polynomial, at rest at both ends). It then shakes it
/// along and about each axis of the gripper frame in turn: `A sin²(π t / T) sin(2π f t)`. Then it is still.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ShakeTest {
    /// Closing speed of the fingers, in m/s.
    pub closing_speed: f64,
    /// Height of the lift, in metres.
    pub lift_m: f64,
    /// Duration of the lift, in seconds.
    pub lift_s: f64,
    /// Amplitude A along each axis, in metres. Default 10 mm: at 5 Hz about the acceleration of gravity.
    pub shake_m: f64,
    /// Amplitude A about each axis, in radians.
    pub shake_rad: f64,
    /// Frequency f of the shaking, in Hz.
    pub shake_hz: f64,
    /// Number of oscillations in the time T on each axis; 0: no shaking.
    pub shake_periods: f64,
    /// Time at rest at the end, in seconds.
    pub rest_s: f64,
    /// Maximum displacement of the object in the closed hand, in metres; beyond it the object has slipped.
    pub slip_m: f64,
    /// Maximum rotation of the object in the closed hand, in radians; beyond it the object has slipped.
    pub slip_rad: f64,
}

impl Default for ShakeTest {
    fn default() -> Self {
        Self {
            closing_speed: 0.1,
            lift_m: 0.1,
            lift_s: 0.5,
            shake_m: 0.01,
            shake_rad: 10_f64.to_radians(),
            shake_hz: 5.0,
            shake_periods: 2.0,
            rest_s: 0.1,
            slip_m: 0.01,
            slip_rad: 15_f64.to_radians(),
        }
    }
}

impl ShakeTest {
    /// Duration of the course after the hand has closed, in seconds.
    pub fn duration_s(&self) -> f64 {
        self.lift_s + 3.0 * self.shake_axis_s() + self.rest_s
    }

    /// Pose of the hand `time_s` (s) after it has closed at `world_from_closed`, lifted along the unit vector `up_in_world`.
    pub fn world_from_hand(&self, world_from_closed: &Pose, up_in_world: &Vector, time_s: f64) -> Pose {
        let risen_m = self.lift_m * smooth_share(time_s / self.lift_s);
        let lifted = Translation3::from(up_in_world * risen_m) * world_from_closed;
        let (since_s, axis_s) = (time_s - self.lift_s, self.shake_axis_s());
        if since_s <= 0.0 || since_s >= 3.0 * axis_s {
            return lifted;
        }
        let (mut axis, mut in_axis_s) = (0, since_s);
        while in_axis_s >= axis_s && axis < 2 {
            (axis, in_axis_s) = (axis + 1, in_axis_s - axis_s);
        }
        let window = sin_cos(PI * in_axis_s / axis_s).0.powi(2);
        let wave = window * sin_cos(TAU * self.shake_hz * in_axis_s).0;
        let mut direction = Vector::zeros();
        direction[axis] = wave;
        let turn = Rotation::from_scaled_axis(direction * self.shake_rad);
        lifted * Pose::from_parts((direction * self.shake_m).into(), turn)
    }

    pub(crate) fn shake_axis_s(&self) -> f64 {
        self.shake_periods / self.shake_hz
    }
}

/// Completed share of a motion after a share of its time: the polynomial of fifth degree that is at rest at both ends.
pub fn smooth_share(share: f64) -> f64 {
    let share = share.clamp(0.0, 1.0);
    share.powi(3) * (10.0 - share * (15.0 - 6.0 * share))
}
