use std::sync::Arc;

use cranny_collision::{Body, Cell, CollisionError, Margins, World};
use cranny_robot::{JointKind, Robot};
use cranny_spatial::{Point, Stream, Vector};

/// Start configuration, and the reason for its choice.
#[derive(Clone, Debug)]
pub(crate) struct StartChoice {
    pub q: Vec<f64>,
    pub why: String,
}

/// Number of configurations drawn.
const DRAWS: usize = 4000;

/// Maximum distance of the robot ahead of the shoulder at the start, as a share of the reach of its arm.
const AHEAD: f64 = 0.22;

impl StartChoice {
    /// Returns a start free of collisions with the robot itself and the ground (m, rad; one value per joint): a named state
    /// that does not reach too far ahead, else the best of the drawn configurations. `None` if no drawn one is free.
    ///
    /// `seldom_free` contains a free configuration for each pair of links that is seldom free: if no drawn configuration is
    /// free, others are drawn that take some joint values from these.
    pub fn of(
        robot: &Arc<Robot>,
        floor_m: f64,
        states: &[(String, Vec<f64>)],
        seldom_free: &[&[f64]],
    ) -> Result<Option<Self>, CollisionError> {
        let world = World::new(vec![Body::floor(floor_m)])?;
        let cell = Cell::new(robot.clone(), world, Margins::default())?;
        let mut scratch = cell.scratch();
        let judge = Judge::of(robot);
        let mut is_free = |q: &[f64]| robot.within_limits(q) && cell.is_free(q, &mut scratch);
        let named = states.iter().filter(|(_, q)| is_free(q) && judge.is_behind(robot, q));
        let named = named.min_by(|(_, a), (_, b)| judge.cost(robot, a).total_cmp(&judge.cost(robot, b)));
        if let Some((name, q)) = named {
            return Ok(Some(Self {
                q: q.clone(),
                why: format!("the state `{name}` of its SRDF, free of itself"),
            }));
        }
        let mut random = Stream::new(0, 0);
        let mut best: Option<(f64, Vec<f64>)> = None;
        for _ in 0..DRAWS {
            let q = judge.draw(robot, &mut random);
            let cost = judge.cost(robot, &q);
            if best.as_ref().is_none_or(|(least, _)| cost < *least) && is_free(&q) {
                best = Some((cost, q));
            }
        }
        for draw in 0..if best.is_none() { DRAWS * seldom_free.len() } else { 0 } {
            let mut q = judge.draw(robot, &mut random);
            for (joint, value) in q.iter_mut().enumerate() {
                if random.uniform_between(0.0, 1.0) < 0.5 {
                    *value = seldom_free[draw % seldom_free.len()][joint];
                }
            }
            let cost = judge.cost(robot, &q);
            if best.as_ref().is_none_or(|(least, _)| cost < *least) && is_free(&q) {
                best = Some((cost, q));
            }
        }
        let rounded = |q: Vec<f64>| -> Vec<f64> {
            q.iter()
                .zip(robot.limits())
                .map(|(value, limits)| limits.clamp((value * 1e3).round() / 1e3))
                .collect()
        };
        let why = format!(
            "the best of {DRAWS} random configurations: no link touches another, the hand is in front of the base, and the arm is folded"
        );
        Ok(best.map(|(_, q)| rounded(q)).map(|q| Self { q, why }))
    }
}

/// Criteria for a good start.
struct Judge {
    /// Joints that move the whole robot; they start at 0.
    base: Vec<usize>,
    reach_m: f64,
    /// Maximum x of the robot in its root frame at the start, in metres; at least that of the base.
    ahead_m: f64,
    /// Origin of the arm.
    shoulder: Point,
}

impl Judge {
    fn of(robot: &Robot) -> Self {
        let movers = robot.ancestors(robot.tip());
        let before_body = movers.iter().take_while(|mover| {
            let parent = robot.links()[mover.child_link].parent.unwrap_or(0);
            robot.links()[parent].collisions.is_empty()
                && robot.ancestors(parent).iter().all(|m| m.joint != mover.joint)
        });
        // A fixed arm whose first link has no geometry has no mobile base: it begins with a revolute joint.
        let mut base: Vec<usize> = before_body.map(|mover| mover.joint).collect();
        if movers.first().is_some_and(|mover| mover.kind == JointKind::Revolute) {
            base.clear();
        }
        let arm = movers.iter().find(|mover| !base.contains(&mover.joint));
        let frames = robot.frames();
        let shoulder = frames.link(arm.map_or(robot.tip(), |mover| mover.child_link)).translation.vector;
        let mut judge = Self { base, reach_m: 0.0, ahead_m: 0.0, shoulder: shoulder.into() };
        let mut random = Stream::new(1, 0);
        for _ in 0..1000 {
            let q = judge.draw(robot, &mut random);
            let tip = robot.frames_at(&q).link(robot.tip()).translation.vector;
            judge.reach_m = judge.reach_m.max((tip - shoulder).norm());
        }
        let frames = robot.frames_at(&judge.draw(robot, &mut random));
        let is_base =
            |link: &usize| robot.ancestors(*link).iter().all(|mover| judge.base.contains(&mover.joint));
        let base_m = Self::ahead(robot, &frames, &|link| is_base(&link));
        judge.ahead_m = base_m.max(shoulder.x + AHEAD * judge.reach_m);
        judge
    }

    /// Draws a configuration with the joints that move the whole robot at 0, and revolute joints within a turn.
    fn draw(&self, robot: &Robot, random: &mut Stream) -> Vec<f64> {
        let mut q = robot.random_configuration(random);
        for (joint, (value, limits)) in q.iter_mut().zip(robot.limits()).enumerate() {
            if self.base.contains(&joint) {
                // The middle of the range keeps a floating robot well above the ground.
                let middle = 0.5 * (limits.lower + limits.upper);
                let is_about_zero =
                    limits.contain(0.0) && middle.abs() < 0.25 * (limits.upper - limits.lower);
                *value = if is_about_zero { 0.0 } else { middle };
            } else if robot.joints()[joint].kind == JointKind::Revolute {
                let turn = std::f64::consts::PI;
                *value =
                    random.uniform_between(limits.lower.max(-turn), limits.upper.min(turn).max(limits.lower));
            }
        }
        q
    }

    fn ahead(robot: &Robot, frames: &cranny_robot::LinkFrames, which: &dyn Fn(usize) -> bool) -> f64 {
        let shapes = (0..robot.links().len()).filter(|link| which(*link)).flat_map(|link| {
            robot.links()[link].collisions.iter().map(move |shape| {
                let ball = shape.solid.ball();
                (frames.link(link) * (shape.link_from_shape * ball.center)).x + ball.radius_m
            })
        });
        shapes.fold(f64::NEG_INFINITY, f64::max)
    }

    fn is_behind(&self, robot: &Robot, q: &[f64]) -> bool {
        Self::ahead(robot, &robot.frames_at(q), &|_| true) <= self.ahead_m
    }

    fn cost(&self, robot: &Robot, q: &[f64]) -> f64 {
        let frames = robot.frames_at(q);
        let tip = frames.link(robot.tip());
        let reach_m = self.reach_m.max(1e-3);
        let from_shoulder = (tip.translation.vector - self.shoulder.coords) / reach_m;
        let too_far = (Self::ahead(robot, &frames, &|_| true) - self.ahead_m).max(0.0) / reach_m;
        let approach = tip.rotation * Vector::z();
        let off_middle =
            q.iter().zip(robot.limits()).enumerate().filter(|(joint, _)| !self.base.contains(joint));
        let off_middle = off_middle.map(|(_, (value, limits))| {
            let range = (limits.upper - limits.lower).clamp(1e-6, std::f64::consts::TAU);
            let middle = if limits.contain(0.0) { 0.0 } else { 0.5 * (limits.lower + limits.upper) };
            ((value - middle) / range).powi(2)
        });
        // The limit ahead takes precedence; then the hand should be in front, pointing ahead and down.
        20.0 * too_far
            + (from_shoulder.x - 0.2).max(0.0)
            + (0.05 - from_shoulder.x).max(0.0) * 2.0
            + 0.5 * from_shoulder.y.abs()
            + 0.3 * (from_shoulder.z - 0.1).abs()
            + 0.3 * (1.0 - approach.x)
            + 0.3 * approach.z.max(0.0)
            + 0.3 * approach.y.abs()
            + off_middle.sum::<f64>()
    }
}
