use cranny_spatial::nalgebra::Matrix3;
use cranny_spatial::{Point, Vector};

use crate::seen::depth_table::{LeastTable, PixelRect};
use crate::seen::known_solids::{Explained, PixelOf};
use crate::seen::pixel_window::{greater, lesser, window};
use crate::{SensorModel, View};

/// A view, prepared to judge cells of space.
///
/// Let an obstacle contain a ball of radius R = (k + ½ + ε)√2 z(c)/f around c, for a whole number k, the lateral error ε (px) and the
/// focal length f (px), and let p be a point of that ball. The pixel nearest to the image of c is within ½ px of it along both axes. All
/// rays of its footprint (±ε), and of those of the pixels at most k away, meet the ball, at depths of at most z(c) + R sin θ, where θ is
/// the greatest angle of a ray from the optical axis. The pixel is within g = ½ + R f/(z(c) cos θ) of the image of p, and the
/// measurements m of all these pixels have a least true depth l(m) ≤ z(p) + R (1 + sin θ). So no point p of such an obstacle is in a cell
/// if, for *all* pixels within g of the image of the cell, the greatest l(m) among the pixels at most k away exceeds the farthest depth
/// in the cell by R (1 + sin θ). Details of an obstacle that no such ball reaches can be missed ([`detail_m`](Self::detail_m)).
///
/// A known body that is transparent holds no obstacle. Where it fills a pixel, c lies behind its back, or the pixel would show the
/// obstacle; so the depth of its back, plus R sin θ, takes the place of l(m).
pub(crate) struct Sight {
    turn: Matrix3<f64>,
    shift: Vector,
    focal_px: [f64; 2],
    center_px: [f64; 2],
    size_px: [usize; 2],
    sensor: SensorModel,
    /// Twice the sine of half the error of orientation.
    turn_error: f64,
    /// Greatest length of a ray of depth 1.
    slant: f64,
    /// Condition for free space, with k = 0.
    sharp: Condition,
    /// The same with k = 1, for space beside a transparent body, whose edge is one or two pixels wide in an image.
    beside: Option<Condition>,
    /// Negative of the greatest true depth of each pixel; 0 where nothing is measured.
    farthest: LeastTable,
    /// Negative of the least depth of `sharp` in the pixels that concern every cell whose image holds the pixel.
    hopeful: LeastTable,
    /// Least true depth, and the negative of the greatest, of pixels that show no known body; others, and those where nothing is
    /// measured, are infinitely far and near. `None` if no pixel shows a known body.
    other: Option<[LeastTable; 2]>,
}

/// Condition under which a cell is free, for one k.
struct Condition {
    /// R per metre of depth.
    detail_per_m: f64,
    /// R (1 + sin θ) per metre of depth.
    slack_per_m: f64,
    /// g, in pixels.
    growth_px: f64,
    /// Depth up to which each pixel shows that nothing is there (m); 0 where nothing is measured.
    free: LeastTable,
}

/// Radius per metre of depth of the ball that no pixel misses, below which the conditions hold.
const MOST_PER_M: f64 = 0.3;

/// Optical constants of a view.
struct Optics {
    focal_px: [f64; 2],
    /// Sine of the greatest angle of a ray from the optical axis.
    sine: f64,
    lateral_px: f64,
    size_px: [usize; 2],
}

impl Condition {
    /// Creates the condition for k = `reach`, for pixels with these least true depths and contents.
    fn new(optics: &Optics, reach: u8, least_m: &[f64], explained: &Explained) -> Self {
        let Optics { focal_px, sine, lateral_px, size_px: [width, height] } = optics;
        let radius_px = (f64::from(reach) + 0.5 + lateral_px) * std::f64::consts::SQRT_2;
        let per_m = radius_px / focal_px[0].min(focal_px[1]);
        // z(c) ≤ z(p) + R.
        let detail_per_m = per_m / (1.0 - per_m);
        let slack_per_m = detail_per_m * (1.0 + sine);
        /// Rounding of a depth to single precision, in metres.
        const ROUNDED_M: f64 = 1e-6;
        let free_m = |pixel: usize| {
            let least_m = least_m[pixel];
            let known_m = match explained.pixel(pixel) {
                PixelOf::Through(back_m) => back_m * (1.0 + detail_per_m * sine),
                PixelOf::Known(depth_m) => depth_m * (1.0 + slack_per_m),
                PixelOf::Edge | PixelOf::Other => 0.0,
            };
            if least_m > 0.0 { known_m.max(least_m) - ROUNDED_M } else { 0.0 }
        };
        #[allow(clippy::cast_possible_truncation, reason = "less than the reserve for rounding")]
        let mut free: Vec<f32> = (0..least_m.len()).map(|pixel| free_m(pixel) as f32).collect();
        if reach > 0 {
            free = greatest_around(&free, [*width, *height], usize::from(reach));
        }
        let cosine = (1.0 - sine * sine).max(1e-6).sqrt();
        Self {
            detail_per_m,
            slack_per_m,
            growth_px: 0.5 + detail_per_m * focal_px[0].max(focal_px[1]) / cosine,
            free: LeastTable::new(*width, free),
        }
    }
}

/// Returns for each pixel of an image the greatest value among those at most `reach` away along both axes; 0 where one of them is
/// outside of the image.
fn greatest_around(image: &[f32], [width, height]: [usize; 2], reach: usize) -> Vec<f32> {
    let mut greatest = window(image, [width, height], reach, greater);
    for (place, value) in greatest.iter_mut().enumerate() {
        let (u, v) = (place % width, place / width);
        let is_inside = u.min(v) >= reach && u + reach < width && v + reach < height;
        *value = if is_inside { *value } else { 0.0 };
    }
    greatest
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
    /// Prepares a view in which pixels show known bodies; with `with_beside` also for space beside a transparent one.
    pub fn new(view: &View, explained: &Explained, with_beside: bool) -> Self {
        let View { camera, depth, sensor, .. } = view;
        let camera_from_world = camera.world_from_camera.inverse();
        let focal_px = [camera.focal_x_px, camera.focal_y_px];
        let size_px = [camera.width_px, camera.height_px];
        let corners = [0, 1, 2, 3].map(|corner| {
            let u = if corner & 1 == 0 { 0 } else { camera.width_px - 1 };
            let v = if corner & 2 == 0 { 0 } else { camera.height_px - 1 };
            let ray = camera.ray(u as f64, v as f64);
            ray.xy().norm() / ray.norm()
        });
        let sine = corners.into_iter().fold(0.0, f64::max);
        let bounds: Vec<Option<[f64; 2]>> = depth
            .depths_m()
            .iter()
            .map(|measured_m| {
                let measured = f64::from(*measured_m);
                let is_valid = (sensor.nearest_m..=sensor.farthest_m).contains(&measured);
                is_valid
                    .then(|| [sensor.least_true_depth_m(measured), sensor.greatest_true_depth_m(measured)])
            })
            .collect();
        let table = |value: &dyn Fn(usize) -> f64| {
            #[allow(clippy::cast_possible_truncation, reason = "rounding is a thousandth of a reserve")]
            let image = (0..bounds.len()).map(|pixel| value(pixel) as f32).collect();
            LeastTable::new(camera.width_px, image)
        };
        let least_m: Vec<f64> = bounds.iter().map(|bounds| bounds.map_or(0.0, |[least, _]| least)).collect();
        let optics = Optics { focal_px, sine, lateral_px: sensor.lateral_error_px, size_px };
        let condition = |reach: u8| Condition::new(&optics, reach, &least_m, explained);
        let sharp = condition(0);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "some pixels")]
        let around = (sharp.growth_px - 0.5) as usize;
        let hopeful = window(sharp.free.image(), size_px, around, lesser).into_iter().map(|least| -least);
        Self {
            turn: camera_from_world.rotation.to_rotation_matrix().into_inner(),
            shift: camera_from_world.translation.vector,
            focal_px,
            center_px: [camera.center_x_px, camera.center_y_px],
            size_px,
            sensor: *sensor,
            turn_error: 2.0 * libm::sin(0.5 * sensor.turn_error_rad),
            slant: 1.0 / (1.0 - sine * sine).max(1e-6).sqrt(),
            hopeful: LeastTable::new(camera.width_px, hopeful.collect()),
            beside: (with_beside && explained.shows_transparent()).then(|| condition(1)),
            sharp,
            farthest: table(&|pixel| bounds[pixel].map_or(0.0, |[_, farthest]| -farthest)),
            other: (!explained.is_empty()).then(|| {
                let of_other = |pixel: usize| bounds[pixel].filter(|_| !explained.is_of_known(pixel));
                [
                    table(&|pixel| of_other(pixel).map_or(f64::INFINITY, |[least, _]| least)),
                    table(&|pixel| of_other(pixel).map_or(0.0, |[_, farthest]| -farthest)),
                ]
            }),
        }
    }

    /// Returns the greatest diameter of details that can be missed at this depth (m), in metres: everywhere, and beside a transparent
    /// body.
    pub fn detail_m(&self, depth_m: f64) -> [f64; 2] {
        let of = |condition: &Condition| 2.0 * condition.detail_per_m * depth_m;
        [of(&self.sharp), of(self.beside.as_ref().unwrap_or(&self.sharp))]
    }

    /// Returns the thickness of the layer on a known body, at this depth z (m) and placed within this tolerance t (m), in which another
    /// body can be taken for it, in metres: everywhere, and beside a transparent body.
    ///
    /// Along a ray, a measurement that fits the known body is at most A = 2 δ(z)/(1 − s) + t + 2 e before it, with the share s of the
    /// error and the displacement e by the error of the pose, or as far before its nearest point in the window of pixels that are compared,
    /// which is at most w = (½ + ⌈ε⌉) √2 z/f wide, and 2 e. On a surface inclined by α to the ray, that is a height of at most
    /// A sin α + (w + 2 e) cos α for the centre of a ball that is missed, whose top is higher by its radius R.
    pub fn layer_m(&self, depth_m: f64, tolerance_m: f64) -> [f64; 2] {
        let SensorModel { depth_error_share, lateral_error_px, position_error_m, .. } = self.sensor;
        let pose_m = position_error_m + self.turn_error * self.slant * depth_m;
        let along_m =
            2.0 * self.sensor.depth_bound_m(depth_m) / (1.0 - depth_error_share) + tolerance_m + 2.0 * pose_m;
        let focal_px = self.focal_px[0].min(self.focal_px[1]);
        let window_px = (0.5 + lateral_error_px.ceil()) * std::f64::consts::SQRT_2;
        let height_m = along_m.hypot(window_px * depth_m / focal_px + 2.0 * pose_m);
        self.detail_m(depth_m).map(|detail_m| height_m + 0.5 * detail_m)
    }

    /// Returns true if the conditions of a view hold for some space: the ball that its pixels cannot miss is small beside its depth.
    pub fn is_sharp(view: &View) -> bool {
        let focal_px = view.camera.focal_x_px.min(view.camera.focal_y_px);
        let radius_px = (1.5 + view.sensor.lateral_error_px) * std::f64::consts::SQRT_2;
        radius_px < MOST_PER_M * focal_px
    }

    /// Returns the depth of a point of the planning frame, in metres.
    pub fn depth_m(&self, point: &Point) -> f64 {
        (self.turn * point.coords + self.shift).z
    }

    /// Judges a cube by its centre and half side (m), which lies beside a transparent body or not.
    pub fn judge(&self, center: &Point, half_m: f64, is_beside: bool) -> Judgement {
        let Some(image) = self.image(center, half_m) else { return Judgement::Open };
        let [near_m, far_m] = image.depths_m;
        if far_m <= self.sensor.nearest_m {
            return Judgement::Hidden;
        }
        let is_free = |condition: &Condition| {
            self.whole_rect(&image, condition.growth_px).is_some_and(|rect| {
                f64::from(condition.free.least(&rect)) > far_m * (1.0 + condition.slack_per_m)
            })
        };
        let beside = self.beside.as_ref().filter(|_| is_beside);
        if near_m >= self.sensor.nearest_m && (is_free(&self.sharp) || beside.is_some_and(is_free)) {
            return Judgement::Free;
        }
        let Some(rect) = self.rect(&image, 1.0) else { return Judgement::Hidden };
        if beside.is_some() {
            return Judgement::Open;
        }
        let is_hidden = -f64::from(self.farthest.least(&rect)) <= near_m;
        if is_hidden {
            return Judgement::Hidden;
        }
        // A pixel beside the image of the cell concerns all smaller cells there, too.
        let is_blocked = -f64::from(self.hopeful.least(&rect)) <= near_m * (1.0 + self.sharp.slack_per_m);
        if is_blocked { Judgement::Blocked } else { Judgement::Open }
    }

    /// Returns true if a surface may have been measured in a cube; with `but_known`, one of another than the known bodies.
    pub fn shows_surface(&self, center: &Point, half_m: f64, but_known: bool) -> bool {
        let Some(image) = self.image(center, half_m) else { return false };
        let Some(rect) = self.rect(&image, self.sharp.growth_px) else { return false };
        let [near_m, far_m] = image.depths_m;
        let (least, farthest) = match &self.other {
            Some([least, farthest]) if but_known => (least, farthest),
            _ => (&self.sharp.free, &self.farthest),
        };
        #[allow(clippy::cast_possible_truncation, reason = "a reserve covers the rounding")]
        let (far, near) = ((far_m * (1.0 + self.sharp.slack_per_m)) as f32, near_m as f32);
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
    /// that of the centre by f (dx − t dz)/(z + dz) with t = x/z.
    fn image(&self, center: &Point, half_m: f64) -> Option<Image> {
        let middle = self.turn * center.coords + self.shift;
        /// Half diagonal of a cube of half side 1, rounded up.
        const DIAGONAL: f64 = 1.732_051;
        let error_m = self.sensor.position_error_m + self.turn_error * (middle.norm() + DIAGONAL * half_m);
        let half_m = half_m + error_m;
        let row = |axis: usize| [self.turn[(axis, 0)], self.turn[(axis, 1)], self.turn[(axis, 2)]];
        let along = row(2);
        let depth_m = half_m * (along[0].abs() + along[1].abs() + along[2].abs());
        let depths_m = [middle.z - depth_m, middle.z + depth_m];
        if depths_m[0] <= 0.0 {
            let nowhere = [[f64::NAN; 2]; 2];
            return (depths_m[1] <= self.sensor.nearest_m).then_some(Image { depths_m, across_px: nowhere });
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
