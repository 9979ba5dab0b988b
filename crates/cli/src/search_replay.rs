use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use cranny_plan::{
    Budget, Observer, Outcome, PlanReport, Problem, ShortcutSettings, planner_with, search, shortcut,
};
use cranny_scenario::PlanFile;
use cranny_view::TreeRecording;

use crate::arguments::Output;
use crate::failure::Failure;
use crate::progress::SearchProgress;
use crate::text;

/// The trees of the search that made a plan, which is run again as the plan file says that it was: same planner,
/// settings and seed, and as many iterations. What the trees do not show is said in one line each.
pub fn replay(
    file: &Path,
    plan: &PlanFile,
    problem: &Problem,
    stop: &Arc<AtomicBool>,
    output: Output,
) -> Result<TreeRecording, Failure> {
    let settings = plan.settings.as_object().cloned().unwrap_or_default();
    let planner = planner_with(&plan.planner, &settings)?;
    // The time that it took says nothing of this machine.
    let budget = Budget { iterations: plan.statistics.iterations, time: Duration::MAX };
    let mut watched = Watched {
        recording: TreeRecording::new(problem.robot.clone(), TreeRecording::MOST_NODES),
        progress: SearchProgress::new(output.quiet, stop.clone()),
    };
    let report = search(planner.as_ref(), &mut problem.clone(), &budget, plan.seed, &mut watched)?;
    watched.progress.finish();
    let recording = watched.recording;
    let note = |text: String| text::note(&format!("{}: {text}", file.display()));
    if report.outcome == Outcome::Cancelled {
        note("its search was stopped; the trees end there".to_owned())?;
    } else if plan.optimisation.is_some() {
        note("the trees are those of its first search; later ones bettered the path".to_owned())?;
    } else if !is_same(plan, &report, problem) {
        note(format!("its search went another way this time ({} has another version?)", plan.version))?;
    }
    if recording.left_out() > 0 {
        let (kept, all) = (recording.len(), recording.len() + recording.left_out());
        note(format!("its trees have {all} nodes; the first {kept} are shown"))?;
    }
    Ok(recording)
}

/// Whether the search ended as the plan says, with its path or the one that was shortened to it.
fn is_same(plan: &PlanFile, report: &PlanReport, problem: &Problem) -> bool {
    if report.outcome != plan.outcome || report.statistics.nodes != plan.statistics.nodes {
        return false;
    }
    let is_it = |path: &[Vec<f64>]| {
        let bits = |path: &[Vec<f64>]| -> Vec<u64> { path.iter().flatten().map(|x| x.to_bits()).collect() };
        bits(path) == bits(&plan.waypoints)
    };
    if is_it(&report.path) {
        return true;
    }
    let settings = ShortcutSettings { seed: plan.seed, ..ShortcutSettings::default() };
    shortcut(problem, &report.path, settings).is_ok_and(|shortened| is_it(&shortened.path))
}

/// Records, shows how far it is, and ends on Ctrl-C.
struct Watched {
    recording: TreeRecording,
    progress: SearchProgress,
}

impl Observer for Watched {
    fn node_added(&mut self, tree: usize, q: &[f64], parent: Option<usize>) {
        self.recording.node_added(tree, q, parent);
    }

    fn progress(&mut self, iterations: u64) {
        self.progress.progress(iterations);
    }

    fn should_stop(&self) -> bool {
        self.progress.should_stop()
    }
}
