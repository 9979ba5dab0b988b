use std::io::{Read, Write};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

use crate::process_group::{self, Family, Leash};

/// What the program of others may take.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Wall-clock time after which it is ended.
    pub time: Duration,
    /// Memory of it and all that it starts, in bytes.
    pub memory_bytes: u64,
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

/// Runs a program: `input` goes to its standard input. How it ended, and how many seconds that took from its
/// beginning.
///
/// # Errors
/// What the operating system says where it cannot be begun.
pub fn run(
    command: &mut Command,
    input: String,
    limits: Limits,
    leash: &Leash,
) -> std::io::Result<(Ending, f64)> {
    let begin = Instant::now();
    process_group::lead(command).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn()?;
    let id = child.id();
    leash.hold(Some(id));
    if let Some(mut stdin) = child.stdin.take() {
        // A program need not listen.
        thread::spawn(move || drop(stdin.write_all(input.as_bytes())));
    }
    let (sender, closed) = mpsc::channel();
    let output = child.stdout.take().map(|stdout| reader(stdout, MOST_OUTPUT_BYTES + 1, Some(sender)));
    let complaint = child.stderr.take().map(|stderr| reader(stderr, MOST_COMPLAINT_BYTES, None));
    let ended = watch(&mut child, begin, limits, &closed);
    // Until its end and that of its output, whoever holds that open.
    let elapsed_s = begin.elapsed().as_secs_f64();
    // What it started and left behind, too: nobody reads on.
    process_group::kill(id);
    leash.hold(None);
    let status = child.wait()?;
    process_group::end_descendants();
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
    Ok((ending, elapsed_s))
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

/// Waits for the end of a program and of its output; nothing if it ended by itself.
fn watch(child: &mut Child, begin: Instant, limits: Limits, closed: &mpsc::Receiver<()>) -> Option<Ending> {
    let mut family = Family::of_program(child.id());
    let (mut is_closed, mut gone): (bool, Option<Instant>) = (false, None);
    loop {
        // That it cannot be asked means that it is gone.
        if gone.is_none() && !matches!(child.try_wait(), Ok(None)) {
            gone = Some(Instant::now());
        }
        match gone {
            Some(gone) if is_closed || gone.elapsed() >= AFTER_THE_END => return None,
            _ => {}
        }
        if begin.elapsed() >= limits.time {
            return Some(Ending::Hung);
        }
        let bytes = family.look();
        if bytes > limits.memory_bytes {
            return Some(Ending::OutOfMemory(bytes));
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
