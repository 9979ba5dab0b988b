use cranny_spatial::nalgebra::Vector3;

use crate::load::between::{Between, Cell};
use crate::load::limit_surface::LoadedPoint;
use crate::load::seat::Seat;

/// Torsional arm of the smallest patch, in metres: 3π/16 of the radius of a Hertz patch of 3.14 mm, as a ball of 33 mm
/// makes in a pad that yields by 0.3 mm.
pub const LEAST_ARM_M: f64 = 0.00185;
/// Share of the greatest load above which a cell counts as bearing.
const BEARS: f64 = 0.02;

/// Patch on which a pad bears, in the plane of the pad.
#[derive(Clone, Debug)]
pub(crate) struct Patch {
    /// Centre of pressure along x and z, in metres.
    pub center_m: [f64; 2],
    /// Mean distance of the pressure from its centre, in metres: the arm of friction against torsion.
    pub arm_m: f64,
    /// Half of the extent of the bearing cells, along x and z, in metres.
    pub half_m: [f64; 2],
    /// Resistance to a turn that shifts the pressure along x and along z, in N m per radian.
    pub turning_stiffness: [f64; 2],
    /// Bearing cells, relative to the centre of pressure.
    pub points: Vec<LoadedPoint>,
    /// Additional torsional arm of each point, in metres.
    pub point_arm_m: f64,
    /// Force along x and z and moment about the centre of pressure (m, from x to z) with which the pad would push the object
    /// without friction, per pressing force: it presses on slopes.
    pub push: Vector3<f64>,
}

impl Patch {
    /// Patch of a pad, 0 at +y and 1 at −y, on a seated object; `None` if no cell bears.
    pub fn of(between: &Between, seat: &Seat, pad: usize) -> Option<Self> {
        let (pressure, side) = (&seat.pressures[pad], [1.0, -1.0][pad]);
        let total: f64 = pressure.iter().sum();
        if total <= 0.0 {
            return None;
        }
        let bearing = || between.cells.iter().zip(pressure).filter(|(_, load)| **load > 0.0);
        let center_m = [
            bearing().map(|(cell, load)| load * cell.x).sum::<f64>() / total,
            bearing().map(|(cell, load)| load * cell.z).sum::<f64>() / total,
        ];
        let points: Vec<LoadedPoint> =
            bearing().map(|(cell, load)| ([cell.x - center_m[0], cell.z - center_m[1]], *load)).collect();
        let of_centers = points.iter().map(|([x, z], load)| load * x.hypot(*z)).sum::<f64>() / total;
        let least = (LEAST_ARM_M.powi(2) - of_centers.powi(2)).max(0.0).sqrt();
        let point_arm_m = between.cell_arm_m.max(least);
        let arm_m =
            points.iter().map(|([x, z], load)| load * x.hypot(*z).hypot(point_arm_m)).sum::<f64>() / total;
        let greatest = pressure.iter().copied().fold(0.0, f64::max);
        let extent = |of: fn(&Cell) -> f64| {
            let most = bearing().filter(|(_, load)| **load > BEARS * greatest).map(|(cell, _)| of(cell));
            let (low, high) = most.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
                (low.min(value), high.max(value))
            });
            0.5 * (high - low)
        };
        let pushed = bearing().fold(Vector3::zeros(), |sum, (cell, load)| {
            let [x, z] = [0, 1].map(|axis| cell.rise[pad][axis] + side * seat.turn_rad[axis]);
            sum + Vector3::new(x, z, (cell.x - center_m[0]) * z - (cell.z - center_m[1]) * x) * *load
        });
        Some(Self {
            center_m,
            arm_m,
            turning_stiffness: [0, 1].map(|axis| {
                seat.stiffness * points.iter().map(|(point, _)| point[axis] * point[axis]).sum::<f64>()
            }),
            half_m: [extent(|cell| cell.x), extent(|cell| cell.z)],
            points,
            point_arm_m,
            push: pushed / total,
        })
    }
}
