use cranny_robot::Robot;
use cranny_spatial::Pose;
use rapier3d_f64::prelude::{
    ActiveCollisionTypes, Collider, PhysicsWorld, RigidBodyBuilder, RigidBodyHandle,
};

use crate::{Piece, SimError, engine};

/// Arm with prescribed link motions: each link is a rigid body that nothing pushes away. A real arm follows a timed path to
/// within fractions of a millimetre; a servo without feed-forward would not, and would push obstacles.
#[derive(Clone, Debug)]
pub(crate) struct ArmModel {
    bodies: Vec<ArmBody>,
}

/// Links that move as one rigid body.
#[derive(Clone, Debug)]
struct ArmBody {
    /// Index of the link whose frame is that of the body.
    link: usize,
    name: String,
    /// Pieces in the frame of the body, without those of the hand.
    pieces: Vec<Piece>,
    colliders: Vec<Collider>,
}

impl ArmModel {
    /// Creates the model of a robot, without the geometry of its hand.
    pub fn new(robot: &Robot) -> Result<Self, SimError> {
        let frames = robot.frames();
        let own = |link: usize| robot.ancestors(link).last().map_or(robot.root(), |mover| mover.child_link);
        let links = || 0..robot.links().len();
        let mut bodies: Vec<ArmBody> = Vec::new();
        for link in links().filter(|link| own(*link) == *link) {
            let mut pieces = Vec::new();
            let carried = || links().filter(|other| own(*other) == link);
            for other in carried().filter(|other| !robot.hand_links().contains(other)) {
                let body_from_link = frames.link(link).inverse() * frames.link(other);
                for shape in &robot.links()[other].collisions {
                    let pose = body_from_link * shape.link_from_shape;
                    pieces.extend(Piece::of_solid(&robot.links()[other].name, &pose, &shape.solid)?);
                }
            }
            let named = carried().find(|other| !robot.links()[*other].collisions.is_empty());
            bodies.push(ArmBody {
                link,
                name: robot.links()[named.unwrap_or(link)].name.clone(),
                colliders: engine::colliders(&robot.links()[link].name, &pieces, 0.0, engine::HAND)?,
                pieces,
            });
        }
        Ok(Self { bodies })
    }

    /// Inserts the arm at a configuration (m, rad; one per joint).
    pub fn insert(&self, robot: &Robot, q: &[f64], world: &mut PhysicsWorld) -> Vec<RigidBodyHandle> {
        let frames = robot.frames_at(q);
        let insert = |body: &ArmBody| {
            let rigid = RigidBodyBuilder::kinematic_position_based();
            let rigid = world.insert_body(rigid.pose(engine::pose(frames.link(body.link))));
            for collider in &body.colliders {
                world.insert_collider(collider.clone(), Some(rigid));
            }
            see_all_contacts(world, rigid);
            rigid
        };
        self.bodies.iter().map(insert).collect()
    }

    /// Sets the target of the next step: the bodies of the arm at a configuration (m, rad; one per joint). Returns the pose of
    /// the robot's tip there, in the planning frame (`world_from_tip`).
    pub fn aim(
        &self,
        robot: &Robot,
        q: &[f64],
        bodies: &[RigidBodyHandle],
        world: &mut PhysicsWorld,
    ) -> Pose {
        let frames = robot.frames_at(q);
        for (body, handle) in self.bodies.iter().zip(bodies) {
            world.bodies[*handle].set_next_kinematic_position(engine::pose(frames.link(body.link)));
        }
        *frames.link(robot.tip())
    }

    /// Returns names and pieces of the bodies.
    pub fn shapes(&self) -> impl Iterator<Item = (&str, &[Piece])> {
        self.bodies.iter().map(|body| (body.name.as_str(), &body.pieces[..]))
    }
}

/// Also enables contacts of a prescribed body with the surroundings, which push neither of them.
pub(crate) fn see_all_contacts(world: &mut PhysicsWorld, body: RigidBodyHandle) {
    for collider in world.bodies[body].colliders().to_vec() {
        let all = ActiveCollisionTypes::default() | ActiveCollisionTypes::KINEMATIC_FIXED;
        world.colliders[collider].set_active_collision_types(all);
    }
}
