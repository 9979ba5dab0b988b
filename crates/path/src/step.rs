use cranny_robot::{JointKind, LinkFrames, Robot};
use cranny_spatial::Vector;

/// Maximum step of the released planners, in metres (ε).
pub const RELEASED_STEP_M: f64 = 0.1;

/// Steps through configuration space. Their size is the largest displacement of the origin of any link frame on the chain to
/// the tip, in metres (as in the released code; the paper bounds each joint instead).
#[derive(Clone, Debug)]
pub struct Stepper {
    /// Moving links between the root and the tip.
    chain: Vec<usize>,
    from_frames: LinkFrames,
    to_frames: LinkFrames,
    q: Vec<f64>,
}

impl Stepper {
    /// Creates a stepper for a robot.
    pub fn new(robot: &Robot) -> Self {
        // Links that no joint moves are left out.
        let mut chain = Vec::new();
        let mut link = Some(robot.tip());
        while let Some(at) = link {
            if !robot.ancestors(at).is_empty() {
                chain.push(at);
            }
            link = robot.links()[at].parent;
        }
        chain.reverse();
        Self { chain, from_frames: robot.frames(), to_frames: robot.frames(), q: vec![0.0; robot.dof()] }
    }

    /// Returns the configuration on the straight line from `from` towards `to` (m, rad; one per joint) at the end of a step of
    /// at most `size_m` metres, and true if it is `to` itself.
    ///
    /// 1. The velocities of the links along the line give the first guess.
    /// 2. While a link moves farther than allowed (paths of links are curved), the guess is shortened.
    pub fn towards(&mut self, robot: &Robot, from: &[f64], to: &[f64], size_m: f64) -> (&[f64], bool) {
        robot.tip_kinematics(from, &mut self.from_frames);
        let slope = |joint: usize| to[joint] - from[joint];
        // 1. The motion of a link is a rotation, and a translation of the point at the origin.
        let mut speed_squared = 0.0_f64;
        let (mut turning, mut sliding) = (Vector::zeros(), Vector::zeros());
        let mut passed = 0;
        for &link in &self.chain {
            let movers = robot.ancestors(link);
            for mover in &movers[passed..] {
                let joint = self.from_frames.link(mover.child_link);
                let axis = joint.rotation * mover.axis_in_child * (mover.multiplier * slope(mover.joint));
                match mover.kind {
                    JointKind::Prismatic => sliding += axis,
                    JointKind::Revolute => {
                        turning += axis;
                        sliding -= axis.cross(&joint.translation.vector);
                    }
                }
            }
            passed = movers.len();
            let point = self.from_frames.link(link).translation.vector;
            speed_squared = speed_squared.max((sliding + turning.cross(&point)).norm_squared());
        }
        let speed = speed_squared.sqrt();
        let mut fraction = if speed > size_m { size_m / speed } else { 1.0 };
        // 2.
        loop {
            let is_end = fraction >= 1.0;
            for (joint, q) in self.q.iter_mut().enumerate() {
                *q = if is_end { to[joint] } else { from[joint] + fraction * slope(joint) };
            }
            robot.forward_kinematics(&self.q, &mut self.to_frames);
            let displacement = self.displacement();
            if displacement <= size_m {
                return (&self.q, is_end);
            }
            /// Factor that shortens slightly more than in proportion, so that a few rounds suffice.
            const SHORTEN: f64 = 0.99;
            fraction = fraction.min(1.0) * SHORTEN * size_m / displacement;
        }
    }

    /// Returns the largest displacement (m) of a frame origin of the chain from `from` to `to` (m, rad; one per joint).
    pub fn displacement_between(&mut self, robot: &Robot, from: &[f64], to: &[f64]) -> f64 {
        robot.tip_kinematics(from, &mut self.from_frames);
        robot.tip_kinematics(to, &mut self.to_frames);
        self.displacement()
    }

    /// Returns the configuration (m, rad; one per joint) that the last step reached.
    pub fn q(&self) -> &[f64] {
        &self.q
    }

    /// Returns the link frames at that configuration.
    pub fn frames(&self) -> &LinkFrames {
        &self.to_frames
    }

    fn displacement(&self) -> f64 {
        self.chain
            .iter()
            .map(|&link| {
                let (a, b) = (self.from_frames.link(link), self.to_frames.link(link));
                (a.translation.vector - b.translation.vector).norm_squared()
            })
            .fold(0.0, f64::max)
            .sqrt()
    }
}
