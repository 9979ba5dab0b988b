use cranny_spatial::CONTACT_M;
use serde::{Deserialize, Serialize};

use crate::CollisionError;

/// How much clearance every check and every proof demands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Margins {
    /// Between any two things, in metres, ≥ 0. Default 0: contact alone counts.
    pub margin_m: f64,
    /// Instead of that between the hand and what it grasps, and what carries that, in metres, ≥ 0. Default 0: fingers
    /// must come close to what they grasp.
    pub grasp_margin_m: f64,
    /// Besides these, between the object to be grasped, or that is held, and all that it may not touch, in metres, ≥ 0: so
    /// far it may be from where it is thought to be. Default 0.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub object_margin_m: f64,
    /// Greatest tilt of what is held, in radians, above 0 and at most π: of the direction in it that pointed up where it stood
    /// when it was grasped, against up. Default: any; that of a body ([`Body::tilt_rad`](crate::Body::tilt_rad)) counts if
    /// it is less.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tilt_rad: Option<f64>,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks for it")]
fn is_zero(margin_m: &f64) -> bool {
    *margin_m == 0.0
}

/// Whether something may be tilted by at most this angle.
pub(crate) fn is_tilt(tilt_rad: f64) -> bool {
    tilt_rad > 0.0 && tilt_rad <= std::f64::consts::PI
}

impl Margins {
    pub(crate) fn check(&self) -> Result<(), CollisionError> {
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

    /// The least distance that counts as free, in metres.
    pub(crate) fn required_m(&self, is_grasp: bool) -> f64 {
        CONTACT_M.max(if is_grasp { self.grasp_margin_m } else { self.margin_m })
    }

    /// Least distance that is demanded between the hand and the object that it is to grasp, in metres; 0 where contact
    /// alone counts.
    pub fn of_grasp_m(&self) -> f64 {
        self.grasp_margin_m + self.object_margin_m
    }

    /// The least distance that counts as free for what is held, in metres.
    pub fn of_held_m(&self) -> f64 {
        self.required_m(false) + self.object_margin_m
    }
}
