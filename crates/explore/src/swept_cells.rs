use std::collections::hash_map::Entry;
use std::collections::{HashMap, HashSet};

use cranny_robot::{LinkFrames, Robot, between};
use cranny_sense::SeenMap;
use cranny_shape::{Aabb, Range, Solid, separation_in};
use cranny_spatial::{Point, Pose, Rotation, Vector};

/// Cell of a map, not seen to be free, that a motion meets: a piece of a box of the map, at most two smallest cells wide.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MetCell {
    /// Its box, in the planning frame.
    pub aabb: Aabb,
    /// True if a surface may have been measured in it; otherwise no view has seen into it.
    pub is_occupied: bool,
    /// First meeting along the motion.
    pub first: FirstMeeting,
}

/// Place of a motion at which a link first meets a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstMeeting {
    /// Index of the edge of the path, from 0.
    pub edge: usize,
    /// Parameter in [0, 1] along the edge.
    pub at: f64,
    /// Index of the link.
    pub link: usize,
}

/// Maximum motion of any corner of a link's box between two samples, in smallest cells.
const STEP_CELLS: f64 = 1.0;

/// Maximum turn or slide of a joint between two samples (rad, m): corners then move almost straight.
const JOINT_STEP: f64 = 0.1;

/// Maximum side of a piece of a box, in smallest cells.
const PIECE_CELLS: f64 = 2.0;

/// Side of the bins in which boxes of the map are found, in smallest cells: the largest box of a map.
const BIN_CELLS: f64 = 16.0;

/// Number of pieces that are collected at most; further ones would change no choice.
const MOST_CELLS: usize = 60_000;

/// Returns the cells of a map that the links of a robot meet along a path (m, rad; one value per joint), in the order of their first
/// meeting; with `occupied`, also those in which a surface may have been measured.
///
/// The path is sampled so densely that no point of a link moves by more than a smallest cell between two samples. A cell counts if its
/// exact distance from a link at a sample is at most half of that, so no cell of the swept volume is left out, except for links that
/// turn far within one sample.
///
/// # Panics
/// If a configuration has not one value per joint.
pub fn swept_cells(robot: &Robot, path: &[Vec<f64>], map: &SeenMap, occupied: bool) -> Vec<MetCell> {
    let cell_m = map.settings().cell_m;
    let mut sweep = Sweep::new(map, occupied);
    let mut frames = robot.frames();
    let single = path.first().map(|q| [q.clone(), q.clone()]);
    let edges = if path.len() == 1 { single.as_ref().map_or(&[][..], |both| &both[..]) } else { path };
    for (edge, ends) in edges.windows(2).enumerate() {
        let [from, to] = ends else { continue };
        let samples = samples_between(robot, [from, to], STEP_CELLS * cell_m, &mut frames);
        let begin = usize::from(edge > 0);
        for sample in begin..=samples {
            let at = sample as f64 / samples as f64;
            let q: Vec<f64> = between(from, to, at).collect();
            robot.forward_kinematics(&q, &mut frames);
            for (link, data) in robot.links().iter().enumerate() {
                for shape in &data.collisions {
                    let pose = frames.link(link) * shape.link_from_shape;
                    sweep.meet(&shape.solid, &pose, FirstMeeting { edge, at, link });
                }
            }
            if sweep.found.len() >= MOST_CELLS {
                return sweep.found;
            }
        }
    }
    sweep.found
}

/// Returns the number of intervals into which an edge is divided, at least 1.
fn samples_between(robot: &Robot, [from, to]: [&Vec<f64>; 2], step_m: f64, frames: &mut LinkFrames) -> usize {
    let most = from.iter().zip(to).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let coarse = whole(most / JOINT_STEP);
    let mut corners_at = |at: f64| -> Vec<Point> {
        let q: Vec<f64> = between(from, to, at).collect();
        robot.forward_kinematics(&q, frames);
        let mut corners = Vec::new();
        for (link, data) in robot.links().iter().enumerate() {
            for shape in &data.collisions {
                let pose = frames.link(link) * shape.link_from_shape;
                let Aabb { center, half_extents } = *shape.solid.aabb();
                for corner in 0..8_u8 {
                    let sign = |bit: u8| if corner & bit == 0 { -1.0 } else { 1.0 };
                    let offset = half_extents.component_mul(&Vector::new(sign(1), sign(2), sign(4)));
                    corners.push(pose * (center + offset));
                }
            }
        }
        corners
    };
    let (mut before, mut moved_m) = (corners_at(0.0), 0.0_f64);
    for index in 1..=coarse {
        let after = corners_at(index as f64 / coarse as f64);
        moved_m = before.iter().zip(&after).map(|(a, b)| (a - b).norm()).fold(moved_m, f64::max);
        before = after;
    }
    coarse * whole(moved_m / step_m)
}

/// Returns the least whole number, from 1, that is not less than a number.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small and not negative")]
fn whole(number: f64) -> usize {
    number.ceil().clamp(1.0, 1e5) as usize
}

/// Boxes of a map, and the pieces of them that were met.
struct Sweep {
    bins: HashMap<[i32; 3], Vec<(Aabb, bool)>>,
    low: Point,
    bin_m: f64,
    piece_m: f64,
    /// Distance up to which a link meets a piece, in metres.
    reach_m: f64,
    is_found: HashSet<[i64; 3]>,
    found: Vec<MetCell>,
    /// Solids of pieces by their half extents.
    solids: HashMap<[i64; 3], Solid>,
}

impl Sweep {
    fn new(map: &SeenMap, occupied: bool) -> Self {
        let settings = map.settings();
        let mut sweep = Self {
            bins: HashMap::new(),
            low: settings.region.low(),
            bin_m: BIN_CELLS * settings.cell_m,
            piece_m: PIECE_CELLS * settings.cell_m,
            reach_m: 0.5 * STEP_CELLS * settings.cell_m,
            is_found: HashSet::new(),
            found: Vec::new(),
            solids: HashMap::new(),
        };
        let unseen = map.unseen().iter().map(|aabb| (*aabb, false));
        let measured = map.occupied().iter().filter(|_| occupied).map(|aabb| (*aabb, true));
        for (aabb, is_occupied) in unseen.chain(measured) {
            // A box of the map lies within one of the cubes with which its search begins.
            sweep.bins.entry(sweep.bin(&aabb.center)).or_default().push((aabb, is_occupied));
        }
        sweep
    }

    #[allow(clippy::cast_possible_truncation, reason = "a region of at most 100 m")]
    fn bin(&self, point: &Point) -> [i32; 3] {
        let place = (point - self.low) / self.bin_m;
        [0, 1, 2].map(|axis| place[axis].floor() as i32)
    }

    /// Adds all pieces that a solid at a pose meets.
    fn meet(&mut self, solid: &Solid, pose: &Pose, first: FirstMeeting) {
        let around = solid.aabb().transformed(pose).grown(self.reach_m);
        let [low, high] = [self.bin(&around.low()), self.bin(&around.high())];
        let mut near = Vec::new();
        for x in low[0]..=high[0] {
            for y in low[1]..=high[1] {
                for z in low[2]..=high[2] {
                    let boxes = self.bins.get(&[x, y, z]).into_iter().flatten();
                    near.extend(boxes.filter(|(aabb, _)| aabb.overlaps(&around)).copied());
                }
            }
        }
        for (aabb, is_occupied) in near {
            self.divide(aabb, is_occupied, solid, pose, first);
        }
    }

    /// Halves a box until its pieces are small, and adds those that the solid meets.
    fn divide(&mut self, aabb: Aabb, is_occupied: bool, solid: &Solid, pose: &Pose, first: FirstMeeting) {
        let in_solid = pose.inverse_transform_point(&aabb.center);
        if solid.aabb().distance_to(&in_solid) > aabb.half_extents.norm() + self.reach_m {
            return;
        }
        let axis = aabb.half_extents.imax();
        if 2.0 * aabb.half_extents[axis] > 1.01 * self.piece_m {
            for side in [-0.5, 0.5] {
                let mut half = aabb;
                half.half_extents[axis] *= 0.5;
                half.center[axis] += side * aabb.half_extents[axis];
                self.divide(half, is_occupied, solid, pose, first);
            }
            return;
        }
        let key = key_of(&aabb.center.coords);
        if self.is_found.contains(&key) {
            return;
        }
        let half = aabb.half_extents;
        let cube = match self.solids.entry(key_of(&half)) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(place) => {
                let Ok(cube) = Solid::cuboid(half) else { return };
                place.insert(cube)
            }
        };
        let at = Pose::from_parts(aabb.center.coords.into(), Rotation::identity());
        let range = Range::to(self.reach_m + half.norm());
        if separation_in(cube, &at, solid, pose, range).lower_m <= self.reach_m {
            self.is_found.insert(key);
            self.found.push(MetCell { aabb, is_occupied, first });
        }
    }
}

/// Returns a point or extent in tenths of a millimetre.
#[allow(clippy::cast_possible_truncation, reason = "at most 100 m")]
fn key_of(vector: &Vector) -> [i64; 3] {
    [0, 1, 2].map(|axis| (vector[axis] * 1e4).round() as i64)
}
