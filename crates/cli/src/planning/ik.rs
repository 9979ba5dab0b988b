use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::atomic::Ordering;

use cranny_file::counted;
use cranny_grasp::{Grasp, GraspSet};
use cranny_scenario::BlockedGripperFrame;
use cranny_task::{
    AnnotatedSolution, FailureReason, Goal, IkAnnotation, IkAnnotationSettings, IkMethod, IkStatus, Problem,
    annotate_ik, hand_collides,
};
use serde::Serialize;

use crate::Answer;
use crate::arguments::{IkArguments, Output};
use crate::failure::Failure;
use crate::planning::task::{Demand, Task};
use crate::progress::{bar, stop_on_interrupt};
use crate::statements::demanded_margins;
use crate::text::{self, degrees, millimetres};

/// Output of `ik --json`; its keys are stable.
#[derive(Serialize)]
struct Answered<'a> {
    scenario: &'a str,
    solved: usize,
    /// True if Ctrl-C left grasps unprocessed.
    stopped: bool,
    grasps: Vec<Annotated<'a>>,
}

#[derive(Serialize)]
struct Annotated<'a> {
    grasp: usize,
    status: &'static str,
    /// True if it is proven that no free configuration exists at the grasp.
    proven_impossible: bool,
    blocked_by: Option<String>,
    attempts: usize,
    solutions: &'a [AnnotatedSolution],
}

pub fn run(arguments: &IkArguments, output: Output) -> Result<Answer, Failure> {
    let Task { scenario, mut problem, .. } = Task::open(&arguments.task, Demand::default(), output)?;
    if scenario.grasps.is_empty() {
        let problem =
            "ik searches at given grasps, and there are none (`grasps sample` makes a file of them)";
        return Err(Failure::Flag { flag: "grasps", problem: problem.to_owned() });
    }
    if let Some(grasp) = arguments.grasp {
        let Some(chosen) = scenario.grasps.grasps().get(grasp) else {
            let problem = text::only_so_many(scenario.grasps.len(), "grasp");
            return Err(Failure::Flag { flag: "grasp", problem });
        };
        let only = GraspSet::new(vec![*chosen]).map_err(cranny_scenario::ScenarioError::from)?;
        problem = problem.with_goal(Goal::Grasps(only))?;
    }
    let settings = IkAnnotationSettings {
        method: if arguments.single_shot { IkMethod::SingleShot } else { IkMethod::Restarts },
        solutions: arguments.solutions,
        attempts: arguments.attempts,
        seed: arguments.seed,
    };
    let stop = stop_on_interrupt();
    let count = if arguments.grasp.is_some() { 1 } else { scenario.grasps.len() };
    let progress = bar(count as u64, output.quiet);
    let mut annotations = annotate_ik(&problem, &settings, &|| progress.inc(1), &stop)?;
    progress.finish_and_clear();
    let is_stopped = stop.load(Ordering::Relaxed);
    if let Some(grasp) = arguments.grasp {
        for annotation in &mut annotations {
            annotation.grasp = grasp;
        }
    }
    let is_unfit = |grasp: &&Grasp| FailureReason::of_width(problem.robot(), grasp).is_some();
    let unfit = problem.grasps().map_or(0, |grasps| grasps.grasps().iter().filter(is_unfit).count());
    if unfit > 0 && !output.quiet {
        let grasps = counted(unfit, "grasp");
        text::note(&format!("{grasps} of a width that the hand cannot take: `plan` leaves such grasps out"))?;
    }
    let solved = annotations.iter().filter(|a| a.status == IkStatus::Solved).count();
    if solved == 0 && !output.quiet {
        filled_hand(&problem)?;
    }
    let grasps = annotations.iter().map(annotated).collect();
    let answered = Answered { scenario: &scenario.id, solved, stopped: is_stopped, grasps };
    let margins = problem.cell().map_or_else(Vec::new, |cell| demanded_margins(&cell.margins()));
    text::answer(&answered, || page(&scenario.id, &annotations, solved, &margins), output)?;
    // An incomplete run is not a positive answer, even if the processed grasps have solutions.
    Ok(if solved > 0 && !is_stopped { Answer::Done } else { Answer::No })
}

/// Prints the reason why no grasp can be free, if the hand itself is the reason.
pub fn filled_hand(problem: &Problem) -> Result<(), Failure> {
    BlockedGripperFrame::of(problem.robot()).map_or(Ok(()), |filled| text::note(&filled.to_string()))
}

fn blocked_by(status: &IkStatus) -> Option<String> {
    match status {
        IkStatus::HandCollides { link, body, .. } => Some(format!("{link} against {body}")),
        IkStatus::NoSolution { contact: Some((first, second)), .. } => {
            Some(format!("{first} against {second}"))
        }
        _ => None,
    }
}

fn annotated(annotation: &IkAnnotation) -> Annotated<'_> {
    Annotated {
        grasp: annotation.grasp,
        status: annotation.status.name(),
        proven_impossible: annotation.status.is_proven_impossible(),
        blocked_by: blocked_by(&annotation.status),
        attempts: annotation.attempts,
        solutions: &annotation.solutions,
    }
}

fn attempts(annotation: &IkAnnotation) -> String {
    counted(annotation.attempts, "attempt")
}

fn page(id: &str, annotations: &[IkAnnotation], solved: usize, margins: &[String]) -> String {
    let mut page =
        format!("{id}: a free exact configuration for {solved} of {}\n", counted(annotations.len(), "grasp"));
    let mut reasons: BTreeMap<String, usize> = BTreeMap::new();
    for annotation in annotations {
        let reason = match &annotation.status {
            IkStatus::Solved => continue,
            IkStatus::HandCollides { link, body, is_proven } => hand_collides(link, body, *is_proven),
            IkStatus::OutOfReach { .. } => "out of reach from every position of the base".to_owned(),
            IkStatus::NoSolution { blocked: 0, .. } => {
                format!("the arm did not reach the pose in {}", attempts(annotation))
            }
            IkStatus::NoSolution { .. } => format!(
                "the arm reached the pose, but never without a collision in {}; the last: {}",
                attempts(annotation),
                blocked_by(&annotation.status).unwrap_or_default()
            ),
            IkStatus::Stopped => "stopped before it was tried".to_owned(),
        };
        *reasons.entry(reason).or_default() += 1;
    }
    let impossible = annotations.iter().filter(|a| a.status.is_proven_impossible()).count();
    if solved < annotations.len() {
        let undecided = annotations.len() - solved - impossible;
        let _ = writeln!(page, "  of the others {impossible} are proven impossible, {undecided} undecided");
    }
    for (reason, count) in reasons {
        let _ = writeln!(page, "  {count:>4}  {reason}");
    }
    if solved < annotations.len() && !margins.is_empty() {
        let margins = margins.join(", ");
        let _ = writeln!(page, "  bodies closer than required count as touching: {margins}");
    }
    if let [annotation] = annotations {
        for s in &annotation.solutions {
            let (translation, rotation) = (s.translation_error_m, s.rotation_error_rad);
            let _ = writeln!(
                page,
                "  {} off, {}, clearance {}: {:.4?}",
                millimetres(translation),
                degrees(rotation),
                millimetres(s.clearance_m),
                s.q
            );
        }
    }
    page
}
