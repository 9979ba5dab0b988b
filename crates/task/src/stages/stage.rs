use std::borrow::Cow;
use std::fmt;

use cranny_file::{at_least, counted};
use cranny_spatial::Pose;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Deserialize, Serialize};
use strum::{EnumString, IntoStaticStr};

use crate::stages::region::RegionRow;
use crate::{Goal, Moved, Problem, Region, TaskError};

/// A stage of a task, in the user's terms. A task is a list of them, each from where the one before ends: to reach for an
/// object is `[Pick]`, to carry it off `[Pick, Move]`, to put it down `[Pick, Place, Move]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "StageRow", into = "StageRow")]
pub enum Stage {
    /// An object is grasped, and lifted off what carries it where a stage follows.
    Pick(Pick),
    /// The arm moves, with what is in the hand.
    Move(Move),
    /// What is in the hand is put down, and the hand leaves it.
    Place(PlaceAt),
}

/// Object that is grasped.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pick {
    /// Name of a body; `None`: the target of the problem.
    pub object: Option<String>,
    /// Clearance that is demanded about the object, in metres; `None`: that of the problem's margins.
    pub object_margin_m: Option<f64>,
    /// Least length of the straight approach, along the z axis of the gripper frame, in metres; 0: the path may come to the
    /// grasp from anywhere.
    pub approach_m: f64,
}

/// Goal of a motion of the arm.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Move {
    /// The configuration that the task starts from.
    #[default]
    Home,
    /// Any of these configurations (m, rad; one value per joint each).
    Configurations(Vec<Vec<f64>>),
    /// Any configuration at which all bodies but floors are so far, in metres, from what is in the hand, or from the hand
    /// where it is empty.
    Clear {
        /// The distance.
        clear_m: f64,
    },
    /// Any configuration at which the hand, or the object in it, has one of these poses, within 1 mm and 1°.
    Region(Region),
}

/// Place where the object in the hand is put down.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaceAt {
    /// Name of a place of the problem.
    pub place: String,
    /// Distance between the hand and the object at the end of the retreat, in metres.
    pub clear_m: f64,
    /// Least length of the straight retreat, against the z axis of the gripper frame, in metres; 0: the hand may leave the
    /// object in another direction.
    pub retreat_m: f64,
}

/// Motion of the robot after it has put an object down.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, EnumString, IntoStaticStr, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum AfterPlacing {
    /// It goes to the configuration that it started from.
    #[default]
    Home,
    /// It stays.
    Stay,
}

impl AfterPlacing {
    /// Name in files and flags.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// Distance of an object in the hand from everything else that counts as clear, unless another is given, in metres.
pub const CLEAR_M: f64 = 0.05;

/// Greatest distance that can be demanded, in metres.
pub const FARTHEST_CLEAR_M: f64 = 1.0;

/// Greatest length of a straight approach or retreat, in metres.
pub(crate) const MOST_STRAIGHT_M: f64 = 0.5;

impl Stage {
    /// The target of the problem is grasped.
    pub fn pick() -> Self {
        Self::Pick(Pick::default())
    }

    /// The arm moves home.
    pub fn home() -> Self {
        Self::Move(Move::Home)
    }

    /// The object in the hand is put down at a named place of the problem, and the hand leaves it by [`CLEAR_M`].
    pub fn place(place: &str) -> Self {
        Self::Place(PlaceAt::named(place))
    }

    /// The target is picked and put down at a place, after which the robot goes home or stays.
    pub fn put_down(place: PlaceAt, then: AfterPlacing) -> Vec<Self> {
        let home = (then == AfterPlacing::Home).then(Self::home);
        [Self::pick(), Self::Place(place)].into_iter().chain(home).collect()
    }

    /// The goal of a problem as the only stage of its task.
    pub fn of_goal(problem: &Problem) -> Vec<Self> {
        match problem.goal() {
            Goal::Grasps(_) => vec![Self::pick()],
            Goal::Configurations(ends) => vec![Self::Move(Move::Configurations(ends.clone()))],
        }
    }

    /// True if another stage picks the same object, goes to the same end or puts down at the same place, whatever distances
    /// the two demand.
    pub fn is_like(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Pick(a), Self::Pick(b)) => a.object == b.object,
            (Self::Place(a), Self::Place(b)) => a.place == b.place,
            (Self::Move(Move::Clear { .. }), Self::Move(Move::Clear { .. })) => true,
            (Self::Move(Move::Region(a)), Self::Move(Move::Region(b))) => a.is_like(b),
            (a, b) => a == b,
        }
    }

    /// The same in a frame in which the one that it is in has this pose.
    #[must_use]
    pub fn seen_from(&self, new_from_old: &Pose) -> Self {
        match self {
            Self::Move(Move::Region(region)) => Self::Move(Move::Region(region.seen_from(new_from_old))),
            other => other.clone(),
        }
    }

    /// Checks stages against a problem: they follow each other, and each can be asked.
    ///
    /// # Errors
    /// [`TaskError::Stage`] names the first that cannot follow, or that names what there is not; those of
    /// [`Problem::with_goal`] for configurations that do not fit the robot.
    pub fn check_all(stages: &[Self], problem: &Problem) -> Result<(), TaskError> {
        let mut held = None;
        for (index, stage) in stages.iter().enumerate() {
            let refuse = |problem: String| Err(TaskError::Stage { stage: index, problem });
            match stage {
                Self::Pick(_) if held.is_some() => {
                    return refuse("the hand already holds an object".to_owned());
                }
                Self::Pick(pick) => {
                    held = Some(pick.body(problem)?);
                    if pick.object_margin_m.is_some_and(|margin_m| !(margin_m.is_finite() && margin_m >= 0.0))
                    {
                        return refuse("the clearance demanded about the object is none".to_owned());
                    }
                    straight_fault("an approach", pick.approach_m).map_or(Ok(()), refuse)?;
                }
                Self::Place(_) | Self::Move(Move::Region(Region { moved: Moved::Object, .. }))
                    if held.is_none() =>
                {
                    return refuse("nothing is in the hand; a pick has to come before it".to_owned());
                }
                Self::Move(goal) => goal.check(index, problem)?,
                Self::Place(place) => {
                    let goal = problem.place(&place.place)?;
                    let rolls = held.take().zip(problem.cell()).and_then(|(body, cell)| {
                        goal.rolls_away(cell.world(), body, problem.weights.of_body(body).rolling_m)
                    });
                    if let Some(reason) = rolls {
                        return refuse(reason);
                    }
                    straight_fault("a retreat", place.retreat_m).map_or(Ok(()), refuse)?;
                }
            }
        }
        Ok(())
    }
}

impl fmt::Display for Stage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mm = |clear_m: &f64| at_least(*clear_m, 1e3, 2);
        match self {
            Self::Pick(Pick { object, approach_m, .. }) => {
                write!(f, "pick '{}'", object.as_deref().unwrap_or(TARGET))?;
                if *approach_m > 0.0 { write!(f, " after {} mm straight", mm(approach_m)) } else { Ok(()) }
            }
            Self::Move(Move::Home) => f.write_str("move home"),
            Self::Move(Move::Configurations(ends)) => {
                write!(f, "move to one of {}", counted(ends.len(), "configuration"))
            }
            Self::Move(Move::Region(region)) => write!(f, "move {region}"),
            Self::Move(Move::Clear { clear_m }) => write!(f, "move until {} mm clear", mm(clear_m)),
            Self::Place(PlaceAt { place, clear_m, retreat_m }) => {
                write!(f, "put down in '{place}', the hand {} mm off it", mm(clear_m))?;
                if *retreat_m > 0.0 { write!(f, " after {} mm straight", mm(retreat_m)) } else { Ok(()) }
            }
        }
    }
}

impl PlaceAt {
    /// A place of that name, with a retreat in any direction until the hand is clear of the object by [`CLEAR_M`].
    pub fn named(place: &str) -> Self {
        Self { place: place.to_owned(), clear_m: CLEAR_M, retreat_m: 0.0 }
    }
}

impl Pick {
    /// The body to be grasped, by index.
    ///
    /// # Errors
    /// [`TaskError::Collision`] for the name of nothing; [`TaskError::NothingToCarry`] without a target.
    pub fn body(&self, problem: &Problem) -> Result<usize, TaskError> {
        let none = || TaskError::NothingToCarry { needs: "a target" };
        match (&self.object, problem.cell()) {
            (Some(name), Some(cell)) => Ok(cell.world().body_index(name)?),
            _ => problem.target().ok_or_else(none),
        }
    }
}

impl Move {
    fn check(&self, stage: usize, problem: &Problem) -> Result<(), TaskError> {
        let refuse = |problem: String| Err(TaskError::Stage { stage, problem });
        match self {
            Self::Home => Ok(()),
            Self::Region(region) => region.fault().map_or(Ok(()), |fault| refuse(fault.to_owned())),
            Self::Clear { clear_m } if (0.0..=FARTHEST_CLEAR_M).contains(clear_m) => Ok(()),
            Self::Clear { clear_m } => {
                refuse(format!("{clear_m} m is no clearance; give 0 to {FARTHEST_CLEAR_M} m"))
            }
            Self::Configurations(ends) => {
                problem.with_goal(Goal::Configurations(ends.clone()))?;
                let robot = problem.robot();
                let mut beyond = ends.iter().map(|end| robot.first_limit_violation(end));
                let Some(first) = beyond.next() else {
                    return refuse("there is no configuration".to_owned());
                };
                match first.filter(|_| beyond.all(|violation| violation.is_some())) {
                    None => Ok(()),
                    Some(violation) => refuse(format!(
                        "{} cannot be at {}: its limits are {} to {}",
                        robot.joint_names()[violation.joint],
                        violation.value,
                        violation.lower,
                        violation.upper
                    )),
                }
            }
        }
    }

    /// The configurations that the motion may end at (m, rad; one value per joint); `None` where they are not
    /// counted.
    pub fn ends(&self, problem: &Problem) -> Option<Vec<Vec<f64>>> {
        match self {
            Self::Home => Some(vec![problem.start().to_vec()]),
            Self::Configurations(ends) => Some(ends.clone()),
            Self::Clear { .. } | Self::Region(_) => None,
        }
    }
}

/// Name of the target of a problem in files of stages.
const TARGET: &str = "target";

/// A stage as files have it: one of `pick`, `move` and `place`, with what belongs to it.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct StageRow {
    /// Object that is grasped: a body of the scenario, or `target`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pick: Option<String>,
    /// Goal of a motion: `home`, `clear`, configurations (m, rad), or a region of poses.
    #[serde(default, rename = "move", skip_serializing_if = "Option::is_none")]
    move_to: Option<MoveRow>,
    /// Place where the object in the hand is put down.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    place: Option<String>,
    /// Distance, in metres: with `move: clear`, of what is in the hand from everything; with `place`, of the hand from the
    /// object at the end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    clear_m: Option<f64>,
    /// Clearance that is demanded about the object of a `pick`, in metres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    object_margin_m: Option<f64>,
    /// Least length of the straight approach of a `pick`, in metres, at most 0.5.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    approach_m: Option<f64>,
    /// Least length of the straight retreat of a `place`, in metres, at most 0.5.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    retreat_m: Option<f64>,
}

/// The fault of a length of a straight motion (m), in words.
fn straight_fault(motion: &str, length_m: f64) -> Option<String> {
    let is_length = (0.0..=MOST_STRAIGHT_M).contains(&length_m);
    (!is_length).then(|| format!("{length_m} m is no length of {motion}; give 0 to {MOST_STRAIGHT_M} m"))
}

#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
enum MoveRow {
    Word(String),
    Configurations(Vec<Vec<f64>>),
    Region(RegionRow),
}

impl JsonSchema for Stage {
    fn schema_name() -> Cow<'static, str> {
        StageRow::schema_name()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        StageRow::json_schema(generator)
    }
}

impl TryFrom<StageRow> for Stage {
    type Error = String;

    fn try_from(row: StageRow) -> Result<Self, String> {
        let StageRow { pick, move_to, place, clear_m, object_margin_m, approach_m, retreat_m } = row;
        let only = |key: &str, of: &str, given: Option<f64>| {
            given.map_or(Ok(()), |_| Err(format!("'{key}' belongs to a stage with {of}")))
        };
        if pick.is_none() {
            only("object_margin_m", "'pick'", object_margin_m)?;
            only("approach_m", "'pick'", approach_m)?;
        }
        if place.is_none() {
            only("retreat_m", "'place'", retreat_m)?;
        }
        let stage = match (pick, move_to, place) {
            (Some(object), None, None) => {
                only("clear_m", "'place' or 'move: clear'", clear_m)?;
                let approach_m = approach_m.unwrap_or_default();
                let object = Some(object).filter(|object| object != TARGET);
                return Ok(Self::Pick(Pick { object, object_margin_m, approach_m }));
            }
            (None, Some(MoveRow::Word(word)), None) => match word.as_str() {
                "home" => Self::home(),
                "clear" => {
                    return Ok(Self::Move(Move::Clear { clear_m: clear_m.unwrap_or(CLEAR_M) }));
                }
                _ => {
                    return Err(format!(
                        "'move' is 'home', 'clear', configurations or a region, not '{word}'"
                    ));
                }
            },
            (None, Some(MoveRow::Configurations(ends)), None) => Self::Move(Move::Configurations(ends)),
            (None, Some(MoveRow::Region(row)), None) => Self::Move(Move::Region(row.try_into()?)),
            (None, None, Some(place)) => {
                let (clear_m, retreat_m) = (clear_m.unwrap_or(CLEAR_M), retreat_m.unwrap_or_default());
                return Ok(Self::Place(PlaceAt { place, clear_m, retreat_m }));
            }
            _ => return Err("a stage has one of 'pick', 'move' and 'place'".to_owned()),
        };
        only("clear_m", "'place' or 'move: clear'", clear_m)?;
        Ok(stage)
    }
}

impl From<Stage> for StageRow {
    fn from(stage: Stage) -> Self {
        let row = Self::default();
        let unless_none = |length_m: f64| Some(length_m).filter(|length_m| *length_m > 0.0);
        match stage {
            Stage::Pick(Pick { object, object_margin_m, approach_m }) => Self {
                pick: Some(object.unwrap_or_else(|| TARGET.to_owned())),
                object_margin_m,
                approach_m: unless_none(approach_m),
                ..row
            },
            Stage::Move(Move::Home) => Self { move_to: Some(MoveRow::Word("home".to_owned())), ..row },
            Stage::Move(Move::Clear { clear_m }) => {
                Self { move_to: Some(MoveRow::Word("clear".to_owned())), clear_m: Some(clear_m), ..row }
            }
            Stage::Move(Move::Region(region)) => {
                Self { move_to: Some(MoveRow::Region(region.into())), ..row }
            }
            Stage::Move(Move::Configurations(ends)) => {
                Self { move_to: Some(MoveRow::Configurations(ends)), ..row }
            }
            Stage::Place(PlaceAt { place, clear_m, retreat_m }) => {
                Self { place: Some(place), clear_m: Some(clear_m), retreat_m: unless_none(retreat_m), ..row }
            }
        }
    }
}
