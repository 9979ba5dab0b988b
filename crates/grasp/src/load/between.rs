use cranny_shape::Surface;
use cranny_spatial::{Point, Pose, Vector};

use crate::Pads;

/// Number of cells of a pad along x and along z.
pub const CELLS: [usize; 2] = [4, 6];
pub(crate) const COUNT: usize = CELLS[0] * CELLS[1];
/// Distance of an open finger behind the pads, in metres: anything farther out is behind the finger.
const BEHIND_M: f64 = 1e-3;

/// Sides of an object between the pads, sampled over their cells, in the gripper frame.
#[derive(Clone, Debug)]
pub(crate) struct Between {
    /// Cells with the object between them: the centre along x and z, and the lower and the upper side along y, in metres.
    pub cells: Vec<Cell>,
    /// Area of a cell, in square metres.
    pub cell_area_m2: f64,
    /// Mean arm of an even pressure on a cell about its centre, in metres.
    pub cell_arm_m: f64,
}

/// A cell of the pads with the object between them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cell {
    pub x: f64,
    pub z: f64,
    pub lower: f64,
    pub upper: f64,
    /// Rise of the object towards each pad, the pad at +y first, per metre along x and along z.
    pub rise: [[f64; 2]; 2],
}

/// Minimum component of a unit normal towards a pad; smaller ones count as this.
const LEAST_FACING: f64 = 1e-3;
/// Maximum rise of a surface, per metre: on steeper slopes a tip slides until it bears little. Of 0.25, 0.5 and 1 this predicts
/// best which grasps hold (`benchmarks/load.md`).
const STEEPEST: f64 = 0.5;

/// Mean distance from the centre of a square of side 1.
const SQUARE_ARM: f64 = 0.382_597_858;

impl Between {
    /// Samples the object of a surface between pads whose gripper frame is at a pose in the frame of the surface.
    pub fn new(surface: &Surface, object_from_gripper: &Pose, pads: &Pads) -> Self {
        let out_m = 0.5 * pads.opening_m + BEHIND_M;
        let along = object_from_gripper * Vector::y();
        let at = |axis: usize, step: usize| {
            pads.middle_m[axis] + pads.half_m[axis] * (2.0 * (step as f64 + 0.5) / CELLS[axis] as f64 - 1.0)
        };
        let mut cells = Vec::with_capacity(COUNT);
        let gripper_from_object = object_from_gripper.rotation.inverse();
        let rise = |normal: &Vector| {
            let n = gripper_from_object * normal;
            [-n.x, -n.z].map(|across| (across / n.y.abs().max(LEAST_FACING)).clamp(-STEEPEST, STEEPEST))
        };
        for i in 0..CELLS[0] {
            for k in 0..CELLS[1] {
                let (x, z) = (at(0, i), at(1, k));
                let origin = object_from_gripper * Point::new(x, -out_m, z);
                let hits = surface.ray_hits(&origin, &along, 2.0 * out_m);
                // If the ray begins inside, the lower side lies behind the finger.
                let Some((first, last)) = hits.first().zip(hits.last()) else { continue };
                let inside_from = if first.normal.dot(&along) > 0.0 { 0.0 } else { first.distance_m };
                let inside_to = if last.normal.dot(&along) < 0.0 { 2.0 * out_m } else { last.distance_m };
                let (lower, upper) = (inside_from - out_m, inside_to - out_m);
                let rise = [rise(&last.normal), rise(&first.normal)];
                cells.push(Cell { x, z, lower, upper, rise });
            }
        }
        let size = [0, 1].map(|axis| 2.0 * pads.half_m[axis] / CELLS[axis] as f64);
        let cell_area_m2 = size[0] * size[1];
        Self { cells, cell_area_m2, cell_arm_m: SQUARE_ARM * cell_area_m2.sqrt() }
    }
}
