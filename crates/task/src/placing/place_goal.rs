use cranny_spatial::Pose;

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

impl PlaceGoal {
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
