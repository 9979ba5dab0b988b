use std::time::Duration;

use cranny_collision::Margins;
use cranny_plan::{Budget, Observer};
use cranny_robot::{IkSearchSettings, Robot, solve_restarts};
use cranny_scenario::Scenario;
use cranny_sense::{Camera, CameraFrame, PlacedCamera, SensedScene, View};
use cranny_solve::{Request, solve};
use cranny_spatial::{Pose, PoseDifference, Stream, Vector};
use cranny_task::{Goal, Problem};
use rayon::prelude::*;

use crate::choice::{Choice, ranked};
use crate::fixed_view::poses_around;
use crate::prediction::Predictions;
use crate::prospect::Prospects;
use crate::{Blockage, CameraKind, ExploreError, NextView};

/// Distances of candidates from the points that they aim at, in metres.
const DISTANCES_M: [f64; 6] = [0.2, 0.27, 0.36, 0.5, 0.75, 1.1];

/// Number of cells by which a candidate is judged.
const JUDGED_CELLS: usize = 250;

/// Number of the best poses for which configurations are sought.
const MOST_POSES: usize = 48;

/// Turns of the camera about its optical axis, in quarters.
const QUARTERS: u32 = 4;

/// Attempts of inverse kinematics for each pose and turn.
const ATTEMPTS: usize = 32;

/// Number of configurations to which motions are sought.
const MOST_MOTIONS: usize = 12;

/// Time limit of each of these searches.
const MOTION_TIME: Duration = Duration::from_secs(2);

/// Difference of two poses up to which they are equal (m, rad): rounding.
const SAME: f64 = 1e-6;

/// Returns a configuration of the robot whose camera in hand sees most of the cells of a blockage, with a motion to it from the start
/// that is proven in the seen space of the scenario; `None` if no such motion leads to a view of any of them. `views` are those that
/// were taken before, if they are known. The same arguments give the same view, unless the time limit cuts a search.
///
/// 1. Poses around the cells are ranked by the cells that a camera there would see, as for a free-standing one.
/// 2. Inverse kinematics finds configurations for the best ones that are free in the seen space. They are ranked again, with the
///    robot in the picture and by predicted views.
/// 3. The first is chosen to which a straight or planned motion is proven.
///
/// # Errors
/// [`ExploreError::NoHandCamera`], [`ExploreError::LooseCamera`], and those of [`solve`].
pub fn next_hand_view(
    seen: &Scenario,
    margins: Margins,
    blockage: &Blockage,
    camera: &PlacedCamera,
    views: &[View],
    seed: u64,
    observer: &mut dyn Observer,
) -> Result<Option<NextView>, ExploreError> {
    let robot = &*seen.robot;
    let camera = &PlacedCamera { configuration: None, ..camera.clone() };
    let tip_from_camera = tip_from_camera(robot, camera, &seen.start)?;
    let Some(space) = seen.seen.as_ref().filter(|_| !blockage.cells.is_empty()) else { return Ok(None) };
    let prospects = Prospects::new(seen, &space.map, blockage, camera.sensor)?;
    let stride = (prospects.count() / JUDGED_CELLS).max(1);
    let choice = |value: f64, camera: Camera| Choice { value, camera, frees: None, with: Vec::new() };
    let with_robot = |choice: &Choice<Vec<f64>>| -> Result<SensedScene, ExploreError> {
        Ok(prospects.with_robot(&choice.with)?)
    };
    let mut all = |_: &Camera| true;
    // 1.
    let poses: Vec<Pose> = poses_around(&blockage.aims(), &seen.world.up(), &DISTANCES_M).collect();
    let judged = poses.into_par_iter().map(|world_from_camera| {
        let placed = Camera { world_from_camera, ..camera.camera.clone() };
        Ok(choice(prospects.of(&placed, prospects.bodies(), stride)?.value, placed))
    });
    let judged = judged.collect::<Result<Vec<_>, ExploreError>>()?;
    let focus = blockage.center();
    let poses = ranked(judged, MOST_POSES, &focus, views, None, &mut all, with_robot)?;
    // 2.
    let problem = seen.problem(margins)?;
    let cell = problem.exact_cell("explore")?;
    let (mut random, mut scratch) = (Stream::new(seed, 0), cell.scratch());
    let mut found: Vec<Choice<Vec<f64>>> = Vec::new();
    for Choice { camera: placed, .. } in poses {
        for quarter in 0..QUARTERS {
            let turn = Pose::rotation(Vector::z() * (f64::from(quarter) * std::f64::consts::FRAC_PI_2));
            let world_from_tip = placed.world_from_camera * turn * tip_from_camera.inverse();
            let settings = IkSearchSettings::default();
            let mut is_free = |q: &[f64]| cell.is_free(q, &mut scratch);
            let solutions =
                solve_restarts(robot, &world_from_tip, &mut random, settings, 1, ATTEMPTS, &mut is_free);
            for mut q in solutions.into_iter().map(|solution| solution.q) {
                robot.turn_towards(&seen.start, &mut q);
                let placed = camera.at(robot, &q)?;
                let prospect = prospects.of(&placed, &prospects.with_robot(&q)?, stride)?;
                found.push(Choice { with: q, ..choice(prospect.value, placed) });
            }
        }
        if observer.should_stop() {
            return Ok(None);
        }
    }
    // 3.
    let predictions = Predictions::new(seen, blockage, camera.sensor, views, CameraKind::Hand)?;
    let found = ranked(found, MOST_MOTIONS, &focus, views, predictions.as_ref(), &mut all, with_robot)?;
    for (refused, Choice { camera: placed, frees, with: q, .. }) in found.into_iter().enumerate() {
        let Some(motion) = motion_to(&problem, &q, seed, observer)? else { continue };
        let sees = prospects.of(&placed, &prospects.with_robot(&q)?, 1)?.sees;
        return Ok(Some(NextView { camera: placed, sees, frees, refused, motion }));
    }
    Ok(None)
}

/// Returns the pose of a camera in the frame of the hand.
fn tip_from_camera(robot: &Robot, camera: &PlacedCamera, start: &[f64]) -> Result<Pose, ExploreError> {
    if camera.frame == CameraFrame::World {
        return Err(ExploreError::NoHandCamera);
    }
    let at = |q: &[f64]| -> Result<Pose, ExploreError> {
        let world_from_camera = camera.at(robot, q)?.world_from_camera;
        Ok(robot.frames_at(q).link(robot.tip()).inverse() * world_from_camera)
    };
    // Another value of every joint.
    let other: Vec<f64> =
        start.iter().zip(1..).map(|(value, index)| value + 0.1 * f64::from(index)).collect();
    let (here, there) = (at(start)?, at(&other)?);
    let PoseDifference { translation_m, rotation_rad } = PoseDifference::between(&here, &there);
    if translation_m > SAME || rotation_rad > SAME {
        return Err(ExploreError::LooseCamera { camera: camera.name.clone() });
    }
    Ok(here)
}

/// Returns a proven path from the start of a problem to a configuration (m, rad; one value per joint), the straight one if possible.
fn motion_to(
    problem: &Problem,
    q: &[f64],
    seed: u64,
    observer: &mut dyn Observer,
) -> Result<Option<Vec<Vec<f64>>>, ExploreError> {
    let cell = problem.exact_cell("explore")?;
    if cell.motion_is_free(problem.start(), q, &mut cell.scratch()).is_proven() {
        return Ok(Some(vec![problem.start().to_vec(), q.to_vec()]));
    }
    let asked = problem.with_goal(Goal::Configurations(vec![q.to_vec()]))?;
    let budget = Budget { time: MOTION_TIME, ..Budget::default() };
    let answer = solve(&asked, &Request { seed, budget, hold: None, ..Request::default() }, observer)?;
    Ok(answer.is_solved().then(|| answer.waypoints()))
}
