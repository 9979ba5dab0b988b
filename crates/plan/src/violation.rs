use std::fmt;

use cranny_robot::JointUnit;
use serde::{Serialize, Serializer};

use crate::GoalError;

/// One thing that is wrong with a path. It is shown in one sentence ([`fmt::Display`]); as JSON it is an object of
/// `kind`, `edge`, `at`, `first`, `second`, `depth_m` and what the kind has besides.
#[derive(Clone, Debug, PartialEq)]
pub enum Violation {
    /// The path does not begin at the start of the problem.
    Start {
        /// The joint.
        joint: String,
        /// How far it is off (m or rad).
        off: f64,
        /// What that is measured in.
        unit: JointUnit,
    },
    /// A joint is outside its limits.
    JointLimit {
        /// Which way point, from 0.
        way_point: usize,
        /// The joint.
        joint: String,
        /// How far it is beyond (m or rad).
        excess: f64,
        /// What that is measured in.
        unit: JointUnit,
    },
    /// Two things touch.
    Contact {
        /// Where.
        place: Place,
        /// How deep, in metres.
        depth_m: f64,
    },
    /// Under `paper`: the released check says that a way point is not free.
    NotFree {
        /// Which way point, from 0.
        way_point: usize,
    },
    /// Two things come closer than the margin that is demanded.
    Clearance {
        /// Where.
        place: Place,
        /// Their distance, in metres.
        clearance_m: f64,
        /// The distance that is demanded, in metres.
        required_m: f64,
    },
    /// No contact was found, but none could be excluded either.
    Unresolved {
        /// Where.
        place: Place,
        /// The least distance that was seen, in metres.
        clearance_m: f64,
    },
    /// Under `paper`: a step farther than any that the released planners take between two checks.
    Step {
        /// Which edge, from 0.
        edge: usize,
        /// By how much, in metres.
        excess_m: f64,
    },
    /// The path does not end at a grasp.
    Grasp {
        /// Which way point is the last.
        way_point: usize,
        /// The nearest grasp, if there is any.
        nearest: Option<GoalError>,
    },
    /// The path does not end at a goal configuration.
    Configuration {
        /// Which way point is the last.
        way_point: usize,
        /// The joint that is farthest off from the nearest one.
        joint: String,
        /// How far (m or rad).
        off: f64,
        /// What that is measured in.
        unit: JointUnit,
    },
}

/// A place on an edge where two things are too close.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// Which edge, from 0.
    pub edge: usize,
    /// Where on it, in [0, 1].
    pub at: f64,
    /// A link.
    pub first: String,
    /// Another link, or a body.
    pub second: String,
}

impl Violation {
    /// What files and `--json` call its kind.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Start { .. } => "start",
            Self::JointLimit { .. } => "joint-limit",
            Self::Contact { .. } | Self::NotFree { .. } => "contact",
            Self::Clearance { .. } => "clearance",
            Self::Unresolved { .. } => "unresolved",
            Self::Step { .. } => "step",
            Self::Grasp { .. } | Self::Configuration { .. } => "goal",
        }
    }

    /// Which edge, from 0, or way point where it is about a single one.
    pub fn edge(&self) -> usize {
        match self {
            Self::Start { .. } => 0,
            Self::JointLimit { way_point, .. }
            | Self::NotFree { way_point }
            | Self::Grasp { way_point, .. }
            | Self::Configuration { way_point, .. } => *way_point,
            Self::Step { edge, .. } => *edge,
            Self::Contact { place, .. } | Self::Clearance { place, .. } | Self::Unresolved { place, .. } => {
                place.edge
            }
        }
    }

    /// Where two things are too close, if that is what is wrong.
    pub fn place(&self) -> Option<&Place> {
        match self {
            Self::Contact { place, .. } | Self::Clearance { place, .. } | Self::Unresolved { place, .. } => {
                Some(place)
            }
            _ => None,
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "edge {} at {:.3}", self.edge, self.at)
    }
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mm = |metres: f64| metres * 1e3;
        match self {
            Self::Start { joint, off, unit } => write!(f, "{joint} is {off:.6} {unit} off the start"),
            Self::JointLimit { way_point, joint, excess, unit } => {
                write!(f, "way point {way_point}: {joint} is {excess:.4} {unit} beyond its limit")
            }
            Self::Contact { place, depth_m } => {
                let Place { first, second, .. } = place;
                write!(f, "{place}: {first} is {:.3} mm deep in {second}", mm(*depth_m))
            }
            Self::NotFree { way_point } => write!(f, "way point {way_point} is not free"),
            Self::Clearance { place, clearance_m, required_m } => {
                let Place { first, second, .. } = place;
                let (clearance, required) = (mm(*clearance_m), mm(*required_m));
                write!(
                    f,
                    "{place}: {first} is {clearance:.3} mm from {second}, {required:.3} mm are demanded"
                )
            }
            Self::Unresolved { place, .. } => {
                let Place { first, second, .. } = place;
                write!(f, "{place}: {first} against {second} can be neither proven nor refuted")
            }
            Self::Step { edge, .. } => write!(f, "edge {edge} is longer than the released planners step"),
            Self::Grasp { nearest: None, .. } => write!(f, "the path ends at no grasp, for there is none"),
            Self::Grasp {
                nearest: Some(GoalError { grasp, translation_error_m, rotation_error_rad }),
                ..
            } => {
                let (off, turned) = (mm(*translation_error_m), rotation_error_rad.to_degrees());
                write!(f, "the path ends {off:.2} mm and {turned:.2}° from the nearest grasp, {grasp}")
            }
            Self::Configuration { joint, off, unit, .. } => {
                write!(f, "the path ends with {joint} {off:.6} {unit} off the nearest goal")
            }
        }
    }
}

/// A violation as JSON has it. The first six keys are in all kinds.
#[derive(Default, Serialize)]
struct Row<'a> {
    kind: &'static str,
    edge: usize,
    at: f64,
    first: &'a str,
    second: &'a str,
    depth_m: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    off: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    unit: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    clearance_m: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    required_m: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    excess_m: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    translation_error_m: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    rotation_error_rad: Option<f64>,
}

impl Serialize for Violation {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let of_joint = |joint, off, unit: JointUnit| Row {
            first: joint,
            off: Some(off),
            unit: Some(unit.symbol()),
            ..Row::default()
        };
        let row = match self {
            Self::Start { joint, off, unit } | Self::Configuration { joint, off, unit, .. } => {
                of_joint(joint.as_str(), *off, *unit)
            }
            Self::JointLimit { joint, excess, unit, .. } => of_joint(joint, *excess, *unit),
            Self::Contact { depth_m, .. } => Row { depth_m: Some(*depth_m), ..Row::default() },
            Self::NotFree { .. } => Row::default(),
            Self::Clearance { clearance_m, required_m, .. } => {
                Row { clearance_m: Some(*clearance_m), required_m: Some(*required_m), ..Row::default() }
            }
            Self::Unresolved { clearance_m, .. } => Row { clearance_m: Some(*clearance_m), ..Row::default() },
            Self::Step { excess_m, .. } => Row { excess_m: Some(*excess_m), ..Row::default() },
            Self::Grasp { nearest, .. } => Row {
                translation_error_m: nearest.map(|nearest| nearest.translation_error_m),
                rotation_error_rad: nearest.map(|nearest| nearest.rotation_error_rad),
                ..Row::default()
            },
        };
        let at = self.place().map_or(0.0, |place| place.at);
        let [first, second] =
            self.place().map_or([row.first, ""], |place| [place.first.as_str(), place.second.as_str()]);
        Row { kind: self.kind(), edge: self.edge(), at, first, second, ..row }.serialize(serializer)
    }
}
