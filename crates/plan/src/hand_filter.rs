use cranny_collision::World;
use cranny_grasp::{Finger, Grasp, Hand};
use cranny_robot::{JointKind, Robot, RobotFinger, RobotHand};
use cranny_shape::{ShapeError, Solid, Surface, TriangleSoup, quick_lower_bound, separation};
use cranny_spatial::{CONTACT_M, Pose, Vector};

use crate::grasp_poses;

/// The hand of a robot: the links that move as one with its tip. Fingers stand where the robot has them outside its
/// group of joints: open. What nobody describes of it ([`Robot::hand`]) is 0, and it has no fingers.
pub fn robot_hand(robot: &Robot) -> Hand {
    // Any configuration gives the rigid transforms between the links of the hand and the tip.
    let frames = robot.frames();
    let gripper_from_root = frames.link(robot.tip()).inverse();
    let mut hand = Hand {
        name: robot.name().to_owned(),
        parts: Vec::new(),
        fingers: Vec::new(),
        opening_m: 0.0,
        finger_depth_m: 0.0,
        closing_force_n: 0.0,
    };
    let known = robot.hand();
    let fingers = known.map_or(&[][..], |known| &known.fingers[..]);
    let is_below = |link: usize, finger: &RobotFinger| {
        std::iter::successors(Some(link), |&link| robot.links()[link].parent).any(|link| link == finger.link)
    };
    let mut add_links = |is_wanted: &dyn Fn(usize) -> bool| {
        let begin = hand.parts.len();
        for &link in robot.hand_links().iter().filter(|link| is_wanted(**link)) {
            let gripper_from_link = gripper_from_root * frames.link(link);
            let shapes = robot.links()[link].collisions.iter();
            hand.parts
                .extend(shapes.map(|shape| (gripper_from_link * shape.link_from_shape, shape.solid.clone())));
        }
        begin..hand.parts.len()
    };
    add_links(&|link| !fingers.iter().any(|finger| is_below(link, finger)));
    for finger in fingers {
        let parts = add_links(&|link| is_below(link, finger));
        let gripper_from_link = gripper_from_root * frames.link(finger.link);
        let stroke = finger.range.closed - finger.range.open;
        let stroke_m = match finger.kind {
            JointKind::Prismatic => gripper_from_link.rotation * finger.axis_in_link * stroke,
            JointKind::Revolute => continue,
        };
        hand.fingers.push(Finger { parts, stroke_m });
    }
    if let Some(RobotHand { description, .. }) = known {
        hand.name.clone_from(&description.name);
        hand.opening_m = description.opening_m;
        hand.finger_depth_m = description.finger_depth_m;
        hand.closing_force_n = description.closing_force_n;
    }
    hand
}

/// Whether a hand can take a grasp in a world: with open fingers, at the grasp and along the last of a
/// straight approach to it.
///
/// The hand is checked as the solids that its parts sweep over, so the whole approach is decided at once and
/// exactly; only a cylinder counts as a prism around it and a mesh as its convex hull. Contact is contact
/// below [`CONTACT_M`], as everywhere.
#[derive(Clone, Debug)]
pub struct HandFilter {
    world: World,
    swept: Vec<(Pose, Solid)>,
    open_surfaces: Vec<(Pose, Surface)>,
    swept_surfaces: Vec<(Pose, Surface)>,
}

/// How much of the approach is straight, in metres, unless said otherwise: the depth of the Panda's fingers
/// before its palm.
pub const APPROACH_M: f64 = 0.05;

impl HandFilter {
    /// The filter for `hand` in `world` (object, obstacles, floor), with `approach_m` of straight approach
    /// along the gripper's z.
    ///
    /// # Errors
    /// [`ShapeError::FlatHull`] for a part of the hand without volume, [`ShapeError::Size`] for a negative
    /// approach or one that is no number.
    pub fn new(hand: &Hand, world: World, approach_m: f64) -> Result<Self, ShapeError> {
        if !(0.0..=cranny_spatial::FARTHEST_M).contains(&approach_m) {
            return Err(ShapeError::Size { what: "the length of an approach", value: approach_m });
        }
        let mut swept = Vec::new();
        let mut swept_surfaces = Vec::new();
        for (gripper_from_part, solid) in &hand.parts {
            let back_in_part = gripper_from_part.rotation.inverse() * Vector::z() * -approach_m;
            // A half-space sweeps over everything, and belongs to no hand.
            let Some(solid) = solid.swept(&back_in_part) else { continue };
            if let Some((points, _)) = solid.bounding_points() {
                let hull = TriangleSoup::convex_hull(&points)?;
                swept_surfaces.push((*gripper_from_part, Surface::new(&hull)?));
            }
            swept.push((*gripper_from_part, solid));
        }
        Ok(Self { world, swept, open_surfaces: Vec::new(), swept_surfaces })
    }

    /// The same filter with one more thing in the way, which is only a surface: the scan of an object that has
    /// holes. Rounded parts of the hand (spheres, capsules) are checked against it without their rounding.
    #[must_use]
    pub fn with_surface(mut self, world_from_surface: Pose, surface: Surface) -> Self {
        self.open_surfaces.push((world_from_surface, surface));
        self
    }

    /// Whether the hand can take the grasp, or its twin.
    pub fn is_free(&self, grasp: &Grasp) -> bool {
        grasp_poses::poses(grasp).iter().any(|pose| self.pose_is_free(pose))
    }

    /// Whether the hand is free on its way to `world_from_gripper` and there.
    pub fn pose_is_free(&self, world_from_gripper: &Pose) -> bool {
        self.blocking_body(world_from_gripper).is_none() && !self.meets_surface(world_from_gripper)
    }

    /// The first body of the world, by index, that the hand touches on its way to `world_from_gripper` or
    /// there.
    pub fn blocking_body(&self, world_from_gripper: &Pose) -> Option<usize> {
        let touches = |pose: &Pose, hand: &Solid, other_pose: &Pose, other: &Solid| {
            quick_lower_bound(hand, pose, other, other_pose, CONTACT_M) < CONTACT_M
                && separation(hand, pose, other, other_pose, CONTACT_M).lower_m < CONTACT_M
        };
        self.world.bodies().iter().position(|body| {
            self.swept.iter().any(|(gripper_from_part, hand)| {
                let pose = world_from_gripper * gripper_from_part;
                body.parts.iter().any(|part| touches(&pose, hand, &part.world_from_solid, &part.solid))
            })
        })
    }

    fn meets_surface(&self, world_from_gripper: &Pose) -> bool {
        self.open_surfaces.iter().any(|(world_from_surface, surface)| {
            self.swept_surfaces.iter().any(|(gripper_from_part, hand)| {
                let pose = world_from_gripper * gripper_from_part;
                let gap_m = hand.aabb().gap_to(surface.aabb(), &pose.inv_mul(world_from_surface));
                gap_m <= 0.0 && hand.touches(&pose, surface, world_from_surface)
            })
        })
    }
}
