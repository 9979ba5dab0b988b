use cranny_collision::World;
use cranny_grasp::{Finger, Grasp, Hand, PadRectangle};
use cranny_robot::{Hold, Robot, RobotHand};
use cranny_shape::{ShapeError, Solid, Surface, TriangleSoup, quick_lower_bound, separation};
use cranny_spatial::{CONTACT_M, Point, Pose, Vector};

use crate::grasping::grasp_poses;

/// Returns the hand of a robot: the links that move rigidly with its tip, with open fingers. Without a description of the hand
/// ([`Robot::hand`]), its dimensions are 0 and it has no fingers.
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
        pads: None,
    };
    let known = robot.hand();
    let motions: Vec<Vector> = (0..robot.links().len()).map(|link| straight_stroke_m(robot, link)).collect();
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
    let stands = |link: usize| motions[link].norm() <= 0.0;
    add_links(&stands);
    for finger in 0..known.map_or(0, |known| known.fingers) {
        let moves = |link: usize| robot.finger_of(link) == Some(finger) && !stands(link);
        let stroke_m = robot.hand_links().iter().find(|link| moves(**link)).map(|link| motions[*link]);
        let parts = add_links(&moves);
        hand.fingers.extend(stroke_m.map(|stroke_m| Finger { parts, stroke_m }));
    }
    if let Some(RobotHand { description, .. }) = known {
        hand.name.clone_from(&description.name);
        hand.opening_m = description.opening_m;
        hand.finger_depth_m = description.finger_depth_m;
        hand.closing_force_n = description.closing_force_n;
        hand.pads = description.pads.map(|pads| PadRectangle {
            middle_m: pads.middle_m,
            half_m: pads.size_m.map(|size_m| 0.5 * size_m),
        });
    }
    if let Some(tool) = robot.tool() {
        hand.name.clone_from(&tool.name);
    }
    hand
}

/// Returns the translation of a link in the gripper frame while the hand closes from fully open, in metres; 0 for a link that
/// turns, such as a knuckle of a parallel linkage.
fn straight_stroke_m(robot: &Robot, link: usize) -> Vector {
    /// A pad that turns by less counts as parallel, in radians.
    const PARALLEL_RAD: f64 = 0.02;
    let holding = robot.holding("");
    let mut frames = holding.frames();
    let at_zero = vec![0.0; robot.dof()];
    let mut tip_from_link_at = |closing: f64| {
        holding.place_held(&Hold { tip_from_held: Pose::identity(), closing }, &mut frames);
        holding.forward_kinematics(&at_zero, &mut frames);
        frames.link(robot.tip()).inv_mul(frames.link(link))
    };
    let (open, closed) = (tip_from_link_at(0.0), tip_from_link_at(1.0));
    if open.rotation.angle_to(&closed.rotation) > PARALLEL_RAD {
        return Vector::zeros();
    }
    closed.translation.vector - open.translation.vector
}

/// Collision filter for a hand in a world: checks a grasp, and the end of a straight approach to it, with open fingers.
///
/// The filter checks the volumes that the solids of the hand sweep, so one exact check decides the whole approach. A cylinder
/// counts as a prism around it, the surface of a mesh as the hulls of its pieces, a distance below [`CONTACT_M`] as contact.
#[derive(Clone, Debug)]
pub struct HandFilter {
    world: World,
    swept: Vec<(Pose, Solid)>,
    open_surfaces: Vec<(Pose, Surface)>,
    swept_surfaces: Vec<(Pose, Surface)>,
}

/// Default length of the straight approach, in metres: the depth of the Panda's fingers in front of its palm.
pub const APPROACH_M: f64 = 0.05;

/// Returns the corners of octahedra inscribed in balls about points.
fn with_rounding(points: &[Point], radius_m: f64) -> Vec<Point> {
    let axes = [Vector::x(), Vector::y(), Vector::z()].into_iter().flat_map(|axis| [axis, -axis]);
    points.iter().flat_map(|point| axes.clone().map(move |axis| point + axis * radius_m)).collect()
}

impl HandFilter {
    /// Creates the filter for `hand` in `world` (object, obstacles, floor), with a straight approach of length `approach_m` (m)
    /// along the gripper's z axis.
    ///
    /// # Errors
    /// [`ShapeError::FlatHull`] for a solid of the hand without extent, [`ShapeError::Size`] for an approach that is negative
    /// or not a number.
    pub fn new(hand: &Hand, world: World, approach_m: f64) -> Result<Self, ShapeError> {
        if !(0.0..=cranny_spatial::FARTHEST_M).contains(&approach_m) {
            return Err(ShapeError::Size { what: "the length of an approach", value: approach_m });
        }
        let mut swept = Vec::new();
        let mut swept_surfaces = Vec::new();
        for (gripper_from_part, solid) in &hand.parts {
            let back_in_part = gripper_from_part.rotation.inverse() * Vector::z() * -approach_m;
            // A half-space would sweep over everything, and no hand contains one.
            for solid in solid.swept(&back_in_part) {
                if let Some((points, radius_m)) = solid.bounding_points() {
                    let points = if radius_m > 0.0 { with_rounding(&points, radius_m) } else { points };
                    // A piece of a mesh may be flat.
                    let hull = TriangleSoup::convex_hull(&points)
                        .or_else(|_| TriangleSoup::convex_hull(&with_rounding(&points, CONTACT_M)))?;
                    swept_surfaces.push((*gripper_from_part, Surface::new(&hull)?));
                }
                swept.push((*gripper_from_part, solid));
            }
        }
        Ok(Self { world, swept, open_surfaces: Vec::new(), swept_surfaces })
    }

    /// Returns this filter with one more obstacle that is only a surface: the scan of an object that has holes. For rounded
    /// solids of the hand (spheres, capsules), octahedra inscribed in their balls are checked against it.
    #[must_use]
    pub fn with_surface(mut self, world_from_surface: Pose, surface: Surface) -> Self {
        self.open_surfaces.push((world_from_surface, surface));
        self
    }

    /// Returns true if the hand is free at the grasp or at its twin.
    pub fn is_free(&self, grasp: &Grasp) -> bool {
        grasp_poses::gripper_poses(grasp).iter().any(|pose| self.pose_is_free(pose))
    }

    /// Returns true if the hand is free at `world_from_gripper` and along the approach to it.
    pub fn pose_is_free(&self, world_from_gripper: &Pose) -> bool {
        self.blocking_body(world_from_gripper).is_none() && !self.meets_surface(world_from_gripper)
    }

    /// Returns the index of the first body that the hand touches at `world_from_gripper` or along the approach to it.
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
