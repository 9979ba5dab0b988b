use std::fmt;

use cranny_collision::{Cell, Contact, ToolBound, ToolRegion};
use cranny_file::distinct;
use cranny_robot::JointUnit;
use cranny_spatial::CONTACT_M;
use cranny_task::{FailureReason, FoundGrasp};
use serde::ser::SerializeMap;
use serde::{Deserialize, Serialize, Serializer};
use strum::IntoStaticStr;

/// Fault of a path. [`fmt::Display`] writes it as one sentence; as JSON it is an object of `kind`, `edge`, `at`, `first`,
/// `second`, `depth_m` and the further values of its cause.
#[derive(Clone, Debug, PartialEq)]
pub struct Violation {
    /// Location on the path.
    pub at: Location,
    /// Cause of the fault.
    pub cause: Cause,
}

/// Location on a path.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Location {
    /// Index, from 0, of the edge, or of the way point if the fault is at a single one.
    pub edge: usize,
    /// Position along the edge, in [0, 1].
    pub along: f64,
    /// Names of the pair that is too close: a link, and another link or a body.
    pub pair: Option<[String; 2]>,
}

/// Cause of a fault of a path.
#[derive(Clone, Debug, PartialEq, IntoStaticStr)]
#[strum(serialize_all = "kebab-case")]
pub enum Cause {
    /// The path does not begin at the start of the problem.
    Start(JointOffset),
    /// A joint is outside its limits, by the offset.
    JointLimit(JointOffset),
    /// A pair is in contact.
    Contact {
        /// Penetration depth, in metres.
        depth_m: f64,
    },
    /// A way point fails the released check (under `paper`).
    #[strum(to_string = "contact")]
    NotFree,
    /// A pair comes closer than the required margin.
    Clearance {
        /// Distance of the pair, in metres.
        clearance_m: f64,
        /// Required distance, in metres.
        required_m: f64,
    },
    /// No contact was found, but none could be excluded.
    Unresolved {
        /// Smallest distance found, in metres.
        clearance_m: f64,
    },
    /// An edge is longer than the step of the released planners (under `paper`).
    Step {
        /// Excess over that step, in metres.
        excess_m: f64,
    },
    /// The path does not end at a grasp.
    #[strum(to_string = "goal")]
    Grasp {
        /// Nearest grasp, if there is one.
        nearest: Option<GoalError>,
    },
    /// The path does not end at a goal configuration.
    #[strum(to_string = "goal")]
    Configuration {
        /// Joint with the largest offset from the nearest goal.
        farthest: JointOffset,
    },
    /// The hand does not hold the object where it must close on it.
    Grip {
        /// Reason of the failure.
        reason: FailureReason,
    },
    /// The hand closes on the target without force closure, or with too low a score.
    #[strum(to_string = "grip")]
    WeakGrasp {
        /// Score, in [0, 1]; 0 if the contacts are not in force closure.
        score: f64,
        /// Required score.
        required: f64,
    },
    /// The stated grasp at the end of the path is wrong.
    #[strum(to_string = "grip")]
    StatedGrasp {
        /// Stated and measured grasp.
        stated_and_measured: Box<[FoundGrasp; 2]>,
    },
    /// A plan file states a wrong value.
    Statement {
        /// Key in the file.
        key: String,
        /// Value in the file, in words.
        stated: String,
        /// Measured value, in words.
        measured: String,
    },
    /// The object comes closer to its support than at rest during lift-off, or that could not be excluded.
    LiftOff,
    /// The object is not off its support at the end of the lift-off.
    #[strum(to_string = "lift-off")]
    NotOff,
    /// The object travels farther in its lift-off than allowed.
    #[strum(to_string = "lift-off")]
    LongLiftOff {
        /// Length of the object's path, in metres.
        length_m: f64,
        /// Allowed length, in metres.
        most_m: f64,
    },
    /// The object comes closer to its support than at rest during set-down, or that could not be excluded.
    SetDown,
    /// The object is not off its support at the beginning of the set-down.
    #[strum(to_string = "set-down")]
    NotAbove,
    /// The object travels farther in its set-down than allowed.
    #[strum(to_string = "set-down")]
    LongSetDown {
        /// Length of the object's path, in metres.
        length_m: f64,
        /// Allowed length, in metres.
        most_m: f64,
    },
    /// The held object is tilted farther than allowed, or was not proven to keep the limit.
    Tilt {
        /// Tilt, in radians.
        tilt_rad: f64,
        /// Allowed tilt, in radians.
        most_rad: f64,
    },
    /// The tool violates a bound, or was not proven to keep it.
    Tool {
        /// Name of the bound.
        name: String,
        /// Excess over the bound, in radians or metres; not positive if only the proof failed.
        by: f64,
        /// True for a bound on an angle.
        is_angle: bool,
    },
    /// The object is released away from its goal placement.
    #[strum(to_string = "goal")]
    NotPlaced {
        /// Description of the difference.
        fault: String,
    },
    /// The hand is still too close to the object at the end of its retreat.
    #[strum(to_string = "retreat")]
    NotClear {
        /// Distance between hand and object, in metres.
        clearance_m: f64,
        /// Required distance, in metres.
        required_m: f64,
    },
    /// The straight approach or retreat of the hand is shorter than required.
    NotStraight {
        /// Length of the straight line, in metres.
        length_m: f64,
        /// Required length, in metres.
        required_m: f64,
    },
    /// The path ends before the task is complete.
    #[strum(to_string = "goal")]
    Unfinished {
        /// Index of the stage in which it ends.
        stage: usize,
        /// Number of stages.
        stages: usize,
    },
    /// The stated held object or finger opening is wrong.
    #[strum(to_string = "grip")]
    Hold {
        /// Stated object, and distance between the fingers, in metres.
        said: (String, f64),
        /// Object that the hand closes on, and distance between the fingers, in metres.
        held: (String, f64),
        /// Mode of the segment that states it.
        mode: &'static str,
    },
    /// The carried object is still too close to a body at the end of the move.
    #[strum(to_string = "goal")]
    NotOut {
        /// Distance of the object from the nearest body, in metres.
        clearance_m: f64,
        /// Required distance, in metres.
        required_m: f64,
    },
    /// The hand, or the object in it, does not reach the required poses.
    #[strum(to_string = "goal")]
    NotThere {
        /// Description of the difference.
        fault: String,
    },
}

/// Error of the end of a path relative to the nearest grasp.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GoalError {
    /// Index of the grasp.
    pub grasp: usize,
    /// Distance of the gripper frame from the grasp, in metres.
    pub translation_error_m: f64,
    /// Angle between the gripper frame and the grasp or its twin, in radians.
    pub rotation_error_rad: f64,
}

/// Offset of a joint from its allowed or required value.
#[derive(Clone, Debug, PartialEq)]
pub struct JointOffset {
    /// Name of the joint.
    pub joint: String,
    /// Offset (m or rad).
    pub off: f64,
    /// Unit of the offset.
    pub unit: JointUnit,
}

impl Location {
    /// Returns the location of a way point, numbered from 0.
    pub fn way_point(way_point: usize) -> Self {
        Self { edge: way_point, ..Self::default() }
    }

    pub(crate) fn of_contact(cell: &Cell, edge: usize, along: f64, contact: &Contact) -> Self {
        Self { edge, along, pair: Some(contact.names(cell)) }
    }
}

impl Violation {
    /// Creates a fault at a way point, numbered from 0.
    pub fn at_way_point(way_point: usize, cause: Cause) -> Self {
        Self { at: Location::way_point(way_point), cause }
    }

    /// Creates the fault of a pair that is too close on an edge.
    pub(crate) fn of_contact(cell: &Cell, edge: usize, along: f64, contact: &Contact) -> Self {
        let Contact { clearance_m, required_m, depth_m, .. } = *contact;
        let cause = if clearance_m < CONTACT_M {
            Cause::Contact { depth_m }
        } else if clearance_m < required_m {
            Cause::Clearance { clearance_m, required_m }
        } else {
            Cause::Unresolved { clearance_m }
        };
        Self { at: Location::of_contact(cell, edge, along, contact), cause }
    }

    /// Creates the fault of a pair on an edge that is neither proven free nor in contact.
    pub(crate) fn unresolved(cell: &Cell, edge: usize, along: f64, contact: &Contact) -> Self {
        let cause = Cause::Unresolved { clearance_m: contact.clearance_m };
        Self { at: Location::of_contact(cell, edge, along, contact), cause }
    }

    /// Creates the fault of tool bound `bound` on an edge, with its excess in radians or metres.
    pub(crate) fn out_of_bounds(cell: &Cell, (edge, along): (usize, f64), bound: usize, by: f64) -> Self {
        let is_tilt = cell.tilt_bound() == Some(bound);
        let cause = match cell.tool_bounds().nth(bound) {
            Some(ToolBound { region: ToolRegion::Cone { most_rad, .. }, .. }) if is_tilt => {
                Cause::Tilt { tilt_rad: by + most_rad, most_rad: *most_rad }
            }
            bound => Cause::Tool {
                name: bound.map_or_else(String::new, |bound| bound.name.clone()),
                by,
                is_angle: bound.is_some_and(|bound| bound.region.is_of_angle()),
            },
        };
        Self { at: Location { edge, along, pair: None }, cause }
    }

    /// Returns the name of its kind in files and `--json`.
    pub fn kind(&self) -> &'static str {
        (&self.cause).into()
    }

    /// Returns this fault for a path with `before` additional edges in front.
    pub(crate) fn counted_from(mut self, before: usize) -> Self {
        self.at.edge += before;
        self
    }
}

impl Cause {
    /// Returns the sentence of an exceeded bound; empty for other causes.
    fn of_bound(&self) -> String {
        match self {
            Self::Tilt { tilt_rad, most_rad } => {
                let [tilt, most] = [tilt_rad, most_rad].map(|angle| angle.to_degrees());
                format!(
                    "what is held is tilted by {tilt:.2}°, or not proven to be tilted by less, of {most:.2}° allowed"
                )
            }
            Self::Tool { name, by, is_angle } => {
                let (by, unit) = if *is_angle { (by.to_degrees(), "°") } else { (mm(*by), " mm") };
                format!("the bound '{name}' is exceeded by {by:.2}{unit}, or not proven to be kept")
            }
            _ => String::new(),
        }
    }
}

impl Location {
    /// Returns the words for the edge, or for the rounded corner at its end.
    fn stretch(&self) -> String {
        let (from, to) = (self.edge, self.edge + 1);
        if self.along < 1.0 {
            format!("edge {from}, from way point {from} to {to}")
        } else {
            format!("rounded corner at way point {to}")
        }
    }
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.pair {
            Some(_) => write!(f, "edge {} at {:.3}", self.edge, self.along),
            None => write!(f, "way point {}", self.edge),
        }
    }
}

/// Formats the difference of two unequal values with enough decimals not to show zero.
fn apart(off: f64, decimals: usize) -> String {
    let [off, _] = distinct([off, 0.0], decimals);
    off
}

fn mm(metres: f64) -> f64 {
    metres * 1e3
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { at, cause } = self;
        let [first, second] = at.pair.as_ref().map_or(["", ""], |pair| [&pair[0][..], &pair[1]]);
        match cause {
            Cause::Start(JointOffset { joint, off, unit }) => {
                write!(f, "{joint} is {} {unit} off the start", apart(*off, 6))
            }
            Cause::JointLimit(JointOffset { joint, off, unit }) => {
                write!(f, "{at}: {joint} is {} {unit} beyond its limit, of robot or task", apart(*off, 4))
            }
            Cause::Contact { depth_m } => {
                write!(f, "{at}: {first} is {} mm deep in {second}", apart(mm(*depth_m), 3))
            }
            Cause::NotFree => write!(f, "{at} is not free"),
            Cause::Clearance { clearance_m, required_m } => {
                let [clearance, required] = distinct([mm(*clearance_m), mm(*required_m)], 3);
                write!(f, "{at}: {first} is {clearance} mm from {second}, {required} mm are demanded")
            }
            Cause::Unresolved { .. } => {
                write!(f, "{at}: contact of {first} and {second} can be neither proven nor refuted")
            }
            Cause::Step { .. } => {
                write!(f, "edge {} is longer than a step of the released planners", at.edge)
            }
            Cause::Grasp { nearest: None } => {
                write!(f, "the path does not end at a grasp: the problem has no grasps")
            }
            Cause::Grasp { nearest: Some(nearest) } => {
                let off = apart(mm(nearest.translation_error_m), 2);
                let turned = apart(nearest.rotation_error_rad.to_degrees(), 2);
                let grasp = nearest.grasp;
                write!(f, "the path ends {off} mm and {turned}° from the nearest grasp, {grasp}")
            }
            Cause::Configuration { farthest: JointOffset { joint, off, unit } } => {
                write!(f, "the path ends with {joint} {} {unit} off the nearest goal", apart(*off, 6))
            }
            Cause::Grip { reason } => write!(f, "{at}: {}", reason.sentence()),
            Cause::WeakGrasp { score, required } => {
                let [score, required] = distinct([*score, *required], 3);
                write!(f, "{at}: the grasp has a score of {score}, {required} is demanded")
            }
            Cause::StatedGrasp { stated_and_measured } => {
                let [said, measured] = stated_and_measured.as_ref();
                write!(f, "{at}: {}", measured.against(said))
            }
            Cause::Statement { key, stated, measured } if key == "hold_demanded" => {
                write!(f, "{key}: the hold has a factor of {measured}, {stated} is demanded")
            }
            Cause::Statement { key, stated, measured } => {
                write!(f, "{key}: the file states {stated}, measured {measured}")
            }
            Cause::LiftOff | Cause::SetDown => {
                write!(f, "{at}: {first} is not proven to stay as far from {second} as at rest")
            }
            Cause::NotOff => write!(f, "{at}: the object is not yet clear of its support"),
            Cause::NotAbove => {
                write!(f, "{at}: the set-down does not begin clear of the support of the object")
            }
            Cause::LongLiftOff { length_m, most_m } | Cause::LongSetDown { length_m, most_m } => {
                let [length, most] = distinct([mm(*length_m), mm(*most_m)], 1);
                let moved =
                    if matches!(cause, Cause::LongLiftOff { .. }) { "lifted off" } else { "set down" };
                write!(f, "{at}: {moved} over {length} mm, {most} mm are allowed")
            }
            Cause::Tilt { .. } | Cause::Tool { .. } => write!(f, "{}: {}", at.stretch(), cause.of_bound()),
            Cause::NotPlaced { fault } => write!(f, "{at}: the object is let go, but {fault}"),
            Cause::NotThere { fault } => write!(f, "{at}: {fault}"),
            Cause::NotClear { clearance_m, required_m } | Cause::NotOut { clearance_m, required_m } => {
                let [clearance, required] = distinct([mm(*clearance_m), mm(*required_m)], 1);
                match cause {
                    Cause::NotOut { .. } => write!(f, "carried out, the object is {clearance} mm clear")?,
                    _ => write!(f, "after its retreat the hand is {clearance} mm from the object")?,
                }
                write!(f, ", {required} mm are demanded")
            }
            Cause::NotStraight { length_m, required_m } => {
                let [length, required] = distinct([mm(*length_m), mm(*required_m)], 1);
                write!(f, "{at}: the hand goes {length} mm on a straight line, {required} mm are demanded")
            }
            Cause::Unfinished { stage, stages } => {
                write!(f, "the path ends in stage {} of {stages}, before that is done", stage + 1)
            }
            Cause::Hold { said, held, mode } => {
                let [said, held] = [said, held]
                    .map(|(name, opening_m)| format!("{name}, fingers {:.2} mm apart", mm(*opening_m)));
                write!(f, "{at}: the hand holds {held}; stated of '{mode}': {said}")
            }
        }
    }
}

impl Serialize for Violation {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self { at, cause } = self;
        let [mut first, second] = at.pair.as_ref().map_or(["", ""], |pair| [&pair[0][..], &pair[1]]);
        let (mut unit, mut depth_m) = (None, None);
        let figures: &[(&str, f64)] = match cause {
            Cause::Start(offset) | Cause::JointLimit(offset) | Cause::Configuration { farthest: offset } => {
                (first, unit) = (&offset.joint, Some(offset.unit.symbol()));
                &[("off", offset.off)]
            }
            Cause::Contact { depth_m: depth } => {
                depth_m = Some(depth);
                &[]
            }
            Cause::Clearance { clearance_m, required_m }
            | Cause::NotOut { clearance_m, required_m }
            | Cause::NotClear { clearance_m, required_m } => {
                &[("clearance_m", *clearance_m), ("required_m", *required_m)]
            }
            Cause::LongLiftOff { length_m, most_m } | Cause::LongSetDown { length_m, most_m } => {
                &[("length_m", *length_m), ("most_m", *most_m)]
            }
            Cause::NotStraight { length_m, required_m } => {
                &[("length_m", *length_m), ("required_m", *required_m)]
            }
            Cause::Hold { said, held, .. } => &[("said_opening_m", said.1), ("opening_m", held.1)],
            Cause::WeakGrasp { score, required } => &[("score", *score), ("required", *required)],
            Cause::StatedGrasp { stated_and_measured } => {
                let [said, measured] = stated_and_measured.as_ref();
                &[
                    ("said_opening_m", said.opening_m),
                    ("opening_m", measured.opening_m),
                    ("said_score", said.score),
                    ("score", measured.score),
                ]
            }
            Cause::Unresolved { clearance_m } => &[("clearance_m", *clearance_m)],
            Cause::Tilt { tilt_rad, most_rad } => &[("tilt_rad", *tilt_rad), ("most_rad", *most_rad)],
            Cause::Tool { by, is_angle, .. } => &[(if *is_angle { "by_rad" } else { "by_m" }, *by)],
            Cause::Step { excess_m } => &[("excess_m", *excess_m)],
            Cause::Grasp { nearest: Some(nearest) } => &[
                ("translation_error_m", nearest.translation_error_m),
                ("rotation_error_rad", nearest.rotation_error_rad),
            ],
            _ => &[],
        };
        let mut row = serializer.serialize_map(None)?;
        row.serialize_entry("kind", self.kind())?;
        row.serialize_entry("edge", &at.edge)?;
        row.serialize_entry("at", &at.along)?;
        row.serialize_entry("first", first)?;
        row.serialize_entry("second", second)?;
        row.serialize_entry("depth_m", &depth_m)?;
        figures.iter().try_for_each(|(key, value)| row.serialize_entry(key, value))?;
        if let Cause::Statement { key, stated, measured } = cause {
            for (name, value) in [("key", key), ("stated", stated), ("measured", measured)] {
                row.serialize_entry(name, value)?;
            }
        }
        if let Cause::Tool { name, .. } = cause {
            row.serialize_entry("bound", name)?;
        }
        unit.map_or(Ok(()), |unit| row.serialize_entry("unit", unit))?;
        row.end()
    }
}
