//! Places and tasks of a scenario whose bodies have changed.

use std::mem::take;

use cranny_scenario::{NamedTask, Scenario};
use cranny_task::{Pick, PlaceAt, PlaceGoal, PlaceRegion, Stage};

/// Returns the scenario without the places on bodies that are not, or no longer, its obstacles, without poses to place a target that it
/// does not have, and without the tasks that name such a place or such a body.
pub fn without_lost_places(mut scenario: Scenario) -> Scenario {
    let (mut places, mut tasks) = (take(&mut scenario.places), take(&mut scenario.tasks));
    let Scenario { world, target, .. } = &scenario;
    let is_obstacle = |name: &str| world.body_index(name).is_ok_and(|body| Some(body) != *target);
    places.retain(|place: &PlaceGoal| match &place.spot {
        PlaceRegion::Surface { on, .. } => is_obstacle(on),
        PlaceRegion::Target(_) => target.is_some(),
    });
    let is_known = |stage: &Stage| match stage {
        Stage::Pick(Pick { object: Some(object), .. }) => world.body_index(object).is_ok(),
        Stage::Place(PlaceAt { place, .. }) => places.iter().any(|known| known.name == *place),
        Stage::Pick(_) | Stage::Move(_) => true,
    };
    tasks.retain(|task: &NamedTask| task.stages.iter().all(is_known));
    Scenario { places, tasks, ..scenario }
}
