use std::ops::Range;

use cranny_spatial::Point;

use crate::Camera;

/// Pixels of a rectangle: columns and rows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct PixelRange {
    pub columns: Range<usize>,
    pub rows: Range<usize>,
}

/// Depth below which the projection of a point is not used, in metres.
const LEAST_DEPTH_M: f64 = 1e-6;

/// Rounding of a projected coordinate, in pixels, for points beyond [`LEAST_DEPTH_M`].
const ROUNDING_PX: f64 = 1e-3;

impl PixelRange {
    /// All pixels of a camera.
    pub fn whole(camera: &Camera) -> Self {
        Self { columns: 0..camera.width_px, rows: 0..camera.height_px }
    }

    /// Returns the pixels whose rays may meet the convex hull of points in the camera frame if each ray is shifted by at most
    /// `shift_px` (px) along both image axes; `None` if all points lie behind the camera or no pixel is left.
    pub fn of(camera: &Camera, points: impl Iterator<Item = Point>, shift_px: f64) -> Option<Self> {
        let (mut is_behind, mut is_in_front) = (false, false);
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for point in points {
            match camera.project(&point).filter(|_| point.z > LEAST_DEPTH_M) {
                Some(place) => {
                    is_in_front = true;
                    for axis in 0..2 {
                        low[axis] = low[axis].min(place[axis]);
                        high[axis] = high[axis].max(place[axis]);
                    }
                }
                None => is_behind = true,
            }
        }
        match (is_in_front, is_behind) {
            (false, _) => None,
            (true, true) => Some(Self::whole(camera)),
            (true, false) => {
                let margin = shift_px + ROUNDING_PX;
                let side = |axis: usize, most: usize| pixels(low[axis] - margin, high[axis] + margin, most);
                Some(Self { columns: side(0, camera.width_px)?, rows: side(1, camera.height_px)? })
            }
        }
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
        let of = |points: &[Point], shift_px| PixelRange::of(&camera, points.iter().copied(), shift_px);
        let points = [Point::new(0.0, 0.0, 1.0), Point::new(0.2, -0.1, 1.0)];
        assert_eq!(of(&points, 0.0), Some(PixelRange { columns: 50..60, rows: 35..40 }));
        assert_eq!(of(&points, 1.0), Some(PixelRange { columns: 49..61, rows: 34..41 }));
        assert_eq!(of(&[Point::new(5.0, 0.0, 1.0)], 0.0), None);
        assert_eq!(of(&[Point::new(0.0, 0.0, -1.0)], 0.0), None);
        assert_eq!(of(&[points[0], Point::new(0.0, 0.0, -1.0)], 0.0), Some(PixelRange::whole(&camera)));
    }
}
