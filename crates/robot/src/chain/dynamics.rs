use cranny_spatial::nalgebra::Matrix3;
use cranny_spatial::{Point, Pose, Vector};

use crate::{Inertial, JointKind, LinkFrames, Mover, Robot};

/// Masses and inertias of a robot, for the forces at its joints ([`Robot::path_forces`]).
#[derive(Clone, Debug)]
pub struct Dynamics {
    bodies: Vec<MovingBody>,
    gravity: Vector,
    dof: usize,
}

/// A link with mass that joints move.
#[derive(Clone, Debug)]
struct MovingBody {
    link: usize,
    inertial: Inertial,
    /// Largest principal moment of inertia, in kg m².
    greatest_moment: f64,
    /// [`Robot::link_arms_m`] of the centre of mass, each multiplied by the multiplier of its joint.
    arms_m: Vec<f64>,
}

/// Joint forces along a path `q(s)`, per joint in N or N m: the force at joint j is `inertia·s̈ + bend·ṡ² + weight`.
#[derive(Clone, Debug, PartialEq)]
pub struct PathForces {
    /// Coefficients of `s̈`.
    pub inertia: Vec<f64>,
    /// Coefficients of `ṡ²`.
    pub bend: Vec<f64>,
    /// Forces at rest.
    pub weight: Vec<f64>,
}

/// Standard gravity of Earth, in m/s².
const GRAVITY_M_S2: f64 = 9.81;

impl Dynamics {
    /// Collects the masses of all moving links of `robot`. `up` is the direction opposite to gravity in the root frame, a
    /// unit vector; `held` is rigidly attached to the hand, in the tip frame. The hand is taken to be open.
    ///
    /// # Errors
    /// Name of the first link that has a shape, is moved by a joint and has no mass or inertia in the URDF.
    pub fn new(robot: &Robot, up: &Vector, held: Option<Inertial>) -> Result<Self, String> {
        let frames = robot.frames();
        let mut bodies = Vec::new();
        for (link, of_link) in robot.links().iter().enumerate() {
            if robot.ancestors(link).is_empty() || robot.held_link() == Some(link) {
                continue;
            }
            match of_link.inertial {
                Some(inertial) => bodies.push(MovingBody::new(robot, &frames, link, inertial)),
                None if of_link.collisions.is_empty() => {}
                None => return Err(of_link.name.clone()),
            }
        }
        bodies.extend(held.map(|held| MovingBody::new(robot, &frames, robot.tip(), held)));
        Ok(Self { bodies, gravity: -GRAVITY_M_S2 * up, dof: robot.dof() })
    }

    /// Bounds the change of each coefficient of [`PathForces`] per unit of `s`, one value per joint, given bounds on the
    /// absolute values of the first three derivatives of the joints (m, rad) by `s` (one value per joint each).
    ///
    /// For a link with arms `ρ_j` (maximum distances of its centre of mass from the joint axes over all joint values), let
    /// `P = Σ ρ_j |q_j'|`, `W = Σ |q_j'|` over the joints that turn, and `Z`, `Y`, `PZ`, `PY` the same sums with the second and
    /// third derivatives. A column of the Jacobian of the centre changes by at most `J' = Wρ_j + P`, the centre itself by
    /// `c' ≤ P`, `c'' ≤ C₂ = 2WP + PZ` and `c''' ≤ (3W² + Z)P + W(2WP + 2C₂) + 2(W·PZ + Z·P) + PY`; a moment of inertia λ
    /// adds `λ(Z + 4W²)` to the change of the first coefficient and `λ(Y + 8WZ + 9W³)` to that of the second.
    pub fn changes(&self, robot: &Robot, [first, second, third]: [&[f64]; 3]) -> PathForces {
        let none = || vec![0.0; self.dof];
        let mut changes = PathForces { inertia: none(), bend: none(), weight: none() };
        for body in &self.bodies {
            let movers = robot.ancestors(body.link);
            let sum = |of: &[f64], is_turn: bool| -> f64 {
                let terms = movers.iter().zip(&body.arms_m).map(|(mover, arm_m)| {
                    let rate = of[mover.joint].abs();
                    match (is_turn, mover.kind) {
                        (false, _) => arm_m * rate,
                        (true, JointKind::Revolute) => mover.multiplier.abs() * rate,
                        (true, JointKind::Prismatic) => 0.0,
                    }
                });
                terms.sum()
            };
            let [p, pz, py] = [first, second, third].map(|of| sum(of, false));
            let [w, z, y] = [first, second, third].map(|of| sum(of, true));
            let c2 = 2.0 * w * p + pz;
            let c3 = (3.0 * w * w + z) * p + w * (2.0 * w * p + 2.0 * c2) + 2.0 * (w * pz + z * p) + py;
            let (mass, moment) = (body.inertial.mass_kg, body.greatest_moment);
            for (mover, arm_m) in movers.iter().zip(&body.arms_m) {
                let (joint, multiplier) = (mover.joint, mover.multiplier.abs());
                let turns = if mover.kind == JointKind::Revolute { multiplier } else { 0.0 };
                let column = w * arm_m + turns * p;
                changes.inertia[joint] +=
                    mass * (column * p + arm_m * c2) + turns * moment * (z + 4.0 * w * w);
                changes.bend[joint] +=
                    mass * (column * c2 + arm_m * c3) + turns * moment * (y + 8.0 * w * z + 9.0 * w.powi(3));
                changes.weight[joint] += mass * self.gravity.norm() * column;
            }
        }
        changes
    }
}

impl MovingBody {
    fn new(robot: &Robot, frames: &LinkFrames, link: usize, inertial: Inertial) -> Self {
        let mut arms_m = robot.link_arms_m(frames, link, &inertial.center);
        for (arm_m, mover) in arms_m.iter_mut().zip(robot.ancestors(link)) {
            *arm_m *= mover.multiplier.abs();
        }
        let greatest_moment = inertial.inertia_kg_m2.symmetric_eigenvalues().max();
        Self { link, inertial, greatest_moment, arms_m }
    }

    /// Adds the joint forces that the motion of the link requires: joint values change with `rates` and `accelerations` (one
    /// value per joint each); `gravity` acts on the link (m/s²).
    fn add_forces(
        &self,
        robot: &Robot,
        frames: &LinkFrames,
        [rates, accelerations]: [&[f64]; 2],
        gravity: &Vector,
        forces: &mut [f64],
    ) {
        let movers = robot.ancestors(self.link);
        let place = |mover: &Mover| {
            let world_from_child: &Pose = frames.link(mover.child_link);
            (world_from_child.translation.vector, world_from_child.rotation * mover.axis_in_child)
        };
        // The motion of one of its points describes the motion of the link.
        let mut motion = PointMotion::default();
        for mover in movers {
            let (origin, axis) = place(mover);
            let [rate, acceleration] =
                [rates, accelerations].map(|of| mover.multiplier * of[mover.joint] * axis);
            motion = motion.at(origin);
            match mover.kind {
                JointKind::Revolute => {
                    motion.turn_acceleration += acceleration + motion.turn.cross(&rate);
                    motion.turn += rate;
                }
                JointKind::Prismatic => {
                    motion.acceleration += acceleration + 2.0 * motion.turn.cross(&rate);
                }
            }
        }
        let world_from_link = frames.link(self.link);
        let center: Point = world_from_link * self.inertial.center;
        let motion = motion.at(center.coords);
        let turn = world_from_link.rotation.to_rotation_matrix();
        let inertia: Matrix3<f64> = turn.matrix() * self.inertial.inertia_kg_m2 * turn.matrix().transpose();
        let force = self.inertial.mass_kg * (motion.acceleration - gravity);
        let moment = inertia * motion.turn_acceleration + motion.turn.cross(&(inertia * motion.turn));
        for mover in movers {
            let (origin, axis) = place(mover);
            let along = match mover.kind {
                JointKind::Revolute => axis.dot(&((center.coords - origin).cross(&force) + moment)),
                JointKind::Prismatic => axis.dot(&force),
            };
            forces[mover.joint] += mover.multiplier * along;
        }
    }
}

/// Acceleration of a point of a link, with the link's angular velocity and acceleration.
#[derive(Clone, Copy, Default)]
struct PointMotion {
    point: Vector,
    acceleration: Vector,
    turn: Vector,
    turn_acceleration: Vector,
}

impl PointMotion {
    /// Returns the motion of another point of the same link.
    fn at(self, point: Vector) -> Self {
        let arm = point - self.point;
        let acceleration =
            self.acceleration + self.turn_acceleration.cross(&arm) + self.turn.cross(&self.turn.cross(&arm));
        Self { point, acceleration, ..self }
    }
}

impl Robot {
    /// Returns the joint forces along a path at `q` (m, rad) with first and second derivatives `first` and `second` by the
    /// path parameter (one value per joint each), from the equations of motion (Newton–Euler: Featherstone 2008, §5.3).
    /// Friction in the drives and the inertia of their rotors, which a URDF does not state, are neglected.
    ///
    /// # Panics
    /// If there is not one value per joint.
    pub fn path_forces(
        &self,
        dynamics: &Dynamics,
        [q, first, second]: [&[f64]; 3],
        frames: &mut LinkFrames,
    ) -> PathForces {
        self.forward_kinematics(q, frames);
        let still = vec![0.0; self.dof()];
        let forces = |motion: [&[f64]; 2], gravity: &Vector| {
            let mut forces = vec![0.0; self.dof()];
            for body in &dynamics.bodies {
                body.add_forces(self, frames, motion, gravity, &mut forces);
            }
            forces
        };
        PathForces {
            inertia: forces([&still, first], &Vector::zeros()),
            bend: forces([first, second], &Vector::zeros()),
            weight: forces([&still, &still], &dynamics.gravity),
        }
    }
}
