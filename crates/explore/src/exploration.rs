use cranny_collision::Margins;
use cranny_plan::{Budget, Observer, Outcome};
use cranny_scenario::{Scenario, SeenOptions};
use cranny_sense::{Camera, CameraFrame, Noise, PlacedCamera, SensedScene, StoredView, View, Views};
use cranny_shape::Aabb;
use cranny_solve::{Answer, Request, solve};
use cranny_spatial::other_seed;
use cranny_task::Criterion;

use crate::blockage::is_proven;
use crate::given_path::with_given_path;
use crate::prospect::{LEAST_ROOM_M, trial};
use crate::{
    Blockage, CameraKind, Candidate, ExploreError, NextView, find_blockage, next_fixed_view, next_hand_view,
};

/// Settings of an exploration.
#[derive(Clone, Debug)]
pub struct ExploreSettings {
    /// Maximum number of views, with the first one. Default: 8.
    pub views: usize,
    /// Cameras. The first view is that of the first one, with the robot at its start; the next views are those of the first camera
    /// of the kind. Default: the first of the scenario's default cameras.
    pub cameras: Vec<PlacedCamera>,
    /// Kind of the camera that is moved.
    pub kind: CameraKind,
    /// Seed of the errors of all views, within the bounds of their sensors; `None`: exact depths.
    pub noise_seed: Option<u64>,
    /// Demanded clearances.
    pub margins: Margins,
    /// Request for the plan; its budget is that of each search. Default: 5 s.
    pub request: Request,
    /// Names of the obstacles whose places are known.
    pub known: Vec<String>,
    /// Options of the map.
    pub options: SeenOptions,
}

impl Default for ExploreSettings {
    fn default() -> Self {
        let budget = Budget { time: std::time::Duration::from_secs(5), ..Budget::default() };
        Self {
            views: 8,
            cameras: Vec::new(),
            kind: CameraKind::default(),
            noise_seed: None,
            margins: Margins::default(),
            request: Request { budget, ..Request::default() },
            known: Vec::new(),
            options: SeenOptions::default(),
        }
    }
}

/// Result of one view.
#[derive(Clone, Debug)]
pub struct ViewReport {
    /// Name of the view.
    pub name: String,
    /// Camera at its stated pose.
    pub camera: Camera,
    /// In hand: proven motion from the start to the configuration of the view (m, rad; one value per joint), else empty.
    pub motion: Vec<Vec<f64>>,
    /// Volume of the mapped region that all views until then show to be free, or that lies inside of known bodies, in cubic metres
    /// ([`SeenMap::free_m3`](cranny_sense::SeenMap::free_m3)).
    pub free_m3: f64,
    /// Volume in which surfaces may have been measured.
    pub occupied_m3: f64,
    /// Volume that no view has seen.
    pub unseen_m3: f64,
    /// Outcome of the search in the space seen until then.
    pub outcome: Outcome,
    /// Cells that block the best candidate, if the search failed and there is a candidate.
    pub blockage: Option<Blockage>,
    /// Next view, if there is one; that of the last report is not taken.
    pub next: Option<NextView>,
}

/// Result of an exploration.
#[derive(Clone, Debug)]
pub struct Explored {
    /// Views in order, each with what it changed.
    pub reports: Vec<ViewReport>,
    /// All views.
    pub views: Views,
    /// Known bodies with the seen space as obstacles.
    pub seen: Scenario,
    /// Answer of the last search.
    pub answer: Answer,
}

/// Explores a true scenario by rendered views until a plan is proven in the space that they show, or no view is left.
///
/// 1. A view is rendered, with errors within the bounds of its sensor, and the map is made of all views.
/// 2. The plan is searched for in the seen space.
/// 3. Without one, the cells that block the best candidate are collected ([`find_blockage`]). A candidate that meets none is the plan,
///    if it is proven.
/// 4. The next view is chosen by these cells ([`next_fixed_view`], [`next_hand_view`]). A pose of a free-standing camera at which
///    something is in the true scene is refused, as anyone who places a camera would see.
///
/// The robot stands at its start in the map and in the plan: from a view in hand, it returns there on the same path.
/// `report` is called after each view.
///
/// # Errors
/// [`ExploreError::HasSeen`], [`ExploreError::Criterion`], [`ExploreError::NoHandCamera`], [`ExploreError::LooseCamera`]; those of the
/// scenario, the cameras and [`solve`].
///
/// # Panics
/// If [`ExploreSettings::views`] is 0.
pub fn explore(
    truth: &Scenario,
    settings: &ExploreSettings,
    observer: &mut dyn Observer,
    report: &mut dyn FnMut(&ViewReport),
) -> Result<Explored, ExploreError> {
    assert!(settings.views > 0, "an exploration has a first view");
    let mut exploration = Exploration::new(truth, settings)?;
    let (mut camera, mut motion) = (exploration.first.clone(), Vec::new());
    let mut reports = Vec::new();
    loop {
        let (one, seen, answer) = exploration.look(&camera, motion, observer)?;
        report(&one);
        let next = one.next.clone();
        reports.push(one);
        match next {
            Some(next) if !answer.is_solved() && reports.len() < settings.views => {
                camera = exploration.moved(&next);
                motion = next.motion;
            }
            _ => {
                let stored = |view| StoredView { view, segments: None };
                let views = exploration.views.into_iter().map(stored).collect();
                return Ok(Explored { reports, views: Views { views, segments: Vec::new() }, seen, answer });
            }
        }
    }
}

/// State of an exploration.
struct Exploration<'a> {
    truth: &'a Scenario,
    settings: &'a ExploreSettings,
    known: Scenario,
    /// Bodies of the true scenario without the robot.
    bodies: SensedScene,
    /// Camera of the first view.
    first: PlacedCamera,
    /// Camera of the next views.
    mover: PlacedCamera,
    views: Vec<View>,
    candidate: Option<Candidate>,
}

impl<'a> Exploration<'a> {
    fn new(truth: &'a Scenario, settings: &'a ExploreSettings) -> Result<Self, ExploreError> {
        if truth.seen.is_some() {
            return Err(ExploreError::HasSeen { id: truth.id.clone() });
        }
        if truth.criterion != Criterion::Exact {
            return Err(ExploreError::Criterion { id: truth.id.clone() });
        }
        let cameras = if settings.cameras.is_empty() {
            truth.default_cameras(&truth.sensed()?, 1)?
        } else {
            settings.cameras.clone()
        };
        let is_fixed = |camera: &&PlacedCamera| camera.frame == CameraFrame::World;
        let mover = match settings.kind {
            // Any camera can be taken off.
            CameraKind::Fixed => cameras.iter().find(is_fixed).or(cameras.first()),
            CameraKind::Hand => cameras.iter().find(|camera| !is_fixed(camera)),
        };
        let Some((first, mover)) = cameras.first().zip(mover) else { return Err(ExploreError::NoHandCamera) };
        Ok(Self {
            truth,
            settings,
            known: truth.with_known_bodies_only(&settings.known)?,
            bodies: SensedScene::of_world(&truth.world)?,
            first: first.clone(),
            // It is where the robot brings it.
            mover: PlacedCamera { configuration: None, ..mover.clone() },
            views: Vec::new(),
            candidate: None,
        })
    }

    /// Returns the camera of the next views at its next pose.
    fn moved(&self, next: &NextView) -> PlacedCamera {
        match self.settings.kind {
            CameraKind::Fixed => {
                PlacedCamera { frame: CameraFrame::World, camera: next.camera.clone(), ..self.mover.clone() }
            }
            CameraKind::Hand => self.mover.clone(),
        }
    }

    /// Takes a view at the end of a motion, and plans in the space that all views show.
    fn look(
        &mut self,
        camera: &PlacedCamera,
        motion: Vec<Vec<f64>>,
        observer: &mut dyn Observer,
    ) -> Result<(ViewReport, Scenario, Answer), ExploreError> {
        let ExploreSettings { margins, request, options, .. } = self.settings;
        // 1.
        let view = self.rendered(camera, motion.last())?;
        let (name, stated) = (view.name.clone(), view.camera.clone());
        self.views.push(view);
        let seen = self.known.with_seen(&self.views, options)?;
        // 2.
        let problem = seen.problem(*margins)?;
        let mut answer = solve(&problem, request, observer)?;
        // 3.
        let is_open = !answer.is_solved() && !observer.should_stop();
        let blockage = if is_open {
            find_blockage(&seen, *margins, request, self.candidate.as_ref(), observer)?
        } else {
            None
        };
        self.candidate = blockage.as_ref().map(|blockage| blockage.candidate.clone());
        if let Some(Candidate::Path(path)) = &self.candidate
            && is_proven(&problem, path)?
        {
            let given = solve(&problem, &with_given_path(request, path)?, observer)?;
            answer = if given.is_solved() { given } else { answer };
        }
        // 4.
        let blockage = blockage.filter(|blockage| !answer.is_solved() && !blockage.cells.is_empty());
        let next = match &blockage {
            Some(blockage) if !observer.should_stop() => self.next(&seen, blockage, observer)?,
            _ => None,
        };
        if !answer.is_solved() && observer.should_stop() {
            answer.outcome = Outcome::Cancelled;
        }
        // After a stop, a view that was not found may exist.
        let is_whole = answer.outcome != Outcome::Cancelled;
        let (blockage, next) = (blockage.filter(|_| is_whole), next.filter(|_| is_whole));
        let volume_m3 = |cells: &[Aabb]| cells.iter().map(|cell| 8.0 * cell.half_extents.product()).sum();
        let map = seen.seen.as_ref().map(|space| space.map.clone());
        let volumes =
            map.map_or([0.0; 3], |map| [map.free_m3(), volume_m3(map.occupied()), volume_m3(map.unseen())]);
        let [free_m3, occupied_m3, unseen_m3] = volumes;
        let outcome = answer.outcome;
        let report = ViewReport {
            name,
            camera: stated,
            motion,
            free_m3,
            occupied_m3,
            unseen_m3,
            outcome,
            blockage,
            next,
        };
        Ok((report, seen, answer))
    }

    /// Renders a view in the true scenario with the robot at `q` (m, rad; one value per joint) or at its start.
    fn rendered(&self, camera: &PlacedCamera, q: Option<&Vec<f64>>) -> Result<View, ExploreError> {
        let (robot, index) = (&*self.truth.robot, self.views.len());
        let noise = Noise {
            factor: if self.settings.noise_seed.is_some() { 1.0 } else { 0.0 },
            seed: other_seed(self.settings.noise_seed.unwrap_or(0), index as u64),
            ..Noise::default()
        };
        let q = q.or(camera.configuration.as_ref());
        let at = q.unwrap_or(&self.truth.start);
        let scene = self.bodies.clone().with_robot(robot, at)?;
        let placed = camera.at(robot, at)?;
        let view = scene.view(format!("view{}", index + 1), &placed, &camera.sensor, &noise)?;
        Ok(view.at_configuration(q.cloned()))
    }

    /// Chooses the next view.
    fn next(
        &self,
        seen: &Scenario,
        blockage: &Blockage,
        observer: &mut dyn Observer,
    ) -> Result<Option<NextView>, ExploreError> {
        match self.settings.kind {
            CameraKind::Fixed => {
                let scene = self.truth.sensed()?;
                let mut is_free = |camera: &Camera| is_free_in(&scene, camera);
                next_fixed_view(seen, blockage, &self.mover, &self.views, &mut is_free)
            }
            CameraKind::Hand => {
                let seed = other_seed(self.settings.request.seed, self.views.len() as u64);
                next_hand_view(
                    seen,
                    self.settings.margins,
                    blockage,
                    &self.mover,
                    &self.views,
                    seed,
                    observer,
                )
            }
        }
    }
}

/// Returns true if a free-standing camera is free in the true scenario.
fn is_free_in(scene: &SensedScene, camera: &Camera) -> bool {
    trial(camera).is_ok_and(|camera| scene.render(&camera).has_room(LEAST_ROOM_M))
}
