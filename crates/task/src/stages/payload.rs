use cranny_robot::Inertial;
use cranny_shape::VolumeMoments;
use cranny_spatial::nalgebra::Matrix3;
use serde::{Deserialize, Serialize};

/// Mass, centre of mass and inertia of the object in the hand.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Payload {
    /// Mass, in kilograms.
    pub mass_kg: f64,
    /// Centre of mass in the gripper frame, in metres.
    pub center_m: [f64; 3],
    /// Inertia about the centre along the axes of the gripper frame, in kg m²: xx, xy, xz, yy, yz, zz.
    pub inertia_kg_m2: [f64; 6],
    /// True if the mass is not stated, and was assumed from the volume ([`cranny_grasp::ASSUMED_DENSITY`]).
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub mass_assumed: bool,
}

impl Payload {
    /// Creates the payload of a mass (kg) with the moments of its shape in the gripper frame.
    pub(crate) fn new(mass_kg: f64, moments: &VolumeMoments, mass_assumed: bool) -> Self {
        let inertia = moments.inertia_per_mass_m2 * mass_kg;
        let at = |row, column| 0.5 * (inertia[(row, column)] + inertia[(column, row)]);
        Self {
            mass_kg,
            center_m: moments.center.coords.into(),
            inertia_kg_m2: [at(0, 0), at(0, 1), at(0, 2), at(1, 1), at(1, 2), at(2, 2)],
            mass_assumed,
        }
    }

    /// Returns the payload as a rigid body in the gripper frame.
    pub fn inertial(&self) -> Inertial {
        let [xx, xy, xz, yy, yz, zz] = self.inertia_kg_m2;
        Inertial {
            mass_kg: self.mass_kg,
            center: self.center_m.into(),
            inertia_kg_m2: Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz),
        }
    }
}
