use std::fmt;

use cranny_file::distinct;
use cranny_robot::JointUnit;
use serde::ser::SerializeMap;
use serde::{Deserialize, Serialize, Serializer};
use strum::IntoStaticStr;

use crate::{FailureReason, OwnGrasp};

/// One thing that is wrong with a path. It is shown in one sentence ([`fmt::Display`]); as JSON it is an object of
/// `kind`, `edge`, `at`, `first`, `second`, `depth_m` and what the kind has besides.
#[derive(Clone, Debug, PartialEq, IntoStaticStr)]
#[strum(serialize_all = "kebab-case")]
pub enum Violation {
    /// The path does not begin at the start of the problem.
    Start(JointOffset),
    /// A joint is outside its limits.
    JointLimit {
        /// Which way point, from 0.
        way_point: usize,
        /// How far it is beyond.
        excess: JointOffset,
    },
    /// Two things touch.
    Contact {
        /// Where.
        place: Place,
        /// How deep, in metres.
        depth_m: f64,
    },
    /// Under `paper`: the released check says that a way point is not free.
    #[strum(to_string = "contact")]
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
    #[strum(to_string = "goal")]
    Grasp {
        /// Which way point is the last.
        way_point: usize,
        /// The nearest grasp, if there is any.
        nearest: Option<GoalError>,
    },
    /// The path does not end at a goal configuration.
    #[strum(to_string = "goal")]
    Configuration {
        /// Which way point is the last.
        way_point: usize,
        /// The joint that is farthest off from the nearest one.
        farthest: JointOffset,
    },
    /// The hand does not hold the object where it is to close on it.
    Grip {
        /// Which way point.
        way_point: usize,
        /// Why.
        reason: FailureReason,
    },
    /// The hand closes on the target in no grasp, or in one that is too bad.
    #[strum(to_string = "grip")]
    WeakGrasp {
        /// Which way point.
        way_point: usize,
        /// Its score, in [0, 1]; 0 where its contacts are in no force closure.
        score: f64,
        /// The score that is demanded.
        required: f64,
    },
    /// What is said of the grasp at which the path ends is not so.
    #[strum(to_string = "grip")]
    SaidGrasp {
        /// Which way point.
        way_point: usize,
        /// What is said, and what is so.
        said_and_measured: Box<[OwnGrasp; 2]>,
    },
    /// A plan file states a figure that is not so.
    Statement {
        /// Its key in the file.
        key: String,
        /// The value in the file, in words.
        stated: String,
        /// The measured value, in words.
        measured: String,
    },
    /// The object comes nearer to what it rested on than at rest, or that could not be excluded.
    LiftOff {
        /// Where.
        place: Place,
    },
    /// At the end of the lift-off the object is not off what it rested on.
    #[strum(to_string = "lift-off")]
    NotOff {
        /// Which way point is that end.
        way_point: usize,
    },
    /// The object goes farther in its lift-off than it may.
    #[strum(to_string = "lift-off")]
    LongLiftOff {
        /// Which way point is its end.
        way_point: usize,
        /// How far the object has gone there, in metres.
        length_m: f64,
        /// How far it may go, in metres.
        most_m: f64,
    },
    /// On its way down the object comes nearer to what it is put down on than it is then to be, or that could not be excluded.
    SetDown {
        /// Where.
        place: Place,
    },
    /// Where its way down begins the object is not off what it is put down on.
    #[strum(to_string = "set-down")]
    NotAbove {
        /// Which way point is that begin.
        way_point: usize,
    },
    /// The object goes farther on its way down than it may.
    #[strum(to_string = "set-down")]
    LongSetDown {
        /// Which way point is its end.
        way_point: usize,
        /// How far the object has gone there, in metres.
        length_m: f64,
        /// How far it may go, in metres.
        most_m: f64,
    },
    /// The object is let go elsewhere than where it is to be put down.
    #[strum(to_string = "goal")]
    NotPlaced {
        /// Which way point.
        way_point: usize,
        /// What is wrong, in words.
        fault: String,
    },
    /// At the end of its retreat the hand is still too near to the object.
    #[strum(to_string = "retreat")]
    NotClear {
        /// Which way point is that end.
        way_point: usize,
        /// How far the hand is from the object there, in metres.
        clearance_m: f64,
        /// How far it has to be, in metres.
        required_m: f64,
    },
    /// The path ends before the task does.
    #[strum(to_string = "goal")]
    Unfinished {
        /// Which way point is the last.
        way_point: usize,
        /// Index of the stage in which it ends.
        stage: usize,
        /// Number of stages.
        stages: usize,
    },
    /// What is said of the object in the hand is not so.
    #[strum(to_string = "grip")]
    Hold {
        /// Which way point.
        way_point: usize,
        /// What is said: the object, and how far the fingers are apart, in metres.
        said: (String, f64),
        /// What the hand closes on, and how far the fingers are apart then, in metres.
        held: (String, f64),
    },
    /// Carried out, the object is still too near to something.
    #[strum(to_string = "goal")]
    NotOut {
        /// Which way point is the last.
        way_point: usize,
        /// How far the object is from the nearest body there, in metres.
        clearance_m: f64,
        /// How far it has to be, in metres.
        required_m: f64,
    },
}

/// The end of a path against the nearest grasp.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GoalError {
    /// Index of the grasp.
    pub grasp: usize,
    /// Distance of the gripper frame from it, in metres.
    pub translation_error_m: f64,
    /// Angle between the gripper frame and it or its twin, in radians.
    pub rotation_error_rad: f64,
}

/// How far a joint is from where it may be.
#[derive(Clone, Debug, PartialEq)]
pub struct JointOffset {
    /// The joint.
    pub joint: String,
    /// How far (m or rad).
    pub off: f64,
    /// What that is measured in.
    pub unit: JointUnit,
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
        self.into()
    }

    /// Which edge, from 0, or way point where it is about a single one.
    pub fn edge(&self) -> usize {
        match self {
            Self::Start(_) | Self::Statement { .. } => 0,
            Self::JointLimit { way_point, .. }
            | Self::NotFree { way_point }
            | Self::Grasp { way_point, .. }
            | Self::Configuration { way_point, .. }
            | Self::Grip { way_point, .. }
            | Self::WeakGrasp { way_point, .. }
            | Self::SaidGrasp { way_point, .. }
            | Self::LongLiftOff { way_point, .. }
            | Self::Hold { way_point, .. }
            | Self::NotOut { way_point, .. }
            | Self::Unfinished { way_point, .. }
            | Self::NotAbove { way_point }
            | Self::LongSetDown { way_point, .. }
            | Self::NotPlaced { way_point, .. }
            | Self::NotClear { way_point, .. }
            | Self::NotOff { way_point } => *way_point,
            Self::Step { edge, .. } => *edge,
            Self::Contact { place, .. }
            | Self::Clearance { place, .. }
            | Self::Unresolved { place, .. }
            | Self::SetDown { place }
            | Self::LiftOff { place } => place.edge,
        }
    }

    /// Where two things are too close, if that is what is wrong.
    pub fn place(&self) -> Option<&Place> {
        match self {
            Self::Contact { place, .. }
            | Self::Clearance { place, .. }
            | Self::Unresolved { place, .. }
            | Self::SetDown { place }
            | Self::LiftOff { place } => Some(place),
            _ => None,
        }
    }

    /// The same of a path that has so many edges before this one.
    pub(crate) fn counted_from(mut self, before: usize) -> Self {
        match &mut self {
            Self::Start(_) | Self::Statement { .. } => {}
            Self::JointLimit { way_point, .. }
            | Self::NotFree { way_point }
            | Self::Grasp { way_point, .. }
            | Self::Configuration { way_point, .. }
            | Self::Grip { way_point, .. }
            | Self::WeakGrasp { way_point, .. }
            | Self::SaidGrasp { way_point, .. }
            | Self::LongLiftOff { way_point, .. }
            | Self::Hold { way_point, .. }
            | Self::NotOut { way_point, .. }
            | Self::Unfinished { way_point, .. }
            | Self::NotAbove { way_point }
            | Self::LongSetDown { way_point, .. }
            | Self::NotPlaced { way_point, .. }
            | Self::NotClear { way_point, .. }
            | Self::NotOff { way_point } => *way_point += before,
            Self::Step { edge, .. } => *edge += before,
            Self::Contact { place, .. }
            | Self::Clearance { place, .. }
            | Self::Unresolved { place, .. }
            | Self::SetDown { place }
            | Self::LiftOff { place } => place.edge += before,
        }
        self
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "edge {} at {:.3}", self.edge, self.at)
    }
}

/// Difference of two values that are not equal, with as many decimals as it takes not to show zero.
fn apart(off: f64, decimals: usize) -> String {
    let [off, _] = distinct([off, 0.0], decimals);
    off
}

fn mm(metres: f64) -> f64 {
    metres * 1e3
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Start(JointOffset { joint, off, unit }) => {
                write!(f, "{joint} is {} {unit} off the start", apart(*off, 6))
            }
            Self::JointLimit { way_point, excess: JointOffset { joint, off, unit } } => {
                let off = apart(*off, 4);
                write!(f, "way point {way_point}: {joint} is {off} {unit} beyond its limit")
            }
            Self::Contact { place: place @ Place { first, second, .. }, depth_m } => {
                write!(f, "{place}: {first} is {} mm deep in {second}", apart(mm(*depth_m), 3))
            }
            Self::NotFree { way_point } => write!(f, "way point {way_point} is not free"),
            Self::Clearance { place: place @ Place { first, second, .. }, clearance_m, required_m } => {
                let [clearance, required] = distinct([mm(*clearance_m), mm(*required_m)], 3);
                write!(f, "{place}: {first} is {clearance} mm from {second}, {required} mm are demanded")
            }
            Self::Unresolved { place: place @ Place { first, second, .. }, .. } => {
                write!(f, "{place}: {first} against {second} can be neither proven nor refuted")
            }
            Self::Step { edge, .. } => write!(f, "edge {edge} is longer than the released planners step"),
            Self::Grasp { nearest: None, .. } => write!(f, "the path ends at no grasp, for there is none"),
            Self::Grasp { nearest: Some(nearest), .. } => {
                let off = apart(mm(nearest.translation_error_m), 2);
                let turned = apart(nearest.rotation_error_rad.to_degrees(), 2);
                let grasp = nearest.grasp;
                write!(f, "the path ends {off} mm and {turned}° from the nearest grasp, {grasp}")
            }
            Self::Configuration { farthest: JointOffset { joint, off, unit }, .. } => {
                write!(f, "the path ends with {joint} {} {unit} off the nearest goal", apart(*off, 6))
            }
            Self::Grip { way_point, reason } => write!(f, "way point {way_point}: {}", reason.sentence()),
            Self::WeakGrasp { way_point, score, required } => {
                let [score, required] = distinct([*score, *required], 3);
                write!(f, "way point {way_point}: a grasp of score {score} there, {required} is demanded")
            }
            Self::SaidGrasp { way_point, said_and_measured } => {
                let [said, measured] = said_and_measured.as_ref();
                write!(f, "way point {way_point}: {}", measured.against(said))
            }
            Self::Statement { key, stated, measured } => {
                write!(f, "{key}: the file states {stated}, measured {measured}")
            }
            Self::LiftOff { place: place @ Place { first, second, .. } }
            | Self::SetDown { place: place @ Place { first, second, .. } } => {
                write!(f, "{place}: {first} is not proven to stay off {second} as it was at rest")
            }
            Self::NotOff { way_point } => {
                write!(f, "way point {way_point}: the object is not yet off what it rested on")
            }
            Self::LongLiftOff { way_point, length_m, most_m } => {
                let [length, most] = distinct([mm(*length_m), mm(*most_m)], 1);
                write!(f, "way point {way_point}: lifted off over {length} mm, {most} mm are allowed")
            }
            Self::NotAbove { way_point } => {
                write!(f, "way point {way_point}: the object is not yet off what it is put down on")
            }
            Self::LongSetDown { way_point, length_m, most_m } => {
                let [length, most] = distinct([mm(*length_m), mm(*most_m)], 1);
                write!(f, "way point {way_point}: set down over {length} mm, {most} mm are allowed")
            }
            Self::NotPlaced { way_point, fault } => {
                write!(f, "way point {way_point}: the object is let go, but {fault}")
            }
            Self::NotClear { clearance_m, required_m, .. } => {
                let [clearance, required] = distinct([mm(*clearance_m), mm(*required_m)], 1);
                write!(
                    f,
                    "after its retreat the hand is {clearance} mm from the object, {required} mm are demanded"
                )
            }
            Self::Unfinished { stage, stages, .. } => {
                write!(f, "the path ends in stage {} of {stages}, before that is done", stage + 1)
            }
            Self::Hold { way_point, said, held } => {
                let [said, held] = [said, held]
                    .map(|(name, opening_m)| format!("{name}, fingers {:.2} mm apart", mm(*opening_m)));
                write!(f, "way point {way_point}: the hand holds {held}, and not, as is said, {said}")
            }
            Self::NotOut { clearance_m, required_m, .. } => {
                let [clearance, required] = distinct([mm(*clearance_m), mm(*required_m)], 1);
                write!(f, "carried out, the object is {clearance} mm clear, {required} mm are demanded")
            }
        }
    }
}

impl Serialize for Violation {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let place = self.place();
        let (mut first, mut unit, mut depth_m) = (place.map_or("", |place| &place.first), None, None);
        let figures: &[(&str, f64)] = match self {
            Self::Start(offset)
            | Self::JointLimit { excess: offset, .. }
            | Self::Configuration { farthest: offset, .. } => {
                (first, unit) = (&offset.joint, Some(offset.unit.symbol()));
                &[("off", offset.off)]
            }
            Self::Contact { depth_m: depth, .. } => {
                depth_m = Some(depth);
                &[]
            }
            Self::Clearance { clearance_m, required_m, .. }
            | Self::NotOut { clearance_m, required_m, .. }
            | Self::NotClear { clearance_m, required_m, .. } => {
                &[("clearance_m", *clearance_m), ("required_m", *required_m)]
            }
            Self::LongLiftOff { length_m, most_m, .. } | Self::LongSetDown { length_m, most_m, .. } => {
                &[("length_m", *length_m), ("most_m", *most_m)]
            }
            Self::Hold { said, held, .. } => &[("said_opening_m", said.1), ("opening_m", held.1)],
            Self::WeakGrasp { score, required, .. } => &[("score", *score), ("required", *required)],
            Self::SaidGrasp { said_and_measured, .. } => {
                let [said, measured] = said_and_measured.as_ref();
                &[
                    ("said_opening_m", said.opening_m),
                    ("opening_m", measured.opening_m),
                    ("said_score", said.score),
                    ("score", measured.score),
                ]
            }
            Self::Unresolved { clearance_m, .. } => &[("clearance_m", *clearance_m)],
            Self::Step { excess_m, .. } => &[("excess_m", *excess_m)],
            Self::Grasp { nearest: Some(nearest), .. } => &[
                ("translation_error_m", nearest.translation_error_m),
                ("rotation_error_rad", nearest.rotation_error_rad),
            ],
            Self::NotFree { .. }
            | Self::Grasp { nearest: None, .. }
            | Self::Grip { .. }
            | Self::Statement { .. }
            | Self::LiftOff { .. }
            | Self::SetDown { .. }
            | Self::NotAbove { .. }
            | Self::NotPlaced { .. }
            | Self::Unfinished { .. }
            | Self::NotOff { .. } => &[],
        };
        let mut row = serializer.serialize_map(None)?;
        row.serialize_entry("kind", self.kind())?;
        row.serialize_entry("edge", &self.edge())?;
        row.serialize_entry("at", &place.map_or(0.0, |place| place.at))?;
        row.serialize_entry("first", first)?;
        row.serialize_entry("second", place.map_or("", |place| &place.second))?;
        row.serialize_entry("depth_m", &depth_m)?;
        figures.iter().try_for_each(|(key, value)| row.serialize_entry(key, value))?;
        if let Self::Statement { key, stated, measured } = self {
            for (name, value) in [("key", key), ("stated", stated), ("measured", measured)] {
                row.serialize_entry(name, value)?;
            }
        }
        unit.map_or(Ok(()), |unit| row.serialize_entry("unit", unit))?;
        row.end()
    }
}
