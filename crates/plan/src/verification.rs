use std::ops::Range;

use cranny_collision::{Cell, Collider, Contact, Motion, Scratch};
use cranny_grasp::GraspSet;
use cranny_spatial::{CONTACT_M, PoseDifference};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::step::{RELEASED_STEP_M, Stepper};
use crate::{Goal, NotChecked, PlanError, Problem, Validity};

/// What a judge found in a path.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Verification {
    /// Whether the path meets the criterion: no violation at all.
    pub valid: bool,
    /// What is wrong, in the order of the path: of the first thousand edges that touch something every pair, of
    /// further ones a single pair.
    pub violations: Vec<Violation>,
    /// How the path ends: the nearest grasp, and how far it is.
    pub goal: Option<GoalError>,
    /// The least distance along the whole path, in metres, certified from below (`exact` only); `None` where
    /// there is nothing to touch.
    pub clearance_m: Option<f64>,
    /// The same for every edge (`exact` only); 0 for an edge that is not proven.
    pub clearances_per_edge_m: Vec<Option<f64>>,
    /// What touches and was not compared (`exact` only): all that is said holds but for these.
    pub not_checked: Vec<NotChecked>,
}

/// The end of a path against the nearest grasp.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GoalError {
    /// Index of the grasp.
    pub grasp: usize,
    /// Distance of the gripper frame from it, in metres.
    pub translation_error_m: f64,
    /// Angle between the gripper frame and it or its twin, in radians.
    pub rotation_error_rad: f64,
}

/// One thing that is wrong with a path.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Violation {
    /// What kind of thing.
    pub kind: ViolationKind,
    /// Which edge, from 0, or way point where it is about a single one.
    pub edge: usize,
    /// Where on the edge, in [0, 1].
    pub at: f64,
    /// A link or a joint.
    pub first: String,
    /// What it touches: a link or a body; empty where there is nothing.
    pub second: String,
    /// How deep, in metres (rad for a joint): overlap, excess over a limit, or error of an end.
    pub depth_m: f64,
}

/// The kinds of violation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum ViolationKind {
    /// The path does not begin at the start of the problem.
    Start,
    /// The path does not end at a goal.
    Goal,
    /// A joint is outside its limits.
    JointLimit,
    /// Two things touch.
    Contact,
    /// Two things come closer than the margin that is demanded.
    Clearance,
    /// No contact was found, but none could be excluded either.
    Unresolved,
    /// Under `paper`: a step farther than any that the released planners take between two checks.
    Step,
}

/// How far a path may begin from the start of its problem, per joint (m or rad): way points are often
/// written with six digits.
const START_TOLERANCE: f64 = 1e-5;

/// The length of a path: the sum of the L2 lengths of its edges in configuration space (m and rad mixed).
pub fn path_length(path: &[Vec<f64>]) -> f64 {
    let edge = |pair: &[Vec<f64>]| -> f64 {
        pair[0].iter().zip(&pair[1]).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
    };
    path.windows(2).map(edge).fold(0.0, |sum, length| sum + length)
}

/// What a judge says of clearance beside its verdict.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ClearanceReport {
    /// The least distance along every edge: exact to 10 µm, some milliseconds an edge.
    #[default]
    PerEdge,
    /// Nothing: the verdict alone, which takes a fraction of that.
    Left,
}

/// Judges a path, whoever made it, by the criterion of `problem`; [`verify_with`] a report on every edge.
///
/// # Errors
/// As [`verify_with`].
pub fn verify(problem: &Problem, path: &[Vec<f64>]) -> Result<Verification, PlanError> {
    verify_with(problem, path, ClearanceReport::PerEdge)
}

/// Judges a path, whoever made it, by the criterion of `problem`. The verdict does not depend on `report`, but for
/// this: a proof that the clearance of its own edge contradicts is none.
///
/// 1. It begins at the start.
/// 2. Every way point is within the joint limits.
/// 3. Under `exact` every edge is proven, with every pair of links checked that is free at any way point; under `paper` every way point but the first and the last (a goal
///    root is not checked by the released planners) passes the released check, and no step is longer than
///    theirs.
/// 4. It ends at a goal.
///
/// # Errors
/// [`PlanError::JointCount`] or [`PlanError::NotFinite`] for a way point that is no configuration of the
/// robot, [`PlanError::EmptyPath`] for a path without way points.
pub fn verify_with(
    problem: &Problem,
    path: &[Vec<f64>],
    report: ClearanceReport,
) -> Result<Verification, PlanError> {
    for q in path {
        problem.check_configuration("way point", q)?;
    }
    let (Some(first), Some(last)) = (path.first(), path.last()) else { return Err(PlanError::EmptyPath) };
    let mut violations = Vec::new();
    // 1.
    let joint_names = problem.robot.joint_names();
    for ((a, b), name) in first.iter().zip(&problem.start).zip(joint_names) {
        if (a - b).abs() > START_TOLERANCE {
            violations.push(at_way_point(ViolationKind::Start, 0, name, (a - b).abs()));
        }
    }
    // 2.
    for (index, q) in path.iter().enumerate() {
        for ((value, limits), name) in q.iter().zip(problem.robot.limits()).zip(joint_names) {
            let excess = (limits.lower - value).max(value - limits.upper);
            if excess > 0.0 {
                violations.push(at_way_point(ViolationKind::JointLimit, index, name, excess));
            }
        }
    }
    // 3.
    let mut clearances_per_edge_m = Vec::new();
    let mut not_checked = Vec::new();
    match &problem.validity {
        Validity::Exact(cell) => {
            let cell = &cell.with_pairs_free_at(path.iter().map(Vec::as_slice));
            not_checked = NotChecked::of(cell);
            // A path of one way point is an edge of no length.
            let single = [first.clone(), first.clone()];
            let path = if path.len() == 1 { &single[..] } else { path };
            let mut faulty = 0;
            for begin in (0..path.len() - 1).step_by(EDGES_AT_ONCE) {
                let detail = if faulty < MOST_DETAILED { Detail::EveryPair } else { Detail::FirstPair };
                let edges = begin..(begin + EDGES_AT_ONCE).min(path.len() - 1);
                for (found, least_m) in judge_edges(cell, path, edges, report, detail) {
                    if report == ClearanceReport::PerEdge {
                        clearances_per_edge_m.push(least_m.is_finite().then_some(least_m));
                    }
                    faulty += usize::from(found.is_err());
                    violations.extend(found.err().into_iter().flatten());
                }
            }
        }
        Validity::Paper { check, .. } => {
            let mut scratch = check.scratch();
            let mut stepper = Stepper::new(&problem.robot);
            for (edge, pair) in path.windows(2).enumerate() {
                let moved_m = stepper.displacement_between(&problem.robot, &pair[0], &pair[1]);
                if moved_m > RELEASED_STEP_M * (1.0 + 1e-9) {
                    let excess_m = moved_m - RELEASED_STEP_M;
                    violations.push(at_way_point(ViolationKind::Step, edge, "", excess_m));
                }
            }
            for (index, q) in path.iter().enumerate().take(path.len() - 1).skip(1) {
                if problem.robot.within_limits(q) && !check.is_free(q, &mut scratch) {
                    violations.push(at_way_point(ViolationKind::Contact, index, "", 0.0));
                }
            }
        }
    }
    // 4.
    let goal = match &problem.goal {
        Goal::Grasps(grasps) => {
            let end = end_at_grasp(problem, grasps, last);
            let is_there = end.is_some_and(|(_, difference)| problem.validity.is_arrival(&difference));
            if !is_there {
                let off = end.map_or(f64::INFINITY, |(_, difference)| difference.translation_m);
                violations.push(at_way_point(ViolationKind::Goal, path.len() - 1, "", off));
            }
            end.map(|(grasp, difference)| GoalError {
                grasp,
                translation_error_m: difference.translation_m,
                rotation_error_rad: difference.rotation_rad,
            })
        }
        Goal::Configurations(goals) => {
            let off = |goal: &Vec<f64>| goal.iter().zip(last).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            let nearest = goals.iter().map(off).fold(f64::INFINITY, f64::min);
            if nearest > START_TOLERANCE {
                violations.push(at_way_point(ViolationKind::Goal, path.len() - 1, "", nearest));
            }
            None
        }
    };
    let clearance_m = clearances_per_edge_m.iter().copied().flatten().reduce(f64::min);
    let valid = violations.is_empty();
    Ok(Verification { valid, violations, goal, clearance_m, clearances_per_edge_m, not_checked })
}

/// The grasp at which the path ends: of those where the gripper has arrived the one with the best score,
/// else the nearest.
fn end_at_grasp(problem: &Problem, grasps: &GraspSet, q: &[f64]) -> Option<(usize, PoseDifference)> {
    let mut frames = problem.robot.frames();
    problem.robot.forward_kinematics(q, &mut frames);
    let gripper = frames.link(problem.robot.tip());
    let arrived = |&grasp: &usize| {
        let difference = grasps.grasps()[grasp].difference(gripper);
        problem.validity.is_arrival(&difference)
    };
    match grasps.by_score().into_iter().find(|g| problem.criterion() == crate::Criterion::Exact && arrived(g))
    {
        Some(grasp) => Some((grasp, grasps.grasps()[grasp].difference(gripper))),
        None => grasps.nearest(gripper),
    }
}

/// So many edges are judged by all cores before the next ones are.
const EDGES_AT_ONCE: usize = 1024;

/// Fewer are not worth a thread, and the scratch that it needs.
const EDGES_PER_THREAD: usize = 128;

/// After about so many edges with faults, of each further one a single pair that touches is told: to find all takes
/// milliseconds an edge, and a path may have a million.
const MOST_DETAILED: usize = 1000;

/// What is told of an edge that touches something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Detail {
    /// Every pair that touches, where it is deepest.
    EveryPair,
    /// One pair, at an end, in the middle, or where the proof met it.
    FirstPair,
}

/// Of each edge whether it is proven, else what is wrong with it, and its least clearance (m) if `report` wants it.
fn judge_edges(
    cell: &Cell,
    path: &[Vec<f64>],
    edges: Range<usize>,
    report: ClearanceReport,
    detail: Detail,
) -> Vec<(Result<(), Vec<Violation>>, f64)> {
    let judge = |scratch: &mut Scratch, edge: usize| {
        let (a, b) = (&path[edge], &path[edge + 1]);
        let found = judge_edge(cell, edge, [a, b], detail, scratch);
        if report == ClearanceReport::Left || found.is_err() {
            return (found, 0.0);
        }
        let measured = cell.measure_motion(a, b, scratch);
        match measured.contradiction {
            Some((at, contact)) => {
                (Err(vec![describe(cell, ViolationKind::Unresolved, edge, at, &contact)]), 0.0)
            }
            None => (found, measured.least_m),
        }
    };
    if edges.len() <= EDGES_PER_THREAD {
        let mut scratch = cell.scratch();
        return edges.map(|edge| judge(&mut scratch, edge)).collect();
    }
    edges.into_par_iter().with_min_len(EDGES_PER_THREAD).map_init(|| cell.scratch(), judge).collect()
}

/// Whether an edge is proven; else what is wrong with it on the way, if not only its ends are.
fn judge_edge(
    cell: &Cell,
    edge: usize,
    [a, b]: [&[f64]; 2],
    detail: Detail,
    scratch: &mut Scratch,
) -> Result<(), Vec<Violation>> {
    let of_contact = |(at, contact): &(f64, Contact)| {
        let touches = contact.clearance_m < CONTACT_M;
        let kind = if touches { ViolationKind::Contact } else { ViolationKind::Clearance };
        describe(cell, kind, edge, *at, contact)
    };
    if detail == Detail::FirstPair {
        // Where the ends or the middle touch something, a proof would only look for the first such place.
        let found = deepest_contacts(cell, [a, b], None, 2, scratch);
        if let Some(first) = found.first() {
            return Err(vec![of_contact(first)]);
        }
    }
    let seed = match cell.motion_is_free(a, b, scratch) {
        Motion::Proven => return Ok(()),
        Motion::Unresolved { at, contact } => {
            return Err(vec![describe(cell, ViolationKind::Unresolved, edge, at, &contact)]);
        }
        Motion::Contact { at, contact } => Some((at, contact)),
        // The limits are judged at the way points; what touches on the way counts all the same.
        Motion::OutOfLimits { .. } => None,
    };
    let contacts = match seed {
        Some(first) if detail == Detail::FirstPair => vec![first],
        None if detail == Detail::FirstPair => Vec::new(),
        seed => deepest_contacts(cell, [a, b], seed, SAMPLES, scratch),
    };
    Err(contacts.iter().map(of_contact).collect())
}

fn describe(cell: &Cell, kind: ViolationKind, edge: usize, at: f64, contact: &Contact) -> Violation {
    Violation {
        kind,
        edge,
        at,
        first: cell.name(contact.first).to_owned(),
        second: cell.name(contact.second).to_owned(),
        depth_m: contact.depth_m,
    }
}

/// How many pieces an edge is cut into to find what it touches.
const SAMPLES: u32 = 64;

/// Every pair that touches on an edge, each at the deepest of the ends of so many pieces and of `seed`.
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
        let q: Vec<f64> = a.iter().zip(b).map(|(a, b)| a + (b - a) * at).collect();
        for contact in cell.contacts(&q, scratch) {
            keep(at, contact);
        }
    }
    // Links first, then bodies, in the order of the robot: the same list for the same path.
    let rank = |collider: Collider| match collider {
        Collider::Link(link) => (0, link),
        Collider::Body(body) => (1, body),
    };
    found.sort_by_key(|(_, contact)| (rank(contact.first), rank(contact.second)));
    found
}

fn at_way_point(kind: ViolationKind, index: usize, first: &str, depth_m: f64) -> Violation {
    Violation { kind, edge: index, at: 0.0, first: first.to_owned(), second: String::new(), depth_m }
}
