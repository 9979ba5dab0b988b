use cranny_robot::{LinkFrames, Robot};
use cranny_shape::{Solid, overlap, quick_lower_bound, separation};
use cranny_spatial::{CONTACT_M, Pose, Stream};

/// How two links of a robot were found in many drawn configurations.
#[derive(Clone, Debug, PartialEq)]
pub struct SelfContact {
    /// The links, by index.
    pub links: (usize, usize),
    /// In how many of the configurations they touched.
    pub touching: usize,
    /// Whether no third link with geometry is between them.
    pub is_adjacent: bool,
    /// How deep they were in each other at the least, of those where they touched, in metres.
    pub least_depth_m: f64,
}

/// As many configurations are drawn.
pub const SELF_CONTACT_SAMPLES: usize = 1000;

/// The depth of how many contacts of a pair is looked at.
const DEPTH_SAMPLES: usize = 10;

impl SelfContact {
    /// Whether they touched in nearly every configuration: 95 of 100, as `MoveIt`'s setup assistant has it.
    pub fn is_always(&self) -> bool {
        self.touching * 100 >= 95 * SELF_CONTACT_SAMPLES
    }

    /// All pairs of links with geometry that move against each other, from drawn configurations: as `MoveIt`'s setup
    /// assistant does (Coleman et al. 2014).
    pub fn sample(robot: &Robot) -> Vec<Self> {
        let links: Vec<usize> =
            (0..robot.links().len()).filter(|&link| !robot.links()[link].collisions.is_empty()).collect();
        let pairs = links.iter().flat_map(|&a| links.iter().filter(move |b| a < **b).map(move |&b| (a, b)));
        let moves = |&(a, b): &(usize, usize)| robot.ancestors(a) != robot.ancestors(b);
        let mut contacts: Vec<Self> = pairs
            .filter(moves)
            .map(|links| Self {
                links,
                touching: 0,
                is_adjacent: robot.adjacent_pairs().binary_search(&links).is_ok(),
                least_depth_m: f64::INFINITY,
            })
            .collect();
        let (mut random, mut frames) = (Stream::new(0, 0), robot.frames());
        for _ in 0..SELF_CONTACT_SAMPLES {
            robot.forward_kinematics(&robot.random_configuration(&mut random), &mut frames);
            for contact in &mut contacts {
                let (a, b) =
                    (placed(robot, &frames, contact.links.0), placed(robot, &frames, contact.links.1));
                if !touch(&a, &b) {
                    continue;
                }
                contact.touching += 1;
                if contact.touching <= DEPTH_SAMPLES {
                    contact.least_depth_m = contact.least_depth_m.min(depth_m(&a, &b));
                }
            }
        }
        contacts
    }
}

fn placed<'r>(robot: &'r Robot, frames: &LinkFrames, link: usize) -> Vec<(Pose, &'r Solid)> {
    let root_from_link = *frames.link(link);
    let shapes = robot.links()[link].collisions.iter();
    shapes.map(|shape| (root_from_link * shape.link_from_shape, &shape.solid)).collect()
}

fn touch(first: &[(Pose, &Solid)], second: &[(Pose, &Solid)]) -> bool {
    first.iter().any(|(pose_a, a)| {
        second.iter().any(|(pose_b, b)| {
            quick_lower_bound(a, pose_a, b, pose_b, CONTACT_M) < CONTACT_M
                && separation(a, pose_a, b, pose_b, CONTACT_M).lower_m < CONTACT_M
        })
    })
}

fn depth_m(first: &[(Pose, &Solid)], second: &[(Pose, &Solid)]) -> f64 {
    let overlaps = first
        .iter()
        .flat_map(|(pose_a, a)| second.iter().filter_map(move |(pose_b, b)| overlap(a, pose_a, b, pose_b)));
    overlaps.map(|overlap| overlap.depth_m).fold(0.0, f64::max)
}
