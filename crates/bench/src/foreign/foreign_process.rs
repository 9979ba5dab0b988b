use std::io::{Read, Write};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

use cranny_file::system;

use crate::foreign::process_group::{self, Family, Leash};
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
    pub walls: Isolation,
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

/// Runs a program with `input` on its standard input.
///
/// # Errors
/// Error of the operating system if the program cannot be started.
pub fn run(command: &mut Command, input: String, limits: Limits, leash: &Leash) -> std::io::Result<Ran> {
    system::lead_group(command).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let (mut child, begin) = spawn(command, limits)?;
    let id = child.id();
    leash.hold(Some(id));
    if let Some(mut stdin) = child.stdin.take() {
        // A program need not read its input.
        thread::spawn(move || drop(stdin.write_all(input.as_bytes())));
    }
    let (sender, closed) = mpsc::channel();
    let output = child.stdout.take().map(|stdout| reader(stdout, MOST_OUTPUT_BYTES + 1, Some(sender)));
    let complaint = child.stderr.take().map(|stderr| reader(stderr, MOST_COMPLAINT_BYTES, None));
    let (ended, most_bytes) = watch(&mut child, begin, limits, &closed);
    let elapsed_s = begin.elapsed().as_secs_f64();
    // Processes that it left behind are ended too, because their output is no longer read.
    system::kill_group(id);
    // Without process groups only the program is killed. An error means that it has already ended.
    let _ = child.kill();
    leash.hold(None);
    let status = child.wait()?;
    process_group::end_descendants();
    limits.walls.clear_shared_memory();
    let join = |handle: Option<thread::JoinHandle<Vec<u8>>>| {
        handle.and_then(|handle| handle.join().ok()).unwrap_or_default()
    };
    let (output, complaint) = (join(output), join(complaint));
    let ending = match ended {
        Some(ending) => ending,
        None if output.len() as u64 > MOST_OUTPUT_BYTES => Ending::Flood,
        None => {
            let complaint = String::from_utf8_lossy(&complaint);
            let last = complaint.lines().map(str::trim).rfind(|line| !line.is_empty());
            Ending::Exited { status, output, complaint: last.unwrap_or_default().to_owned() }
        }
    };
    Ok(Ran { ending, elapsed_s, memory_bytes: Some(most_bytes).filter(|bytes| *bytes > 0) })
}

/// Starts an isolated program and returns it with its start time. A thread isolates itself, and its children inherit this.
fn spawn(command: &mut Command, limits: Limits) -> std::io::Result<(Child, Instant)> {
    let within = || {
        limits.walls.close(limits.scratch)?;
        let begin = Instant::now();
        Ok((command.spawn()?, begin))
    };
    thread::scope(|scope| {
        let panicked = |_| Err(std::io::Error::other("no thread for it"));
        scope.spawn(within).join().unwrap_or_else(panicked)
    })
}

/// Maximum number of bytes read from standard error; the final message is usually among them.
const MOST_COMPLAINT_BYTES: u64 = 1 << 20;

/// Reads at most `most` bytes; `closed` receives a message at the end of the stream.
fn reader(
    stream: impl Read + Send + 'static,
    most: u64,
    closed: Option<mpsc::Sender<()>>,
) -> thread::JoinHandle<Vec<u8>> {
    thread::spawn(move || {
        let mut bytes = Vec::new();
        // Bytes read before an error are kept.
        let _ = stream.take(most).read_to_end(&mut bytes);
        if let Some(closed) = closed {
            let _ = closed.send(());
        }
        bytes
    })
}

/// Time for which children of a program may keep its output open after its own end.
const AFTER_THE_END: Duration = Duration::from_millis(200);

/// Waits for the end of a program and of its output. Returns the ending, `None` unless it was forced, and the peak memory.
fn watch(
    child: &mut Child,
    begin: Instant,
    limits: Limits,
    closed: &mpsc::Receiver<()>,
) -> (Option<Ending>, u64) {
    let mut most_bytes = 0;
    let mut family = Family::of_program(child.id());
    let (mut is_closed, mut gone): (bool, Option<Instant>) = (false, None);
    loop {
        // An error means that the program has ended.
        if gone.is_none() && !matches!(child.try_wait(), Ok(None)) {
            gone = Some(Instant::now());
        }
        match gone {
            Some(gone) if is_closed || gone.elapsed() >= AFTER_THE_END => return (None, most_bytes),
            _ => {}
        }
        if begin.elapsed() >= limits.time {
            return (Some(Ending::Hung), most_bytes);
        }
        let bytes = family.look(limits.walls);
        most_bytes = most_bytes.max(bytes);
        if bytes > limits.memory_bytes {
            return (Some(Ending::OutOfMemory(bytes)), most_bytes);
        }
        if is_closed {
            // A program usually ends shortly after closing its output.
            thread::sleep(Duration::from_micros(200));
        } else {
            let left = limits.time.saturating_sub(begin.elapsed());
            let after = gone.map_or(LOOK_EVERY, |gone| AFTER_THE_END.saturating_sub(gone.elapsed()));
            let heard = closed.recv_timeout(LOOK_EVERY.min(left).min(after));
            is_closed = !matches!(heard, Err(RecvTimeoutError::Timeout));
        }
    }
}
