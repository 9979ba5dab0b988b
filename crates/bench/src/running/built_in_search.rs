use std::cell::RefCell;

use cranny_file::system::PeakMemory;
use cranny_plan::{Observer, Statistics};
use cranny_record::{PlanAttempt, PlanSource};
use cranny_scenario::Scenario;
use cranny_sim::{SimulatedAnswer, solve_in_physics};
use cranny_solve::{Answer, Request, solve};
use cranny_task::Problem;

use crate::running::worker_message::Message;
use crate::{BenchError, PathDemand, Trial, TrialOutcome, TrialRecord};

/// Function that sends a message to the campaign.
pub type Tell<'a> = &'a mut dyn FnMut(&Message) -> Result<(), BenchError>;

/// Result of a built-in planner.
pub struct Found {
    /// Answer of the last search.
    pub answer: Answer,
    /// Result in physics if plans were tried and none went as planned.
    pub failure: Option<String>,
    /// Sum over all searches.
    statistics: Statistics,
    memory_bytes: Option<u64>,
}

impl Found {
    /// Runs a built-in planner, and its plans in physics if demanded.
    pub fn plan(
        (scenario, problem): (&Scenario, &Problem),
        request: &Request,
        demand: &PathDemand,
        (tell, peak): (Tell<'_>, &PeakMemory),
    ) -> Result<Self, BenchError> {
        let tell = RefCell::new(tell);
        let mut end = EndOfSearch { tell: &tell, told: Ok(()), peak, memory_bytes: None };
        let found = if let Some(most) = demand.try_in_physics {
            let source = PlanSource {
                scenario: scenario.id.clone(),
                grasps: demand.given_grasps(),
                margins: demand.margins,
                ..PlanSource::default()
            };
            let most = usize::try_from(most).unwrap_or(usize::MAX);
            // The next search has a time limit of its own.
            let again = |_: &PlanAttempt| drop((tell.borrow_mut())(&Message::Opened));
            solve_in_physics((scenario, problem), (request, &source), most, &mut end, again)?
        } else {
            let answer = solve(problem, request, &mut end)?;
            SimulatedAnswer { statistics: answer.statistics, answer, tries: Vec::new() }
        };
        end.told?;
        let SimulatedAnswer { answer, tries, statistics } = found;
        let failed = tries.last().filter(|last| !last.as_planned);
        let failure = failed.map(|last| {
            let count = tries.len();
            format!("none of {count} plans went as planned in physics; the last object: {}", last.outcome)
        });
        Ok(Self { answer, failure, statistics, memory_bytes: end.memory_bytes })
    }

    /// Record of the trial before its path is judged.
    pub fn record(&self, trial: &Trial) -> TrialRecord {
        let refused = || self.answer.refused.as_ref().map(ToString::to_string);
        let outcome = match &self.failure {
            Some(_) => TrialOutcome::GaveUp,
            None => TrialOutcome::without_path(self.answer.outcome),
        };
        let detail = self.failure.clone().or_else(refused);
        TrialRecord {
            memory_bytes: self.memory_bytes,
            ..TrialRecord::without_path(trial, outcome, detail, self.statistics)
        }
    }
}

/// Observer that measures the memory of the first search and reports the end of each: judging has limits of its own.
struct EndOfSearch<'a, 't> {
    tell: &'a RefCell<Tell<'t>>,
    told: Result<(), BenchError>,
    peak: &'a PeakMemory,
    memory_bytes: Option<u64>,
}

impl Observer for EndOfSearch<'_, '_> {
    fn search_ended(&mut self) {
        // Later searches follow a simulation, whose memory does not count for the planner.
        self.memory_bytes = self.memory_bytes.or_else(|| self.peak.growth_bytes());
        self.told = (self.tell.borrow_mut())(&Message::Planned);
    }
}
