use cranny_spatial::{Stream, Vector};

use crate::{JointKind, Robot};

/// Number of base positions drawn, of which the nearest is taken; at the edge of the workspace about a tenth are valid.
const BASE_DRAWS: usize = 32;

/// Maximum number of consecutive slides that are drawn together; three already reach every point.
const MOST_SLIDES: usize = 6;

/// Prismatic joints between the root and the first revolute joint: they translate the arm without turning it.
#[derive(Clone, Debug)]
pub(crate) struct Base {
    /// Index in `q`, and the translation in the root frame per metre.
    slides: Vec<(usize, Vector)>,
    /// Position of the arm's first joint in the root frame while all slides are at 0.
    arm_in_root: Vector,
    /// Upper bound on the distance of the tip from the arm's first joint, in metres.
    reach_m: f64,
}

impl Base {
    pub fn of(robot: &Robot) -> Option<Self> {
        let movers = robot.ancestors(robot.tip());
        let count = movers.iter().take_while(|mover| mover.kind == JointKind::Prismatic).count();
        let arm = movers.get(count).filter(|_| (1..=MOST_SLIDES).contains(&count))?.child_link;
        let frames = robot.frames();
        let origin = |link: usize| frames.link(link).translation.vector;
        let slides = movers[..count].iter().map(|mover| {
            let axis_in_root = frames.link(mover.child_link).rotation * mover.axis_in_child;
            (mover.joint, axis_in_root * mover.multiplier)
        });
        // The distance between the origins of neighbouring axes does not depend on their rotation.
        let mut reach_m = 0.0;
        let mut previous = arm;
        for mover in &movers[count + 1..] {
            reach_m += (origin(mover.child_link) - origin(previous)).norm();
            if mover.kind == JointKind::Prismatic {
                let limits = robot.limits()[mover.joint];
                reach_m += mover.multiplier.abs() * limits.lower.abs().max(limits.upper.abs());
            }
            previous = mover.child_link;
        }
        reach_m += (origin(robot.tip()) - origin(previous)).norm();
        Some(Self { slides: slides.collect(), arm_in_root: origin(arm), reach_m })
    }

    /// Redraws the slides of `q` (m, rad; one per joint) until the target is in reach, or keeps the nearest of [`BASE_DRAWS`].
    pub fn draw_near(&self, robot: &Robot, target_in_root: &Vector, random: &mut Stream, q: &mut [f64]) {
        let mut nearest_m = f64::INFINITY;
        for _ in 0..BASE_DRAWS {
            let mut candidate = [0.0; MOST_SLIDES];
            let mut arm_in_root = self.arm_in_root;
            for (value, (joint, axis)) in candidate.iter_mut().zip(&self.slides) {
                let limits = robot.limits()[*joint];
                *value = random.uniform_between(limits.lower, limits.upper);
                arm_in_root += axis * *value;
            }
            let distance_m = (target_in_root - arm_in_root).norm();
            if distance_m < nearest_m {
                nearest_m = distance_m;
                for (value, (joint, _)) in candidate.iter().zip(&self.slides) {
                    q[*joint] = *value;
                }
            }
            if distance_m <= self.reach_m {
                return;
            }
        }
    }
}
