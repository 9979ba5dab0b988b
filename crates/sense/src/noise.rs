use cranny_spatial::{Pose, Rotation, Stream, Vector, nalgebra};

use crate::error::within;
use crate::rendering::interval::Side;
use crate::rendering::render::{Meeting, Rays};
use crate::{Camera, DepthImage, SenseError, SensedScene, SensorModel, View};

/// Errors of a simulated sensor, drawn within the bounds of its model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Factor on all bounds of the sensor model: 1 draws errors up to the bounds, 2 a sensor that violates its model.
    pub factor: f64,
    /// Share of pixels at random places without a measurement, 0 to 1.
    pub dropout_share: f64,
    /// Share of the pixels at depth edges that measure a depth between front and back, 0 to 1; the other pixels at edges are
    /// measured as usual.
    pub mixed_share: f64,
    /// Seed of all draws; the same seed gives the same bytes.
    pub seed: u64,
}

impl Default for Noise {
    /// No dropouts; half of the edge pixels mixed, as time-of-flight cameras measure.
    fn default() -> Self {
        Self { factor: 1.0, dropout_share: 0.0, mixed_share: 0.5, seed: 0 }
    }
}

/// Difference of the depths of neighbouring rays, as a share of the lesser, above which they lie on both sides of an edge
/// (filters of depth cameras take 3 to 5 %).
const EDGE_SHARE: f64 = 0.03;

/// Streams of draws, so that one kind of error does not depend on the others.
const PIXELS: u64 = 0;
const POSE: u64 = 1;

impl Noise {
    /// Checks the ranges of all settings.
    ///
    /// # Errors
    /// [`SenseError::Noise`] with the first setting out of its range.
    pub fn check(&self) -> Result<(), SenseError> {
        for (property, value, greatest, range) in [
            ("factor", self.factor, 100.0, "0 to 100"),
            ("share of dropouts", self.dropout_share, 1.0, "0 to 1"),
            ("share of mixed pixels", self.mixed_share, 1.0, "0 to 1"),
        ] {
            within(value, [0.0, greatest], |value| SenseError::Noise { property, value, range })?;
        }
        Ok(())
    }

    /// Returns a measurement of a depth (m) with an error within the bounds; NaN for a dropout, no depth, or a measurement out
    /// of the range of the sensor. Always draws twice.
    fn measured_m(&self, true_m: f64, sensor: &SensorModel, random: &mut Stream) -> f32 {
        let error = random.uniform_between(-1.0, 1.0) * self.factor * sensor.depth_bound_m(true_m);
        let is_dropped = random.uniform() < self.dropout_share;
        let measured_m = true_m + error;
        let is_valid = (sensor.nearest_m..=sensor.farthest_m).contains(&measured_m) && !is_dropped;
        #[allow(clippy::cast_possible_truncation, reason = "depths are stored as f32")]
        if is_valid { measured_m as f32 } else { f32::NAN }
    }

    /// Returns a depth between two neighbouring ones (m) if they lie on both sides of an edge and the pixel is drawn to be mixed,
    /// otherwise the first. Always draws twice.
    fn mixed_m(&self, first_m: f64, second_m: f64, random: &mut Stream) -> f64 {
        let (is_mixed, share) = (random.uniform() < self.mixed_share, random.uniform());
        let is_edge = first_m.is_finite() && second_m.is_finite() && is_edge(first_m, second_m);
        if is_mixed && is_edge { first_m + share * (second_m - first_m) } else { first_m }
    }
}

fn is_edge(first_m: f64, second_m: f64) -> bool {
    (first_m - second_m).abs() > EDGE_SHARE * first_m.min(second_m)
}

/// Returns a depth image with errors, drawn from an image without errors.
///
/// The law of [`SensorModel`] holds for bounds times `factor`: the lateral error is drawn among the whole pixels within its
/// bound. A pixel at an edge is mixed if the bound is a pixel or more, otherwise invalid: the image does not show where between
/// the centres of two pixels the edge lies. [`SensedScene::measure`] knows, and is preferable for scenes.
///
/// # Errors
/// Those of [`SensorModel::check`] and [`Noise::check`].
pub fn noisy(image: &DepthImage, sensor: &SensorModel, noise: &Noise) -> Result<DepthImage, SenseError> {
    sensor.check()?;
    noise.check()?;
    let mut random = Stream::new(noise.seed, PIXELS);
    let (width, height) = (image.width(), image.height());
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "at most 16 px times a factor of 100"
    )]
    let shift = (sensor.lateral_error_px * noise.factor) as usize;
    let true_m = |u: usize, v: usize| image.depth_m(u, v).map_or(f64::INFINITY, f64::from);
    let mut depths_m = Vec::with_capacity(width * height);
    for v in 0..height {
        for u in 0..width {
            let mut near = |at: usize, count: usize| {
                (at + random.index(2 * shift + 1)).saturating_sub(shift).min(count - 1)
            };
            let first_m = true_m(near(u, width), near(v, height));
            let depth_m = if shift > 0 {
                let second_m = true_m(near(u, width), near(v, height));
                noise.mixed_m(first_m, second_m, &mut random)
            } else {
                let is_drawn = random.uniform() < noise.mixed_share;
                let neighbours = [(1, 0), (0, 1), (-1, 0), (0, -1)].map(|(du, dv)| {
                    u.checked_add_signed(du)
                        .zip(v.checked_add_signed(dv))
                        .and_then(|(u, v)| image.depth_m(u, v))
                });
                let is_at_edge =
                    neighbours.iter().flatten().any(|other_m| is_edge(first_m, f64::from(*other_m)));
                if is_drawn && is_at_edge { f64::NAN } else { first_m }
            };
            depths_m.push(noise.measured_m(depth_m, sensor, &mut random));
        }
    }
    DepthImage::new(width, height, depths_m)
}

impl SensedScene {
    /// Returns the depth image that a sensor at the true pose of `camera` measures, with errors within the bounds of its model
    /// times the factor of the noise.
    ///
    /// Satisfies the law of [`SensorModel`]: each pixel measures the depth of a ray within the lateral bound, or at an edge a
    /// depth between those of two such rays, with a depth error uniform within its bound (test
    /// `measurements_obey_the_law_of_the_sensor`).
    ///
    /// # Errors
    /// Those of [`SensorModel::check`] and [`Noise::check`].
    pub fn measure(
        &self,
        camera: &Camera,
        sensor: &SensorModel,
        noise: &Noise,
    ) -> Result<DepthImage, SenseError> {
        sensor.check()?;
        noise.check()?;
        let mut random = Stream::new(noise.seed, PIXELS);
        let most_shift_px = sensor.lateral_error_px * noise.factor;
        let mut met = || {
            let shift = |random: &mut Stream| random.uniform_between(-1.0, 1.0) * most_shift_px;
            let shifts_px: Vec<[f64; 2]> =
                (0..camera.pixel_count()).map(|_| [shift(&mut random), shift(&mut random)]).collect();
            self.meetings(&Rays { camera, shifts_px: &shifts_px, most_shift_px }, Side::Front, |_| true)
        };
        let (first, second) = (met(), met());
        let measured = |(first, second): (&Meeting, &Meeting)| {
            let depth_m = noise.mixed_m(first.depth_m, second.depth_m, &mut random);
            noise.measured_m(depth_m, sensor, &mut random)
        };
        let depths_m = first.iter().zip(&second).map(measured).collect();
        Ok(DepthImage::of_camera(camera, depths_m))
    }

    /// Returns the view of a sensor at the true pose of `camera`: depths with errors as [`Self::measure`] draws them, and the
    /// camera at a stated pose that deviates from the true one ([`Camera::misplaced`]).
    ///
    /// # Errors
    /// As [`Self::measure`], and those of [`View::new`].
    pub fn view(
        &self,
        name: impl Into<String>,
        camera: &Camera,
        sensor: &SensorModel,
        noise: &Noise,
    ) -> Result<View, SenseError> {
        View::new(name, camera.misplaced(sensor, noise), self.measure(camera, sensor, noise)?, *sensor)
    }
}

impl Camera {
    /// Returns this camera at a stated pose that deviates from its true one within the bounds of the sensor model times the
    /// factor of the noise: uniform in the ball of positions, and by a uniform angle about a random axis through the camera.
    #[must_use]
    pub fn misplaced(&self, sensor: &SensorModel, noise: &Noise) -> Self {
        let mut random = Stream::new(noise.seed, POSE);
        let mut direction = || {
            let drawn = Vector::from_fn(|_, _| random.normal());
            nalgebra::Unit::try_new(drawn, 0.0).unwrap_or_else(Vector::z_axis)
        };
        let (way, axis) = (direction(), direction());
        let reach_m = libm::cbrt(random.uniform()) * sensor.position_error_m * noise.factor;
        let angle_rad = random.uniform() * sensor.turn_error_rad * noise.factor;
        let true_pose = &self.world_from_camera;
        let stated = Pose::from_parts(
            (true_pose.translation.vector + way.into_inner() * reach_m).into(),
            Rotation::from_axis_angle(&axis, angle_rad) * true_pose.rotation,
        );
        Self { world_from_camera: stated, ..self.clone() }
    }
}
