use crate::SenseError;
use crate::error::within;

/// Largest relative error of rounding a depth to `f32`, doubled to cover the arithmetic around it.
const F32_ROUNDING: f64 = 1.0 / (1 << 23) as f64;

/// Bounds on the errors of a depth camera.
///
/// Law: let z range over the true depths along all rays within `lateral_error_px` of the centre of a pixel in each image axis.
/// A valid measurement m of this pixel satisfies
///
/// min z − δ(min z) ≤ m ≤ max z + δ(max z),  δ(z) = `depth_error_m` + `depth_error_share` · z.
///
/// A pixel at an edge may thus measure a depth between front and back. A ray that meets nothing has z = ∞. The true camera lies
/// within `position_error_m` of its stated position and is rotated by at most `turn_error_rad` about it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorModel {
    /// Constant part of the depth error, in metres.
    pub depth_error_m: f64,
    /// Part of the depth error that grows with depth, as a share of it.
    pub depth_error_share: f64,
    /// Lateral error of a pixel along each image axis, in pixels.
    pub lateral_error_px: f64,
    /// Distance between stated and true position of the camera, in metres.
    pub position_error_m: f64,
    /// Angle between stated and true orientation of the camera, in radians.
    pub turn_error_rad: f64,
    /// Least depth that the sensor measures, in metres.
    pub nearest_m: f64,
    /// Greatest depth that the sensor measures, in metres.
    pub farthest_m: f64,
}

impl Default for SensorModel {
    /// A structured-light or time-of-flight camera within 2 m, on a calibrated mount: 1 mm and 0.5 %.
    fn default() -> Self {
        Self {
            depth_error_m: 0.001,
            depth_error_share: 0.005,
            lateral_error_px: 0.5,
            position_error_m: 0.0,
            turn_error_rad: 0.0,
            nearest_m: 0.1,
            farthest_m: 5.0,
        }
    }
}

impl SensorModel {
    /// Maximum lateral error, in pixels.
    pub const MOST_LATERAL_PX: f64 = 16.0;

    /// Model of a sensor without any error, for exact renders.
    pub fn exact() -> Self {
        Self { depth_error_m: 0.0, depth_error_share: 0.0, lateral_error_px: 0.0, ..Self::default() }
    }

    /// Checks the ranges of all properties.
    ///
    /// # Errors
    /// [`SenseError::Sensor`] with the first property out of its range.
    pub fn check(&self) -> Result<(), SenseError> {
        for (property, value, greatest, range) in [
            ("depth_error_m", self.depth_error_m, 1.0, "0 to 1"),
            ("depth_error_share", self.depth_error_share, 0.5, "0 to 0.5"),
            ("lateral_error_px", self.lateral_error_px, Self::MOST_LATERAL_PX, "0 to 16"),
            ("position_error_m", self.position_error_m, 1.0, "0 to 1"),
            ("turn_error_rad", self.turn_error_rad, 0.5, "0 to 0.5 (28.6°)"),
            ("nearest_m", self.nearest_m, 60.0, "0 to 60"),
            ("farthest_m", self.farthest_m, 60.0, "0 to 60"),
        ] {
            within(value, [0.0, greatest], |value| SenseError::Sensor { property, value, range })?;
        }
        if self.nearest_m >= self.farthest_m {
            let range = "less than farthest_m";
            return Err(SenseError::Sensor { property: "nearest_m", value: self.nearest_m, range });
        }
        Ok(())
    }

    /// Returns the bound δ(z) of the depth error at a true depth (m), in metres.
    pub fn depth_bound_m(&self, true_depth_m: f64) -> f64 {
        self.depth_error_m + self.depth_error_share * true_depth_m
    }

    /// Returns the least true depth that can measure `measured_m`, in metres; at least 0. Includes the rounding of the
    /// measurement to `f32`.
    ///
    /// z ≥ (m − `depth_error_m`) / (1 + `depth_error_share`) (test `true_depths_lie_between_their_bounds`).
    pub fn least_true_depth_m(&self, measured_m: f64) -> f64 {
        let measured_m = measured_m * (1.0 - F32_ROUNDING);
        ((measured_m - self.depth_error_m) / (1.0 + self.depth_error_share)).max(0.0)
    }

    /// Returns the greatest true depth that can measure `measured_m`, in metres. Includes the rounding of the measurement to
    /// `f32`.
    pub fn greatest_true_depth_m(&self, measured_m: f64) -> f64 {
        (measured_m * (1.0 + F32_ROUNDING) + self.depth_error_m) / (1.0 - self.depth_error_share)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        #[allow(clippy::cast_possible_truncation, reason = "depths are stored as f32")]
        fn true_depths_lie_between_their_bounds(
            true_m in 0.0..6.0, error_m in 0.0..0.1, share in 0.0..0.5, side in -1.0..=1.0,
        ) {
            let sensor =
                SensorModel { depth_error_m: error_m, depth_error_share: share, ..SensorModel::default() };
            let measured_m = f64::from((true_m + side * sensor.depth_bound_m(true_m)) as f32);
            if measured_m > 0.0 {
                prop_assert!(sensor.least_true_depth_m(measured_m) <= true_m + 1e-12);
                prop_assert!(sensor.greatest_true_depth_m(measured_m) >= true_m - 1e-12);
            }
        }
    }

    #[test]
    fn values_out_of_range_are_named() {
        let fault = |sensor: SensorModel| sensor.check().unwrap_err().to_string();
        let base = SensorModel::default();
        base.check().expect("the default is valid");
        assert!(fault(SensorModel { depth_error_m: -1.0, ..base }).contains("depth_error_m"));
        assert!(fault(SensorModel { lateral_error_px: f64::NAN, ..base }).contains("but is NaN"));
        assert!(fault(SensorModel { nearest_m: 5.0, ..base }).contains("less than farthest_m"));
        assert!(fault(SensorModel { turn_error_rad: 0.6, ..base }).contains("28.6"));
    }
}
