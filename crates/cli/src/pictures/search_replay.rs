use std::path::Path;
use std::sync::Arc;

use cranny_file::counted;
use cranny_grasp::ScoreKind;
use cranny_plan::{Observer, Registry};
use cranny_record::PlanFile;
use cranny_solve::{Answer, Request, solve};
use cranny_task::Problem;
use cranny_view::TreeRecording;

use crate::arguments::Output;
use crate::failure::Failure;
use crate::progress::SearchProgress;
use crate::text;

/// Repeats the search of a plan with the planner, settings, seed and number of iterations of its file, and returns its trees.
/// Prints a note for everything that the trees do not show.
pub fn replay(
    file: &Path,
    plan: &PlanFile,
    problem: &Problem,
    registry: &Registry,
    output: Output,
) -> Result<TreeRecording, Failure> {
    let search = |request: Request| -> Result<(TreeRecording, bool), Failure> {
        let mut watched = Watched {
            recording: TreeRecording::new(problem.robot().clone(), TreeRecording::MOST_NODES),
            progress: SearchProgress::new(output.quiet, Arc::default()),
        };
        let answer = solve(problem, &request, &mut watched)?;
        watched.progress.finish();
        Ok((watched.recording, is_same(plan, &answer)))
    };
    let request = Request { registry: registry.clone(), ..plan.request() };
    let (mut recording, mut is_repeated) = search(request.clone())?;
    if !is_repeated && plan.score == ScoreKind::Load {
        // Loads that the file of grasps states have ranked them instead of computed ones.
        let stated = search(Request { score: None, ..request })?;
        if stated.1 {
            (recording, is_repeated) = stated;
        }
    }
    let note = |text: String| text::note(&format!("{}: {text}", file.display()));
    if plan.optimisation.is_some() {
        note("the trees are those of its first search; later searches improved the path".to_owned())?;
    } else if !is_repeated {
        note(format!(
            "its search gave another result this time (was the plan made by another version, {}?)",
            plan.version
        ))?;
    }
    if recording.left_out() > 0 {
        let (kept, all) = (recording.len(), recording.len() + recording.left_out());
        note(format!("its trees have {}; only the first {kept} are shown", counted(all, "node")))?;
    }
    Ok(recording)
}

/// Returns true if the repeated search ended with the outcome and the path of the plan.
fn is_same(plan: &PlanFile, answer: &Answer) -> bool {
    let bits = |q: &Vec<f64>| q.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    answer.outcome == plan.outcome
        && answer.statistics.nodes == plan.statistics.nodes
        && answer.waypoints().iter().map(bits).eq(plan.waypoints.iter().map(bits))
}

/// Observer that records the trees and shows the progress. Ctrl-C ends the program: a page with incomplete trees would
/// pass for a complete one.
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
}
