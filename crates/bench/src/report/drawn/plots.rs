use crate::report::drawn::plot::{Plot, Scope};
use crate::report::drawn::success_curve::MOST_CURVES;
use crate::report::drawn::{box_plot, difficulty_plot, profile_plot, success_plot};
use crate::report::planner_rank::ranked_planners;
use crate::report::summary::Summary;

/// Maximum number of plots of a report.
const MOST_PLOTS: usize = 300;

/// Returns the plots of a summary, in the order of the page: by criterion, then over all scenarios, then by environment; at most
/// 300, and of the eight best planners if there are more.
pub fn plots(summary: &Summary) -> Vec<Plot> {
    let ranked = ranked_planners(&summary.rows);
    let mut drawn: Vec<&str> = ranked.iter().copied().take(MOST_CURVES).collect();
    drawn.sort_unstable();
    let planners_in_all = ranked.len();
    let mut plots = Vec::new();
    for criterion in summary.criteria() {
        let overall = Scope { summary, criterion, environment: None, drawn: &drawn, planners_in_all };
        plots.extend(success_plot::overall(overall));
        plots.extend(profile_plot::plot(overall));
        for environment in summary.environments(criterion) {
            if plots.len() >= MOST_PLOTS {
                break;
            }
            let scope = Scope { environment: Some(environment), ..overall };
            plots.extend(success_plot::plots(scope));
            plots.extend(difficulty_plot::plots(scope));
            plots.extend(box_plot::plots(scope));
        }
    }
    plots.truncate(MOST_PLOTS);
    let mut taken = std::collections::BTreeMap::<String, usize>::new();
    for plot in &mut plots {
        // Names of planners may differ only in characters that are removed from file names.
        let count = taken.entry(plot.name.clone()).or_default();
        *count += 1;
        if *count > 1 {
            plot.name = format!("{}-{count}", plot.name);
        }
    }
    plots
}
