use cranny_spatial::CONTACT_M;

use crate::{CollisionError, World};

/// How much clearance every check and every proof demands.
#[derive(Clone, Debug, Default)]
pub struct Margins {
    /// Between any two things, in metres, ≥ 0. Default 0: contact alone counts.
    pub margin_m: f64,
    /// Instead of `margin_m` between the links and the bodies below, in metres, ≥ 0. Default 0: fingers
    /// must come close to what they grasp.
    pub grasp_margin_m: f64,
    /// The links of hand and fingers, by index.
    pub hand_links: Vec<usize>,
    /// The object to be grasped and what carries it, by index.
    pub grasp_bodies: Vec<usize>,
}

impl Margins {
    /// The same with one object to be grasped: it and its supports get the grasp margin.
    #[must_use]
    pub fn for_target(mut self, world: &World, target: usize) -> Self {
        self.grasp_bodies = world.supports_of(target);
        self.grasp_bodies.push(target);
        self
    }

    pub(crate) fn check(&self) -> Result<(), CollisionError> {
        for value in [self.margin_m, self.grasp_margin_m] {
            if !(value.is_finite() && value >= 0.0) {
                return Err(CollisionError::Margin { value });
            }
        }
        Ok(())
    }

    pub(crate) fn between(&self, link: usize, body: usize) -> f64 {
        let is_grasp = self.hand_links.contains(&link) && self.grasp_bodies.contains(&body);
        CONTACT_M.max(if is_grasp { self.grasp_margin_m } else { self.margin_m })
    }

    pub(crate) fn between_links(&self) -> f64 {
        CONTACT_M.max(self.margin_m)
    }
}
