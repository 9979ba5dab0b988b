use cranny_file::distinct;
use cranny_grasp::Grasp;
use cranny_robot::Robot;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Why one grasp was not reached by a search that found no path.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Value")]
pub struct GraspFailure {
    /// Index of the grasp.
    pub grasp: usize,
    /// What stood in the way.
    #[serde(flatten)]
    pub reason: FailureReason,
    /// Attempts of inverse kinematics at it and its twin.
    pub attempts: u64,
}

/// The row of a [`GraspFailure`] before its keys are checked: serde refuses no unknown key beside a flattened field.
#[derive(Deserialize)]
struct FailureRow {
    grasp: usize,
    #[serde(flatten)]
    reason: FailureReason,
    attempts: u64,
}

impl TryFrom<Value> for GraspFailure {
    type Error = String;

    /// Reads a row, and refuses keys that it does not have.
    fn try_from(row: Value) -> Result<Self, String> {
        let FailureRow { grasp, reason, attempts } =
            FailureRow::deserialize(&row).map_err(|fault| fault.to_string())?;
        let failure = Self { grasp, reason, attempts };
        let known = serde_json::to_value(&failure).map_err(|fault| fault.to_string())?;
        let unknown =
            row.as_object().and_then(|row| row.keys().find(|key| known.get(key.as_str()).is_none()));
        unknown.map_or(Ok(failure), |key| Err(format!("unknown field `{key}`")))
    }
}

impl GraspFailure {
    /// The reason for which most grasps failed.
    pub fn commonest(failures: &[Self]) -> Option<&FailureReason> {
        let (sentence, _) = Self::counted(failures).into_iter().next()?;
        failures.iter().map(|failure| &failure.reason).find(|reason| reason.sentence() == sentence)
    }

    /// How many grasps failed for each reason, the commonest first.
    pub fn counted(failures: &[Self]) -> Vec<(String, usize)> {
        let mut counts: Vec<(String, usize)> = Vec::new();
        for failure in failures {
            let reason = failure.reason.sentence();
            match counts.iter_mut().find(|(known, _)| *known == reason) {
                Some((_, count)) => *count += 1,
                None => counts.push((reason, 1)),
            }
        }
        counts.sort_by(|(a, m), (b, n)| n.cmp(m).then_with(|| a.cmp(b)));
        counts
    }
}

/// Obstacle between a robot and a grasp. Only the first three are certain: the others state what the search met, not
/// that no path exists.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "reason")]
#[non_exhaustive]
pub enum FailureReason {
    /// The object is stated to be wider there than the hand opens.
    TooWide {
        /// Its width, in metres.
        width_m: f64,
        /// Between the pads of the open hand, in metres.
        opening_m: f64,
    },
    /// The grasp is farther away than the arm can ever reach, wherever its base stands.
    OutOfReach {
        /// Least distance beyond, in metres.
        beyond_m: f64,
    },
    /// The hand alone collides there and at the twin.
    HandCollides {
        /// Which link of the hand.
        link: String,
        /// Which body of the world.
        body: String,
    },
    /// No attempt of inverse kinematics came to the pose.
    NoIk,
    /// The arm came to the pose, but touched the world; seen last:
    ArmCollides {
        /// Which link.
        link: String,
        /// Which body of the world.
        body: String,
    },
    /// The arm came to the pose, but touched itself; seen last:
    SelfCollision {
        /// One link.
        first: String,
        /// The other.
        second: String,
    },
    /// The arm came to the pose, but the tool was out of a bound; seen last:
    OutOfBounds {
        /// Name of the bound.
        bound: String,
    },
    /// Free configurations hold the grasp, but no path to any of them was found.
    NotConnected {
        /// How many.
        goals: u64,
    },
    /// The open hand met something on the straight line to the grasp:
    ApproachBlocked {
        /// One thing.
        first: String,
        /// The other.
        second: String,
    },
    /// The arm cannot move the hand along the straight line to the grasp.
    ApproachOutOfReach,
    /// No path was found to the begin of the straight line to the grasp.
    ApproachNotReached,
    /// The hand closed there, but not on the object: a finger touched nothing.
    ClosesOnNothing,
    /// It was left out, because it had failed before.
    LeftOut,
    /// The pads would slip under less than the loads that were to be held.
    Slips,
    /// The hand holds the object there, but not in each attitude, and steadier grasps were tried first.
    Unsteady,
    /// The hand turns or shifts the object too far while it closes for it to be put down where it is to stand.
    TurnsInHand,
    /// The fingers met something on their way to the object:
    ClosingCollides {
        /// One thing.
        first: String,
        /// The other.
        second: String,
    },
    /// The object, or what carries it, met something before it was off what it rested on:
    LiftOffBlocked {
        /// One thing.
        first: String,
        /// The other.
        second: String,
    },
    /// The arm cannot go on to where the object is off what it rested on.
    LiftOffOutOfReach,
    /// The object was lifted off, but no way was found to where it is to be carried.
    NotCarried,
    /// Held like that the object cannot be where it is to be carried:
    EndBlocked {
        /// One thing.
        first: String,
        /// The other.
        second: String,
    },
    /// The object can be nowhere where it is to be put down, as it is held or at all.
    NoPlace,
    /// The open hand, where it would let the object go, met something; seen first:
    PlaceBlocked {
        /// One thing.
        first: String,
        /// The other.
        second: String,
    },
    /// The arm came to no place where it could let the object go.
    PlaceOutOfReach,
    /// The object, or what carries it, met something on the way down to where it is to be put:
    SetDownBlocked {
        /// One thing.
        first: String,
        /// The other.
        second: String,
    },
    /// The arm cannot move the object down to where it is to be put.
    SetDownOutOfReach,
    /// The fingers met something when they let the object go:
    OpeningCollides {
        /// One thing.
        first: String,
        /// The other.
        second: String,
    },
    /// The open hand met something on its way off the object:
    RetreatBlocked {
        /// One thing.
        first: String,
        /// The other.
        second: String,
    },
    /// The arm cannot move the hand off the object.
    RetreatOutOfReach,
    /// The object can be put down, but no way was found from where it is lifted off.
    NotBroughtThere,
    /// The object was put down, but no way back was found for the empty hand.
    NotReturned,
    /// The arm found no way to where it was to move next.
    NotMoved,
    /// A later stage of the task could not be done after this:
    Later {
        /// Index of the stage.
        stage: usize,
        /// Why.
        because: Box<FailureReason>,
    },
    /// The search ended before it came to this grasp.
    NotTried,
}

/// Two widths that differ by less are equal, in metres: files round.
const WIDTH_TOLERANCE_M: f64 = 1e-9;

impl FailureReason {
    /// [`Self::TooWide`] for a grasp whose stated width is beyond the opening of the robot's hand.
    pub fn of_width(robot: &Robot, grasp: &Grasp) -> Option<Self> {
        let opening_m = robot.hand()?.description.opening_m;
        let width_m = grasp.width_m.filter(|width_m| *width_m > opening_m + WIDTH_TOLERANCE_M)?;
        (opening_m > 0.0).then_some(Self::TooWide { width_m, opening_m })
    }

    /// The reason in words, without the grasp.
    pub fn sentence(&self) -> String {
        match self {
            Self::TooWide { width_m, opening_m } => {
                let [width, opening] = distinct([width_m * 1e3, opening_m * 1e3], 1);
                format!("the object is {width} mm wide there, and the hand opens {opening} mm")
            }
            // One sentence for all of them, which are counted by it.
            Self::OutOfReach { .. } => "beyond reach from anywhere the base can stand".to_owned(),
            Self::HandCollides { link, body } => format!("the hand alone collides: {link} against {body}"),
            Self::NoIk => "no attempt of inverse kinematics came there".to_owned(),
            Self::ArmCollides { link, body } => format!("the arm came there, but {link} touched {body}"),
            Self::SelfCollision { first, second } => {
                format!("the arm came there, but touched itself: {first} against {second}")
            }
            Self::OutOfBounds { bound } => format!("the arm came there, but exceeded the bound '{bound}'"),
            Self::NotConnected { .. } => "held by free configurations, but not connected".to_owned(),
            Self::ApproachBlocked { first, second } => {
                format!("the hand cannot come there straight: {first} against {second}")
            }
            Self::ApproachOutOfReach => "the arm cannot move the hand there straight".to_owned(),
            Self::ApproachNotReached => {
                "reached, but no way was found to where the straight approach begins".to_owned()
            }
            Self::ClosesOnNothing => "the hand closes on nothing there".to_owned(),
            Self::LeftOut => "left out: it failed in physics".to_owned(),
            Self::Slips => {
                "the hand holds the object too weakly there to carry it (`hold` demands less)".to_owned()
            }
            Self::Unsteady => {
                "the hand does not hold the object there in each attitude, and steadier grasps were tried first"
                    .to_owned()
            }
            Self::TurnsInHand => {
                "the hand turns or shifts the object there while it closes, so that it cannot be put down"
                    .to_owned()
            }
            Self::ClosingCollides { first, second } => {
                format!("reached, but the fingers cannot close: {first} against {second}")
            }
            Self::LiftOffBlocked { first, second } => {
                format!("reached, but the object cannot be lifted off: {first} against {second}")
            }
            Self::LiftOffOutOfReach => "reached, but the arm cannot lift the object off".to_owned(),
            Self::NotCarried => "lifted off, but no way out was found".to_owned(),
            Self::EndBlocked { first, second } => {
                format!("held like that the object cannot be where it is to go: {first} against {second}")
            }
            Self::NoPlace => "held like that the object has no place where it is to be put down".to_owned(),
            Self::PlaceBlocked { first, second } => {
                format!(
                    "the open hand cannot be where the object is to be put down: {first} against {second}"
                )
            }
            Self::PlaceOutOfReach => "lifted off, but the arm comes to no place to put it down".to_owned(),
            Self::SetDownBlocked { first, second } => {
                format!("lifted off, but the object cannot be set down: {first} against {second}")
            }
            Self::SetDownOutOfReach => "lifted off, but the arm cannot set the object down".to_owned(),
            Self::OpeningCollides { first, second } => {
                format!("set down, but the fingers cannot open: {first} against {second}")
            }
            Self::RetreatBlocked { first, second } => {
                format!("set down, but the hand cannot retreat: {first} against {second}")
            }
            Self::RetreatOutOfReach => "set down, but the arm cannot retreat".to_owned(),
            Self::NotBroughtThere => {
                "lifted off, but no way was found to where it is to be put down".to_owned()
            }
            Self::NotReturned => "set down, but no way back was found".to_owned(),
            Self::NotMoved => "no way was found to where the arm was to move".to_owned(),
            Self::Later { stage, because } => {
                format!("stage {} failed after it: {}", stage + 1, because.sentence())
            }
            Self::NotTried => "not tried".to_owned(),
        }
    }
}
