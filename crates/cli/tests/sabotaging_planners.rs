//! Planners that harm other trials or leave notes for their own next trial: the enclosure of a trial prevents both.

use std::path::Path;
use std::process::{Command as Process, Output, Stdio};

use assert_cmd::Command;
use cranny_bench::{Results, StoredTrial, TrialOutcome};

/// Start of each planner: calls of the C library, and an end with a message that becomes the detail of the trial.
const PRELUDE: &str = "\
import ctypes, os, resource, signal, socket, sys, threading, time
libc = ctypes.CDLL(None, use_errno=True)
def end(message):
    print(message, file=sys.stderr, flush=True)
    os._exit(3)
";

/// Runs planners in Python, by name, in one campaign in 031 and returns its output and trials.
pub fn campaign(folder: &Path, planners: &[(&str, &str)], more: &[&str]) -> (Output, Vec<StoredTrial>) {
    campaign_with(folder, planners, more, |_| ())
}

/// Runs a campaign as [`campaign`], after a change of its command.
pub fn campaign_with(
    folder: &Path,
    planners: &[(&str, &str)],
    more: &[&str],
    change: impl Fn(&mut Command),
) -> (Output, Vec<StoredTrial>) {
    let mut words: Vec<String> =
        ["bench", "run", "-o", "results.db", "--scenarios", "031"].map(str::to_owned).into();
    for (name, text) in planners {
        std::fs::write(folder.join(format!("{name}.py")), format!("{PRELUDE}{text}")).expect("written");
        words.extend(["--planner".to_owned(), format!("{name}=exec:python3 {name}.py {{grasps}}")]);
    }
    let mut command = Command::cargo_bin("cranny").expect("the program");
    command.current_dir(folder).args(words).args(more);
    change(&mut command);
    let output = command.output().expect("it runs");
    let file = folder.join("results.db");
    let trials = if file.exists() {
        Results::open(&file).expect("results").trials().expect("trials")
    } else {
        Vec::new()
    };
    (output, trials)
}

/// Runs one planner in the full sandbox; `None`, with a note, if the kernel lacks a mechanism.
pub fn enclosed(text: &str, more: &[&str]) -> Option<Vec<StoredTrial>> {
    enclosed_with(text, more, |_| ())
}

/// Runs one planner as [`enclosed`], after a change of the command of the campaign.
pub fn enclosed_with(text: &str, more: &[&str], change: impl Fn(&mut Command)) -> Option<Vec<StoredTrial>> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let more = [&["--sandbox", "require"], more].concat();
    let (output, trials) = campaign_with(folder.path(), &[("cheat", text)], &more, change);
    let error = String::from_utf8_lossy(&output.stderr);
    if error.contains("this machine has no") {
        eprintln!("SKIPPED, enclosure of planners: {error}");
        return None;
    }
    assert_eq!(output.status.code(), Some(0), "{error}");
    Some(trials)
}

pub fn detail(trial: &StoredTrial) -> &str {
    trial.record.detail.as_deref().unwrap_or_default()
}

pub fn all_gave_up(trials: Option<Vec<StoredTrial>>) {
    for trial in trials.unwrap_or_default() {
        assert_eq!(trial.record.outcome, TrialOutcome::GaveUp, "{}", detail(&trial));
    }
}

/// Returns the number of running processes with `mark` among their arguments.
fn running(mark: &str) -> usize {
    let listing = Process::new("ps").args(["-eo", "stat,args"]).output().expect("ps");
    let text = String::from_utf8_lossy(&listing.stdout).into_owned();
    text.lines().filter(|line| !line.starts_with('Z') && line.contains(mark)).count()
}

/// Returns a duration in seconds that no other process sleeps for.
fn unusual_duration(offset: u64) -> String {
    (3_000_000 + 10 * u64::from(std::process::id()) + offset).to_string()
}

#[test]
fn no_process_outside_of_a_trial_can_be_slowed_limited_or_stopped() {
    all_gave_up(enclosed(
        "
own = (1, os.getpid())
def harmed(action):
    harmed = []
    for process in (p for p in range(2, 40000) if p not in own):
        try:
            action(process)
            harmed.append(process)
        except OSError:
            pass
    return harmed
actions = {
    'priority': lambda p: os.setpriority(os.PRIO_PROCESS, p, 19),
    'group': lambda p: os.setpriority(os.PRIO_PGRP, p, 19),
    'processors': lambda p: os.sched_setaffinity(p, {0}),
    'class': lambda p: os.sched_setscheduler(p, os.SCHED_IDLE, os.sched_param(0)),
    'limits': lambda p: resource.prlimit(p, resource.RLIMIT_CPU, (1, 1)),
    'signal': lambda p: os.kill(p, signal.SIGCONT),
}
for name, action in actions.items():
    if found := harmed(action):
        end(f'{name} of {found}')
try:
    os.kill(1, signal.SIGKILL)
except OSError:
    pass
os._exit(0)
",
        &["--runs", "1"],
    ));
}

#[test]
fn no_note_outlives_a_trial() {
    let text = "
path = sys.argv[1].encode()
found = []
def note(name, is_there, leave):
    try:
        if is_there():
            found.append(name)
        leave()
    except OSError:
        pass
key = 0x0cafe
create = 0o1000
note('shared memory', lambda: libc.shmget(key, 0, 0) >= 0, lambda: libc.shmget(key, 4096, create | 0o600))
note('queue', lambda: libc.msgget(key, 0) >= 0, lambda: libc.msgget(key, create | 0o600))
note('semaphore', lambda: libc.semget(key, 0, 0) >= 0, lambda: libc.semget(key, 1, create | 0o600))
def mailbox(flags):
    return libc.mq_open(b'/cranny-note', flags, 0o600, None)
note('mailbox', lambda: mailbox(os.O_RDONLY) >= 0, lambda: mailbox(os.O_RDWR | os.O_CREAT))
def keys(*words):
    return libc.syscall(*words)
for ring in (-3, -4, -5):
    search = lambda: keys(250, 10, ring, b'user', b'cranny', 0) >= 0
    note(f'key {ring}', search, lambda: keys(248, b'user', b'cranny', b'memo', 4, ring))
note('attribute', lambda: b'user.memo' in [os.fsencode(n) for n in os.listxattr(path)],
     lambda: os.setxattr(path, b'user.memo', b'1'))
folder = os.path.dirname(path)
note('mode', lambda: os.stat(path).st_mode & 0o111, lambda: os.chmod(path, 0o755))
note('mode of a folder', lambda: os.stat(folder).st_mode & 0o2, lambda: os.chmod(folder, 0o777))
note('time', lambda: os.stat(folder).st_mtime < 10, lambda: os.utime(folder, (5, 5)))
note('access', lambda: os.stat(path).st_atime < 10, lambda: os.utime(path, (5, os.stat(path).st_mtime)))
for place in ('/dev/shm', '/tmp', '/var/tmp', os.path.expanduser('~'), '/run', '/dev/mqueue'):
    memo = os.path.join(place, f'cranny-memo-{os.getuid()}')
    note(place, lambda: os.path.exists(memo), lambda: open(memo, 'w').close())
if found:
    end(f'found {found}')
os._exit(0)
";
    all_gave_up(enclosed(text, &["--runs", "3"]));
}

#[test]
fn a_daemon_whose_first_thread_has_ended_is_counted_and_ended() {
    let sleep = unusual_duration(1);
    let text = format!(
        "
if os.fork() == 0:
    os.setsid()
    if os.fork():
        os._exit(0)
    def hold():
        held = bytearray(b'1') * (400 << 20)
        time.sleep(60)
    threading.Thread(target=hold).start()
    libc.pthread_exit(None)
os.execvp('sleep', ['sleep', '{sleep}'])
"
    );
    for sandbox in ["off", "auto"] {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let more = ["--runs", "1", "--memory-limit", "200", "--sandbox", sandbox];
        let (output, trials) = campaign(folder.path(), &[("daemon", &text)], &more);
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        assert_eq!(trials[0].record.outcome, TrialOutcome::OutOfMemory, "{}", detail(&trials[0]));
        assert_eq!((running(&sleep), running("daemon.py")), (0, 0));
    }
}

#[test]
fn a_crowd_of_processes_is_limited_named_and_ended() {
    let sleep = unusual_duration(2);
    let crowd = format!(
        "
for index in range(700):
    if os.fork() == 0:
        os.execvp('sleep', ['sleep', '{sleep}'])
time.sleep(60)
"
    );
    // Each process is replaced by its child faster than a list of processes is read.
    let chain = format!(
        "
for index in range(20):
    if os.fork() == 0:
        os.setsid()
        begin = time.monotonic()
        while time.monotonic() < begin + 30:
            if os.fork():
                os._exit(0)
        os.execvp('sleep', ['sleep', '{sleep}'])
os._exit(0)
"
    );
    for sandbox in ["off", "auto"] {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let planners = [("crowd", crowd.as_str()), ("chain", chain.as_str())];
        let (output, trials) = campaign(folder.path(), &planners, &["--runs", "1", "--sandbox", sandbox]);
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        for trial in &trials {
            if trial.record.trial.planner == "crowd" {
                assert_eq!(trial.record.outcome, TrialOutcome::Crashed, "{}", detail(trial));
                assert!(detail(trial).contains("at most 256 are allowed"), "{}", detail(trial));
            } else {
                assert_eq!(trial.record.outcome, TrialOutcome::GaveUp, "{}", detail(trial));
            }
        }
        let left = [running(&sleep), running("crowd.py"), running("chain.py")];
        assert_eq!(left, [0; 3], "--sandbox {sandbox}");
    }
}

#[test]
fn a_program_has_no_terminal_and_types_into_none() {
    let text = "
try:
    terminal = os.open('/dev/tty', os.O_RDWR)
    end('a terminal')
except OSError:
    pass
import fcntl
# Without a sandbox, root may type into any terminal.
is_root_outside = os.getuid() == 0 and sys.argv[1] == 'off'
for number in range(0 if is_root_outside else 20):
    try:
        terminal = os.open(f'/dev/pts/{number}', os.O_RDWR)
        fcntl.ioctl(terminal, 0x5412, b'x')
        end(f'typed into {number}')
    except OSError:
        pass
os._exit(0)
";
    for sandbox in ["off", "auto"] {
        let folder = tempfile::tempdir().expect("a temporary folder");
        std::fs::write(folder.path().join("typist.py"), format!("{PRELUDE}{text}")).expect("written");
        // The campaign has a terminal.
        let program = assert_cmd::cargo::cargo_bin("cranny").display().to_string();
        let spawn = "import pty, sys; sys.exit(pty.spawn(sys.argv[1:]) >> 8)";
        let words = ["bench", "run", "-o", "results.db", "--scenarios", "031", "--runs", "1"];
        let planner =
            ["--planner", &format!("typist=exec:python3 typist.py {sandbox}"), "--sandbox", sandbox];
        let mut command = Process::new("python3");
        command.current_dir(folder.path()).args(["-c", spawn, program.as_str()]).args(words).args(planner);
        let output = command.stdin(Stdio::null()).output().expect("it runs");
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stdout));
        let trials =
            Results::open(&folder.path().join("results.db")).expect("results").trials().expect("trials");
        assert_eq!(trials[0].record.outcome, TrialOutcome::GaveUp, "{}", detail(&trials[0]));
    }
}

#[test]
fn no_memory_network_or_namespace_is_beyond_the_limits() {
    let listener = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
    let port = listener.local_addr().expect("an address").port();
    all_gave_up(enclosed(
        &format!(
            "
try:
    os.memfd_create('hidden')
    end('a file in memory')
except OSError:
    pass
if libc.shmget(0, 64 << 20, 0o1600) >= 0:
    end('64 MiB of shared memory')
if libc.unshare(0x10000000) == 0:
    end('a user namespace')
try:
    socket.create_connection(('127.0.0.1', {port}), timeout=1)
    end('a service of the machine')
except OSError:
    pass
os._exit(0)
"
        ),
        &["--runs", "1"],
    ));
}
