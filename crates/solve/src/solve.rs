use std::time::Instant;

use cranny_plan::{
    Criterion, MotionLimits, Observer, Outcome, PlanError, PlanReport, Problem, ShortcutSettings, Shortened,
    Trajectory, audit_with, optimise, search, shortcut,
};

use crate::{Answer, Optimisation, Request, Segment, Shortening, SolveError, Timed, Timing};

/// Solves a problem as a request says.
///
/// 1. The planner looks for a path; better ones are looked for if that is asked.
/// 2. A path under `exact` is shortened, unless it is to be kept or was bettered.
/// 3. Whatever was found is judged like anybody's path before it is called solved.
/// 4. A path that holds gets its time, if that is asked.
///
/// That there is no path is an answer ([`Outcome`]), no error.
///
/// # Errors
/// As [`Request::check`], and those of the planner.
pub fn solve(
    problem: &Problem,
    request: &Request,
    observer: &mut dyn Observer,
) -> Result<Answer, SolveError> {
    request.check(problem)?;
    let mut problem = request.scored(problem)?;
    if let Some(threshold) = request.goal_threshold {
        problem = problem.with_goal_threshold(threshold);
    }
    let planner = request.planner_for(problem.criterion())?;
    // 1.
    let (budget, seed) = (&request.budget, request.seed);
    let mut optimisation = None;
    let report = match request.optimise {
        Some(settings) => {
            let optimised = optimise(planner.as_ref(), &mut problem, budget, settings, seed, observer)?;
            optimisation = Some(Optimisation {
                settings,
                time_s: optimised.time_s,
                iterations: optimised.iterations,
                improvements: optimised.improvements,
            });
            optimised.report
        }
        None => search(planner.as_ref(), &mut problem, budget, seed, observer)?,
    };
    observer.search_ended();
    let PlanReport { outcome, mut path, statistics, failures } = report;
    // 2.
    let mut shortening = None;
    let is_shortened =
        problem.criterion() == Criterion::Exact && optimisation.is_none() && !request.keep_path;
    if is_shortened && !path.is_empty() {
        let settings = ShortcutSettings { seed, ..ShortcutSettings::default() };
        let Shortened { path: shortened, time_s } = shortcut(&problem, &path, settings)?;
        path = shortened;
        shortening = Some(Shortening { attempts: settings.attempts, time_s });
    }
    // 3.
    let audit = if path.is_empty() { None } else { Some(audit_with(&problem, &path, request.audit)?) };
    let not_checked = audit.as_ref().map_or_else(|| problem.not_checked(), |audit| audit.not_checked.clone());
    // 4.
    let holds = outcome == Outcome::Solved && audit.as_ref().is_some_and(|audit| audit.valid);
    let timed = match request.timing {
        Some(timing) if holds => {
            let begin = Instant::now();
            let trajectory = timing.of(&problem, &path)?;
            trajectory.map(|trajectory| Timed { trajectory, time_s: begin.elapsed().as_secs_f64() })
        }
        _ => None,
    };
    let limits = request.timing.map(|timing| MotionLimits::of(problem.robot(), timing.method));
    let untimed = limits.and_then(Result::err).map(|fault| fault.to_string());
    let clearances_m = audit.as_ref().map(|audit| audit.clearances_per_edge_m.clone()).unwrap_or_default();
    let segments = if path.is_empty() { Vec::new() } else { vec![Segment { waypoints: path, clearances_m }] };
    Ok(Answer {
        planner: planner.name().to_owned(),
        settings: planner.settings(),
        criterion: problem.criterion(),
        score: request.score,
        goal_threshold: problem.goal_threshold(),
        budget: request.budget,
        seed,
        joint_names: problem.robot().joint_names().to_vec(),
        outcome,
        segments,
        audit,
        timed,
        untimed,
        shortening,
        optimisation,
        statistics,
        failures,
        not_checked,
    })
}

impl Timing {
    /// A path in time; `None` for a robot without the limits that this needs.
    ///
    /// # Errors
    /// [`PlanError`] for a path that cannot be timed.
    pub fn of(self, problem: &Problem, path: &[Vec<f64>]) -> Result<Option<Trajectory>, PlanError> {
        let Ok(limits) = MotionLimits::of(problem.robot(), self.method) else { return Ok(None) };
        let trajectory = match problem.cell().filter(|_| self.blend) {
            Some(cell) => Trajectory::blended(path, &limits, cell)?,
            None => Trajectory::along(path, &limits)?,
        };
        Ok(Some(trajectory))
    }
}
