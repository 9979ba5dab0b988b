use std::fmt::Write as _;

use cranny_bench::statistics::area_under_curve;
use cranny_grasp::Load;
use cranny_sim::{GraspOutcome, GraspRow};
use serde::Serialize;

use crate::text;

/// Agreement of the computed load of grasps with physics.
#[derive(Serialize)]
pub struct LoadPrediction {
    /// Area under the ROC curve: fraction of pairs of a successful and a lost grasp with greater load at rest of the former.
    area_under_curve: Option<f64>,
    /// Grasps with a load at rest of 2 or more.
    firm: Share,
    /// Grasps with a load at rest below 0.8.
    weak: Share,
    /// Grasps with a load of 1.5 or more along the whole motion.
    firm_in_motion: Share,
}

/// Number of successful grasps, out of those tested.
#[derive(Clone, Copy, Serialize)]
struct Share {
    held: usize,
    tried: usize,
}

impl LoadPrediction {
    /// Computes the agreement over rows with a load whose hand closed on the object; `None` without any.
    pub fn of(rows: &[GraspRow]) -> Option<Self> {
        let closed = rows.iter().filter(|row| row.outcome != GraspOutcome::NeverClosed);
        let known: Vec<(Load, bool)> =
            closed.filter_map(|row| Some((row.load?, row.outcome == GraspOutcome::Held))).collect();
        let share = |is_meant: &dyn Fn(&Load) -> bool| {
            let meant = || known.iter().filter(|(load, _)| is_meant(load));
            Share { held: meant().filter(|(_, held)| *held).count(), tried: meant().count() }
        };
        let at_rest = |wanted: bool| -> Vec<f64> {
            known.iter().filter(|(_, held)| *held == wanted).map(|(load, _)| load.at_rest).collect()
        };
        (!known.is_empty()).then(|| Self {
            area_under_curve: area_under_curve(&at_rest(true), &at_rest(false)),
            firm: share(&|load| load.at_rest >= 2.0),
            weak: share(&|load| load.at_rest < 0.8),
            firm_in_motion: share(&|load| load.in_motion >= 1.5),
        })
    }

    /// Formats the agreement for display.
    pub fn page(&self) -> String {
        let mut page = String::new();
        let mut line = |whose: &str, share: Share| {
            if share.tried > 0 {
                let _ = writeln!(page, "  load {whose}: {} of {} held", share.held, share.tried);
            }
        };
        line("of 2 or more at rest", self.firm);
        line("below 0.8 at rest", self.weak);
        line("of 1.5 or more along the course", self.firm_in_motion);
        if let Some(area) = self.area_under_curve {
            let percent = 100.0 * area;
            let _ = writeln!(
                page,
                "  of two grasps, one held and one not, the held one has the greater load at rest in {percent:.1} %"
            );
        }
        page
    }
}

/// Formats a load for display.
pub fn load_text(load: &Load) -> String {
    let Load { at_rest, in_motion, turn_rad, shift_m, .. } = load;
    let (turned, moved) = (text::degrees(*turn_rad), text::millimetres(shift_m.abs()));
    format!(
        "{at_rest:.2} at rest, {in_motion:.2} along the course (below 1 a pad slips, for as long as that lasts); \
         closing turns it by {turned} and moves it by {moved}"
    )
}
