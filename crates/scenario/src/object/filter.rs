use cranny_collision::{Body, World};
use cranny_grasp::Hand;
use cranny_shape::{Solid, Surface, TriangleSoup};
use cranny_spatial::Pose;
use cranny_task::HandFilter;

use crate::ScenarioError;

/// The filter of a hand against an object in its own frame, and `others` around it; an object whose mesh encloses
/// nothing is only its surface.
///
/// # Errors
/// Those of [`World::new`] and [`HandFilter::new`].
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
