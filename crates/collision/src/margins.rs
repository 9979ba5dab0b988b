use cranny_spatial::CONTACT_M;
use serde::{Deserialize, Serialize};

use crate::CollisionError;

/// Clearances that every check and every proof demands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Margins {
    /// Clearance of every collision pair, in metres, ≥ 0. Default 0: only contact counts.
    pub margin_m: f64,
    /// Clearance between the hand and the grasped object or its supports, in metres, ≥ 0, instead of `margin_m`. Default 0:
    /// fingers must come close to the object. If greater than `margin_m`, also between the hand and bodies put down before.
    pub grasp_margin_m: f64,
    /// Additional clearance, for the uncertain position of the object, between the object that is held or to be grasped and all
    /// that it may not touch, in metres, ≥ 0. Default 0.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub object_margin_m: f64,
    /// Maximum tilt of the held object, in radians, above 0 and at most π: the angle between up and the direction in the object
    /// that pointed up before the grasp. Default: no limit. The limit of the object ([`Body::tilt_rad`](crate::Body::tilt_rad))
    /// applies if it is smaller.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tilt_rad: Option<f64>,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks for it")]
fn is_zero(margin_m: &f64) -> bool {
    *margin_m == 0.0
}

/// Returns true if the angle is a valid limit of a tilt.
pub(crate) fn is_tilt(tilt_rad: f64) -> bool {
    tilt_rad > 0.0 && tilt_rad <= std::f64::consts::PI
}

impl Margins {
    /// Checks the range of each value.
    ///
    /// # Errors
    /// [`CollisionError::Margin`] for one that is negative or not finite, [`CollisionError::Tilt`] for a tilt out of range.
    pub fn check(&self) -> Result<(), CollisionError> {
        for value in [self.margin_m, self.grasp_margin_m, self.object_margin_m] {
            if !(value.is_finite() && value >= 0.0) {
                return Err(CollisionError::Margin { value });
            }
        }
        if let Some(tilt_rad) = self.tilt_rad.filter(|tilt_rad| !is_tilt(*tilt_rad)) {
            return Err(CollisionError::Tilt { tilt_rad });
        }
        Ok(())
    }

    /// Returns the least distance that counts as free, in metres.
    pub(crate) fn required_m(&self, is_grasp: bool) -> f64 {
        CONTACT_M.max(if is_grasp { self.grasp_margin_m } else { self.margin_m })
    }

    /// Returns the least distance demanded between the hand and the object to be grasped, in metres; 0 if only contact counts.
    pub fn of_grasp_m(&self) -> f64 {
        self.grasp_margin_m + self.object_margin_m
    }

    /// Returns the least distance that counts as free for the held object, in metres.
    pub fn of_held_m(&self) -> f64 {
        self.required_m(false) + self.object_margin_m
    }
}
