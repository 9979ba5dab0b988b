use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Args;
use clap::builder::ArgPredicate;
use cranny_collision::Margins;
use cranny_path::MAX_SAMPLE_RATE_HZ;
use cranny_record::SpeedOption;
use cranny_scenario::GivenGrasps;
use cranny_solve::{DEFAULT_HOLD, PoseRadius};

use crate::choices::{
    CostArgument, CriterionArgument, GeometryArgument, LeastScore, ScoreArgument, ThenArgument,
    TimingArgument, least_score,
};
use crate::number_argument::{MOST_ITERATIONS, millimetres, pose_error, seconds, whole};
use crate::planning::explore_arguments::ExploreArguments;

/// Output format and verbosity of a command.
#[derive(Clone, Copy, Debug, Args)]
pub struct Output {
    /// Print one JSON document on standard output; messages go to standard error
    #[arg(long, global = true)]
    pub json: bool,
    /// Print no progress and no summary
    #[arg(long, short, global = true)]
    pub quiet: bool,
    /// Overwrite files of another kind as well (never results of campaigns, never a device)
    #[arg(long, global = true)]
    pub force: bool,
}

impl Output {
    /// Returns these settings without `quiet`, for a command that does nothing but print its answer.
    pub fn aloud(self) -> Self {
        Self { quiet: false, ..self }
    }
}

/// Required clearances and tilt bound.
#[derive(Clone, Copy, Debug, Args)]
pub struct MarginArguments {
    /// Clearance that every check and proof requires between any two bodies, in millimetres [default: 0]
    #[arg(long, value_name = "MM", value_parser = millimetres)]
    margin: Option<f64>,
    /// Clearance of hand and fingers from the target and its support, in millimetres [default: 0; `plan` takes 1
    /// where the task goes on after the grasp, unless --robust is given]
    #[arg(long, value_name = "MM", value_parser = millimetres)]
    grasp_margin: Option<f64>,
    /// Maximum tilt of a held object relative to its orientation when grasped, in degrees, proven along the whole motion; for
    /// bodies with `upright_deg` in scenario.yaml, the smaller value applies
    #[arg(long, value_name = "DEG", num_args = 0..=1, default_missing_value = "15", value_parser = tilt_degrees)]
    upright: Option<f64>,
}

fn tilt_degrees(word: &str) -> Result<f64, String> {
    let fault = || format!("'{word}' is not a valid tilt limit: expected degrees, above 0 and at most 180");
    let degrees: f64 = word.parse().map_err(|_| fault())?;
    if degrees > 0.0 && degrees <= 180.0 { Ok(degrees) } else { Err(fault()) }
}

impl MarginArguments {
    /// Returns the margins, with those of `otherwise` for the options that are not given.
    pub fn or(self, otherwise: Margins) -> Margins {
        Margins {
            margin_m: self.margin.unwrap_or(otherwise.margin_m),
            grasp_margin_m: self.grasp_margin.unwrap_or(otherwise.grasp_margin_m),
            tilt_rad: self.upright.map(f64::to_radians).or(otherwise.tilt_rad),
            ..otherwise
        }
    }
}

/// Task and criterion of a command.
#[derive(Clone, Debug, Args)]
pub struct TaskArguments {
    /// Built-in scenario, or the folder of one
    #[arg(value_name = "ID")]
    pub id: String,
    /// Criterion for solved tasks and free motions [default: the scenario's own, else exact]
    #[arg(long, value_enum)]
    pub criterion: Option<CriterionArgument>,
    #[command(flatten)]
    pub margins: MarginArguments,
    /// Also check link pairs that are listed as not checked, except adjacent links that touch at every value of their joint
    #[arg(long)]
    pub strict_pairs: bool,
    /// Robot to use instead of the scenario's: a built-in one (see `cranny robot list`), the folder of one, or a URDF with
    /// SRDF, limits.yaml and robot.yaml beside it
    #[arg(long, value_name = "FILE")]
    pub robot: Option<PathBuf>,
    /// Obstacles of a released scenario: the true boxes, or the inflated mesh that its planners used [default: scene under
    /// exact, export under paper]
    #[arg(long, value_enum)]
    pub geometry: Option<GeometryArgument>,
    /// File of grasps in the planning frame, or `none`: the planner then generates its own grasp, which `verify` measures on
    /// the target's mesh [default: the scenario's own]
    #[arg(long, value_name = "FILE|none")]
    pub grasps: Option<GivenGrasps>,
}

impl TaskArguments {
    /// Returns true if a tilt bound is given.
    pub fn is_upright(&self) -> bool {
        self.margins.upright.is_some()
    }
}

/// Maximum number of physics trials; each takes about a second.
const MOST_TRIES: u64 = 1000;

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny plan 021
  cranny plan 023 --planner j-plus-rrt --criterion paper --seed 4
  cranny plan path/to/scenarios/035 --time-limit 60 -o reach.plan.json
  cranny plan 021 --margin 5 --grasp-margin 1
  cranny plan 021 --rate 100 --jerk-limited
  cranny plan 021 --optimise 0.1 --cost time --score-weight 0
  cranny plan 043 --place outside --optimise 2
  cranny plan 021 --planner ik-rbt --set critical_m=0.05
  cranny plan 035 --carry home
  cranny plan 015 --carry out --clear 100
  cranny plan 012 --place outside --then stay
  cranny plan 031 --robot fr3 --carry home --torque
  cranny plan 012 --place outside --approach 8 --retreat 10
  cranny plan 031 --place outside --try-in-physics 5
  cranny plan 021 --robust 2,3
  cranny plan 213 --steps
  cranny plan path/to/scenario --task tidy
  cranny plan 021 --grasps scored.csv --score physics    see `cranny simulate grasps --trials`
  cranny plan 031 --place outside --min-score load=3
  cranny plan 021 --grasps none
  cranny plan --moveit scene0001.yaml request0001.yaml
  cranny plan 021 --explore --noise-seed 1 --time-limit 2 -o seen021
  cranny plan 021 --explore --views 12 --camera hand --cameras cameras.yaml
  cranny plan 021 --json --quiet", mut_arg("id", |id| id
    .required(false)
    .required_unless_present("moveit")
    .default_value_if("moveit", ArgPredicate::IsPresent, "")))]
#[expect(clippy::struct_excessive_bools, reason = "a flag of the command each")]
pub struct PlanArguments {
    #[command(flatten)]
    pub task: TaskArguments,
    // An attribute instead of a doc comment: `MoveIt` would need backticks there, which the help would show.
    #[arg(
        long,
        num_args = 2,
        value_names = ["SCENE", "REQUEST"],
        conflicts_with_all = ["id", "criterion", "grasp_margin", "geometry", "grasps", "score", "goal_threshold"],
        help = "Plan a MoveIt scene and request (YAML) in place of a scenario, for the robot of the scene's \
                model, whose URDF and SRDF lie beside the scene or in the folder above, or for --robot"
    )]
    pub moveit: Vec<PathBuf>,
    /// Planner (see `cranny list`) [default: reach under exact, grasp-reach with --grasps none, ik-rrt under paper]
    #[arg(long, value_name = "NAME")]
    pub planner: Option<String>,
    /// Setting of the planner, named as in docs/planners.md; repeatable
    #[arg(long, value_name = "NAME=VALUE", value_parser = setting)]
    pub set: Vec<(String, serde_json::Value)>,
    /// Score used to compare and filter grasps [default: load under exact where the file states it for each grasp and
    /// --min-score is not given, else geometric]
    #[arg(long, value_enum)]
    pub score: Option<ScoreArgument>,
    /// Minimum score of a goal grasp, from 0 to 1, or minimum load, from 0; grasps below it or without a score are ignored. A
    /// kind before it (load=2) is short for --score too
    #[arg(long, value_name = "[KIND=]S", allow_hyphen_values = true, conflicts_with = "moveit", value_parser = least_score)]
    pub min_score: Option<LeastScore>,
    /// Seed of all random numbers: the same seed gives the same path
    #[arg(long, value_name = "N", default_value = "0", value_parser = whole(0..=u64::MAX))]
    pub seed: u64,
    /// Time limit of the search, in seconds, which ends after its first attempts at the earliest; with --explore, of each search,
    /// and 5 by default
    #[arg(
        long,
        value_name = "S",
        default_value = "120",
        default_value_if("explore", ArgPredicate::IsPresent, "5"),
        value_parser = seconds
    )]
    pub time_limit: Duration,
    /// Maximum number of iterations of the search [default: no limit]
    #[arg(long, value_name = "N", value_parser = whole(0..=MOST_ITERATIONS))]
    pub iterations: Option<u64>,
    /// Carry the target on after the grasp: `home`, to the robot's start configuration; `out`, until it is clear of everything
    /// but the floor; to a configuration (comma-separated values), or to any of those in a file (.csv). A grasp from which it
    /// cannot be carried there is rejected
    #[arg(long, value_name = "home|out|Q|FILE", allow_hyphen_values = true)]
    pub carry: Option<String>,
    /// Require that the plan tolerates this error of the target's pose, a displacement and a turn about its centre at once,
    /// before the hand closes on it and in the hand afterwards (every plan states the errors that it tolerates)
    #[arg(long, value_name = "MM,DEG", value_parser = pose_error, conflicts_with = "moveit")]
    pub robust: Option<PoseRadius>,
    /// Factor by which weight and inertia must be able to grow, at least, before the object slips in the hand: weaker grasps
    /// are rejected, and motions are slowed down accordingly; 0 disables the check
    #[arg(long, value_name = "FACTOR", default_value_t = DEFAULT_HOLD, allow_negative_numbers = true)]
    pub hold: f64,
    /// Execute each plan in physics, as `simulate plan` does; if an object is lost or does not stay where it was put down, plan
    /// again without the failed grasp and with the next seed; N is the maximum number of attempts
    #[arg(long, value_name = "N", value_parser = whole(1..=MOST_TRIES), conflicts_with = "moveit")]
    pub try_in_physics: Option<u64>,
    /// Put the target down at a place of the scenario (`places` in its scenario.yaml; `cranny info` lists them) and open the
    /// hand. A grasp with which it cannot be brought there is rejected
    #[arg(long, value_name = "PLACE")]
    pub place: Option<String>,
    /// Move the hand into a region of the scenario instead of to a grasp (`regions` in its scenario.yaml; `cranny info` lists
    /// them). Give the flag again for other regions, any of which is a goal
    #[arg(long, value_name = "NAME", action = clap::ArgAction::Append)]
    pub goal_region: Vec<String>,
    /// Plan a task of several stages (`tasks` in the scenario.yaml; `cranny info` lists them)
    #[arg(long = "task", value_name = "NAME")]
    pub named_task: Option<String>,
    /// Pick and place what the scenario's `steps` name: short for --task steps
    #[arg(long, conflicts_with = "named_task")]
    pub steps: bool,
    /// With --place: destination of the robot after the hand has left the target [default: home]
    #[arg(long, value_enum, value_name = "WHERE")]
    pub then: Option<ThenArgument>,
    /// In millimetres. With --carry out: final clearance of the target, at most 1000; with --place, --steps and --task:
    /// distance of the hand from an object after leaving it, at most 500 [default: 50]
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    pub clear: Option<f64>,
    /// Length of the straight approach to each grasp along the hand's z axis, in centimetres, at least this long and at most 50
    /// (proven, within 1 mm and 1°) [default: as the stages of a task state it, else 0]
    #[arg(long, value_name = "CM", allow_negative_numbers = true)]
    pub approach: Option<f64>,
    /// With --place, --steps and --task: length of the straight retreat from each object, in centimetres
    #[arg(long, value_name = "CM", allow_negative_numbers = true)]
    pub retreat: Option<f64>,
    /// Do not shorten the planner's path
    #[arg(long)]
    pub no_shortcut: bool,
    /// Search for better paths for this many seconds after the first; with --iterations as well, over all searches, the same
    /// seed gives the same path. A better path has a lower cost: the measure of --cost minus the weighted score of the grasp
    #[arg(long, value_name = "SECONDS", value_parser = seconds, conflicts_with = "no_shortcut")]
    pub optimise: Option<Duration>,
    /// Cost of a path under --optimise [default: mix; length for a robot without acceleration limits]
    #[arg(long, value_enum, requires = "optimise")]
    pub cost: Option<CostArgument>,
    /// Weight of the grasp score: the cost that a grasp of score 1 saves against one of score 0, in the unit of the cost
    #[arg(long, value_name = "W", default_value_t = 1.0, requires = "optimise")]
    pub score_weight: f64,
    /// Under paper: the goal is reached where ½·mm + ½·deg is below this; 0 is never reached, to measure a planner's speed
    /// [default: 50]
    #[arg(long, value_name = "D")]
    pub goal_threshold: Option<f64>,
    /// Write the trajectory beside the plan, as ID.trajectory.csv: position, velocity and acceleration of every joint, at this
    /// sample rate in Hz
    #[arg(long, value_name = "HZ", value_parser = sample_rate)]
    pub rate: Option<f64>,
    /// Limits that the trajectory keeps [default: jerk-limited if the robot states jerk limits, else time-optimal]
    #[arg(long, value_enum)]
    pub timing: Option<TimingArgument>,
    /// Short for --timing jerk-limited
    #[arg(long, conflicts_with = "timing")]
    pub jerk_limited: bool,
    /// Stop at each corner of the path instead of rounding corners whose blend is proven free
    #[arg(long)]
    pub stop_at_corners: bool,
    /// Round corners (the default)
    #[arg(long, hide = true, conflicts_with = "stop_at_corners")]
    pub blend: bool,
    /// Keep the force or torque of each joint within the effort limit of the URDF, given the masses of links and held object
    #[arg(long)]
    pub torque: bool,
    /// Fraction of the joint velocity limits to use, above 0 and at most 1, for all motions or for one kind (carry=0.2);
    /// repeatable [default: `speeds` of scenario.yaml, else 1]
    #[arg(long, value_name = "[MODE=]SHARE")]
    pub speed: Vec<SpeedOption>,
    /// Fraction of the joint acceleration limits to use, in the same form
    #[arg(long, value_name = "[MODE=]SHARE")]
    pub acceleration: Vec<SpeedOption>,
    /// Maximum speed of the gripper frame in m/s, for all motions or for one kind (carry=0.25); repeatable [default: `speeds`
    /// of scenario.yaml; set-down=0.1]
    #[arg(long, value_name = "[MODE=]M/S")]
    pub tool_speed: Vec<SpeedOption>,
    /// Maximum angular speed of the hand and of the object that it holds, in degrees a second
    #[arg(long, value_name = "[MODE=]DEG/S")]
    pub turn_speed: Vec<SpeedOption>,
    #[command(flatten)]
    pub explore: ExploreArguments,
    /// File to write the plan to, even if the search failed [default: ID.plan.json in this folder, only if solved]; with
    /// --explore, the new folder to write [default: ID.explored, only if solved]
    #[arg(long, short, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Write a certificate too, as `cranny certify` does; without one the exit code is 1
    #[arg(long, value_name = "FILE", conflicts_with = "moveit")]
    pub certificate: Option<PathBuf>,
}

#[derive(Clone, Debug, Args)]
#[command(
    after_help = "Examples:
  cranny verify 021 021.plan.json
  cranny verify path/to/scenarios/011 way_points.csv --margin 2
  cranny verify --moveit scene0001.yaml request0001.yaml scene0001.plan.json

Way points: a plan file, or one configuration a line, comma-separated (.csv, .try). Criterion, margins and
whether a set of grasps is given are those of the plan file unless flags say otherwise.",
    override_usage = "cranny verify [OPTIONS] <ID> <PLAN>
       cranny verify [OPTIONS] --moveit <SCENE> <REQUEST> <PLAN>"
)]
pub struct VerifyArguments {
    #[command(flatten)]
    pub task: TaskArguments,
    /// A plan file (.plan.json) or way points (.csv, .try)
    #[arg(value_name = "PLAN", required_unless_present = "moveit", conflicts_with = "moveit")]
    pub plan: Option<PathBuf>,
    /// Accept a path that does not end at a goal
    #[arg(long)]
    pub any_end: bool,
    // An attribute, as for `plan`.
    #[arg(
        long,
        num_args = 2,
        value_names = ["SCENE", "REQUEST"],
        conflicts_with_all = ["criterion", "grasp_margin", "geometry", "grasps"],
        help = "Judge PLAN, then the only argument, against a MoveIt scene and request (YAML) in place of a \
                scenario, as `cranny plan --moveit` takes them"
    )]
    pub moveit: Vec<PathBuf>,
}

impl VerifyArguments {
    /// Returns the path of the file to verify: the last argument, which takes the position of the id if there is no id.
    pub fn plan(&self) -> &Path {
        self.plan.as_deref().unwrap_or(Path::new(&self.task.id))
    }
}

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny certify 021 021.plan.json
  cranny certify path/to/scenarios/011 way_points.csv -o 011.cert
  cranny certify path/to/narrow_gate
  cranny certify 035 --impossible-grasps

docs/certificate.md defines the file and names the programs that check it.")]
pub struct CertifyArguments {
    #[command(flatten)]
    pub task: TaskArguments,
    /// A plan file (.plan.json) or way points (.csv, .try); without it, or for a plan without a path, the certificate is that no
    /// motion exists
    #[arg(value_name = "PLAN", conflicts_with = "impossible_grasps")]
    pub plan: Option<PathBuf>,
    /// The certificate is that no motion leads to certain grasps: those at which the hand is found to touch the world by more than
    /// the tolerance of 1 mm and 1°, or that are beyond reach
    #[arg(long)]
    pub impossible_grasps: bool,
    /// File to write the certificate to [default: ID.cert in this folder]
    #[arg(long, short, value_name = "FILE")]
    pub output: Option<PathBuf>,
}

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny ik 025
  cranny ik 021 --solutions 5 --grasp 139
  cranny ik 021 --single-shot
  cranny ik path/to/scenarios/011 --json > ik.json")]
pub struct IkArguments {
    #[command(flatten)]
    pub task: TaskArguments,
    /// Only this grasp, by its index from 0
    #[arg(long, value_name = "N")]
    pub grasp: Option<usize>,
    /// Number of distinct solutions to search for at each grasp
    #[arg(long, value_name = "N", default_value = "1", value_parser = whole::<usize>(1..=1000))]
    pub solutions: usize,
    /// Maximum number of attempts at each grasp
    #[arg(long, value_name = "N", default_value = "5000", value_parser = whole::<usize>(1..=1_000_000_000))]
    pub attempts: usize,
    /// Make one attempt at each grasp and one at its twin, from the start, as the paper does
    #[arg(long, conflicts_with = "attempts")]
    pub single_shot: bool,
    /// Seed of all random numbers
    #[arg(long, value_name = "N", default_value = "0", value_parser = whole(0..=u64::MAX))]
    pub seed: u64,
}

/// Parses `name=value`; the value is a number, true or false, otherwise text.
fn setting(text: &str) -> Result<(String, serde_json::Value), String> {
    let (name, value) =
        text.split_once('=').ok_or_else(|| format!("'{text}' is not of the form name=value"))?;
    let value = match serde_json::from_str(value) {
        Ok(
            value @ (serde_json::Value::Number(_) | serde_json::Value::Bool(_) | serde_json::Value::Array(_)),
        ) => value,
        _ => value.into(),
    };
    Ok((name.to_owned(), value))
}

pub fn sample_rate(text: &str) -> Result<f64, String> {
    let rate_hz: f64 = text.parse().map_err(|_| {
        format!("'{text}' is not a valid sample rate: expected a number of samples per second")
    })?;
    if rate_hz > 0.0 && rate_hz <= MAX_SAMPLE_RATE_HZ {
        Ok(rate_hz)
    } else {
        Err(format!("expected more than 0 and at most {MAX_SAMPLE_RATE_HZ} samples per second"))
    }
}
