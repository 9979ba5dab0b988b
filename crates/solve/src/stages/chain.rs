mod first_move;

use std::sync::Arc;
use std::time::Instant;

use cranny_plan::{Budget, Observer, Outcome, PlanError, PlanReport, Planner, RefusedClaim, begin_search};
use cranny_spatial::Pose;
use cranny_task::{
    Carrier, FailureReason, GraspFailure, LiftOffSettings, Mode, Move, Pick, PlaceAt, Problem, Segment,
    Stage, State,
};

use crate::hold_factors::FirmGrip;
use crate::stages::approach::{Approach, approach, blocked_approach};
use crate::stages::effort::{Effort, First, Stop};
use crate::stages::later_stage_checks::LaterStageChecks;
use crate::stages::later_stages::{blocked_after, is_of_later_pick, of_stage};
use crate::stages::onward::{Piece, Towards, Way, onward};
use crate::stages::place_search::{PlaceSearch, PutDowns, Spoiled};
use crate::stages::refusals::{Demanded, Refusals, add_failed, add_own};
use crate::{Request, SolveError};

/// Pieces through all remaining stages, or the reason why there are none.
type Through = Result<Vec<Piece>, FailureReason>;

/// Maximum number of end configurations of a move that are tried before the stage is given up.
const MOST_ENDS: usize = 4;

/// Search for a path through the stages of a task: depth first, with backtracking over all stages.
///
/// 1. The planner searches for a path to the goal of the first stage, with the whole budget. Each path that it finds is a
///    candidate.
/// 2. From the end of a candidate each next stage yields one candidate after another: a grasp and the path to it; a path; a
///    transfer to a placement, a set-down and a retreat. Searches after the first stage have short budgets that grow with the
///    number of those that failed ([`Effort`]).
/// 3. If the next stage yields no candidate after this one, this one is rejected and the next one is tried. A placement after
///    which a later pick failed is tried last from then on.
/// 4. If several objects are picked, the search restarts from another seed while time remains.
pub(crate) struct Chain<'a> {
    problem: &'a Problem,
    stages: &'a [Stage],
    request: &'a Request,
    start: State,
    effort: Effort,
    ahead: LaterStageChecks,
    failures: Vec<GraspFailure>,
    /// Spoiled placements, by stage.
    spoiled: Vec<Spoiled>,
    /// Number of searches started for picks, by stage.
    begun: Vec<u64>,
    outcome: Outcome,
    /// Path of the first stage that was claimed and refused.
    refused: Option<RefusedClaim>,
    /// The carrier of the first object, if the first of several stages is a pick.
    pub first_carrier: Option<Arc<Carrier>>,
}

/// The object in the hand from the lift-off on.
struct Held<'a> {
    carrier: &'a Arc<Carrier>,
    /// Search for placements, if the object is put down.
    places: Option<Arc<PlaceSearch>>,
    /// The path that led to the grasp; empty if the arm has moved since.
    led: &'a [Vec<f64>],
    /// Forces of the grip, if a load factor is required and can be computed.
    grip: Option<&'a FirmGrip>,
}

impl<'a> Chain<'a> {
    /// # Errors
    /// [`TaskError::NothingToCarry`] under `paper`, and those of [`LaterStageChecks::new`].
    pub fn new(
        problem: &'a Problem,
        stages: &'a [Stage],
        request: &'a Request,
        first_carrier: Option<Arc<Carrier>>,
    ) -> Result<Self, PlanError> {
        let start = State::start(problem)
            .ok_or(cranny_task::TaskError::NothingToCarry { needs: "the exact criterion" })?;
        let places = stages.iter().any(|stage| matches!(stage, Stage::Place(_)));
        let effort = Effort::new((request.seed, request.budget.time), places);
        let (spoiled, begun) = (vec![Spoiled::new(); stages.len()], vec![0; stages.len()]);
        let (failures, outcome) = (Vec::new(), Outcome::BudgetExhausted);
        let ahead = LaterStageChecks::new(problem, stages, &start, request.seed)?;
        Ok(Self {
            problem,
            stages,
            request,
            start,
            effort,
            ahead,
            failures,
            spoiled,
            begun,
            outcome,
            refused: None,
            first_carrier,
        })
    }

    /// Runs the search; returns the report of all searches together, and the pieces of a path, if one was found.
    pub fn search(
        mut self,
        planner: &dyn Planner,
        observer: &mut dyn Observer,
    ) -> Result<(PlanReport, Vec<Piece>), SolveError> {
        let begin = Instant::now();
        let start = self.start.clone();
        let picks = self.stages.iter().filter(|stage| matches!(stage, Stage::Pick(_))).count();
        let found = loop {
            let found = self.first(planner, &start, observer)?;
            let spent = self.effort.spent.iterations;
            let is_over = self.outcome == Outcome::Cancelled
                || self.effort.left().is_zero()
                || spent >= self.request.budget.iterations;
            let is_later = |failure: &GraspFailure| is_of_later_pick(self.stages, 0, &failure.reason);
            let may_find = matches!(self.outcome, Outcome::BudgetExhausted | Outcome::ClaimedNotProven)
                || self.failures.iter().any(is_later);
            if found.is_some() || picks < 2 || is_over || !may_find {
                break found;
            }
        };
        let outcome = if found.is_some() { Outcome::Solved } else { self.outcome };
        let pieces = found.unwrap_or_default();
        let mut statistics = self.effort.spent;
        statistics.planning_time_s = begin.elapsed().as_secs_f64();
        let path = pieces.first().map(|(segment, _)| segment.waypoints.clone()).unwrap_or_default();
        let failures = if outcome == Outcome::Solved { Vec::new() } else { self.failures };
        let refused = self.refused.filter(|_| outcome == Outcome::ClaimedNotProven);
        Ok((PlanReport { outcome, path, statistics, failures, refused }, pieces))
    }

    /// Searches the first stage, and from there all others.
    fn first(
        &mut self,
        planner: &dyn Planner,
        start: &State,
        observer: &mut dyn Observer,
    ) -> Result<Option<Vec<Piece>>, SolveError> {
        let budget = Budget { time: self.effort.left(), ..self.request.budget };
        let through = match &self.stages[0] {
            Stage::Pick(pick) => self.pick((0, pick), (planner, budget), start, observer)?,
            Stage::Move(goal) => self.first_move(goal, (planner, budget), start, observer)?,
            Stage::Place(_) => return Ok(None),
        };
        Ok(through.ok())
    }

    /// Searches the stages from `index` on.
    fn through(
        &mut self,
        index: usize,
        state: &State,
        held: Option<&Held<'_>>,
        observer: &mut dyn Observer,
    ) -> Result<Through, SolveError> {
        match (self.stages.get(index), held) {
            (None, _) => Ok(Ok(Vec::new())),
            (Some(_), _) if self.effort.left().is_zero() => Ok(Err(FailureReason::NotTried)),
            (Some(Stage::Move(goal)), _) => {
                let moved = self.move_on((index, goal), state, held, observer)?;
                Ok(moved.map_err(|because| of_stage(index, because)))
            }
            (Some(Stage::Place(place)), Some(held)) => {
                let placed = self.place((index, place), state, held, observer)?;
                Ok(placed.map_err(|because| of_stage(index, because)))
            }
            (Some(Stage::Place(_)), None) => Ok(Err(FailureReason::NoPlace)),
            (Some(Stage::Pick(pick)), _) => {
                let planner = self.request.later_planner_for(&state.picking(self.problem, pick)?)?;
                let budget = self.effort.next_pick_budget();
                let picked = self.pick((index, pick), (planner.as_ref(), budget), state, observer)?;
                Ok(picked.map_err(|because| match because {
                    FailureReason::Later { .. } => because,
                    because => FailureReason::Later { stage: index, because: Box::new(because) },
                }))
            }
        }
    }

    /// Searches a pick, and from there all stages that follow.
    fn pick(
        &mut self,
        (index, pick): (usize, &Pick),
        (planner, budget): (&dyn Planner, Budget),
        state: &State,
        observer: &mut dyn Observer,
    ) -> Result<Through, SolveError> {
        let picking = state.picking(self.problem, pick)?;
        let before = state.before_picking(&picking);
        let is_last = index + 1 == self.stages.len();
        let carrier = match &self.first_carrier {
            _ if is_last => None,
            Some(known) if index == 0 => Some(known.clone()),
            _ => Some(Arc::new(Carrier::new(&picking, LiftOffSettings::default())?)),
        };
        let places = match &carrier {
            Some(carrier) => self.places_after(index, carrier)?,
            None => None,
        };
        let is_own = picking.grasp_measure().is_some();
        if is_own && places.as_ref().is_some_and(|places| !places.has_any()) {
            if index == 0 {
                let failure = GraspFailure { grasp: 0, reason: FailureReason::NoPlace, attempts: 0 };
                (self.outcome, self.failures) = (Outcome::NoReachableGrasp, vec![failure]);
            }
            return Ok(Err(FailureReason::NoPlace));
        }
        let refusals = Arc::new(Refusals::default());
        let demanded = self.request.hold.filter(|hold| *hold > 0.0);
        let load_model =
            carrier.as_ref().zip(demanded).and_then(|(carrier, _)| carrier.load_model(self.problem));
        let asked = {
            let on_the_way = picking.cell().filter(|_| pick.approach_m > 0.0);
            let on_the_way = on_the_way.map(|cell| blocked_approach(cell, pick.approach_m));
            let after = carrier.as_ref().map(|carrier| {
                blocked_after((self.problem, &self.stages[index + 1..]), carrier, places.as_ref())
            });
            let blocked = move |world_from_tip: &Pose| {
                let before = on_the_way.as_ref().and_then(|blocked| blocked(world_from_tip));
                before.or_else(|| after.as_ref().and_then(|blocked| blocked(world_from_tip)))
            };
            let is_put_down = places.is_some();
            let firm = load_model.clone().zip(demanded);
            let firm = firm.map(|(load_model, factor)| Demanded { load_model, factor, is_put_down, is_own });
            let filter = refusals.filter(self.request.left_out_filter(index), firm, blocked);
            picking.clone().with_grasp_filter(filter)
        };
        let patience = if index == 0 { usize::MAX } else { self.effort.patience() };
        let seed = self.next_seed(index);
        let budget = Budget { time: self.effort.left(), ..budget };
        let mut search = begin_search(planner, &asked, &budget, seed)?;
        let mut failed: Vec<(Pose, FailureReason)> = Vec::new();
        loop {
            let is_hopeless = || refusals.are_all() && (index > 0 || refusals.is_each_weak(&picking));
            let mut report = if index == 0 {
                search.next(&mut First { observer, is_hopeless: &is_hopeless })?
            } else {
                search.next(&mut Stop { observer, is_hopeless: &is_hopeless })?
            };
            if report.outcome == Outcome::Cancelled && is_hopeless() {
                report.outcome = if index > 0 { Outcome::BudgetExhausted } else { Outcome::GaveUp };
            }
            if report.outcome != Outcome::Solved {
                self.effort
                    .count(&report.statistics, if index > 0 { report.outcome } else { Outcome::Solved });
                return Ok(Err(self.not_picked(index, (&picking, &refusals), report, failed)));
            }
            let reached = before.at(report.path.last().map_or(&[], |q| &q[..]));
            let path = std::mem::take(&mut report.path);
            let approach =
                approach(&mut self.effort, (index, &picking), (&before, path), pick.approach_m, observer);
            let through = match (approach, &carrier) {
                (Ok(Approach { pieces, led }), Some(carrier)) => {
                    let robot = self.problem.robot();
                    let grip = load_model
                        .as_ref()
                        .and_then(|load_model| FirmGrip::of(load_model, robot, &reached.q));
                    let held = Held { carrier, places: places.clone(), led: &led, grip: grip.as_ref() };
                    let onward = self.lift_off(index, &reached, &held, observer)?;
                    onward.map(|onward| [pieces, onward].concat())
                }
                (Ok(Approach { pieces, .. }), None) => Ok(pieces),
                (Err(reason), _) => Err(reason),
            };
            match through {
                Ok(pieces) => {
                    self.effort.count(&report.statistics, Outcome::Solved);
                    return Ok(Ok(pieces));
                }
                Err(reason) => {
                    let robot = self.problem.robot();
                    // A reason that was found before stays if the budget ends.
                    if !reason.is_of_budget() {
                        failed.push((*robot.frames_at(&reached.q).link(robot.tip()), reason));
                    }
                    if failed.len() >= patience {
                        self.effort.count(&report.statistics, Outcome::BudgetExhausted);
                        return Ok(Err(self.not_picked(index, (&picking, &refusals), report, failed)));
                    }
                    search.reject();
                }
            }
        }
    }

    /// Records the failures of the first pick; returns the reason of the last candidate, else the planner's most frequent one.
    fn not_picked(
        &mut self,
        index: usize,
        (picking, refusals): (&Problem, &Refusals),
        report: PlanReport,
        failed: Vec<(Pose, FailureReason)>,
    ) -> FailureReason {
        let PlanReport { outcome, mut failures, refused, .. } = report;
        match picking.grasps() {
            _ if picking.grasp_measure().is_some() => add_own(&mut failures, &failed, refusals),
            Some(grasps) => add_failed(&mut failures, grasps, &failed),
            None => {}
        }
        let commonest = GraspFailure::commonest(&failures).cloned();
        if index == 0 {
            (self.outcome, self.failures, self.refused) = (outcome, failures, refused);
        }
        let last = failed.into_iter().next_back().map(|(_, reason)| reason);
        last.or(commonest).unwrap_or(FailureReason::NotTried)
    }

    /// Closes the hand at a reached grasp, lifts the object off its support, and searches all stages that follow.
    fn lift_off(
        &mut self,
        index: usize,
        reached: &State,
        held: &Held<'_>,
        observer: &mut dyn Observer,
    ) -> Result<Through, SolveError> {
        let lifted = || -> Result<(State, Vec<Vec<f64>>), FailureReason> {
            let closed = reached.closed_on(held.carrier)?;
            let Some((carrier, grip)) = closed.held() else { return Err(FailureReason::ClosesOnNothing) };
            let path = carrier.lift_off(grip, &reached.q)?;
            let off = path.last().map_or_else(|| closed.clone(), |last| closed.at(last));
            Ok((off, path))
        };
        let (off, path) = match lifted() {
            Ok(lifted) => lifted,
            Err(reason) => return Ok(Err(reason)),
        };
        let lift_off = (off.segment(index, Mode::LIFT_OFF, path), None);
        let onward = self.through(index + 1, &off, Some(held), observer)?;
        Ok(onward.map(|onward| [vec![lift_off], onward].concat()))
    }

    /// Searches a move after the first stage, with or without an object in the hand, and all stages that follow.
    fn move_on(
        &mut self,
        (index, goal): (usize, &Move),
        state: &State,
        held: Option<&Held<'_>>,
        observer: &mut dyn Observer,
    ) -> Result<Through, SolveError> {
        let mode = match (held, state.let_go()) {
            (Some(_), _) => Mode::CARRY,
            (None, Some(_)) => Mode::RETURN,
            (None, None) => Mode::REACH,
        };
        let led = held.map_or(&[][..], |held| held.led);
        let mut ends = goal.ends(self.problem);
        let mut reason = FailureReason::NotMoved;
        for _ in 0..MOST_ENDS {
            let Some(towards) = Towards::of(goal, ends.as_deref(), self.problem) else { break };
            let (path, problem): Way = match onward(&mut self.effort, state, led, &towards, observer) {
                Ok(way) => way,
                Err(_) if mode == Mode::RETURN => return Ok(Err(FailureReason::NotReturned)),
                Err(reason) => return Ok(Err(reason)),
            };
            let there = state.at(path.last().map_or(&[], |q| &q[..]));
            let is_firm = held.is_none_or(|held| self.is_firm(held, &path));
            let held = held.map(|held| Held { places: held.places.clone(), led: &[], ..*held });
            let through = if is_firm {
                self.through(index + 1, &there, held.as_ref(), observer)?
            } else {
                Err(FailureReason::Slips)
            };
            match through {
                Ok(onward) => {
                    let segment = if mode.holds {
                        state.segment(index, mode, path)
                    } else {
                        Segment::empty(index, mode, path)
                    };
                    return Ok(Ok([vec![(segment, Some(problem))], onward].concat()));
                }
                Err(met) => reason = met,
            }
            if let Some(ends) = &mut ends {
                ends.retain(|end| *end != there.q);
            }
        }
        Ok(Err(reason))
    }

    /// Puts the object in the hand down, and searches all stages that follow.
    fn place(
        &mut self,
        (index, place): (usize, &PlaceAt),
        state: &State,
        held: &Held<'_>,
        observer: &mut dyn Observer,
    ) -> Result<Through, SolveError> {
        let places = match &held.places {
            Some(places) => places.clone(),
            None => Arc::new(PlaceSearch::new(
                self.problem,
                held.carrier,
                (index, place),
                &self.ahead,
                &self.effort,
            )?),
        };
        let mut put_downs = PutDowns::new(&places, state, held.led);
        loop {
            let put_down = match put_downs.next(&mut self.effort, &self.spoiled[index], observer) {
                Ok(put_down) => put_down,
                Err(reason) => return Ok(Err(reason)),
            };
            let is_firm = self.is_firm(held, &put_down.transfer.0) && self.is_firm(held, &put_down.set_down);
            let through = if is_firm {
                self.through(index + 1, &put_down.after, None, observer)?
            } else {
                Err(FailureReason::Slips)
            };
            match through {
                Ok(onward) => {
                    let (transfer, problem) = put_down.transfer;
                    let pieces = vec![
                        (state.segment(index, Mode::CARRY, transfer), Some(problem)),
                        (state.segment(index, Mode::SET_DOWN, put_down.set_down), None),
                        (Segment::empty(index, Mode::RETREAT, put_down.retreat), None),
                    ];
                    return Ok(Ok([pieces, onward].concat()));
                }
                Err(reason) => {
                    let is_spoiled = is_of_later_pick(self.stages, index, &reason);
                    if is_spoiled {
                        *self.spoiled[index].entry(put_down.placement).or_default() += 1;
                    }
                    put_downs.reject(put_down.placement, reason, is_spoiled);
                }
            }
        }
    }

    /// Returns true if the hold has the required factor at rest in each orientation of a path (m, rad; one value per joint).
    fn is_firm(&self, held: &Held<'_>, path: &[Vec<f64>]) -> bool {
        let demanded = self.request.hold.unwrap_or_default();
        held.grip.is_none_or(|grip| grip.at_rest(self.problem.robot(), path) >= demanded)
    }

    /// Creates the placement search of the stage that puts down the object of a pick; `None` if no stage does.
    fn places_after(
        &self,
        index: usize,
        carrier: &Arc<Carrier>,
    ) -> Result<Option<Arc<PlaceSearch>>, PlanError> {
        let next = (index + 1..self.stages.len()).find(|next| !matches!(self.stages[*next], Stage::Move(_)));
        let Some((next, Stage::Place(place))) = next.map(|next| (next, &self.stages[next])) else {
            return Ok(None);
        };
        let places = PlaceSearch::new(self.problem, carrier, (next, place), &self.ahead, &self.effort)?;
        Ok(Some(Arc::new(places)))
    }

    fn next_seed(&mut self, index: usize) -> u64 {
        let number = self.begun[index];
        self.begun[index] += 1;
        self.effort.seed_of(number)
    }
}
