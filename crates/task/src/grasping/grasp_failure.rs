use std::collections::BTreeMap;

use cranny_file::distinct;
use cranny_grasp::Grasp;
use cranny_robot::Robot;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Reason why a search without a solution did not reach a grasp.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Value")]
pub struct GraspFailure {
    /// Index of the grasp.
    pub grasp: usize,
    /// The reason.
    #[serde(flatten)]
    pub reason: FailureReason,
    /// Number of IK attempts at the grasp and its twin.
    pub attempts: u64,
}

/// Row of a [`GraspFailure`] before its keys are checked: serde refuses no unknown key beside a flattened field.
#[derive(Deserialize)]
struct FailureRow {
    grasp: usize,
    #[serde(flatten)]
    reason: FailureReason,
    attempts: u64,
}

impl TryFrom<Value> for GraspFailure {
    type Error = String;

    /// Reads a row and refuses unknown keys.
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
    /// Returns the reason for which most grasps failed.
    pub fn commonest(failures: &[Self]) -> Option<&FailureReason> {
        let (sentence, _) = Self::counted(failures).into_iter().next()?;
        failures.iter().map(|failure| &failure.reason).find(|reason| reason.sentence() == sentence)
    }

    /// Returns the number of grasps that failed for each reason, most frequent first.
    pub fn counted(failures: &[Self]) -> Vec<(String, usize)> {
        let mut known: BTreeMap<String, usize> = BTreeMap::new();
        for failure in failures {
            *known.entry(failure.reason.sentence()).or_default() += 1;
        }
        let mut counts: Vec<(String, usize)> = known.into_iter().collect();
        counts.sort_by(|(a, m), (b, n)| n.cmp(m).then_with(|| a.cmp(b)));
        counts
    }
}

/// Reason for the failure of a grasp. Only the first three are certain: the others name obstacles that the search met, which
/// does not prove that no path exists.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "reason")]
#[non_exhaustive]
pub enum FailureReason {
    /// The object is stated to be wider at the grasp than the hand opens.
    TooWide {
        /// Width of the object, in metres.
        width_m: f64,
        /// Distance between the pads of the open hand, in metres.
        opening_m: f64,
    },
    /// The grasp is beyond the reach of the arm, for every position of its base.
    OutOfReach {
        /// Lower bound of the distance beyond reach, in metres.
        beyond_m: f64,
    },
    /// The hand, or the link that carries it, collides at the grasp and at its twin, whatever the arm does.
    HandCollides {
        /// Name of the link.
        link: String,
        /// Name of the body of the world.
        body: String,
        /// True if it is proven that the hand touches the world at every pose within the tolerance of the grasp or of its twin.
        #[serde(default)]
        is_proven: bool,
    },
    /// No IK attempt converged to the pose.
    NoIk,
    /// The arm reached the pose, but touched the world; last contact found:
    ArmCollides {
        /// Name of the link.
        link: String,
        /// Name of the body of the world.
        body: String,
    },
    /// The arm reached the pose, but touched itself; last contact found:
    SelfCollision {
        /// First link.
        first: String,
        /// Second link.
        second: String,
    },
    /// The arm reached the pose, but the tool was outside a bound; last bound found:
    OutOfBounds {
        /// Name of the bound.
        bound: String,
    },
    /// Free configurations exist at the grasp, but no path to any of them was found.
    NotConnected {
        /// Number of these configurations.
        goals: u64,
    },
    /// The open hand collided on the straight approach to the grasp:
    ApproachBlocked {
        /// First of the colliding pair.
        first: String,
        /// Second of the colliding pair.
        second: String,
    },
    /// The arm cannot move the hand along the straight approach to the grasp.
    ApproachOutOfReach,
    /// No path to the start of the straight approach was found.
    ApproachNotReached,
    /// The hand closed at the grasp, but a finger did not touch the object.
    ClosesOnNothing,
    /// The grasp was excluded by the request, for example because it had failed before.
    LeftOut,
    /// The pads would slip under less than the required loads.
    Slips,
    /// The hand holds the object at the grasp, but not in every orientation, and steadier grasps were tried first.
    Unsteady,
    /// Closing the hand turns or shifts the object too far for it to be put down at the goal.
    TurnsInHand,
    /// A link of a finger touched the object before the pad of that finger:
    TouchesBesidePads {
        /// Name of the link.
        link: String,
    },
    /// The fingers collided while they closed on the object:
    ClosingCollides {
        /// First of the colliding pair.
        first: String,
        /// Second of the colliding pair.
        second: String,
    },
    /// The object or the hand and arm that carry it collided during the lift-off:
    LiftOffBlocked {
        /// First of the colliding pair.
        first: String,
        /// Second of the colliding pair.
        second: String,
    },
    /// The arm cannot reach the end of the lift-off.
    LiftOffOutOfReach,
    /// The object was lifted off, but no transfer path to the goal was found.
    NotCarried,
    /// The object in this grasp collides at the goal of the transfer:
    EndBlocked {
        /// First of the colliding pair.
        first: String,
        /// Second of the colliding pair.
        second: String,
    },
    /// With the object in this grasp, the tool is outside of a bound at every goal of the transfer; the least excess:
    EndOutOfBounds {
        /// Name of the bound.
        bound: String,
        /// Excess over the bound, in radians or metres.
        by: f64,
        /// True for a bound on an angle.
        is_angle: bool,
    },
    /// No placement of the object at the goal is feasible, either in this grasp or in any grasp.
    NoPlace,
    /// The open hand collides at the placement; first contact found:
    PlaceBlocked {
        /// First of the colliding pair.
        first: String,
        /// Second of the colliding pair.
        second: String,
    },
    /// The arm reached no placement of the object.
    PlaceOutOfReach,
    /// The object or the hand and arm that carry it collided during the set-down:
    SetDownBlocked {
        /// First of the colliding pair.
        first: String,
        /// Second of the colliding pair.
        second: String,
    },
    /// The arm cannot follow the set-down to the placement.
    SetDownOutOfReach,
    /// The fingers collided while they released the object:
    OpeningCollides {
        /// First of the colliding pair.
        first: String,
        /// Second of the colliding pair.
        second: String,
    },
    /// The open hand collided during the retreat from the object:
    RetreatBlocked {
        /// First of the colliding pair.
        first: String,
        /// Second of the colliding pair.
        second: String,
    },
    /// The arm cannot follow the retreat from the object.
    RetreatOutOfReach,
    /// Placements are feasible, but no transfer path from the lift-off was found.
    NotBroughtThere,
    /// The object was put down, but no return path of the empty hand was found.
    NotReturned,
    /// No path of the arm to the next goal was found.
    NotMoved,
    /// A later stage of the task failed after this one:
    Later {
        /// Index of the stage.
        stage: usize,
        /// Reason for the failure of that stage.
        because: Box<FailureReason>,
    },
    /// The search ended before it tried this grasp.
    NotTried,
}

/// Tolerance on widths, in metres, because values in files are rounded.
const WIDTH_TOLERANCE_M: f64 = 1e-9;

/// Inaccuracy of the gap that the collision geometry leaves between closed pads, in metres.
const CLOSED_GAP_OFF_M: f64 = 1e-3;

/// Describes the contact of a hand at a grasp, whatever the arm does.
pub fn hand_collides(link: &str, body: &str, is_proven: bool) -> String {
    if is_proven {
        return format!(
            "proven impossible: whatever the arm does, the hand or the link that carries it collides (at the exact pose {link} with {body})"
        );
    }
    format!("whatever the arm does, {link} collides with {body} at the exact pose")
}

impl FailureReason {
    /// Returns [`Self::TooWide`] for a grasp whose stated width exceeds the opening of the robot's hand, and
    /// [`Self::ClosesOnNothing`] if it is less than the gap between its closed pads.
    pub fn of_width(robot: &Robot, grasp: &Grasp) -> Option<Self> {
        let hand = robot.hand()?;
        let opening_m = hand.description.opening_m;
        let width_m = grasp.width_m?;
        if opening_m > 0.0 && width_m < hand.closed_gap_m() - CLOSED_GAP_OFF_M {
            return Some(Self::ClosesOnNothing);
        }
        if width_m <= opening_m + WIDTH_TOLERANCE_M {
            return None;
        }
        (opening_m > 0.0).then_some(Self::TooWide { width_m, opening_m })
    }

    /// Returns true if the budget ended before a path through all stages was found or failed.
    pub fn is_of_budget(&self) -> bool {
        match self {
            Self::NotTried => true,
            Self::Later { because, .. } => because.is_of_budget(),
            _ => false,
        }
    }

    /// Describes the reason in words, without the grasp.
    pub fn sentence(&self) -> String {
        match self {
            Self::TooWide { width_m, opening_m } => {
                let [width, opening] = distinct([width_m * 1e3, opening_m * 1e3], 1);
                format!("the object is {width} mm wide there, and the hand opens {opening} mm")
            }
            // All distances share one sentence, because failures are counted by it.
            Self::OutOfReach { .. } => "out of reach from every position of the base".to_owned(),
            Self::HandCollides { link, body, is_proven } => hand_collides(link, body, *is_proven),
            Self::NoIk => "inverse kinematics found no solution".to_owned(),
            Self::ArmCollides { link, body } => {
                format!("inverse kinematics found solutions, but {link} touched {body}")
            }
            Self::SelfCollision { first, second } => {
                format!("inverse kinematics found solutions with self-collision: {first} against {second}")
            }
            Self::OutOfBounds { bound } => {
                format!("inverse kinematics found solutions, but they exceeded the bound '{bound}'")
            }
            Self::NotConnected { .. } => {
                "inverse kinematics found free solutions, but no path to them was found".to_owned()
            }
            Self::ApproachBlocked { first, second } => {
                format!("the straight approach of the hand collides: {first} against {second}")
            }
            Self::ApproachOutOfReach => "the arm cannot follow the straight approach".to_owned(),
            Self::ApproachNotReached => {
                "reached, but no path to the start of the straight approach was found".to_owned()
            }
            Self::ClosesOnNothing => "the hand closes on nothing there".to_owned(),
            Self::LeftOut => "left out: it failed in physics".to_owned(),
            Self::Slips => {
                "the hand holds the object too weakly there to carry it (a lower `hold` helps)".to_owned()
            }
            Self::Unsteady => {
                "the hand does not hold the object there in each attitude, and steadier grasps were tried first"
                    .to_owned()
            }
            Self::TurnsInHand => {
                "the hand turns or shifts the object there while it closes, so that it cannot be put down"
                    .to_owned()
            }
            Self::TouchesBesidePads { link } => {
                format!("reached, but {link} touches the object there before a pad does")
            }
            Self::ClosingCollides { first, second } => {
                format!("reached, but the fingers cannot close: {first} against {second}")
            }
            Self::LiftOffBlocked { first, second } => {
                format!("reached, but the object cannot be lifted off: {first} against {second}")
            }
            Self::LiftOffOutOfReach => "reached, but the arm cannot lift the object off".to_owned(),
            Self::NotCarried => "lifted off, but no path out was found".to_owned(),
            Self::EndBlocked { first, second } => {
                format!("with this grasp the object collides at its goal: {first} against {second}")
            }
            // All amounts share one sentence, as failures are counted by it.
            Self::EndOutOfBounds { bound, .. } => {
                format!("with this grasp the object exceeds the bound '{bound}' at the goal of the transfer")
            }
            Self::NoPlace => "with this grasp no placement of the object is feasible".to_owned(),
            Self::PlaceBlocked { first, second } => {
                format!(
                    "the open hand cannot be where the object is to be put down: {first} against {second}"
                )
            }
            Self::PlaceOutOfReach => "lifted off, but the arm reaches no placement".to_owned(),
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
                "lifted off, but no path to the placement was found".to_owned()
            }
            Self::NotReturned => "set down, but no path back was found".to_owned(),
            Self::NotMoved => "no path to the goal of the move was found".to_owned(),
            Self::Later { stage, because } => {
                format!("the later stage {} failed: {}", stage + 1, because.sentence())
            }
            Self::NotTried => "not tried".to_owned(),
        }
    }
}
