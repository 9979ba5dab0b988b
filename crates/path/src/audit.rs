use std::ops::Range;

use cranny_collision::{Cell, Collider, Contact, MeasureOptions, Motion, NearestPair, Scratch};
use cranny_grasp::GraspSet;
use cranny_robot::{between, distance};
use cranny_spatial::PoseDifference;
use cranny_task::{FoundGrasp, Goal, NotChecked, Problem, Region, Validity};
use rayon::prelude::*;
use serde::Serialize;

use crate::audit_limits::{START_TOLERANCE, first_violations, joint_offset};
use crate::clearance_limit::ClearanceLimit;
use crate::grasp_judge::GraspJudge;
use crate::step::{RELEASED_STEP_M, Stepper};
use crate::{AuditLimits, Cause, GoalError, Location, PathError, PickAudit, Violation};

/// Verdict on a path.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Audit {
    /// True if the path meets the criterion, that is, has no violation.
    pub valid: bool,
    /// Violations in path order, up to [`AuditLimits::violations`] or a few more. The first thousand or so faulty edges list
    /// every pair in contact, further ones a single pair. The edges of a path far beyond a joint limit are not judged.
    pub violations: Vec<Violation>,
    /// Error at the end of the path relative to the nearest grasp.
    pub goal: Option<GoalError>,
    /// Grasp at the end of the path, if the problem gives no set of grasps and the hand grasps the target there.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub own_grasp: Option<FoundGrasp>,
    /// Grasps of all picks of a task with several picks; `goal` and `own_grasp` are those of the first.
    #[serde(skip_serializing_if = "is_one_pick")]
    pub picks: Vec<PickAudit>,
    /// Clearance of the whole path in metres, a certified lower bound (`exact` only); `None` if nothing can collide.
    pub clearance_m: Option<f64>,
    /// Pair that limits the clearance; `None` if the clearance is 0, infinite, or not measured per edge.
    pub clearance_limit: Option<ClearanceLimit>,
    /// Clearance of each edge in metres, a certified lower bound (`exact` only); 0 for an edge that is not proven. Empty if the
    /// audit ended before the last edge.
    pub clearances_per_edge_m: Vec<Option<f64>>,
    /// Pairs in contact that were not checked (`exact` only). The verdict excludes these.
    pub not_checked: Vec<NotChecked>,
}

impl Audit {
    /// Returns the verdict on a path that is not judged beyond these violations.
    pub(crate) fn ended(problem: &Problem, violations: Vec<Violation>, settings: AuditSettings) -> Self {
        let is_measured = problem.cell().is_some() && settings.clearances != Clearances::None;
        Self { violations, clearance_m: is_measured.then_some(0.0), ..Self::empty() }
    }

    /// Returns the score of the grasp at which the path ends, or `None` if there is none or it has no score.
    pub fn grasp_score(&self, problem: &Problem) -> Option<f64> {
        let given = || problem.grasps()?.grasps()[self.goal?.grasp].score;
        self.own_grasp.map_or_else(given, |grasp| Some(grasp.score))
    }

    /// Returns the verdict on an empty motion.
    pub fn empty() -> Self {
        Self {
            valid: false,
            violations: Vec::new(),
            goal: None,
            own_grasp: None,
            picks: Vec::new(),
            clearance_m: None,
            clearance_limit: None,
            clearances_per_edge_m: Vec::new(),
            not_checked: Vec::new(),
        }
    }

    /// Adds the result of a pick; the first one also sets `goal` and `own_grasp`.
    pub(crate) fn add_pick(&mut self, pick: PickAudit) {
        if self.picks.is_empty() {
            (self.goal, self.own_grasp) = (pick.goal, pick.own_grasp);
        }
        self.picks.push(pick);
    }

    /// Adds a violation for each stated grasp (with the stage of its pick) that differs from the measured grasp.
    #[must_use]
    pub fn with_stated_grasps(mut self, stated: &[(usize, FoundGrasp)]) -> Self {
        for (stage, grasp) in stated {
            let Some(pick) = self.picks.iter().find(|pick| pick.stage == *stage) else { continue };
            let way_point = pick.way_point;
            if let Some(measured) = pick.own_grasp.filter(|measured| !measured.agrees_with(grasp)) {
                let stated_and_measured = Box::new([*grasp, measured]);
                let cause = Cause::StatedGrasp { stated_and_measured };
                self.violations.push(Violation::at_way_point(way_point, cause));
                self.valid = false;
            }
        }
        self
    }
}

fn is_one_pick(picks: &[PickAudit]) -> bool {
    picks.len() < 2
}

/// Returns the length of a path of way points (m, rad; one value per joint): the sum of the L2 lengths of its edges in
/// configuration space (m and rad mixed).
pub fn path_length(path: &[Vec<f64>]) -> f64 {
    path.windows(2).map(|edge| distance(&edge[0], &edge[1])).fold(0.0, |sum, length| sum + length)
}

/// Settings of an audit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AuditSettings {
    /// True if the path must end at a goal. Default: true.
    pub at_goal: bool,
    /// Clearances to measure. Default: those of edges.
    pub clearances: Clearances,
    /// Limits of the path and of the audit. Default: [`AuditLimits::default`].
    pub limits: AuditLimits,
}

/// Clearances to measure in addition to the verdict, under the exact criterion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clearances {
    /// No clearances: takes a fraction of the time of the other choices.
    None,
    /// Clearance of the whole path, a certified lower bound at most a tenth (and 10 µm) below the true value.
    OfPath,
    /// Clearance of every edge, certified lower bounds at most 10 µm below the true values: a few milliseconds per edge.
    OfEdges,
}

/// Relative slack of the lower bound of the clearance of a path.
const PATH_SHARE: f64 = 0.1;

impl Default for AuditSettings {
    fn default() -> Self {
        Self { at_goal: true, clearances: Clearances::OfEdges, limits: AuditLimits::default() }
    }
}

/// Audits a path of way points (m, rad; one value per joint) from any source by the criterion of `problem`, as [`audit_with`]
/// with the default settings.
///
/// # Errors
/// As [`audit_with`].
pub fn audit(problem: &Problem, path: &[Vec<f64>]) -> Result<Audit, PathError> {
    audit_with(problem, path, AuditSettings::default())
}

/// Audits a path of way points (m, rad; one value per joint) from any source by the criterion of `problem`. The verdict does
/// not depend on `settings.clearances`, except that a measured clearance can refute the proof of its edge.
///
/// 1. The path begins at the start.
/// 2. Every way point is within the joint limits; if one is more than 10 m or rad beyond, the audit ends here.
/// 3. Under `exact` every edge is proven, for every pair of links that is free at any way point. Under `paper` every way point
///    except the first and the last (the released planners do not check a goal root) passes the released check, and no edge is
///    longer than the step of those planners.
/// 4. The path ends at a goal, if `at_goal` is set. Without a set of grasps, it ends in a grasp of the target with a sufficient
///    score on the target surface, and the closing motion of the fingers is proven.
///
/// # Errors
/// [`TaskError::JointCount`](cranny_task::TaskError::JointCount) or [`TaskError::NotFinite`](cranny_task::TaskError::NotFinite)
/// for a way point that is not a configuration of the robot, [`PathError::EmptyPath`] for a path without way points,
/// [`PathError::TooManyWayPoints`] and [`PathError::TooMuchTravel`] for a path beyond [`AuditSettings::limits`].
pub fn audit_with(problem: &Problem, path: &[Vec<f64>], settings: AuditSettings) -> Result<Audit, PathError> {
    // 1. and 2.
    let (mut violations, is_over) = first_violations(problem, path, settings.limits)?;
    let (Some(first), Some(last)) = (path.first(), path.last()) else { return Err(PathError::EmptyPath) };
    if is_over {
        return Ok(Audit::ended(problem, violations, settings));
    }
    let most = settings.limits.violations;
    // 3.
    let (mut clearances_per_edge_m, mut clearance_m, mut clearance_limit) = (Vec::new(), None, None);
    let mut not_checked = Vec::new();
    match problem.validity() {
        Validity::Exact(cell) => {
            not_checked = NotChecked::of(cell);
            violations.extend(cell.standing_contact().map(|contact| {
                let Contact { clearance_m, required_m, .. } = contact;
                let at = Location::of_contact(cell, 0, 0.0, &contact);
                Violation { at, cause: Cause::Clearance { clearance_m, required_m } }
            }));
            // A path of one way point is audited as an edge of zero length.
            let single = [first.clone(), first.clone()];
            let path = if path.len() == 1 { &single[..] } else { path };
            let mut faulty = 0;
            // A batch of one thread ends at the first violation.
            let at_once = if most == 1 { EDGES_PER_THREAD } else { EDGES_AT_ONCE };
            for begin in (0..path.len() - 1).step_by(at_once) {
                if violations.len() >= most {
                    break;
                }
                let detail = if faulty < MOST_DETAILED { Detail::EveryPair } else { Detail::FirstPair };
                let edges = begin..(begin + at_once).min(path.len() - 1);
                for (found, measured) in judge_edges(cell, path, edges, settings, detail) {
                    let measured = measured.filter(|(least_m, _)| least_m.is_finite());
                    let least_m = measured.map(|(least_m, _)| least_m);
                    if let Some((least_m, nearest)) =
                        measured.filter(|(m, _)| clearance_m.is_none_or(|least| *m < least))
                    {
                        clearance_m = Some(least_m);
                        clearance_limit = nearest.map(|nearest| ClearanceLimit::of(cell, &nearest));
                    }
                    if settings.clearances == Clearances::OfEdges {
                        clearances_per_edge_m.push(least_m);
                    }
                    faulty += usize::from(found.is_err());
                    violations.extend(found.err().into_iter().flatten());
                }
            }
            if clearances_per_edge_m.len() < path.len() - 1 {
                clearances_per_edge_m.clear();
            }
            if settings.clearances == Clearances::OfPath {
                let is_proven = faulty == 0 && violations.len() < most;
                let measured = || cell.path_clearance(path, PATH_SHARE, &mut cell.scratch());
                clearance_m = Some(if is_proven { measured() } else { 0.0 });
                clearance_m = clearance_m.filter(|found| found.is_finite());
            }
        }
        Validity::Paper { check, .. } => {
            let mut scratch = check.scratch();
            let mut stepper = Stepper::new(problem.robot());
            for (edge, pair) in path.windows(2).enumerate() {
                if violations.len() >= most {
                    break;
                }
                let moved_m = stepper.displacement_between(problem.robot(), &pair[0], &pair[1]);
                if moved_m > RELEASED_STEP_M * (1.0 + 1e-9) {
                    let excess_m = moved_m - RELEASED_STEP_M;
                    violations.push(Violation::at_way_point(edge, Cause::Step { excess_m }));
                }
            }
            for (way_point, q) in path.iter().enumerate().take(path.len() - 1).skip(1) {
                if violations.len() >= most {
                    break;
                }
                if problem.robot().within_limits(q) && !check.is_free(q, &mut scratch) {
                    violations.push(Violation::at_way_point(way_point, Cause::NotFree));
                }
            }
        }
    }
    // 4.
    let end = End { way_point: path.len() - 1, q: last, must_arrive: settings.at_goal };
    let is_over = violations.len() >= most;
    let (goal, own_grasp) = if is_over { (None, None) } else { judge_end(problem, &end, &mut violations) };
    let valid = violations.is_empty();
    Ok(Audit {
        valid,
        violations,
        goal,
        own_grasp,
        picks: vec![PickAudit { stage: 0, goal, own_grasp, way_point: path.len() - 1 }],
        clearance_m,
        clearance_limit,
        clearances_per_edge_m,
        not_checked,
    })
}

struct End<'a> {
    way_point: usize,
    q: &'a [f64],
    /// True if it must be at a goal.
    must_arrive: bool,
}

/// Judges the end of a path: returns the nearest of the given grasps, or the grasp that the hand takes there.
fn judge_end(
    problem: &Problem,
    end: &End,
    violations: &mut Vec<Violation>,
) -> (Option<GoalError>, Option<FoundGrasp>) {
    let End { way_point, q: last, must_arrive } = *end;
    let mut own_grasp = None;
    let goal = match (problem.goal(), problem.grasp_measure()) {
        (_, Some(measure)) => {
            match GraspJudge::new(measure).grasp_at(last) {
                Ok(grasp) => own_grasp = Some(grasp),
                Err(cause) if must_arrive => violations.push(Violation::at_way_point(way_point, cause)),
                Err(_) => {}
            }
            None
        }
        (Goal::Grasps(grasps), None) => {
            let end = end_at_grasp(problem, grasps, last);
            let nearest = end.map(|(grasp, difference)| GoalError {
                grasp,
                translation_error_m: difference.translation_m,
                rotation_error_rad: difference.rotation_rad,
            });
            let has_arrived = end.is_some_and(|(_, difference)| problem.is_arrival(&difference));
            if must_arrive && !has_arrived {
                violations.push(Violation::at_way_point(way_point, Cause::Grasp { nearest }));
            }
            nearest
        }
        (Goal::Regions(regions), None) => {
            let robot = problem.robot();
            let pose = *robot.frames_at(last).link(robot.tip());
            let fault = Region::fault_of_all(regions, |_| Some(pose)).filter(|_| must_arrive);
            violations
                .extend(fault.map(|fault| Violation::at_way_point(way_point, Cause::NotThere { fault })));
            None
        }
        (Goal::Configurations(goals), None) => {
            // A goal is as far away as its joint with the largest offset; the nearest goal is reported.
            let worst = |goal: &Vec<f64>| {
                let off = goal.iter().zip(last).enumerate();
                let off = off.map(|(joint, (a, b))| (joint, problem.robot().joint_difference(joint, *a, *b)));
                off.max_by(|a, b| a.1.total_cmp(&b.1))
            };
            let nearest = goals.iter().filter_map(worst).min_by(|a, b| a.1.total_cmp(&b.1));
            if let Some((joint, off)) = nearest.filter(|(_, off)| must_arrive && *off > START_TOLERANCE) {
                let cause = Cause::Configuration { farthest: joint_offset(problem, joint, off) };
                violations.push(Violation::at_way_point(way_point, cause));
            }
            None
        }
    };
    (goal, own_grasp)
}

/// Returns the score of the grasp at which a path ends, or `None` if it ends at none.
pub(crate) fn end_score(problem: &Problem, q: &[f64]) -> Option<f64> {
    if let Some(measure) = problem.grasp_measure() {
        return GraspJudge::new(measure).grasp_at(q).ok().map(|grasp| grasp.score);
    }
    let grasps = problem.grasps()?;
    grasps.grasps()[end_at_grasp(problem, grasps, q)?.0].score
}

/// Returns the error of the gripper at `q` (m, rad; one per joint) relative to a grasp; `None` unless it has arrived there.
///
/// # Panics
/// If `q` does not have one value per joint.
pub fn arrival_at(problem: &Problem, grasp: usize, q: &[f64]) -> Option<GoalError> {
    let frames = problem.robot().frames_at(q);
    let difference = problem.grasps()?.grasps().get(grasp)?.difference(frames.link(problem.robot().tip()));
    let PoseDifference { translation_m, rotation_rad } = difference;
    let found = GoalError { grasp, translation_error_m: translation_m, rotation_error_rad: rotation_rad };
    problem.is_arrival(&difference).then_some(found)
}

/// Returns the grasp at which the path ends: under `exact` the best-scored one where the gripper has arrived, else the nearest.
fn end_at_grasp(problem: &Problem, grasps: &GraspSet, q: &[f64]) -> Option<(usize, PoseDifference)> {
    let frames = problem.robot().frames_at(q);
    let gripper = frames.link(problem.robot().tip());
    let arrived = |&grasp: &usize| {
        let difference = grasps.grasps()[grasp].difference(gripper);
        problem.is_arrival(&difference)
    };
    match grasps
        .by_score()
        .into_iter()
        .find(|g| problem.criterion() == cranny_task::Criterion::Exact && arrived(g))
    {
        Some(grasp) => Some((grasp, grasps.grasps()[grasp].difference(gripper))),
        None => grasps.nearest(gripper),
    }
}

/// Number of edges that are judged in parallel as one batch.
const EDGES_AT_ONCE: usize = 1024;

/// Minimum number of edges per thread: fewer do not justify a thread and its scratch.
const EDGES_PER_THREAD: usize = 128;

/// Approximate number of faulty edges after which only one colliding pair is reported per edge. Finding all pairs takes
/// milliseconds per edge, and a path may have a million edges.
const MOST_DETAILED: usize = 1000;

/// Level of detail reported for an edge in contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Detail {
    /// Every colliding pair, at its deepest sample.
    EveryPair,
    /// One colliding pair, at an end, at the midpoint, or where the proof found it.
    FirstPair,
}

/// Verdict on an edge: proven, or its violations; and its clearance (m) with the nearest pair, if measured.
type JudgedEdge = (Result<(), Vec<Violation>>, Option<(f64, Option<NearestPair>)>);

fn judge_edges(
    cell: &Cell,
    path: &[Vec<f64>],
    edges: Range<usize>,
    settings: AuditSettings,
    detail: Detail,
) -> Vec<JudgedEdge> {
    let judge = |scratch: &mut Scratch, edge: usize| {
        let (a, b) = (&path[edge], &path[edge + 1]);
        let found = judge_edge(cell, edge, [a, b], detail, scratch);
        if settings.clearances != Clearances::OfEdges {
            return (found, None);
        }
        if found.is_err() {
            return (found, Some((0.0, None)));
        }
        let measured = cell.measure_motion([a, b], MeasureOptions::default(), scratch);
        match measured.contradiction {
            Some((at, contact)) => {
                (Err(vec![Violation::unresolved(cell, edge, at, &contact)]), Some((0.0, None)))
            }
            None => (found, Some((measured.least_m, measured.nearest))),
        }
    };
    if edges.len() <= EDGES_PER_THREAD {
        let (mut scratch, mut judged) = (cell.scratch(), Vec::with_capacity(edges.len()));
        for edge in edges {
            judged.push(judge(&mut scratch, edge));
            if settings.limits.violations == 1 && judged.last().is_some_and(|(found, _)| found.is_err()) {
                break;
            }
        }
        return judged;
    }
    edges.into_par_iter().with_min_len(EDGES_PER_THREAD).map_init(|| cell.scratch(), judge).collect()
}

/// Proves an edge, or returns the violations along it; there are none if only joint limits are violated.
fn judge_edge(
    cell: &Cell,
    edge: usize,
    [a, b]: [&[f64]; 2],
    detail: Detail,
    scratch: &mut Scratch,
) -> Result<(), Vec<Violation>> {
    let of_contact = |(along, contact): &(f64, Contact)| Violation::of_contact(cell, edge, *along, contact);
    if detail == Detail::FirstPair {
        // If the ends or the midpoint collide, a proof would only search for the first contact.
        let found = deepest_contacts(cell, [a, b], None, 2, scratch);
        if let Some(first) = found.first() {
            return Err(vec![of_contact(first)]);
        }
    }
    let seed = match cell.motion_is_free(a, b, scratch) {
        Motion::Proven => return Ok(()),
        Motion::Unresolved { at, contact } => {
            return Err(vec![Violation::unresolved(cell, edge, at, &contact)]);
        }
        Motion::Contact { at, contact } => Some((at, contact)),
        Motion::OutOfBounds { at, bound, by } => {
            return Err(vec![Violation::out_of_bounds(cell, (edge, at), bound, by)]);
        }
        // Joint limits are judged at the way points; contacts along the edge are violations all the same.
        Motion::OutOfLimits { .. } => None,
    };
    let contacts = match seed {
        Some(first) if detail == Detail::FirstPair => vec![first],
        None if detail == Detail::FirstPair => Vec::new(),
        seed => deepest_contacts(cell, [a, b], seed, SAMPLES, scratch),
    };
    Err(contacts.iter().map(of_contact).collect())
}

/// Number of intervals into which an edge is divided to find its contacts.
const SAMPLES: u32 = 64;

/// Returns every colliding pair on an edge, each at the deepest of the ends of `pieces` intervals and `seed`.
fn deepest_contacts(
    cell: &Cell,
    [a, b]: [&[f64]; 2],
    seed: Option<(f64, Contact)>,
    pieces: u32,
    scratch: &mut Scratch,
) -> Vec<(f64, Contact)> {
    let mut found: Vec<(f64, Contact)> = Vec::from_iter(seed);
    let mut keep = |at: f64, contact: Contact| {
        let same = |c: &(f64, Contact)| (c.1.first, c.1.second) == (contact.first, contact.second);
        let rank = |c: &Contact| c.depth_m - c.clearance_m;
        match found.iter_mut().find(|c| same(c)) {
            Some(known) if rank(&known.1) >= rank(&contact) => {}
            Some(known) => *known = (at, contact),
            None => found.push((at, contact)),
        }
    };
    for sample in 0..=pieces {
        let at = f64::from(sample) / f64::from(pieces);
        let q: Vec<f64> = between(a, b, at).collect();
        for contact in cell.contacts(&q, scratch) {
            keep(at, contact);
        }
    }
    // Links are listed before bodies, each in ascending order, so that a path always yields the same list.
    let rank = |collider: Collider| match collider {
        Collider::Link(link) => (0, link),
        Collider::Body(body) => (1, body),
    };
    found.sort_by_key(|(_, contact)| (rank(contact.first), rank(contact.second)));
    found
}
