use std::ffi::OsStr;
use std::io::{BufRead as _, BufReader, Read, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

use cranny_file::system;

use crate::WorkerProgram;
use crate::foreign::enclosure::{Enclosure, MOST_PROCESSES, READY, Start};
use crate::foreign::process_group::{self, Census, Family, Leash};
use crate::foreign::sandbox::Isolation;

/// Resource limits of an external program.
#[derive(Clone, Copy, Debug)]
pub struct Limits<'a> {
    /// Wall-clock time after which it is ended.
    pub time: Duration,
    /// Memory of the program and its descendants, in bytes.
    pub memory_bytes: u64,
    /// The only folder for its output, and the isolation that enforces this.
    pub scratch: &'a Path,
    pub isolation: Isolation,
    /// Program of the process that encloses it.
    pub worker: &'a WorkerProgram,
}

/// Ending of a program.
#[derive(Debug)]
pub enum Ending {
    /// It exited by itself; with its output and the last line of its standard error.
    Exited { status: ExitStatus, output: Vec<u8>, complaint: String },
    /// It exceeded its time limit and was ended.
    Hung,
    /// It exceeded its memory limit and was ended; with its memory, in bytes.
    OutOfMemory(u64),
    /// It had more than [`MOST_PROCESSES`] processes and was ended; with their number.
    Crowd(usize),
    /// It printed more than [`MOST_OUTPUT_BYTES`].
    Flood,
}

/// Maximum output; every path is shorter.
pub const MOST_OUTPUT_BYTES: u64 = 64 << 20;

/// Sampling interval of memory: within it a program can fill a few tens of megabytes.
pub const LOOK_EVERY: Duration = Duration::from_millis(20);

/// Result of running a program.
#[derive(Debug)]
pub struct Ran {
    pub ending: Ending,
    /// Time until the program has ended and the last process has closed its output, in seconds.
    pub elapsed_s: f64,
    /// Peak memory of the program and its descendants, in bytes; `None` if unknown.
    pub memory_bytes: Option<u64>,
}

/// Runs a program with `input` on its standard input, enclosed by a process of its own.
///
/// # Errors
/// Error of the operating system if the program cannot be started.
pub fn run(command: &Command, input: String, limits: Limits, leash: &Leash) -> std::io::Result<Ran> {
    let mut enclosing = limits.isolation.command(limits.worker)?;
    enclosing.current_dir(limits.scratch).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = enclosing.spawn()?;
    leash.attach(vec![child.id()]);
    let (sender, events) = mpsc::channel();
    let output = child.stdout.take().map(|stdout| output_reader(stdout, sender));
    let complaint = child.stderr.take().map(|stderr| thread::spawn(|| read(stderr, MOST_COMPLAINT_BYTES)));
    let started = start(&mut child, enclosure(command, limits), &events);
    // Within namespaces, the process that made them waits outside.
    let inner = if limits.isolation.namespaces { system::children(child.id()) } else { Vec::new() };
    let enclosing = [vec![child.id()], inner].concat();
    leash.attach(enclosing.clone());
    let begin = Instant::now();
    let mut most_bytes = 0;
    let ended = started.map(|stdin| {
        // A program need not read its input.
        thread::spawn(move || {
            let mut stdin = stdin;
            drop(stdin.write_all(input.as_bytes()));
        });
        watch(&mut child, (begin, limits), &enclosing, &events, &mut most_bytes)
    });
    let elapsed_s = begin.elapsed().as_secs_f64();
    // Processes that it left behind are ended too, because their output is no longer read.
    leash.end();
    // An error means that it has already ended.
    let _ = child.kill();
    leash.attach(Vec::new());
    let status = system::status_of_shell(child.wait()?);
    process_group::end_descendants();
    let join = |handle: Option<thread::JoinHandle<Vec<u8>>>| {
        handle.and_then(|handle| handle.join().ok()).unwrap_or_default()
    };
    let (output, complaint) = (join(output), join(complaint));
    let last_line = || {
        let complaint = String::from_utf8_lossy(&complaint);
        let last = complaint.lines().map(str::trim).rfind(|line| !line.is_empty());
        last.unwrap_or_default().to_owned()
    };
    let ending = match ended {
        Err(reason) if reason.is_empty() => return Err(std::io::Error::other(last_line())),
        Err(reason) => return Err(std::io::Error::other(reason)),
        Ok(Some(ending)) => ending,
        Ok(None) if output.len() as u64 > MOST_OUTPUT_BYTES => Ending::Flood,
        Ok(None) => Ending::Exited { status, output, complaint: last_line() },
    };
    Ok(Ran { ending, elapsed_s, memory_bytes: Some(most_bytes).filter(|bytes| *bytes > 0) })
}

/// Returns the request to enclose a command.
fn enclosure(command: &Command, limits: Limits) -> Enclosure {
    let text = |word: &OsStr| word.to_string_lossy().into_owned();
    let set = command.get_envs().filter_map(|(name, value)| Some((text(name), text(value?))));
    Enclosure {
        command: std::iter::once(command.get_program()).chain(command.get_args()).map(text).collect(),
        folder: limits.scratch.to_owned(),
        environment: set.collect(),
        isolation: limits.isolation,
        shared_memory_bytes: limits.memory_bytes,
    }
}

/// Time limit for preparing the enclosure of a program.
const PREPARATION: Duration = Duration::from_mins(1);

/// Requests an enclosure and waits until it is ready. Returns the standard input of the program, or the reason against it;
/// it is empty if the standard error has it.
fn start(
    child: &mut Child,
    enclosure: Enclosure,
    events: &mpsc::Receiver<Event>,
) -> Result<ChildStdin, String> {
    let mut stdin = child.stdin.take().ok_or("it has no standard input")?;
    let line = serde_json::to_string(&Start::Enclose(enclosure)).map_err(|reason| reason.to_string())?;
    // An error means that it has ended, which the missing answer shows.
    let _ = writeln!(stdin, "{line}").and_then(|()| stdin.flush());
    match events.recv_timeout(PREPARATION) {
        Ok(Event::FirstLine(line)) if line == READY => Ok(stdin),
        Ok(Event::FirstLine(line)) => Err(line),
        Ok(Event::Closed) | Err(RecvTimeoutError::Disconnected) => Err(String::new()),
        Err(RecvTimeoutError::Timeout) => Err("its sandbox is not ready after a minute".to_owned()),
    }
}

/// Maximum number of bytes read from standard error; the final message is usually among them.
const MOST_COMPLAINT_BYTES: u64 = 1 << 20;

/// Event of an enclosed program.
enum Event {
    /// First line of the output, printed by the process that encloses it.
    FirstLine(String),
    /// End of the output, or of the output that is read.
    Closed,
}

/// Reads the output of a program after its first line.
fn output_reader(stdout: ChildStdout, events: mpsc::Sender<Event>) -> thread::JoinHandle<Vec<u8>> {
    thread::spawn(move || {
        let mut stdout = BufReader::new(stdout);
        let mut first = Vec::new();
        // An error is the end of the output.
        let _ = (&mut stdout).take(MOST_COMPLAINT_BYTES).read_until(b'\n', &mut first);
        if !first.is_empty() {
            let line = String::from_utf8_lossy(&first).trim().to_owned();
            let _ = events.send(Event::FirstLine(line));
        }
        let bytes = read(stdout, MOST_OUTPUT_BYTES + 1);
        let _ = events.send(Event::Closed);
        bytes
    })
}

/// Reads at most `most` bytes; those before an error count.
fn read(stream: impl Read, most: u64) -> Vec<u8> {
    let mut bytes = Vec::new();
    let _ = stream.take(most).read_to_end(&mut bytes);
    bytes
}

/// Waits for the end of a program and of its output. Returns the ending if it was forced, otherwise `None`; updates the peak
/// memory.
fn watch(
    child: &mut Child,
    (begin, limits): (Instant, Limits),
    enclosing: &[u32],
    events: &mpsc::Receiver<Event>,
    most_bytes: &mut u64,
) -> Option<Ending> {
    let mut family = Family::of_program(enclosing);
    let mut is_closed = false;
    loop {
        // An error means that the program has ended. Its children had their time to print.
        if !matches!(child.try_wait(), Ok(None)) {
            return None;
        }
        if begin.elapsed() >= limits.time {
            return Some(Ending::Hung);
        }
        let Census { processes, bytes } = family.count();
        *most_bytes = bytes.max(*most_bytes);
        if bytes > limits.memory_bytes {
            return Some(Ending::OutOfMemory(bytes));
        }
        if processes > MOST_PROCESSES {
            return Some(Ending::Crowd(processes));
        }
        if is_closed {
            // A program usually ends shortly after closing its output.
            thread::sleep(Duration::from_micros(200));
        } else {
            let left = limits.time.saturating_sub(begin.elapsed());
            is_closed = !matches!(events.recv_timeout(LOOK_EVERY.min(left)), Err(RecvTimeoutError::Timeout));
        }
    }
}
