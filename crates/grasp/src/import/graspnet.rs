//! Grasps of GraspNet-1Billion: x approach, y closing, origin at the grasp point, fingertips `depth` ahead of it.
//!
//! Source: `graspnetAPI` (`grasp.py`, `utils/utils.py`: `generate_views`, `batch_viewpoint_params_to_matrix`,
//! `generate_scene_model`; `graspnet.py`: `loadGrasp`).

use std::f64::consts::{FRAC_PI_2, PI};

use cranny_file::excerpt;
use cranny_spatial::nalgebra::{Matrix3, Rotation3};
use cranny_spatial::{Pose, Rotation, Vector};

use crate::import::array::{Archive, Array};
use crate::import::format::{GraspFormat, ImportSettings, MOST_GRASPS, Read};
use crate::{Grasp, pose_of_rows};

const VIEWS: u64 = 300;
const ANGLES: u64 = 12;
const DEPTHS: u64 = 4;

/// Maximum number of points; each has 14 400 labels.
const MOST_POINTS: u64 = 20_000;
const MOST_COORDINATES: usize = 60_000;

/// Pose `theirs_from_z` of a frame whose z is their approach and whose y is their closing axis, at the fingertips.
fn tips(depth_m: f64) -> Pose {
    let turn = Rotation::from_scaled_axis(Vector::y() * FRAC_PI_2);
    Pose::from_parts(Vector::new(depth_m, 0.0, 0.0).into(), turn)
}

/// Reads a `GraspGroup`: score, width, height, depth, rotation (9, row by row), translation, object.
pub fn read_group(array: Array, settings: &ImportSettings) -> Result<Read, String> {
    let numbers = array.all(17 * MOST_GRASPS, "the array")?;
    let rows = numbers.as_chunks::<17>().0;
    let mut objects: Vec<f64> = rows.iter().map(|row| row[16]).collect();
    objects.sort_by(f64::total_cmp);
    objects.dedup();
    let wanted = match (settings.object, &objects[..]) {
        (Some(object), _) => object as f64,
        (None, [object]) => *object,
        (None, []) => return Err("it holds no grasps".to_owned()),
        (None, several) => {
            let ids = excerpt(&format!("{:?}", &several[..several.len().min(20)]));
            return Err(format!("it holds grasps of {} objects (ids {ids}): name one", several.len()));
        }
    };
    let mut read = Read::new(GraspFormat::GraspnetGroup);
    read.in_file = rows.len();
    // Scores of networks may exceed 1.
    let greatest = rows.iter().map(|row| row[0]).fold(1.0, f64::max);
    for (place, row) in rows.iter().enumerate() {
        let &[score, width_m, _, depth_m, r00, r01, r02, r10, r11, r12, r20, r21, r22, x, y, z, object] = row;
        #[allow(clippy::float_cmp, reason = "ids are whole")]
        if object != wanted || score < 0.0 {
            read.masked += 1;
            continue;
        }
        let rows = [r00, r01, r02, x, r10, r11, r12, y, r20, r21, r22, z, 0.0, 0.0, 0.0, 1.0];
        let pose = pose_of_rows(&rows).map_err(|fault| format!("grasp {place}: {fault}"))?;
        if !depth_m.is_finite() {
            return Err(format!("grasp {place}: its depth is {depth_m}"));
        }
        let world_from_gripper = pose * tips(depth_m);
        let score = Some(score / greatest);
        read.push(place, Grasp { score, width_m: Some(width_m), ..Grasp::at(world_from_gripper) })?;
    }
    if greatest > 1.0 {
        read.notes.push(format!("scores are divided by the greatest, {greatest}"));
    }
    read.notes.push(
        "poses are in the frame of the file, which is that of the camera for those of a scene".to_owned(),
    );
    Ok(read)
}

/// Reads object labels: for each point, view, angle and depth the least friction coefficient with which the grasp holds,
/// −1 if it is invalid.
pub fn read_labels(archive: &Archive, settings: &ImportSettings) -> Result<Read, String> {
    let points = archive.with("points", |array| {
        let &[count @ 1..=MOST_POINTS, 3] = &array.shape[..] else {
            return Err(format!(
                "points is of shape {:?}, not (P, 3) with P up to {MOST_POINTS}",
                array.shape
            ));
        };
        Ok((count, array.all(MOST_COORDINATES, "points")?))
    })?;
    let (count, points) = points.ok_or("it has no points")?;
    let expected = [count, VIEWS, ANGLES, DEPTHS];
    let mut read = Read::new(GraspFormat::GraspnetLabels);
    let wrong =
        |name: &str, shape: &[u64]| format!("{name} is of shape {shape:?}, but there are {count} points");
    archive.with("scores", |scores| {
        if scores.shape != expected {
            return Err(wrong("scores", &scores.shape));
        }
        archive.with("offsets", |offsets| {
            if offsets.shape[..] != [&expected[..], &[3]].concat() {
                return Err(wrong("offsets", &offsets.shape));
            }
            labels(&points, scores, offsets, settings, &mut read)
        })
    })?;
    read.notes.push("the score is 1.1 less the least friction coefficient, at most 1".to_owned());
    read.note_unread(&archive.unread(&["points", "offsets", "scores"]));
    Ok(read)
}

fn labels(
    points: &[f64],
    mut scores: Array,
    mut offsets: Array,
    settings: &ImportSettings,
    read: &mut Read,
) -> Result<(), String> {
    let views: Vec<Rotation> = (0..VIEWS).map(view).collect();
    let of_view = ANGLES * DEPTHS;
    for (place, friction) in scores.numbers.by_ref().enumerate() {
        let fault = |reason: std::io::Error| format!("label {place}: {reason}");
        let mut next = || {
            offsets
                .numbers
                .next()
                .unwrap_or_else(|| Err(std::io::ErrorKind::UnexpectedEof.into()))
                .map_err(fault)
        };
        let (angle, depth_m, width_m) = (next()?, next()?, next()?);
        let friction = friction.map_err(fault)?;
        read.in_file += 1;
        if friction <= 0.0 {
            read.masked += 1;
            continue;
        }
        if ![friction, angle, depth_m].iter().all(|value| value.is_finite()) {
            return Err(format!("label {place}: friction {friction}, angle {angle}, depth {depth_m}"));
        }
        let score = (1.1 - friction).clamp(0.0, 1.0);
        if settings.min_score.is_some_and(|least| score < least) {
            read.below += 1;
            continue;
        }
        let label = place as u64;
        #[allow(clippy::cast_possible_truncation, reason = "a place in arrays that are in memory")]
        let (point, view) = ((label / (VIEWS * of_view)) as usize, (label / of_view % VIEWS) as usize);
        let at = Vector::new(points[3 * point], points[3 * point + 1], points[3 * point + 2]);
        let turn = views[view] * Rotation::from_scaled_axis(Vector::x() * angle);
        let world_from_gripper = Pose::from_parts(at.into(), turn) * tips(depth_m);
        read.push(
            place,
            Grasp { score: Some(score), width_m: Some(width_m), ..Grasp::at(world_from_gripper) },
        )?;
    }
    scores.end("scores")?;
    offsets.end("offsets")
}

/// Rotation of a view: x is the approach direction of the hand, opposite to a point of the Fibonacci lattice.
fn view(index: u64) -> Rotation {
    let golden = (5.0_f64.sqrt() - 1.0) / 2.0;
    let z = (2 * index + 1) as f64 / VIEWS as f64 - 1.0;
    let (radius, turn) = ((1.0 - z * z).sqrt(), 2.0 * index as f64 * PI * golden);
    let x_axis = -Vector::new(radius * libm::cos(turn), radius * libm::sin(turn), z);
    let level = Vector::new(-x_axis.y, x_axis.x, 0.0);
    let y_axis = if level.norm() > 0.0 { level.normalize() } else { Vector::y() };
    let axes = Matrix3::from_columns(&[x_axis, y_axis, x_axis.cross(&y_axis)]);
    Rotation::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes))
}
