use cranny_spatial::nalgebra::{Matrix4, Vector4};

use crate::load::between::Between;

/// Pressure of a soft pad per depth, in N/m³: pressed with 70 N, 17.5 × 18.5 mm yield by 0.4 mm.
pub const SOFT_PAD: f64 = 5e8;
/// Pressure of a hard pad per depth, in N/m³: it yields by 0.02 mm, so that it bears on few points.
pub(crate) const HARD_PAD: f64 = 20.0 * SOFT_PAD;
/// Rotation at which friction against turning sets in, in radians.
const SETTING_IN_RAD: f64 = 2e-3;
/// Small stiffness against turning, in N m, which makes the point of least energy unique.
const TRACE: f64 = 1e-2;
/// Maximum number of Newton steps.
const MOST_STEPS: usize = 60;
/// Minimum gain of a step, in joules.
const LEAST_GAIN: f64 = 1e-9;

/// Rest position of an object between two flat soft pads.
#[derive(Clone, Debug)]
pub(crate) struct Seat {
    /// Displacement of the object along y, in metres.
    pub shift_m: f64,
    /// Rotation of the object about z and about −x, in radians.
    pub turn_rad: [f64; 2],
    /// Forces on the cells of the pad at +y and of the pad at −y, in newtons, one per cell.
    pub pressures: [Vec<f64>; 2],
    /// Stiffness of a cell, in N/m.
    pub stiffness: f64,
    /// Width of the object between the pads, in metres.
    pub width_m: f64,
}

impl Seat {
    /// Rotation of the object, in radians.
    pub fn turn(&self) -> f64 {
        self.turn_rad[0].hypot(self.turn_rad[1])
    }

    /// Minimizes the energy of two beds of springs of a hardness (N/m³), the work of the closing force (N) and that of
    /// friction against turning between the pads, over opening, shift and two small rotations, by damped Newton. `None`
    /// if nothing is between the pads.
    pub fn of(between: &Between, hardness: f64, force_n: f64, friction: f64) -> Option<Self> {
        let cells = &between.cells;
        let count = cells.len() as f64;
        let high = cells.iter().map(|cell| cell.upper).fold(f64::NEG_INFINITY, f64::max);
        let low = cells.iter().map(|cell| cell.lower).fold(f64::INFINITY, f64::min);
        let width_m = cells.iter().map(|cell| cell.upper - cell.lower).fold(f64::NEG_INFINITY, f64::max);
        if cells.is_empty() {
            return None;
        }
        let middle = [
            cells.iter().map(|cell| cell.x).sum::<f64>() / count,
            cells.iter().map(|cell| cell.z).sum::<f64>() / count,
        ];
        let stiffness = hardness * between.cell_area_m2;
        let resist = friction * force_n * width_m;
        let rows: Vec<[f64; 2]> = cells.iter().map(|cell| [cell.x - middle[0], cell.z - middle[1]]).collect();
        let depths = |v: &Vector4<f64>, cell: usize| {
            let ([dx, dz], sides) = (rows[cell], &cells[cell]);
            let moved = v[1] + v[2] * dx + v[3] * dz;
            [(sides.upper + moved - v[0]).max(0.0), (-sides.lower - moved - v[0]).max(0.0)]
        };
        let energy = |v: &Vector4<f64>| {
            let springs: f64 = (0..cells.len()).map(|cell| depths(v, cell)).map(|[a, b]| a * a + b * b).sum();
            let turning = v[2].hypot(v[3]).hypot(SETTING_IN_RAD) - SETTING_IN_RAD;
            0.5 * stiffness * springs
                + 2.0 * force_n * v[0]
                + 0.5 * TRACE * (v[2] * v[2] + v[3] * v[3])
                + resist * turning
        };
        let mut v = Vector4::new(0.5 * (high - low) - 1e-4, -0.5 * (high + low), 0.0, 0.0);
        let mut value = energy(&v);
        for _ in 0..MOST_STEPS {
            let mut slope = Vector4::new(2.0 * force_n, 0.0, TRACE * v[2], TRACE * v[3]);
            let mut curve = Matrix4::from_diagonal(&Vector4::new(1e3, 1e3, TRACE, TRACE));
            for (cell, [dx, dz]) in rows.iter().enumerate() {
                let depths = depths(&v, cell);
                for (depth, sign) in depths.into_iter().zip([1.0, -1.0]) {
                    if depth > 0.0 {
                        let row = Vector4::new(-1.0, sign, sign * dx, sign * dz);
                        slope += row * (stiffness * depth);
                        curve += row * row.transpose() * stiffness;
                    }
                }
            }
            let turn = Vector4::new(0.0, 0.0, v[2], v[3]);
            let steep = turn.norm().hypot(SETTING_IN_RAD);
            slope += turn * (resist / steep);
            let level = Matrix4::from_diagonal(&Vector4::new(0.0, 0.0, 1.0, 1.0)) / steep;
            curve += (level - turn * turn.transpose() / steep.powi(3)) * resist;
            let Some(mut step) = curve.cholesky().map(|curve| -curve.solve(&slope)) else { break };
            for (axis, most) in [3e-3, 3e-3, 0.1, 0.1].into_iter().enumerate() {
                step[axis] = step[axis].clamp(-most, most);
            }
            let mut share = 1.0;
            let mut tried = energy(&(v + step));
            while tried > value + 1e-12 && share > 1e-4 {
                share *= 0.5;
                tried = energy(&(v + step * share));
            }
            if share <= 1e-4 {
                break;
            }
            v += step * share;
            let gain = value - tried;
            value = tried;
            if gain < LEAST_GAIN {
                break;
            }
        }
        let pressures = [0, 1]
            .map(|pad| (0..cells.len()).map(|cell| stiffness * depths(&v, cell)[pad]).collect::<Vec<f64>>());
        Some(Self { shift_m: v[1], turn_rad: [v[2], v[3]], pressures, stiffness, width_m })
    }
}
