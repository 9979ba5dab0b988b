use cranny_robot::Robot;
use cranny_spatial::{CONTACT_M, Stream};

use crate::link_body::{LinkBody, group_separation};

/// The pairs of links that are checked against each other, as indices into `bodies`: all but adjacent ones
/// (no link with geometry between them), those the robot's SRDF disables, those that never move against
/// each other, and those in contact in every one of [`SAMPLES`] random configurations.
pub(crate) fn self_pairs(robot: &Robot, bodies: &[LinkBody]) -> Vec<(usize, usize)> {
    let is_left_out = |a: usize, b: usize| {
        let pair = (a.min(b), a.max(b));
        robot.adjacent_pairs().contains(&pair) || robot.disabled_pairs().contains(&pair)
    };
    let moves_relatively = |a: usize, b: usize| {
        let joints = |link: usize| robot.ancestors(link).iter().map(|j| j.child_link).collect::<Vec<_>>();
        joints(a) != joints(b)
    };
    let mut pairs = Vec::new();
    for second in 0..bodies.len() {
        for first in 0..second {
            let (a, b) = (bodies[first].link, bodies[second].link);
            if !is_left_out(a, b) && moves_relatively(a, b) {
                pairs.push((first, second));
            }
        }
    }
    let always = always_in_contact(robot, bodies, &pairs);
    pairs.into_iter().zip(always).filter(|(_, always)| !always).map(|(pair, _)| pair).collect()
}

/// How many random configurations must all show contact. One free one is enough to keep a pair.
const SAMPLES: usize = 500;

fn always_in_contact(robot: &Robot, bodies: &[LinkBody], pairs: &[(usize, usize)]) -> Vec<bool> {
    let mut random = Stream::new(0, 0);
    let mut frames = robot.frames();
    let mut always = vec![true; pairs.len()];
    for _ in 0..SAMPLES {
        if always.iter().all(|a| !a) {
            break;
        }
        let q: Vec<f64> = robot.limits().iter().map(|l| random.uniform_between(l.lower, l.upper)).collect();
        robot.forward_kinematics(&q, &mut frames);
        for (&(first, second), always) in pairs.iter().zip(&mut always) {
            if *always {
                let placed = |body: usize| {
                    let LinkBody { link, shapes, .. } = &bodies[body];
                    let world_from_link = *frames.link(*link);
                    shapes.iter().map(move |(pose, solid)| (world_from_link * pose, solid))
                };
                let gap = group_separation(placed(first), &placed(second), CONTACT_M);
                *always = gap.upper_m <= CONTACT_M;
            }
        }
    }
    always
}
