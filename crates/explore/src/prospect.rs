use cranny_scenario::Scenario;
use cranny_sense::{Camera, Content, OccupancyGrid, Render, SeenMap, SenseError, SensedScene, SensorModel};
use cranny_spatial::{Point, Vector};

use crate::{Blockage, ExploreError, MetCell};

/// Prospects of cameras: how many blocking cells they would see.
///
/// A camera sees the centre of a cell if it lies within its image and its range, and no occupied cell and no known body is between the
/// two. Unseen cells count as transparent, and so do the blocking cells themselves.
pub(crate) struct Prospects<'a> {
    grid: OccupancyGrid,
    /// Known bodies, without the robot.
    known: SensedScene,
    scenario: &'a Scenario,
    sensor: SensorModel,
    /// Centres of the cells, and the depth (m) from which each is seen sharply.
    centers: Vec<(Point, f64)>,
}

/// Prospect of a camera.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Prospect {
    /// Value for the choice: the sum over the cells, less if a cell is far away, or nothing behind it returns a depth.
    pub value: f64,
    /// Number of cells that the camera sees, of those that were considered.
    pub sees: usize,
}

/// Width of the image in which a candidate is judged, in pixels.
const TRIAL_WIDTH_PX: f64 = 64.0;

/// Depth from which a cell is seen sharply, in metres: farther away, a pixel is wide, and the space beside surfaces stays unseen. A cell
/// in which a surface may have been measured lies beside one.
const SHARP_M: f64 = 0.35;
const OCCUPIED_SHARP_M: f64 = 0.15;

/// Distance from the border of the image within which cells are not counted, as a share of its width.
const BORDER_SHARE: f64 = 0.02;

/// Distance behind a cell within which a surface is sought, in metres.
const BEHIND_M: f64 = 2.0;

/// Weights of a cell behind which a surface is known, behind which there is unseen space, and behind which there is neither: a pixel
/// without a depth shows nothing.
const WEIGHTS: [f64; 3] = [1.0, 0.7, 0.2];

/// Least depth of anything before a free-standing camera, in metres, and distance within which nothing may have been measured.
pub(crate) const LEAST_ROOM_M: f64 = 0.1;
const LEAST_GAP_M: f64 = 0.05;

impl<'a> Prospects<'a> {
    /// Prepares the prospects of cameras with this sensor for the cells of a blockage.
    ///
    /// # Errors
    /// [`ExploreError::Sense`] for a body that cannot be rendered.
    pub fn new(
        scenario: &'a Scenario,
        map: &SeenMap,
        blockage: &Blockage,
        sensor: SensorModel,
    ) -> Result<Self, ExploreError> {
        let mut grid = OccupancyGrid::new(map);
        for cell in &blockage.cells {
            grid.fill(&cell.aabb, Content::Unseen);
        }
        let known = SensedScene::of_world(&scenario.without_map()?.world)?;
        let sharp_m = |cell: &MetCell| if cell.is_occupied { OCCUPIED_SHARP_M } else { SHARP_M };
        let centers = blockage.cells.iter().map(|cell| (cell.aabb.center, sharp_m(cell))).collect();
        Ok(Self { grid, known, scenario, sensor, centers })
    }

    /// Returns the number of cells.
    pub fn count(&self) -> usize {
        self.centers.len()
    }

    /// Returns the known bodies without the robot.
    pub fn bodies(&self) -> &SensedScene {
        &self.known
    }

    /// Returns the known bodies with the robot at `q` (m, rad; one per joint).
    ///
    /// # Errors
    /// [`SenseError::NoSurface`].
    pub fn with_robot(&self, q: &[f64]) -> Result<SensedScene, SenseError> {
        self.known.clone().with_robot(&self.scenario.robot, q)
    }

    /// Returns true if nothing known is at or close before a camera.
    ///
    /// # Errors
    /// [`SenseError::Camera`].
    pub fn is_free(&self, camera: &Camera, scene: &SensedScene) -> Result<bool, SenseError> {
        let eye = Point::from(camera.world_from_camera.translation.vector);
        let mut places = offsets(LEAST_GAP_M, self.grid.side_m()).map(|offset| eye + offset);
        if places.any(|place| self.grid.at(&place) == Some(Content::Occupied)) {
            return Ok(false);
        }
        Ok(scene.render(&trial(camera)?).has_room(LEAST_ROOM_M))
    }

    /// Returns the prospect of a camera among known bodies, judged by every `stride`-th cell.
    ///
    /// # Errors
    /// [`SenseError::Camera`].
    pub fn of(&self, camera: &Camera, scene: &SensedScene, stride: usize) -> Result<Prospect, SenseError> {
        let trial = trial(camera)?;
        let render = scene.render(&trial);
        let mut prospect = Prospect::default();
        for (center, sharp_m) in self.centers.iter().step_by(stride) {
            let weight = self.weight(center, *sharp_m, &trial, &render);
            prospect.value += weight;
            prospect.sees += usize::from(weight > 0.0);
        }
        Ok(prospect)
    }

    /// Returns the weight of a point in the value of a camera; 0 if it is not seen.
    fn weight(&self, point: &Point, sharp_m: f64, camera: &Camera, render: &Render) -> f64 {
        let in_camera = camera.world_from_camera.inverse_transform_point(point);
        if !(self.sensor.nearest_m..=self.sensor.farthest_m).contains(&in_camera.z) {
            return 0.0;
        }
        let Some([u, v]) = camera.project(&in_camera) else { return 0.0 };
        let (width, height) = (camera.width_px as f64, camera.height_px as f64);
        let border = BORDER_SHARE * width - 0.5;
        let is_inside = u >= border && v >= border && u <= width - 1.0 - border && v <= height - 1.0 - border;
        if !is_inside {
            return 0.0;
        }
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a pixel of the image")]
        let (column, row) = (u.round().max(0.0) as usize, v.round().max(0.0) as usize);
        let known_m = render.depth.depth_m(column, row).map(f64::from);
        if known_m.is_some_and(|known_m| known_m <= in_camera.z) {
            return 0.0;
        }
        let eye = Point::from(camera.world_from_camera.translation.vector);
        let (towards, distance_m) = (eye - point, (eye - point).norm());
        let direction = towards / distance_m;
        let side_m = self.grid.side_m();
        if self.grid.is_blocked(point, &direction, [side_m, distance_m - LEAST_GAP_M]) {
            return 0.0;
        }
        let [surface, unseen, nothing] = WEIGHTS;
        let behind = if known_m.is_some() { surface } else { nothing };
        let away = -direction;
        let mut beyond = self.grid.along(point, &away, [side_m, BEHIND_M]);
        let behind = beyond.try_fold(behind, |best: f64, content| match content {
            Some(Content::Occupied) => Err(surface),
            Some(Content::Unseen) => Ok(best.max(unseen)),
            _ => Ok(best),
        });
        let (Ok(behind) | Err(behind)) = behind;
        behind * (sharp_m / in_camera.z).min(1.0)
    }
}

/// Returns points of a cube of this half side (m) around the origin, at most `side_m` (m) apart.
fn offsets(half_m: f64, side_m: f64) -> impl Iterator<Item = Vector> {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "some points")]
    let count = (2.0 * half_m / side_m).ceil().clamp(1.0, 20.0) as u32;
    let at = move |index: u32| -half_m + 2.0 * half_m * f64::from(index) / f64::from(count);
    let indices = move || 0..=count;
    indices().flat_map(move |x| {
        indices().flat_map(move |y| indices().map(move |z| Vector::new(at(x), at(y), at(z))))
    })
}

/// Returns a camera at the same pose with fewer pixels.
pub(crate) fn trial(camera: &Camera) -> Result<Camera, SenseError> {
    let share = TRIAL_WIDTH_PX / camera.width_px as f64;
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "some pixels")]
    let height_px = (camera.height_px as f64 * share).round().max(1.0) as usize;
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "some pixels")]
    let width_px = TRIAL_WIDTH_PX as usize;
    let center = |center_px: f64| (center_px + 0.5) * share - 0.5;
    Camera::new(
        [width_px, height_px],
        [camera.focal_x_px * share, camera.focal_y_px * share],
        [center(camera.center_x_px), center(camera.center_y_px)],
        camera.world_from_camera,
    )
}
