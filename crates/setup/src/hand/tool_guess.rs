//! Gripper frame of a tool, which has no two sides that close on each other.
//!
//! 1. Fingers, if there are any, stand where their tips are farthest apart.
//! 2. The approach direction leads from the last joint of the arm to the middle of the tool, or to the tips of the fingers; it is
//!    that of an axis of the tool's link if one is near.
//! 3. The gripper frame lies between the fingers, slightly behind the nearest tip; without fingers, slightly ahead of the tool, so
//!    that the tool is free where its frame is on a face.

use std::collections::BTreeMap;

use cranny_file::counted;
use cranny_robot::UrdfText;
use cranny_shape::Solid;
use cranny_spatial::{Point, Pose, Rotation, Vector};

use crate::SetupError;
use crate::anatomy::{Anatomy, extent_m, middle};
use crate::choice::Choice;
use crate::hand::grip_place::{inset_m, upright};
use crate::hand::hand_guess::{finger_ends, palm_origin};
use crate::hand::palm::palms;
use crate::hand::posture::Posture;

/// Distance of the gripper frame of a tool without fingers ahead of it, in metres: more than the gripper may be off a grasp.
const AHEAD_M: f64 = 2e-3;

/// Tool with its gripper frame.
pub(crate) struct ToolGuess {
    /// Gripper frame in the link of the tool.
    pub link_from_frame: Pose,
    /// Existing bare link with this frame.
    pub existing: Option<usize>,
    /// Values of the joints of its fingers (m, rad), by name; empty if it has none.
    pub open: BTreeMap<String, f64>,
    /// Number of fingers.
    pub fingers: usize,
}

impl ToolGuess {
    /// Returns the tool of a link; `None` if it has no geometry that shows its approach direction.
    pub fn of(anatomy: &Anatomy, link: usize) -> Option<Self> {
        let body = anatomy.body_of[link];
        // 1.
        let palm = [2, 1]
            .into_iter()
            .find_map(|least| palms(anatomy, least).into_iter().find(|palm| palm.body == body));
        let fingers = palm.as_ref().map_or(&[][..], |palm| &palm.fingers);
        let (mut q, mut open) = (anatomy.rest(), BTreeMap::new());
        if let Some(palm) = &palm {
            let ends = finger_ends(anatomy, palm);
            let value = |&joint: &usize| (anatomy.robot.joint_names()[joint].clone(), ends.open[joint]);
            open = ends.drivers.iter().map(value).collect();
            q = ends.open;
        }
        let posture = Posture::at(anatomy, link, &q);
        // 2.
        let own: Vec<(Pose, Solid)> = anatomy.robot.links()[link]
            .collisions
            .iter()
            .map(|shape| (shape.link_from_shape, shape.solid.clone()))
            .collect();
        let own = if own.is_empty() { posture.palm_solids() } else { own };
        let tips: Vec<Point> = fingers.iter().map(|&finger| posture.tip(finger)).collect();
        let centre = match tips.len() {
            0 => middle(&own)?,
            count => (tips.iter().map(|tip| tip.coords).sum::<Vector>() / count as f64).into(),
        };
        let ahead = centre - palm_origin(&posture, body);
        let rotation = towards(&ahead)?;
        let [x, y, z] = [Vector::x(), Vector::y(), Vector::z()].map(|axis| rotation * axis);
        // 3.
        let tip_z = |&finger: &usize| extent_m(&posture.solids(finger), &z);
        let hinge_z = |&finger: &usize| posture.origin(anatomy.bodies[finger].top).coords.dot(&z);
        let nearest = fingers.iter().map(|finger| (tip_z(finger), hinge_z(finger)));
        let nearest = nearest.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|(tip_z, _)| tip_z.is_finite());
        let origin = if let Some((tip_z, hinge_z)) = nearest {
            let along = tip_z - inset_m(tip_z - hinge_z);
            centre.coords + z * (along - centre.coords.dot(&z))
        } else {
            let middle_along = |axis: &Vector| 0.5 * (extent_m(&own, axis) - extent_m(&own, &-axis));
            x * middle_along(&x) + y * middle_along(&y) + z * (extent_m(&own, &z) + AHEAD_M)
        };
        // Adding zero turns −0 into 0.
        let origin = origin.map(|length| (length * 1e5).round() / 1e5 + 0.0);
        let link_from_frame = Pose::from_parts(origin.into(), rotation);
        let existing = existing(anatomy, link, &posture, &link_from_frame);
        Some(Self { link_from_frame, existing, open, fingers: fingers.len() })
    }

    /// Describes the tool of a link, and returns the link of its gripper frame: `tip`, an existing one, or a new one in `text`.
    pub fn gripper_frame(
        &self,
        (anatomy, link): (&Anatomy, usize),
        tip: Option<usize>,
        text: &mut UrdfText,
        choices: &mut Vec<Choice>,
    ) -> Result<String, SetupError> {
        let tool = anatomy.link_name(link);
        let kind = match self.fingers {
            0 => format!("{tool}, a body without fingers"),
            count => format!("{tool} with {}, which stand open", counted(count, "finger")),
        };
        let why = "as requested: grasps for it come from files, none are sampled and nothing is carried";
        choices.push(Choice::new("tool", kind, why, "--palm LINK for a hand whose pads close along an axis"));
        let otherwise = "--tip LINK, or `tip` in robot.yaml";
        let frame = "z the approach direction, to which grasps refer";
        if let Some(link) = tip {
            let name = anatomy.link_name(link).to_owned();
            choices.push(Choice::new("gripper frame", name.clone(), "as requested", "--tip LINK"));
            return Ok(name);
        }
        if let Some(link) = self.existing {
            let name = anatomy.link_name(link).to_owned();
            let why = format!("a bare link at the end of the tool, {frame}");
            choices.push(Choice::new("gripper frame", name.clone(), &why, otherwise));
            return Ok(name);
        }
        let name = anatomy.free_name("grasp_frame");
        *text = text.with_frame(&name, tool, &self.link_from_frame)?;
        let [x, y, z] = self.link_from_frame.translation.vector.map(|length| length * 1000.0).into();
        let place = if self.fingers == 0 { "just ahead of the tool" } else { "between the open fingers" };
        choices.push(Choice::new(
            "gripper frame",
            format!("{name}, a new link at ({x:.1}, {y:.1}, {z:.1}) mm on {tool}"),
            &format!("{place}, {frame}"),
            otherwise,
        ));
        Ok(name)
    }
}

/// Returns a frame with z in a direction, and y along the axis most perpendicular to it.
fn towards(ahead: &Vector) -> Option<Rotation> {
    let axes = [Vector::y(), Vector::x(), Vector::z()];
    let y = axes.into_iter().min_by(|a, b| a.dot(ahead).abs().total_cmp(&b.dot(ahead).abs()))?;
    upright(&y, &ahead.try_normalize(1e-6)?, None)
}

/// Returns a bare link that is rigid with the tool, with the same approach direction and about the same origin, if there is one.
fn existing(anatomy: &Anatomy, link: usize, posture: &Posture, link_from_frame: &Pose) -> Option<usize> {
    const NEAR_M: f64 = 0.01;
    const TURNED: f64 = 0.996;
    let is_it = |&&other: &&usize| {
        let link_from_other = posture.frames.link(link).inverse() * posture.frames.link(other);
        let between = link_from_frame.inv_mul(&link_from_other);
        anatomy.robot.links()[other].collisions.is_empty()
            && between.translation.vector.norm() < NEAR_M
            && (between.rotation * Vector::z()).z > TURNED
    };
    anatomy.bodies[anatomy.body_of[link]].links.iter().find(is_it).copied()
}
