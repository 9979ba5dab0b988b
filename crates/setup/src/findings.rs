use std::sync::Arc;

use cranny_collision::{Body, Cell, Margins, UncheckedReason, World};
use cranny_file::counted;
use cranny_robot::Robot;
use serde::Serialize;

use crate::SetupError;
use crate::self_contacts::{SELF_CONTACT_SAMPLES, SelfContact};

/// Findings from a robot's files.
#[derive(Clone, Debug, Serialize)]
pub struct RobotFindings {
    /// Joints that move, one line each.
    pub joints: Vec<String>,
    /// Other findings.
    pub findings: Vec<Finding>,
}

/// Property or omission of a robot's files, and its consequence.
#[derive(Clone, Debug, Serialize)]
pub struct Finding {
    /// Subject of the finding.
    pub what: &'static str,
    /// Observed property.
    pub found: String,
    /// Consequence for planning.
    pub consequence: String,
    /// True if it must be fixed before anything can be planned.
    pub is_fault: bool,
}

impl RobotFindings {
    /// Collects the findings of a robot.
    ///
    /// # Errors
    /// [`SetupError::Collision`] for a link that cannot be checked.
    pub fn of(robot: &Arc<Robot>) -> Result<Self, SetupError> {
        let joint = |(name, limits): (&String, &cranny_robot::JointLimits)| {
            let unit = limits.unit;
            let rate =
                |value: Option<f64>| value.map_or_else(|| "none".to_owned(), |value| value.to_string());
            format!(
                "{name}: {:.4} to {:.4} {unit}, {} {unit}/s, acceleration {}, jerk {}",
                limits.lower,
                limits.upper,
                limits.velocity,
                rate(limits.acceleration),
                rate(limits.jerk)
            )
        };
        let joints = robot.joint_names().iter().zip(robot.limits()).map(joint).collect();
        let contacts = SelfContact::sample(robot)?;
        let mut findings = vec![tip(robot), hand(robot)];
        findings.extend(cranny_scenario::wide_opening(robot).map(|doubt| {
            let consequence = "sampled grasps can be too wide for the fingers (`opening_m` in robot.yaml)";
            finding("opening", doubt, consequence, false)
        }));
        findings.push(rates(robot));
        findings.extend(robot.notes().iter().map(|note| finding("not read", note.clone(), UNREAD, false)));
        findings.extend(cranny_scenario::link_repairs(robot).into_iter().map(|repair| {
            finding("mesh", repair, "the volume that its repaired surface encloses is solid", false)
        }));
        findings.extend(geometry(robot));
        findings.extend(pairs(robot, &contacts));
        findings.push(start(robot)?);
        Ok(Self { joints, findings })
    }

    /// Returns true if there is no fault that prevents planning.
    pub fn is_sound(&self) -> bool {
        self.findings.iter().all(|finding| !finding.is_fault)
    }
}

/// Consequence of content of a model that is not read.
const UNREAD: &str = "shapes, joints and limits are complete without it, except for what the line states";

fn finding(what: &'static str, found: String, consequence: impl Into<String>, is_fault: bool) -> Finding {
    Finding { what, found, consequence: consequence.into(), is_fault }
}

fn name(robot: &Robot, link: usize) -> &str {
    &robot.links()[link].name
}

/// Reports links that have visual but no collision geometry.
fn geometry(robot: &Robot) -> Option<Finding> {
    let shaped = robot.links().iter().filter(|link| !link.collisions.is_empty()).count();
    let unseen: Vec<&str> = cranny_scenario::seen_only_links(robot).collect();
    let names = unseen.join(", ");
    let consequence = "links with a <visual> but no <collision> are ignored by collision checks and proofs";
    (!unseen.is_empty()).then(|| finding("not checked", names, consequence, shaped == 0))
}

fn tip(robot: &Robot) -> Finding {
    let found = name(robot, robot.tip()).to_owned();
    if robot.tool().is_some() {
        let consequence = "the frame that is moved to grasps: z must be the approach direction";
        return finding("gripper frame", found, consequence, false);
    }
    let consequence = "the frame that is moved to grasps: y must be the axis on which the pads close, z the \
                       approach direction";
    finding("gripper frame", found, consequence, false)
}

fn hand(robot: &Robot) -> Finding {
    let links: Vec<&str> = robot.hand_links().iter().map(|&link| name(robot, link)).collect();
    let links = if links.is_empty() {
        "no link with a `<collision>` below the gripper frame".to_owned()
    } else {
        links.join(", ")
    };
    if let Some(tool) = robot.tool() {
        let consequence = "grasps from files are reached; none are sampled, as it has no pads that close, and nothing is \
                           carried";
        return finding("tool", format!("{}: {links}", tool.name), consequence, false);
    }
    let Some(hand) = robot.hand() else {
        let consequence = "no joint is known to close it: grasps from files can be reached, but none sampled \
                           and nothing carried (`hand` in robot.yaml)";
        return finding("hand", links, consequence, false);
    };
    let description = &hand.description;
    let joints: Vec<String> = description
        .fingers
        .iter()
        .map(|(joint, range)| format!("{joint} {:.4} open, {:.4} closed", range.open, range.closed))
        .collect();
    let how = if joints.is_empty() { "closed by no joint".to_owned() } else { joints.join(", ") };
    let found = format!("{links}; {how}; {:.1} mm open", description.opening_m * 1000.0);
    let consequence = match (joints.is_empty(), hand.fingers) {
        (true, _) => "grasps are sampled for it, and reached; nothing is carried".to_owned(),
        (false, 1) => format!(
            "one finger moves ({}), closing with {} N; the other side is fixed",
            counted(hand.joints.len(), "joint"),
            description.closing_force_n
        ),
        (false, fingers) => format!(
            "{fingers} fingers move ({}), closing with {} N",
            counted(hand.joints.len(), "joint"),
            description.closing_force_n
        ),
    };
    finding("hand", found, consequence, false)
}

fn rates(robot: &Robot) -> Finding {
    let lacking: Vec<&str> = robot
        .limits()
        .iter()
        .zip(robot.joint_names())
        .filter(|(limits, _)| limits.acceleration.is_none())
        .map(|(_, name)| name.as_str())
        .collect();
    if lacking.is_empty() {
        return finding(
            "limits",
            "every joint has an acceleration".to_owned(),
            "trajectories are timed",
            false,
        );
    }
    let found = format!("no acceleration for {}", lacking.join(", "));
    finding("limits", found, "paths are planned, but not timed (give them in limits.yaml)", false)
}

fn pairs(robot: &Robot, contacts: &[SelfContact]) -> Vec<Finding> {
    let mut findings = Vec::new();
    let pair = |c: &SelfContact| format!("{} and {}", name(robot, c.links.0), name(robot, c.links.1));
    for contact in contacts.iter().filter(|contact| contact.is_declared) {
        let touched = contact.touching * 100 / SELF_CONTACT_SAMPLES;
        let depth = if contact.touching > 0 {
            format!(", at least {:.1} mm deep", contact.least_depth_m * 1000.0)
        } else {
            String::new()
        };
        let adjacent = if contact.is_adjacent { "adjacent, " } else { "" };
        let found =
            format!("{}: {adjacent}they touch in {touched} % of drawn configurations{depth}", pair(contact));
        findings.push(finding("unchecked pair", found, "not checked, as declared in its SRDF", false));
    }
    for (contact, reason) in contacts.iter().filter_map(|c| Some((c, c.unchecked?))) {
        let touched = contact.touching * 100 / SELF_CONTACT_SAMPLES;
        let found = format!("{}: they touch in {touched} % of drawn configurations", pair(contact));
        let consequence = match reason {
            UncheckedReason::AdjacentFree => {
                "adjacent, proven to touch at no value of their joint; their distance does not count as \
                 clearance"
            }
            UncheckedReason::AdjacentAtJoint => {
                "adjacent, not checked, and named with every plan: near their joint they touch at some of its values \
                 (--strict-pairs checks them)"
            }
            UncheckedReason::AdjacentUnproven => {
                "adjacent, not checked, and named with every plan: too close to prove anything of them"
            }
            _ => {
                "proven to touch in every configuration; not checked, and named with every plan; to accept \
                 the contact, disable the pair in an SRDF"
            }
        };
        findings.push(finding("not compared", found, consequence, false));
    }
    /// Minimum share of configurations in contact, in per cent, above which a pair severely restricts the robot.
    const OFTEN: usize = 60;
    let often = |c: &&SelfContact| {
        !c.is_declared && c.unchecked.is_none() && c.touching * 100 > OFTEN * SELF_CONTACT_SAMPLES
    };
    for contact in contacts.iter().filter(often) {
        let touched = contact.touching * 100 / SELF_CONTACT_SAMPLES;
        let found = format!("{}: they touch in {touched} % of drawn configurations", pair(contact));
        findings.push(finding(
            "touching pair",
            found,
            "checked: it severely restricts the motion of the robot",
            false,
        ));
    }
    findings
}

fn start(robot: &Arc<Robot>) -> Result<Finding, SetupError> {
    let Some(start) = robot.default_start() else {
        let consequence = "a scenario states the start; otherwise each joint is as near to 0 as its limits \
                           allow (`start` in robot.yaml)";
        return Ok(finding("start", "not stated".to_owned(), consequence, false));
    };
    if let Some(outside) = robot.first_limit_violation(start) {
        let joint = &robot.joint_names()[outside.joint];
        let found =
            format!("{joint} is at {}, outside {} to {}", outside.value, outside.lower, outside.upper);
        return Ok(finding("start", found, "nothing can be planned from there", true));
    }
    let floor = robot.floor_m().map(Body::floor);
    let cell = Cell::new(robot.clone(), World::new(floor.into_iter().collect())?, Margins::default())?;
    let mut scratch = cell.scratch();
    Ok(match cell.first_contact(start, &mut scratch) {
        None => {
            let clear_mm = cell.clearance(start, &mut scratch) * 1000.0;
            let found = format!("free, {clear_mm:.1} mm from itself and the ground");
            finding("start", found, "plans begin there unless a scenario states another start", false)
        }
        Some(contact) => {
            let [first, second] = contact.names(&cell);
            finding("start", format!("{first} touches {second}"), "nothing can be planned from there", true)
        }
    })
}
