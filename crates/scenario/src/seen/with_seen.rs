use std::sync::Arc;

use cranny_collision::Body;
use cranny_sense::{
    KnownBody, SeenMap, SeenSettings, SenseError, SensorModel, Unseen, View, check_configuration,
};
use cranny_shape::{Aabb, Solid};
use cranny_spatial::{Point, Pose, Vector};

use crate::seen::seen_space::{SeenOptions, SeenSpace};
use crate::{Scenario, ScenarioError};

/// Error of the pose of the robot's links at the start, in metres.
const ROBOT_TOLERANCE_M: f64 = 0.005;

/// Name of the robot as a known body.
const ROBOT: &str = "robot";

/// Space around the target in which cells are half as wide, for the hand, in metres.
const FINE_M: f64 = 0.08;

/// Side of the smallest cells on known bodies beside the target, in metres: without them, it would be stuck in cells that no camera sees
/// into.
const BORDER_M: f64 = 0.0025;

/// Space around robot and target that is mapped by default, in metres.
const AROUND_M: f64 = 0.5;

impl Scenario {
    /// Returns the scenario with a map of the space that these views show as further obstacles: `occupied` and `unseen`. The robot, in
    /// each view at its configuration, and the bodies of the scenario, which are known, are cut out; of clouds this cannot be done.
    ///
    /// # Errors
    /// [`ScenarioError::Sense`] for options out of range, a configuration of another robot or a body that cannot be rendered, [`ScenarioError::BodyName`] if the scenario
    /// has a body of one of these names.
    pub fn with_seen(&self, views: &[View], options: &SeenOptions) -> Result<Self, ScenarioError> {
        for (property, value) in [
            ("robot_reach_m", options.robot_reach_m),
            ("floor_reach_m", options.floor_reach_m),
            ("tolerance_m", options.tolerance_m),
        ] {
            if !(0.0..=0.2).contains(&value) {
                return Err(ScenarioError::SeenOption { property, value });
            }
        }
        let (fine_m, cell_m) = (options.fine_m, options.cell_m);
        // The default is that of no wider cells.
        if fine_m > cell_m && fine_m.total_cmp(&SeenOptions::default().fine_m).is_ne() {
            return Err(ScenarioError::SeenFine { fine_m, cell_m });
        }
        let known = |name: &str, solids: Vec<(Pose, Solid)>, tolerance_m: f64, reach_m: f64| KnownBody {
            name: name.to_owned(),
            solids,
            tolerance_m,
            reach_m,
            border_m: None,
            is_transparent: false,
            is_alone: false,
        };
        let robot_at = |q: &[f64]| {
            let robot = known(ROBOT, self.solids_of_robot(q), ROBOT_TOLERANCE_M, options.robot_reach_m);
            KnownBody { is_alone: true, ..robot }
        };
        let mut bodies = vec![robot_at(&self.start)];
        let mut around_target = Vec::new();
        for (index, body) in self.world.bodies().iter().enumerate() {
            let has_inside = |solid: &Solid| !solid.is_half_space() && solid.as_union().is_none();
            let solids: Vec<(Pose, Solid)> =
                body.parts.iter().map(|part| (part.world_from_solid, part.solid.clone())).collect();
            if body.is_floor() {
                let floor = known(&body.name, solids, 0.0, options.floor_reach_m);
                bodies.push(KnownBody { is_transparent: true, ..floor });
            } else if solids.iter().all(|(_, solid)| has_inside(solid)) {
                if self.target == Some(index) {
                    let boxes = solids.iter().map(|(pose, solid)| solid.aabb().transformed(pose));
                    around_target = boxes.collect();
                }
                let body = known(&body.name, solids, options.tolerance_m, options.tolerance_m);
                bodies.push(KnownBody { is_transparent: true, border_m: Some(BORDER_M), ..body });
            }
        }
        let of_robot = bodies[0].solids.iter().map(|(pose, solid)| solid.aabb().transformed(pose));
        let region = options.region.unwrap_or_else(|| around(of_robot.chain(around_target.iter().copied())));
        let fine = around_target.iter().map(|aabb| aabb.grown(FINE_M)).collect();
        let SeenOptions { cell_m, fine_m, unseen, .. } = *options;
        let settings = SeenSettings { region, fine, cell_m, fine_m: fine_m.min(cell_m), unseen };
        let shown = |view: &View| {
            let elsewhere = view.configuration.as_ref().filter(|q| **q != self.start);
            let Some(q) = elsewhere else { return Ok(None) };
            check_configuration(&self.robot, &view.name, q)?;
            Ok::<_, SenseError>(Some([&[robot_at(q)], &bodies[1..]].concat()))
        };
        let shown = views.iter().map(shown).collect::<Result<Vec<_>, _>>()?;
        let map = SeenMap::of_moving(views, &bodies, &shown, settings)?;
        let mut seen = self.clone();
        for body in map.bodies()? {
            seen = seen.with_body(body)?;
        }
        let sensors = views.iter().map(|view| view.sensor).collect();
        let blind =
            views.iter().filter(|view| view.usable_pixels() == 0).map(|view| view.name.clone()).collect();
        let seen_space = SeenSpace { map: Arc::new(map), sensors, blind, options: options.clone() };
        Ok(Self { seen: Some(seen_space), ..seen })
    }

    /// Returns the solids of the robot's links at `q` (m, rad; one value per joint), with their poses in the planning frame.
    fn solids_of_robot(&self, q: &[f64]) -> Vec<(Pose, Solid)> {
        let frames = self.robot.frames_at(q);
        let links = self.robot.links().iter().enumerate();
        let solids = links.flat_map(|(index, link)| {
            let world_from_link = *frames.link(index);
            let shapes = link.collisions.iter();
            shapes.map(move |shape| (world_from_link * shape.link_from_shape, shape.solid.clone()))
        });
        solids.collect()
    }

    /// Returns a note on each view that shows nothing.
    pub fn blind_views(&self) -> Vec<String> {
        let note = |view: &String| {
            format!(
                "the view '{view}' shows nothing: no pixel has a depth within the range of its sensor (is `depth_unit_m` right, \
                 and the camera outside of all bodies?)"
            )
        };
        self.seen.iter().flat_map(|seen| &seen.blind).map(note).collect()
    }

    /// Returns a sentence on the views that the obstacles come from, the bounds of their errors and what they do not show; `None` if the
    /// obstacles do not come from views.
    pub fn seen_statement(&self) -> Option<String> {
        let SeenSpace { map, sensors, options, .. } = self.seen.as_ref()?;
        let unseen = match options.unseen {
            Unseen::Solid => "all space that none of them shows to be free is an obstacle",
            Unseen::Free => "space that none of them shows counts as free, so nothing is proven of it",
        };
        let millimetres = |length_m: f64| format!("{:.0} mm", (length_m * 1e3).ceil());
        // A bound is never stated less than it is.
        let bound = |value: f64, unit: f64, digits: usize| cranny_file::at_most(value, unit, digits);
        let greatest = |of: fn(&SensorModel) -> f64| sensors.iter().map(of).fold(0.0, f64::max);
        let [detail, layer] = [map.detail_m(), map.layer_m()].map(|bounds| {
            let [everywhere, beside] = bounds.map(millimetres);
            if self.target.is_some() {
                format!("{everywhere}, beside the target {beside},")
            } else {
                everywhere
            }
        });
        let show = if sensors.len() == 1 { "shows" } else { "show" };
        let is_stated = |(index, body): (usize, &Body)| {
            self.target != Some(index) && !body.is_floor() && !SeenMap::is_name_of_map(&body.name)
        };
        let stated = self.world.bodies().iter().enumerate().any(is_stated);
        let besides = if stated { "those of the scenario and " } else { "" };
        let mut claimed = Vec::new();
        // A cell that comes within reach has its farthest point a diagonal farther away.
        let reach_m = options.tolerance_m + 3_f64.sqrt() * BORDER_M;
        if self.target.is_some() {
            claimed.push(format!("{} of the target", millimetres(reach_m)));
        }
        if stated {
            claimed.push(format!("{} of an obstacle of the scenario", millimetres(reach_m)));
        }
        if options.floor_reach_m > 0.0 {
            claimed.push(format!(
                "{} of the floor, except for a layer of a cell at most",
                millimetres(options.floor_reach_m)
            ));
        }
        let claimed = if claimed.is_empty() {
            String::new()
        } else {
            format!("; everything does within {}", claimed.join(", "))
        };
        let has_known = stated || self.target.is_some() || self.world.bodies().iter().any(Body::is_floor);
        let risen = if has_known {
            format!(", and so may things that rise less than {layer} above the surface of a known body")
        } else {
            String::new()
        };
        let around_robot = if options.robot_reach_m > 0.0 {
            let reach = millimetres(options.robot_reach_m);
            format!("Within {reach} of the robot at its start, unseen space counts as free, and so does all")
        } else {
            "All counts as free".to_owned()
        };
        Some(format!(
            "the obstacles are {besides}what {} {show}; {unseen}. Their errors are bounded by {} mm + {} % of the depth, {} pixels, and {} mm \
             and {}° of the camera's pose; things thinner than {detail} may be missed{risen}. {around_robot} in the cells, {} wide, \
             that the robot touches {}{claimed}",
            cranny_file::counted(sensors.len(), "view"),
            bound(greatest(|sensor| sensor.depth_error_m), 1e3, 1),
            bound(greatest(|sensor| sensor.depth_error_share), 1e2, 2),
            bound(greatest(|sensor| sensor.lateral_error_px), 1.0, 1),
            bound(greatest(|sensor| sensor.position_error_m), 1e3, 1),
            bound(greatest(|sensor| sensor.turn_error_rad), 1_f64.to_degrees(), 2),
            millimetres(options.cell_m),
            if options.robot_reach_m > 0.0 { "there" } else { "at its start" },
        ))
    }
}

/// Returns the box around these boxes, with space around it.
fn around(boxes: impl Iterator<Item = Aabb>) -> Aabb {
    let corners: Vec<Point> = boxes.flat_map(|aabb| [aabb.low(), aabb.high()]).collect();
    if corners.is_empty() {
        return Aabb { center: Point::origin(), half_extents: Vector::repeat(AROUND_M) };
    }
    Aabb::around(&corners, AROUND_M)
}
