use cranny_spatial::{Point, Vector, sin_cos};
use strum::{EnumString, IntoStaticStr, VariantArray};

/// From where a scene is looked at, by a lens without distortion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Where the eye is, in the planning frame.
    pub eye: Point,
    /// To the right of the picture, a unit vector.
    pub right: Vector,
    /// To the top of the picture, a unit vector.
    pub up: Vector,
    /// The angle between the lower and the upper edge, in radians; above 0, below π.
    pub height_rad: f64,
}

/// The four directions from which every scenario can be looked at. The robot reaches along x of the planning
/// frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, EnumString, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "kebab-case")]
pub enum StandardView {
    /// From the right, somewhat ahead and above: the view that shows most.
    ThreeQuarter,
    /// From behind the robot: what it sees.
    Front,
    /// From the right of the robot, level.
    Side,
    /// From above; ahead is up.
    Top,
}

impl StandardView {
    /// What flags and file names call it.
    pub fn name(self) -> &'static str {
        self.into()
    }

    /// Where the eye is as seen from what it looks at, in degrees: turned about z from x, and above the ground.
    pub fn direction_deg(self) -> (f64, f64) {
        match self {
            Self::ThreeQuarter => (-75.0, 22.0),
            Self::Front => (180.0, 14.0),
            Self::Side => (-90.0, 4.0),
            Self::Top => (180.0, 90.0),
        }
    }
}

/// The height of the picture in angle: that of a lens of 85 mm on film of 24 mm and somewhat more, a portrait
/// that neither bulges nor flattens.
const HEIGHT_RAD: f64 = 0.42;

/// How much of the picture's half width or height things may fill.
const FILLED: f64 = 0.93;

impl Camera {
    /// A camera that looks from a direction (degrees: turned about z from x, and above the ground) and stands
    /// just so far away that all `points` are in the picture, `aspect` = width / height.
    ///
    /// The eye in the frame of the camera follows from the four planes of its pyramid, each of which one of the
    /// points touches; the narrower pair decides the distance.
    pub fn framing(direction_deg: (f64, f64), points: &[Point], aspect: f64) -> Self {
        let (turn_deg, rise_deg) = direction_deg;
        let (sin_turn, cos_turn) = sin_cos(turn_deg.to_radians());
        let (sin_rise, cos_rise) = sin_cos(rise_deg.to_radians());
        let back = Vector::new(cos_rise * cos_turn, cos_rise * sin_turn, sin_rise);
        // Also straight from above, where the vertical says nothing.
        let right = Vector::new(-sin_turn, cos_turn, 0.0);
        let up = back.cross(&right);
        let half_height = libm::tan(0.5 * HEIGHT_RAD) * FILLED;
        let half_width = half_height * aspect;
        let farthest =
            |along: &dyn Fn(&Point) -> f64| points.iter().map(along).fold(f64::NEG_INFINITY, f64::max);
        // How far the planes on both sides of an axis push the eye, and where it then is on the axis.
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

    /// Out of the picture towards the eye, a unit vector.
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
