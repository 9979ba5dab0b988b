use std::sync::Arc;

use cranny_sense::{KnownBody, SeenMap, SeenSettings, SensorModel, Unseen, View};
use cranny_shape::{Aabb, Solid};
use cranny_spatial::{Point, Pose, Vector};

use crate::seen::seen_space::{SeenOptions, SeenSpace};
use crate::{Scenario, ScenarioError};

/// Error of the pose of the robot's links at the start, in metres.
const ROBOT_TOLERANCE_M: f64 = 0.005;

/// Name of the robot as a known body.
const ROBOT: &str = "robot";

/// Name of the target as a known body.
const TARGET: &str = "target";

/// Space around the target in which cells are half as wide, for the hand, in metres.
const FINE_M: f64 = 0.08;

/// Space around robot and target that is mapped by default, in metres.
const AROUND_M: f64 = 0.5;

impl Scenario {
    /// Returns the scenario with a map of the space that these views show as further obstacles: `occupied` and `unseen`. The robot at
    /// its start, the target and the floor are cut out.
    ///
    /// # Errors
    /// [`ScenarioError::Sense`] for options out of range or a body that cannot be rendered, [`ScenarioError::BodyName`] if the scenario
    /// has a body of one of these names.
    pub fn with_seen(&self, views: &[View], options: &SeenOptions) -> Result<Self, ScenarioError> {
        for (property, value) in [
            ("robot_reach_m", options.robot_reach_m),
            ("floor_reach_m", options.floor_reach_m),
            ("target_tolerance_m", options.target_tolerance_m),
        ] {
            if !(0.0..=0.2).contains(&value) {
                return Err(ScenarioError::SeenOption { property, value });
            }
        }
        let frames = self.robot.frames_at(&self.start);
        let links = self.robot.links().iter().enumerate().flat_map(|(index, link)| {
            let world_from_link = *frames.link(index);
            link.collisions
                .iter()
                .map(move |shape| (world_from_link * shape.link_from_shape, shape.solid.clone()))
        });
        let known = |name: &str, solids: Vec<(Pose, Solid)>, tolerance_m: f64, reach_m: f64| KnownBody {
            name: name.to_owned(),
            solids,
            tolerance_m,
            reach_m,
            is_transparent: name == TARGET,
            is_alone: name == ROBOT,
        };
        let mut bodies = vec![known(ROBOT, links.collect(), ROBOT_TOLERANCE_M, options.robot_reach_m)];
        let solids_of = |body: usize| -> Vec<(Pose, Solid)> {
            let parts = self.world.bodies()[body].parts.iter();
            parts.map(|part| (part.world_from_solid, part.solid.clone())).collect()
        };
        if let Some(target) = self.target {
            let tolerance_m = options.target_tolerance_m;
            bodies.push(known(TARGET, solids_of(target), tolerance_m, tolerance_m));
        }
        let is_floor =
            |body: usize| self.world.bodies()[body].parts.iter().all(|part| part.solid.is_half_space());
        if let Some(floor) = (0..self.world.bodies().len()).find(|body| is_floor(*body)) {
            bodies.push(known("floor", solids_of(floor), 0.0, options.floor_reach_m));
        }
        let region = options.region.unwrap_or_else(|| region_of_interest(&bodies));
        let fine = bodies.iter().filter(|body| body.is_transparent).flat_map(|body| &body.solids);
        let fine = fine.map(|(pose, solid)| solid.aabb().transformed(pose).grown(FINE_M)).collect();
        let settings = SeenSettings { region, fine, cell_m: options.cell_m, unseen: options.unseen };
        let map = SeenMap::new(views, &bodies, settings)?;
        let mut seen = self.clone();
        for body in map.bodies()? {
            seen = seen.with_body(body)?;
        }
        let sensors = views.iter().map(|view| view.sensor).collect();
        Ok(Self { seen: Some(SeenSpace { map: Arc::new(map), sensors, options: options.clone() }), ..seen })
    }

    /// Returns a sentence on the views that the obstacles come from, the bounds of their errors and what they do not show; `None` if the
    /// obstacles do not come from views.
    pub fn seen_statement(&self) -> Option<String> {
        let SeenSpace { map, sensors, options } = self.seen.as_ref()?;
        let unseen = match options.unseen {
            Unseen::Solid => "all space that none of them shows to be free is an obstacle",
            Unseen::Free => "space that none of them shows counts as free, so nothing is proven of it",
        };
        let millimetres = |length_m: f64| format!("{:.0} mm", (length_m * 1e3).ceil());
        // A bound is never stated less than it is.
        let bound = |value: f64, unit: f64, digits: usize| cranny_file::at_most(value, unit, digits);
        let greatest = |of: fn(&SensorModel) -> f64| sensors.iter().map(of).fold(0.0, f64::max);
        let [detail, beside] = map.detail_m().map(millimetres);
        Some(format!(
            "the obstacles are what {} show; {unseen}. Their errors are bounded by {} mm + {} % of the depth, {} pixels, and {} mm \
             and {}° of the camera's pose; things thinner than {detail} may be missed, beside the target {beside}. Within {} \
             of the robot at its start, and {} of the floor, unseen space counts as free, and so \
             does all that the robot touches there",
            cranny_file::counted(sensors.len(), "view"),
            bound(greatest(|sensor| sensor.depth_error_m), 1e3, 1),
            bound(greatest(|sensor| sensor.depth_error_share), 1e2, 2),
            bound(greatest(|sensor| sensor.lateral_error_px), 1.0, 1),
            bound(greatest(|sensor| sensor.position_error_m), 1e3, 1),
            bound(greatest(|sensor| sensor.turn_error_rad), 1_f64.to_degrees(), 2),
            millimetres(options.robot_reach_m),
            millimetres(options.floor_reach_m),
        ))
    }
}

/// Returns the box around these bodies, with space around it.
fn region_of_interest(known: &[KnownBody]) -> Aabb {
    let solids = known.iter().flat_map(|body| &body.solids).filter(|(_, solid)| !solid.is_half_space());
    let boxes = solids.map(|(pose, solid)| solid.aabb().transformed(pose));
    let corners: Vec<Point> = boxes.flat_map(|aabb| [aabb.low(), aabb.high()]).collect();
    if corners.is_empty() {
        return Aabb { center: Point::origin(), half_extents: Vector::repeat(AROUND_M) };
    }
    Aabb::around(&corners, AROUND_M)
}
