//! The judge: samples of a motion, each checked by edges and triangles.

use std::path::Path;
use std::sync::Arc;

use cranny_robot::{LinkFrames, Robot};
use cranny_spatial::nalgebra::Matrix4;
use cranny_spatial::{Point, Pose, Stream};

use crate::hull::convex_hull;
use crate::mesh::{Bounds, Mesh, Placed};
use crate::scene::{self, Obstacle};

/// Greatest motion of a point of a link between two samples, in metres.
pub const STEP_M: f64 = 0.5e-3;

/// Height of the floor in the root frame, in metres.
const FLOOR_M: f64 = -0.05;

/// Joint limits of the URDF (m, rad).
#[expect(clippy::approx_constant, reason = "the file says so")]
pub const LIMITS: [[f64; 2]; 9] = [
    [-1.0, 1.0],
    [-1.0, 1.0],
    [-2.9671, 2.9671],
    [-1.8326, 1.8326],
    [-2.9671, 2.9671],
    [-3.1416, 0.0],
    [-2.9671, 2.9671],
    [-0.0873, 3.8223],
    [-2.9671, 2.9671],
];

/// A robot among the obstacles of a released scenario.
pub struct Oracle {
    robot: Arc<Robot>,
    pub links: Vec<LinkMesh>,
    obstacles: Vec<Obstacle>,
    /// Pairs of links that are checked, as indices into `links`.
    pub pairs: Vec<(usize, usize)>,
    start: Vec<f64>,
    pub grasps: Vec<Matrix4<f64>>,
}

/// Closed mesh of a collision shape of a link, in the frame of the link.
pub struct LinkMesh {
    pub link: usize,
    pub name: String,
    pub mesh: Mesh,
    bounds: Bounds,
}

/// Names of two things that touch.
#[derive(Clone, Debug, PartialEq)]
pub struct Touch {
    pub first: String,
    pub second: String,
}

/// Result of the judge for a motion.
#[derive(Debug)]
pub struct Sight {
    pub samples: usize,
    /// First touch, with its parameter in [0, 1].
    pub touch: Option<(f64, Touch)>,
}

/// All meshes at their poses for one configuration.
#[derive(Clone)]
pub struct Pictures<'a> {
    frames: LinkFrames,
    pub links: Vec<Placed<'a>>,
    obstacles: Vec<(&'a str, Placed<'a>)>,
}

impl Oracle {
    /// Creates the oracle of a released scenario from its files, with its own reader.
    pub fn new(robot: Arc<Robot>, folder: &Path) -> Self {
        Self::among(robot, scene::obstacles(folder), scene::start(folder), scene::grasps(folder))
    }

    /// Creates the oracle for a robot among obstacles, the target last.
    pub fn among(
        robot: Arc<Robot>,
        obstacles: Vec<Obstacle>,
        start: Vec<f64>,
        grasps: Vec<Matrix4<f64>>,
    ) -> Self {
        let mut links = Vec::new();
        for (link, description) in robot.links().iter().enumerate() {
            for shape in &description.collisions {
                let mesh = match (&shape.soup, shape.solid.as_cuboid()) {
                    (Some(soup), _) => convex_hull(&soup.vertices),
                    (None, Some(half_extents)) => Mesh::cuboid(half_extents),
                    (None, None) => {
                        shape.solid.tessellation().map(|soup| Mesh::of_soup(&soup)).expect("it is bounded")
                    }
                };
                let in_link = |vertex: &Point| shape.link_from_shape * vertex;
                let vertices: Vec<Point> = mesh.vertices.iter().map(in_link).collect();
                let bounds = Bounds::around(&vertices);
                let mesh = Mesh::new(vertices, mesh.triangles);
                links.push(LinkMesh { link, name: description.name.clone(), mesh, bounds });
            }
        }
        let mut oracle = Self { robot, links, obstacles, pairs: Vec::new(), start, grasps };
        oracle.pairs = oracle.pairs_to_look_at();
        oracle
    }

    /// Returns all pairs of links except those without another meshed link between them and those that always touch.
    fn pairs_to_look_at(&self) -> Vec<(usize, usize)> {
        /// Number of sampled configurations: one without touch keeps a pair.
        const CONFIGURATIONS: usize = 100;
        let mut random = Stream::new(0, 0);
        let mut pictures = self.pictures();
        let count = self.links.len();
        let mut always: Vec<(usize, usize)> = (0..count)
            .flat_map(|second| (0..second).map(move |first| (first, second)))
            .filter(|&(first, second)| !self.are_neighbours(first, second))
            .collect();
        let mut pairs = Vec::new();
        for _ in 0..CONFIGURATIONS {
            self.look_at(&random_configuration(&mut random), &mut pictures);
            let touches = |pair: &(usize, usize)| pictures.links[pair.0].meets(&pictures.links[pair.1]);
            let (still, apart): (Vec<_>, Vec<_>) = always.into_iter().partition(touches);
            pairs.extend(apart);
            always = still;
        }
        pairs.sort_unstable();
        pairs
    }

    fn are_neighbours(&self, first: usize, second: usize) -> bool {
        let has_mesh = |link: usize| self.links.iter().any(|mesh| mesh.link == link);
        let above = |link: usize| {
            let mut parent = self.robot.links()[link].parent;
            while let Some(bare) = parent.filter(|&link| !has_mesh(link)) {
                parent = self.robot.links()[bare].parent;
            }
            parent
        };
        let (first, second) = (self.links[first].link, self.links[second].link);
        first == second || above(first) == Some(second) || above(second) == Some(first)
    }

    pub fn pictures(&self) -> Pictures<'_> {
        let still = Pose::identity();
        let mut obstacles = Vec::new();
        for obstacle in &self.obstacles {
            obstacles.extend(obstacle.parts.iter().map(|part| (obstacle.name.as_str(), part.placed(&still))));
        }
        let links = self.links.iter().map(|link| link.mesh.placed(&still)).collect();
        Pictures { frames: self.robot.frames(), links, obstacles }
    }

    /// Returns the meshes with the target where a hand that closed on it at `grasp` releases it at `down` (m, rad).
    pub fn pictures_with_target_moved(&self, grasp: &[f64], down: &[f64]) -> Pictures<'_> {
        let tip = |q: &[f64]| *self.robot.frames_at(q).link(self.robot.tip());
        let moved = tip(down) * tip(grasp).inverse();
        let mut pictures = self.pictures();
        let target = self.obstacles.last().map_or(0, |target| target.parts.len());
        let first = pictures.obstacles.len() - target;
        for (_, part) in &mut pictures.obstacles[first..] {
            part.move_to(&moved);
        }
        pictures
    }

    pub fn look_at(&self, q: &[f64], pictures: &mut Pictures) {
        self.robot.forward_kinematics(q, &mut pictures.frames);
        for (placed, link) in pictures.links.iter_mut().zip(&self.links) {
            placed.move_to(pictures.frames.link(link.link));
        }
    }

    /// Returns the first touch at `q` (m, rad).
    pub fn touch_at(&self, q: &[f64], pictures: &mut Pictures) -> Option<Touch> {
        self.look_at(q, pictures);
        let touch = |link: usize, second: &str| {
            Some(Touch { first: self.links[link].name.clone(), second: second.to_owned() })
        };
        for (link, placed) in pictures.links.iter().enumerate() {
            if placed.bounds.low.z < FLOOR_M {
                return touch(link, "floor");
            }
            if let Some((name, _)) = pictures.obstacles.iter().find(|(_, obstacle)| placed.meets(obstacle)) {
                return touch(link, name);
            }
        }
        let touches =
            |&&(first, second): &&(usize, usize)| pictures.links[first].meets(&pictures.links[second]);
        self.pairs.iter().find(touches).and_then(|&(first, second)| touch(first, &self.links[second].name))
    }

    /// Checks the straight motion from `a` to `b` (m, rad) until something touches.
    pub fn watch(&self, a: &[f64], b: &[f64], pictures: &mut Pictures) -> Sight {
        let mut sight = Sight { samples: 0, touch: None };
        for t in self.samples(a, b) {
            sight.samples += 1;
            if let Some(touch) = self.touch_at(&between(a, b, t), pictures) {
                sight.touch = Some((t, touch));
                break;
            }
        }
        sight
    }

    /// Returns the number of samples and the first touch of the target on the straight motion from `a` to `b` (m, rad),
    /// `raised_m` (m) higher than in the hand that closed on it at `grasp`.
    pub fn watch_carried(
        &self,
        grasp: &[f64],
        raised_m: f64,
        [a, b]: [&[f64]; 2],
    ) -> (usize, Option<(f64, Touch)>) {
        let raise = Pose::translation(0.0, 0.0, raised_m);
        let tip = |q: &[f64]| *self.robot.frames_at(q).link(self.robot.tip());
        let grasped_from_root = tip(grasp).inverse();
        let still = Pose::identity();
        let (target, others) = self.obstacles.split_last().expect("there is a target");
        let others: Vec<(&str, Placed)> = others
            .iter()
            .flat_map(|other| other.parts.iter().map(|part| (other.name.as_str(), part.placed(&still))))
            .collect();
        let mut held: Vec<Placed> = target.parts.iter().map(|part| part.placed(&still)).collect();
        let mut samples = 0;
        for t in self.samples(a, b) {
            samples += 1;
            let moved = raise * tip(&between(a, b, t)) * grasped_from_root;
            for part in &mut held {
                part.move_to(&moved);
                let named = |name: &str| Touch { first: target.name.clone(), second: name.to_owned() };
                if part.bounds.low.z < FLOOR_M {
                    return (samples, Some((t, named("floor"))));
                }
                if let Some((name, _)) = others.iter().find(|(_, other)| part.meets(other)) {
                    return (samples, Some((t, named(name))));
                }
            }
        }
        (samples, None)
    }

    /// Returns the number of samples and all touches of a task that puts the target down, given as its six segments. At the end
    /// the target may penetrate its new support up to `most_sunk_m`, in metres, and before that no deeper than at the end.
    pub fn watch_task(
        &self,
        [reach, lift_off, carry, set_down, retreat, back]: &[Vec<Vec<f64>>; 6],
        most_sunk_m: f64,
    ) -> (usize, Vec<String>) {
        let (grasp, down) = (reach.last().expect("a grasp"), set_down.last().expect("a way down"));
        let rest_m = self.resting_depth_m();
        let (mut faults, mut samples) = (Vec::new(), 0);
        let rises = (0..20).map(|step| 1e-4 * f64::from(step));
        let is_free = |rise_m: &f64| self.watch_carried(grasp, *rise_m, [down, down]).1.is_none();
        let sunk_m = rises.take_while(|rise_m| *rise_m <= most_sunk_m).find(is_free).unwrap_or_default();
        for (way, raised_m) in [(lift_off, rest_m + 1e-4), (carry, 0.0), (set_down, sunk_m)] {
            for (edge, ends) in way.windows(2).enumerate() {
                let (seen, touch) = self.watch_carried(grasp, raised_m, [&ends[0], &ends[1]]);
                samples += seen;
                faults.extend(touch.map(|(t, touch)| format!("held, edge {edge} at {t}: {touch:?}")));
            }
        }
        let mut before = self.pictures();
        let mut after = self.pictures_with_target_moved(grasp, down);
        for (ways, pictures) in [(&[reach][..], &mut before), (&[retreat, back], &mut after)] {
            for (edge, ends) in ways.iter().flat_map(|way| way.windows(2)).enumerate() {
                let sight = self.watch(&ends[0], &ends[1], pictures);
                samples += sight.samples;
                faults.extend(sight.touch.map(|(t, touch)| format!("empty, edge {edge} at {t}: {touch:?}")));
            }
        }
        (samples, faults)
    }

    /// Returns the rise that frees the target from all its supports, in metres, to 0.1 mm.
    pub fn resting_depth_m(&self) -> f64 {
        let rises = (0..100).map(|step| 1e-4 * f64::from(step));
        let is_free =
            |rise_m: &f64| self.watch_carried(&self.start, *rise_m, [&self.start, &self.start]).1.is_none();
        rises.into_iter().find(is_free).expect("it rests within a centimetre")
    }

    /// Returns points of [0, 1] along the motion, both ends included, between which no link moves farther than [`STEP_M`]. The
    /// motion of a link is at most that of a corner of its box.
    pub fn samples<'a>(&'a self, a: &'a [f64], b: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        let mut frames = self.robot.frames();
        let mut corners_at = move |t: f64| {
            self.robot.forward_kinematics(&between(a, b, t), &mut frames);
            let corners =
                |link: &LinkMesh| link.bounds.corners().map(|corner| frames.link(link.link) * corner);
            self.links.iter().flat_map(corners).collect::<Vec<Point>>()
        };
        let (mut here, mut step) = (corners_at(0.0), 1.0);
        std::iter::successors(Some(0.0), move |&t| {
            if t >= 1.0 {
                return None;
            }
            loop {
                let next = f64::min(t + step, 1.0);
                let there = corners_at(next);
                let way = |(from, to): (&Point, &Point)| (to - from).norm();
                let farthest = here.iter().zip(&there).map(way).fold(0.0, f64::max);
                // Aim slightly lower, so that the next step rarely needs a second attempt.
                step = (0.95 * (next - t) * STEP_M / farthest).min(2.0 * step);
                if farthest <= STEP_M {
                    here = there;
                    return Some(next);
                }
            }
        })
    }

    /// Returns the faults of the ends of a path and of the joint values of its way points (m, rad).
    pub fn faults_of_way_points(&self, path: &[Vec<f64>]) -> Vec<String> {
        let (Some(first), Some(last)) = (path.first(), path.last()) else {
            return vec!["no path".to_owned()];
        };
        let mut faults = Vec::new();
        if first.len() != self.start.len() || first.iter().zip(&self.start).any(|(a, b)| (a - b).abs() > 1e-9)
        {
            faults.push("it does not begin at the start".to_owned());
        }
        for (index, q) in path.iter().enumerate() {
            if q.iter().zip(LIMITS).any(|(value, [low, high])| !(low..=high).contains(value)) {
                faults.push(format!("way point {index} is outside the limits"));
            }
        }
        let is_reached = |grasp: &Matrix4<f64>| self.is_reached(grasp, last);
        if !self.grasps.iter().any(is_reached) {
            faults.push("it does not end at a grasp".to_owned());
        }
        faults
    }

    /// Returns true if the gripper is within 1 mm and 1° of the grasp or its twin at `q` (m, rad).
    pub fn is_reached(&self, grasp: &Matrix4<f64>, q: &[f64]) -> bool {
        let frames = self.robot.frames_at(q);
        let gripper = frames.link(self.robot.link_index("panda_grasptarget").unwrap()).to_homogeneous();
        let distance_m = (gripper - grasp).fixed_view::<3, 1>(0, 3).norm();
        let relative = grasp.fixed_view::<3, 3>(0, 0).transpose() * gripper.fixed_view::<3, 3>(0, 0);
        let [x, y, z] = [0, 1, 2].map(|axis| relative[(axis, axis)]);
        // The trace of a rotation is 1 + 2 cos; the twin's x and y axes point in the opposite direction.
        let cosine = 0.5 * ((x + y + z).max(z - x - y) - 1.0);
        distance_m <= 1e-3 && cosine >= 1.0_f64.to_radians().cos()
    }
}

/// Returns the point `t` of the straight motion from `a` to `b` (m, rad).
pub fn between(a: &[f64], b: &[f64], t: f64) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + (b - a) * t).collect()
}

/// Returns a configuration that is uniform within the limits.
pub fn random_configuration(random: &mut Stream) -> Vec<f64> {
    LIMITS.map(|[low, high]| random.uniform_between(low, high)).to_vec()
}
