use std::collections::HashSet;

use cranny_collision::Resting;
use cranny_task::{
    Carrier, ContactSegment, Grip, Mode, MotionEnd, Move, Moved, Placed, Placer, Problem, Region, Segment,
    Stage, State, StateSequence, are_complete, check_segments, joined, straight_line,
};

use crate::corner_audit::audit_corners;
use crate::{
    Audit, AuditSettings, Cause, Location, PathError, PickAudit, Violation, audit_with, audit_without_proof,
};

/// Tolerance on the stated finger opening, in metres.
const OPENING_TOLERANCE_M: f64 = 1e-4;
/// Tolerance on the length of an object's path, in metres: straight lines in joint space are curved in Cartesian space.
const LENGTH_TOLERANCE_M: f64 = 1e-3;

/// Audits the segments of a task from any source: every motion as by [`audit_with`], in the state along it ([`StateSequence`]);
/// the closing and opening of the hand; and the end of each stage. Edges are numbered through all segments.
///
/// # Errors
/// [`cranny_task::TaskError::Segments`] for segments of other stages ([`check_segments`]), and those of [`audit_with`].
pub fn audit_task(
    problem: &Problem,
    stages: &[Stage],
    segments: &[Segment],
    settings: AuditSettings,
) -> Result<Audit, PathError> {
    // This precedes the states, because the hand closes and opens in them.
    if let Some(audit) = audit_without_proof(problem, segments, settings)? {
        return Ok(audit);
    }
    if let Some(along) = StateSequence::of(problem, stages, segments)? {
        return audit_along(problem, stages, (segments, &along), settings);
    }
    check_segments(stages, segments).map_err(|problem| cranny_task::TaskError::Segments { problem })?;
    audit_with(problem, &joined(segments), settings)
}

/// Audits segments as [`audit_task`] does, with known states along them, under `exact`.
///
/// # Errors
/// As [`audit_task`].
pub fn audit_along(
    problem: &Problem,
    stages: &[Stage],
    (segments, along): (&[Segment], &StateSequence),
    settings: AuditSettings,
) -> Result<Audit, PathError> {
    if let Some(audit) = audit_without_proof(problem, segments, settings)? {
        return Ok(audit);
    }
    check_segments(stages, segments).map_err(|problem| cranny_task::TaskError::Segments { problem })?;
    let task = TaskJudge { problem, stages, settings };
    let (mut audit, mut before, mut closed_at) = (Audit::empty(), 0, 0);
    let mut picks = along.picks.iter();
    let mut first = 0;
    let known = &segments[..along.states.len()];
    for run in known.chunk_by(is_one_motion) {
        if audit.violations.len() >= settings.limits.violations {
            audit.clearances_per_edge_m.clear();
            return Ok(audit);
        }
        let (state, next) = (&along.states[first], segments.get(first + run.len()));
        let segment = Segment { waypoints: joined(run), ..run[0].clone() };
        first += run.len();
        let run = Run { segment: &segment, before, next };
        match state.held() {
            None => task.empty(&mut audit, state, &run, &mut picks)?,
            Some((carrier, grip)) => {
                let was_held = first > 1 && segments[first - 2].mode.holds;
                if !was_held {
                    closed_at = before;
                }
                check_hold(&mut audit, carrier, grip, &segment, closed_at);
                task.held(&mut audit, state, (carrier, grip), &run)?;
            }
        }
        before += segment.waypoints.len() - 1;
    }
    audit_corners(&mut audit, known, along, settings);
    // A way point belongs to two segments or edges, and to its corner.
    let mut reported = HashSet::new();
    audit.violations.retain(|violation| reported.insert(violation.to_string()));
    match &along.stopped {
        Some(reason) => {
            audit.violations.push(Violation::at_way_point(before, Cause::Grip { reason: reason.clone() }));
        }
        None if settings.at_goal && !are_complete(stages, segments) => {
            let stage = segments.last().map_or(0, |last| last.stage);
            let cause = Cause::Unfinished { stage, stages: stages.len() };
            audit.violations.push(Violation::at_way_point(before, cause));
        }
        None => {}
    }
    audit.valid = audit.violations.is_empty();
    Ok(audit)
}

/// Returns true if both segments belong to one stage and one world, and both or neither are straight lines.
fn is_one_motion(a: &Segment, b: &Segment) -> bool {
    let is_straight = |mode: Mode| mode == Mode::APPROACH || mode == Mode::RETREAT;
    let properties = |segment: &Segment| {
        (segment.stage, segment.mode.holds, segment.mode.rests_at, is_straight(segment.mode))
    };
    properties(a) == properties(b) && a.mode.rests_at.is_none()
}

/// Motion, the number of edges before it, and the segment that follows.
struct Run<'a> {
    segment: &'a Segment,
    before: usize,
    next: Option<&'a Segment>,
}

impl Run<'_> {
    /// Returns the index of its last way point.
    fn last(&self) -> usize {
        self.before + self.segment.waypoints.len() - 1
    }

    fn ends_stage(&self) -> bool {
        self.next.is_none_or(|next| next.stage != self.segment.stage)
    }

    fn path(&self) -> &[Vec<f64>] {
        &self.segment.waypoints
    }

    fn end(&self) -> &[f64] {
        &self.segment.waypoints[self.segment.waypoints.len() - 1]
    }
}

struct TaskJudge<'a> {
    problem: &'a Problem,
    stages: &'a [Stage],
    settings: AuditSettings,
}

impl TaskJudge<'_> {
    /// Judges a motion of the open and empty hand.
    fn empty<'p>(
        &self,
        audit: &mut Audit,
        state: &State,
        run: &Run<'_>,
        picks: &mut impl Iterator<Item = &'p Problem>,
    ) -> Result<(), PathError> {
        let is_at_grasp = run.next.is_none_or(|next| next.mode.holds);
        self.straight(audit, state, run, is_at_grasp);
        match &self.stages[run.segment.stage] {
            Stage::Pick(_) if is_at_grasp => {
                let Some(picking) = picks.next() else { return Err(PathError::EmptyPath) };
                let judged = if run.segment.mode == Mode::APPROACH {
                    audit_with(
                        &picking.with_start_in_cell(&state.q, state.cell())?,
                        run.path(),
                        self.settings,
                    )?
                } else {
                    audit_with(picking, run.path(), self.settings)?
                };
                let (goal, own_grasp) = (judged.goal, judged.own_grasp);
                let (stage, way_point) = (run.segment.stage, run.last());
                audit.add_pick(PickAudit { stage, goal, own_grasp, way_point });
                append(audit, judged, run.before);
                Ok(())
            }
            Stage::Move(goal) if run.ends_stage() => self.moved(audit, state, goal, run),
            stage => {
                append(audit, self.anywhere(state, run)?, run.before);
                if let (Stage::Place(place), true, Some((body, pose))) =
                    (stage, run.ends_stage(), state.let_go())
                {
                    let placed = Placed::of(state.cell(), body, *pose);
                    let (way_point, required_m) = (run.last(), place.clear_m);
                    let clearance_m = placed.clearance_m(run.end(), required_m, &mut placed.scratch());
                    if clearance_m < required_m {
                        let cause = Cause::NotClear { clearance_m, required_m };
                        audit.violations.push(Violation::at_way_point(way_point, cause));
                    }
                }
                Ok(())
            }
        }
    }

    /// Compares the length of a straight motion with the length that its stage requires.
    fn straight(&self, audit: &mut Audit, state: &State, run: &Run<'_>, is_at_grasp: bool) {
        let stage = &self.stages[run.segment.stage];
        let required_m = match stage {
            Stage::Pick(pick) if is_at_grasp && (run.next.is_some() || self.settings.at_goal) => {
                pick.approach_m
            }
            Stage::Place(place) if run.segment.mode == Mode::RETREAT => place.retreat_m,
            _ => return,
        };
        let line = straight_line(state.cell().robot(), Some(stage), run.segment);
        let length_m = line.map_or(0.0, |line| line.length_m());
        if length_m < required_m {
            let cause = Cause::NotStraight { length_m, required_m };
            audit.violations.push(Violation::at_way_point(run.last(), cause));
        }
    }

    /// Judges a motion that may end anywhere.
    fn anywhere(&self, state: &State, run: &Run<'_>) -> Result<Audit, PathError> {
        let settings = AuditSettings { at_goal: false, ..self.settings };
        audit_with(&state.moving(vec![state.q.clone()])?, run.path(), settings)
    }

    /// Judges the last motion of a move, with any held object, and its end.
    fn moved(&self, audit: &mut Audit, state: &State, goal: &Move, run: &Run<'_>) -> Result<(), PathError> {
        let ends = goal.ends(self.problem).filter(|_| self.settings.at_goal);
        let Some(ends) = ends else { return self.moved_anywhere(audit, state, goal, run) };
        let judged = audit_with(&state.moving(ends)?, run.path(), self.settings)?;
        append(audit, judged, run.before);
        Ok(())
    }

    fn moved_anywhere(
        &self,
        audit: &mut Audit,
        state: &State,
        goal: &Move,
        run: &Run<'_>,
    ) -> Result<(), PathError> {
        append(audit, self.anywhere(state, run)?, run.before);
        if !self.settings.at_goal {
            return Ok(());
        }
        if let Some(regions) = goal.regions(self.problem)? {
            let pose_of = |moved: Moved| state.pose_of(moved, run.end());
            let fault = Region::fault_of_all(&regions, pose_of);
            let violation = |fault| Violation::at_way_point(run.last(), Cause::NotThere { fault });
            audit.violations.extend(fault.map(violation));
        }
        if let Move::Clear { clear_m } = goal {
            let clearance_m = state.clearance_m(run.end(), *clear_m, &mut state.cell().scratch());
            if clearance_m < *clear_m {
                let (way_point, required_m) = (run.last(), *clear_m);
                let cause = Cause::NotOut { clearance_m, required_m };
                audit.violations.push(Violation::at_way_point(way_point, cause));
            }
        }
        Ok(())
    }

    fn held(
        &self,
        audit: &mut Audit,
        state: &State,
        (carrier, grip): (&Carrier, &Grip),
        run: &Run<'_>,
    ) -> Result<(), PathError> {
        let stage = &self.stages[run.segment.stage];
        let is_let_go = run.next.is_some_and(|next| !next.mode.holds);
        if let (Stage::Place(place), true) = (stage, is_let_go) {
            let placer = Placer::new(self.problem, carrier, place)?;
            if let Some(fault) = placer.fault_at(&carrier.held_at(grip, run.end())) {
                audit.violations.push(Violation::at_way_point(run.last(), Cause::NotPlaced { fault }));
            }
        }
        match (state.resting().zip(run.segment.mode.rests_at), stage) {
            (Some((resting, end)), _) => {
                let near = Near { carrier, grip, resting, end, state, run };
                near.judge(audit, self.anywhere(state, run)?, self.settings.limits.violations);
                Ok(())
            }
            (None, Stage::Move(goal)) if run.ends_stage() => self.moved(audit, state, goal, run),
            (None, _) => {
                append(audit, self.anywhere(state, run)?, run.before);
                Ok(())
            }
        }
    }
}

/// Compares the held object stated by a segment with the object that the hand holds.
fn check_hold(audit: &mut Audit, carrier: &Carrier, grip: &Grip, segment: &Segment, way_point: usize) {
    let Some((name, opening_m)) = segment.attached.as_ref().zip(segment.opening_m) else { return };
    let off_m = (opening_m - grip.opening_m).abs();
    if name != carrier.object() || off_m.is_nan() || off_m > OPENING_TOLERANCE_M {
        let held = (carrier.object().to_owned(), grip.opening_m);
        let cause = Cause::Hold { said: (name.clone(), opening_m), held, mode: segment.mode.name };
        audit.violations.push(Violation::at_way_point(way_point, cause));
    }
}

/// Motion of a held object that rests on its support at one end.
struct Near<'a> {
    carrier: &'a Carrier,
    grip: &'a Grip,
    resting: &'a Resting,
    end: MotionEnd,
    state: &'a State,
    run: &'a Run<'a>,
}

impl Near<'_> {
    /// Adds the audit of its edges, and checks that the object comes no closer to its support than at rest (until there are
    /// `most` violations), travels no farther than allowed, and is off its support at the other end.
    fn judge(&self, audit: &mut Audit, mut judged: Audit, most: usize) {
        let Self { carrier, grip, resting, run, .. } = *self;
        let (kind, off_at, off_way_point) = match self.end {
            MotionEnd::First => (ContactSegment::LiftOff, run.end(), run.last()),
            MotionEnd::Last => (ContactSegment::SetDown, &run.path()[0][..], run.before),
        };
        judged.not_checked = judged.not_checked.into_iter().map(|pair| pair.along(kind)).collect();
        append(audit, judged, run.before);
        let cell = self.state.cell();
        let mut scratch = cell.scratch();
        for (edge, ends) in run.path().windows(2).enumerate() {
            if audit.violations.len() >= most {
                break;
            }
            let ends = [&ends[0][..], &ends[1]];
            if let Some((along, body)) = carrier.first_support_violation(cell, resting, ends, &mut scratch) {
                let pair = Some([carrier.object().to_owned(), carrier.body_name(body)]);
                let at = Location { edge: run.before + edge, along, pair };
                let cause = match self.end {
                    MotionEnd::First => Cause::LiftOff,
                    MotionEnd::Last => Cause::SetDown,
                };
                audit.violations.push(Violation { at, cause });
            }
        }
        let (way_point, most_m) = (run.last(), carrier.settings().most_m);
        let length_m = carrier.length_m(grip, run.path());
        if length_m > most_m + LENGTH_TOLERANCE_M {
            let cause = match self.end {
                MotionEnd::First => Cause::LongLiftOff { length_m, most_m },
                MotionEnd::Last => Cause::LongSetDown { length_m, most_m },
            };
            audit.violations.push(Violation::at_way_point(way_point, cause));
        }
        if !carrier.is_off(grip, resting, off_at, &mut grip.carrying_scratch()) {
            let cause = match self.end {
                MotionEnd::First => Cause::NotOff,
                MotionEnd::Last => Cause::NotAbove,
            };
            audit.violations.push(Violation::at_way_point(off_way_point, cause));
        }
    }
}

/// Merges the audit of a motion whose first edge has the index `before`.
fn append(audit: &mut Audit, piece: Audit, before: usize) {
    audit.violations.extend(piece.violations.into_iter().map(|violation| violation.counted_from(before)));
    audit.clearances_per_edge_m.extend(piece.clearances_per_edge_m);
    if piece.clearance_m.is_some_and(|piece_m| audit.clearance_m.is_none_or(|least_m| piece_m < least_m)) {
        (audit.clearance_m, audit.clearance_limit) = (piece.clearance_m, piece.clearance_limit);
    }
    let new = piece.not_checked.into_iter().filter(|pair| !audit.not_checked.contains(pair));
    let new: Vec<_> = new.collect();
    audit.not_checked.extend(new);
}
