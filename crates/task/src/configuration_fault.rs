use std::fmt;

use cranny_collision::Cell;
use cranny_file::distinct;
use cranny_robot::LimitViolation;
use cranny_spatial::{CONTACT_M, ROUNDING_M};

use crate::problem::Validity;
use crate::{FailureReason, Problem};

/// A reason why a configuration is not free, shown in one sentence.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ConfigurationFault {
    /// A joint is outside its limits (m, rad).
    JointLimit {
        /// The joint.
        joint: String,
        /// Its value.
        value: f64,
        /// Its lower limit.
        lower: f64,
        /// Its upper limit.
        upper: f64,
    },
    /// A link touches another link or a body.
    Contact {
        /// Name of a link.
        first: String,
        /// Name of another link or of a body.
        second: String,
        /// Penetration depth, in metres.
        depth_m: f64,
    },
    /// A link is closer to another link or a body than the required clearance.
    Clearance {
        /// Name of a link.
        first: String,
        /// Name of another link or of a body.
        second: String,
        /// Their distance, in metres.
        clearance_m: f64,
        /// Required distance, in metres.
        required_m: f64,
    },
    /// The tool is outside a bound.
    OutOfBounds {
        /// Name of the bound.
        name: String,
        /// Excess over the bound, in radians or metres.
        by: f64,
        /// True for a bound on an angle.
        is_angle: bool,
    },
    /// Under `paper`: the released check refuses the configuration without a reason.
    Refused,
}

/// Returns the bounds of the tool that are exceeded at `q` (m, rad; one per joint).
pub(crate) fn exceeded_bounds(cell: &Cell, q: &[f64]) -> Vec<ConfigurationFault> {
    let exceeded = cell.tool_bounds().enumerate().filter_map(|(index, bound)| {
        let by = cell.tool_excess(index, q, &mut cell.scratch());
        let (name, is_angle) = (bound.name.clone(), bound.region.is_of_angle());
        (by > -ROUNDING_M).then_some(ConfigurationFault::OutOfBounds { name, by, is_angle })
    });
    exceeded.collect()
}

/// Returns the reason why none of some ends of a transfer (m, rad; one value per joint) is within the bounds of the tool.
pub fn ends_out_of_bounds(cell: &Cell, ends: &[Vec<f64>]) -> Option<FailureReason> {
    let mut least: Option<FailureReason> = None;
    for end in ends {
        let exceeded = exceeded_bounds(cell, end);
        let Some(ConfigurationFault::OutOfBounds { name, by, is_angle }) = exceeded.into_iter().next() else {
            return None;
        };
        let is_less = match &least {
            Some(FailureReason::EndOutOfBounds { by: least, .. }) => by < *least,
            _ => true,
        };
        if is_less {
            least = Some(FailureReason::EndOutOfBounds { bound: name, by, is_angle });
        }
    }
    least
}

impl Problem {
    /// Returns all reasons why `q` (m, rad; one per joint) is not free; lists no contacts if a joint is outside its limits.
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn configuration_faults(&self, q: &[f64]) -> Vec<ConfigurationFault> {
        let robot = self.robot();
        let beyond: Vec<ConfigurationFault> = robot
            .limit_violations(q)
            .map(|LimitViolation { joint, value, lower, upper }| {
                let joint = robot.joint_names()[joint].clone();
                ConfigurationFault::JointLimit { joint, value, lower, upper }
            })
            .collect();
        if !beyond.is_empty() {
            return beyond;
        }
        match self.validity() {
            Validity::Exact(cell) => {
                let contacts = cell.contacts(q, &mut cell.scratch());
                let fault = |contact: &cranny_collision::Contact| {
                    let [first, second] = contact.names(cell);
                    if contact.clearance_m < CONTACT_M {
                        return ConfigurationFault::Contact { first, second, depth_m: contact.depth_m };
                    }
                    let (clearance_m, required_m) = (contact.clearance_m, contact.required_m);
                    ConfigurationFault::Clearance { first, second, clearance_m, required_m }
                };
                contacts.iter().map(fault).chain(exceeded_bounds(cell, q)).collect()
            }
            Validity::Paper { check, .. } => {
                let is_free = check.is_free(q, &mut check.scratch());
                if is_free { Vec::new() } else { vec![ConfigurationFault::Refused] }
            }
        }
    }

    /// Returns, for each goal configuration, all reasons why it is not free.
    pub fn goal_faults(&self) -> Vec<Vec<ConfigurationFault>> {
        self.goal_configurations().iter().map(|goal| self.configuration_faults(goal)).collect()
    }
}

impl fmt::Display for ConfigurationFault {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::JointLimit { joint, value, lower, upper } => {
                let [value, lower, upper] = distinct([*value, *lower, *upper], 4);
                write!(formatter, "{joint} is {value}, outside its limits [{lower}, {upper}]")
            }
            Self::Contact { first, second, depth_m } => {
                write!(formatter, "{first} touches {second}, {:.2} mm deep", depth_m * 1e3)
            }
            Self::Clearance { first, second, clearance_m, required_m } => {
                let [is, demanded] = distinct([clearance_m * 1e3, required_m * 1e3], 2);
                write!(formatter, "{first} is {is} mm from {second}, but {demanded} mm is demanded")
            }
            Self::OutOfBounds { name, by, is_angle: true } => {
                write!(formatter, "the bound '{name}' is exceeded by {:.2}°", by.to_degrees())
            }
            Self::OutOfBounds { name, by, .. } => {
                write!(formatter, "the bound '{name}' is exceeded by {:.2} mm", by * 1e3)
            }
            Self::Refused => formatter
                .write_str("the released check refuses it: a link touches, or is below the floor height"),
        }
    }
}
