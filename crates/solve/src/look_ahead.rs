use std::sync::Arc;

use cranny_plan::{
    Carrier, LiftOffSettings, Pick, PlaceAt, Placement, Placer, PlanError, Problem, Stage, State,
};
use cranny_spatial::Pose;

/// Draws of the next place that are looked at for one where its object can be.
const MOST_DRAWS: usize = 64;

/// Conditions under which the next pick after a place, and the place of that object, may be possible once an object stands
/// at a placement: no configuration is looked for.
pub(crate) struct LookAhead {
    problem: Problem,
    carrier: Arc<Carrier>,
    pick: Pick,
    /// The next object in the hand, and where it is put down.
    next: Option<(Carrier, Option<Placer>)>,
}

impl LookAhead {
    /// Of the stages after a place of what a carrier carries; `None` where nothing is picked after it.
    pub fn of(
        problem: &Problem,
        after: &[Stage],
        carrier: &Arc<Carrier>,
        seed: u64,
    ) -> Result<Option<Self>, PlanError> {
        let mut after = after.iter().filter(|stage| !matches!(stage, Stage::Move(_)));
        let Some(Stage::Pick(pick)) = after.next() else { return Ok(None) };
        let then = match after.next() {
            Some(Stage::Place(place)) => Some(place),
            _ => None,
        };
        let (problem, carrier, pick) = (problem.clone(), carrier.clone(), pick.clone());
        let ahead = Self { problem, carrier, pick, next: None };
        // What is the same in every world is made in the present one.
        let now = ahead.picking(&ahead.carrier.world_from_object())?;
        let next = Carrier::new(&now, LiftOffSettings::default()).ok();
        let with_place = |next: Carrier| -> Result<(Carrier, Option<Placer>), PlanError> {
            let Some(PlaceAt { place, clear_m }) = then else { return Ok((next, None)) };
            let placer = Placer::new(&next, ahead.problem.place(place)?, *clear_m)?.with_placements(seed);
            Ok((next, Some(placer)))
        };
        let next = next.map(with_place).transpose()?;
        Ok(Some(Self { next, ..ahead }))
    }

    /// True unless the next pick, or its place, is known to be impossible.
    pub fn is_hopeful(&self, placement: &Placement) -> bool {
        let Ok(picking) = self.picking(&placement.world_from_held) else { return false };
        if !picking.may_be_grasped() {
            return false;
        }
        let (Some((next, placer)), Some(cell)) = (&self.next, picking.cell()) else { return true };
        next.amid(cell).is_ok_and(|next| {
            placer.as_ref().is_none_or(|placer| placer.amid(&next).has_placement(MOST_DRAWS))
        })
    }

    /// The problem of the next pick with the object at a pose of its first solid.
    fn picking(&self, world_from_held: &Pose) -> Result<Problem, PlanError> {
        let placed = State::after_letting_go(&self.carrier, world_from_held, self.problem.start())?;
        placed.picking(&self.problem, &self.pick)
    }
}
