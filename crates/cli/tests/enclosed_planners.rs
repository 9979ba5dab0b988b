//! Views, limits and shortages of planners in the enclosure of a trial.

use std::os::unix::net::UnixListener;
use std::path::Path;
use std::process::Command as Process;

use assert_cmd::Command;
use cranny_bench::{StoredTrial, TrialOutcome};

use crate::sabotaging_planners::{all_gave_up, campaign, campaign_with, detail, enclosed, enclosed_with};

/// Runs a command in a shell after this line.
fn limit(command: &mut Command, line: &str) {
    let program = command.get_program().to_owned();
    let words: Vec<_> = command.get_args().map(ToOwned::to_owned).collect();
    let folder = command.get_current_dir().expect("a folder").to_owned();
    // The limits of plain shells lack the number of processes.
    *command = Command::new("bash");
    command.current_dir(folder).args(["-c", &format!("{line}; exec \"$0\" \"$@\"")]).arg(program).args(words);
}

fn all_are_out_of_memory(trials: Option<Vec<StoredTrial>>) {
    for trial in trials.unwrap_or_default() {
        assert_eq!(trial.record.outcome, TrialOutcome::OutOfMemory, "{}", detail(&trial));
    }
}

#[test]
fn a_trial_sees_no_files_of_other_trials_campaigns_or_results() {
    let other = tempfile::Builder::new().prefix("cranny-bench-").tempdir().expect("a temporary folder");
    std::fs::write(other.path().join("note"), "an answer").expect("written");
    let text = "
import fcntl, glob
own = os.getcwd()
root = os.path.abspath('../../../..')
open('mine', 'w').write(str(os.getpid()))
begin = time.monotonic()
while time.monotonic() < begin + 1:
    others = [p for p in glob.glob(root + '/*/*/scratch/*') if p != own]
    if others:
        end(f'files of {others}')
    time.sleep(0.02)
if notes := glob.glob(os.path.dirname(root) + '/cranny-bench-*/note'):
    end(f'notes {notes}')
# Its inputs are there.
if not open(sys.argv[1]).read():
    end('no grasps')
results = os.path.join(os.path.dirname(os.path.abspath(__file__)), 'results.db')
for file in (results, results + '-wal', results + '-shm'):
    if os.path.getsize(file):
        end(f'{file} can be read')
    try:
        fcntl.lockf(open(file), fcntl.LOCK_SH | fcntl.LOCK_NB, 1, 120)
        os.pread(os.open(file, os.O_RDONLY), 1, 0) and end('read')
    except OSError:
        pass
os._exit(0)
";
    all_gave_up(enclosed(text, &["--runs", "2", "--workers", "2"]));
}

#[test]
fn a_folder_that_is_deep_or_closed_does_not_outlive_its_trial() {
    // Deeper than the number of open files of the campaign.
    let text = "
found = [name for name in os.listdir('..') if name != os.path.basename(os.getcwd())]
if found:
    end(f'found {found}')
os.makedirs('a/b')
os.chmod('a/b', 0o555)
os.chmod('a', 0o555)
for level in range(600):
    os.mkdir('d')
    os.chdir('d')
os._exit(0)
";
    for sandbox in ["off", "auto"] {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let more = ["--runs", "2", "--sandbox", sandbox];
        let (output, trials) =
            campaign_with(folder.path(), &[("nest", text)], &more, |command| limit(command, "ulimit -n 256"));
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        all_gave_up(Some(trials));
    }
}

#[test]
fn no_socket_of_the_machine_can_be_reached_by_its_path() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("a server");
    let _server = UnixListener::bind(&path).expect("a socket");
    let text = format!(
        "
for path in ({:?},):
    try:
        client = socket.socket(socket.AF_UNIX)
        client.connect(path)
        end('a server outside')
    except OSError:
        pass
os._exit(0)
",
        path.display().to_string()
    );
    all_gave_up(enclosed(&text, &["--runs", "1"]));
}

#[test]
fn a_trial_has_one_share_of_the_processors_and_delays_nobody() {
    let text = "
session = os.getsid(0)
if os.fork() == 0:
    # A daemon continues without a session of its own.
    os.setsid()
    os._exit(0 if os.getsid(0) == session else 1)
if os.wait()[1]:
    end('a session of its own')
if resource.getrlimit(resource.RLIMIT_NICE) != (0, 0):
    end('a priority')
import ctypes, fcntl
attributes = (ctypes.c_uint32 * 12)(48)
if libc.syscall(314, 0, attributes, 0) == 0:
    end('scheduling attributes')
try:
    fcntl.fcntl(open(__file__), 1024, fcntl.F_WRLCK)
    end('a lease')
except OSError:
    pass
for family in (38, 40):
    try:
        socket.socket(family, socket.SOCK_SEQPACKET if family == 38 else socket.SOCK_STREAM)
        end(f'a socket of family {family}')
    except OSError:
        pass
if libc.syscall(425, 8, (ctypes.c_uint8 * 120)()) >= 0:
    end('a ring of calls')
# x32: the calls of another interface, here `keyctl`.
if libc.syscall(0x40000000 + 250, 0, -4, 0) != -1 or ctypes.get_errno() != 38:
    end('a call of another interface')
socket.socketpair()
os._exit(0)
";
    all_gave_up(enclosed(text, &["--runs", "1"]));
}

#[test]
fn memory_that_no_process_owns_is_counted_or_refused() {
    let limit = ["--runs", "1", "--memory-limit", "200", "--time-limit", "5"];
    let semaphores = "
import ctypes
if libc.semget(0, 32000, 0o1600) >= 0:
    end('2 MiB of semaphores')
queues = [libc.msgget(0, 0o1600) for _ in range(100)]
if queues[-1] >= 0:
    end('100 queues of messages')
os._exit(0)
";
    all_gave_up(enclosed(semaphores, &limit));
    let deleted = "
file = os.open('deleted', os.O_CREAT | os.O_RDWR)
os.unlink('deleted')
for _ in range(160):
    os.write(file, bytes(1 << 20))
held = bytearray(b'1') * (60 << 20)
time.sleep(20)
";
    for trial in enclosed(deleted, &limit).unwrap_or_default() {
        assert_eq!(trial.record.outcome, TrialOutcome::OutOfMemory, "{}", detail(&trial));
        assert!(
            detail(&trial).contains("of these 167 MB in files of its scratch folder"),
            "{}",
            detail(&trial)
        );
    }
    let page_tables = "
libc.mmap.restype = ctypes.c_void_p
size = 1 << 38
begin = libc.mmap(None, ctypes.c_size_t(size), 1, 0x4022, -1, ctypes.c_long(0))
libc.madvise(ctypes.c_void_p(begin), ctypes.c_size_t(size), 15)
# The zero page, which does not count, in one table of 4 KiB each.
for offset in range(0, size, 1 << 21):
    ctypes.c_char.from_address(begin + offset).value
time.sleep(20)
";
    all_are_out_of_memory(enclosed(page_tables, &limit));
    let buffers = "
for _ in range(3):
    os.fork()
held = []
for _ in range(1000):
    held.append(socket.socketpair())
time.sleep(20)
";
    all_are_out_of_memory(enclosed(buffers, &limit));
    let large_buffers = "
pairs = [socket.socketpair() for _ in range(100)]
held = 0
for one, other in pairs:
    one.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 1 << 30)
    one.setblocking(False)
    try:
        while True:
            held += one.send(bytes(1 << 16))
    except BlockingIOError:
        pass
if held > 50 << 20:
    end(f'{held} bytes in buffers')
os._exit(0)
";
    all_gave_up(enclosed(large_buffers, &limit));
}

/// Pages that a process releases stay in shared memory, but belong to no process.
#[test]
fn shared_memory_without_a_name_is_refused() {
    let text = "
import mmap
try:
    mmap.mmap(-1, 4096)
    end('memory without a file')
except PermissionError:
    pass
try:
    open('/dev/zero', 'r+b')
    end('memory of a device')
except PermissionError:
    pass
# Memory of its own, and memory of a file, as far as the limit permits.
mmap.mmap(-1, 4096, flags=mmap.MAP_PRIVATE)[:] = bytes(4096)
file = open('file', 'w+b')
file.truncate(1 << 20)
mmap.mmap(file.fileno(), 1 << 20)[:] = bytes(1 << 20)
os._exit(0)
";
    all_gave_up(enclosed(text, &["--runs", "1"]));
}

#[test]
fn sockets_that_are_sent_between_processes_count_and_copies_of_files_do_not() {
    let limit = ["--runs", "1", "--memory-limit", "200", "--time-limit", "5"];
    let in_flight = "
import array
carriers = []
for number in range(900):
    if number % 100 == 0:
        one, other = socket.socketpair()
        carriers.append((one, other))
    pair = socket.socketpair()
    rights = array.array('i', [own.fileno() for own in pair])
    one.sendmsg([b'x'], [(socket.SOL_SOCKET, socket.SCM_RIGHTS, rights)])
time.sleep(20)
";
    all_are_out_of_memory(enclosed(in_flight, &limit));
    let copies = "
held = [os.dup(0) for _ in range(3000)]
time.sleep(1)
os._exit(0)
";
    all_gave_up(enclosed(copies, &limit));
}

#[test]
fn a_trial_leaves_no_notes_with_files_that_it_may_only_read() {
    let text = "
import fcntl, mmap, struct
for command in (1036, 1038):
    try:
        fcntl.fcntl(open(__file__), command, struct.pack('Q', 3))
        end('a hint')
    except OSError:
        pass
memory = mmap.mmap(-1, 4096, flags=mmap.MAP_PRIVATE)
begin = ctypes.addressof(ctypes.c_char.from_buffer(memory))
if libc.mincore(ctypes.c_void_p(begin), ctypes.c_size_t(4096), ctypes.create_string_buffer(1)) == 0:
    end('pages in memory')
try:
    os.preadv(os.open(__file__, os.O_RDONLY), [bytearray(8)], 0, os.RWF_NOWAIT)
    end('pages of a file')
except OSError as fault:
    if fault.errno != 1:
        end(f'error {fault.errno}')
# This advice has no effect, and is no error.
os.posix_fadvise(os.open(__file__, os.O_RDONLY), 0, 0, os.POSIX_FADV_DONTNEED)
os._exit(0)
";
    all_gave_up(enclosed(text, &["--runs", "1"]));
}

#[test]
fn files_in_the_scratch_folder_count_without_a_sandbox_too() {
    let text = "
for number in range(300):
    open(str(number), 'wb').write(bytes(1 << 20))
time.sleep(20)
";
    let folder = tempfile::tempdir().expect("a temporary folder");
    let more = ["--runs", "1", "--memory-limit", "200", "--sandbox", "off"];
    let (_, trials) = campaign(folder.path(), &[("writer", text)], &more);
    assert_eq!(trials[0].record.outcome, TrialOutcome::OutOfMemory, "{}", detail(&trials[0]));
    assert!(detail(&trials[0]).contains("in files of its scratch folder"), "{}", detail(&trials[0]));
}

#[test]
fn a_planner_writes_its_files_wherever_the_temporary_folder_is() {
    let text = "
for folder in (os.getcwd(), os.environ['TMPDIR'], os.path.dirname(sys.argv[1])):
    try:
        open(os.path.join(folder, 'file'), 'w').write('x')
    except OSError as reason:
        if folder != os.path.dirname(sys.argv[1]):
            end(f'{folder}: {reason}')
if not open(sys.argv[1]).read():
    end('no grasps')
os._exit(0)
";
    let real = tempfile::tempdir().expect("a temporary folder");
    let link = real.path().join("link");
    std::os::unix::fs::symlink(real.path(), &link).expect("a link");
    let memory = Path::new("/dev/shm");
    let in_memory = memory.is_dir().then(|| tempfile::tempdir_in(memory).expect("a folder in memory"));
    let in_memory = in_memory.iter().map(|folder| folder.path().to_owned());
    for temporary in in_memory.chain([link]) {
        let change = |command: &mut Command| {
            let _ = command.env("TMPDIR", &temporary);
        };
        all_gave_up(enclosed_with(text, &["--runs", "1"], change));
    }
}

#[test]
fn low_limits_of_the_user_keep_the_sandbox() {
    let works = enclosed("os._exit(0)", &["--runs", "1"]).is_some();
    let text = "
if resource.getrlimit(resource.RLIMIT_NPROC)[1] > 3000:
    end('more processes than before')
os._exit(0)
";
    let trials = enclosed_with(text, &["--runs", "1"], |command| limit(command, "ulimit -u 3000"));
    assert_eq!(trials.is_some(), works);
    all_gave_up(trials);
}

#[test]
fn a_long_standard_error_ends_no_planner() {
    let text = "
for _ in range(40):
    os.write(2, b'progress' * 8192 + b'\\n')
end('the last line')
";
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (_, trials) = campaign(folder.path(), &[("talker", text)], &["--runs", "1"]);
    assert_eq!(detail(&trials[0]), "ended with exit code 3: the last line");
}

#[test]
fn a_weaker_sandbox_is_noted_and_its_rows_are_named_by_the_report() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    // Programs of the machine, apart from those that make namespaces.
    let programs = folder.path().join("bin");
    std::fs::create_dir(&programs).expect("created");
    let python = Process::new("python3").args(["-c", "import sys; print(sys.executable)"]).output();
    let python = String::from_utf8_lossy(&python.expect("python3").stdout).trim().to_owned();
    std::os::unix::fs::symlink(python, programs.join("python3")).expect("a link");
    let run = |more: &[&str]| {
        let change = |command: &mut Command| {
            let _ = command.env("PATH", &programs);
        };
        let (output, trials) = campaign_with(folder.path(), &[("weak", "os._exit(0)")], more, change);
        assert_eq!(trials.len(), 1);
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    let note = run(&["--runs", "1"]);
    assert_eq!(note.matches("note: this machine has no namespaces").count(), 1, "{note}");
    assert!(note.contains("leave notes for its next trial"), "{note}");
    let report = Command::cargo_bin("cranny")
        .expect("the program")
        .current_dir(folder.path())
        .args(["bench", "report", "results.db", "--json"])
        .output()
        .expect("it runs");
    let report = String::from_utf8_lossy(&report.stdout).into_owned();
    assert!(report.contains("1 of 1 rows are of external programs that ran without namespaces"), "{report}");
}

/// The campaign waits for ten seconds past the time limit of a trial, which must not begin before the program does.
#[test]
fn a_slow_preparation_of_the_enclosure_makes_no_planner_hung() {
    if std::env::var_os("CRANNY_LONG").is_none() {
        return;
    }
    let programs = tempfile::tempdir().expect("a temporary folder");
    let slow = programs.path().join("setpriv");
    let path = std::env::var("PATH").expect("a search path");
    let found = std::env::split_paths(&path).map(|folder| folder.join("setpriv")).find(|path| path.is_file());
    let Some(found) = found else { return };
    let script = format!("#!/bin/sh\nsleep 11\nexec {} \"$@\"\n", found.display());
    std::fs::write(&slow, script).expect("written");
    let mode = std::os::unix::fs::PermissionsExt::from_mode(0o755);
    std::fs::set_permissions(&slow, mode).expect("a mode");
    let path = format!("{}:{path}", programs.path().display());
    let change = |command: &mut Command| {
        let _ = command.env("PATH", &path);
    };
    let trials = enclosed_with("os._exit(0)", &["--runs", "1", "--time-limit", "0.5"], change);
    for trial in trials.iter().flatten() {
        assert!(trial.record.statistics.planning_time_s < 0.5);
    }
    all_gave_up(trials);
}
