use std::ops::Range;

use cranny_spatial::Point;

use crate::Camera;

/// Pixels of a rectangle: columns and rows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct PixelRange {
    pub columns: Range<usize>,
    pub rows: Range<usize>,
}

/// Depth of the plane before the camera at which hulls are cut, in metres.
const LEAST_DEPTH_M: f64 = 1e-6;

/// Rounding of a projected coordinate, in pixels and relative to it: a point on that plane within 1 km of the camera is off by 10⁻¹³ m
/// at most.
const ROUNDING_PX: f64 = 1e-3;
const RELATIVE_ROUNDING: f64 = 1e-6;

impl PixelRange {
    /// All pixels of a camera.
    pub fn whole(camera: &Camera) -> Self {
        Self { columns: 0..camera.width_px, rows: 0..camera.height_px }
    }

    /// Returns the pixels whose rays may meet the convex hull of points in the camera frame if each ray is shifted by at most
    /// `shift_px` (px) along both image axes; `None` if all points lie behind the camera or no pixel is left.
    pub fn of(camera: &Camera, points: &[Point], shift_px: f64) -> Option<Self> {
        let is_before = |point: &Point| point.z > LEAST_DEPTH_M;
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        let mut add = |point: &Point| {
            let Some(place) = camera.project(point) else { return };
            for axis in 0..2 {
                low[axis] = low[axis].min(place[axis]);
                high[axis] = high[axis].max(place[axis]);
            }
        };
        for point in points.iter().filter(|point| is_before(point)) {
            add(point);
            // The hull ends where it crosses the plane of the camera.
            for other in points.iter().filter(|other| !is_before(other)) {
                let share = (point.z - LEAST_DEPTH_M) / (point.z - other.z);
                let crossing = point + (other - point) * share;
                add(&Point::new(crossing.x, crossing.y, LEAST_DEPTH_M));
            }
        }
        if low[0] > high[0] {
            return None;
        }
        let side = |axis: usize, most: usize| {
            let margin = |place: f64| shift_px + ROUNDING_PX + place.abs() * RELATIVE_ROUNDING;
            pixels(low[axis] - margin(low[axis]), high[axis] + margin(high[axis]), most)
        };
        Some(Self { columns: side(0, camera.width_px)?, rows: side(1, camera.height_px)? })
    }
}

/// Returns the integers from `low` to `high` below `count`; `None` if there are none.
fn pixels(low: f64, high: f64, count: usize) -> Option<Range<usize>> {
    let last = count as f64 - 1.0;
    let (first, end) = (low.ceil().max(0.0), high.floor().min(last));
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "both lie within the image")]
    (first <= end).then(|| first as usize..end as usize + 1)
}

#[cfg(test)]
mod tests {
    use cranny_spatial::Pose;

    use super::*;

    #[test]
    fn a_range_holds_the_pixels_of_its_points_and_no_others() {
        let camera = Camera::new([100, 80], [50.0; 2], [49.5, 39.5], Pose::identity()).expect("a camera");
        let of = |points: &[Point], shift_px| PixelRange::of(&camera, points, shift_px);
        let points = [Point::new(0.0, 0.0, 1.0), Point::new(0.2, -0.1, 1.0)];
        assert_eq!(of(&points, 0.0), Some(PixelRange { columns: 50..60, rows: 35..40 }));
        assert_eq!(of(&points, 1.0), Some(PixelRange { columns: 49..61, rows: 34..41 }));
        assert_eq!(of(&[Point::new(5.0, 0.0, 1.0)], 0.0), None);
        assert_eq!(of(&[Point::new(0.0, 0.0, -1.0)], 0.0), None);
        // From before the camera to behind it, to the left: the pixels from the middle to the border.
        let across = [Point::new(0.0, 0.0, 1.0), Point::new(-0.1, 0.01, -1.0)];
        assert_eq!(of(&across, 0.0), Some(PixelRange { columns: 0..50, rows: 40..80 }));
        assert_eq!(of(&[Point::new(5.0, 0.0, 1.0), Point::new(5.0, 0.0, -1.0)], 0.0), None);
    }
}
