use cranny_scenario::{Scenario, SeenOptions};
use cranny_sense::{
    Camera, Content, DepthImage, OccupancyGrid, Render, SegmentKind, SensedScene, SensorModel, View,
};
use cranny_spatial::Point;
use rayon::prelude::*;

use crate::prospect::trial;
use crate::{Blockage, CameraKind, ExploreError, MetCell};

/// Predictions of the cells that a view would show to be free, by the map itself: the view is predicted from the points measured so
/// far and the known bodies, and mapped around the blocking cells.
pub(crate) struct Predictions<'a> {
    known: Scenario,
    options: SeenOptions,
    sensor: SensorModel,
    cells: &'a [MetCell],
    /// Points measured before, without those of known bodies, with the widths of their pixels (m).
    points: Vec<(Point, f64)>,
    /// Cells of the present map.
    grid: OccupancyGrid,
    /// Kind of the camera: in hand, pixels of the robot are dropped.
    kind: CameraKind,
}

/// Depth of a pixel that looks through unseen space onto nothing known, in metres: something may return a depth there.
const FAR_M: f64 = 3.0;

/// Space around the blocking cells that is mapped, in metres.
const AROUND_M: f64 = 0.02;

/// Difference of a depth from that of a known body, beyond the bound of its error, up to which a pixel shows the body, in metres.
const KNOWN_M: f64 = 0.01;

/// Maximum width of a measured point in a predicted image, in pixels.
const MOST_WIDTH_PX: f64 = 9.0;

impl<'a> Predictions<'a> {
    /// Prepares predictions for a camera with this sensor from earlier views; `None` without views or a map.
    ///
    /// # Errors
    /// [`ExploreError::Sense`] for a body that cannot be rendered.
    pub fn new(
        seen: &Scenario,
        blockage: &'a Blockage,
        sensor: SensorModel,
        views: &[View],
        kind: CameraKind,
    ) -> Result<Option<Self>, ExploreError> {
        let Some(space) = seen.seen.as_ref().filter(|_| !views.is_empty()) else { return Ok(None) };
        let known = seen.without_map()?;
        let around = blockage.around().grown(AROUND_M);
        let mut points = Vec::new();
        for view in views {
            let bodies = known.sensed_at(view.configuration.as_ref().unwrap_or(&known.start))?;
            points.extend(points_of(view, &bodies.render(&view.camera)));
        }
        Ok(Some(Self {
            known,
            options: SeenOptions { region: Some(around), ..space.options.clone() },
            sensor,
            cells: &blockage.cells,
            points,
            grid: OccupancyGrid::new(&space.map),
            kind,
        }))
    }

    /// Returns the number of blocking cells that a camera among known bodies would show to be free.
    ///
    /// # Errors
    /// Those of [`Scenario::with_seen`].
    pub fn frees(&self, camera: &Camera, known: &SensedScene) -> Result<usize, ExploreError> {
        let view = self.predicted(camera, known)?;
        let seen = self.known.with_seen(&[view], &self.options)?;
        let Some(space) = &seen.seen else { return Ok(0) };
        let grid = OccupancyGrid::new(&space.map);
        let is_free = |cell: &&MetCell| grid.at(&cell.aabb.center) == Some(Content::Free);
        Ok(self.cells.iter().filter(is_free).count())
    }

    /// Predicts the view of a camera.
    fn predicted(&self, camera: &Camera, known: &SensedScene) -> Result<View, ExploreError> {
        let (width, height) = (camera.width_px, camera.height_px);
        let Render { depth, segments } = known.render(camera);
        let robot: Vec<bool> =
            known.segments().iter().map(|segment| segment.kind == SegmentKind::Robot).collect();
        let is_robot = |segment: u16| segment > 0 && robot[usize::from(segment) - 1];
        let mut depths_m: Vec<f32> = depth.depths_m().to_vec();
        let camera_from_world = camera.world_from_camera.inverse();
        let [most_u, most_v] = [width, height].map(|side| side as f64);
        for (point, width_m) in &self.points {
            let in_camera = camera_from_world * point;
            let Some([u, v]) = camera.project(&in_camera) else { continue };
            let half_px = (0.5 * width_m * camera.focal_x_px / in_camera.z).min(0.5 * MOST_WIDTH_PX);
            let [low, high] = [-half_px, half_px].map(|beside| [(u + beside).round(), (v + beside).round()]);
            if high[0] < 0.0 || high[1] < 0.0 || low[0] >= most_u || low[1] >= most_v {
                continue;
            }
            #[allow(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "clamped to the image"
            )]
            let range =
                |axis: usize, most: f64| low[axis].max(0.0) as usize..=high[axis].min(most - 1.0) as usize;
            #[allow(clippy::cast_possible_truncation, reason = "depths are stored as f32")]
            let depth_m = in_camera.z as f32;
            for row in range(1, most_v) {
                for column in range(0, most_u) {
                    let place = &mut depths_m[row * width + column];
                    if place.is_nan() || depth_m < *place {
                        *place = depth_m;
                    }
                }
            }
        }
        let far = self.far(camera)?;
        for (pixel, depth_m) in depths_m.iter_mut().enumerate() {
            let is_robot = is_robot(segments[pixel]);
            if is_robot && self.kind == CameraKind::Hand {
                *depth_m = f32::NAN;
            } else if depth_m.is_nan() && !is_robot && far.shows(pixel % width, pixel / width) {
                #[allow(clippy::cast_possible_truncation, reason = "a depth")]
                let far_m = FAR_M.min(self.sensor.farthest_m) as f32;
                *depth_m = far_m;
            }
        }
        let depth = DepthImage::new(width, height, depths_m)?;
        Ok(View::new("predicted", camera.clone(), depth, self.sensor)?)
    }

    /// Returns the pixels whose rays pass unseen space.
    fn far(&self, camera: &Camera) -> Result<Far, ExploreError> {
        let coarse = trial(camera)?;
        let (columns, rows) = (coarse.width_px, coarse.height_px);
        let eye = Point::from(camera.world_from_camera.translation.vector);
        let passes = (0..columns * rows).into_par_iter().map(|pixel| {
            let ray = coarse.ray((pixel % columns) as f64, (pixel / columns) as f64);
            let direction = camera.world_from_camera.rotation * ray.normalize();
            let mut along = self.grid.along(&eye, &direction, [0.0, FAR_M]);
            along.any(|content| content == Some(Content::Unseen))
        });
        Ok(Far { passes: passes.collect(), columns, rows, share: columns as f64 / camera.width_px as f64 })
    }
}

/// Coarse image of the pixels whose rays pass unseen space.
struct Far {
    passes: Vec<bool>,
    columns: usize,
    rows: usize,
    /// Columns per column of the whole image.
    share: f64,
}

impl Far {
    fn shows(&self, u: usize, v: usize) -> bool {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a pixel of the image")]
        let [column, row] = [u, v].map(|at| ((at as f64 + 0.5) * self.share) as usize);
        self.passes[row.min(self.rows - 1) * self.columns + column.min(self.columns - 1)]
    }
}

/// Returns the measured points of a view with the widths of their pixels (m), without those that show known bodies.
fn points_of(view: &View, known: &Render) -> Vec<(Point, f64)> {
    let View { camera, depth, sensor, .. } = view;
    let focal_px = camera.focal_x_px.min(camera.focal_y_px);
    let point = |pixel: usize| {
        let (u, v) = (pixel % camera.width_px, pixel / camera.width_px);
        let depth_m = f64::from(depth.depth_m(u, v)?);
        let known_m = known.depth.depth_m(u, v).map(f64::from);
        let near_m = sensor.depth_bound_m(depth_m) + KNOWN_M;
        if known_m.is_some_and(|known_m| (known_m - depth_m).abs() <= near_m) {
            return None;
        }
        let in_camera = Point::from(camera.ray(u as f64, v as f64) * depth_m);
        Some((camera.world_from_camera * in_camera, depth_m / focal_px))
    };
    (0..camera.pixel_count()).filter_map(point).collect()
}
