use cranny_grasp::{GraspSet, ScoreKind};
use serde::Serialize;

/// Loads of a set of grasps that a command writes.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct GraspLoads {
    /// Load that half of the grasps exceed.
    median: f64,
    /// Number of grasps with a load of [`FIRM`] or more.
    firm: usize,
    /// True if the mass of the object is not stated, and was assumed from its volume.
    mass_assumed: bool,
}

/// Load from which a grasp counts as firm: most such grasps do not slip in physics (`benchmarks/load.md`).
const FIRM: f64 = 2.0;

impl GraspLoads {
    /// Returns the loads of a set; `None` if none is known.
    pub fn of(set: &GraspSet, mass_assumed: bool) -> Option<Self> {
        let mut loads: Vec<f64> = set.grasps().iter().filter_map(|grasp| grasp.load).collect();
        loads.sort_by(f64::total_cmp);
        let median = *loads.get(loads.len() / 2)?;
        Some(Self { median, firm: loads.iter().filter(|load| **load >= FIRM).count(), mass_assumed })
    }

    /// Formats the loads for display.
    pub fn text(&self) -> String {
        let assumed = if self.mass_assumed { "; mass not stated: 400 kg/m³ assumed" } else { "" };
        format!("{:.2} at the median, {} of {FIRM} or more{assumed}", self.median, self.firm)
    }
}

/// Returns the grasps sorted by their score of a kind, highest first.
pub fn sorted(set: &GraspSet, kind: ScoreKind) -> GraspSet {
    set.chosen(&set.scored_by(kind).by_score())
}
