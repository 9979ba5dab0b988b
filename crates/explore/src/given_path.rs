use cranny_plan::{Budget, Observer, Outcome, PlanError, PlanReport, Planner, Registry, Statistics};
use cranny_solve::Request;
use cranny_task::Problem;
use serde::{Deserialize, Serialize};

/// Planner that returns a path that is known already, if it is proven: so that it is shortened, timed and audited like any other.
#[derive(Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct GivenPath {
    /// Way points (m, rad; one value per joint).
    path: Vec<Vec<f64>>,
}

/// Name of the planner.
const NAME: &str = "given-path";

impl Planner for GivenPath {
    fn name(&self) -> &'static str {
        NAME
    }

    fn settings(&self) -> serde_json::Value {
        serde_json::json!(self)
    }

    fn plan(
        &self,
        problem: &Problem,
        _budget: &Budget,
        _seed: u64,
        _observer: &mut dyn Observer,
    ) -> Result<PlanReport, PlanError> {
        let cell = problem.exact_cell(NAME)?;
        let mut scratch = cell.scratch();
        let mut edges = self.path.windows(2);
        let is_proven = edges.all(|edge| cell.motion_is_free(&edge[0], &edge[1], &mut scratch).is_proven());
        let ended =
            if is_proven && self.path.len() > 1 { Ok(self.path.clone()) } else { Err(Outcome::GaveUp) };
        Ok(PlanReport::of(ended, Statistics::default()))
    }
}

/// Returns a request in which the planner returns this path (m, rad; one value per joint).
pub(crate) fn with_given_path(request: &Request, path: &[Vec<f64>]) -> Result<Request, PlanError> {
    let registry = Registry::default().with::<GivenPath>()?;
    let settings = [("path".to_owned(), serde_json::json!(path))].into_iter().collect();
    Ok(Request { registry, planner: Some(NAME.to_owned()), settings, ..request.clone() })
}
