use std::fmt::Write;
use std::path::Path;

use cranny_collision::Margins;
use cranny_file::counted;
use cranny_grasp::{GraspSet, ScoreKind};
use cranny_path::BaseEnclosure;
use cranny_path::ClearanceLimit;
use cranny_plan::{Improvement, NoGrasp, Outcome, Statistics};
use cranny_record::{PlanAttempt, PlanFile, PlanShortening, PlanTiming};
use cranny_solve::{HoldFactors, JointRadius, PoseRadius, Robustness, Tilt, ToolSlack};
use cranny_task::{GraspFailure, Mode, MotionEnd, Move, Segment, Stage};
use serde::Serialize;

use crate::planning::obstruction::Obstruction;
use crate::statements::demanded_margins;
use crate::text::{
    self, at_least_degrees, at_least_mm, at_most_degrees, at_most_mm, at_most_seconds, millimetres,
};

/// Output of `plan --json`; its keys are stable.
#[derive(Serialize)]
pub struct Answered<'a> {
    #[serde(flatten)]
    pub plan: &'a PlanFile,
    pub planning_time_s: f64,
    pub preparation_time_s: f64,
    /// Time between preparation and answer that is in no other figure: for the proof, the tolerated errors, the least length, and
    /// tries in physics.
    pub judging_time_s: f64,
    pub shortcut_time_s: Option<f64>,
    pub iterations: u64,
    pub valid: bool,
    pub start_faults: Vec<String>,
    /// Deviations of the problem from its files, in sentences.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub deviations: Vec<String>,
    pub plan_file: Option<&'a Path>,
    pub duration_s: Option<f64>,
    pub timing_time_s: Option<f64>,
    pub trajectory_file: Option<&'a Path>,
    /// Pair of bodies that limits the clearance.
    pub clearance_limit: Option<&'a ClearanceLimit>,
    /// Seen space that blocks the best candidate, and the next view of it.
    #[serde(flatten)]
    pub obstruction: Option<Obstruction>,
    /// True if the planner generates the grasps of the first pick.
    #[serde(skip)]
    pub makes_first_grasps: bool,
    /// True if the limit of iterations was reached.
    #[serde(skip)]
    pub is_spent_by_iterations: bool,
    /// Reason why there is no trajectory.
    #[serde(skip)]
    pub untimed: Option<String>,
}

/// Selects the improvements to print, of all those in the plan file: the first, the last, and each that is at least 5 % below
/// the previous selected one.
fn milestones(improvements: &[Improvement]) -> Vec<&Improvement> {
    const FALL: f64 = 0.05;
    let mut told: Vec<&Improvement> = Vec::new();
    for improvement in improvements {
        if told.last().is_none_or(|last| last.cost - improvement.cost >= FALL * last.cost.abs()) {
            told.push(improvement);
        }
    }
    let last = improvements.last().filter(|last| told.last().is_some_and(|told| told.cost > last.cost));
    told.extend(last);
    told
}

/// Returns a line for each carried object.
fn carried(plan: &PlanFile) -> Vec<String> {
    let of_pick = |pair: &[Segment]| {
        let [lift_off, onward] = pair else { return None };
        let object = lift_off.attached.as_deref().filter(|_| is_at(lift_off, MotionEnd::First))?;
        let [off, on] = [lift_off, onward].map(|segment| segment.waypoints.len());
        let opening = millimetres(lift_off.opening_m?);
        let uneven = text::uneven(lift_off.uneven_m);
        Some(format!(
            "{object}, hand closed to {opening}{uneven}: {} to lift it off, {on} to where it goes",
            counted(off, "way point")
        ))
    };
    plan.segments.windows(2).filter_map(of_pick).collect()
}

fn is_at(segment: &Segment, end: MotionEnd) -> bool {
    segment.mode.rests_at == Some(end)
}

/// Formats the tolerated errors of poses and joints.
fn robust(robustness: &Robustness) -> String {
    let pose = |radius: &PoseRadius| {
        format!("{} or {}", at_least_mm(radius.translation_m), at_least_degrees(radius.rotation_rad))
    };
    let joints = |radius: &JointRadius| {
        let sliding = radius.sliding_m.map(at_least_mm);
        sliding.into_iter().chain(radius.turning_rad.map(at_least_degrees)).collect::<Vec<_>>().join(" or ")
    };
    let Robustness { object, slip, base, joints: all_joints } = robustness;
    let parts = [
        object.as_ref().map(|radius| format!("object {}", pose(radius))),
        slip.as_ref().map(|radius| format!("in the hand {}", pose(radius))),
        base.as_ref().map(|radius| format!("base {}", pose(radius))),
        all_joints.as_ref().map(|radius| format!("all joints {}", joints(radius))),
    ];
    format!("free with {} off", parts.into_iter().flatten().collect::<Vec<_>>().join("; "))
}

/// Formats the upper bound on the excess of the path length over the shortest path of its task, in percent; empty if unknown.
fn beyond_least(plan: &PlanFile) -> String {
    let share = plan.least_length.map(|least| plan.path_length / least - 1.0);
    share.filter(|share| share.is_finite()).map_or_else(String::new, |share| {
        let percent = cranny_file::at_most(100.0 * share, 1.0, 0);
        format!(", at most {percent} % longer than the shortest possible motion")
    })
}

/// Formats the hold of the carried object; `None` if nothing is carried.
fn held(plan: &PlanFile) -> Option<String> {
    let carries = plan.segments.iter().any(|segment| segment.mode.holds);
    let Some(HoldFactors { factor, at_rest, mass_assumed }) = plan.hold else {
        let is_asked = carries && plan.hold_demanded.is_some();
        return is_asked.then(|| "not computed: the hand does not have two known flat pads".to_owned());
    };
    let at_least = |factor: f64| cranny_file::at_least(factor, 1.0, 1);
    let mut held = match factor {
        Some(factor) => {
            format!(
                "by a factor of {} along the whole motion, {} at rest",
                at_least(factor),
                at_least(at_rest)
            )
        }
        None => {
            format!(
                "by a factor of {} at rest (the load in motion is unknown, because the path is not timed)",
                at_least(at_rest)
            )
        }
    };
    if let Some(slowest) = plan.segments.iter().filter_map(|segment| segment.speed).reduce(f64::min) {
        let _ = write!(held, "; slowed down to {} % of the speed for it", at_least(slowest * 100.0));
    }
    if mass_assumed {
        held.push_str("; the mass is not stated, and was assumed from the volume");
    }
    Some(held)
}

/// Returns a line for each object that is put down.
fn placed(plan: &PlanFile) -> Vec<String> {
    let of_place = |(index, set_down): (usize, &Segment)| {
        let Some(Stage::Place(place)) = plan.task.get(set_down.stage) else { return None };
        let retreat = plan.segments.get(index + 1).filter(|_| is_at(set_down, MotionEnd::Last))?;
        let points = |segment: &Segment| segment.waypoints.len();
        let home = matches!(plan.task.get(set_down.stage + 1), Some(Stage::Move(Move::Home)));
        let back = plan.segments.get(index + 2).filter(|_| home);
        let end = match plan.task.get(set_down.stage + 1) {
            None => "where it stays",
            Some(_) => "where the next stage begins",
        };
        let back = back.map_or_else(|| end.to_owned(), |back| format!("{} home", points(back)));
        let (name, clear) = (&place.place, at_least_mm(place.clear_m.max(place.retreat_m)));
        Some(format!(
            "'{name}': {} to set it down, {} until the hand is {clear} off it, {back}",
            counted(points(set_down), "way point"),
            points(retreat)
        ))
    };
    plan.segments.iter().enumerate().filter_map(of_place).collect()
}

/// Returns a line for each straight segment that the task requires.
fn straight(plan: &PlanFile) -> Vec<String> {
    let of_segment = |segment: &Segment| {
        let (length_m, end) = match plan.task.get(segment.stage)? {
            Stage::Pick(pick) if segment.mode == Mode::APPROACH => (pick.approach_m, "to the grasp"),
            Stage::Place(place) if segment.mode == Mode::RETREAT => (place.retreat_m, "off the object"),
            _ => return None,
        };
        let length = at_least_mm(length_m);
        (length_m > 0.0)
            .then(|| format!("{length} or more along the hand's z axis {end}, within 1 mm and 1°, proven"))
    };
    plan.segments.iter().filter_map(of_segment).collect()
}

/// Formats the duration of the trajectory and the time of its computation.
fn timed(timing: &PlanTiming, seconds: f64) -> String {
    let corners = if timing.blended { ", corners rounded" } else { "" };
    let torque = if timing.torque_up.is_some() { ", within the drives' efforts" } else { "" };
    let hand = timing.hand_s.iter().enumerate().map(|(index, [begin_s, end_s])| {
        let begins = if index == 0 { ", the hand" } else { " and" };
        let moves = if index % 2 == 0 { "closes" } else { "opens" };
        format!("{begins} {moves} from {begin_s:.3} to {end_s:.3} s")
    });
    let hand: String = hand.collect();
    let (duration, method) = (at_most_seconds(timing.duration_s), timing.method.name());
    format!("{duration}, {method}{corners}{torque}{hand}; {:.3} ms to time", seconds * 1e3)
}

/// Maximum number of reasons for refused goals that are listed.
const MOST_GOAL_FAULTS: usize = 12;

/// Formats the times of the search by purpose.
fn times(answered: &Answered) -> String {
    let statistics = &answered.plan.statistics;
    format!(
        "{} collision, {} proof, {} IK, {} nearest neighbours; {} to load, {} to judge",
        text::seconds(statistics.collision_time_s),
        text::seconds(statistics.proof_time_s),
        text::seconds(statistics.ik_time_s),
        text::seconds(statistics.nearest_time_s),
        text::seconds(answered.preparation_time_s),
        text::seconds(answered.judging_time_s)
    )
}

/// Formats the result and the time of the processing after the search.
fn shortened(shortening: &PlanShortening, seconds: f64) -> String {
    let searches = match shortening.searches {
        0 => String::new(),
        searches => format!(", with {searches} further searches"),
    };
    format!("in {}{searches}", text::seconds(seconds))
}

/// Formats the counts of the search.
fn searched(statistics: &Statistics) -> String {
    let [iterations, nodes, checks] = [
        counted(statistics.iterations, "iteration"),
        counted(statistics.nodes, "node"),
        counted(statistics.collision_checks, "collision check"),
    ];
    format!("{iterations}, {nodes}, {checks}")
}

/// Adds the lines on the path and its end.
fn about_path(answered: &Answered, grasps: &GraspSet, line: &mut dyn FnMut(&str, String)) {
    let Answered { plan, clearance_limit, .. } = answered;
    if let (Some(grasp), Some(translation), Some(rotation)) =
        (plan.grasp, plan.translation_error_m, plan.rotation_error_rad)
    {
        let count = grasps.len();
        let ends_at = &grasps.grasps()[grasp];
        let name = match plan.score {
            ScoreKind::Geometric => "score",
            ScoreKind::Physics => "robust score",
            ScoreKind::Load => "load",
        };
        let score = ends_at.score_of(plan.score);
        let left_out = match (plan.min_score, plan.below_min_score) {
            (Some(least), Some(below)) => format!("; {below} below {least} are no goals"),
            _ => String::new(),
        };
        line("grasp", format!("{grasp} of {count} ({name} {}{left_out})", text::score(score)));
        line("error", format!("{}, {}", at_most_mm(translation), at_most_degrees(rotation)));
    }
    if let Some(grasp) = &plan.own_grasp {
        line("grasp", text::own_grasp(grasp));
    }
    for pick in &plan.picks {
        let grasp = match (&pick.own_grasp, pick.grasp) {
            (Some(grasp), _) => text::own_grasp(grasp),
            (None, Some(grasp)) => format!("{grasp} of {}", grasps.len()),
            (None, None) => continue,
        };
        line("grasp", format!("stage {}: {grasp}", pick.stage + 1));
    }
    if let Some(clearance) = plan.clearance_m {
        let but_for = text::but_for(&plan.not_checked);
        let limited_by = text::limited_by(*clearance_limit, plan.margins);
        line(
            "clearance",
            format!("{} or more along the whole path, proven{but_for}{limited_by}", at_least_mm(clearance)),
        );
    }
    for (name, pairs) in text::not_checked(&plan.not_checked) {
        line(name, pairs);
    }
    if !plan.waypoints.is_empty() {
        let points = counted(plan.waypoints.len(), "way point");
        let length = cranny_file::at_most(plan.path_length, 1.0, 3);
        line("path", format!("{points}, length {length}{}", beyond_least(plan)));
    }
    if let Some(robustness) = &plan.robustness {
        line("robust", robust(robustness));
    }
    if let Some(value) = held(plan) {
        line("holds", value);
    }
    if let Some(Tilt { object, greatest_rad, most_rad }) = &plan.tilt {
        let [greatest, most] = [greatest_rad, most_rad].map(|angle| angle.to_degrees());
        line(
            "upright",
            format!("{object} is tilted by {greatest:.1}° at most, of {most:.1}° allowed, proven"),
        );
    }
    for ToolSlack { name, slack_m, slack_rad } in &plan.tool {
        let slack = slack_m.map(at_least_mm).or(slack_rad.map(at_least_degrees)).unwrap_or_default();
        line("tool", format!("{slack} or more within '{name}', proven"));
    }
    let stated = [("straight", straight(plan)), ("carries", carried(plan)), ("puts down", placed(plan))];
    for (name, lines) in stated {
        for value in lines {
            line(name, value);
        }
    }
}

/// Adds the obstacles between the robot and its grasps, the number of grasps that were not tried, and the reason if no grasp was
/// chosen. A planner does not count its own grasps.
fn blocked(plan: &PlanFile, is_own: bool, line: &mut dyn FnMut(&str, String)) {
    let is_tried = |failure: &&GraspFailure| !failure.reason.is_of_budget();
    let tried: Vec<GraspFailure> = plan.failures.iter().filter(is_tried).cloned().collect();
    for (reason, count) in GraspFailure::counted(&tried) {
        let which = if is_own { "own grasps".to_owned() } else { counted(count, "grasp") };
        line("blocked", format!("{which:>11}: {reason}"));
    }
    let left = plan.failures.len() - tried.len();
    if left > 0 && !is_own {
        line("not tried", counted(left, "grasp"));
    }
    let margins = demanded_margins(&Margins { tilt_rad: None, ..plan.margins });
    if !(plan.failures.is_empty() || margins.is_empty()) {
        line("", format!("bodies closer than required count as touching: {}", margins.join(", ")));
    }
    if let Some(reason) = &plan.no_grasp {
        no_grasp(reason, line);
    }
    if let Some(refused) = &plan.refused {
        line("refused", refused.to_string());
    }
}

/// Adds the reason why no grasp was chosen at all, and a remedy.
fn no_grasp(reason: &NoGrasp, line: &mut dyn FnMut(&str, String)) {
    match reason {
        NoGrasp::TooWide(too_wide) => line("too wide", too_wide.to_string()),
        NoGrasp::OutOfReach(miss) => {
            let nearest =
                miss.grasp.map_or_else(|| "a sampled grasp".to_owned(), |grasp| format!("grasp {grasp}"));
            let beyond = match miss.beyond_m {
                beyond_m if beyond_m > 0.0 => format!(", {} or more beyond reach", at_least_mm(beyond_m)),
                _ => String::new(),
            };
            let (missed, turned) = (at_most_mm(miss.missed_by_m), at_most_degrees(miss.turned_by_rad));
            let joints = match &miss.joints_at_limits[..] {
                [] => "no joint at its limit".to_owned(),
                joints => format!("joints at their limits: {}", joints.join(", ")),
            };
            line(
                "reach",
                format!("nearest is {nearest}{beyond}: the arm misses it by {missed}, {turned}, {joints}"),
            );
            if let Some([x, y]) = miss.base_shift_m {
                let shift = format!("{x:+.2} m along x and {y:+.2} m along y of its own frame");
                line("hint", format!("with the base moved by {shift}, a grasp has a free configuration"));
            }
        }
        NoGrasp::BaseEnclosed(BaseEnclosure { joints, region_m, blocked_by, beyond_m, squares }) => {
            let within = joints.iter().zip(region_m);
            let within =
                within.map(|(joint, [lower, upper])| format!("{joint} in [{lower:.3}, {upper:.3}] m"));
            line(
                "proven",
                format!(
                    "no path exists: the base stays within {}, and from there every goal is {} or more beyond reach",
                    within.collect::<Vec<_>>().join(", "),
                    at_least_mm(*beyond_m)
                ),
            );
            let walls = blocked_by.iter().map(|[link, body]| format!("{link}–{body}"));
            let walls = walls.collect::<Vec<_>>().join(", ");
            line("", format!("blocked by {walls}; {squares} squares compared"));
        }
        _ => {}
    }
}

/// Returns the printed text of an answer; `grasps` are those of its problem.
pub fn page(answered: &Answered, grasps: &GraspSet) -> String {
    let Answered { plan, .. } = answered;
    let statistics = &plan.statistics;
    let mut page = format!(
        "{}: {} by {} in {} (criterion {}, seed {})\n",
        plan.scenario,
        if plan.outcome == Outcome::Solved && plan.tries.last().is_some_and(|last| !last.as_planned) {
            "solved, but in no attempt as planned in physics,"
        } else {
            plan.outcome.name()
        },
        plan.planner,
        text::seconds(answered.planning_time_s),
        plan.criterion.name(),
        plan.seed
    );
    let mut line = |name: &str, value: String| {
        let _ = writeln!(page, "  {name:<12}{value}");
    };
    about_path(answered, grasps, &mut line);
    for tried in &plan.tries {
        let PlanAttempt { seed, outcome, as_planned, .. } = tried;
        let result = if *as_planned { "as planned" } else { "not as planned" };
        line("physics", format!("seed {seed}: {outcome}, {result}"));
    }
    line("search", searched(statistics));
    if statistics.ik_attempts > 0 {
        let attempts = counted(statistics.ik_attempts, "IK attempt");
        let goals = counted(statistics.goals_tried, "free goal configuration");
        line("goals", format!("{goals} found, {attempts}"));
    }
    line("time", times(answered));
    if let (Some(shortening), Some(seconds)) = (&plan.shortening, answered.shortcut_time_s) {
        line("shortened", shortened(shortening, seconds));
    }
    if let Some(optimisation) = &plan.optimisation {
        let kind = optimisation.cost.name();
        for Improvement { cost, iterations, time_s } in milestones(&optimisation.improvements) {
            let iterations = counted(*iterations, "iteration");
            line("cost", format!("{cost:.3} ({kind}) after {time_s:.3} s, {iterations}"));
        }
    }
    blocked(plan, answered.makes_first_grasps, &mut line);
    for (name, value) in answered.obstruction.iter().flat_map(Obstruction::lines) {
        line(name, value);
    }
    for fault in &answered.start_faults {
        line("start", fault.clone());
    }
    let refused = plan.goal_faults.iter().enumerate().flat_map(|(goal, faults)| {
        let number = if plan.goal_faults.len() > 1 { format!("{goal}: ") } else { String::new() };
        faults.iter().map(move |fault| format!("{number}{fault}"))
    });
    let refused: Vec<String> = refused.collect();
    for fault in refused.iter().take(MOST_GOAL_FAULTS) {
        line("goal", fault.clone());
    }
    if refused.len() > MOST_GOAL_FAULTS {
        line("", format!("and {} more; --json lists them all", refused.len() - MOST_GOAL_FAULTS));
    }
    for deviation in &answered.deviations {
        line("note", deviation.clone());
    }
    if plan.outcome == Outcome::Solved && !answered.valid {
        line("judged", "NOT valid; please report this".to_owned());
    }
    let is_spent = matches!(plan.outcome, Outcome::BudgetExhausted | Outcome::ClaimedNotProven);
    if is_spent && plan.no_grasp.is_none() {
        let first = if answered.obstruction.is_some() { "the next view, " } else { "" };
        let limit =
            if answered.is_spent_by_iterations { "more --iterations" } else { "a longer --time-limit" };
        line("hint", format!("{first}{limit}, another --seed or another --planner may find a path"));
    }
    if plan.outcome != Outcome::Solved && answered.plan_file.is_none() {
        line(
            "to see it",
            "plan again with -o FILE, then `cranny view` the scenario with that file".to_owned(),
        );
    }
    if let (Some(timing), Some(seconds)) = (&plan.timing, answered.timing_time_s) {
        line("trajectory", timed(timing, seconds));
    } else if let (true, Some(reason)) = (answered.valid, &answered.untimed) {
        line("trajectory", format!("none: {reason}"));
    }
    if let Some(file) = answered.trajectory_file {
        line("samples in", file.display().to_string());
    }
    if let Some(file) = answered.plan_file {
        line("written to", file.display().to_string());
    }
    page
}
