//! Subsets of grasps that represent many: random, far from each other, or near to as many others as possible.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

use cranny_spatial::{Stream, Vector};
use rayon::prelude::*;

use crate::Grasp;
use crate::metric::Place;

/// Chooses `count` of `total` indices uniformly at random, in ascending order; all of them if there are no more.
pub fn random_subset(total: usize, count: usize, seed: u64) -> Vec<usize> {
    let mut random = Stream::new(seed, SUBSET_STREAM);
    let mut indices: Vec<usize> = (0..total).collect();
    let count = count.min(total);
    for place in 0..count {
        indices.swap(place, place + random.index(total - place));
    }
    indices.truncate(count);
    indices.sort_unstable();
    indices
}

/// Indices of `count` grasps that are far from each other, in the order of choice: the first at random, then always the
/// one farthest from all before (Gonzalez 1985, "Clustering to minimize the maximum intercluster distance", whole); ties
/// go to the first. All indices if there are no more.
pub fn farthest_subset(grasps: &[Grasp], count: usize, seed: u64) -> Vec<usize> {
    let places: Vec<Place> = grasps.iter().map(Place::of).collect();
    if places.is_empty() || count == 0 {
        return Vec::new();
    }
    let mut newest = Stream::new(seed, SUBSET_STREAM).index(places.len());
    let mut chosen = vec![newest];
    let mut distance = vec![f64::INFINITY; places.len()];
    while chosen.len() < count.min(places.len()) {
        let place = places[newest];
        // A chosen grasp has distance 0, but so may others: only −1 excludes it for good.
        distance[newest] = -1.0;
        let farthest = distance
            .par_iter_mut()
            .zip(&places)
            .with_min_len(PLACES_PER_TASK)
            .enumerate()
            .map(|(index, (nearest, other))| {
                *nearest = place.distance_if_below(other, *nearest);
                (*nearest, index)
            })
            .reduce(|| (f64::NEG_INFINITY, usize::MAX), farther);
        newest = farthest.1;
        chosen.push(newest);
    }
    chosen
}

/// Random stream of the subsets; no sampling uses this number.
const SUBSET_STREAM: u64 = u64::MAX;

/// Minimum number of grasps per thread; fewer are not worth one.
const PLACES_PER_TASK: usize = 2048;

/// Returns the farther of two, of equals the first; independent of the order of comparison.
fn farther(a: (f64, usize), b: (f64, usize)) -> (f64, usize) {
    let order = b.0.total_cmp(&a.0).then(a.1.cmp(&b.1));
    if order.is_gt() { b } else { a }
}

/// Indices of `count` grasps that have as many grasps as possible nearby, in the order of choice: always the one with the most
/// grasps within `threshold` by [`grasp_distance`](crate::grasp_distance) that are near no chosen one yet; ties go to the first
/// (greedy maximum coverage: Nemhauser, Wolsey & Fisher 1978, "An analysis of approximations for maximizing submodular set
/// functions", whole). Once all are covered, the count begins anew. All indices if there are no more.
pub fn covering_subset(grasps: &[Grasp], count: usize, threshold: f64) -> Vec<usize> {
    let near = neighbours(grasps, threshold);
    let count = count.min(grasps.len());
    let mut chosen = Vec::with_capacity(count);
    let mut is_chosen = vec![false; grasps.len()];
    while chosen.len() < count {
        let mut is_covered = is_chosen.clone();
        let uncovered = |near: &Vec<u32>, is_covered: &[bool]| {
            near.iter().filter(|other| !is_covered[**other as usize]).count()
        };
        let mut gain: Vec<usize> = near.iter().map(|near| uncovered(near, &is_covered)).collect();
        // Gains only shrink: the grasp with the best old gain is the best if this gain is unchanged (Minoux 1978, "Accelerated
        // greedy algorithms for maximizing submodular set functions", whole).
        let mut queue: BinaryHeap<(usize, Reverse<usize>)> =
            (0..grasps.len()).filter(|&i| !is_chosen[i]).map(|index| (gain[index], Reverse(index))).collect();
        let begin = chosen.len();
        while chosen.len() < count {
            let Some((old_gain, Reverse(best))) = queue.pop() else { break };
            if gain[best] < old_gain {
                queue.push((gain[best], Reverse(best)));
                continue;
            }
            if old_gain == 0 {
                break;
            }
            chosen.push(best);
            is_chosen[best] = true;
            for &covered in &near[best] {
                if !std::mem::replace(&mut is_covered[covered as usize], true) {
                    for &other in &near[covered as usize] {
                        gain[other as usize] -= 1;
                    }
                }
            }
        }
        if chosen.len() == begin {
            break;
        }
    }
    chosen
}

/// Indices of all grasps within `threshold` of each grasp, itself included.
///
/// Two grasps cannot be near unless their approach directions are. So the search uses cells of these directions, and in
/// each cell the axis along which the grasps are spread farthest.
fn neighbours(grasps: &[Grasp], threshold: f64) -> Vec<Vec<u32>> {
    let places: Vec<Place> = grasps.iter().map(Place::of).collect();
    // The chord of `threshold` degrees is shorter than the arc.
    let cell_size = threshold.to_radians().max(LEAST_CELL);
    #[allow(
        clippy::cast_possible_truncation,
        reason = "components of a unit vector over a cell's size are small"
    )]
    let cell_of = |grasp: &Grasp| {
        let approach = grasp.world_from_gripper.rotation * Vector::z();
        [approach.x, approach.y, approach.z].map(|x| (x / cell_size).floor() as i64)
    };
    let mut cells: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    for (index, grasp) in (0..u32::MAX).zip(grasps) {
        cells.entry(cell_of(grasp)).or_default().push(index);
    }
    let Some(first) = places.first().map(|place| place.origin_mm) else { return Vec::new() };
    let (low, high) =
        places.iter().fold((first, first), |(l, h), p| (l.inf(&p.origin_mm), h.sup(&p.origin_mm)));
    let axis = (high - low).imax();
    let along = |index: u32| places[index as usize].origin_mm[axis];
    for members in cells.values_mut() {
        members.sort_by(|&a, &b| along(a).total_cmp(&along(b)).then(a.cmp(&b)));
    }
    let around = || (-1..=1).flat_map(|i| (-1..=1).flat_map(move |j| (-1..=1).map(move |k| [i, j, k])));
    grasps
        .par_iter()
        .zip(&places)
        .map(|(grasp, place)| {
            let [x, y, z] = cell_of(grasp);
            let mut near = Vec::new();
            for members in around().filter_map(|[i, j, k]| cells.get(&[x + i, y + j, z + k])) {
                let begin =
                    members.partition_point(|&other| along(other) < place.origin_mm[axis] - threshold);
                let within = members[begin..]
                    .iter()
                    .take_while(|&&other| along(other) <= place.origin_mm[axis] + threshold)
                    .filter(|&&other| place.is_within(&places[other as usize], threshold));
                near.extend(within);
            }
            near
        })
        .collect()
}

/// Minimum size of a cell of directions; smaller ones would only be empty.
const LEAST_CELL: f64 = 0.01;
