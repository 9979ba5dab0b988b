use cranny_collision::Resting;

use crate::{
    AfterPlacing, Audit, AuditSettings, Carrier, CarryEnd, ContactSegment, Grip, Place, Placer, PlanError,
    Problem, Violation, audit_with,
};

/// The pieces of a task's path, each from where the one before ends, and what is said of them.
#[derive(Clone, Copy, Debug)]
pub struct TaskPath<'a> {
    /// To the grasp, the hand open and empty.
    pub reach: &'a [Vec<f64>],
    /// The object in the closed hand, off what it rested on.
    pub lift_off: &'a [Vec<f64>],
    /// And on from there.
    pub carry: &'a [Vec<f64>],
    /// What the hand is said to hold in each of the last two, and how far its fingers are apart, in metres.
    pub held: [Option<(&'a str, f64)>; 2],
    /// Where the object is to be carried; `None`: wherever the path ends.
    pub end: Option<&'a CarryEnd>,
    /// What follows where it is put down.
    pub place: Option<PlacePath<'a>>,
}

/// The pieces of a path along which an object is put down, each from where the one before ends.
#[derive(Clone, Copy, Debug)]
pub struct PlacePath<'a> {
    /// Puts it down.
    pub placer: &'a Placer,
    /// The object in the closed hand, down to where it then rests.
    pub set_down: &'a [Vec<f64>],
    /// The hand open and empty, off the object.
    pub retreat: &'a [Vec<f64>],
    /// And on from there, if it goes on.
    pub back: Option<&'a [Vec<f64>]>,
    /// What the hand is said to hold in the first, and how far its fingers are apart, in metres.
    pub held: Option<(&'a str, f64)>,
}

/// A number that is said of how far the fingers are apart is right to within this, in metres.
const OPENING_TOLERANCE_M: f64 = 1e-4;
/// What the object may go farther than it may, in metres: straight lines in joint space are none in space.
const LENGTH_TOLERANCE_M: f64 = 1e-3;

/// Judges the path of a task, whoever made it: the way to the grasp as [`audit_with`] does, whether the hand closes there
/// on the object, every edge after that with the object in the hand, as it stands in it then, and where it ends. Edges are
/// counted through all pieces.
///
/// # Errors
/// As [`audit_with`].
pub fn audit_task(
    problem: &Problem,
    carrier: &Carrier,
    path: TaskPath<'_>,
    settings: AuditSettings,
) -> Result<Audit, PlanError> {
    let mut audit = audit_with(problem, path.reach, settings)?;
    let Some(grasp) = path.reach.last() else { return Err(PlanError::EmptyPath) };
    let way_point = path.reach.len() - 1;
    let grip = match carrier.close(grasp) {
        Ok(grip) => grip,
        Err(reason) => {
            audit.violations.push(Violation::Grip { way_point, reason });
            audit.valid = false;
            return Ok(audit);
        }
    };
    for (name, opening_m) in path.held.into_iter().chain(path.place.map(|place| place.held)).flatten() {
        let off_m = (opening_m - grip.opening_m).abs();
        if name != carrier.object() || off_m.is_nan() || off_m > OPENING_TOLERANCE_M {
            let held = (carrier.object().to_owned(), grip.opening_m);
            audit.violations.push(Violation::Hold { way_point, said: (name.to_owned(), opening_m), held });
        }
    }
    lift_off(&mut audit, carrier, &grip, path, settings)?;
    carry(&mut audit, carrier, &grip, path, settings)?;
    if let Some(placing) = path.place {
        place(&mut audit, carrier, &grip, (path, placing), settings)?;
    }
    audit.valid = audit.violations.is_empty();
    Ok(audit)
}

fn lift_off(
    audit: &mut Audit,
    carrier: &Carrier,
    grip: &Grip,
    path: TaskPath<'_>,
    settings: AuditSettings,
) -> Result<(), PlanError> {
    let (Some(from), Some(off)) = (path.reach.last(), path.lift_off.last()) else {
        return Err(PlanError::EmptyPath);
    };
    let before = path.reach.len() - 1;
    let near = Near { carrier, grip, resting: carrier.resting(), from, path: path.lift_off, before };
    near.judge(audit, settings, ContactSegment::LiftOff)?;
    let way_point = near.last();
    if let Some((length_m, most_m)) = near.too_long_m() {
        audit.violations.push(Violation::LongLiftOff { way_point, length_m, most_m });
    }
    if !near.is_off_at(off) {
        audit.violations.push(Violation::NotOff { way_point });
    }
    Ok(())
}

/// A piece of a path along which a held object is near what it rests on, at one of its ends.
struct Near<'a> {
    carrier: &'a Carrier,
    grip: &'a Grip,
    resting: &'a Resting,
    /// Where the piece before it ends.
    from: &'a [f64],
    path: &'a [Vec<f64>],
    /// How many edges there are before it.
    before: usize,
}

impl Near<'_> {
    /// Whether its edges are proven, and stay off what the object rests on.
    fn judge(
        &self,
        audit: &mut Audit,
        settings: AuditSettings,
        segment: ContactSegment,
    ) -> Result<(), PlanError> {
        let lifting = self.grip.lifting(self.from, self.from)?;
        let anywhere = AuditSettings { at_goal: false, ..settings };
        let mut judged = audit_with(&lifting, self.path, anywhere)?;
        judged.not_checked = judged.not_checked.into_iter().map(|pair| pair.along(segment)).collect();
        append(audit, judged, self.before);
        let mut scratch = lifting.exact_cell("audit")?.scratch();
        for (edge, ends) in self.path.windows(2).enumerate() {
            let ends = [&ends[0][..], &ends[1]];
            if let Some((at, body)) = self.carrier.stays_off(self.grip, self.resting, ends, &mut scratch) {
                let (first, second) = (self.carrier.object().to_owned(), self.carrier.body_name(body));
                let place = Place { edge: self.before + edge, at, first, second };
                audit.violations.push(match segment {
                    ContactSegment::LiftOff => Violation::LiftOff { place },
                    ContactSegment::SetDown => Violation::SetDown { place },
                });
            }
        }
        Ok(())
    }

    /// Which way point is its last.
    fn last(&self) -> usize {
        self.before + self.path.len() - 1
    }

    /// How far the object goes and how far it may, in metres, where that is too far.
    fn too_long_m(&self) -> Option<(f64, f64)> {
        let (length_m, most_m) =
            (self.carrier.length_m(self.grip, self.path), self.carrier.settings().most_m);
        (length_m > most_m + LENGTH_TOLERANCE_M).then_some((length_m, most_m))
    }

    fn is_off_at(&self, q: &[f64]) -> bool {
        self.carrier.is_off(self.grip, self.resting, q, &mut self.grip.carrying_scratch())
    }
}

fn carry(
    audit: &mut Audit,
    carrier: &Carrier,
    grip: &Grip,
    path: TaskPath<'_>,
    settings: AuditSettings,
) -> Result<(), PlanError> {
    let (Some(off), Some(last)) = (path.lift_off.last(), path.carry.last()) else {
        return Err(PlanError::EmptyPath);
    };
    let before = path.reach.len() + path.lift_off.len() - 2;
    let ends = path.end.and_then(|end| carrier.ends(end)).filter(|_| settings.at_goal);
    let at_goal = ends.is_some();
    let carrying = grip.carrying(off, ends.unwrap_or_else(|| vec![off.clone()]))?;
    append(audit, audit_with(&carrying, path.carry, AuditSettings { at_goal, ..settings })?, before);
    if let Some(CarryEnd::Out { clear_m }) = path.end.filter(|_| settings.at_goal) {
        let clearance_m = grip.clearance_m(last, *clear_m, &mut grip.carrying_scratch());
        if clearance_m < *clear_m {
            let way_point = before + path.carry.len() - 1;
            audit.violations.push(Violation::NotOut { way_point, clearance_m, required_m: *clear_m });
        }
    }
    Ok(())
}

/// The object put down, the hand opened and off it, and the arm where it goes then.
fn place(
    audit: &mut Audit,
    carrier: &Carrier,
    grip: &Grip,
    (path, place): (TaskPath<'_>, PlacePath<'_>),
    settings: AuditSettings,
) -> Result<(), PlanError> {
    let PlacePath { placer, set_down, retreat, back, .. } = place;
    let (Some(from), Some(above), Some(down), Some(off)) =
        (path.carry.last(), set_down.first(), set_down.last(), retreat.last())
    else {
        return Err(PlanError::EmptyPath);
    };
    let mut before = path.reach.len() + path.lift_off.len() + path.carry.len() - 3;
    let way_point = before + set_down.len() - 1;
    let world_from_held = placer.held_at(grip, down);
    let placement = placer.placement(&world_from_held);
    if let Some(fault) = placer.fault_of(&placement) {
        audit.violations.push(Violation::NotPlaced { way_point, fault });
    }
    let near_grip = &placement.grip_near(grip)?;
    let near = Near { carrier, grip: near_grip, resting: placement.resting(), from, path: set_down, before };
    near.judge(audit, settings, ContactSegment::SetDown)?;
    if let Some((length_m, most_m)) = near.too_long_m() {
        audit.violations.push(Violation::LongSetDown { way_point, length_m, most_m });
    }
    if !near.is_off_at(above) {
        audit.violations.push(Violation::NotAbove { way_point: before });
    }
    before = way_point;
    let placed = match placer.open(grip, down) {
        Ok(placed) => placed,
        Err(reason) => {
            audit.violations.push(Violation::Grip { way_point, reason });
            return Ok(());
        }
    };
    let anywhere = AuditSettings { at_goal: false, ..settings };
    append(audit, audit_with(&placed.leaving(down, vec![down.clone()])?, retreat, anywhere)?, before);
    before += retreat.len() - 1;
    let required_m = placer.settings().clear_m;
    let clearance_m = placed.clearance_m(off, required_m, &mut placed.scratch());
    if clearance_m < required_m {
        audit.violations.push(Violation::NotClear { way_point: before, clearance_m, required_m });
    }
    let at_goal = settings.at_goal && placer.settings().then == AfterPlacing::Home;
    // Without a way back the robot is where its hand has left the object.
    let (goes_on, back) = (back.is_some(), back.unwrap_or(std::slice::from_ref(off)));
    let home = placed.leaving(off, vec![carrier.problem().start().to_vec()])?;
    let judged = audit_with(&home, back, AuditSettings { at_goal, ..settings })?;
    let judged = if goes_on { judged } else { Audit { clearances_per_edge_m: Vec::new(), ..judged } };
    append(audit, judged, before);
    Ok(())
}

/// Adds what was found of a piece whose first edge has this number.
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
