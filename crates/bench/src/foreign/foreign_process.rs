use std::io::{Read, Write};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

use cranny_file::system;

use crate::foreign::process_group::{self, Family, Leash};
use crate::foreign::sandbox::Walls;

/// What the program of others may take.
#[derive(Clone, Copy, Debug)]
pub struct Limits<'a> {
    /// Wall-clock time after which it is ended.
    pub time: Duration,
    /// Memory of it and all that it starts, in bytes.
    pub memory_bytes: u64,
    /// The folder in which it may write, and what keeps it from writing elsewhere.
    pub scratch: &'a Path,
    pub walls: Walls,
}

/// How a program ended.
#[derive(Debug)]
pub enum Ending {
    /// By itself, with what it printed, and the end of its complaints.
    Exited { status: ExitStatus, output: Vec<u8>, complaint: String },
    /// It ran past its time and was ended.
    Hung,
    /// It took more memory than it was given and was ended; how much it had, in bytes.
    OutOfMemory(u64),
    /// It printed more than [`MOST_OUTPUT_BYTES`].
    Flood,
}

/// No path is as long.
pub const MOST_OUTPUT_BYTES: u64 = 64 << 20;

/// How often memory is looked at: what can be filled between two looks is a few tens of megabytes.
pub const LOOK_EVERY: Duration = Duration::from_millis(20);

/// How a program ran.
#[derive(Debug)]
pub struct Ran {
    pub ending: Ending,
    /// Until its end and that of its output, whoever held that open, in seconds.
    pub elapsed_s: f64,
    /// The most that it and all that it started were seen to hold, in bytes; nothing where nobody tells.
    pub memory_bytes: Option<u64>,
}

/// Runs a program: `input` goes to its standard input.
///
/// # Errors
/// What the operating system says where it cannot be begun.
pub fn run(command: &mut Command, input: String, limits: Limits, leash: &Leash) -> std::io::Result<Ran> {
    system::lead_group(command).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let (mut child, begin) = spawn(command, limits)?;
    let id = child.id();
    leash.hold(Some(id));
    if let Some(mut stdin) = child.stdin.take() {
        // A program need not listen.
        thread::spawn(move || drop(stdin.write_all(input.as_bytes())));
    }
    let (sender, closed) = mpsc::channel();
    let output = child.stdout.take().map(|stdout| reader(stdout, MOST_OUTPUT_BYTES + 1, Some(sender)));
    let complaint = child.stderr.take().map(|stderr| reader(stderr, MOST_COMPLAINT_BYTES, None));
    let (ended, most_bytes) = watch(&mut child, begin, limits, &closed);
    let elapsed_s = begin.elapsed().as_secs_f64();
    // What it started and left behind, too: nobody reads on.
    system::kill_group(id);
    // Where there are no groups, it alone; that it is gone already is what is wanted.
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

/// Starts a program within its walls, which a thread puts around itself and hands on to what it starts; and when.
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

/// Of what a program says on standard error the first so many bytes are read; what it says on its end is seldom
/// behind more.
const MOST_COMPLAINT_BYTES: u64 = 1 << 20;

/// Reads at most so many bytes; `closed` hears when nothing more comes.
fn reader(
    stream: impl Read + Send + 'static,
    most: u64,
    closed: Option<mpsc::Sender<()>>,
) -> thread::JoinHandle<Vec<u8>> {
    thread::spawn(move || {
        let mut bytes = Vec::new();
        // What was read before a fault counts.
        let _ = stream.take(most).read_to_end(&mut bytes);
        if let Some(closed) = closed {
            let _ = closed.send(());
        }
        bytes
    })
}

/// What a program started may hold its output open for so long after its own end.
const AFTER_THE_END: Duration = Duration::from_millis(200);

/// Waits for the end of a program and of its output: how it had to be ended, nothing if it ended by itself, and the most
/// memory that was seen.
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
        // That it cannot be asked means that it is gone.
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
            // Between its last word and its end little time goes by.
            thread::sleep(Duration::from_micros(200));
        } else {
            let left = limits.time.saturating_sub(begin.elapsed());
            let after = gone.map_or(LOOK_EVERY, |gone| AFTER_THE_END.saturating_sub(gone.elapsed()));
            let heard = closed.recv_timeout(LOOK_EVERY.min(left).min(after));
            is_closed = !matches!(heard, Err(RecvTimeoutError::Timeout));
        }
    }
}
