use clap::ValueEnum;
use cranny_grasp::{GraspSet, ScoreKind};
use cranny_path::{CostKind, TimingMethod};
use cranny_scenario::Geometry;
use cranny_task::{AfterPlacing, Criterion};

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum CriterionArgument {
    /// Within 1 mm and 1°, true geometry, the whole path proven
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
    /// Length, with each joint weighted by how far it moves the arm, in metres
    Length,
    /// Plain L2 length, metres and radians alike
    L2,
    /// Duration of the time-optimal trajectory, in seconds
    Time,
    /// Length, weighted up to eleven times where the robot is nearer than 20 mm to the world
    Clearance,
    /// Path length of the tool, in metres
    Tool,
    /// Rotation angle of the tool, in radians
    Turn,
    /// Length plus half a metre for each straight segment: few corners
    Smooth,
    /// Seconds: duration of the trajectory, plus 1 per metre of tool path and 0.3 per radian of tool rotation
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
    /// Velocity and acceleration limits: the fastest trajectory
    TimeOptimal,
    /// Also jerk limits: smooth accelerations
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
    /// Contact quality: how little friction the contacts need
    Geometric,
    /// Robust score, required of every grasp: success rate in physics with small errors in everything
    Physics,
    /// Factor by which gravity may grow before a pad slips, always recomputed, even if the file of grasps states it
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

/// Minimum score, with its kind if one is named.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeastScore {
    pub kind: Option<ScoreKind>,
    pub least: f64,
}

impl LeastScore {
    /// Returns the grasps of a set with at least this score; without a kind, the geometric score counts.
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
            let known =
                known.map_err(|_| format!("unknown score '{kind}' (known: geometric, physics, load)"))?;
            (Some(known.into()), number)
        }
    };
    let least: f64 = number.trim().parse().map_err(|_| format!("'{number}' is not a number"))?;
    if !(least >= 0.0 && least.is_finite()) {
        return Err(format!(
            "'{number}' is not a valid score: expected a number from 0 to 1, or a load of at least 0"
        ));
    }
    Ok(LeastScore { kind, least })
}
/// Destination of the robot after it has put something down.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ThenArgument {
    /// Its start configuration
    Home,
    /// Stays where it is
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
