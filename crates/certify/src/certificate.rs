use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::sync::Arc;

use cranny_collision::Cell;
use cranny_grasp::Grasp;
use cranny_robot::Robot;
use cranny_spatial::{Point, Pose, PoseDifference};
use cranny_task::{Goal, Problem, Segment, Stage, StateSequence, gripper_poses};
use sha2::{Digest as _, Sha256};

use crate::CertifyError;
use crate::enclosure::{Base, Boxes, START_TOLERANCE};
use crate::joint_curve::{Course, JointCurve};
use crate::model::Model;
use crate::pair_tree::PieceProof;
use crate::repeats::folded;
use crate::scene_text::{FORMAT, Rules, line, scene_text};

/// Part of a motion in one cell.
struct Passage {
    cell: Arc<Cell>,
    name: String,
    goal: (String, Pose),
    paths: Vec<(&'static str, Vec<JointCurve>)>,
}

/// Returns the certificate of the motion along the segments of a task, `cranny-certificate/1`. `name` is that of the scenario.
///
/// 1. A scene for each run of segments in one cell: robot, world and rules as that cell has them, and their hash.
/// 2. Its path: along the curves of rounded corners if there are any. A motion in a single scene has a path along its way
///    points, too.
/// 3. For each piece and each pair of objects a tree of intervals and planes (`PieceProof::prove`).
/// 4. Lines that repeat earlier ones, such as the solids of the next scene, refer to them.
///
/// # Errors
/// [`CertifyError`] for a motion that is not proven, or of a kind that certificates do not cover.
pub fn certificate(
    name: &str,
    problem: &Problem,
    stages: &[Stage],
    segments: &[Segment],
) -> Result<String, CertifyError> {
    let mut text = format!("{FORMAT}\n");
    for Passage { cell, name, goal, paths } in passages(name, problem, stages, segments)? {
        let robot = cell.robot();
        let start = paths.first().and_then(|(_, path)| path.first()).map(|piece| piece[0].clone());
        let start = start.unwrap_or_default();
        let start = if text.len() > FORMAT.len() + 1 { start } else { problem.start().to_vec() };
        check_values(robot, &start, &paths)?;
        let model = in_order(&cell)?;
        let scene = scene_text(robot, &model, &Rules { name: &name, start: &start, goals: &[goal] });
        let _ = writeln!(text, "{scene}hash {}", hash_of(&scene));
        for (path, pieces) in &paths {
            let _ = writeln!(text, "path {path}");
            path_lines(&mut text, &cell, &model, (path, pieces))?;
        }
    }
    text.push_str("end\n");
    Ok(folded(&text))
}

/// Returns the certificate that no motion leads from the start of a problem to any of its goals, `cranny-certificate/1`. `name` is
/// that of the scenario.
///
/// 1. The ranges of the slides on which the arm stands are divided into boxes. A box is excluded if two objects touch in all of it,
///    whatever the arm does.
/// 2. No goal is in reach from the boxes that the start remains connected with, or the hand touches the world at it.
///
/// # Errors
/// [`CertifyError::NotExcluded`] if that is not so, or remains undecided; [`CertifyError::NotCovered`] for a problem of another kind.
pub fn impossibility(name: &str, problem: &Problem) -> Result<String, CertifyError> {
    let cell = problem.cell().ok_or_else(|| not_covered("the paper's criterion, which proves nothing"))?;
    let (robot, start) = (cell.robot(), problem.start());
    let goals: Vec<(String, Pose)> = match (problem.goal(), problem.grasp_measure()) {
        (Goal::Grasps(grasps), None) => grasps.grasps().iter().enumerate().flat_map(grasp_goals).collect(),
        (Goal::Configurations(ends), _) => {
            let tip = |q: &Vec<f64>| *robot.frames_at(q).link(robot.tip());
            ends.iter().enumerate().map(|(index, q)| (format!("configuration-{index}"), tip(q))).collect()
        }
        _ => return Err(not_covered("a proof that no motion exists to grasps that a planner may choose")),
    };
    if goals.is_empty() {
        return Err(not_covered("a problem without goals"));
    }
    let model = in_order(cell)?;
    let base = Base::new(cell, &model, start).ok_or(CertifyError::NotExcluded)?;
    let tips = |goals: &[(String, Pose)]| -> Vec<Point> {
        goals.iter().map(|(_, goal)| Point::from(goal.translation.vector)).collect()
    };
    if let Some(boxes) = Boxes::around(&base, &tips(&goals)) {
        return Ok(no_motion(name, &base, &boxes, &goals, &[]));
    }
    let (blocked, left): (Vec<_>, Vec<_>) =
        goals.into_iter().map(|goal| (base.blocked_at(&goal.1), goal)).partition(|(mark, _)| mark.is_some());
    let marks: Vec<String> = blocked.iter().filter_map(|(mark, _)| mark.clone()).collect();
    let left: Vec<(String, Pose)> = left.into_iter().map(|(_, goal)| goal).collect();
    let boxes = if left.is_empty() { Some(Boxes::whole(&base)) } else { Boxes::around(&base, &tips(&left)) };
    let boxes = boxes.filter(|_| !marks.is_empty()).ok_or(CertifyError::NotExcluded)?;
    let goals: Vec<(String, Pose)> = blocked.into_iter().map(|(_, goal)| goal).chain(left).collect();
    Ok(no_motion(name, &base, &boxes, &goals, &marks))
}

/// Returns the certificate that no motion leads to some grasps of a problem, by their indices, `cranny-certificate/1`: those at which
/// a point is found that the hand and the world have in common, or that are beyond reach from everywhere. `name` is that of the
/// scenario.
///
/// # Errors
/// [`CertifyError::NoneImpossible`] if there are none; [`CertifyError::NotCovered`] for a problem of another kind.
pub fn impossible_grasps(name: &str, problem: &Problem) -> Result<(String, Vec<usize>), CertifyError> {
    let cell = problem.cell().ok_or_else(|| not_covered("the paper's criterion, which proves nothing"))?;
    let (Goal::Grasps(grasps), None) = (problem.goal(), problem.grasp_measure()) else {
        return Err(not_covered("a proof about grasps that a planner may choose"));
    };
    let model = in_order(cell)?;
    let base = Base::new(cell, &model, problem.start()).ok_or(CertifyError::NotExcluded)?;
    let is_beyond = |goal: &Pose| base.is_beyond_all(&Point::from(goal.translation.vector));
    let (mut blocked, mut marks, mut beyond, mut indices) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for (index, grasp) in grasps.grasps().iter().enumerate() {
        let goals = grasp_goals((index, grasp));
        if is_beyond(&grasp.world_from_gripper) {
            beyond.extend(goals);
        } else if let Some(of_goals) =
            goals.iter().map(|(_, goal)| base.blocked_at(goal)).collect::<Option<Vec<String>>>()
        {
            blocked.extend(goals);
            marks.extend(of_goals);
        } else {
            continue;
        }
        indices.push(index);
    }
    if indices.is_empty() {
        return Err(CertifyError::NoneImpossible);
    }
    let goals = [blocked, beyond].concat();
    Ok((no_motion(name, &base, &Boxes::whole(&base), &goals, &marks), indices))
}

/// Returns the goals of a grasp: its pose, and that with the fingers exchanged.
fn grasp_goals((index, grasp): (usize, &Grasp)) -> Vec<(String, Pose)> {
    let [own, turned] = gripper_poses(grasp);
    let turned = (!grasp.has_no_twin).then(|| (format!("grasp-{index}-half-turn"), turned));
    std::iter::once((format!("grasp-{index}"), own)).chain(turned).collect()
}

fn in_order(cell: &Cell) -> Result<Model, CertifyError> {
    let model = Model::of(cell);
    if model.is_in_order() {
        return Ok(model);
    }
    Err(not_covered("a robot that lists a finger before its tip, which a joint moves"))
}

/// Returns the text of a certificate that no motion leads to a goal; the first goals are blocked, by these marks.
fn no_motion(
    name: &str,
    base: &Base<'_>,
    boxes: &Boxes,
    goals: &[(String, Pose)],
    marks: &[String],
) -> String {
    let scene = scene_text(base.cell.robot(), base.model, &Rules { name, start: base.start, goals });
    let mut text = format!("{FORMAT}\n{scene}hash {}\n", hash_of(&scene));
    line(&mut text, &format!("none {}", base.link), &base.axis_points);
    let _ = writeln!(text, "boxes{}", boxes.marks(base));
    for (goal, mark) in marks.iter().enumerate() {
        let _ = writeln!(text, "blocked {goal} {mark}");
    }
    text.push_str("end\n");
    text
}

/// Divides a motion into runs in one cell.
fn passages(
    name: &str,
    problem: &Problem,
    stages: &[Stage],
    segments: &[Segment],
) -> Result<Vec<Passage>, CertifyError> {
    if problem.cell().is_none() {
        return Err(not_covered("the paper's criterion, which proves nothing"));
    }
    let along = StateSequence::of(problem, stages, segments).ok().flatten();
    let Some(along) = along.filter(|along| along.stopped.is_none() && along.states.len() == segments.len())
    else {
        return Err(not_covered("a task that is not carried out to its end"));
    };
    let Course { way_points, rounded } = Course::of(segments);
    let has_corners = segments.iter().any(|segment| !segment.corners.is_empty());
    let executed = if has_corners { &rounded } else { &way_points };
    let path = if has_corners { "rounded" } else { "way-points" };
    let cell_of = |segment: usize| along.states[segment].cell();
    let mut picks = along.picks.iter();
    let mut passages: Vec<Passage> = Vec::new();
    let runs: Vec<&[(usize, JointCurve)]> =
        executed.chunk_by(|a, b| Arc::ptr_eq(cell_of(a.0), cell_of(b.0))).collect();
    for run in &runs {
        let (Some((_, first)), Some((segment, last))) = (run.first(), run.last()) else { continue };
        let cell = cell_of(*segment).clone();
        let end = last.last().unwrap_or(&first[0]);
        let tip = *cell.robot().frames_at(end).link(cell.robot().tip());
        let is_of_grasp = !segments[*segment].mode.holds
            && segments.get(segment + 1).map_or(passages.is_empty(), |next| next.mode.holds);
        let mode = segments[*segment].mode.name;
        let goal = match picks.next().filter(|_| is_of_grasp) {
            Some(picking) => goal_at(picking, &tip)?,
            None => (format!("end-of-{mode}"), tip),
        };
        let name = if runs.len() > 1 { format!("{name}/{mode}") } else { name.to_owned() };
        let pieces = run.iter().map(|(_, piece)| piece.clone()).collect();
        passages.push(Passage { cell, name, goal, paths: vec![(path, pieces)] });
    }
    match &mut passages[..] {
        [] => Err(not_covered("a path without an edge")),
        [whole] if has_corners => {
            whole.paths.insert(0, ("way-points", way_points.into_iter().map(|(_, edge)| edge).collect()));
            Ok(passages)
        }
        _ => Ok(passages),
    }
}

/// Appends the pieces of a path with their proofs.
fn path_lines(
    text: &mut String,
    cell: &Cell,
    model: &Model,
    (path, pieces): (&'static str, &[JointCurve]),
) -> Result<(), CertifyError> {
    let mut outside: BTreeSet<(usize, usize, usize, usize)> = BTreeSet::new();
    let name = |index: usize| model.objects[index].name.clone();
    for (edge, curve) in pieces.iter().enumerate() {
        text.push_str("piece\n");
        for q in curve {
            line(text, "q", q);
        }
        let mut proof = PieceProof::new(cell, model, curve);
        for pair in &model.pairs {
            let ((a, b), margin_m) = *pair;
            let tree = proof.prove(*pair).map_err(|stuck| CertifyError::NotApart {
                path,
                edge,
                first: name(a),
                second: name(b),
                margin_m,
                at: stuck.at,
            })?;
            let _ = writeln!(text, "p {}", tree.marks);
            outside.extend(tree.outside.iter().map(|(i, j)| (a, b, *i, *j)));
        }
        for bound in &model.bounds {
            let marks = proof.prove_bound(bound).map_err(|stuck| CertifyError::NotKept {
                path,
                edge,
                bound: bound.name.clone(),
                at: stuck.at,
            })?;
            let _ = writeln!(text, "b {marks}");
        }
    }
    for ((a, b), _) in &model.pairs {
        for (i, of_a) in model.objects[*a].solids.iter().enumerate() {
            for (j, of_b) in model.objects[*b].solids.iter().enumerate() {
                let is_mesh = of_a.faces() > 0 || of_b.faces() > 0;
                if is_mesh && !outside.contains(&(*a, *b, i, j)) {
                    return Err(CertifyError::NotOutside { first: name(*a), second: name(*b) });
                }
            }
        }
    }
    Ok(())
}

fn hash_of(scene: &str) -> String {
    Sha256::digest(scene.as_bytes()).iter().fold(String::new(), |mut hash, byte| {
        let _ = write!(hash, "{byte:02x}");
        hash
    })
}

fn not_covered(what: &str) -> CertifyError {
    CertifyError::NotCovered { what: what.to_owned() }
}

/// Checks the limits of all control points, and the start.
fn check_values(
    robot: &Robot,
    start: &[f64],
    paths: &[(&'static str, Vec<JointCurve>)],
) -> Result<(), CertifyError> {
    let joint = |index: usize| robot.joint_names()[index].clone();
    let mut points = paths.iter().flat_map(|(_, path)| path).flatten();
    if let Some(violation) = points.find_map(|q| robot.first_limit_violation(q)) {
        return Err(CertifyError::Limit { joint: joint(violation.joint), value: violation.value });
    }
    let first = paths.first().and_then(|(_, path)| path.first()).map_or(start, |piece| &piece[0]);
    let off = first.iter().zip(start).map(|(a, b)| (a - b).abs()).enumerate();
    match off.max_by(|a, b| a.1.total_cmp(&b.1)) {
        Some((index, off)) if off > START_TOLERANCE => Err(CertifyError::Start { joint: joint(index), off }),
        _ => Ok(()),
    }
}

/// Returns the goal at which the tip has arrived, with its name.
fn goal_at(problem: &Problem, tip: &Pose) -> Result<(String, Pose), CertifyError> {
    match (problem.goal(), problem.grasp_measure()) {
        (Goal::Grasps(grasps), None) => {
            let arrived = |index: &usize| problem.is_arrival(&grasps.grasps()[*index].difference(tip));
            let index = grasps.by_score().into_iter().find(arrived).ok_or(CertifyError::Goal)?;
            // The hand may be turned by half a turn about its approach.
            let (grasp, turned) = (&grasps.grasps()[index], grasps.grasps()[index].twin());
            let off = |pose: &Pose| PoseDifference::between(pose, tip).rotation_rad;
            if off(&grasp.world_from_gripper) <= off(&turned.world_from_gripper) {
                Ok((format!("grasp-{index}"), grasp.world_from_gripper))
            } else {
                Ok((format!("grasp-{index}-half-turn"), turned.world_from_gripper))
            }
        }
        (Goal::Configurations(_), None) => Ok(("configuration".to_owned(), *tip)),
        _ => Ok(("own-grasp".to_owned(), *tip)),
    }
}
