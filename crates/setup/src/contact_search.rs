use cranny_robot::{LinkFrames, LinkPath, Robot};
use cranny_shape::{Solid, overlap, quick_lower_bound, separation};
use cranny_spatial::{CONTACT_M, Pose, Stream};

/// Number of configurations searched for one in which two links do not touch.
pub const SEARCH_SAMPLES: usize = 100_000;

/// Number of values of each of two joints in a grid of about [`SEARCH_SAMPLES`]: less than 0.5 % of a range apart.
const GRID: usize = 316;

/// Number of random configurations whose depth is minimised joint by joint, of values per joint, and of rounds over all joints.
const DESCENTS: [usize; 3] = [8, 256, 2];

/// Pair of links of a robot, and the joints that move one relative to the other.
pub(crate) struct PairSearch<'r> {
    robot: &'r Robot,
    links: (usize, usize),
    joints: Vec<usize>,
    path: LinkPath,
    frames: LinkFrames,
}

/// Solids with their poses, for both links in the same frame.
type Placed<'r> = Vec<(Pose, &'r Solid)>;

impl<'r> PairSearch<'r> {
    pub fn new(robot: &'r Robot, links: (usize, usize)) -> Self {
        let [a, b] = [links.0, links.1].map(|link| robot.ancestors(link));
        let shared = a.iter().zip(b).take_while(|(a, b)| a.child_link == b.child_link).count();
        let mut joints: Vec<usize> =
            a[shared..].iter().chain(&b[shared..]).map(|mover| mover.joint).collect();
        joints.sort_unstable();
        joints.dedup();
        let path = robot.path_between([links.0, links.1]);
        Self { robot, links, joints, path, frames: robot.frames() }
    }

    /// Searches for a configuration (m, rad; one per joint) in which the links do not touch: in a grid over one or two joints
    /// between them; otherwise among random ones, and by moving each joint in turn to its value of minimum depth.
    pub fn free_configuration(&mut self) -> Option<Vec<f64>> {
        let limits = self.robot.limits();
        let value = |joint: usize, step: usize, steps: usize| {
            let share = step as f64 / (steps - 1) as f64;
            limits[joint].lower + (limits[joint].upper - limits[joint].lower) * share
        };
        let mut q: Vec<f64> = limits.iter().map(|limits| limits.clamp(0.0)).collect();
        let mut random = Stream::new(0, 1);
        match self.joints[..] {
            [joint] => {
                return (0..SEARCH_SAMPLES).find_map(|step| {
                    q[joint] = value(joint, step, SEARCH_SAMPLES);
                    self.is_free(&q).then(|| q.clone())
                });
            }
            [first, second] => {
                return (0..GRID * GRID).find_map(|cell| {
                    q[first] = value(first, cell / GRID, GRID);
                    q[second] = value(second, cell % GRID, GRID);
                    self.is_free(&q).then(|| q.clone())
                });
            }
            _ => {}
        }
        let drawn = (0..SEARCH_SAMPLES).map(|_| self.robot.random_configuration(&mut random));
        if let Some(free) = drawn.into_iter().find(|q| self.is_free(q)) {
            return Some(free);
        }
        let [descents, values, rounds] = DESCENTS;
        for _ in 0..descents {
            let mut q = self.robot.random_configuration(&mut random);
            for joint in std::iter::repeat_n(self.joints.clone(), rounds).flatten() {
                let mut least = (f64::INFINITY, q[joint]);
                for step in 0..values {
                    q[joint] = value(joint, step, values);
                    if self.is_free(&q) {
                        return Some(q);
                    }
                    let depth_m = self.depth_m(&q);
                    if depth_m < least.0 {
                        least = (depth_m, q[joint]);
                    }
                }
                q[joint] = least.1;
            }
        }
        None
    }

    /// Describes the maximum size of a window of free configurations that the search may have missed.
    pub fn missed(&self) -> &'static str {
        match self.joints.len() {
            0 | 1 => "a window of 0.001 % of the joint's range",
            2 => "a window of 0.32 % of the range of either joint",
            // No hit in n samples means a share below 3 / n with 95 % confidence.
            _ => "0.003 % of all configurations",
        }
    }

    /// Returns true if the links do not touch at `q` (m, rad; one per joint).
    pub fn is_free(&mut self, q: &[f64]) -> bool {
        self.robot.path_kinematics(&self.path, q, &mut self.frames);
        self.is_free_in(&self.frames)
    }

    /// Returns true if the links do not touch in these frames.
    pub fn is_free_in(&self, frames: &LinkFrames) -> bool {
        let (first, second) = self.placed(frames);
        first.iter().all(|(pose_a, a)| {
            second.iter().all(|(pose_b, b)| {
                quick_lower_bound(a, pose_a, b, pose_b, CONTACT_M) > CONTACT_M
                    || separation(a, pose_a, b, pose_b, CONTACT_M).lower_m >= CONTACT_M
            })
        })
    }

    /// Returns the maximum penetration depth of any two solids of the links at `q` (m, rad; one per joint), in metres.
    pub fn depth_m(&mut self, q: &[f64]) -> f64 {
        self.robot.path_kinematics(&self.path, q, &mut self.frames);
        let (first, second) = self.placed(&self.frames);
        let overlaps = first.iter().flat_map(|(pose_a, a)| {
            second.iter().filter_map(move |(pose_b, b)| overlap(a, pose_a, b, pose_b))
        });
        overlaps.map(|overlap| overlap.depth_m).fold(0.0, f64::max)
    }

    /// Returns the solids of both links with their poses in one frame.
    fn placed(&self, frames: &LinkFrames) -> (Placed<'r>, Placed<'r>) {
        let of = |link: usize| {
            let root_from_link = *frames.link(link);
            let shapes = self.robot.links()[link].collisions.iter();
            shapes.map(|shape| (root_from_link * shape.link_from_shape, &shape.solid)).collect()
        };
        (of(self.links.0), of(self.links.1))
    }
}
