use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;
use cranny_file::counted;
use cranny_grasp::Hand;
use cranny_plan::Unobserved;
use cranny_record::{PlanFile, read_waypoints};
use cranny_scenario::{Friction, OpenOptions, TargetPhysics};
use cranny_sim::{
    ContactPhase, Disturbance, ExecutedPlan, GraspOutcome, PickPath, PlacedError, PlanContact, PlanExecution,
    PlanOutcome, PlanRow, Released, SimError, StopReason,
};
use cranny_solve::{TaskTrajectory, Timing};
use cranny_task::{Segment, robot_hand};

use crate::arguments::Output;
use crate::failure::Failure;
use crate::file_kind::FileKind;
use crate::number_argument::positive;
use crate::planning::plan_task::{check_plan, read_plan};
use crate::planning::task::open_scenario;
use crate::text::{self, degrees, millimetres};
use crate::{Answer, number_argument, output_file, physics::recording, progress};

/// Overrides of object and hand properties in the files.
#[derive(Clone, Debug, Args)]
pub struct InsteadArguments {
    /// Mass of the object, in kilograms (with several picks, of each object) [default: its own]
    #[arg(long, value_name = "KG", value_parser = positive)]
    mass: Option<f64>,
    /// Coefficient of friction of the object, or its range, such as 0.35..0.6 [default: its own]
    #[arg(long, value_name = "MU")]
    friction: Option<Friction>,
    /// Closing force of the fingers, in newtons [default: the hand's own]
    #[arg(long, value_name = "N", value_parser = positive)]
    closing_force: Option<f64>,
}

impl InsteadArguments {
    pub fn of_target(&self) -> TargetPhysics {
        TargetPhysics { mass_kg: self.mass, friction: self.friction, ..TargetPhysics::default() }
    }

    pub fn of_hand(&self, hand: Hand) -> Hand {
        Hand { closing_force_n: self.closing_force.unwrap_or(hand.closing_force_n), ..hand }
    }
}

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny simulate plan 021 021.plan.json
  cranny simulate plan 035 035.plan.json --record run.glb     or .gif, to be looked at
  cranny simulate plan 021 021.plan.json --lift 50 --json
  cranny simulate plan 213 213.plan.json                     of several steps
  cranny simulate plan 213 213.plan.json --replan            measured after each, and planned anew
  cranny simulate plan 012 012.plan.json --disturb 1         with everything a little wrong
  cranny simulate plan 012 012.plan.json --export run.json   for MuJoCo

The arm is where the timed path has it at each instant; the hand closes with its closing force on the object, which lies
where it stands. Then the arm lifts straight up, or follows the rest of a plan that carries the object on (`plan --carry`)
or puts it down (`plan --place`). Of several steps (`plan --steps`) each begins where the one before has left things. The
answer is what was touched, and four facts of the object: whether it stayed in the hand; by how much it slipped there;
whether it was released where the plan has it; and whether it stands there, within 10 mm and 10°, 2 s after the arm has
stopped. Turns of a round object that nobody can see do not count. The outcome is that of `simulate grasps`, or of an
object that was released `placed` or `misplaced`.")]
pub struct SimulatePlanArguments {
    /// Built-in scenario, or the folder of one
    #[arg(value_name = "ID")]
    pub id: String,
    /// Plan file (.plan.json) or way points (.csv, .try)
    #[arg(value_name = "PLAN")]
    pub plan: PathBuf,
    /// Height to which the object is lifted if the plan ends at the grasp, in millimetres
    #[arg(long, value_name = "MM", default_value = "30", value_parser = number_argument::millimetres)]
    pub lift: f64,
    #[command(flatten)]
    pub instead: InsteadArguments,
    /// Apply errors drawn from this seed: of the hand 2 mm and 2° per axis, of friction 30 %, of mass 20 %
    #[arg(long, value_name = "SEED")]
    pub disturb: Option<u64>,
    /// Robot to use instead of the plan's or the scenario's: a built-in one, the folder of one, or a URDF with limits.yaml and
    /// robot.yaml beside it
    #[arg(long, value_name = "FILE")]
    pub robot: Option<PathBuf>,
    /// Measure the objects after each pick: replan the rest if an object is off by more than the plan tolerates, and repeat the
    /// pick if its object is not at its goal
    #[arg(long)]
    pub replan: bool,
    /// Export the plan of a single pick for another engine; `cranny.mujoco_grasps.run_plan` runs the document in MuJoCo
    #[arg(long, value_name = "FILE")]
    pub export: Option<PathBuf>,
    /// Record the motion: .glb, .gif, or .json for `cranny render`
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
}

impl SimulatePlanArguments {
    /// Returns the checked path and kind of the recording, if one is requested.
    pub fn recorded(&self, output: Output) -> Result<Option<(&Path, FileKind)>, Failure> {
        let Some(file) = self.record.as_deref() else { return Ok(None) };
        let kind = recording::kind_of(file)?;
        output_file::check(file, kind, output)?;
        Ok(Some((file, kind)))
    }
}

pub fn run(arguments: &SimulatePlanArguments, output: Output) -> Result<Answer, Failure> {
    let recorded = arguments.recorded(output)?;
    if let Some(file) = &arguments.export {
        output_file::check(file, FileKind::Experiment, output)?;
    }
    let file = &arguments.plan;
    let plan = read_plan(file)?;
    let of_plan = || plan.as_ref().and_then(|plan| plan.robot.clone()).map(PathBuf::from);
    let options = OpenOptions {
        criterion: plan.as_ref().map(|plan| plan.criterion),
        robot: arguments.robot.clone().or_else(of_plan),
        geometry: plan.as_ref().and_then(PlanFile::given_geometry),
        grasps: plan.as_ref().map(PlanFile::given_grasps).unwrap_or_default(),
    };
    let scenario = open_scenario(&arguments.id, &options, output)?;
    let refused = |problem: String| Failure::File { path: file.clone(), problem };
    let picks = if let Some(plan) = &plan {
        check_plan(file, plan, &scenario.robot, &scenario.id, "executed in")?;
        if plan.waypoints.is_empty() {
            let ended = plan.outcome.sentence();
            return Err(refused(format!("the plan has no path, so there is nothing to execute: {ended}")));
        }
        plan.check_task(&scenario)?;
        PickPath::all_of(plan, &scenario.problem(plan.margins)?)
    } else {
        let reach = Segment::reach(read_waypoints(file, scenario.robot.dof())?, Vec::new());
        let end = reach.waypoints.last().cloned().unwrap_or_default();
        let timed = TaskTrajectory::of(Timing::default(), &scenario.robot, &[reach])?;
        timed.map(|timed| vec![PickPath { object: None, timed, end }]).ok_or(SimError::NoTimes)
    };
    let picks = picks.map_err(|fault| match fault {
        SimError::NoTimes => refused(fault.to_string()),
        fault => fault.into(),
    })?;
    let execution = PlanExecution {
        scenario: &scenario,
        hand: arguments.instead.of_hand(robot_hand(&scenario.robot)),
        instead: arguments.instead.of_target(),
        lift_m: arguments.lift,
        disturbance: arguments.disturb.map(Disturbance::of_execution).unwrap_or_default(),
        is_recorded: recorded.is_some(),
    };
    let count = picks.len();
    if let Some(PickPath { object: Some(object), .. }) = execution.massless(&picks)?.filter(|_| count > 1) {
        return Err(refused(format!(
            "the mass of '{object}' is not known (write mass_kg in its entry of scenario.yaml, or give --mass)"
        )));
    }
    if let Some(file) = &arguments.export {
        let experiment = execution.experiment(&picks)?.ok_or_else(|| Failure::Flag {
            flag: "export",
            problem: format!("the plan has {count} picks; give a plan with a single pick"),
        })?;
        output_file::write(file, FileKind::Experiment, text::json(&experiment)?.as_bytes(), output)?;
    }
    let bar = progress::bar(count as u64, output.quiet);
    bar.set_message("picks");
    let (mut runs, replanned) = match (&plan, arguments.replan) {
        (Some(plan), true) => {
            let margins = plan.margins;
            let problem = scenario.problem(margins)?;
            let done = || bar.inc(1);
            let found = execution.run_replanning(plan, (&problem, margins), &mut Unobserved, done)?;
            let executed = found.executed(&scenario.id);
            (found.runs, Some(executed))
        }
        (None, true) => {
            return Err(refused(
                "way points alone cannot be replanned: --replan needs a plan file with stages".to_owned(),
            ));
        }
        (_, false) => (execution.run(&picks, || bar.inc(1))?, None),
    };
    bar.finish_and_clear();
    if let Some((file, kind)) = recorded {
        recording::write(&recording::of_picks(&scenario, &mut runs), file, kind, output)?;
    }
    let nothing = || Failure::NoTarget { id: scenario.id.clone() };
    let executed = replanned.or_else(|| ExecutedPlan::of(&scenario.id, count, &runs)).ok_or_else(nothing)?;
    text::answer(&executed, || page(&executed, count), output)?;
    Ok(if executed.is_as_planned() { Answer::Done } else { Answer::No })
}

fn page(executed: &ExecutedPlan, count: usize) -> String {
    let (scenario, steps, new_plans, stopped) = match executed {
        ExecutedPlan::One { scenario, row } => return page_of(scenario, row),
        ExecutedPlan::Several { scenario, steps, new_plans, stopped, .. } => {
            (scenario, steps, new_plans, stopped)
        }
    };
    let there = steps.iter().filter(|step| step.row.is_as_planned()).count();
    let anew =
        new_plans.map_or_else(String::new, |new_plans| format!(", {}", counted(new_plans, "new plan")));
    let contacts = match steps.iter().map(|step| step.row.contacts.len()).sum::<usize>() {
        0 => String::new(),
        contacts => format!(", {} that the plan does not have", counted(contacts, "contact")),
    };
    let mut page =
        format!("{scenario}: {there} of {} as planned{contacts}{anew}\n", counted(count, "object"));
    for (index, step) in steps.iter().enumerate() {
        let _ = write!(page, "step {}, {}", index + 1, page_of(&step.object, &step.row));
    }
    if let Some(stopped) = stopped {
        let reason = match stopped {
            StopReason::NotReleased => "the object was not released",
            StopReason::NoPlan => "no plan was found from where the objects are",
            StopReason::TooManyRepeats => "a step failed too often",
        };
        let _ = writeln!(page, "the remaining steps were not executed: {reason}");
    }
    page
}

/// Formats the result of the plan called `name`.
fn page_of(name: &str, row: &PlanRow) -> String {
    let mut page =
        format!("{}: {}, after a path of {:.1} s to the grasp", name, row.outcome.name(), row.reach_s);
    if row.lift_m > 0.0 {
        let _ = write!(page, " and a lift of {}", millimetres(row.lift_m));
    } else {
        let _ = write!(page, ", of {:.1} s that were simulated", row.simulated_s);
    }
    page.push('\n');
    if let Some(settled_m) = row.settled_m {
        let settled = millimetres(settled_m);
        let _ = writeln!(
            page,
            "  the object does not rest where the plan has it: it came to rest {settled} away before the motion"
        );
    }
    for contact in &row.contacts {
        let PlanContact { time_s, link, body, depth_m, phase } = contact;
        let phase = match phase {
            ContactPhase::Reach => "before closing",
            ContactPhase::Hold => "after closing",
            ContactPhase::Release => "after opening",
        };
        let depth = millimetres(*depth_m);
        let _ = writeln!(page, "  {phase}: {link} touched {body} at {time_s:.2} s, {depth} deep");
    }
    if !row.contacts.iter().any(|contact| contact.phase == ContactPhase::Reach) {
        page.push_str("  nothing was touched before the hand closed\n");
    }
    let pushed = millimetres(row.pushed_m);
    // The place of an object that was put down is below.
    let rose = if row.released.is_none() {
        let side = if row.rose_m < 0.0 { "lower" } else { "higher" };
        format!(", and is {} {side} at the end", millimetres(row.rose_m.abs()))
    } else {
        String::new()
    };
    let _ = writeln!(page, "  the object was pushed by {pushed} before{rose}");
    let end = if row.released.is_some() { "until it was released" } else { "to the end" };
    let stayed = match (row.is_kept, row.is_in_hand || row.released.is_some()) {
        (true, _) => format!("stayed in the hand {end}"),
        (false, true) => format!("stayed in the hand {end}, but slipped too far"),
        (false, false) => format!("did NOT stay in the hand {end}"),
    };
    let [slipped, turned] = [millimetres(row.translation_error_m), degrees(row.rotation_error_rad)];
    let _ = match row.outcome {
        PlanOutcome::Grasped(GraspOutcome::NeverClosed | GraspOutcome::KnockedAway) => {
            writeln!(page, "  the hand never held it: it moved by {slipped}, {turned} while the hand closed")
        }
        _ => writeln!(page, "  it {stayed}: it slipped by {slipped}, {turned}"),
    };
    let off = |error: &PlacedError| {
        format!("{}, {} off", millimetres(error.translation_m), degrees(error.rotation_rad))
    };
    if let Some(Released { position_m: [x, y, z], off: at, .. }) = &row.released {
        let _ = writeln!(
            page,
            "  it was released at ({x:.3}, {y:.3}, {z:.3}) m in the planning frame, {}",
            off(at)
        );
    }
    if let Some(placed) = &row.placed {
        let stands = if placed.is_there { "stands where" } else { "does NOT stand where" };
        let [x, y, z] = row.position_m;
        let at = format!("({x:.3}, {y:.3}, {z:.3}) m in the planning frame, {}", off(placed));
        let _ = writeln!(page, "  2 s later it {stands} it was to be put down: it is at {at}");
    }
    page
}
