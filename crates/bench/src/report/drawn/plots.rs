use crate::report::drawn::plot::{Plot, Scope};
use crate::report::drawn::{box_plot, difficulty_plot, profile_plot, success_plot};
use crate::report::summary::Summary;

/// Returns all plots of a summary, in the order of the page: by criterion, then over all scenarios, then by environment.
pub fn plots(summary: &Summary) -> Vec<Plot> {
    let mut plots = Vec::new();
    for criterion in summary.criteria() {
        let overall = Scope { summary, criterion, environment: None };
        plots.extend(success_plot::overall(overall));
        plots.extend(profile_plot::plot(overall));
        for environment in summary.environments(criterion) {
            let scope = Scope { summary, criterion, environment: Some(environment) };
            plots.extend(success_plot::plots(scope));
            plots.extend(difficulty_plot::plots(scope));
            plots.extend(box_plot::plots(scope));
        }
    }
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
