use cranny_scenario::ObjectType;
use cranny_shape::{StablePose, equal_poses, stable_poses};
use cranny_spatial::{Pose, Stream, Vector};
use rayon::prelude::*;
use serde::Serialize;

use crate::object_model::{ObjectModel, come_to_rest};
use crate::{Disturbance, Physics, Piece, PieceShape, SimError, engine};

/// Resting poses of a dropped object, compared with the stable poses of its geometry.
#[derive(Clone, Debug, Serialize)]
pub struct Settling {
    /// Number of drops.
    pub drops: usize,
    /// Stable poses of the object; symmetric ones are merged.
    pub poses: Vec<SettledPose>,
    /// Number of drops that ended otherwise: on an edge, or in a pose too improbable to be listed.
    pub elsewhere: usize,
    /// Number of drops that still moved after 10 s.
    pub still_moving: usize,
    /// Pearson's χ² of the counts against the computed probabilities. Poses with fewer than five expected drops are merged.
    /// `None` if only one remains.
    pub chi_squared: Option<ChiSquared>,
}

/// Stable pose with its count.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct SettledPose {
    /// Index of the stable pose of the object, from 0.
    pub pose: usize,
    /// Computed probability: quasi-static, by solid angle.
    pub probability: f64,
    /// Number of drops that ended in this pose.
    pub count: usize,
}

/// Test of counts against probabilities.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ChiSquared {
    /// Sum over all poses of (count − expected)² / expected.
    pub statistic: f64,
    /// Number of poses minus one.
    pub degrees_of_freedom: usize,
    /// Probability of a greater statistic if the probabilities are correct.
    pub p_value: f64,
}

/// Height above the ground from which an object is dropped, in metres.
const DROP_M: f64 = 0.02;

/// Duration without motion after which an object rests, in seconds: on an edge it would have begun to fall.
const STILL_S: f64 = 0.3;

/// Maximum duration of a drop, in seconds, for objects that roll on.
const LONGEST_S: f64 = 10.0;

/// Maximum angle between the vertical and that of a stable pose, in radians: beyond it the object is on an edge.
const SAME_POSE_RAD: f64 = 0.05;

/// Drops an object `count` times from 20 mm above level ground, with a random orientation from a random stream per drop; the
/// friction with the ground is that of the object. `on_done` is called after each drop. Once `stop` returns true, no further
/// drop begins, and `drops` is the number of those performed.
///
/// # Errors
/// [`SimError::Shape`] for a mesh that cannot rest.
pub fn settle(
    object: &ObjectType,
    count: usize,
    seed: u64,
    on_done: &(dyn Fn() + Sync),
    stop: &(dyn Fn() -> bool + Sync),
) -> Result<Settling, SimError> {
    let shape = |reason| SimError::Shape { of: object.name.clone(), reason };
    let model = ObjectModel::new(object)?;
    let faces = stable_poses(&object.mesh.vertices, &object.center_of_mass).map_err(shape)?;
    let known: Vec<StablePose> = object.stable_poses.iter().chain(&faces).copied().collect();
    let groups = equal_poses(&known, &object.mesh).map_err(shape)?;
    let upward = |pose: &Pose| pose.rotation.inverse() * Vector::z();
    let floor = [Piece { body_from_piece: Pose::identity(), shape: PieceShape::HalfSpace }];
    let floor = engine::colliders("floor", &floor, 0.0, engine::SURROUNDINGS)?;
    // Find the face that is down; the first member of its group is the listed pose.
    let listed = |up: &Vector| {
        let angle = |pose: &StablePose| upward(&pose.ground_from_body).angle(up);
        let nearest = (0..known.len()).min_by(|&a, &b| angle(&known[a]).total_cmp(&angle(&known[b])))?;
        let pose = groups[nearest];
        (angle(&known[nearest]) < SAME_POSE_RAD && pose < object.stable_poses.len()).then_some(pose)
    };
    let drop = |index: usize| {
        if stop() {
            return None;
        }
        let turn = Pose::from_parts(Vector::zeros().into(), Stream::new(seed, index as u64).rotation());
        let lowest_m = object.mesh.vertices.iter().map(|v| (turn * v).z).fold(f64::INFINITY, f64::min);
        let mut world = engine::world(&Physics::default());
        for collider in &floor {
            world.insert_collider(collider.clone(), None);
        }
        let place = Pose::translation(0.0, 0.0, DROP_M - lowest_m) * turn;
        let nominal = Disturbance::default();
        let body = model.insert(&place, &nominal, &mut world);
        let rolling = model.rolling(Physics::default().rolling_m, &nominal);
        let (rest, is_still) = come_to_rest(&mut world, (body, &rolling), STILL_S, LONGEST_S);
        on_done();
        Some((listed(&upward(&rest)), is_still))
    };
    let drops: Vec<(Option<usize>, bool)> = (0..count).into_par_iter().filter_map(drop).collect();
    let mut poses: Vec<SettledPose> = object
        .stable_poses
        .iter()
        .enumerate()
        .map(|(pose, stable)| SettledPose { pose, probability: stable.probability, count: 0 })
        .collect();
    let mut elsewhere = 0;
    for pose in drops.iter().filter(|(_, is_still)| *is_still).map(|(pose, _)| pose) {
        match pose {
            Some(pose) => poses[*pose].count += 1,
            None => elsewhere += 1,
        }
    }
    let still_moving = drops.iter().filter(|(_, is_still)| !is_still).count();
    let chi_squared = ChiSquared::of(&poses, elsewhere);
    Ok(Settling { drops: drops.len(), poses, elsewhere, still_moving, chi_squared })
}

impl ChiSquared {
    fn of(poses: &[SettledPose], elsewhere: usize) -> Option<Self> {
        let rested = poses.iter().map(|pose| pose.count).sum::<usize>() + elsewhere;
        let expected = |probability: f64| probability * rested as f64;
        let (often, seldom): (Vec<&SettledPose>, Vec<&SettledPose>) =
            poses.iter().partition(|pose| expected(pose.probability) >= 5.0);
        let mut cells: Vec<(f64, f64)> =
            often.iter().map(|pose| (expected(pose.probability), pose.count as f64)).collect();
        let others = seldom.iter().map(|pose| pose.count).sum::<usize>() + elsewhere;
        let others_expected = rested as f64 - cells.iter().map(|cell| cell.0).sum::<f64>();
        if others_expected >= 5.0 {
            cells.push((others_expected, others as f64));
        } else if let Some(last) = cells.last_mut() {
            *last = (last.0 + others_expected, last.1 + others as f64);
        }
        let degrees_of_freedom = cells.len().checked_sub(1).filter(|degrees| *degrees > 0)?;
        let statistic = cells.iter().map(|(expected, count)| (count - expected).powi(2) / expected).sum();
        Some(Self { statistic, degrees_of_freedom, p_value: p_value(statistic, degrees_of_freedom as f64) })
    }
}

/// Returns the p-value of a χ² statistic, to within some thousandths (its cube root is nearly normal: Wilson & Hilferty 1931,
/// "The distribution of chi-square", whole).
fn p_value(statistic: f64, degrees_of_freedom: f64) -> f64 {
    let variance = 2.0 / (9.0 * degrees_of_freedom);
    let normal = ((statistic / degrees_of_freedom).cbrt() - 1.0 + variance) / variance.sqrt();
    0.5 * libm::erfc(normal / std::f64::consts::SQRT_2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn p_values_are_those_of_tables() {
        // Abramowitz & Stegun, table 26.8.
        for (statistic, degrees, expected) in
            [(3.841, 1.0, 0.05), (5.991, 2.0, 0.05), (11.345, 3.0, 0.01), (18.307, 10.0, 0.05)]
        {
            assert!((p_value(statistic, degrees) - expected).abs() < 0.005, "{statistic}, {degrees}");
        }
    }

    #[test]
    fn seldom_poses_count_together() {
        let pose = |probability, count| SettledPose { pose: 0, probability, count };
        let test = ChiSquared::of(&[pose(0.6, 60), pose(0.36, 30), pose(0.03, 6), pose(0.01, 4)], 0).unwrap();
        // The last two poses share four expected drops, which is too few, so they are merged into the second.
        assert_eq!(test.degrees_of_freedom, 1);
        assert!(test.statistic.abs() < 1e-9 && test.p_value > 0.9, "{test:?}");
        assert!(ChiSquared::of(&[pose(1.0, 50)], 0).is_none());
    }
}
