use cranny_explore::{
    Blockage, Candidate, ExploreError, FirstMeeting, NextView, find_blockage, next_fixed_view,
};
use cranny_file::counted;
use cranny_plan::{Budget, Observer};
use cranny_robot::Robot;
use cranny_scenario::Scenario;
use cranny_sense::{Camera, CameraFrame, PlacedCamera, SensorModel};
use cranny_solve::Request;
use cranny_spatial::{Point, Pose, Vector};
use cranny_task::{Criterion, Problem};
use serde::Serialize;

use crate::failure::Failure;

/// Cells of seen space that block the best candidate, and the next view of them.
#[derive(Serialize)]
pub struct Obstruction {
    blocked_by: ShownBlockage,
    next_view: Option<ShownView>,
}

/// Cells that block a candidate, in the planning frame.
#[derive(Serialize)]
struct ShownBlockage {
    /// Blocked candidate: `path` if it is free of all that was measured, `blocked-path`, or `grasp`.
    candidate: &'static str,
    /// Index of the grasp.
    #[serde(skip_serializing_if = "Option::is_none")]
    grasp: Option<usize>,
    cells: usize,
    /// Number of cells that no view has seen into; in the others, a surface may have been measured.
    unseen_cells: usize,
    volume_m3: f64,
    center_m: [f64; 3],
    size_m: [f64; 3],
    /// Edge of the candidate, from 0, position along it in [0, 1], and link that first meets one of the cells.
    first_edge: Option<usize>,
    first_at: Option<f64>,
    first_link: Option<String>,
    /// Way points of the candidate (m, rad); one for a grasp.
    waypoints: Vec<Vec<f64>>,
}

/// Camera pose in the planning frame.
#[derive(Serialize)]
struct ShownView {
    position_m: [f64; 3],
    quaternion_xyzw: [f64; 4],
    /// Number of the blocking cells that the camera is expected to see.
    sees: usize,
    /// Number of them that the view is predicted to show to be free, if earlier views are known.
    #[serde(skip_serializing_if = "Option::is_none")]
    frees: Option<usize>,
    /// Number of better poses that were refused.
    refused: usize,
    /// In hand: proven path from the start to the configuration of the view (m, rad).
    #[serde(skip_serializing_if = "Vec::is_empty")]
    waypoints: Vec<Vec<f64>>,
}

/// Maximum time of each search for a candidate after a search has failed.
const SEARCH_S: u64 = 5;

/// Camera that is proposed for the next view: width and height (px), and horizontal field of view (degrees).
const SIZE_PX: [usize; 2] = [320, 240];
const FIELD_DEG: f64 = 70.0;

impl Obstruction {
    /// Shows a blockage with its next view.
    pub fn new(blockage: &Blockage, next: Option<&NextView>, robot: &Robot) -> Self {
        let first = blockage.first;
        let (candidate, grasp) = match &blockage.candidate {
            Candidate::Path(_) => ("path", None),
            Candidate::BlockedPath(_) => ("blocked-path", None),
            Candidate::Grasp { grasp, .. } => ("grasp", Some(*grasp)),
        };
        let around = blockage.around();
        let blocked_by = ShownBlockage {
            candidate,
            grasp,
            cells: blockage.cells.len(),
            unseen_cells: blockage.unseen_count(),
            volume_m3: blockage.volume_m3(),
            center_m: coordinates(&blockage.center().coords),
            size_m: coordinates(&(around.half_extents * 2.0)),
            first_edge: first.map(|first| first.edge),
            first_at: first.map(|first| first.at),
            first_link: first.map(|FirstMeeting { link, .. }| robot.links()[link].name.clone()),
            waypoints: blockage.candidate.waypoints().to_vec(),
        };
        let next_view = next.map(|NextView { camera, sees, frees, refused, motion }| {
            let Pose { rotation, translation } = camera.world_from_camera;
            ShownView {
                position_m: coordinates(&translation.vector),
                quaternion_xyzw: rotation.coords.into(),
                sees: *sees,
                frees: *frees,
                refused: *refused,
                waypoints: motion.clone(),
            }
        });
        Self { blocked_by, next_view }
    }

    /// Searches for what blocks a problem whose search has failed; `None` if it does not concern seen space.
    pub fn of_failed(
        scenario: &Scenario,
        problem: &Problem,
        request: &Request,
        observer: &mut dyn Observer,
    ) -> Result<Option<Self>, Failure> {
        let is_meant = problem.criterion() == Criterion::Exact && request.stages.is_empty();
        let (Some(space), Some(cell)) = (scenario.seen.as_ref().filter(|_| is_meant), problem.cell()) else {
            return Ok(None);
        };
        let time = request.budget.time.min(std::time::Duration::from_secs(SEARCH_S));
        let request = Request { budget: Budget { time, ..request.budget }, ..request.clone() };
        let blockage = find_blockage(scenario, cell.margins(), &request, None, observer)?;
        let Some(blockage) = blockage.filter(|blockage| !blockage.cells.is_empty()) else { return Ok(None) };
        let camera = Camera::with_field_of_view(SIZE_PX, FIELD_DEG.to_radians(), Pose::identity());
        let camera = PlacedCamera {
            name: "next".to_owned(),
            frame: CameraFrame::World,
            camera: camera.map_err(ExploreError::from)?,
            sensor: space.sensors.first().copied().unwrap_or_else(SensorModel::default),
            configuration: None,
        };
        let next = next_fixed_view(scenario, &blockage, &camera, &[], &mut |_| true)?;
        Ok(Some(Self::new(&blockage, next.as_ref(), problem.robot())))
    }

    /// Returns the lines of a page, each with its heading.
    pub fn lines(&self) -> Vec<(&'static str, String)> {
        let ShownBlockage { candidate, grasp, cells, unseen_cells, volume_m3, center_m, size_m, .. } =
            &self.blocked_by;
        let kinds = match (unseen_cells, cells - unseen_cells) {
            (unseen, 0) => counted(*unseen, "unseen cell"),
            (0, occupied) => counted(occupied, "occupied cell"),
            (unseen, occupied) => {
                format!("{} and {}", counted(*unseen, "unseen cell"), counted(occupied, "occupied cell"))
            }
        };
        let what = match (*candidate, grasp) {
            (_, Some(grasp)) => format!("grasp {grasp}"),
            ("path", _) => "a path that is free of all that was measured".to_owned(),
            _ => "every path that was found".to_owned(),
        };
        let first = match (&self.blocked_by.first_link, self.blocked_by.first_edge, self.blocked_by.first_at)
        {
            (Some(link), _, _) if *candidate == "grasp" => format!("; {link} meets them"),
            (Some(link), Some(edge), Some(at)) => {
                format!("; {link} meets them first, {:.1} % along segment {}", 100.0 * at, edge + 1)
            }
            _ => String::new(),
        };
        let [width, depth, height] = size_m;
        let mut lines = vec![(
            "blocked by",
            format!(
                "{kinds} ({:.1} l) about {} m, {width:.2} × {depth:.2} × {height:.2} m, block {what}{first}",
                1e3 * volume_m3,
                text_of(center_m)
            ),
        )];
        lines.push((
            "next view",
            self.next_view.as_ref().map_or_else(
                || "none sees any of these cells from a position that can be reached".to_owned(),
                |next| next.text(*cells),
            ),
        ));
        lines
    }
}

impl ShownView {
    fn text(&self, cells: usize) -> String {
        let [x, y, z, w] = self.quaternion_xyzw;
        let rotation = cranny_spatial::nalgebra::Quaternion::new(w, x, y, z);
        let along = cranny_spatial::Rotation::from_quaternion(rotation) * Vector::z();
        let refused = match self.refused {
            0 => String::new(),
            count => format!("; {} before it cannot be reached", counted(count, "pose")),
        };
        let frees =
            self.frees.map_or_else(String::new, |frees| format!(", {frees} are predicted to be free"));
        let by_hand = match self.waypoints.len() {
            0 => String::new(),
            count => format!(", reached by a proven motion of {}", counted(count, "way point")),
        };
        format!(
            "at {} m along {}{by_hand}: sees up to {} of the {cells}{frees}{refused}",
            text_of(&self.position_m),
            text_of(&coordinates(&along)),
            self.sees
        )
    }
}

fn coordinates(vector: &Vector) -> [f64; 3] {
    [vector.x, vector.y, vector.z]
}

/// Formats a point or direction.
pub fn text_of(coordinates: &[f64; 3]) -> String {
    let [x, y, z] = coordinates;
    format!("({x:.3}, {y:.3}, {z:.3})")
}

/// Returns the coordinates of the position of a camera.
pub fn position_of(camera: &Camera) -> [f64; 3] {
    coordinates(&Point::from(camera.world_from_camera.translation.vector).coords)
}
