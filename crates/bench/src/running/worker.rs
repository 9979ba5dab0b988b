use std::io::{BufRead, Write};
use std::sync::mpsc;
use std::thread;

use cranny_file::system::{self, PeakMemory};
use cranny_plan::Registry;

use crate::foreign::enclosure::Start;
use crate::foreign::process_group::{self, Leash};
use crate::running::opened_scenario::OpenedScenarios;
use crate::running::worker_message::{Message, Request};
use crate::{BenchError, running::trial_run};

/// Serves the trials of a campaign with the planners of a registry, one line of `input` each. At the end of `input` it
/// kills any running external program and exits the process: a campaign that has ended needs no answer. If the first line
/// requests it, the process encloses an external program instead, and exits with its exit code.
///
/// # Errors
/// [`BenchError::Message`] for a line that is no request, or if the answers cannot be written.
pub fn serve(
    registry: &Registry,
    input: impl BufRead + Send + 'static,
    output: &mut impl Write,
) -> Result<(), BenchError> {
    let mut lines = input.lines();
    let first = lines.next().and_then(Result::ok).unwrap_or_default();
    if let Ok(Start::Enclose(enclosure)) = serde_json::from_str(&first) {
        std::process::exit(enclosure.run(output));
    }
    system::begin_session();
    let mut peak = PeakMemory::new();
    system::close_to_others();
    process_group::adopt();
    let leash = Leash::default();
    let (sender, requests) = mpsc::channel();
    let last_will = leash.clone();
    let reader = thread::Builder::new().spawn(move || {
        let first = std::iter::once(first).filter(|line| !line.is_empty());
        for line in first.chain(lines.map_while(Result::ok)) {
            if sender.send(line).is_err() {
                return;
            }
        }
        last_will.kill();
        std::process::exit(0);
    });
    reader.map_err(|reason| BenchError::message(&reason))?;
    let mut scenarios = OpenedScenarios::default();
    let mut tell = |message: &Message| -> Result<(), BenchError> {
        let mut line = serde_json::to_string(message).map_err(|reason| BenchError::message(&reason))?;
        line.push('\n');
        output
            .write_all(line.as_bytes())
            .and_then(|()| output.flush())
            .map_err(|reason| BenchError::message(&reason))
    };
    for line in requests {
        let request: Request = serde_json::from_str(&line).map_err(|reason| BenchError::message(&reason))?;
        let message = match trial_run::run(registry, &request, (&mut scenarios, &mut peak), &leash, &mut tell)
        {
            Ok((record, path)) => Message::Answered(Box::new(record), path),
            Err(fault) if fault.is_shortage() => Message::NotStarted(fault.to_string()),
            Err(fault) => Message::Refused(fault.to_string()),
        };
        tell(&message)?;
    }
    Ok(())
}
