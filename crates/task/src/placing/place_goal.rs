use cranny_collision::{Body, World};
use cranny_shape::Roundness;
use cranny_spatial::{Pose, Vector};

use crate::grasping::load_model::soup_in_world;

/// Goal for putting an object down.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaceGoal {
    /// Name of the goal.
    pub name: String,
    /// Region or pose of the goal.
    pub spot: PlaceRegion,
}

/// Region or pose at which an object can be put down.
#[derive(Clone, Debug, PartialEq)]
pub enum PlaceRegion {
    /// Any position wholly on a level rectangle, in a pose that is stable on level ground, with any turn about the vertical.
    Surface {
        /// Name of the body of the world that the rectangle lies on.
        on: String,
        /// Pose of its centre in the planning frame, z upwards.
        pose: Pose,
        /// Lengths along its x and y axes, in metres.
        size_m: [f64; 2],
    },
    /// First solid of the object at this pose, within 1 mm and 1°.
    Target(Pose),
}

/// Sine of the greatest angle between the horizontal and the axis of a lying round body: 5°.
const LYING: f64 = 0.0872;

/// Returns the axis of a round body without resistance to rolling (m), in the frame of its first solid; `None` for any other body,
/// and for a ball.
pub(crate) fn rolling_axis(body: &Body, rolling_m: Option<f64>) -> Option<Vector> {
    if rolling_m.is_some_and(|rolling_m| rolling_m > 0.0) {
        return None;
    }
    match Roundness::of_mesh(&soup_in_world(body)?).ok()? {
        Roundness::About(axis) => {
            Some(body.parts.first()?.world_from_solid.rotation.inverse() * axis.into_inner())
        }
        _ => None,
    }
}

/// Returns true if an axis, in a frame with z upwards, is level.
pub(crate) fn is_lying(axis: &Vector) -> bool {
    axis.z.abs() < LYING
}

impl PlaceGoal {
    /// Returns the reason, in words, why a body of a world, with this resistance to rolling (m), rolls away from this goal: it
    /// is a ball, or lies on its round side, and no resistance is stated.
    pub(crate) fn rolls_away(&self, world: &World, body: usize, rolling_m: Option<f64>) -> Option<String> {
        if rolling_m.is_some_and(|rolling_m| rolling_m > 0.0) {
            return None;
        }
        let body = &world.bodies()[body];
        let roundness = Roundness::of_mesh(&soup_in_world(body)?).ok()?;
        let rolls = match (roundness, &self.spot) {
            (Roundness::Ball, _) => true,
            (Roundness::About(axis), PlaceRegion::Target(pose)) => {
                let turned = pose.rotation * body.parts.first()?.world_from_solid.rotation.inverse();
                (turned * axis).dot(&world.up()).abs() < LYING
            }
            _ => false,
        };
        rolls.then(|| self.rolls_away_text(&body.name))
    }

    /// Returns the reason, in words, why the body of this name rolls away from this goal.
    pub(crate) fn rolls_away_text(&self, body: &str) -> String {
        format!(
            "{body} rolls away from '{}': no resistance to rolling is stated for it (`rolling_m` beside its `mass_kg`, in metres; \
             0.0003 for a hard ball)",
            self.name
        )
    }

    /// Returns this goal in a new frame; `new_from_old` is the pose of the present frame in it.
    #[must_use]
    pub fn in_frame(&self, new_from_old: &Pose) -> Self {
        let spot = match &self.spot {
            PlaceRegion::Surface { on, pose, size_m } => {
                PlaceRegion::Surface { on: on.clone(), pose: new_from_old * pose, size_m: *size_m }
            }
            PlaceRegion::Target(pose) => PlaceRegion::Target(new_from_old * pose),
        };
        Self { name: self.name.clone(), spot }
    }
}
