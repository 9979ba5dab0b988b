/// How a target weighs and slides, as far as it is said.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TargetPhysics {
    /// Its mass, in kilograms; positive.
    pub mass_kg: Option<f64>,
    /// The coefficient of friction between it and the pads of a gripper; positive.
    pub friction: Option<f64>,
}

impl TargetPhysics {
    /// What this says; where it says nothing, what `other` does.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self { mass_kg: self.mass_kg.or(other.mass_kg), friction: self.friction.or(other.friction) }
    }
}
