use std::io::{BufRead as _, BufReader, Write as _};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use cranny_file::system;
use cranny_plan::Statistics;

use crate::foreign::foreign_process::LOOK_EVERY;
use crate::foreign::process_group::Family;
use crate::running::worker_message::{Message, Request};
use crate::running::worker_program::WorkerProgram;
use crate::store::exports::ExportFolder;
use crate::{BenchError, MEGABYTE, Trial, TrialOutcome, TrialRecord};

/// Process that serves trials one after the other, and may end during any of them.
pub struct WorkerProcess {
    child: Child,
    /// Descendants observed until now.
    family: Family,
    requests: Option<ChildStdin>,
    lines: Receiver<String>,
    complaint: Arc<Mutex<String>>,
    /// Thread that reads standard error until the worker ends.
    listener: Option<JoinHandle<()>>,
    /// Folder for the scenarios that it exports for external planners, used by no other worker.
    exports: ExportFolder,
}

/// Result of a request.
pub enum Served {
    /// The worker answered and remains available; with the record of the trial and the planner's path.
    Answered(TrialRecord, Vec<Vec<f64>>),
    /// The question is invalid; the worker remains available.
    Refused(String),
    /// The trial cannot be started now; the worker remains available.
    NotStarted(String),
    /// The worker was lost with the trial.
    Lost(TrialRecord),
    /// The campaign was stopped; the worker has ended.
    Stopped,
}

/// Time limit for opening a scenario, writing its files and preparing the enclosure of an external program.
const PATIENCE: Duration = Duration::from_mins(5);

/// Time limit for judging a path. A path of the maximum length usually takes seconds.
const JUDGING: Duration = Duration::from_mins(2);

/// Time past the limit after which a search counts as hung. A built-in planner checks the clock every few iterations, and may
/// compute a hundred inverse kinematics solutions in between: seconds on a busy machine. An external program is ended earlier,
/// by the worker itself.
const GRACE: Duration = Duration::from_secs(10);

/// Time allowed to a worker for ending itself and its children.
const FAREWELL: Duration = Duration::from_millis(500);

/// Polling interval for the end of the worker.
const LOOK_OUT_EVERY: Duration = Duration::from_millis(5);

impl WorkerProcess {
    /// Starts a worker, with a new folder of its own within `exports`.
    pub fn start(worker: &WorkerProgram, exports: &Path) -> Result<Self, BenchError> {
        let fault = |reason: std::io::Error| BenchError::NotRunnable {
            program: worker.program.display().to_string(),
            reason,
        };
        let exports = ExportFolder::new_in(exports, "worker-").map_err(fault)?;
        let mut command = Command::new(&worker.program);
        command.args(&worker.arguments).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().map_err(fault)?;
        let (stdout, stderr) = (child.stdout.take(), child.stderr.take());
        let (sender, lines) = mpsc::channel();
        let (requests, family) = (child.stdin.take(), Family::of(child.id()));
        let complaint = Arc::new(Mutex::new(String::new()));
        // On an error below, dropping it ends the worker.
        let mut worker = Self { child, family, requests, lines, complaint, listener: None, exports };
        if let Some(stdout) = stdout {
            let read = move || {
                for line in BufReader::new(stdout).split(b'\n').map_while(Result::ok) {
                    if sender.send(String::from_utf8_lossy(&line).into_owned()).is_err() {
                        return;
                    }
                }
            };
            thread::Builder::new().spawn(read).map_err(fault)?;
        }
        if let Some(stderr) = stderr {
            let complaint = worker.complaint.clone();
            let listen = move || {
                // The most informative line is the first one of a panic, otherwise the last one.
                for line in BufReader::new(stderr).split(b'\n').map_while(Result::ok) {
                    let line = String::from_utf8_lossy(&line).trim().to_owned();
                    let mut kept = complaint.lock().unwrap_or_else(PoisonError::into_inner);
                    if !line.is_empty() && !line.starts_with("note:") {
                        *kept = if kept.contains("panicked at") { format!("{kept} {line}") } else { line };
                    }
                }
            };
            worker.listener = Some(thread::Builder::new().spawn(listen).map_err(fault)?);
        }
        Ok(worker)
    }

    /// Requests a trial and waits for the answer, at most as long as the trial may take. Time and memory of the judge do not
    /// count for the planner: if the judge exceeds its limits or crashes, the trial is undecided.
    pub fn serve(&mut self, request: &Request, is_stopped: &dyn Fn() -> bool) -> Served {
        let asked = serde_json::to_string(request).map_err(std::io::Error::other).and_then(|line| {
            let requests = self.requests.as_mut().ok_or(std::io::ErrorKind::BrokenPipe)?;
            requests.write_all(line.as_bytes())?;
            requests.write_all(b"\n")?;
            requests.flush()
        });
        let trial = &request.question.trial;
        if asked.is_err() {
            return self.lost(trial, Duration::ZERO);
        }
        let limit = Duration::try_from_secs_f64(trial.time_limit_s).unwrap_or(Duration::MAX);
        let mut begin = Instant::now();
        let mut deadline = begin.checked_add(PATIENCE);
        // The memory that the worker uses before the search does not count for the planner.
        let mut memory_bytes = None;
        // Time of the search, once it has ended.
        let mut searched_s = None;
        loop {
            match self.lines.recv_timeout(LOOK_EVERY) {
                Ok(line) => match serde_json::from_str(&line) {
                    Ok(Message::Opened) => {
                        (begin, searched_s) = (Instant::now(), None);
                        deadline = begin.checked_add(limit.saturating_add(GRACE));
                        let held = self.resident_bytes();
                        memory_bytes = held.map(|held| held + request.memory_limit_bytes);
                    }
                    Ok(Message::Planned) => {
                        searched_s = Some(begin.elapsed().as_secs_f64());
                        deadline = Instant::now().checked_add(JUDGING);
                    }
                    Ok(Message::Answered(record, path)) => return Served::Answered(*record, path),
                    Ok(Message::Refused(reason)) => return Served::Refused(reason),
                    Ok(Message::NotStarted(reason)) => return Served::NotStarted(reason),
                    Err(reason) => {
                        let detail = format!("the worker's answer is not valid: {reason}");
                        return self.ended(trial, TrialOutcome::Garbled, detail, begin.elapsed());
                    }
                },
                Err(RecvTimeoutError::Disconnected) => {
                    return undecided(self.lost(trial, begin.elapsed()), searched_s);
                }
                Err(RecvTimeoutError::Timeout) => {
                    if is_stopped() {
                        self.end();
                        return Served::Stopped;
                    }
                    if deadline.is_some_and(|deadline| Instant::now() >= deadline) {
                        let detail = format!("ended after {:.1} s", begin.elapsed().as_secs_f64());
                        let ended = self.ended(trial, TrialOutcome::Hung, detail, begin.elapsed());
                        return undecided(ended, searched_s);
                    }
                    self.family.count();
                    let held = self.resident_bytes();
                    if let (Some(held), Some(most)) = (held, memory_bytes)
                        && held > most
                    {
                        let detail = format!("held {} MB", held / MEGABYTE);
                        let ended = self.ended(trial, TrialOutcome::OutOfMemory, detail, begin.elapsed());
                        return undecided(ended, searched_s);
                    }
                }
            }
        }
    }

    /// Ends the worker because of its behaviour; the trial gets that outcome.
    fn ended(&mut self, trial: &Trial, outcome: TrialOutcome, detail: String, time: Duration) -> Served {
        let record = lost(trial, outcome, detail, time);
        self.end();
        Served::Lost(record)
    }

    /// Returns the result of a trial whose worker ended by itself.
    fn lost(&mut self, trial: &Trial, time: Duration) -> Served {
        let status = self.end();
        // This ends the children of the worker in any process group.
        self.family.end();
        let outcome = match status {
            Some(status) if system::is_killed(status) => TrialOutcome::Killed,
            _ => TrialOutcome::Crashed,
        };
        let mut detail = status.map_or_else(|| "ended".to_owned(), system::ending);
        // The last lines may still be in transit, and children may keep the stream open.
        let gone = Instant::now();
        while self.listener.as_ref().is_some_and(|listener| !listener.is_finished())
            && gone.elapsed() < FAREWELL
        {
            thread::sleep(LOOK_OUT_EVERY);
        }
        let complaint = self.complaint.lock().unwrap_or_else(PoisonError::into_inner);
        if !complaint.is_empty() {
            detail = format!("{detail}: {complaint}");
        }
        Served::Lost(lost(trial, outcome, detail, time))
    }

    /// Ends the worker and its children, first by request, then by force. Returns its exit status if it ended by itself.
    fn end(&mut self) -> Option<std::process::ExitStatus> {
        self.requests = None;
        let begin = Instant::now();
        while begin.elapsed() < FAREWELL {
            if let Ok(Some(status)) = self.child.try_wait() {
                return Some(status);
            }
            thread::sleep(LOOK_OUT_EVERY);
        }
        // The worker adopts orphans as long as it runs.
        self.family.end();
        system::kill_group(self.child.id());
        // Without process groups only the worker is killed. An error means that it has already ended.
        let _ = self.child.kill();
        let _ = self.child.wait();
        self.family.end();
        None
    }

    /// Returns the memory of the worker alone, in bytes.
    fn resident_bytes(&self) -> Option<u64> {
        system::memory(self.child.id()).map(|memory| memory.resident_bytes)
    }

    /// Returns the folder that it exports scenarios to.
    pub fn exports(&self) -> &Path {
        self.exports.path()
    }

    /// Returns true if the worker can serve requests.
    pub fn is_alive(&mut self) -> bool {
        matches!(self.child.try_wait(), Ok(None))
    }
}

impl Drop for WorkerProcess {
    fn drop(&mut self) {
        self.end();
    }
}

fn lost(trial: &Trial, outcome: TrialOutcome, detail: String, time: Duration) -> TrialRecord {
    let statistics = Statistics { planning_time_s: time.as_secs_f64(), ..Statistics::default() };
    TrialRecord::without_path(trial, outcome, Some(detail), statistics)
}

/// Returns the result of a trial whose worker was lost: undecided, with the time of its search alone, if the search had ended.
/// A worker that was killed then stays so: its judge is not at fault either.
fn undecided(served: Served, searched_s: Option<f64>) -> Served {
    let (mut record, searched_s) = match (served, searched_s) {
        (Served::Lost(record), Some(searched_s)) => (record, searched_s),
        (served, _) => return served,
    };
    record.statistics.planning_time_s = searched_s;
    if record.outcome != TrialOutcome::Killed {
        record.outcome = TrialOutcome::Undecided;
        record.detail = record.detail.map(|detail| format!("the judge gave no verdict: {detail}"));
    }
    Served::Lost(record)
}
