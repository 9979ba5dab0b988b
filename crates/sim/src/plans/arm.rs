use cranny_robot::{JointKind, LinkFrames, Robot};
use cranny_spatial::nalgebra::{Matrix3, UnitQuaternion};
use cranny_spatial::{Point, Pose, Vector};
use rapier3d_f64::prelude::{
    Collider, GenericJoint, GenericJointBuilder, JointAxesMask, JointAxis, MassProperties, MotorModel,
    MultibodyJointHandle, PhysicsWorld, RigidBodyBuilder, RigidBodyHandle,
};
use serde::Serialize;

use crate::{Piece, SimError, engine};

/// How the joints of an arm are driven: each by a servo that is stiff for the inertia that it sees, within the effort
/// limit of the URDF.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DriveSettings {
    /// The natural frequency of a servo, in Hz.
    pub frequency_hz: f64,
    /// Its damping ratio.
    pub damping_ratio: f64,
    /// What rotor and gear add to the inertia of a revolute joint, in kg m².
    pub rotor_inertia_kg_m2: f64,
}

impl Default for DriveSettings {
    fn default() -> Self {
        Self { frequency_hz: 50.0, damping_ratio: 1.0, rotor_inertia_kg_m2: 0.1 }
    }
}

impl DriveSettings {
    /// # Errors
    /// [`SimError::Figure`] for one that is out of its range.
    pub(crate) fn check(&self) -> Result<(), SimError> {
        for (figure, value, range, (least, greatest)) in [
            ("frequency of the drives", self.frequency_hz, "from 1 to 100 Hz", (1.0, 100.0)),
            ("damping ratio of the drives", self.damping_ratio, "from 0.1 to 10", (0.1, 10.0)),
            ("inertia of a rotor", self.rotor_inertia_kg_m2, "from 0 to 10 kg m²", (0.0, 10.0)),
        ] {
            if !(least..=greatest).contains(&value) {
                return Err(SimError::Figure { figure, value, range });
            }
        }
        Ok(())
    }
}

/// An arm as the engine wants it: rigid bodies, each on the one before by a joint of the group.
#[derive(Clone, Debug)]
pub(crate) struct ArmModel {
    /// The first is what no joint moves; parents before children.
    bodies: Vec<ArmBody>,
    /// The body of the hand, and the gripper frame in it.
    tip: (usize, Pose),
    drives: DriveSettings,
}

/// All links that move as one.
#[derive(Clone, Debug)]
struct ArmBody {
    /// The link whose frame is that of the body.
    link: usize,
    name: String,
    /// Body and joint on which it hangs; `None` for the first.
    hangs_on: Option<(usize, usize)>,
    /// In the frame of the body, without those of the hand.
    pieces: Vec<Piece>,
    colliders: Vec<Collider>,
    mass: Option<MassProperties>,
}

impl ArmModel {
    /// Of a robot, without the geometry of its hand.
    pub fn new(robot: &Robot, drives: DriveSettings) -> Result<Self, SimError> {
        drives.check()?;
        let name = || robot.name().to_owned();
        let frames = robot.frames();
        let mut bodies: Vec<ArmBody> = Vec::new();
        for link in 0..robot.links().len() {
            let movers = robot.ancestors(link);
            let own = movers.last().map_or(robot.root(), |mover| mover.child_link);
            if own != link {
                continue;
            }
            let hangs_on = match movers {
                [] => None,
                [above @ .., mover] => {
                    if mover.child_link != robot.joints()[mover.joint].child_link {
                        let joint = robot.joint_names()[mover.joint].clone();
                        return Err(SimError::Mimic { robot: name(), joint });
                    }
                    let parent = above.last().map_or(robot.root(), |mover| mover.child_link);
                    let parent = bodies.iter().position(|body| body.link == parent);
                    parent.map(|parent| (parent, mover.joint))
                }
            };
            let carried: Vec<usize> = carried_by(robot, link).collect();
            let mass = mass_of(robot, &frames, link, &carried);
            let has_shape = carried.iter().any(|other| !robot.links()[*other].collisions.is_empty());
            if mass.is_none() && hangs_on.is_some() && has_shape {
                return Err(SimError::NoMass { robot: name(), link: robot.links()[link].name.clone() });
            }
            let mut pieces = Vec::new();
            for &other in carried.iter().filter(|other| !robot.hand_links().contains(other)) {
                let body_from_link = frames.link(link).inverse() * frames.link(other);
                for shape in &robot.links()[other].collisions {
                    let pose = body_from_link * shape.link_from_shape;
                    pieces.extend(Piece::of_solid(&robot.links()[other].name, &pose, &shape.solid)?);
                }
            }
            let named = carried.iter().find(|other| !robot.links()[**other].collisions.is_empty());
            bodies.push(ArmBody {
                link,
                name: robot.links()[*named.unwrap_or(&link)].name.clone(),
                hangs_on,
                colliders: engine::colliders(&robot.links()[link].name, &pieces, 0.0, engine::HAND)?,
                pieces,
                mass,
            });
        }
        let tip_link = robot.ancestors(robot.tip()).last().map_or(robot.root(), |mover| mover.child_link);
        let tip = bodies.iter().position(|body| body.link == tip_link).unwrap_or(0);
        let tip = (tip, frames.link(tip_link).inverse() * frames.link(robot.tip()));
        Ok(Self { bodies, tip, drives })
    }

    /// The arm at a configuration (m, rad; one per joint), held there by its drives.
    pub fn insert(&self, robot: &Robot, q: &[f64], world: &mut PhysicsWorld) -> Arm {
        let frames = robot.frames_at(q);
        let mut arm = Arm {
            bodies: Vec::new(),
            joints: vec![None; robot.dof()],
            start: q.to_vec(),
            tip_from_gripper: self.tip.1,
            tip: self.tip.0,
        };
        for body in &self.bodies {
            let place = engine::pose(frames.link(body.link));
            let Some((parent, joint)) = body.hangs_on else {
                arm.bodies.push(world.insert_body(RigidBodyBuilder::fixed().pose(place)));
                Self::insert_colliders(body, arm.bodies[0], world);
                continue;
            };
            let mut rigid = RigidBodyBuilder::dynamic().pose(place).can_sleep(false);
            if let Some(mass) = body.mass {
                rigid = rigid.additional_mass_properties(mass);
            }
            let rigid = world.insert_body(rigid);
            Self::insert_colliders(body, rigid, world);
            let parent_from_body = frames.link(self.bodies[parent].link).inverse() * frames.link(body.link);
            let data = self.joint(robot, joint, &parent_from_body);
            let handle = world.insert_multibody_joint(arm.bodies[parent], rigid, data);
            arm.joints[joint] = handle.map(|handle| (handle, axis_of(robot.joints()[joint].kind)));
            arm.bodies.push(rigid);
            let of_rotor = robot.joints()[joint].kind == JointKind::Revolute;
            if let Some((multibody, _)) = handle.and_then(|handle| world.multibody_joints.get_mut(handle)) {
                let last = multibody.ndofs() - 1;
                // What the engine damps by itself is no part of the model.
                multibody.damping_mut().fill(0.0);
                multibody.armature_mut()[last] = if of_rotor { self.drives.rotor_inertia_kg_m2 } else { 0.0 };
            }
        }
        arm
    }

    fn insert_colliders(body: &ArmBody, rigid: RigidBodyHandle, world: &mut PhysicsWorld) {
        for collider in &body.colliders {
            world.insert_collider(collider.clone(), Some(rigid));
        }
    }

    /// A joint whose coordinate is how far it is from where it began.
    fn joint(&self, robot: &Robot, joint: usize, parent_from_body: &Pose) -> GenericJoint {
        let described = &robot.joints()[joint];
        // The engine's joints move along or about the x axis of their frame.
        let turn = UnitQuaternion::rotation_between(&Vector::x(), &described.axis_in_child)
            .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector::z_axis(), std::f64::consts::PI));
        let body_from_joint = Pose::from_parts(Vector::zeros().into(), turn);
        let (locked, axis) = match described.kind {
            JointKind::Revolute => (JointAxesMask::LOCKED_REVOLUTE_AXES, JointAxis::AngX),
            JointKind::Prismatic => (JointAxesMask::LOCKED_PRISMATIC_AXES, JointAxis::LinX),
        };
        let omega = std::f64::consts::TAU * self.drives.frequency_hz;
        GenericJointBuilder::new(locked)
            .local_frame1(engine::pose(&(parent_from_body * body_from_joint)))
            .local_frame2(engine::pose(&body_from_joint))
            .motor_model(axis, MotorModel::AccelerationBased)
            .set_motor(axis, 0.0, 0.0, omega * omega, 2.0 * self.drives.damping_ratio * omega)
            .motor_max_force(axis, described.effort.unwrap_or(f64::MAX))
            .build()
    }

    /// What can be seen of it: names and pieces of the bodies of [`Arm::bodies`].
    pub fn shapes(&self) -> impl Iterator<Item = (&str, &[Piece])> {
        self.bodies.iter().map(|body| (body.name.as_str(), &body.pieces[..]))
    }
}

/// The arm in a world of the engine.
pub(crate) struct Arm {
    pub bodies: Vec<RigidBodyHandle>,
    /// Per joint of the group.
    joints: Vec<Option<(MultibodyJointHandle, JointAxis)>>,
    /// Where it began; the engine counts from there.
    start: Vec<f64>,
    tip: usize,
    pub tip_from_gripper: Pose,
}

impl Arm {
    /// The body that carries the hand.
    pub fn tip(&self) -> RigidBodyHandle {
        self.bodies[self.tip]
    }

    /// Sets the targets of the drives: `q` (m, rad) and `velocity` (m/s, rad/s), one value per joint each.
    pub fn aim(&self, q: &[f64], velocity: &[f64], world: &mut PhysicsWorld) {
        for (index, joint) in self.joints.iter().enumerate() {
            let Some((handle, axis)) = *joint else { continue };
            let Some((multibody, link)) = world.multibody_joints.get_mut(handle) else { continue };
            let Some(link) = multibody.link_mut(link) else { continue };
            let motor = link.joint.data.motors[axis as usize];
            let (position, speed) = (q[index] - self.start[index], velocity[index]);
            link.joint.data.set_motor(axis, position, speed, motor.stiffness, motor.damping);
        }
    }

    /// The configuration (m, rad; one per joint) of the joints.
    pub fn configuration(&self, world: &PhysicsWorld) -> Vec<f64> {
        let value = |(joint, start): (&Option<(MultibodyJointHandle, JointAxis)>, &f64)| {
            let (handle, axis) = (*joint)?;
            let (multibody, link) = world.multibody_joints.get(handle)?;
            Some(start + multibody.link(link)?.joint.coords()[axis as usize])
        };
        let values = self.joints.iter().zip(&self.start);
        values.map(|pair| value(pair).unwrap_or(*pair.1)).collect()
    }
}

fn axis_of(kind: JointKind) -> JointAxis {
    match kind {
        JointKind::Revolute => JointAxis::AngX,
        JointKind::Prismatic => JointAxis::LinX,
    }
}

/// The links that move as one with a link below a joint, itself among them.
fn carried_by(robot: &Robot, body: usize) -> impl Iterator<Item = usize> {
    let of = |link: usize| robot.ancestors(link).last().map_or(robot.root(), |mover| mover.child_link);
    (0..robot.links().len()).filter(move |&link| of(link) == body)
}

/// Mass, centre and inertia of links together, in the frame of one of them; `None` if none of them weighs anything.
fn mass_of(robot: &Robot, frames: &LinkFrames, body: usize, links: &[usize]) -> Option<MassProperties> {
    let placed = |&link: &usize| {
        let inertial = robot.links()[link].inertial?;
        let body_from_link = frames.link(body).inverse() * frames.link(link);
        let turn = body_from_link.rotation.to_rotation_matrix();
        let inertia = turn.matrix() * inertial.inertia_kg_m2 * turn.matrix().transpose();
        Some((inertial.mass_kg, body_from_link * inertial.center, inertia))
    };
    let parts: Vec<(f64, Point, Matrix3<f64>)> = links.iter().filter_map(placed).collect();
    let mass_kg: f64 = parts.iter().map(|part| part.0).sum();
    if parts.is_empty() {
        return None;
    }
    let center = parts.iter().map(|(mass, at, _)| at.coords * *mass).sum::<Vector>() / mass_kg;
    let mut inertia = Matrix3::zeros();
    for (mass, at, own) in &parts {
        // The parallel axis theorem.
        let arm = at.coords - center;
        inertia += own + (Matrix3::identity() * arm.norm_squared() - arm * arm.transpose()) * *mass;
    }
    Some(engine::mass_properties(mass_kg, &Point::from(center), &inertia))
}
