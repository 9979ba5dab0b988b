use cranny_spatial::{Point, Vector, sin_cos};
use strum::{EnumString, IntoStaticStr, VariantArray};

/// Pinhole camera without distortion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Position of the eye, in the planning frame.
    pub eye: Point,
    /// Unit vector to the right of the picture.
    pub right: Vector,
    /// Unit vector to the top of the picture.
    pub up: Vector,
    /// Vertical field of view, in radians; above 0, below π.
    pub height_rad: f64,
}

/// The four standard directions of view of a scenario. The robot reaches along x of the planning frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, EnumString, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "kebab-case")]
pub enum StandardView {
    /// From the right, slightly ahead and above: the most informative view.
    ThreeQuarter,
    /// From behind the robot, in its direction of view.
    Front,
    /// From the right of the robot, nearly level.
    Side,
    /// From above, with the direction ahead at the top.
    Top,
}

impl StandardView {
    /// Name in flags and file names.
    pub fn name(self) -> &'static str {
        self.into()
    }

    /// Direction from the target point to the eye, in degrees: azimuth about z from x, and elevation above the ground.
    pub fn direction_deg(self) -> (f64, f64) {
        match self {
            Self::ThreeQuarter => (-75.0, 22.0),
            Self::Front => (180.0, 14.0),
            Self::Side => (-90.0, 4.0),
            Self::Top => (180.0, 90.0),
        }
    }
}

/// Vertical field of view: slightly more than that of an 85 mm portrait lens on 24 mm film, with little perspective distortion.
const HEIGHT_RAD: f64 = 0.42;

/// Share of the half width or height of the picture that the scene may fill.
const FILLED: f64 = 0.93;

impl Camera {
    /// Creates a camera in a direction (degrees: azimuth about z from x, and elevation above the ground) at the smallest
    /// distance at which all `points` are in the picture; `aspect` = width / height.
    ///
    /// Each of the four planes of the view pyramid touches one of the points, which determines the eye in the camera frame; the
    /// narrower pair of planes determines the distance.
    pub fn framing(direction_deg: (f64, f64), points: &[Point], aspect: f64) -> Self {
        let (turn_deg, rise_deg) = direction_deg;
        let (sin_turn, cos_turn) = sin_cos(turn_deg.to_radians());
        let (sin_rise, cos_rise) = sin_cos(rise_deg.to_radians());
        let back = Vector::new(cos_rise * cos_turn, cos_rise * sin_turn, sin_rise);
        // This is also valid straight from above, where the vertical gives no direction.
        let right = Vector::new(-sin_turn, cos_turn, 0.0);
        let up = back.cross(&right);
        let half_height = libm::tan(0.5 * HEIGHT_RAD) * FILLED;
        let half_width = half_height * aspect;
        let farthest =
            |along: &dyn Fn(&Point) -> f64| points.iter().map(along).fold(f64::NEG_INFINITY, f64::max);
        // Distance that the two planes of an axis require, and the resulting coordinate of the eye on that axis.
        let between = |axis: &Vector, slope: f64| {
            let one = farthest(&|p| p.coords.dot(axis) + slope * p.coords.dot(&back));
            let other = farthest(&|p| -p.coords.dot(axis) + slope * p.coords.dot(&back));
            ((one + other) / (2.0 * slope), 0.5 * (one - other))
        };
        let (distance_for_width, x) = between(&right, half_width);
        let (distance_for_height, y) = between(&up, half_height);
        let eye = right * x + up * y + back * distance_for_width.max(distance_for_height);
        let eye = if eye.iter().all(|x| x.is_finite()) { eye } else { back };
        Self { eye: eye.into(), right, up, height_rad: HEIGHT_RAD }
    }

    /// Unit vector out of the picture, towards the eye.
    pub fn back(&self) -> Vector {
        self.right.cross(&self.up)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_view_has_all_in_it_and_something_at_its_edge() {
        let points: Vec<Point> = (0..8)
            .map(|i| Point::new(f64::from(i & 1) * 2.0, f64::from(i >> 1 & 1) - 3.0, f64::from(i >> 2)))
            .collect();
        for &view in StandardView::VARIANTS {
            let camera = Camera::framing(view.direction_deg(), &points, 4.0 / 3.0);
            let slope = libm::tan(0.5 * camera.height_rad);
            let reach = points.iter().map(|point| {
                let from_eye = point - camera.eye;
                let depth = -from_eye.dot(&camera.back());
                assert!(depth > 0.0);
                let x = from_eye.dot(&camera.right) / (depth * slope * 4.0 / 3.0);
                let y = from_eye.dot(&camera.up) / (depth * slope);
                x.abs().max(y.abs())
            });
            let reach = reach.fold(0.0, f64::max);
            assert!((reach - FILLED).abs() < 1e-9, "{view:?}: {reach}");
        }
    }

    #[test]
    fn seen_from_above_ahead_is_up_and_left_is_left() {
        let camera = Camera::framing(StandardView::Top.direction_deg(), &[Point::origin()], 1.0);
        assert!((camera.up - Vector::x()).norm() < 1e-12);
        assert!((camera.right + Vector::y()).norm() < 1e-12);
    }
}
