use clap::ValueEnum;
use cranny_grasp::{GraspSet, ScoreKind};
use cranny_path::{CostKind, TimingMethod};
use cranny_scenario::Geometry;
use cranny_task::{AfterPlacing, Criterion};

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum CriterionArgument {
    /// Within 1 mm and 1°, real geometry, the whole path proven
    Exact,

    /// The released planners' own loose measure, for comparison only
    Paper,
}

impl From<CriterionArgument> for Criterion {
    fn from(argument: CriterionArgument) -> Self {
        match argument {
            CriterionArgument::Exact => Self::Exact,
            CriterionArgument::Paper => Self::Paper,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum CostArgument {
    /// Its length, each joint weighted by how far it moves the arm, in metres
    Length,
    /// Its plain L2 length, metres and radians alike
    L2,
    /// The seconds of the time-optimal trajectory along it
    Time,
    /// Its length, up to eleven times as much where the robot is nearer than 20 mm to the world
    Clearance,
    /// The path of the tool, in metres
    Tool,
    /// The angle by which the tool turns, in radians
    Turn,
    /// Its length, and half a metre for each straight piece: few corners
    Smooth,
    /// Seconds: of its trajectory, with 1 for a metre of the tool's path and 0.3 for a radian of its turn
    Mix,
}

impl From<CostArgument> for CostKind {
    fn from(argument: CostArgument) -> Self {
        match argument {
            CostArgument::Length => Self::Length,
            CostArgument::L2 => Self::L2,
            CostArgument::Time => Self::Time,
            CostArgument::Clearance => Self::Clearance,
            CostArgument::Tool => Self::Tool,
            CostArgument::Turn => Self::Turn,
            CostArgument::Smooth => Self::Smooth,
            CostArgument::Mix => Self::Mix,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum TimingArgument {
    /// Those of velocity and acceleration: the fastest
    TimeOptimal,
    /// Those of jerk too: accelerations change smoothly
    JerkLimited,
}

impl From<TimingArgument> for TimingMethod {
    fn from(argument: TimingArgument) -> Self {
        match argument {
            TimingArgument::TimeOptimal => Self::TimeOptimal,
            TimingArgument::JerkLimited => Self::JerkLimited,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ScoreArgument {
    /// Of the contacts: how little friction they need
    Geometric,
    /// The robust score, which every grasp must then have: how often it is held in physics, everything a little wrong
    Physics,
    /// The factor by which gravity may grow before a pad slips, computed anew whatever the file of grasps states
    Load,
}

impl From<ScoreArgument> for ScoreKind {
    fn from(argument: ScoreArgument) -> Self {
        match argument {
            ScoreArgument::Geometric => Self::Geometric,
            ScoreArgument::Physics => Self::Physics,
            ScoreArgument::Load => Self::Load,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum GeometryArgument {
    /// The true boxes and the target's own mesh
    Scene,
    /// The merged obstacle mesh that the released planners used
    Export,
}

impl From<GeometryArgument> for Geometry {
    fn from(argument: GeometryArgument) -> Self {
        match argument {
            GeometryArgument::Scene => Self::Scene,
            GeometryArgument::Export => Self::Export,
        }
    }
}

/// A least score, of a kind if one is named.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeastScore {
    pub kind: Option<ScoreKind>,
    pub least: f64,
}

impl LeastScore {
    /// The grasps of a set that have at least this score; without a kind the geometric one.
    pub fn among(&self, set: &GraspSet) -> GraspSet {
        let kind = self.kind.unwrap_or(ScoreKind::Geometric);
        let is_enough = |index: &usize| set.grasps()[*index].score_of(kind).is_some_and(|s| s >= self.least);
        set.chosen(&(0..set.len()).filter(is_enough).collect::<Vec<usize>>())
    }
}

pub fn least_score(text: &str) -> Result<LeastScore, String> {
    let (kind, number) = match text.split_once('=') {
        None => (None, text),
        Some((kind, number)) => {
            let known = ScoreArgument::from_str(kind, false);
            let known = known.map_err(|_| format!("'{kind}' is none of geometric, physics and load"))?;
            (Some(known.into()), number)
        }
    };
    let least: f64 = number.trim().parse().map_err(|_| format!("'{number}' is no number"))?;
    if !(least >= 0.0 && least.is_finite()) {
        return Err(format!("'{number}' is no score; give a number from 0 to 1, or a load from 0"));
    }
    Ok(LeastScore { kind, least })
}
/// Where a robot goes once it has put something down.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ThenArgument {
    /// To where it started
    Home,
    /// Nowhere
    Stay,
}

impl From<ThenArgument> for AfterPlacing {
    fn from(argument: ThenArgument) -> Self {
        match argument {
            ThenArgument::Home => Self::Home,
            ThenArgument::Stay => Self::Stay,
        }
    }
}
