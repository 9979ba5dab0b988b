use cranny_collision::{Body, World};
use cranny_grasp::Hand;
use cranny_shape::{Solid, Surface, TriangleSoup};
use cranny_spatial::Pose;
use cranny_task::HandFilter;

use crate::ScenarioError;

/// Returns the filter of a hand for an object in its own frame, surrounded by `others`; an object whose mesh encloses no volume
/// is represented by its surface only.
///
/// # Errors
/// As [`World::new`] and [`HandFilter::new`].
pub fn filter_around_object(
    hand: &Hand,
    mesh: &TriangleSoup,
    surface: &Surface,
    mut others: Vec<Body>,
    approach_m: f64,
) -> Result<HandFilter, ScenarioError> {
    let solid = Solid::mesh(mesh).ok();
    let is_open = solid.is_none();
    others.extend(solid.map(|solid| Body::new("object", Pose::identity(), solid)));
    let filter = HandFilter::new(hand, World::new(others)?, approach_m)?;
    Ok(if is_open { filter.with_surface(Pose::identity(), surface.clone()) } else { filter })
}
