use crate::load::between::{Between, CELLS, Cell};
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
    /// Bearing cells, relative to the centre of pressure.
    pub points: Vec<LoadedPoint>,
    /// Additional torsional arm of each point, in metres.
    pub point_arm_m: f64,
    /// Force along x and z with which the pad squeezes the object out along its plane, as a share of the pressing force.
    pub squeeze: [f64; 2],
}

impl Patch {
    /// Patch of a pad, 0 at +y and 1 at −y, on a seated object; `None` if no cell bears.
    pub fn of(between: &Between, seat: &Seat, pad: usize) -> Option<Self> {
        let pressure = &seat.pressures[pad];
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
        let squeezed = bearing().fold([0.0; 2], |sum, (cell, load)| {
            [0, 1].map(|axis| sum[axis] + load * squeeze(between, seat, pad, cell, axis))
        });
        Some(Self {
            center_m,
            arm_m,
            half_m: [extent(|cell| cell.x), extent(|cell| cell.z)],
            points,
            point_arm_m,
            squeeze: squeezed.map(|force| force / total),
        })
    }
}

/// Rise of a seated object towards a pad along an axis (0: x, 1: z) at a cell, if it continues to the border of the pad,
/// where the pad presses on a slope. Otherwise 0: the rise ends at a summit under the pad, on which the pad lies flat.
fn squeeze(between: &Between, seat: &Seat, pad: usize, cell: &Cell, axis: usize) -> f64 {
    let side = [1.0, -1.0][pad];
    let height = |cell: &Cell| {
        let turned = seat.turn_rad[0] * cell.x + seat.turn_rad[1] * cell.z;
        side * ([cell.upper, cell.lower][pad] + turned)
    };
    let rise = cell.rise[pad][axis] + side * seat.turn_rad[axis];
    let mut at = cell.at;
    let mut highest = height(cell);
    loop {
        let next = at[axis].checked_add_signed(if rise > 0.0 { 1 } else { -1 });
        let Some(next) = next.filter(|next| *next < CELLS[axis]) else { return rise };
        at[axis] = next;
        let above = between.grid[at[0]][at[1]].map(|index| height(&between.cells[index]));
        match above.filter(|above| *above >= highest - LEVEL_M) {
            Some(above) => highest = above,
            None => return 0.0,
        }
    }
}

/// Height difference below which surfaces are level, in metres.
const LEVEL_M: f64 = 1e-6;
