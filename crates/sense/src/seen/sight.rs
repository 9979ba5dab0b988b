use cranny_spatial::nalgebra::Matrix3;
use cranny_spatial::{Point, Vector};

use crate::View;
use crate::seen::depth_table::{LeastTable, PixelRect};
use crate::seen::known_solids::Explained;

/// A view, prepared to judge cells of space.
///
/// Let an obstacle contain a ball of radius r = (½ + ε)√2 z_c/f around c, for the lateral error ε (px) and the focal length f (px), and
/// let p be a point of that ball. The pixel nearest to the image of c is within ½ px of it along both axes, and all rays of its
/// footprint (±ε) meet the ball, at depths of at most z_c + r sin θ, where θ is the greatest angle of a ray from the optical axis. The
/// pixel is within g = ½ + r f/(z_c cos θ) of the image of p, and its measurement m has a least true depth l(m) ≤ z_p + r (1 + sin θ). So
/// no point p of such an obstacle is in a cell if l(m) exceeds the farthest depth in the cell by r (1 + sin θ) for *all* pixels within
/// g of the image of the cell. Details of an obstacle that no such ball reaches can be missed ([`detail_m`](Self::detail_m)).
pub(crate) struct Sight {
    turn: Matrix3<f64>,
    shift: Vector,
    focal_px: [f64; 2],
    center_px: [f64; 2],
    size_px: [usize; 2],
    nearest_m: f64,
    position_error_m: f64,
    /// Twice the sine of half the error of orientation.
    turn_error: f64,
    /// Radius of a detail per metre of depth.
    detail_per_m: f64,
    /// Depth by which the rays of a detail may exceed that of its nearest point, per metre of depth.
    slack_per_m: f64,
    /// Distance of pixels from the image of a cell that can show an obstacle in it, in pixels.
    growth_px: f64,
    /// Least true depth of each pixel; 0 where nothing is measured.
    free: LeastTable,
    /// Negative of the greatest true depth of each pixel; 0 where nothing is measured.
    farthest: LeastTable,
    /// Negative of the least of `free` in the pixels that concern every cell whose image holds the pixel.
    hopeful: LeastTable,
    /// The same two tables for pixels that show no known body; others, and those where nothing is measured, are infinitely far and near.
    /// `None` if no pixel shows a known body.
    other: Option<[LeastTable; 2]>,
}

/// Result of a view for a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Judgement {
    /// Nothing is in the cell.
    Free,
    /// No smaller cell within it can be seen to be free, and no surface was measured in it.
    Hidden,
    /// No smaller cell within it can be seen to be free.
    Blocked,
    /// Smaller cells may be free.
    Open,
}

/// Image of a cell.
struct Image {
    /// Least and greatest depth (m).
    depths_m: [f64; 2],
    /// Least and greatest coordinates u and v (px).
    across_px: [[f64; 2]; 2],
}

impl Sight {
    /// Prepares a view in which pixels show known bodies; the least cells have this half side (m).
    pub fn new(view: &View, explained: &Explained, least_half_m: f64) -> Self {
        let View { camera, depth, sensor, .. } = view;
        let camera_from_world = camera.world_from_camera.inverse();
        let focal_px = [camera.focal_x_px, camera.focal_y_px];
        let reach_px = 0.5 + sensor.lateral_error_px;
        let per_m = reach_px * std::f64::consts::SQRT_2 / focal_px[0].min(focal_px[1]);
        // z_c ≤ z_p + r.
        let detail_per_m = per_m / (1.0 - per_m.min(0.5));
        let corners = [0, 1, 2, 3].map(|corner| {
            let u = if corner & 1 == 0 { 0 } else { camera.width_px - 1 };
            let v = if corner & 2 == 0 { 0 } else { camera.height_px - 1 };
            let ray = camera.ray(u as f64, v as f64);
            ray.xy().norm() / ray.norm()
        });
        let sine = corners.into_iter().fold(0.0, f64::max);
        let bounds = |pixel: usize| {
            let measured = f64::from(depth.depths_m()[pixel]);
            let is_valid = (sensor.nearest_m..=sensor.farthest_m).contains(&measured);
            is_valid.then(|| [sensor.least_true_depth_m(measured), sensor.greatest_true_depth_m(measured)])
        };
        let table = |value: &dyn Fn(usize) -> f64| {
            #[allow(clippy::cast_possible_truncation, reason = "rounding is a thousandth of a reserve")]
            let image = (0..camera.pixel_count()).map(|pixel| value(pixel) as f32).collect();
            LeastTable::new(camera.width_px, image)
        };
        /// Rounding of a depth to single precision, in metres.
        const ROUNDED_M: f64 = 1e-6;
        let slack_per_m = detail_per_m * (1.0 + sine);
        // A cell at the surface of a known body holds nothing else.
        let behind_known = |known_m: f64| known_m * (1.0 + slack_per_m) + 4.0 * least_half_m;
        let least = |pixel: usize| {
            let known = explained.depth_m(pixel).map(behind_known);
            bounds(pixel).map_or(0.0, |[least, _]| known.unwrap_or(least).max(least) - ROUNDED_M)
        };
        let growth_px =
            0.5 + detail_per_m * focal_px[0].max(focal_px[1]) / (1.0 - sine * sine).max(1e-6).sqrt();
        let free = table(&least);
        let hopeful = (0..camera.pixel_count()).map(|pixel| {
            let range = |at: usize, size: usize| {
                #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "some pixels")]
                let around = (growth_px - 0.5) as usize;
                [at.saturating_sub(around), (at + around).min(size - 1)]
            };
            let (u, v) = (pixel % camera.width_px, pixel / camera.width_px);
            let rect = PixelRect { columns: range(u, camera.width_px), rows: range(v, camera.height_px) };
            -free.least(&rect)
        });
        let hopeful = LeastTable::new(camera.width_px, hopeful.collect());
        Self {
            turn: camera_from_world.rotation.to_rotation_matrix().into_inner(),
            shift: camera_from_world.translation.vector,
            focal_px,
            center_px: [camera.center_x_px, camera.center_y_px],
            size_px: [camera.width_px, camera.height_px],
            nearest_m: sensor.nearest_m,
            position_error_m: sensor.position_error_m,
            turn_error: 2.0 * libm::sin(0.5 * sensor.turn_error_rad),
            detail_per_m,
            slack_per_m,
            growth_px,
            hopeful,
            free,
            farthest: table(&|pixel| bounds(pixel).map_or(0.0, |[_, farthest]| -farthest)),
            other: (!explained.is_empty()).then(|| {
                let of_other = |pixel: usize| bounds(pixel).filter(|_| !explained.is_of_known(pixel));
                [
                    table(&|pixel| of_other(pixel).map_or(f64::INFINITY, |[least, _]| least)),
                    table(&|pixel| of_other(pixel).map_or(0.0, |[_, farthest]| -farthest)),
                ]
            }),
        }
    }

    /// Returns the diameter of details that can be missed at this depth (m), in metres.
    pub fn detail_m(&self, depth_m: f64) -> f64 {
        2.0 * self.detail_per_m * depth_m
    }

    /// Returns the depth of a point of the planning frame, in metres.
    pub fn depth_m(&self, point: &Point) -> f64 {
        (self.turn * point.coords + self.shift).z
    }

    /// Judges a cube by its centre and half side (m).
    pub fn judge(&self, center: &Point, half_m: f64) -> Judgement {
        let Some(image) = self.image(center, half_m) else { return Judgement::Open };
        if image.depths_m[1] <= self.nearest_m {
            return Judgement::Hidden;
        }
        let [near_m, far_m] = image.depths_m;
        if near_m >= self.nearest_m
            && let Some(rect) = self.whole_rect(&image, self.growth_px)
            && f64::from(self.free.least(&rect)) > far_m * (1.0 + self.slack_per_m)
        {
            return Judgement::Free;
        }
        let Some(rect) = self.rect(&image, 1.0) else { return Judgement::Hidden };
        let is_hidden = -f64::from(self.farthest.least(&rect)) <= near_m;
        if is_hidden {
            return Judgement::Hidden;
        }
        // A pixel beside the image of the cell concerns all smaller cells there, too.
        let is_blocked = -f64::from(self.hopeful.least(&rect)) <= near_m * (1.0 + self.slack_per_m);
        if is_blocked { Judgement::Blocked } else { Judgement::Open }
    }

    /// Returns true if a surface may have been measured in a cube; with `but_known`, one of another than the known bodies.
    pub fn shows_surface(&self, center: &Point, half_m: f64, but_known: bool) -> bool {
        let Some(image) = self.image(center, half_m) else { return false };
        let Some(rect) = self.rect(&image, self.growth_px) else { return false };
        let [near_m, far_m] = image.depths_m;
        let (least, farthest) = match &self.other {
            Some([least, farthest]) if but_known => (least, farthest),
            _ => (&self.free, &self.farthest),
        };
        #[allow(clippy::cast_possible_truncation, reason = "a reserve covers the rounding")]
        let (far, near) = ((far_m * (1.0 + self.slack_per_m)) as f32, near_m as f32);
        if least.least(&rect) > far || -farthest.least(&rect) < near {
            return false;
        }
        // Pixels on both sides of an edge are no surface in between.
        let mut bounds = std::iter::zip(least.pixels(&rect), farthest.pixels(&rect));
        bounds.any(|(least, farthest)| least <= far && -farthest >= near)
    }

    /// Returns the image of a cube, grown by the error of the camera's pose; `None` if it is not certainly before the camera, unless it
    /// is certainly too near.
    ///
    /// A point of the cube is its centre plus d with |d·e| ≤ h along each axis e of the cube, and its coordinate in the image differs from
    /// that of the centre by f (d_x − t d_z)/(z + d_z) with t = x/z.
    fn image(&self, center: &Point, half_m: f64) -> Option<Image> {
        let middle = self.turn * center.coords + self.shift;
        /// Half diagonal of a cube of half side 1, rounded up.
        const DIAGONAL: f64 = 1.732_051;
        let error_m = self.position_error_m + self.turn_error * (middle.norm() + DIAGONAL * half_m);
        let half_m = half_m + error_m;
        let row = |axis: usize| [self.turn[(axis, 0)], self.turn[(axis, 1)], self.turn[(axis, 2)]];
        let along = row(2);
        let depth_m = half_m * (along[0].abs() + along[1].abs() + along[2].abs());
        let depths_m = [middle.z - depth_m, middle.z + depth_m];
        if depths_m[0] <= 0.0 {
            let nowhere = [[f64::NAN; 2]; 2];
            return (depths_m[1] <= self.nearest_m).then_some(Image { depths_m, across_px: nowhere });
        }
        let (inverse, nearer) = (1.0 / middle.z, half_m / depths_m[0]);
        let range = |axis: usize| {
            let (own, slope) = (row(axis), middle[axis] * inverse);
            let spread: f64 = (0..3).map(|edge| (own[edge] - slope * along[edge]).abs()).sum();
            let at = self.center_px[axis] + self.focal_px[axis] * slope;
            let beside = self.focal_px[axis] * spread * nearer;
            [at - beside, at + beside]
        };
        Some(Image { depths_m, across_px: [range(0), range(1)] })
    }

    /// Returns the pixels within `growth_px` of an image; `None` unless all of them exist.
    fn whole_rect(&self, image: &Image, growth_px: f64) -> Option<PixelRect> {
        let is_inside = |axis: usize| {
            let [low, high] = image.across_px[axis];
            low - growth_px >= 0.0 && high + growth_px <= (self.size_px[axis] - 1) as f64
        };
        (is_inside(0) && is_inside(1)).then(|| self.rect(image, growth_px)).flatten()
    }

    /// Returns the existing pixels within `growth_px` of an image; `None` if there are none.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the image")]
    fn rect(&self, image: &Image, growth_px: f64) -> Option<PixelRect> {
        let range = |axis: usize| {
            let ([low, high], last) = (image.across_px[axis], (self.size_px[axis] - 1) as f64);
            let (first, end) = ((low - growth_px).ceil(), (high + growth_px).floor());
            (end >= 0.0 && first <= last && first <= end)
                .then(|| [first.max(0.0) as usize, end.min(last) as usize])
        };
        Some(PixelRect { columns: range(0)?, rows: range(1)? })
    }
}
