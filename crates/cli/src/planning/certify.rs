use std::path::{Path, PathBuf};
use std::time::Instant;

use cranny_certify::{CertifyError, certificate, impossibility, impossible_grasps};
use cranny_record::{PlanFile, read_waypoints};
use cranny_task::{Mode, Problem, Segment, Stage};
use serde::Serialize;

use crate::Answer;
use crate::arguments::{CertifyArguments, Output};
use crate::failure::Failure;
use crate::file_kind::FileKind;
use crate::output_file;
use crate::planning::plan_task::{PlanTask, check_plan, read_plan};
use crate::planning::task::Demand;
use crate::text;

/// Claims of a certificate.
const MOTION: &str = "a motion";
const NO_MOTION: &str = "no motion";

pub fn run(arguments: &CertifyArguments, output: Output) -> Result<Answer, Failure> {
    let (file, id) = (arguments.plan.as_deref(), &arguments.task.id);
    let plan = file.map(read_plan).transpose()?.flatten();
    let demand = plan.as_ref().map(Demand::of_plan).unwrap_or_default();
    let PlanTask { source, problem, .. } = PlanTask::open(&arguments.task, &[], demand, output)?;
    let name = Path::new(id).file_stem().unwrap_or_default().to_string_lossy();
    let to = arguments.output.clone().unwrap_or_else(|| PathBuf::from(format!("{name}.cert")));
    output_file::check(&to, FileKind::Certificate, output)?;
    let dof = problem.robot().dof();
    let written = match (file, &plan) {
        (Some(file), Some(plan)) => {
            check_plan(file, plan, problem.robot(), &source.scenario, "certified for")?;
            if !plan.waypoints.is_empty() {
                plan.check_path(file, dof)?;
            }
            write(&source.scenario, &problem, plan, &to, output)?
        }
        (Some(file), None) => {
            let segments = [Segment::empty(0, Mode::REACH, read_waypoints(file, dof)?)];
            let text = || certificate(&source.scenario, &problem, &[Stage::pick()], &segments);
            Written::of(MOTION, text, &to, output)?
        }
        (None, _) if arguments.impossible_grasps => {
            let mut grasps = Vec::new();
            let text = || {
                let (text, indices) = impossible_grasps(&source.scenario, &problem)?;
                grasps = indices;
                Ok(text)
            };
            let written = Written::of(NO_MOTION, text, &to, output)?;
            Written { grasps: Some(grasps), ..written }
        }
        (None, _) => Written::of(NO_MOTION, || impossibility(&source.scenario, &problem), &to, output)?,
    };
    text::answer(&written, || written.line(), output)?;
    Ok(if written.is_certified() { Answer::Done } else { Answer::No })
}

/// Writes the certificate of a plan, if there is one: of its motion, or that none exists if it has none.
pub fn write(
    scenario: &str,
    problem: &Problem,
    plan: &PlanFile,
    to: &Path,
    output: Output,
) -> Result<Written, Failure> {
    if plan.waypoints.is_empty() {
        return Written::of(NO_MOTION, || impossibility(scenario, problem), to, output);
    }
    let own = [Stage::pick()];
    let stages = if plan.task.is_empty() { &own[..] } else { &plan.task };
    Written::of(MOTION, || certificate(scenario, problem, stages, &plan.segments), to, output)
}

/// Certificate that was written, or the reason why there is none; printed by `--json` with these keys.
#[derive(Clone, Debug, Serialize)]
pub struct Written {
    claim: &'static str,
    /// Indices of the grasps that it is about, if it is about some.
    #[serde(skip_serializing_if = "Option::is_none")]
    grasps: Option<Vec<usize>>,
    certificate: Option<PathBuf>,
    bytes: usize,
    time_s: f64,
    refused: Option<String>,
}

impl Written {
    fn of(
        claim: &'static str,
        text: impl FnOnce() -> Result<String, CertifyError>,
        to: &Path,
        output: Output,
    ) -> Result<Self, Failure> {
        let begin = Instant::now();
        let text = text();
        let time_s = begin.elapsed().as_secs_f64();
        let none = Self { claim, grasps: None, certificate: None, bytes: 0, time_s, refused: None };
        match text {
            Ok(text) => {
                output_file::write(to, FileKind::Certificate, text.as_bytes(), output)?;
                Ok(Self { certificate: Some(to.to_owned()), bytes: text.len(), ..none })
            }
            Err(reason) => Ok(Self { refused: Some(reason.to_string()), ..none }),
        }
    }

    pub fn is_certified(&self) -> bool {
        self.certificate.is_some()
    }

    /// Returns the line that is printed.
    pub fn line(&self) -> String {
        match (&self.certificate, &self.refused) {
            (Some(file), _) => {
                let kilobytes = self.bytes.div_ceil(1000);
                let milliseconds = 1e3 * self.time_s;
                let (claim, file) = (self.claim, file.display());
                let to = match self.grasps.as_deref() {
                    None => String::new(),
                    Some([_]) => " to 1 grasp".to_owned(),
                    Some(grasps) => format!(" to {} grasps", grasps.len()),
                };
                format!("certificate of {claim}{to}: {file}, {kilobytes} kB, in {milliseconds:.1} ms\n")
            }
            (None, reason) => {
                format!("no certificate of {}: {}\n", self.claim, reason.as_deref().unwrap_or_default())
            }
        }
    }
}
