use std::collections::HashMap;

use cranny_robot::{HandJoint, JointKind, LinkFrames, Robot};
use cranny_scenario::Scenario;
use cranny_spatial::Pose;
use serde::Serialize;

use crate::viewer::number_row;

/// Kinematics of the robot of a page, sufficient for forward kinematics of all links.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct PageRobot {
    links: Vec<PageLink>,
    joints: Vec<PageJoint>,
    tip: usize,
    start: Vec<f64>,
}

#[derive(Clone, Debug, Serialize)]
struct PageLink {
    name: String,
    parent: Option<usize>,
}

#[derive(Clone, Debug, Serialize)]
struct PageJoint {
    name: String,
    child: usize,
    parent_from_child: [f64; 7],
    kind: &'static str,
    axis: [f64; 3],
    variable: Option<usize>,
    factor: f64,
    offset: f64,
    lower: Option<f64>,
    upper: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    stroke: Option<f64>,
}

/// Rectangle in the plane, in metres.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct FloorArea {
    low: [f64; 2],
    high: [f64; 2],
}

impl PageRobot {
    /// Returns an empty robot, for a page without one.
    pub fn none() -> Self {
        Self { links: Vec::new(), joints: Vec::new(), tip: 0, start: Vec::new() }
    }

    pub fn of(scenario: &Scenario) -> Self {
        let robot = &scenario.robot;
        let link = |link: &cranny_robot::Link| PageLink { name: link.name.clone(), parent: link.parent };
        Self {
            links: robot.links().iter().map(link).collect(),
            joints: PageJoint::all(robot),
            tip: robot.tip(),
            start: scenario.start.clone(),
        }
    }
}

impl PageJoint {
    /// Returns the joints between links and their parents. The pose at 0 includes the constant offset of a mimic joint, so that
    /// every offset is 0.
    fn all(robot: &Robot) -> Vec<Self> {
        let at_zero = robot.frames();
        let names: HashMap<usize, &str> =
            robot.joints().iter().map(|joint| (joint.child_link, joint.name.as_str())).collect();
        let of_hand = robot.hand().into_iter().flat_map(|hand| &hand.joints);
        let fingers: HashMap<usize, &HandJoint> = of_hand.map(|joint| (joint.link, joint)).collect();
        let above = |child| Self::above(robot, child, &at_zero, &names, &fingers);
        (1..robot.links().len()).filter_map(above).collect()
    }

    /// Returns the joint between a link and its parent; `None` for the root.
    fn above(
        robot: &Robot,
        child: usize,
        at_zero: &LinkFrames,
        names: &HashMap<usize, &str>,
        fingers: &HashMap<usize, &HandJoint>,
    ) -> Option<Self> {
        let parent = robot.links()[child].parent?;
        let parent_from_child = at_zero.link(parent).inv_mul(at_zero.link(child));
        let fixed = Self {
            name: robot.links()[child].name.clone(),
            child,
            parent_from_child: number_row::pose(&parent_from_child),
            kind: "fixed",
            axis: [0.0, 0.0, 1.0],
            variable: None,
            factor: 0.0,
            offset: 0.0,
            lower: None,
            upper: None,
            stroke: None,
        };
        let Some(mover) = robot.ancestors(child).last().filter(|mover| mover.child_link == child) else {
            return Some(match fingers.get(&child) {
                Some(HandJoint { kind, axis_in_link, stroke, .. }) => Self {
                    kind: kind_name(*kind),
                    axis: (*axis_in_link).into(),
                    stroke: Some(*stroke),
                    ..fixed
                },
                None => fixed,
            });
        };
        let limits = &robot.limits()[mover.joint];
        Some(Self {
            name: names.get(&child).map_or(fixed.name, |name| (*name).to_owned()),
            kind: kind_name(mover.kind),
            axis: mover.axis_in_child.into(),
            variable: Some(mover.joint),
            factor: mover.multiplier,
            lower: limits.lower.is_finite().then_some(limits.lower),
            upper: limits.upper.is_finite().then_some(limits.upper),
            ..fixed
        })
    }
}

fn kind_name(kind: JointKind) -> &'static str {
    match kind {
        JointKind::Revolute => "revolute",
        JointKind::Prismatic => "prismatic",
    }
}

impl FloorArea {
    /// Computes the area that the base can reach: the motion of the link that two prismatic joints move over the plane, between
    /// their limits. `None` for a robot that does not begin with two such joints.
    pub fn of(robot: &Robot) -> Option<Self> {
        let base = robot.links().iter().enumerate().position(|(link, _)| {
            let movers = robot.ancestors(link);
            movers.len() == 2 && movers.iter().all(|m| m.kind == JointKind::Prismatic)
        })?;
        let movers = robot.ancestors(base);
        let mut frames = robot.frames();
        let mut corner = |is_high: [bool; 2]| {
            let mut q = vec![0.0; robot.dof()];
            for (mover, is_high) in movers.iter().zip(is_high) {
                let limits = &robot.limits()[mover.joint];
                q[mover.joint] = if is_high { limits.upper } else { limits.lower };
            }
            robot.forward_kinematics(&q, &mut frames);
            let Pose { translation, .. } = frames.link(base);
            translation.vector
        };
        let corners = [[false, false], [false, true], [true, false], [true, true]].map(&mut corner);
        let is_level = corners.iter().all(|c| (c.z - corners[0].z).abs() < LEVEL_M && c.norm().is_finite());
        let bounds = |axis: usize| {
            let values = corners.iter().map(|corner| corner[axis]);
            (values.clone().fold(f64::INFINITY, f64::min), values.fold(f64::NEG_INFINITY, f64::max))
        };
        let ((low_x, high_x), (low_y, high_y)) = (bounds(0), bounds(1));
        is_level.then_some(Self { low: [low_x, low_y], high: [high_x, high_y] })
    }
}

/// Maximum height change of a base on a floor, in metres: far below any stair.
const LEVEL_M: f64 = 1e-6;
