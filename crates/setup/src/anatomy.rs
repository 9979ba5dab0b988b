use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};

use cranny_robot::{
    JointFacts, JointGroup, JointKind, LinkFrames, Mover, Robot, RobotError, RobotOptions, TextSource,
    UrdfText,
};
use cranny_shape::{Solid, separation};
use cranny_spatial::{CONTACT_M, Point, Pose, Vector};

use crate::limits;

/// Robot with all joints free, whose links are merged into rigid bodies.
pub(crate) struct Anatomy {
    pub robot: Robot,
    /// Joint data by joint name.
    pub joints: HashMap<String, JointFacts>,
    pub bodies: Vec<RigidBody>,
    pub body_of: Vec<usize>,
}

/// Links that are rigid with each other.
pub(crate) struct RigidBody {
    /// Topmost of the links.
    pub top: usize,
    pub links: Vec<usize>,
    /// Parent rigid body and the joint between; `None` for that of the root.
    pub above: Option<(usize, Mover)>,
    pub below: Vec<usize>,
}

impl Anatomy {
    /// Builds the anatomy of a URDF. `solid_meshes`: as in [`RobotOptions`].
    pub fn of(
        urdf: &UrdfText,
        base_dir: Option<&Path>,
        packages: &[PathBuf],
        solid_meshes: &[String],
    ) -> Result<Self, RobotError> {
        let facts = urdf.joints()?;
        let is_free =
            |joint: &&JointFacts| joint.motion.as_ref().is_some_and(|motion| motion.mimics.is_none());
        let group: Vec<String> = facts.iter().filter(is_free).map(|joint| joint.name.clone()).collect();
        // A robot without a joint is an error, which `Robot` reports.
        let group = if group.is_empty() { JointGroup::RootToTip } else { JointGroup::Joints(group) };
        let options = RobotOptions {
            group,
            limits: Some(TextSource::Text {
                name: "limits.yaml".to_owned(),
                text: limits::needed_text(&facts),
            }),
            packages: packages.to_owned(),
            solid_meshes: solid_meshes.to_owned(),
            ..RobotOptions::default()
        };
        let robot = Robot::from_urdf_text(urdf.text(), urdf.file(), base_dir, &options)?;
        let mut bodies: Vec<RigidBody> = Vec::new();
        let mut body_of: Vec<usize> = Vec::with_capacity(robot.links().len());
        for (index, link) in robot.links().iter().enumerate() {
            let own_joint = link.parent.and_then(|parent| {
                robot.ancestors(index).get(robot.ancestors(parent).len()).map(|mover| (parent, *mover))
            });
            match (link.parent, own_joint) {
                (Some(parent), None) => {
                    let body = body_of[parent];
                    bodies[body].links.push(index);
                    body_of.push(body);
                }
                (_, own_joint) => {
                    let above = own_joint.map(|(parent, mover)| (body_of[parent], mover));
                    if let Some((above, _)) = above {
                        let new = bodies.len();
                        bodies[above].below.push(new);
                    }
                    body_of.push(bodies.len());
                    bodies.push(RigidBody { top: index, links: vec![index], above, below: Vec::new() });
                }
            }
        }
        let joints = facts.into_iter().map(|joint| (joint.name.clone(), joint)).collect();
        Ok(Self { robot, joints, bodies, body_of })
    }

    /// Returns the configuration (m, rad; one per joint) with each joint as near to 0 as its limits allow.
    pub fn rest(&self) -> Vec<f64> {
        self.robot.limits().iter().map(|limits| limits.clamp(0.0)).collect()
    }

    /// Returns a rigid body and all its descendants.
    pub fn branch(&self, body: usize) -> Vec<usize> {
        let mut branch = vec![body];
        let mut next = 0;
        while let Some(&body) = branch.get(next) {
            branch.extend(&self.bodies[body].below);
            next += 1;
        }
        branch
    }

    /// Returns the solids of rigid bodies, with their poses in the frame of a link.
    pub fn solids_in(&self, bodies: &[usize], link: usize, frames: &LinkFrames) -> Vec<(Pose, Solid)> {
        let link_from_root = frames.link(link).inverse();
        let links = bodies.iter().flat_map(|&body| &self.bodies[body].links);
        let placed = links.flat_map(|&index| {
            let link_from_own = link_from_root * frames.link(index);
            let shapes = self.robot.links()[index].collisions.iter();
            shapes.map(move |shape| (link_from_own * shape.link_from_shape, shape.solid.clone()))
        });
        placed.collect()
    }

    /// Returns the data of the joint directly above a rigid body.
    pub fn joint_above(&self, body: usize) -> Option<&JointFacts> {
        let top = &self.robot.links()[self.bodies[body].top].name;
        self.joints.values().find(|joint| joint.child == *top)
    }

    /// Returns the joints of the group that move a rigid body, root first, with the joints that its mimic joints follow.
    pub fn joints_of(&self, body: usize) -> impl Iterator<Item = &Mover> {
        self.robot.ancestors(self.bodies[body].top).iter()
    }

    /// Returns an unused link name.
    pub fn free_name(&self, name: &str) -> String {
        let numbered = (2..).map(|number: u32| format!("{name}_{number}"));
        let mut names = std::iter::once(name.to_owned()).chain(numbered);
        names.find(|name| self.robot.link_index(name).is_none()).unwrap_or_default()
    }

    pub fn link_name(&self, link: usize) -> &str {
        &self.robot.links()[link].name
    }

    /// Returns true if the joint above a rigid body turns without end and mimics no other: a wheel, if it carries little.
    pub fn is_endless(&self, body: usize) -> bool {
        let motion = self.joint_above(body).and_then(|joint| joint.motion.as_ref());
        motion.is_some_and(|motion| motion.is_continuous && motion.mimics.is_none())
    }

    /// Returns the number of wheels: leaf links that turn without end about a horizontal axis.
    pub fn wheels(&self) -> usize {
        let is_wheel = |&body: &usize| self.bodies[body].below.is_empty() && self.is_endless(body);
        let is_upright = |&body: &usize| {
            let frames = self.robot.frames();
            self.bodies[body].above.is_some_and(|(_, mover)| {
                let axis = frames.link(mover.child_link).rotation * mover.axis_in_child;
                mover.kind == JointKind::Revolute && axis.z.abs() < 0.3
            })
        };
        (0..self.bodies.len()).filter(is_wheel).filter(is_upright).count()
    }
}

/// Returns the extent of solids in a direction, in metres from the origin.
pub(crate) fn extent_m(solids: &[(Pose, Solid)], direction: &Vector) -> f64 {
    let ends = solids.iter().filter_map(|(pose, solid)| {
        let (points, radius_m) = solid.bounding_points()?;
        let farthest = points.iter().map(|point| (pose * point).coords.dot(direction));
        Some(farthest.fold(f64::NEG_INFINITY, f64::max) + radius_m)
    });
    ends.fold(f64::NEG_INFINITY, f64::max)
}

/// Returns the distance of a point from solids, in metres; 0 inside.
pub(crate) fn distance_m(solids: &[(Pose, Solid)], point: &Point) -> f64 {
    /// Radius of the ball that stands for the point, negligible here, in metres.
    const POINT_M: f64 = 1e-7;
    let Ok(ball) = Solid::sphere(POINT_M) else { return 0.0 };
    let pose = Pose::from_parts(point.coords.into(), cranny_spatial::Rotation::identity());
    let distances = solids
        .iter()
        .map(|(own, solid)| separation(solid, own, &ball, &pose, f64::INFINITY).upper_m.max(0.0));
    distances.fold(f64::INFINITY, f64::min)
}

/// Returns true if two sets of solids touch.
pub(crate) fn touch(first: &[(Pose, Solid)], second: &[(Pose, Solid)]) -> bool {
    first.iter().any(|(pose_a, a)| {
        second.iter().any(|(pose_b, b)| separation(a, pose_a, b, pose_b, CONTACT_M).lower_m < CONTACT_M)
    })
}

/// Returns the mean of the centres of the bounding balls of solids.
pub(crate) fn middle(solids: &[(Pose, Solid)]) -> Option<Point> {
    let centers: Vec<Vector> =
        solids.iter().map(|(pose, solid)| (pose * solid.ball().center).coords).collect();
    let count = centers.len() as f64;
    (!centers.is_empty()).then(|| (centers.iter().sum::<Vector>() / count).into())
}

/// Returns true if a name is typical of hands and fingers.
pub(crate) fn is_hand_name(name: &str) -> bool {
    let name = name.to_lowercase();
    ["grip", "finger", "jaw", "claw", "hand", "thumb", "knuckle"].iter().any(|word| name.contains(word))
}

/// Returns joint values by joint name.
pub(crate) fn by_name(robot: &Robot, q: &[f64]) -> BTreeMap<String, f64> {
    robot.joint_names().iter().cloned().zip(q.iter().copied()).collect()
}
