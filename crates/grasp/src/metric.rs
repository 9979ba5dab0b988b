//! Distances between grasps, and coverage of one set by another.

use cranny_spatial::nalgebra::Quaternion;
use cranny_spatial::{Rotation, Vector};
use rayon::prelude::*;

use crate::Grasp;

/// Distance of two grasps: millimetres between their origins plus degrees between their rotations, up to the 180°
/// symmetry of the gripper. Twice the released metric.
///
/// `distance(a, b) = distance(b, a)`, `distance(a, a.twin()) = 0`.
pub fn grasp_distance(a: &Grasp, b: &Grasp) -> f64 {
    Place::of(a).distance(&Place::of(b))
}

/// Maximum [`grasp_distance`] at which a grasp counts as found because one of a set is near it (coverage: Eppner et al.
/// 2019, §V).
pub const COVERAGE_THRESHOLD: f64 = 15.0;

/// Distances of the grasps of `reference`, one per grasp, to the nearest of `set`, in the unit of [`grasp_distance`];
/// infinite for an empty set.
pub fn nearest_distances(reference: &[Grasp], set: &[Grasp]) -> Vec<f64> {
    let set: Vec<Place> = set.iter().map(Place::of).collect();
    reference
        .par_iter()
        .map(|grasp| {
            let place = Place::of(grasp);
            set.iter().fold(f64::INFINITY, |nearest, other| place.distance_if_below(other, nearest))
        })
        .collect()
}

/// Share of the grasps of `reference` that are within `threshold` of one of `set` by [`grasp_distance`] (Eppner et al.
/// 2019, §V); 0 for an empty reference.
pub fn coverage(reference: &[Grasp], set: &[Grasp], threshold: f64) -> f64 {
    let distances = nearest_distances(reference, set);
    let covered = distances.iter().filter(|distance| **distance <= threshold).count();
    if reference.is_empty() { 0.0 } else { covered as f64 / reference.len() as f64 }
}

/// Distances between grasps over all pairs of different ones; see [`spread`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DistanceRange {
    /// Minimum.
    pub least: f64,
    /// Median; the upper one of an even number.
    pub median: f64,
    /// Maximum.
    pub greatest: f64,
}

/// Minimum, median and maximum distance of all pairs of different grasps, without storing all distances (5·10⁹ distances of 10⁵
/// grasps take 40 GB); `None` for fewer than two grasps.
///
/// Numbers that are not negative have the order of their bits. Finds the median by its topmost bits, counted over all pairs,
/// then by the next ones among those with the same bits above, and then by the last (radix selection).
pub fn spread(grasps: &[Grasp]) -> Option<DistanceRange> {
    let places: Vec<Place> = grasps.iter().map(Place::of).collect();
    let pairs = places.len() * places.len().checked_sub(1)? / 2;
    if pairs == 0 {
        return None;
    }
    let (mut rank, mut median) = (pairs / 2, 0_u64);
    let (mut least, mut greatest) = (f64::INFINITY, 0.0_f64);
    // The sign, which is 0, is the 64th bit.
    for shift in [2 * DIGIT_BITS, DIGIT_BITS, 0] {
        let is_candidate = |bits: u64| bits >> (shift + DIGIT_BITS) == median >> (shift + DIGIT_BITS);
        let threads = rayon::current_num_threads().min(places.len());
        let counted = (0..threads).into_par_iter().map(|thread| {
            let mut counts = vec![0_usize; 1 << DIGIT_BITS];
            let (mut least, mut greatest) = (f64::INFINITY, 0.0_f64);
            for index in (thread..places.len()).step_by(threads) {
                for other in &places[index + 1..] {
                    let distance = places[index].distance(other);
                    (least, greatest) = (least.min(distance), greatest.max(distance));
                    if is_candidate(distance.to_bits()) {
                        counts[digit(distance.to_bits(), shift)] += 1;
                    }
                }
            }
            (counts, least, greatest)
        });
        let (counts, low, high) = counted.reduce(
            || (vec![0; 1 << DIGIT_BITS], f64::INFINITY, 0.0),
            |(mut sum, a, b), (counts, low, high)| {
                sum.iter_mut().zip(&counts).for_each(|(sum, count)| *sum += count);
                (sum, a.min(low), b.max(high))
            },
        );
        (least, greatest) = (low, high);
        for (value, count) in (0_u64..).zip(counts) {
            if rank < count {
                median |= value << shift;
                break;
            }
            rank -= count;
        }
    }
    Some(DistanceRange { least, median: f64::from_bits(median), greatest })
}

/// Third of the bits of a number without its sign: three passes, and 16 MB of counts a thread.
const DIGIT_BITS: u32 = 21;

fn digit(bits: u64, shift: u32) -> usize {
    usize::try_from((bits >> shift) & ((1 << DIGIT_BITS) - 1)).unwrap_or_default()
}

/// Grasp prepared for comparison with many others.
#[derive(Clone, Copy)]
pub(crate) struct Place {
    pub origin_mm: Vector,
    rotation: Quaternion<f64>,
    twin: Quaternion<f64>,
}

impl Place {
    pub fn of(grasp: &Grasp) -> Self {
        let rotation = |rotation: Rotation| rotation.into_inner();
        Self {
            origin_mm: grasp.world_from_gripper.translation.vector * 1000.0,
            rotation: rotation(grasp.world_from_gripper.rotation),
            twin: rotation(grasp.twin().world_from_gripper.rotation),
        }
    }

    pub fn distance(&self, other: &Self) -> f64 {
        self.distance_if_below(other, f64::INFINITY)
    }

    /// Distance, or `limit` if the distance is not below it.
    pub fn distance_if_below(&self, other: &Self, limit: f64) -> f64 {
        let translation_mm = (self.origin_mm - other.origin_mm).norm();
        if translation_mm >= limit {
            return limit;
        }
        let cosine = self.cosine(other);
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        limit.min(translation_mm + (2.0 * libm::atan2(sine, cosine)).to_degrees())
    }

    /// Returns true if the distance is at most `threshold`. Agrees with [`Self::distance`], mostly without its arc tangent.
    pub fn is_within(&self, other: &Self, threshold: f64) -> bool {
        let apart_squared_mm2 = (self.origin_mm - other.origin_mm).norm_squared();
        if apart_squared_mm2 > threshold * threshold {
            return false;
        }
        // With h, half the remaining angle: 1 − h²/2 ≤ cos h ≤ 1 − h²/2 + h⁴/24.
        let half_squared = (0.5 * (threshold - apart_squared_mm2.sqrt())).to_radians().powi(2);
        let over = self.cosine(other) - (1.0 - 0.5 * half_squared);
        over >= -DOUBT
            && (over > half_squared * half_squared / 24.0 + DOUBT || self.distance(other) <= threshold)
    }

    /// |cos| of half the angle to the nearer of the other and its twin.
    fn cosine(&self, other: &Self) -> f64 {
        self.rotation.dot(&other.rotation).abs().max(self.twin.dot(&other.rotation).abs())
    }
}

/// Difference of cosines below which the arc tangent decides: well above rounding.
const DOUBT: f64 = 1e-12;
