use std::borrow::Cow;
use std::fmt;

use cranny_file::{at_least, counted};
use cranny_spatial::Pose;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Deserialize, Serialize};
use strum::{EnumString, IntoStaticStr};

use crate::stages::region_row::RegionRow;
use crate::{Goal, Moved, Problem, Region, TaskError};

/// A stage of a task, in the user's terms. A task is a list of stages, each starting at the end of the previous one: `[Pick]`
/// grasps an object, `[Pick, Move]` carries it away, `[Pick, Place, Move]` puts it down.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "StageRow", into = "StageRow")]
pub enum Stage {
    /// Grasps an object, and lifts it off its support if a stage follows.
    Pick(Pick),
    /// Moves the arm, with the object in the hand if there is one.
    Move(Move),
    /// Puts the object in the hand down, and retreats from it.
    Place(PlaceAt),
}

/// Object of a pick, and the approach to it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pick {
    /// Name of a body; `None`: the target of the problem.
    pub object: Option<String>,
    /// Required clearance of the object, in metres; `None`: that of the problem's margins.
    pub object_margin_m: Option<f64>,
    /// Least length of the straight approach, along the z axis of the gripper frame, in metres; 0: the path may come to the
    /// grasp from any direction.
    pub approach_m: f64,
}

/// Goal of a motion of the arm.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Move {
    /// The start configuration of the task.
    #[default]
    Home,
    /// Any of these configurations (m, rad; one value per joint each).
    Configurations(Vec<Vec<f64>>),
    /// Any configuration with at least this distance of the object in the hand, or the empty hand, from all bodies but floors.
    Clear {
        /// Required distance, in metres.
        clear_m: f64,
    },
    /// Any configuration at which the hand, or the object in it, has a pose in any of these regions, within 1 mm and 1°.
    Regions(Vec<Region>),
    /// The same with regions of the problem, by name.
    NamedRegions(Vec<String>),
}

/// Placement goal of the object in the hand, and the retreat from it.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaceAt {
    /// Name of a placement goal of the problem.
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
    /// Returns to the start configuration.
    #[default]
    Home,
    /// Stays where it is.
    Stay,
}

impl AfterPlacing {
    /// Name in files and flags.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// Default distance of an object in the hand from everything else that counts as clear, in metres.
pub const CLEAR_M: f64 = 0.05;

/// Greatest distance that can be required, in metres.
pub const FARTHEST_CLEAR_M: f64 = 1.0;

/// Greatest length of a straight approach or retreat, in metres.
pub(crate) const MOST_STRAIGHT_M: f64 = 0.5;

impl Stage {
    /// Creates a stage that grasps the target of the problem.
    pub fn pick() -> Self {
        Self::Pick(Pick::default())
    }

    /// Creates a stage that moves the arm home.
    pub fn home() -> Self {
        Self::Move(Move::Home)
    }

    /// Creates a stage that puts the object down at a named placement goal of the problem and retreats by [`CLEAR_M`].
    pub fn place(place: &str) -> Self {
        Self::Place(PlaceAt::named(place))
    }

    /// Creates the stages that pick the target and put it down, after which the robot goes home or stays.
    pub fn put_down(place: PlaceAt, then: AfterPlacing) -> Vec<Self> {
        let home = (then == AfterPlacing::Home).then(Self::home);
        [Self::pick(), Self::Place(place)].into_iter().chain(home).collect()
    }

    /// Returns the goal of a problem as the only stage of its task.
    pub fn of_goal(problem: &Problem) -> Vec<Self> {
        match problem.goal() {
            Goal::Grasps(_) => vec![Self::pick()],
            Goal::Configurations(ends) => vec![Self::Move(Move::Configurations(ends.clone()))],
            Goal::Regions(regions) => vec![Self::Move(Move::Regions(regions.clone()))],
        }
    }

    /// Returns true if another stage is of the same kind with the same object or goal, regardless of the required distances.
    pub fn is_like(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Pick(a), Self::Pick(b)) => a.object == b.object,
            (Self::Place(a), Self::Place(b)) => a.place == b.place,
            (Self::Move(Move::Clear { .. }), Self::Move(Move::Clear { .. })) => true,
            (Self::Move(Move::Regions(a)), Self::Move(Move::Regions(b))) => {
                a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.is_like(b))
            }
            (a, b) => a == b,
        }
    }

    /// Returns this stage in a new frame; `new_from_old` is the pose of the present frame in it.
    #[must_use]
    pub fn in_frame(&self, new_from_old: &Pose) -> Self {
        match self {
            Self::Move(Move::Regions(regions)) => {
                let regions = regions.iter().map(|region| region.in_frame(new_from_old));
                Self::Move(Move::Regions(regions.collect()))
            }
            other => other.clone(),
        }
    }

    /// Checks stages against a problem: their order is valid, and each is possible.
    ///
    /// # Errors
    /// [`TaskError::Stage`] names the first stage that cannot follow or that names something unknown; those of
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
                        return refuse(
                            "object_margin_m must be a finite number of metres, at least 0".to_owned(),
                        );
                    }
                    straight_fault("an approach", pick.approach_m).map_or(Ok(()), refuse)?;
                }
                Self::Place(_) if held.is_none() => return refuse(EMPTY_HAND.to_owned()),
                Self::Move(goal) => {
                    goal.check(index, problem)?;
                    let regions = goal.regions(problem)?.unwrap_or_default();
                    if held.is_none() && regions.iter().any(|region| region.moved == Moved::Object) {
                        return refuse(EMPTY_HAND.to_owned());
                    }
                }
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
                if *approach_m > 0.0 {
                    write!(f, " after a straight approach of {} mm", mm(approach_m))
                } else {
                    Ok(())
                }
            }
            Self::Move(Move::Home) => f.write_str("move home"),
            Self::Move(Move::Configurations(ends)) => {
                write!(f, "move to one of {}", counted(ends.len(), "configuration"))
            }
            Self::Move(Move::Regions(regions)) => {
                let regions: Vec<String> = regions.iter().map(Region::to_string).collect();
                write!(f, "move {}", regions.join(", or "))
            }
            Self::Move(Move::NamedRegions(names)) => {
                let names: Vec<String> = names.iter().map(|name| format!("'{name}'")).collect();
                write!(f, "move into the region {}", names.join(" or "))
            }
            Self::Move(Move::Clear { clear_m }) => write!(f, "move until {} mm clear", mm(clear_m)),
            Self::Place(PlaceAt { place, clear_m, retreat_m }) => {
                write!(f, "put down in '{place}', the hand {} mm off it", mm(clear_m))?;
                if *retreat_m > 0.0 {
                    write!(f, " after a straight retreat of {} mm", mm(retreat_m))
                } else {
                    Ok(())
                }
            }
        }
    }
}

impl PlaceAt {
    /// Creates the options of a place stage: a named placement goal, and a retreat in any direction by [`CLEAR_M`].
    pub fn named(place: &str) -> Self {
        Self { place: place.to_owned(), clear_m: CLEAR_M, retreat_m: 0.0 }
    }
}

impl Pick {
    /// Returns the index of the body that is grasped.
    ///
    /// # Errors
    /// [`TaskError::Collision`] for an unknown name; [`TaskError::NothingToCarry`] without a target.
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
            Self::Regions(regions) if regions.is_empty() => refuse("'move' lists no region".to_owned()),
            Self::NamedRegions(names) if names.is_empty() => refuse("'move' names no region".to_owned()),
            Self::Regions(regions) => regions.iter().find_map(Region::fault).map_or(Ok(()), refuse),
            Self::Home | Self::NamedRegions(_) => Ok(()),
            Self::Clear { clear_m } if (0.0..=FARTHEST_CLEAR_M).contains(clear_m) => Ok(()),
            Self::Clear { clear_m } => {
                refuse(format!("{clear_m} m is not a valid clearance: expected 0 to {FARTHEST_CLEAR_M} m"))
            }
            Self::Configurations(ends) => {
                problem.with_goal(Goal::Configurations(ends.clone()))?;
                let robot = problem.robot();
                let mut beyond = ends.iter().map(|end| robot.first_limit_violation(end));
                let Some(first) = beyond.next() else {
                    return refuse("'move' lists no configuration".to_owned());
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

    /// Returns the configurations at which the motion may end (m, rad; one value per joint); `None` if they are no finite set.
    pub fn ends(&self, problem: &Problem) -> Option<Vec<Vec<f64>>> {
        match self {
            Self::Home => Some(vec![problem.start().to_vec()]),
            Self::Configurations(ends) => Some(ends.clone()),
            Self::Clear { .. } | Self::Regions(_) | Self::NamedRegions(_) => None,
        }
    }

    /// Returns the regions in one of which the motion ends; `None` for other goals.
    ///
    /// # Errors
    /// [`TaskError::UnknownRegion`].
    pub fn regions(&self, problem: &Problem) -> Result<Option<Vec<Region>>, TaskError> {
        match self {
            Self::Regions(regions) => Ok(Some(regions.clone())),
            Self::NamedRegions(names) => {
                names.iter().map(|name| problem.region(name).cloned()).collect::<Result<_, _>>().map(Some)
            }
            Self::Home | Self::Configurations(_) | Self::Clear { .. } => Ok(None),
        }
    }
}

const EMPTY_HAND: &str = "nothing is in the hand; a pick has to come before it";

/// Name of the target of a problem in files of stages.
const TARGET: &str = "target";

/// A stage in the format of files: one of `pick`, `move` and `place`, with its options.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct StageRow {
    /// Object that is grasped: a body of the scenario, or `target`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pick: Option<String>,
    /// Goal of a motion: `home`, `clear`, configurations (m, rad), a region of poses or a list of them, or `regions` of the
    /// scenario by name.
    #[serde(default, rename = "move", skip_serializing_if = "Option::is_none")]
    move_to: Option<MoveRow>,
    /// Placement goal of the object in the hand.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    place: Option<String>,
    /// Distance, in metres: with `move: clear`, of the object in the hand from everything; with `place`, of the hand from the
    /// object at the end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    clear_m: Option<f64>,
    /// Required clearance of the object of a `pick`, in metres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    object_margin_m: Option<f64>,
    /// Least length of the straight approach of a `pick`, in metres, at most 0.5.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    approach_m: Option<f64>,
    /// Least length of the straight retreat of a `place`, in metres, at most 0.5.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    retreat_m: Option<f64>,
}

/// Returns the fault, in words, of a length of a straight motion (m).
fn straight_fault(motion: &str, length_m: f64) -> Option<String> {
    let is_length = (0.0..=MOST_STRAIGHT_M).contains(&length_m);
    (!is_length)
        .then(|| format!("{length_m} m is not a valid length of {motion}: expected 0 to {MOST_STRAIGHT_M} m"))
}

#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
enum MoveRow {
    Word(String),
    Configurations(Vec<Vec<f64>>),
    Region(Box<RegionRow>),
    Regions(Vec<RegionRow>),
    NamedRegions(RegionNames),
}

/// Regions of the scenario: the motion ends in any of them.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct RegionNames {
    regions: Vec<String>,
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
        for (motion, length_m) in [("an approach", approach_m), ("a retreat", retreat_m)] {
            length_m.and_then(|length_m| straight_fault(motion, length_m)).map_or(Ok(()), Err)?;
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
            (None, Some(MoveRow::Region(row)), None) => Self::Move(Move::Regions(vec![(*row).try_into()?])),
            (None, Some(MoveRow::Regions(rows)), None) => {
                let regions = rows.into_iter().map(Region::try_from).collect::<Result<_, _>>()?;
                Self::Move(Move::Regions(regions))
            }
            (None, Some(MoveRow::NamedRegions(RegionNames { regions })), None) => {
                Self::Move(Move::NamedRegions(regions))
            }
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
            Stage::Move(Move::Regions(regions)) => {
                let mut rows: Vec<RegionRow> = regions.into_iter().map(RegionRow::from).collect();
                let only = if rows.len() == 1 { rows.pop() } else { None };
                Self {
                    move_to: Some(only.map_or(MoveRow::Regions(rows), |row| MoveRow::Region(Box::new(row)))),
                    ..row
                }
            }
            Stage::Move(Move::NamedRegions(regions)) => {
                Self { move_to: Some(MoveRow::NamedRegions(RegionNames { regions })), ..row }
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
