use cranny_plan::{
    AfterPlacing, Carrier, FailureReason, Grip, Observer, PlaceSettings, Placed, Placement, Placer,
    PlanError, Problem,
};
use cranny_robot::{IkSearch, IkSearchSettings, IkSettings};
use cranny_spatial::{Pose, Stream};

use crate::ways_out::WaysOut;

/// Random starts of inverse kinematics at a placement.
const ATTEMPTS: usize = 32;
/// Configurations at one placement that are looked at.
const CONFIGURATIONS: usize = 2;
/// So many ends of ways down are enough for a search of the way there.
const ENOUGH_ENDS: usize = 4;
/// Ways down that are given up, because nothing leads on from where they end, before the grasp is.
const MOST_DEAD_ENDS: usize = 4;
/// What tells the random starts from other draws of the same seed.
const STARTS_STREAM: u64 = 0x91ac_e001;

/// Looks for ways from where an object is lifted off to where it is put down, and off it.
pub(crate) struct PutDown {
    placer: Placer,
    home: Vec<f64>,
    seed: u64,
}

/// The way off an object, and the way back with the problem that it solves, if there is one.
type Leaving = (Vec<Vec<f64>>, Option<(Vec<Vec<f64>>, Problem)>);

/// The pieces that follow a lift-off: those that can be shortened with the problem that they solve.
pub(crate) struct WayDown {
    pub carry: (Vec<Vec<f64>>, Problem),
    pub set_down: Vec<Vec<f64>>,
    pub retreat: Vec<Vec<f64>>,
    pub back: Option<(Vec<Vec<f64>>, Problem)>,
}

/// A way down, from where it begins on, at whose end the hand can open.
type Descent = Vec<Vec<f64>>;

impl PutDown {
    pub fn new(
        problem: &Problem,
        carrier: &Carrier,
        settings: &PlaceSettings,
        seed: u64,
    ) -> Result<Self, PlanError> {
        let placer = Placer::new(carrier, settings.clone())?.with_placements(seed);
        Ok(Self { placer, home: problem.start().to_vec(), seed })
    }

    /// Why an object that is gripped with the tip at a pose can be let go nowhere.
    pub fn blocked_at(&self, world_from_tip: &Pose) -> Option<FailureReason> {
        self.placer.blocked_at(world_from_tip)
    }

    /// A way from the end of a lift-off to a place, and off it.
    ///
    /// 1. Places where the arm can set the object down and open its hand.
    /// 2. A way to where one of the ways down begins: by where the robot started from, along the way that led to the grasp as
    ///    far as it is free; where that fails, directly.
    /// 3. A way off the object for the open hand, and back, if it is to go back.
    pub fn find(
        &self,
        ways_out: &mut WaysOut,
        grip: &Grip,
        off: &[f64],
        reach: &[Vec<f64>],
        observer: &mut dyn Observer,
    ) -> Result<WayDown, FailureReason> {
        // 1.
        let mut descents = self.descents(ways_out, grip, off, observer)?;
        let mut reason = FailureReason::NotBroughtThere;
        for _ in 0..MOST_DEAD_ENDS {
            // 2.
            let carry = transfer(ways_out, grip, off, reach, &descents, observer)?;
            let at = descents.iter().position(|descent| descent.first() == carry.0.last());
            let set_down = descents.swap_remove(at.ok_or(FailureReason::NotBroughtThere)?);
            // 3.
            match self.leave(ways_out, grip, &set_down, observer) {
                Ok((retreat, back)) => return Ok(WayDown { carry, set_down, retreat, back }),
                Err(met) => reason = met,
            }
            if descents.is_empty() || ways_out.left().is_zero() {
                break;
            }
        }
        Err(reason)
    }

    /// The way off the object where it was set down, and the way back with the problem that it solves, if there is to be one.
    fn leave(
        &self,
        ways_out: &mut WaysOut,
        grip: &Grip,
        set_down: &Descent,
        observer: &dyn Observer,
    ) -> Result<Leaving, FailureReason> {
        let down = set_down.last().ok_or(FailureReason::NotBroughtThere)?;
        let placed = self.placer.open(grip, down)?;
        let retreat = placed.retreat(down, self.placer.settings().clear_m)?;
        if self.placer.settings().then == AfterPlacing::Stay {
            return Ok((retreat, None));
        }
        let back = self.way_back(ways_out, &placed, &retreat, observer).ok_or(FailureReason::NotReturned)?;
        Ok((retreat, Some(back)))
    }

    fn descents(
        &self,
        ways_out: &WaysOut,
        grip: &Grip,
        off: &[f64],
        observer: &dyn Observer,
    ) -> Result<Vec<Descent>, FailureReason> {
        let mut random = Stream::new(self.seed, STARTS_STREAM);
        let (mut descents, mut reason) = (Vec::new(), FailureReason::NoPlace);
        for placement in self.placer.placements() {
            match self.descents_to(placement, grip, off, &mut random) {
                Ok(found) => descents.extend(found),
                Err(met) if is_later(&met, &reason) => reason = met,
                Err(_) => {}
            }
            if descents.len() >= ENOUGH_ENDS || observer.should_stop() || ways_out.left().is_zero() {
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
    ) -> Result<Vec<Descent>, FailureReason> {
        let world_from_tip = self.placer.tip_at(grip, placement)?;
        let near = placement.grip_near(grip).map_err(|_| FailureReason::NoPlace)?;
        let [near, _] = near.cells();
        let ik = IkSettings {
            translation_tolerance_m: 1e-6,
            rotation_tolerance_rad: 1e-5,
            ..IkSettings::default()
        };
        let mut search = IkSearch::new(
            near.robot(),
            &world_from_tip,
            IkSearchSettings { ik, ..IkSearchSettings::default() },
        );
        let mut scratch = near.scratch();
        let mut blocked = None;
        let mut accept = |q: &[f64]| {
            if near.is_free(q, &mut scratch) {
                return true;
            }
            blocked = near.first_contact(q, &mut scratch).or(blocked.take());
            false
        };
        for start in [off, &self.home] {
            search.next_from(start, &mut accept);
        }
        while search.solutions().len() < CONFIGURATIONS
            && search.attempts() < ATTEMPTS
            && search.next_solution(random, ATTEMPTS, &mut accept).is_some()
        {}
        let mut reason = match &blocked {
            Some(contact) => {
                let [first, second] = contact.names(near);
                FailureReason::SetDownBlocked { first, second }
            }
            None => FailureReason::PlaceOutOfReach,
        };
        let mut descents = Vec::new();
        for solution in search.solutions() {
            match self.descent(placement, grip, &solution.q) {
                Ok(descent) => descents.push(descent),
                Err(met) => reason = met,
            }
        }
        if descents.is_empty() { Err(reason) } else { Ok(descents) }
    }

    fn descent(&self, placement: &Placement, grip: &Grip, q: &[f64]) -> Result<Descent, FailureReason> {
        self.placer.opens(grip, q)?;
        self.placer.set_down(grip, placement, q)
    }

    fn way_back(
        &self,
        ways_out: &mut WaysOut,
        placed: &Placed,
        retreat: &[Vec<f64>],
        observer: &dyn Observer,
    ) -> Option<(Vec<Vec<f64>>, Problem)> {
        let problem = placed.leaving(retreat.last()?, vec![self.home.clone()]).ok()?;
        let path = ways_out.search(&problem, observer).ok()??;
        Some((path, problem))
    }
}

/// A way to where one of the ways down begins, and the problem that it solves.
fn transfer(
    ways_out: &mut WaysOut,
    grip: &Grip,
    off: &[f64],
    reach: &[Vec<f64>],
    descents: &[Descent],
    observer: &mut dyn Observer,
) -> Result<(Vec<Vec<f64>>, Problem), FailureReason> {
    let not_there = |_: PlanError| FailureReason::NotBroughtThere;
    let ends: Vec<Vec<f64>> = descents.iter().filter_map(|descent| descent.first()).cloned().collect();
    let carrying = |from: &[f64], to: &[Vec<f64>]| grip.carrying(from, to.to_vec()).map_err(not_there);
    let by_start = |ways_out: &mut WaysOut, observer: &mut dyn Observer| {
        let (mut out, _) = ways_out.find(grip, off, reach, observer)?;
        let from = out.pop().ok_or(FailureReason::NotCarried)?;
        let on = ways_out.search(&carrying(&from, &ends)?, observer).map_err(not_there)?;
        Ok(on.map(|on| [out, on].concat()))
    };
    let path = match by_start(ways_out, observer) {
        Ok(Some(path)) => Some(path),
        Ok(None) | Err(FailureReason::NotCarried) => {
            ways_out.search(&carrying(off, &ends)?, observer).map_err(not_there)?
        }
        Err(reason) => return Err(reason),
    };
    let path = path.ok_or(FailureReason::NotBroughtThere)?;
    let end = path[path.len() - 1..].to_vec();
    Ok((path, carrying(off, &end)?))
}

/// Whether one reason was met later on the way than another.
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
