use cranny_spatial::Vector;

use crate::chain::limits::{CONTINUOUS_LIMIT_RAD, FREE_JOINT_LIMIT_M};
use crate::description::xml::Element;
use crate::model_file::body_tree::JointRule;
use crate::model_file::unread_list::UnreadList;
use crate::sdf::scope::Scope;
use crate::{JointKind, Location, RobotError};

/// Value from which a limit is none (specification, limit: 1e16; models of Gazebo state 1e12).
const NO_LIMIT: f64 = 1e9;

/// A joint, with the names of its ends as frames.
pub(crate) struct SdfJoint {
    pub(crate) name: String,
    /// Name of its frame.
    pub(crate) frame: String,
    pub(crate) at: Location,
    pub(crate) parent: String,
    pub(crate) child: String,
    /// Motion; `None` for a fixed joint.
    pub(crate) motion: Option<SdfMotion>,
}

pub(crate) struct SdfMotion {
    pub(crate) kind: JointKind,
    pub(crate) axis: Vector,
    /// Frame of the axis.
    pub(crate) expressed_in: String,
    pub(crate) range: Option<[f64; 2]>,
    pub(crate) velocity: Option<f64>,
    pub(crate) effort: Option<f64>,
    pub(crate) rule: JointRule,
}

impl SdfJoint {
    /// Reads a joint; a joint of a static model does not move.
    pub(crate) fn read(
        element: Element<'_>,
        scope: &Scope,
        unread: &mut UnreadList,
    ) -> Result<Self, RobotError> {
        add_unread(element, unread);
        let name = element.text("name")?;
        let owner = format!("joint `{name}`");
        let end = |tag| -> Result<String, RobotError> {
            let end = element.needed(tag, &owner)?;
            let of = end.own_text().map_or_else(|| end.text("link"), Ok)?;
            Ok(if of == "world" { String::new() } else { scope.frame(of) })
        };
        let (parent, child) = (end("parent")?, end("child")?);
        let kind = match element.text("type")? {
            "fixed" => None,
            "revolute" => Some((JointKind::Revolute, true)),
            "continuous" => Some((JointKind::Revolute, false)),
            "prismatic" => Some((JointKind::Prismatic, true)),
            other => {
                let (at, joint) = (element.at(), name.to_owned());
                return Err(RobotError::UnsupportedJoint { at, joint, kind: other.to_owned() });
            }
        };
        let motion = match kind {
            Some((kind, is_limited)) if !scope.is_static => {
                let axis = element.needed("axis", &owner)?;
                Some(SdfMotion::read(axis, kind, is_limited, (scope, name))?)
            }
            _ => None,
        };
        Ok(Self {
            name: scope.name(name),
            frame: scope.joint_frame(name),
            at: element.at(),
            parent,
            child,
            motion,
        })
    }
}

/// Adds the content of a joint that is not read.
fn add_unread(joint: Element<'_>, unread: &mut UnreadList) {
    const OF_JOINT: [&str; 4] = ["parent", "child", "pose", "axis"];
    const OF_AXIS: [&str; 4] = ["xyz", "limit", "mimic", "use_parent_model_frame"];
    const OF_LIMIT: [&str; 4] = ["lower", "upper", "velocity", "effort"];
    let axis = joint.first("axis");
    let limit = axis.and_then(|axis| axis.first("limit"));
    for (owner, read) in [Some(joint), axis, limit].into_iter().zip([OF_JOINT, OF_AXIS, OF_LIMIT]) {
        let children = owner.into_iter().flat_map(|owner| owner.children().map(move |child| (owner, child)));
        for (owner, child) in children.filter(|(_, child)| !read.contains(&&*child.tag())) {
            unread.add(owner, child);
        }
    }
}

impl SdfMotion {
    fn read(
        axis: Element<'_>,
        kind: JointKind,
        is_limited: bool,
        (scope, joint): (&Scope, &str),
    ) -> Result<Self, RobotError> {
        let xyz = axis.first("xyz");
        let direction = axis.value_numbers("xyz")?.map_or_else(Vector::z, Vector::from);
        let direction = direction
            .try_normalize(1e-9)
            .ok_or_else(|| RobotError::ZeroAxis { at: axis.at(), joint: joint.to_owned() })?;
        let expressed_in = match xyz.and_then(|xyz| xyz.optional_text("expressed_in")) {
            Some(frame) if !frame.is_empty() => scope.frame(frame),
            // Until version 1.4 the axis was in the frame of the model.
            _ if scope.version <= [1, 4] || axis.value_flag("use_parent_model_frame") => {
                scope.model_frame.clone()
            }
            _ => scope.joint_frame(joint),
        };
        let limit = axis.first("limit").filter(|_| is_limited);
        let bound = |tag| limit.map_or(Ok(None), |limit| limit.value_number(tag));
        let (lower, upper) = (bound("lower")?, bound("upper")?);
        let far = match kind {
            JointKind::Revolute => CONTINUOUS_LIMIT_RAD,
            JointKind::Prismatic => FREE_JOINT_LIMIT_M,
        };
        let lower = lower.filter(|lower| *lower > -NO_LIMIT);
        let upper = upper.filter(|upper| *upper < NO_LIMIT);
        let range =
            (lower.is_some() || upper.is_some()).then(|| [lower.unwrap_or(-far), upper.unwrap_or(far)]);
        let positive = |value: Option<f64>| value.filter(|value| *value > 0.0 && *value < NO_LIMIT);
        let rule = match axis.first("mimic") {
            None => JointRule::Free,
            Some(mimic) => {
                let number = |tag, default| Ok::<_, RobotError>(mimic.value_number(tag)?.unwrap_or(default));
                let multiplier = number("multiplier", 1.0)?;
                let offset = number("offset", 0.0)? - multiplier * number("reference", 0.0)?;
                JointRule::Mimic { master: scope.name(mimic.text("joint")?), multiplier, offset }
            }
        };
        Ok(Self {
            kind,
            axis: direction,
            expressed_in,
            range,
            velocity: positive(bound("velocity")?),
            effort: positive(bound("effort")?),
            rule,
        })
    }
}
