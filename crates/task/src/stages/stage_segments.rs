use crate::stages::segment::{Mode, MotionEnd, Segment};
use crate::stages::stage::Stage;

/// Checks that segments match stages: they are in order; the hand closes only in a pick that a stage follows, and opens only in
/// a place; only an object just grasped, or released next, may touch its support. [`are_complete`] checks that the segments
/// reach the end of the last stage.
///
/// # Errors
/// A sentence that names the first segment that cannot follow.
pub fn check_segments(stages: &[Stage], segments: &[Segment]) -> Result<(), String> {
    let mut before: Option<&Segment> = None;
    for (index, segment) in segments.iter().enumerate() {
        if let Some(fault) = fault_of(stages, [before, segments.get(index + 1)], segment) {
            return Err(format!("segment {index}, '{}', {fault}", segment.mode.name));
        }
        before = Some(segment);
    }
    Ok(())
}

/// Sets the stage indices of segments that have none: a pick ends with the lift-off of its object, a place with the retreat
/// from the object, a move with its only segment.
pub fn number_stages(stages: &[Stage], segments: &mut [Segment]) {
    let mut stage = 0;
    for index in 0..segments.len() {
        segments[index].stage = stage;
        let (mode, next) = (segments[index].mode, segments.get(index + 1));
        let is_over = match stages.get(stage) {
            Some(Stage::Pick(_)) => mode.rests_at == Some(MotionEnd::First),
            Some(Stage::Place(_)) => !mode.holds && next.is_some_and(|next| next.mode != mode),
            Some(Stage::Move(_)) => next.is_some(),
            None => false,
        };
        stage += usize::from(is_over && stage + 1 < stages.len());
    }
}

/// Splits segments into groups with one pick each; segments before the first pick belong to it.
pub fn picks_apart<'a>(stages: &[Stage], segments: &'a [Segment]) -> Vec<&'a [Segment]> {
    let is_pick = |segment: &Segment| matches!(stages.get(segment.stage), Some(Stage::Pick(_)));
    let first = segments.iter().position(is_pick).map_or(0, |first| segments[first].stage);
    let begins = |a: &Segment, b: &Segment| a.stage != b.stage && is_pick(b) && b.stage > first;
    segments.chunk_by(|a, b| !begins(a, b)).collect()
}

/// Returns true if segments reach the end of the last stage.
pub fn are_complete(stages: &[Stage], segments: &[Segment]) -> bool {
    segments.last().is_some_and(|last| {
        last.stage + 1 == stages.len() && last.mode.holds == holds_after(stages, last.stage)
    })
}

/// Returns true if the hand holds an object at the end of a stage.
fn holds_after(stages: &[Stage], stage: usize) -> bool {
    let of_stage = stages[..=stage].iter().enumerate().rev().find_map(|(index, stage)| match stage {
        Stage::Pick(_) => Some(index + 1 < stages.len()),
        Stage::Place(_) => Some(false),
        Stage::Move(_) => None,
    });
    of_stage.unwrap_or(false)
}

fn fault_of(
    stages: &[Stage],
    [before, next]: [Option<&Segment>; 2],
    segment: &Segment,
) -> Option<&'static str> {
    let Some(stage) = stages.get(segment.stage) else {
        return Some("is of a stage that the task does not have");
    };
    let Some(first) = segment.waypoints.first() else { return Some("has no way points") };
    if before.is_some_and(|before| before.waypoints.last() != Some(first)) {
        return Some("does not begin where the segment before it ends");
    }
    let begins_stage = before.is_none_or(|before| before.stage + 1 == segment.stage);
    let continues_stage = before.is_some_and(|before| before.stage == segment.stage);
    if !(continues_stage || begins_stage && (before.is_some() || segment.stage == 0)) {
        return Some("belongs neither to the stage of the segment before it nor to the next stage");
    }
    if segment.speed.is_some_and(|speed| !(speed > 0.0 && speed < 1.0)) {
        return Some("has an invalid speed: it must be a share of the limits, above 0 and below 1");
    }
    let is_one_motion = |before: &Segment| before.mode.holds == segment.mode.holds;
    if before.filter(|before| is_one_motion(before)).is_some_and(|before| before.speed != segment.speed) {
        return Some("has another speed than the segment before it, with which it is one motion");
    }
    if segment.pace.fault().is_some() {
        return Some(
            "has an invalid pace: shares of the limits must be above 0 and at most 1, speeds above 0",
        );
    }
    if let Some(fault) = corner_fault(before, segment) {
        return Some(fault);
    }
    if segment.mode == Mode::APPROACH
        && !(matches!(stage, Stage::Pick(_))
            && next.is_none_or(|next| next.stage != segment.stage || next.mode.holds))
    {
        return Some("is an approach, but no grasp follows it");
    }
    let holds = segment.mode.holds;
    let was_held = before.is_some_and(|before| before.mode.holds);
    let closes = holds && !was_held;
    let opens = was_held && !holds;
    let is_in_hand = segment.attached.is_some() || segment.opening_m.is_some();
    if closes && (begins_stage || !matches!(stage, Stage::Pick(_)) || segment.stage + 1 == stages.len()) {
        return Some("holds an object that was not picked");
    }
    if opens && segment.mode != Mode::RETREAT {
        return Some("does not retreat from the object that the hand has let go");
    }
    if opens && (begins_stage || !matches!(stage, Stage::Place(_))) {
        return Some("lets an object go where none is put down");
    }
    if is_in_hand && !holds {
        return Some("states what is in the hand, but the hand is open and empty");
    }
    let ends_stage = next.is_some_and(|next| next.stage != segment.stage);
    if ends_stage && holds != holds_after(stages, segment.stage) {
        return Some("ends its stage with the hand in the wrong state");
    }
    let may_rest = match segment.mode.rests_at {
        None => true,
        Some(MotionEnd::First) => closes,
        Some(MotionEnd::Last) => next.is_some_and(|next| !next.mode.holds),
    };
    (!may_rest).then_some(
        "allows contact of the object with its support, but neither follows a grasp nor precedes a release",
    )
}

/// Returns the fault of the rounded corners of a segment. Corners must be in the order of its way points and fit their edges.
/// No corner is allowed where an object may touch its support. One at the end of the previous segment is allowed only if both
/// segments are one motion of a stage, or the previous one is a lift-off.
fn corner_fault(before: Option<&Segment>, segment: &Segment) -> Option<&'static str> {
    /// Rounding of the shares of an edge that two corners cut off.
    const OVERLAP: f64 = 1e-9;
    let mut last = before.and_then(|before| {
        let (corner, edge) = (before.corners.last()?, before.waypoints.last_chunk::<2>()?);
        (corner.waypoint + 2 == before.waypoints.len()).then(|| corner.share_after(&edge[0], &edge[1]))
    });
    let mut next = 0;
    for corner in &segment.corners {
        let index = corner.waypoint;
        if index < next {
            return Some("has rounded corners out of order");
        }
        // The previous corner ends on the same edge.
        let taken = last.filter(|_| index == next).unwrap_or(0.0);
        next = index + 1;
        let from = match index {
            0 => before.filter(|before| are_joined(before, segment)).and_then(|before| {
                let way = &before.waypoints;
                way.len().checked_sub(2).map(|from| &way[from])
            }),
            _ => segment.waypoints.get(index - 1),
        };
        let ends = from.zip(segment.waypoints.get(index)).zip(segment.waypoints.get(index + 1));
        let Some(((from, corner_at), to)) = ends.filter(|_| segment.mode.rests_at.is_none()) else {
            return Some("rounds a corner where this is not allowed");
        };
        if !corner.rounds([from, corner_at, to]) {
            return Some("has a rounded corner that does not fit its edges");
        }
        if taken + corner.share_before(from, corner_at) > 1.0 + OVERLAP {
            return Some("has two rounded corners that overlap");
        }
        last = Some(corner.share_after(corner_at, to));
    }
    None
}

/// Returns true if a motion may continue from a segment to the next without a stop. It stops before a straight approach.
pub fn are_joined(before: &Segment, next: &Segment) -> bool {
    let lifts = before.mode.rests_at == Some(MotionEnd::First);
    before.mode.holds == next.mode.holds
        && next.mode != Mode::APPROACH
        && next.mode.rests_at.is_none()
        && (lifts || (before.stage == next.stage && before.mode.rests_at.is_none()))
}
