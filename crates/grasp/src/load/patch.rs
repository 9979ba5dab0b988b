use crate::load::between::Between;
use crate::load::limit_surface::LoadedPoint;

/// Arm of the torsion of the smallest patch, in metres: of a Hertz patch of radius 3.14 mm, as a ball of 33 mm makes in a
/// pad that gives way by 0.3 mm, 3π/16 of its radius.
pub const LEAST_ARM_M: f64 = 0.00185;
/// A cell bears if it bears more than this share of the greatest.
const BEARS: f64 = 0.02;

/// The patch on which a pad bears, in its plane.
#[derive(Clone, Debug)]
pub(crate) struct Patch {
    /// Centre of pressure along x and z, in metres.
    pub center_m: [f64; 2],
    /// Mean distance of the pressure from its centre, in metres: what turns against friction does so on this arm.
    pub arm_m: f64,
    /// Half of the extent of the cells that bear, along x and z, in metres.
    pub half_m: [f64; 2],
    /// The cells that bear, about the centre of pressure.
    pub points: Vec<LoadedPoint>,
    /// Arm on which each of the points turns besides, in metres.
    pub point_arm_m: f64,
}

impl Patch {
    /// The patch of a pad by the forces on its cells (N; one per cell); `None` where none bears.
    pub fn of(between: &Between, pressure: &[f64]) -> Option<Self> {
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
        let extent = |of: fn(&crate::load::between::Cell) -> f64| {
            let most = bearing().filter(|(_, load)| **load > BEARS * greatest).map(|(cell, _)| of(cell));
            let (low, high) = most.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
                (low.min(value), high.max(value))
            });
            0.5 * (high - low)
        };
        Some(Self {
            center_m,
            arm_m,
            half_m: [extent(|cell| cell.x), extent(|cell| cell.z)],
            points,
            point_arm_m,
        })
    }
}
