use cranny_sense::{Camera, SensedScene, View};
use cranny_spatial::Point;

use crate::ExploreError;
use crate::prediction::Predictions;

/// Pose that may become the next view.
pub(crate) struct Choice<T> {
    /// Value by the cells whose centres the camera sees.
    pub value: f64,
    pub camera: Camera,
    /// Number of blocking cells that the view is predicted to show to be free; `None` if it was not predicted.
    pub frees: Option<usize>,
    /// Anything that goes with the camera.
    pub with: T,
}

/// Factor on the value of a camera for each view from a similar pose: what it left unseen, another view from there may not show either.
const REPEATED: f64 = 0.3;

/// Returns the choices of a positive value, the best first: of each group of similar cameras the best, as far as `most`, and these by
/// the cells that they are predicted to free, if views were taken before. Equal ones stay in order. `accepts` may refuse cameras;
/// `known` gives the known bodies with the robot.
///
/// # Errors
/// Those of [`Predictions::frees`].
pub(crate) fn ranked<T>(
    mut choices: Vec<Choice<T>>,
    most: usize,
    focus: &Point,
    views: &[View],
    predictions: Option<&Predictions>,
    accepts: &mut dyn FnMut(&Camera) -> bool,
    known: impl Fn(&Choice<T>) -> Result<SensedScene, ExploreError>,
) -> Result<Vec<Choice<T>>, ExploreError> {
    let repeated = |camera: &Camera| {
        let similar = views.iter().filter(|view| is_similar(&view.camera, camera, focus));
        similar.fold(1.0, |factor, _| factor * REPEATED)
    };
    for choice in &mut choices {
        choice.value *= repeated(&choice.camera);
    }
    choices.retain(|choice| choice.value > 0.0);
    choices.sort_by(|a, b| b.value.total_cmp(&a.value));
    let mut best: Vec<Choice<T>> = Vec::new();
    for choice in choices {
        let is_new = best.iter().all(|other| !is_similar(&other.camera, &choice.camera, focus));
        // A refused camera does not hide its neighbours.
        if is_new && accepts(&choice.camera) {
            best.push(choice);
        }
        if best.len() == most {
            break;
        }
    }
    let Some(predictions) = predictions else { return Ok(best) };
    for choice in &mut best {
        let frees = predictions.frees(&choice.camera, &known(choice)?)?;
        choice.frees = Some(frees);
        choice.value = frees as f64 * repeated(&choice.camera);
    }
    best.sort_by(|a, b| b.value.total_cmp(&a.value));
    Ok(best)
}

/// Returns true if a camera sees a point from about the direction of another one that has it in its image, and not much nearer.
fn is_similar(other: &Camera, camera: &Camera, point: &Point) -> bool {
    /// Cosine of the angle between the directions, and share of the distance below which a camera is much nearer.
    const COSINE: f64 = 0.9;
    const NEARER: f64 = 0.6;
    let in_other = other.world_from_camera.inverse_transform_point(point);
    let is_shown = other.project(&in_other).is_some_and(|[u, v]| {
        (0.0..other.width_px as f64).contains(&(u + 0.5))
            && (0.0..other.height_px as f64).contains(&(v + 0.5))
    });
    let towards = |camera: &Camera| Point::from(camera.world_from_camera.translation.vector) - point;
    let (there, here) = (towards(other), towards(camera));
    is_shown && there.dot(&here) > COSINE * there.norm() * here.norm() && here.norm() > NEARER * there.norm()
}
