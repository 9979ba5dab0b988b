use cranny_robot::{LinkFrames, Robot};
use cranny_shape::overlap;
use cranny_spatial::{CONTACT_M, Stream};

use crate::link_body::{LinkBody, group_separation};

/// Which links can be compared with which, as indices into the link bodies, and of those in contact in every one of
/// [`SAMPLES`] random configurations the least depth that was seen (m).
#[derive(Clone, Debug)]
pub(crate) struct SelfPairs(Vec<((usize, usize), Option<f64>)>);

/// A pair that touches in every sample, and the least depth that was seen (m).
pub(crate) type AlwaysTouching = ((usize, usize), f64);

impl SelfPairs {
    /// All pairs but [adjacent](Robot::adjacent_pairs) ones, those that the robot's SRDF or its options
    /// disable, and those that never move against each other.
    pub fn of(robot: &Robot, bodies: &[LinkBody]) -> Self {
        let links = |pair| links_of(bodies, pair);
        let is_left_out =
            |pair| robot.adjacent_pairs().contains(&pair) || robot.disabled_pairs().contains(&pair);
        let moves_relatively = |(a, b): (usize, usize)| {
            let joints = |link: usize| robot.ancestors(link).iter().map(|j| j.child_link).collect::<Vec<_>>();
            joints(a) != joints(b)
        };
        let mut pairs: Vec<(usize, usize)> = Vec::new();
        for second in 0..bodies.len() {
            pairs.extend((0..second).map(|first| (first, second)).filter(|pair| {
                let links = links(*pair);
                !is_left_out(links) && moves_relatively(links)
            }));
        }
        let depths = depths_if_always_touching(robot, bodies, &pairs);
        Self(pairs.into_iter().zip(depths).collect())
    }

    /// The same with what is held, the last of `bodies`, against all links that move against it.
    pub fn with_held(&self, robot: &Robot, bodies: &[LinkBody]) -> Self {
        let held = bodies.len() - 1;
        let moves = |other: &usize| {
            let joints =
                |body: usize| robot.ancestors(bodies[body].link).iter().map(|mover| mover.child_link);
            !joints(*other).eq(joints(held))
        };
        let with_held = (0..held).filter(moves).map(|other| ((other, held), None));
        Self(self.0.iter().copied().chain(with_held).collect())
    }

    /// Those that are checked, and those that are not because they always touch, though not if they stand in
    /// `asked_for` (by link index, the lower first).
    pub fn split(
        &self,
        bodies: &[LinkBody],
        asked_for: &[(usize, usize)],
    ) -> (Vec<(usize, usize)>, Vec<AlwaysTouching>) {
        let (mut checked, mut always_touching) = (Vec::new(), Vec::new());
        for &(pair, depth_m) in &self.0 {
            match depth_m.filter(|_| !asked_for.contains(&links_of(bodies, pair))) {
                Some(depth_m) => always_touching.push((pair, depth_m)),
                None => checked.push(pair),
            }
        }
        (checked, always_touching)
    }
}

/// The links of two link bodies, the lower index first.
fn links_of(bodies: &[LinkBody], (first, second): (usize, usize)) -> (usize, usize) {
    let (a, b) = (bodies[first].link, bodies[second].link);
    (a.min(b), a.max(b))
}

/// How many random configurations must all show contact. One free one is enough to keep a pair.
const SAMPLES: usize = 500;

/// The depth of how many of them is checked.
const DEPTH_SAMPLES: usize = 20;

/// Per pair the least depth that was seen, in metres; `None` if the pair is free somewhere.
fn depths_if_always_touching(
    robot: &Robot,
    bodies: &[LinkBody],
    pairs: &[(usize, usize)],
) -> Vec<Option<f64>> {
    let mut random = Stream::new(0, 0);
    let mut frames = robot.frames();
    let mut depths = vec![Some(f64::INFINITY); pairs.len()];
    for sample in 0..SAMPLES {
        if depths.iter().all(Option::is_none) {
            break;
        }
        let q: Vec<f64> = robot.random_configuration(&mut random);
        robot.forward_kinematics(&q, &mut frames);
        for (&(first, second), depth_m) in pairs.iter().zip(&mut depths) {
            let Some(least_m) = depth_m else { continue };
            let (first, second) = (&bodies[first], &bodies[second]);
            let gap = group_separation(first.placed(&frames), &second.placed(&frames), CONTACT_M);
            if gap.upper_m > CONTACT_M {
                *depth_m = None;
            } else if sample < DEPTH_SAMPLES {
                *least_m = least_m.min(depth_of(first, second, &frames));
            }
        }
    }
    depths
}

/// How deep two links are in each other, in metres.
fn depth_of(first: &LinkBody, second: &LinkBody, frames: &LinkFrames) -> f64 {
    let others: Vec<_> = second.placed(frames).collect();
    let overlaps = first
        .placed(frames)
        .flat_map(|(pose_a, a)| others.iter().filter_map(move |(pose_b, b)| overlap(a, &pose_a, b, pose_b)));
    overlaps.map(|overlap| overlap.depth_m).fold(0.0, f64::max)
}
