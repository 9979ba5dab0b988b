use std::f64::consts::PI;

use cranny_grasp::ShakeTest;

use crate::SimError;

/// Checks that the parameters of a course are within their ranges.
///
/// # Errors
/// [`SimError::Figure`] for a parameter that is out of range.
pub(crate) fn check_course(course: &ShakeTest) -> Result<(), SimError> {
    for (figure, value, range, (least, greatest)) in [
        ("closing speed", course.closing_speed, "from 0.001 to 1 m/s", (0.001, 1.0)),
        ("lift", course.lift_m, "from 0 to 1 m", (0.0, 1.0)),
        ("time of the lift", course.lift_s, "from 0.01 to 60 s", (0.01, 60.0)),
        ("amplitude of the shaking", course.shake_m, "from 0 to 0.1 m", (0.0, 0.1)),
        ("turn of the shaking", course.shake_rad, "from 0 to 90°", (0.0, 0.5 * PI)),
        ("frequency of the shaking", course.shake_hz, "from 0.1 to 50 Hz", (0.1, 50.0)),
        ("number of periods of the shaking", course.shake_periods, "from 0 to 100", (0.0, 100.0)),
        ("rest at the end", course.rest_s, "from 0 to 60 s", (0.0, 60.0)),
        ("limit of slip", course.slip_m, "positive, up to 0.05 m", (1e-6, 0.05)),
        ("limit of turning", course.slip_rad, "positive, up to 180°", (1e-6, PI)),
    ] {
        if !(least..=greatest).contains(&value) {
            return Err(SimError::Figure { figure, value, range });
        }
    }
    Ok(())
}
