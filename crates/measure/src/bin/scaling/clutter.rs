use std::sync::Arc;

use cranny_collision::{Body, Margins, World};
use cranny_grasp::{Grasp, GraspSet};
use cranny_robot::{LinkFrames, Robot};
use cranny_scenario::{OpenOptions, Scenario};
use cranny_shape::{Solid, separation};
use cranny_spatial::{Pose, Stream, Vector};
use cranny_task::{Goal, Problem};

/// Built-in robot among random boxes that keep clear of its start and of some configurations that reach the goal poses.
/// A smaller number of boxes uses the first ones.
pub struct Clutter {
    robot: Arc<Robot>,
    start: Vec<f64>,
    floor: Body,
    boxes: Vec<Body>,
    grasps: Vec<Grasp>,
}

/// Number of goal poses.
const GRASPS: usize = 10;

/// Range of the half edges of the boxes, in metres: from a cup to a crate.
const HALF_EDGES_M: [f64; 2] = [0.02, 0.08];

/// Maximum absolute x and y of the boxes in the planning frame, in metres: about the reach of the arm.
const AROUND_M: f64 = 2.2;

/// Maximum height of the boxes above the floor, in metres.
const HEIGHT_M: f64 = 1.9;

/// Minimum distance of the boxes from the robot at start and goals, in metres.
const KEPT_FREE_M: f64 = 0.02;

impl Clutter {
    pub fn draw(seed: u64, boxes: usize) -> Self {
        let Scenario { robot, start, world, .. } =
            Scenario::open("021", &OpenOptions::default()).expect("a built-in scenario");
        let floor = world.bodies()[world.body_index("floor").expect("a floor")].clone();
        let mut random = Stream::new(seed, 0);
        let mut clutter = Self { robot, start, floor, boxes: Vec::new(), grasps: Vec::new() };
        let mut kept_free = vec![clutter.robot.frames_at(&clutter.start)];
        let empty = clutter.problem(0);
        let cell = empty.cell().expect("the criterion is exact");
        let mut scratch = cell.scratch();
        while clutter.grasps.len() < GRASPS {
            let limits = clutter.robot.limits();
            let q: Vec<f64> = limits.iter().map(|l| random.uniform_between(l.lower, l.upper)).collect();
            if cell.is_free(&q, &mut scratch) {
                let frames = clutter.robot.frames_at(&q);
                let world_from_gripper = *frames.link(clutter.robot.tip());
                clutter.grasps.push(Grasp::at(world_from_gripper));
                kept_free.push(frames);
            }
        }
        while clutter.boxes.len() < boxes {
            let half_extents =
                Vector::zeros().map(|_: f64| random.uniform_between(HALF_EDGES_M[0], HALF_EDGES_M[1]));
            let place = Vector::new(
                random.uniform_between(-AROUND_M, AROUND_M),
                random.uniform_between(-AROUND_M, AROUND_M),
                random.uniform_between(0.0, HEIGHT_M),
            );
            let world_from_box = Pose::from_parts(place.into(), random.rotation());
            let solid = Solid::cuboid(half_extents).expect("a positive size");
            if kept_free.iter().all(|frames| clutter.keeps_off(frames, &solid, &world_from_box)) {
                let name = format!("box {}", clutter.boxes.len());
                clutter.boxes.push(Body::new(name, world_from_box, solid));
            }
        }
        clutter
    }

    /// Returns the problem to reach any of the poses from the start, among the first `boxes` boxes.
    pub fn problem(&self, boxes: usize) -> Problem {
        let bodies = self.boxes[..boxes].iter().chain([&self.floor]).cloned().collect();
        let world = World::new(bodies).expect("finite poses");
        let goal = Goal::Grasps(GraspSet::new(self.grasps.clone()).expect("good grasps"));
        Problem::exact(self.robot.clone(), world, None, self.start.clone(), goal, Margins::default())
            .expect("a good problem")
    }

    fn keeps_off(&self, frames: &LinkFrames, solid: &Solid, world_from_solid: &Pose) -> bool {
        self.robot.links().iter().enumerate().all(|(link, l)| {
            l.collisions.iter().all(|shape| {
                let world_from_shape = frames.link(link) * shape.link_from_shape;
                let gap = separation(&shape.solid, &world_from_shape, solid, world_from_solid, KEPT_FREE_M);
                gap.lower_m >= KEPT_FREE_M
            })
        })
    }
}
