use std::ffi::OsStr;
use std::io::{self, BufRead as _, BufReader, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStderr, ChildStdin, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

use cranny_file::system;

use crate::WorkerProgram;
use crate::foreign::enclosure::{Enclosure, MOST_PROCESSES, Prepared, Start};
use crate::foreign::process_group::{self, Census, Family, Leash};
use crate::foreign::sandbox::Isolation;
use crate::foreign::written_files::WrittenFiles;

/// Resource limits of an external program.
#[derive(Clone, Copy, Debug)]
pub struct Limits<'a> {
    /// Wall-clock time after which it is ended.
    pub time: Duration,
    /// Memory of the program and its descendants, with the files that they write, in bytes.
    pub memory_bytes: u64,
    /// The only folder for its output, and the isolation that enforces this.
    pub scratch: &'a Path,
    pub isolation: Isolation,
    /// Files and folders that it does not see, and folders within that it can read.
    pub hidden: &'a [PathBuf],
    pub kept: &'a [PathBuf],
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
    /// It exceeded its memory limit and was ended; with its memory, and the files in its scratch folder, in bytes.
    OutOfMemory { bytes: u64, scratch_bytes: u64 },
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
    /// Files that it left.
    pub files: WrittenFiles,
}

/// Runs a program with `input` on its standard input, enclosed by a process of its own, and calls `begins` before it starts.
///
/// # Errors
/// Error of the operating system if the program cannot be started.
pub fn run(
    command: &Command,
    input: String,
    limits: Limits,
    leash: &Leash,
    begins: impl FnOnce(),
) -> io::Result<Ran> {
    let mut enclosing = limits.isolation.command(limits.worker)?;
    enclosing.current_dir(limits.scratch).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = enclosing.spawn()?;
    leash.attach(vec![child.id()]);
    let (sender, events) = mpsc::channel();
    let output = child.stdout.take().map(|stdout| output_reader(stdout, sender)).transpose();
    let complaint = child.stderr.take().map(complaint_reader).transpose();
    let course = begin(&mut child, (command, input), limits, (leash, &events), begins);
    // Processes that it left behind are ended too, because their output is no longer read.
    leash.end();
    // An error means that it has already ended.
    let _ = child.kill();
    leash.attach(Vec::new());
    let status = system::status_of_shell(child.wait()?);
    process_group::end_descendants();
    let (output, complaint) =
        (output?.map(read_by).unwrap_or_default(), complaint?.map(read_by).unwrap_or_default());
    let complaint = String::from_utf8_lossy(&complaint);
    let last = complaint.lines().map(str::trim).rfind(|line| !line.is_empty()).unwrap_or_default();
    let Course { ended, elapsed_s, most_bytes, files } = course.map_err(|reason| {
        // It worked when the campaign began.
        let is_silent = reason.kind() == ErrorKind::UnexpectedEof;
        if is_silent { io::Error::new(ErrorKind::WouldBlock, last.to_owned()) } else { reason }
    })?;
    let ending = match ended {
        Some(ending) => ending,
        None if output.len() as u64 > MOST_OUTPUT_BYTES => Ending::Flood,
        None => Ending::Exited { status, output, complaint: last.to_owned() },
    };
    Ok(Ran { ending, elapsed_s, memory_bytes: Some(most_bytes).filter(|bytes| *bytes > 0), files })
}

/// Course of a program.
struct Course {
    /// Ending if it was forced.
    ended: Option<Ending>,
    elapsed_s: f64,
    most_bytes: u64,
    files: WrittenFiles,
}

/// Starts a program in its enclosure, and waits for its end.
fn begin(
    child: &mut Child,
    (command, input): (&Command, String),
    limits: Limits,
    (leash, events): (&Leash, &mpsc::Receiver<Event>),
    begins: impl FnOnce(),
) -> io::Result<Course> {
    let stdin = prepare(child, enclosure(command, limits), events)?;
    let mut enclosing = vec![child.id()];
    let mut inner = None;
    if limits.isolation.namespaces {
        // The process that made the namespaces waits outside.
        inner = system::children(child.id()).first().copied();
        enclosing.push(inner.ok_or(ErrorKind::UnexpectedEof)?);
    }
    leash.attach(enclosing.clone());
    let mut files = WrittenFiles::of(limits.scratch, inner)?;
    let start = writer(stdin, input)?;
    begins();
    let begin = Instant::now();
    // An error means that the program has ended.
    let _ = start.send(());
    let mut most_bytes = 0;
    let ended = watch(child, (begin, limits), (&enclosing, &mut files), events, &mut most_bytes);
    Ok(Course { ended, elapsed_s: begin.elapsed().as_secs_f64(), most_bytes, files })
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
        hidden: limits.hidden.to_owned(),
        kept: limits.kept.to_owned(),
        memory_bytes: limits.memory_bytes,
    }
}

/// Time limit for preparing the enclosure of a program.
const PREPARATION: Duration = Duration::from_mins(1);

/// Requests an enclosure and waits until it is ready. Returns the standard input of the program.
///
/// # Errors
/// The reason against it; [`ErrorKind::UnexpectedEof`] if the standard error has it.
fn prepare(
    child: &mut Child,
    enclosure: Enclosure,
    events: &mpsc::Receiver<Event>,
) -> io::Result<ChildStdin> {
    let mut stdin = child.stdin.take().ok_or(ErrorKind::BrokenPipe)?;
    let line = serde_json::to_string(&Start::Enclose(enclosure))?;
    // An error means that it has ended, which the missing answer shows.
    let _ = writeln!(stdin, "{line}").and_then(|()| stdin.flush());
    match events.recv_timeout(PREPARATION) {
        Ok(Event::FirstLine(line)) => match serde_json::from_str(&line) {
            Ok(Prepared::Ready) => Ok(stdin),
            Ok(Prepared::Short(reason)) => Err(io::Error::new(ErrorKind::WouldBlock, reason)),
            Ok(Prepared::Refused(reason)) => Err(io::Error::other(reason)),
            Err(_) => Err(io::Error::other(line)),
        },
        Ok(Event::Closed) | Err(RecvTimeoutError::Disconnected) => Err(ErrorKind::UnexpectedEof.into()),
        Err(RecvTimeoutError::Timeout) => {
            Err(io::Error::new(ErrorKind::TimedOut, "its sandbox is not ready after a minute"))
        }
    }
}

/// Creates the thread that writes the input of a program when it receives the signal. A program need not read its input.
fn writer(mut stdin: ChildStdin, input: String) -> io::Result<mpsc::Sender<()>> {
    let (start, started) = mpsc::channel();
    thread::Builder::new().spawn(move || {
        if started.recv().is_ok() {
            let _ = stdin.write_all(input.as_bytes());
        }
    })?;
    Ok(start)
}

/// Maximum length of the first line of output, and of the kept end of standard error, in bytes.
const MOST_LINE_BYTES: usize = 1 << 16;

/// Event of an enclosed program.
enum Event {
    /// First line of the output, printed by the process that encloses it.
    FirstLine(String),
    /// End of the output, or of the output that is read.
    Closed,
}

/// Reads the output of a program after its first line.
fn output_reader(
    stdout: ChildStdout,
    events: mpsc::Sender<Event>,
) -> io::Result<thread::JoinHandle<Vec<u8>>> {
    thread::Builder::new().spawn(move || {
        let mut stdout = BufReader::new(stdout);
        let mut first = Vec::new();
        // An error is the end of the output.
        let _ = (&mut stdout).take(MOST_LINE_BYTES as u64).read_until(b'\n', &mut first);
        if !first.is_empty() {
            let line = String::from_utf8_lossy(&first).trim().to_owned();
            let _ = events.send(Event::FirstLine(line));
        }
        let mut bytes = Vec::new();
        // The bytes before an error count.
        let _ = stdout.take(MOST_OUTPUT_BYTES + 1).read_to_end(&mut bytes);
        let _ = events.send(Event::Closed);
        bytes
    })
}

/// Reads standard error to its end, however long it is, and keeps the last bytes.
fn complaint_reader(mut stderr: ChildStderr) -> io::Result<thread::JoinHandle<Vec<u8>>> {
    thread::Builder::new().spawn(move || {
        let (mut kept, mut buffer) = (Vec::new(), vec![0; MOST_LINE_BYTES]);
        loop {
            match stderr.read(&mut buffer) {
                Ok(0) => return kept,
                Ok(length) => kept.extend_from_slice(&buffer[..length]),
                Err(reason) if reason.kind() == ErrorKind::Interrupted => {}
                Err(_) => return kept,
            }
            let surplus = kept.len().saturating_sub(MOST_LINE_BYTES);
            kept.drain(..surplus);
        }
    })
}

/// Returns the bytes that a thread has read; none if a process that could not be ended holds its pipe open.
fn read_by(reader: thread::JoinHandle<Vec<u8>>) -> Vec<u8> {
    let begin = Instant::now();
    while !reader.is_finished() && begin.elapsed() < CLOSING {
        thread::sleep(Duration::from_micros(200));
    }
    if reader.is_finished() { reader.join().unwrap_or_default() } else { Vec::new() }
}

/// Time limit for reading the rest of the output of a program that has ended.
const CLOSING: Duration = Duration::from_secs(5);

/// Waits for the end of a program and of its output. Returns the ending if it was forced, otherwise `None`; updates the peak
/// memory.
fn watch(
    child: &mut Child,
    (begin, limits): (Instant, Limits),
    (enclosing, files): (&[u32], &mut WrittenFiles),
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
        let Census { processes, bytes, shared_bytes } = family.count();
        let written = files.measure(limits.memory_bytes);
        let bytes = bytes.saturating_add(written.with_shared(shared_bytes));
        *most_bytes = bytes.max(*most_bytes);
        if bytes > limits.memory_bytes {
            return Some(Ending::OutOfMemory { bytes, scratch_bytes: written.scratch });
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
