use cranny_collision::Cell;
use cranny_scenario::Scenario;
use cranny_task::{IkStatus, PlaceGoal, PlaceRegion};
use serde::Serialize;

use crate::viewer::page_grasps::{self, PageGrasp};
use crate::viewer::page_plan::{PlanEntry, rate_hz};
use crate::viewer::page_recording::RecordingRows;
use crate::viewer::page_robot::{FloorArea, PageRobot};
use crate::viewer::page_scene::PageScene;
use crate::{BodyRecording, PagePlan, Scene, SceneSettings, ViewError, viewer::number_row};

/// Task and plans of a page, as the JSON document that `web/src/data/page_data.ts` describes.
#[derive(Clone, Debug, Serialize)]
pub struct PageData {
    format: &'static str,
    name: String,
    robot: PageRobot,
    #[serde(flatten)]
    scene: PageScene,
    link_spheres: Vec<String>,
    world_from_floor: Option<[f64; 7]>,
    floor_area: Option<FloorArea>,
    places: Vec<PagePlace>,
    grasps: Vec<PageGrasp>,
    plans: Vec<PlanEntry>,
    #[serde(skip_serializing_if = "Option::is_none")]
    recording: Option<RecordingRows>,
    is_live: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    feed: Option<u64>,
}

/// Goal of a placement in the encoding of the page.
#[derive(Clone, Debug, Serialize)]
struct PagePlace {
    name: String,
    /// Pose of the middle of the rectangle, or of the first component of the target.
    world_from_place: [f64; 7],
    #[serde(skip_serializing_if = "Option::is_none")]
    size_m: Option<[f64; 2]>,
}

impl PagePlace {
    fn of(place: &PlaceGoal) -> Self {
        let (pose, size_m) = match &place.spot {
            PlaceRegion::Surface { pose, size_m, .. } => (pose, Some(*size_m)),
            PlaceRegion::Target(pose) => (pose, None),
        };
        Self { name: place.name.clone(), world_from_place: number_row::pose(pose), size_m }
    }
}

/// Settings of the data of a page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PageSettings {
    /// Number of instants of each path with a computed closest pair, at least 2. Default 240: finer than the plot's pixels.
    pub clearance_instants: usize,
}

impl Default for PageSettings {
    fn default() -> Self {
        Self { clearance_instants: 240 }
    }
}

impl PageData {
    /// Collects the data of a page. Clearances are computed in `cell`; `statuses` contains known inverse kinematics results.
    ///
    /// # Errors
    /// See [`Scene::of_task`].
    pub fn of(
        scenario: &Scenario,
        plans: &[PagePlan],
        cell: &Cell,
        statuses: &[IkStatus],
        settings: PageSettings,
    ) -> Result<Self, ViewError> {
        let scene = Scene::of_task(scenario, None, &SceneSettings { grasps: 0 })?;
        let balls = cell.link_balls();
        let spheres = balls.iter().map(|balls| {
            let rows = balls.iter().flat_map(|b| [b.center.x, b.center.y, b.center.z, b.radius_m]);
            number_row::floats32(rows.map(number_row::single))
        });
        Ok(Self {
            format: "cranny-page/1",
            name: scenario.id.clone(),
            robot: PageRobot::of(scenario),
            link_spheres: spheres.collect(),
            world_from_floor: scene.world_from_floor.as_ref().map(number_row::pose),
            floor_area: FloorArea::of(&scenario.robot),
            places: scenario.places.iter().map(PagePlace::of).collect(),
            grasps: page_grasps::all(&scenario.grasps, statuses, plans),
            plans: plans.iter().map(|plan| plan.entry(cell, settings.clearance_instants)).collect(),
            scene: PageScene::of(scene, &scenario.robot),
            recording: None,
            is_live: false,
            feed: None,
        })
    }

    /// Collects the data of a recording: a page without robot, grasps and plans.
    pub fn of_recording(recording: &BodyRecording) -> Self {
        let duration_s = recording.times_s.last().copied().unwrap_or_default();
        let scene = Scene::of_moving_bodies(&recording.thinned(rate_hz(duration_s)));
        Self {
            format: "cranny-page/1",
            name: recording.name.clone(),
            robot: PageRobot::none(),
            link_spheres: Vec::new(),
            world_from_floor: scene.world_from_floor.as_ref().map(number_row::pose),
            floor_area: None,
            places: Vec::new(),
            grasps: Vec::new(),
            plans: Vec::new(),
            recording: scene.motion.as_ref().map(RecordingRows::of),
            scene: PageScene::of_bodies(&scene),
            is_live: false,
            feed: None,
        }
    }

    /// Serializes the document of a page without a server.
    ///
    /// # Errors
    /// [`ViewError::PageData`] for a number that JSON cannot represent.
    pub fn to_json(&self) -> Result<Vec<u8>, ViewError> {
        serde_json::to_vec(self).map_err(|reason| ViewError::PageData { reason })
    }

    /// Serializes the document of a served page. `is_live` is true if the server answers verdict requests; `feed` is the number
    /// of the page if others may follow.
    pub(crate) fn served(&self, is_live: bool, feed: Option<u64>) -> Result<Vec<u8>, ViewError> {
        let page = Self { is_live, feed, ..self.clone() };
        serde_json::to_vec(&page).map_err(|reason| ViewError::PageData { reason })
    }
}
