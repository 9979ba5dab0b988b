use cranny_collision::Body;
use cranny_scenario::Scenario;
use cranny_sense::SeenMap;

use crate::ExploreError;

/// Returns a scenario with seen space in which the unseen cells are free; the walls around the mapped region stay.
pub(crate) fn with_unseen_free(seen: &Scenario) -> Result<Scenario, ExploreError> {
    let Ok(unseen) = seen.world.body_index(SeenMap::UNSEEN) else { return Ok(seen.clone()) };
    let body = seen.world.bodies()[unseen].clone();
    let parts: Vec<_> = body.parts.iter().filter(|part| part.solid.as_union().is_none()).cloned().collect();
    let without = seen.without_body(SeenMap::UNSEEN)?;
    if parts.is_empty() {
        return Ok(without);
    }
    Ok(without.with_body(Body { parts, ..body })?)
}

/// Returns a scenario with seen space in which all cells are free; known bodies and the walls around the mapped region stay.
pub(crate) fn with_cells_free(seen: &Scenario) -> Result<Scenario, ExploreError> {
    let free = with_unseen_free(seen)?;
    if free.world.body_index(SeenMap::OCCUPIED).is_err() {
        return Ok(free);
    }
    Ok(free.without_body(SeenMap::OCCUPIED)?)
}
