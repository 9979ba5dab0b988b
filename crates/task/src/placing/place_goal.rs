use cranny_collision::World;
use cranny_shape::Roundness;
use cranny_spatial::Pose;

use crate::grasping::firmness::soup_in_world;

/// Where an object can be put down.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaceGoal {
    /// What it is called.
    pub name: String,
    /// Where it is.
    pub spot: PlaceSpot,
}

/// Where an object can be put down.
#[derive(Clone, Debug, PartialEq)]
pub enum PlaceSpot {
    /// Wholly on a level rectangle, anywhere, as it rests on level ground, turned about the vertical as it likes.
    Surface {
        /// The body of the world that the rectangle lies on.
        on: String,
        /// Its middle, z upwards.
        pose: Pose,
        /// How long it is along its x and y, in metres.
        size_m: [f64; 2],
    },
    /// Where its first solid has this pose, within 1 mm and 1°.
    Target(Pose),
}

/// Cosine of the least angle between the vertical and the axis of a round body that lies on its side: 5° from level.
const LYING: f64 = 0.0872;

impl PlaceGoal {
    /// The reason, in words, for which a body of a world, with this resistance to rolling (m), rolls away from here: it is a ball,
    /// or lies on its round side, and no resistance is stated.
    pub(crate) fn rolls_away(&self, world: &World, body: usize, rolling_m: Option<f64>) -> Option<String> {
        if rolling_m.is_some_and(|rolling_m| rolling_m > 0.0) {
            return None;
        }
        let body = &world.bodies()[body];
        let roundness = Roundness::of_mesh(&soup_in_world(body)?).ok()?;
        let rolls = match (roundness, &self.spot) {
            (Roundness::Ball, _) => true,
            (Roundness::About(axis), PlaceSpot::Target(pose)) => {
                let turned = pose.rotation * body.parts.first()?.world_from_solid.rotation.inverse();
                (turned * axis).dot(&world.up()).abs() < LYING
            }
            _ => false,
        };
        rolls.then(|| {
            format!(
                "{} rolls away from '{}': no resistance to rolling is stated for it (`rolling_m` beside its `mass_kg`, in metres; \
                 0.0003 for a hard ball)",
                body.name, self.name
            )
        })
    }

    /// The same in a frame in which the one that it is in has this pose.
    #[must_use]
    pub fn seen_from(&self, new_from_old: &Pose) -> Self {
        let spot = match &self.spot {
            PlaceSpot::Surface { on, pose, size_m } => {
                PlaceSpot::Surface { on: on.clone(), pose: new_from_old * pose, size_m: *size_m }
            }
            PlaceSpot::Target(pose) => PlaceSpot::Target(new_from_old * pose),
        };
        Self { name: self.name.clone(), spot }
    }
}
