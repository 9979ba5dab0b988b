use std::fmt;

use cranny_grasp::{GraspSampler, SamplerSettings};
use cranny_shape::Surface;
use serde::Serialize;

use crate::{DEFAULT_FRICTION, Scenario};

/// So many first contacts are drawn: a handle with a thousandth of the surface is met by some ten.
const FIRST_CONTACTS: usize = 10_000;

/// An object that no grasp fits, as far as was sampled: two pads that hold it are farther apart than the hand opens.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TooWide {
    /// The least distance of two contacts in force closure, in metres.
    pub narrowest_m: f64,
    /// Between the pads of the open hand, in metres.
    pub opening_m: f64,
}

impl TooWide {
    /// Of an object, if it is; `settings` are those of the sampling of grasps.
    pub fn of(surface: &Surface, settings: &SamplerSettings) -> Option<Self> {
        let narrowest_m = GraspSampler::new(surface, settings).ok()?.too_wide_m(FIRST_CONTACTS)?;
        Some(Self { narrowest_m, opening_m: settings.opening_m })
    }
}

impl fmt::Display for TooWide {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [narrowest_mm, opening_mm] = [self.narrowest_m, self.opening_m].map(|metres| metres * 1e3);
        write!(
            formatter,
            "no grasp fits: two pads that hold it are at least {narrowest_mm:.1} mm apart, as sampled, and the hand \
             opens {opening_mm:.1} mm"
        )
    }
}

impl Scenario {
    /// Why a planner that makes grasps of its own will find none for the target, where nothing else gives any.
    pub fn too_wide_target(&self) -> Option<String> {
        let hand = self.robot.hand().filter(|_| self.grasps.is_empty())?;
        let surface = Surface::new(&self.target_mesh().ok()??).ok()?;
        let friction = self.target_physics().friction.unwrap_or(DEFAULT_FRICTION);
        let opening_m = hand.description.opening_m;
        let too_wide =
            TooWide::of(&surface, &SamplerSettings { friction, opening_m, ..SamplerSettings::default() })?;
        Some(format!("{}: {too_wide}", self.world.bodies()[self.target?].name))
    }
}
