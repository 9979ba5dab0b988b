/// How a target weighs and slides, as far as it is said.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TargetPhysics {
    /// Its mass, in kilograms; positive.
    pub mass_kg: Option<f64>,
    /// The coefficient of friction between it and the pads of a gripper; positive.
    pub friction: Option<f64>,
    /// Resistance to rolling on what it stands on: the arm of the normal force that has to be overcome, in metres; not
    /// negative.
    pub rolling_m: Option<f64>,
}

/// The resistance to rolling of the built-in objects, in metres: 0.3 mm. A tennis ball on a hard floor stops at an
/// incline of 0.5° with it.
pub(crate) const BUILTIN_ROLLING_M: f64 = 3e-4;

impl TargetPhysics {
    /// What this says; where it says nothing, what `other` does.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self {
            mass_kg: self.mass_kg.or(other.mass_kg),
            friction: self.friction.or(other.friction),
            rolling_m: self.rolling_m.or(other.rolling_m),
        }
    }
}
