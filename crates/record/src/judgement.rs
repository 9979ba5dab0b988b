use cranny_collision::Margins;
use cranny_path::{Audit, AuditSettings, Cause, Clearances, Violation, audit_without_proof, path_length};
use cranny_plan::{Outcome, PlanError};
use cranny_scenario::NamedTask;
use cranny_solve::{HoldFactors, Robustness, Tilt, ToolSlack, least_length};
use cranny_task::{NotChecked, Problem, Segment, Stage, StateSequence, give_clearances};
use serde::Serialize;
use serde_json::Value;

use crate::statement::{NOT_CHECKED, Statement, differences};
use crate::{PlanFile, PlanPick, PlanSource, PlanTiming};

/// Verdict on a plan file: on its path, and on all other statements.
#[derive(Clone, Debug, Serialize)]
pub struct Judgement {
    /// Verdict on the path. A false statement is one of its violations, unless the plan was made for another task.
    #[serde(flatten)]
    pub audit: Audit,
    /// Requirements of the file that the audit used, unless `differs` names them.
    pub demanded: Demanded,
    /// Statements that differ from the measured values or from the task of this audit, without effect on the verdict.
    pub differs: Vec<Statement>,
    /// Keys of the file whose values were measured again and compared.
    pub compared: Vec<&'static str>,
    /// Keys of the file that were not compared: they record how the path was found.
    pub not_compared: Vec<&'static str>,
    /// The plan with all figures as measured.
    #[serde(skip)]
    pub measured: PlanFile,
    /// True if the plan was made for the task of this audit, with any set of grasps.
    #[serde(skip)]
    pub is_own_task: bool,
}

impl Judgement {
    /// Returns the compared keys of the file without those of differing or false values.
    pub fn as_stated(&self) -> Vec<&'static str> {
        let false_key = |violation: &Violation| match &violation.cause {
            Cause::Statement { key, .. } => Some(key.clone()),
            _ => None,
        };
        let differing = self.differs.iter().map(|statement| statement.key.clone());
        let other: Vec<String> =
            differing.chain(self.audit.violations.iter().filter_map(false_key)).collect();
        let is_other = |key: &str| other.iter().any(|other| first_key(other) == key);
        self.compared.iter().copied().filter(|key| !is_other(key)).collect()
    }
}

/// Requirements on a path that a plan file contains.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Demanded {
    /// Clearance of every proof.
    pub margins: Margins,
    /// Stages, as [`PlanFile::task`].
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub task: Vec<Stage>,
    /// Least factor of the hold.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hold: Option<f64>,
}

/// Keys that state the task of a plan: if one differs, no figure belongs to the task of this audit.
const TASK: [&str; 5] = ["scenario", "robot", "geometry", "criterion", "margins"];

const GRASPS: &str = "grasps";
const HOLD_DEMANDED: &str = "hold_demanded";

/// The only figures that depend on the set of grasps: no motion does.
const OF_GRASPS: [&str; 6] =
    ["grasp", "translation_error_m", "rotation_error_rad", "own_grasp", "picks", "least_length"];

/// Keys whose values are measured again.
const MEASURED: [&str; 22] = [
    "task_name",
    "task",
    "picks",
    "goal_threshold",
    NOT_CHECKED,
    "outcome",
    "joint_names",
    "grasp",
    "translation_error_m",
    "rotation_error_rad",
    "own_grasp",
    "clearance_m",
    "clearances_per_edge_m",
    "path_length",
    "least_length",
    "segments",
    "timing",
    "robustness",
    "tilt",
    "tool",
    "hold",
    HOLD_DEMANDED,
];

/// Keys that are never measured: they record how the path was found.
const RECORD: [&str; 16] = [
    "planner",
    "settings",
    "score",
    "seed",
    "version",
    "budget",
    "statistics",
    "shortening",
    "optimisation",
    "failures",
    "goal_faults",
    "no_grasp",
    "refused",
    "min_score",
    "below_min_score",
    "tries",
];

/// Keys of a plan without a path that are taken as stated.
const AS_STATED: [&str; 2] = ["outcome", NOT_CHECKED];

impl PlanFile {
    /// Audits the path like one of any other origin, and compares all other statements of the plan with values measured along
    /// it; `None` for a plan without a path. `task` is the source of the problem.
    ///
    /// Pairs that the problem leaves out but can compare ([`Problem::checking_all_pairs`]) are compared if the plan does not
    /// name them and is valid with them: then its planner compared them too.
    ///
    /// # Errors
    /// As [`audit_task`](cranny_path::audit_task).
    pub fn judge(
        &self,
        task: &PlanSource,
        problem: &Problem,
        settings: AuditSettings,
    ) -> Result<Option<Judgement>, PlanError> {
        let judgement = self.judge_in(task, problem, settings)?;
        let is_unnamed = |pair: &NotChecked| {
            let names = |of: &NotChecked| [of.first.clone(), of.second.clone()];
            pair.can_be_checked() && self.not_checked.iter().all(|other| names(other) != names(pair))
        };
        if judgement.as_ref().is_some_and(|judgement| judgement.audit.not_checked.iter().any(is_unnamed)) {
            let strict = self.judge_in(task, &problem.clone().checking_all_pairs(), settings)?;
            if strict.as_ref().is_some_and(|strict| strict.audit.valid) {
                return Ok(strict);
            }
        }
        Ok(judgement)
    }

    /// Compares the statements of a plan without a path with the task. Its outcome, and the reasons for it, are taken as
    /// stated: no search is repeated. It has no other statements.
    pub fn judge_without_path(&self, task: &PlanSource, problem: &Problem) -> Judgement {
        let audit = Audit::empty();
        let measured = Self {
            scenario: task.scenario.clone(),
            robot: task.robot.as_ref().map(|file| file.display().to_string()),
            geometry: task.geometry.map(|geometry| geometry.name().to_owned()),
            grasps: task.grasps.text(),
            criterion: problem.criterion(),
            goal_threshold: problem.goal_threshold(),
            margins: task.margins,
            joint_names: problem.robot().joint_names().to_vec(),
            grasp: None,
            translation_error_m: None,
            rotation_error_rad: None,
            own_grasp: None,
            picks: Vec::new(),
            clearance_m: None,
            clearances_per_edge_m: Vec::new(),
            path_length: 0.0,
            segments: Vec::new(),
            waypoints: Vec::new(),
            timing: None,
            least_length: None,
            robustness: None,
            tilt: None,
            tool: Vec::new(),
            hold: None,
            ..self.clone()
        };
        let (stated, found) = (figures(self), figures(&measured));
        let mut judgement = self.judgement(task, audit, measured);
        let figures: Vec<_> = MEASURED.into_iter().filter(|key| !AS_STATED.contains(key)).collect();
        judgement.differs = differences(&TASK, &stated, &found);
        judgement.differs.extend(differences(&[GRASPS], &stated, &found));
        judgement.differs.extend(differences(&figures, &stated, &found));
        let is_stated = |key: &&str| is_stated(&stated[*key]);
        judgement.not_compared = AS_STATED.into_iter().chain(RECORD).filter(is_stated).collect();
        judgement
    }

    fn judge_in(
        &self,
        task: &PlanSource,
        problem: &Problem,
        settings: AuditSettings,
    ) -> Result<Option<Judgement>, PlanError> {
        // The states and radii of a path far beyond the joint limits are not computed.
        let has_path = !self.waypoints.is_empty();
        let is_refused = has_path && audit_without_proof(problem, &self.segments, settings)?.is_some();
        let along = if is_refused { None } else { self.states(problem)? };
        let along = along.as_ref();
        // The radii take as long as the verdict.
        let (audit, robustness) =
            rayon::join(|| self.audit_along(along, problem, settings), || self.measured_robustness(along));
        let Some(audit) = audit? else { return Ok(None) };
        let robustness = robustness.filter(|_| audit.valid);
        let least_length = if audit.valid { self.measured_least_length(problem) } else { None };
        let is_of_hold = self.hold.is_some() || self.hold_demanded.is_some();
        let hold = match along.filter(|_| is_of_hold && audit.valid) {
            Some(along) => HoldFactors::of(problem, along, &self.segments, self.timing_asked())?,
            None => None,
        };
        // The plan of a task states the requirement, which must not exceed the measured factor.
        let met =
            |demanded: f64| hold.map_or(demanded, |hold| demanded.min(hold.factor.unwrap_or(hold.at_rest)));
        let hold_demanded = self.hold_demanded.filter(|_| !self.task.is_empty()).map(met);
        let is_hold_unknown = hold.is_none() && hold_demanded.is_some();
        let measured = self.measured(task, (along, problem), &audit, settings)?;
        let tilt = along.filter(|_| self.tilt.is_some() && audit.valid);
        let tilt = tilt.and_then(|along| Tilt::of(along, &self.segments));
        let tool = along.filter(|_| !self.tool.is_empty() && audit.valid);
        let tool = tool.map_or_else(Vec::new, |along| ToolSlack::all_of(along, &self.segments));
        let measured = Self { least_length, robustness, tilt, tool, hold_demanded, hold, ..measured };
        let (stated, found) = (figures(self), figures(&measured));
        let is_stated = |key: &&str| is_stated(&stated[*key]);
        let mut judgement = self.judgement(task, audit, measured);
        judgement.differs = differences(&TASK, &stated, &found);
        let is_own_task = judgement.differs.is_empty();
        judgement.is_own_task = is_own_task;
        let of_grasps = differences(&[GRASPS], &stated, &found);
        let has_own_grasps = of_grasps.is_empty();
        judgement.differs.extend(of_grasps);
        // For an invalid path, the statements were measured on another path.
        let holds = judgement.audit.valid;
        // An empty list of pairs is a statement too: that all were compared.
        let is_promise = |key: &&str| is_stated(key) || *key == NOT_CHECKED && self::is_stated(&found[*key]);
        // A task without a name is a requirement, not a statement.
        let is_named = |key: &&str| self.task_name.is_some() || !key.starts_with("task");
        let is_known = |key: &&str| *key != HOLD_DEMANDED || !is_hold_unknown;
        let promises = MEASURED.into_iter().filter(is_promise).filter(is_named);
        let (measured_keys, unknown): (Vec<_>, Vec<_>) = promises.partition(is_known);
        if holds {
            for statement in differences(&measured_keys, &stated, &found) {
                let key = first_key(&statement.key);
                // Without a proof, no stated clearance is true.
                let is_unproven =
                    problem.cell().is_none() && statement.measured.is_null() && key != NOT_CHECKED;
                let is_of_task = is_own_task && (has_own_grasps || !OF_GRASPS.contains(&key));
                // As with margins, a demand counts in any scenario.
                let counts = is_of_task || key == HOLD_DEMANDED;
                if counts && (statement.is_false || is_unproven) {
                    judgement.audit.violations.push(statement.violation());
                } else {
                    judgement.differs.push(statement);
                }
            }
            judgement.audit.valid = judgement.audit.violations.is_empty();
            judgement.compared = measured_keys;
        } else {
            judgement.not_compared = measured_keys;
        }
        judgement.not_compared.extend(unknown.into_iter().chain(RECORD.into_iter().filter(is_stated)));
        Ok(Some(judgement))
    }

    /// Creates a verdict before any statement of the plan is compared.
    fn judgement(&self, task: &PlanSource, audit: Audit, measured: Self) -> Judgement {
        Judgement {
            audit,
            demanded: Demanded {
                margins: task.margins,
                task: self.task.clone(),
                hold: self.hold_demanded.filter(|_| !self.task.is_empty()),
            },
            differs: Vec::new(),
            compared: Vec::new(),
            not_compared: Vec::new(),
            measured,
            is_own_task: false,
        }
    }

    fn measured_robustness(&self, along: Option<&StateSequence>) -> Option<Robustness> {
        let along = along.filter(|_| self.robustness.is_some() && !self.waypoints.is_empty())?;
        Robustness::of(along, &self.segments)
    }

    fn measured_least_length(&self, problem: &Problem) -> Option<f64> {
        self.least_length?;
        least_length(problem, &self.task, path_length(&self.waypoints))
    }

    /// Returns the scenario's task of this name if it differs from that of the plan in more than the required distances.
    fn own_task<'a>(&self, source: &'a PlanSource) -> Option<&'a NamedTask> {
        let named = source.task.as_ref()?;
        let is_same = named.stages.len() == self.task.len()
            && named.stages.iter().zip(&self.task).all(|(a, b)| a.is_like(b));
        (!is_same).then_some(named)
    }

    /// Returns the plan with all figures as measured, except its bounds and the firmness of its hold. Every field is listed, so
    /// that a new one needs a decision.
    fn measured(
        &self,
        task: &PlanSource,
        (along, problem): (Option<&StateSequence>, &Problem),
        audit: &Audit,
        settings: AuditSettings,
    ) -> Result<Self, PlanError> {
        let timing = match &self.timing {
            Some(_) if audit.valid => self.trajectory(problem.robot())?.as_ref().map(PlanTiming::of),
            _ => None,
        };
        // A load of unknown mass leaves torques unknown.
        let is_known = along.is_none_or(|along| {
            along.states.iter().all(|state| state.held().is_none() || state.payload(problem).is_some())
        });
        let up = problem.cell().filter(|_| is_known).map(|cell| cell.world().up().into());
        let timing = timing.map(|timing| PlanTiming { torque_up: timing.torque_up.and(up), ..timing });
        let (clearance_m, clearances_per_edge_m) = match settings.clearances {
            Clearances::OfEdges => (audit.clearance_m, audit.clearances_per_edge_m.clone()),
            Clearances::OfPath | Clearances::None => (self.clearance_m, self.clearances_per_edge_m.clone()),
        };
        let goal = audit.goal.map(|nearest| {
            // If several grasps match at the end, the path ends at any of them.
            let stated =
                self.grasp.and_then(|grasp| cranny_path::arrival_at(problem, grasp, self.reach().last()?));
            stated.unwrap_or(nearest)
        });
        Ok(Self {
            format: self.format.clone(),
            scenario: task.scenario.clone(),
            task_name: task.task.as_ref().map(|task| task.name.clone()),
            task: self.own_task(task).map_or_else(|| self.task.clone(), |task| task.stages.clone()),
            robot: task.robot.as_ref().map(|file| file.display().to_string()),
            geometry: task.geometry.map(|geometry| geometry.name().to_owned()),
            grasps: task.grasps.text(),
            planner: self.planner.clone(),
            settings: self.settings.clone(),
            criterion: problem.criterion(),
            score: self.score,
            goal_threshold: problem.goal_threshold(),
            seed: self.seed,
            version: self.version.clone(),
            outcome: if audit.valid { Outcome::Solved } else { self.outcome },
            margins: task.margins,
            budget: self.budget,
            joint_names: problem.robot().joint_names().to_vec(),
            grasp: goal.map(|goal| goal.grasp),
            translation_error_m: goal.map(|goal| goal.translation_error_m),
            rotation_error_rad: goal.map(|goal| goal.rotation_error_rad),
            own_grasp: audit.own_grasp,
            picks: PlanPick::all_of(audit),
            clearance_m,
            not_checked: audit.not_checked.clone(),
            path_length: path_length(&self.waypoints),
            least_length: None,
            segments: self.measured_segments((along, problem), &clearances_per_edge_m),
            clearances_per_edge_m,
            waypoints: self.waypoints.clone(),
            timing,
            statistics: self.statistics,
            shortening: self.shortening,
            optimisation: self.optimisation.clone(),
            failures: self.failures.clone(),
            goal_faults: self.goal_faults.clone(),
            no_grasp: self.no_grasp.clone(),
            refused: self.refused.clone(),
            min_score: self.min_score,
            below_min_score: self.below_min_score,
            robustness: None,
            tilt: None,
            tool: Vec::new(),
            hold_demanded: self.hold_demanded,
            tries: self.tries.clone(),
            hold: None,
        })
    }

    /// Returns the segments with their measured clearances, and the object and payload of the hand while it is closed.
    fn measured_segments(
        &self,
        (along, problem): (Option<&StateSequence>, &Problem),
        clearances_per_edge_m: &[Option<f64>],
    ) -> Vec<Segment> {
        let limits_torque = self.timing.as_ref().is_some_and(|timing| timing.torque_up.is_some());
        let mut segments = self.segments.clone();
        give_clearances(&mut segments, clearances_per_edge_m);
        for (segment, state) in segments.iter_mut().zip(along.into_iter().flat_map(|along| &along.states)) {
            if let Some((carrier, grip)) = state.held() {
                segment.attached = Some(carrier.object().to_owned());
                segment.opening_m = Some(grip.opening_m);
                segment.uneven_m = Some(grip.uneven_m);
            }
            let is_counted = segment.payload.is_some() || limits_torque;
            segment.payload = if is_counted { state.payload(problem) } else { None };
        }
        segments
    }
}

/// Returns all values of a plan except its way points, which the audit checks itself.
fn figures(plan: &PlanFile) -> Value {
    let segments = plan.segments.iter().map(|segment| Segment { waypoints: Vec::new(), ..segment.clone() });
    let without = PlanFile { waypoints: Vec::new(), segments: segments.collect(), ..plan.clone() };
    serde_json::to_value(without).unwrap_or_default()
}

/// Returns the key of the file on a path through objects and lists.
fn first_key(key: &str) -> &str {
    key.split(['.', '[']).next().unwrap_or_default()
}

/// Returns true if a value states anything: `null` and an empty list do not.
fn is_stated(value: &Value) -> bool {
    !value.is_null() && value.as_array().is_none_or(|list| !list.is_empty())
}
