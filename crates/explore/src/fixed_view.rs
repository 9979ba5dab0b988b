use std::f64::consts::TAU;

use cranny_scenario::Scenario;
use cranny_sense::{Camera, PlacedCamera, View};
use cranny_spatial::{Point, Pose, Vector, sin_cos};
use rayon::prelude::*;

use crate::choice::{Choice, ranked};
use crate::prediction::Predictions;
use crate::prospect::{Prospect, Prospects};
use crate::{Blockage, CameraKind, ExploreError, NextView};

/// Candidates around each point that is aimed at: turns about the vertical, rises above the horizontal (degrees), distances (m).
const TURNS: u32 = 16;
const RISES_DEG: [f64; 5] = [-15.0, 8.0, 25.0, 45.0, 70.0];
const DISTANCES_M: [f64; 8] = [0.15, 0.2, 0.27, 0.36, 0.5, 0.75, 1.1, 1.6];

/// Number of cells by which a candidate is judged.
const JUDGED_CELLS: usize = 250;

/// Number of poses whose views are predicted.
const MOST_PREDICTED: usize = 12;

/// Returns the pose of a free-standing camera that sees most of the cells of a blockage, from a free position; `None` if no pose
/// that `accepts` accepts sees any of them. The camera has the image and the sensor of `camera`; `views` are those that were taken
/// before, if they are known.
///
/// The candidates look at the middle of all cells, of the first and of the last ones, from a fixed set of directions and distances.
/// Near cameras are preferred, from which a pixel is small, and cells behind which something returns a depth. The views of the best
/// ones are predicted from earlier views, and mapped.
///
/// # Errors
/// [`ExploreError::Sense`] for a body that cannot be rendered, and those of [`Scenario::with_seen`].
pub fn next_fixed_view(
    seen: &Scenario,
    blockage: &Blockage,
    camera: &PlacedCamera,
    views: &[View],
    accepts: &mut dyn FnMut(&Camera) -> bool,
) -> Result<Option<NextView>, ExploreError> {
    let Some(space) = seen.seen.as_ref().filter(|_| !blockage.cells.is_empty()) else { return Ok(None) };
    let prospects = Prospects::new(seen, &space.map, blockage, camera.sensor)?;
    let scene = prospects.with_robot(&seen.start)?;
    let stride = (prospects.count() / JUDGED_CELLS).max(1);
    let poses: Vec<Pose> = poses_around(&blockage.aims(), &seen.world.up(), &DISTANCES_M).collect();
    let judged = poses.into_par_iter().map(|world_from_camera| {
        let candidate = Camera { world_from_camera, ..camera.camera.clone() };
        let prospect = if prospects.is_free(&candidate, &scene)? {
            prospects.of(&candidate, &scene, stride)?
        } else {
            Prospect::default()
        };
        Ok(Choice { value: prospect.value, camera: candidate, frees: None, with: () })
    });
    let judged = judged.collect::<Result<Vec<_>, ExploreError>>()?;
    let predictions = Predictions::new(seen, blockage, camera.sensor, views, CameraKind::Fixed)?;
    let mut refused = 0;
    let mut accepts = |camera: &Camera| {
        let is_accepted = accepts(camera);
        refused += usize::from(!is_accepted);
        is_accepted
    };
    let known = |_: &Choice<()>| Ok(scene.clone());
    let (focus, most) = (blockage.center(), MOST_PREDICTED);
    let ranked = ranked(judged, most, &focus, views, predictions.as_ref(), &mut accepts, known)?;
    let Some(Choice { camera, frees, .. }) = ranked.into_iter().next() else { return Ok(None) };
    let sees = prospects.of(&camera, &scene, 1)?.sees;
    Ok(Some(NextView { camera, sees, frees, refused, motion: Vec::new() }))
}

/// Returns the poses of cameras that look at points from directions all around, at these distances (m).
pub(crate) fn poses_around(aims: &[Point], up: &Vector, distances_m: &[f64]) -> impl Iterator<Item = Pose> {
    let axes = [Vector::x(), Vector::y()];
    let level = axes.iter().find_map(|axis| (axis - up * axis.dot(up)).try_normalize(0.1));
    let ahead = level.unwrap_or_else(Vector::x);
    let left = up.cross(&ahead);
    let (up, aims, distances_m) = (*up, aims.to_vec(), distances_m.to_vec());
    aims.into_iter().flat_map(move |aim| {
        distances_m.clone().into_iter().flat_map(move |distance_m| {
            RISES_DEG.into_iter().flat_map(move |rise_deg| {
                (0..TURNS).filter_map(move |turn| {
                    let (sin_turn, cos_turn) = sin_cos(TAU * f64::from(turn) / f64::from(TURNS));
                    let (sin_rise, cos_rise) = sin_cos(rise_deg.to_radians());
                    let outward = (ahead * cos_turn + left * sin_turn) * cos_rise + up * sin_rise;
                    Camera::looking_at(&(aim + outward * distance_m), &aim, &up)
                })
            })
        })
    })
}
