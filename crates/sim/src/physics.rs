use cranny_spatial::Vector;

use crate::SimError;

/// Parameters of the simulated physics. The exported MuJoCo model uses the same values where MuJoCo has the same parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Physics {
    /// Gravitational acceleration, downwards, in m/s².
    pub gravity: f64,
    /// Direction against gravity in the planning frame, a unit vector. Default z.
    pub up: Vector,
    /// Time step, in seconds, in (0, 1/480].
    pub step_s: f64,
    /// Number of solver iterations per step.
    pub solver_iterations: usize,
    /// Stiffness of a contact, as its natural frequency in Hz.
    pub contact_frequency_hz: f64,
    /// Damping ratio of a contact; above 1, nothing bounces.
    pub contact_damping_ratio: f64,
    /// Inertia that the drive adds to a finger, in kilograms. The gears of a gripper turn a light motor into a heavy finger;
    /// the fingers of the model have no other mass.
    pub finger_inertia_kg: f64,
    /// Stiffness of the drive and of the coupling between the fingers, in N/m.
    pub drive_stiffness: f64,
    /// Damping of the drive and of the coupling, in N s/m.
    pub drive_damping: f64,
    /// Rolling resistance of the object on its support: the arm of the normal force that a rotation has to overcome, in metres.
    pub rolling_m: f64,
}

impl Default for Physics {
    fn default() -> Self {
        Self {
            gravity: 9.81,
            up: Vector::z(),
            step_s: 0.002,
            solver_iterations: 4,
            contact_frequency_hz: 200.0,
            contact_damping_ratio: 5.0,
            finger_inertia_kg: 0.5,
            drive_stiffness: 2e4,
            drive_damping: 150.0,
            rolling_m: 0.0,
        }
    }
}

impl Physics {
    /// # Errors
    /// [`SimError::Figure`] for a parameter that is out of range.
    pub(crate) fn check(&self) -> Result<(), SimError> {
        let positive = |value: f64| value.is_finite() && value > 0.0;
        for (figure, value, range, is_sound) in [
            ("gravity", self.gravity, "from 0 to 100 m/s²", (0.0..=100.0).contains(&self.gravity)),
            ("step", self.step_s, "at most 1/480 s", positive(self.step_s) && self.step_s <= 1.0 / 480.0),
            (
                "number of solver iterations",
                self.solver_iterations as f64,
                "from 1 to 1000",
                (1..=1000).contains(&self.solver_iterations),
            ),
            (
                "contact frequency",
                self.contact_frequency_hz,
                "a positive number of hertz",
                positive(self.contact_frequency_hz),
            ),
            (
                "contact damping ratio",
                self.contact_damping_ratio,
                "a positive number",
                positive(self.contact_damping_ratio),
            ),
            (
                "inertia of a finger",
                self.finger_inertia_kg,
                "a positive number of kilograms",
                positive(self.finger_inertia_kg),
            ),
            (
                "resistance to rolling",
                self.rolling_m,
                "from 0 to 0.1 m",
                (0.0..=0.1).contains(&self.rolling_m),
            ),
            // An explicit spring with damper is stable if k dt² + 2 c dt < 4 m; half of that leaves a margin for contacts.
            (
                "stiffness of the drive",
                self.drive_stiffness,
                "positive and below what the step can follow",
                positive(self.drive_stiffness)
                    && self.drive_damping >= 0.0
                    && self.drive_stiffness * self.step_s * self.step_s
                        + 2.0 * self.drive_damping * self.step_s
                        < 2.0 * self.finger_inertia_kg,
            ),
        ] {
            if !is_sound {
                return Err(SimError::Figure { figure, value, range });
            }
        }
        Ok(())
    }
}
