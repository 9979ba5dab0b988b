use std::f64::consts::PI;

use cranny_grasp::ShakeTest;

use crate::SimError;

/// Checks that the parameters of a shake test are within their ranges.
///
/// # Errors
/// [`SimError::Figure`] for a parameter that is out of range.
pub(crate) fn check_shake_test(shake_test: &ShakeTest) -> Result<(), SimError> {
    for (figure, value, range, (least, greatest)) in [
        ("closing speed", shake_test.closing_speed, "from 0.001 to 1 m/s", (0.001, 1.0)),
        ("lift", shake_test.lift_m, "from 0 to 1 m", (0.0, 1.0)),
        ("time of the lift", shake_test.lift_s, "from 0.01 to 60 s", (0.01, 60.0)),
        ("amplitude of the shaking", shake_test.shake_m, "from 0 to 0.1 m", (0.0, 0.1)),
        ("turn of the shaking", shake_test.shake_rad, "from 0 to 90°", (0.0, 0.5 * PI)),
        ("frequency of the shaking", shake_test.shake_hz, "from 0.1 to 50 Hz", (0.1, 50.0)),
        ("number of periods of the shaking", shake_test.shake_periods, "from 0 to 100", (0.0, 100.0)),
        ("rest at the end", shake_test.rest_s, "from 0 to 60 s", (0.0, 60.0)),
        ("limit of slip", shake_test.slip_m, "positive, up to 0.05 m", (1e-6, 0.05)),
        ("limit of turning", shake_test.slip_rad, "positive, up to 180°", (1e-6, PI)),
    ] {
        if !(least..=greatest).contains(&value) {
            return Err(SimError::Figure { figure, value, range });
        }
    }
    Ok(())
}
