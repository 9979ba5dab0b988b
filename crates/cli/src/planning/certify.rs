use std::path::{Path, PathBuf};
use std::time::Instant;

use cranny_certify::{CertifyError, certificate};
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

pub fn run(arguments: &CertifyArguments, output: Output) -> Result<Answer, Failure> {
    let (file, id) = (&arguments.plan, &arguments.task.id);
    let plan = read_plan(file)?;
    let demand = plan.as_ref().map(Demand::of_plan).unwrap_or_default();
    let PlanTask { source, problem, .. } = PlanTask::open(&arguments.task, &[], demand, output)?;
    let name = Path::new(id).file_stem().unwrap_or_default().to_string_lossy();
    let to = arguments.output.clone().unwrap_or_else(|| PathBuf::from(format!("{name}.cert")));
    output_file::check(&to, FileKind::Certificate, output)?;
    let written = if let Some(plan) = &plan {
        check_plan(file, plan, problem.robot(), &source.scenario, "certified for")?;
        plan.check_path(file, problem.robot().dof())?;
        write(&source.scenario, &problem, plan, &to, output)?
    } else {
        let path = read_waypoints(file, problem.robot().dof())?;
        let segments = [Segment::empty(0, Mode::REACH, path)];
        Written::of(
            certificate(&source.scenario, &problem, &[Stage::pick()], &segments),
            &to,
            Instant::now(),
            output,
        )?
    };
    text::answer(&written, || written.line(), output)?;
    Ok(if written.is_certified() { Answer::Done } else { Answer::No })
}

/// Writes the certificate of a plan, if there is one.
pub fn write(
    scenario: &str,
    problem: &Problem,
    plan: &PlanFile,
    to: &Path,
    output: Output,
) -> Result<Written, Failure> {
    let begin = Instant::now();
    let own = [Stage::pick()];
    let stages = if plan.task.is_empty() { &own[..] } else { &plan.task };
    let text = certificate(scenario, problem, stages, &plan.segments);
    Written::of(text, to, begin, output)
}

/// Certificate that was written, or the reason why there is none; printed by `--json` with these keys.
#[derive(Clone, Debug, Serialize)]
pub struct Written {
    certificate: Option<PathBuf>,
    bytes: usize,
    time_s: f64,
    refused: Option<String>,
}

impl Written {
    fn of(
        text: Result<String, CertifyError>,
        to: &Path,
        begin: Instant,
        output: Output,
    ) -> Result<Self, Failure> {
        let time_s = begin.elapsed().as_secs_f64();
        let none = Self { certificate: None, bytes: 0, time_s, refused: None };
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
                format!("certificate: {}, {kilobytes} kB, in {milliseconds:.1} ms\n", file.display())
            }
            (None, reason) => format!("no certificate: {}\n", reason.as_deref().unwrap_or_default()),
        }
    }
}
