use crate::Friction;

/// Mass and friction of a target, as far as they are stated.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TargetPhysics {
    /// Mass, in kilograms; positive.
    pub mass_kg: Option<f64>,
    /// Coefficient of friction between the target and the pads of a gripper.
    pub friction: Option<Friction>,
    /// Rolling resistance on its support: the lever arm of the normal force that resists rolling, in metres; not negative.
    pub rolling_m: Option<f64>,
}

/// Rolling resistance of the built-in objects, in metres (0.3 mm): a tennis ball on a hard floor stops at an incline of 0.5°.
pub(crate) const BUILTIN_ROLLING_M: f64 = 3e-4;

impl TargetPhysics {
    /// Returns the coefficient of friction for loads: the lower end of its range.
    pub fn least_friction(&self) -> Option<f64> {
        self.friction.map(|friction| friction.low)
    }

    /// Returns these values, with missing ones taken from `other`.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self {
            mass_kg: self.mass_kg.or(other.mass_kg),
            friction: self.friction.or(other.friction),
            rolling_m: self.rolling_m.or(other.rolling_m),
        }
    }
}
