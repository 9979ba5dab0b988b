//! Description of the space that cameras have seen.

use cranny_scenario::{Scenario, SeenSpace};
use cranny_sense::Unseen;
use serde::Serialize;

/// Map of a scenario, for Python.
#[derive(Serialize)]
pub struct SeenSummary {
    views: usize,
    unseen: &'static str,
    cell_m: f64,
    region: [[f64; 3]; 2],
    free_m3: f64,
    occupied_boxes: usize,
    unseen_boxes: usize,
    detail_m: f64,
    /// `None` without a target.
    detail_beside_target_m: Option<f64>,
    statement: Option<String>,
}

impl SeenSummary {
    /// Returns the summary of the map; `None` without one.
    pub fn of(scenario: &Scenario) -> Option<Self> {
        let SeenSpace { map, sensors, options, .. } = scenario.seen.as_ref()?;
        let region = &map.settings().region;
        let [detail_m, detail_beside_target_m] = map.detail_m();
        Some(Self {
            views: sensors.len(),
            unseen: match options.unseen {
                Unseen::Solid => "solid",
                Unseen::Free => "free",
            },
            cell_m: options.cell_m,
            region: [region.low().coords.into(), region.high().coords.into()],
            free_m3: map.free_m3(),
            occupied_boxes: map.occupied().len(),
            unseen_boxes: map.unseen().len(),
            detail_m,
            detail_beside_target_m: scenario.target.map(|_| detail_beside_target_m),
            statement: scenario.seen_statement(),
        })
    }
}
