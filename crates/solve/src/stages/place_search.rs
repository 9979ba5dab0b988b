use std::collections::BTreeMap;
use std::sync::Arc;

use cranny_plan::{Observer, PlanError};
use cranny_spatial::{Pose, Stream};
use cranny_task::{Carrier, FailureReason, Grip, PlaceAt, Placement, Placer, Problem, State};

use crate::stages::effort::Effort;
use crate::stages::later_stage_checks::LaterStageChecks;
use crate::stages::onward::{Towards, Way, ik_solutions, onward};

/// Number of descents after which the transfer search starts.
const ENOUGH_ENDS: usize = 4;
/// Number of descents without a continuation after which the grasp is rejected.
const MOST_DEAD_ENDS: usize = 4;
/// Maximum number of sampled placements if another object is picked after the present one is put down …
const MOST_DRAWS_AHEAD: u32 = 2000;
/// … the number of checks of later stages from them …
const MOST_LOOKS: u32 = 20_000;
/// … and the number of promising ones after which the checks stop.
const ENOUGH_HOPES: usize = 12;
/// Random stream of the IK starts, distinct from other streams of the same seed.
const STARTS_STREAM: u64 = 0x91ac_e001;

/// Placements of an object in the hand, for every grasp.
pub(crate) struct PlaceSearch {
    carrier: Arc<Carrier>,
    placer: Placer,
    /// Least length of the straight retreat, in metres; 0: the retreat need not be straight.
    retreat_m: f64,
    home: Vec<f64>,
    seed: u64,
}

/// Placements, by number, after which a later stage failed, each with the count of these failures.
pub(crate) type Spoiled = BTreeMap<usize, u32>;

/// A set-down path from its start, at whose end the hand can open, and the number of its placement.
struct Descent {
    path: Vec<Vec<f64>>,
    placement: usize,
}

/// Paths that put an object down.
pub(crate) struct PutDown {
    /// Path to the start of the set-down.
    pub transfer: Way,
    pub set_down: Vec<Vec<f64>>,
    pub retreat: Vec<Vec<f64>>,
    /// State at the end of the retreat.
    pub after: State,
    /// Number of the placement.
    pub placement: usize,
}

impl PlaceSearch {
    /// Creates the placement search for the object of a carrier in a stage.
    pub fn new(
        problem: &Problem,
        carrier: &Arc<Carrier>,
        (stage, place): (usize, &PlaceAt),
        ahead: &LaterStageChecks,
        effort: &Effort,
    ) -> Result<Self, PlanError> {
        let placer = Placer::new(problem, carrier, place)?;
        let placer = if ahead.is_needed_after(stage) {
            let placer = placer.with_aligned_draws(effort.seed, MOST_DRAWS_AHEAD);
            let mut looks = MOST_LOOKS;
            placer.with_first(ENOUGH_HOPES, |placement| {
                !effort.left().is_zero() && ahead.is_hopeful((stage, carrier), placement, &mut looks)
            })
        } else if ahead.is_needed_after(0) {
            placer.with_aligned_draws(effort.seed, MOST_DRAWS_AHEAD)
        } else {
            placer.with_placements(effort.seed)
        };
        let (home, seed) = (problem.start().to_vec(), effort.seed);
        Ok(Self { carrier: carrier.clone(), placer, retreat_m: place.retreat_m, home, seed })
    }

    /// Returns true if any placement of the object alone is feasible.
    pub fn has_any(&self) -> bool {
        self.placer.placements().next().is_some()
    }

    /// Returns the reason why an object gripped with the tip at a pose in the planning frame can be released nowhere.
    pub fn blocked_at(&self, world_from_tip: &Pose) -> Option<FailureReason> {
        self.placer.blocked_at(world_from_tip)
    }

    /// Searches for descents to placements where the arm can set the object down and open its hand, until there are
    /// [`ENOUGH_ENDS`]; placements after which a later stage failed come last.
    fn descents(
        &self,
        effort: &Effort,
        (grip, off): (&Grip, &[f64]),
        spoiled: &Spoiled,
        observer: &dyn Observer,
    ) -> Result<Vec<Descent>, FailureReason> {
        let mut random = Stream::new(self.seed, STARTS_STREAM);
        let (mut descents, mut reason) = (Vec::new(), FailureReason::NoPlace);
        let times = |number: &usize| spoiled.get(number).copied().unwrap_or(0);
        let mut sorted = Vec::new();
        if !spoiled.is_empty() {
            sorted.extend(self.placer.placements());
            sorted.sort_by_key(|(number, _)| times(number));
        }
        let unsorted = self.placer.placements().filter(|_| spoiled.is_empty());
        for (number, placement) in sorted.into_iter().chain(unsorted) {
            match self.descents_to(placement, grip, off, &mut random) {
                Ok(found) => {
                    descents.extend(found.into_iter().map(|path| Descent { path, placement: number }));
                }
                Err(met) if is_later(&met, &reason) => reason = met,
                Err(_) => {}
            }
            if descents.len() >= ENOUGH_ENDS || observer.should_stop() || effort.left().is_zero() {
                break;
            }
        }
        if descents.is_empty() { Err(reason) } else { Ok(descents) }
    }

    fn descents_to(
        &self,
        placement: &Placement,
        grip: &Grip,
        off: &[f64],
        random: &mut Stream,
    ) -> Result<Vec<Vec<Vec<f64>>>, FailureReason> {
        let world_from_tip = self.placer.tip_at(grip, placement)?;
        let near = placement.grip_near(grip).map_err(|_| FailureReason::NoPlace)?;
        let [near, _] = near.cells();
        let mut scratch = near.scratch();
        let mut blocked = None;
        let mut accept = |q: &[f64]| {
            if near.is_free(q, &mut scratch) {
                return true;
            }
            blocked = near.first_contact(q, &mut scratch).or(blocked.take());
            false
        };
        let search = ik_solutions(near, &world_from_tip, &[off, &self.home], random, &mut accept);
        let mut reason = match &blocked {
            Some(contact) => {
                let [first, second] = contact.names(near);
                FailureReason::SetDownBlocked { first, second }
            }
            None => FailureReason::PlaceOutOfReach,
        };
        let mut descents = Vec::new();
        for solution in search.solutions() {
            let opens = self.carrier.opens(grip, &solution.q);
            match opens.and_then(|()| self.carrier.set_down(grip, placement, &solution.q)) {
                Ok(descent) => descents.push(descent),
                Err(met) => reason = met,
            }
        }
        if descents.is_empty() { Err(reason) } else { Ok(descents) }
    }

    /// Opens the hand after the set-down, and retreats from the object.
    fn leave(&self, state: &State, set_down: &[Vec<f64>]) -> Result<(Vec<Vec<f64>>, State), FailureReason> {
        let down = set_down.last().ok_or(FailureReason::NotBroughtThere)?;
        let open = state.at(down).opened()?;
        let retreat = open.retreat(self.placer.clear_m(), self.retreat_m)?;
        let after = retreat.last().map_or_else(|| open.clone(), |last| open.at(last));
        Ok((retreat, after))
    }
}

/// Iterator over put-downs of the object in one grasp.
pub(crate) struct PutDowns<'a> {
    search: &'a PlaceSearch,
    /// State with the object off its initial support.
    state: &'a State,
    led: &'a [Vec<f64>],
    descents: Vec<Descent>,
    dead_ends: usize,
    reason: FailureReason,
}

impl<'a> PutDowns<'a> {
    /// Starts at a state to which the path `led` of way points (m, rad; one value per joint) led, as in [`onward`].
    pub fn new(search: &'a PlaceSearch, state: &'a State, led: &'a [Vec<f64>]) -> Self {
        Self {
            search,
            state,
            led,
            descents: Vec::new(),
            dead_ends: 0,
            reason: FailureReason::NotBroughtThere,
        }
    }

    /// Returns the next put-down.
    ///
    /// 1. Search for placements where the arm can set the object down and open its hand.
    /// 2. Search for a path to the start of one of the descents: through the start of the robot, along the path that led to the
    ///    grasp as far as it is free; if that fails, directly.
    /// 3. Search for a retreat of the open hand.
    pub fn next(
        &mut self,
        effort: &mut Effort,
        spoiled: &Spoiled,
        observer: &dyn Observer,
    ) -> Result<PutDown, FailureReason> {
        let Some((_, grip)) = self.state.held() else { return Err(FailureReason::ClosesOnNothing) };
        while self.dead_ends < MOST_DEAD_ENDS && !(self.dead_ends > 0 && effort.left().is_zero()) {
            // 1.
            if self.descents.is_empty() {
                if self.dead_ends > 0 && spoiled.is_empty() {
                    break;
                }
                self.descents = self.search.descents(effort, (grip, &self.state.q), spoiled, observer)?;
            }
            // 2.
            let transfer = transfer(effort, self.state, self.led, &self.descents, observer)?;
            let at = self.descents.iter().position(|descent| descent.path.first() == transfer.0.last());
            let Descent { path: set_down, placement } =
                self.descents.swap_remove(at.ok_or(FailureReason::NotBroughtThere)?);
            self.dead_ends += 1;
            // 3.
            match self.search.leave(self.state, &set_down) {
                Ok((retreat, after)) => return Ok(PutDown { transfer, set_down, retreat, after, placement }),
                Err(met) => self.reason = met,
            }
        }
        Err(self.reason.clone())
    }

    /// Records that a placement has no continuation, for a reason; if a later stage failed, other descents to it are dropped.
    pub fn reject(&mut self, placement: usize, reason: FailureReason, is_spoiled: bool) {
        self.reason = reason;
        if is_spoiled {
            self.descents.retain(|descent| descent.placement != placement);
        }
    }
}

/// Returns a path to the start of one of the descents, and the problem that it solves.
fn transfer(
    effort: &mut Effort,
    state: &State,
    led: &[Vec<f64>],
    descents: &[Descent],
    observer: &dyn Observer,
) -> Result<Way, FailureReason> {
    let not_there = FailureReason::NotBroughtThere;
    let ends: Vec<Vec<f64>> = descents.iter().filter_map(|descent| descent.path.first()).cloned().collect();
    let mut path = None;
    if !led.is_empty() {
        match onward(effort, state, led, &Towards::Begin, observer) {
            Ok((mut out, _)) => {
                let from = out.pop().ok_or(FailureReason::NotCarried)?;
                let problem = state.at(&from).moving(ends.clone()).map_err(|_| not_there.clone())?;
                let on = effort.search(&problem, observer).map_err(|_| not_there.clone())?;
                path = on.map(|on| [out, on].concat());
            }
            Err(FailureReason::NotCarried) => {}
            Err(reason) => return Err(reason),
        }
    }
    let path = if let Some(path) = path {
        path
    } else {
        let problem = state.moving(ends).map_err(|_| not_there.clone())?;
        effort.search(&problem, observer).map_err(|_| not_there.clone())?.ok_or(not_there.clone())?
    };
    let end = path[path.len() - 1..].to_vec();
    Ok((path, state.moving(end).map_err(|_| not_there.clone())?))
}

/// Returns true if `reason` occurs later in the sequence of motions than `than`.
fn is_later(reason: &FailureReason, than: &FailureReason) -> bool {
    let stage = |reason: &FailureReason| match reason {
        FailureReason::NoPlace => 0,
        FailureReason::PlaceBlocked { .. } => 1,
        FailureReason::PlaceOutOfReach => 2,
        FailureReason::SetDownBlocked { .. } | FailureReason::SetDownOutOfReach => 3,
        FailureReason::OpeningCollides { .. } => 4,
        _ => 5,
    };
    stage(reason) > stage(than)
}
