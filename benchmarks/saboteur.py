"""Planners that cheat or sabotage, for a campaign beside an honest one (`sabotage.py`).

`saboteur.py NAME` speaks the exec protocol. None of them plans.
"""

from __future__ import annotations

import contextlib
import ctypes
import fcntl
import glob
import json
import mmap
import os
import resource
import signal
import socket
import sys
import threading
import time
from collections.abc import Callable

LIBC = ctypes.CDLL(None, use_errno=True)


def everywhere(action: Callable[[int], object]) -> None:
    """Applies an action to each process that it is allowed for, apart from this one."""
    for process in range(1, 40000):
        if process != os.getpid():
            with contextlib.suppress(OSError):
                action(process)


def burn(processes: int, threads: int) -> None:
    """Computes in many processes and threads until it is ended."""
    for _ in range(processes):
        if os.fork() == 0:
            break
    for _ in range(threads):
        threading.Thread(target=lambda: [None for _ in iter(int, 1)], daemon=True).start()
    while True:
        pass


def fork_chain() -> None:
    """Replaces itself by a child, again and again."""
    while os.fork() == 0:
        os.setsid()
    os._exit(0)


def fork_bomb() -> None:
    """Doubles the number of its processes, again and again."""
    while True:
        with contextlib.suppress(OSError):
            os.fork()


def memory(shared: bool) -> None:
    """Takes memory until it is ended, in `/dev/shm` or in a daemon whose first thread ends."""
    if shared:
        for index in range(1000):
            with open(f"/dev/shm/{index}", "wb") as file:
                file.write(bytes(16 << 20))
    held: list[bytes] = []

    def fill() -> None:
        while True:
            held.append(b"1" * (16 << 20))
            time.sleep(0.01)

    threading.Thread(target=fill).start()
    LIBC.pthread_exit(None)


def remove_files() -> None:
    """Deletes and changes all that it can write: its inputs, temporary folders, results."""
    for top in (os.path.dirname(sys.argv[2]), "/tmp", "/dev/shm", os.getcwd()):
        for folder, _, files in os.walk(top):
            for name in files:
                with contextlib.suppress(OSError):
                    os.chmod(os.path.join(folder, name), 0)
                with contextlib.suppress(OSError):
                    os.unlink(os.path.join(folder, name))


def answer(**keys: object) -> None:
    """Prints an answer."""
    json.dump(keys, sys.stdout)


def long_path(problem: dict) -> None:
    """Answers with very many way points."""
    answer(waypoints=[problem["start"]] * 150_000)


def far_path(problem: dict) -> None:
    """Answers with a way point that is a million radians away."""
    answer(waypoints=[problem["start"], [1e6] * len(problem["start"]), problem["start"]])


def listen() -> None:
    """Leaves a server for its next trial."""
    for family, address in ((socket.AF_INET, ("127.0.0.1", 45871)), (socket.AF_UNIX, "\0cranny")):
        with contextlib.suppress(OSError):
            server = socket.socket(family)
            server.bind(address)
            server.listen()
            if os.fork() == 0:
                os.setsid()
                time.sleep(1000)


def leave_notes() -> None:
    """Leaves keys, queues and shared memory for its next trial."""
    for index in range(1000):
        LIBC.shmget(index + 1, 1 << 20, 0o1600)
        LIBC.msgget(index + 1, 0o1600)
        LIBC.semget(index + 1, 100, 0o1600)
        LIBC.syscall(248, b"user", str(index).encode(), b"memo", 4, -4)


def flood() -> None:
    """Prints without end."""
    while True:
        os.write(1, bytes(1 << 20))


def disturb_caches() -> None:
    """Reads and writes much memory, within its limit."""
    block = mmap.mmap(-1, 64 << 20)
    while True:
        block[:] = bytes(len(block))


def sessions() -> None:
    """Computes in many sessions, each of which would have a share of the processors."""
    for _ in range(250):
        if os.fork() == 0:
            with contextlib.suppress(OSError):
                os.setsid()
            while True:
                pass
    time.sleep(1000)


def beside(ending: str) -> list[str]:
    """Returns the files with this ending that belong to the user: those of rivals, of the campaign and of earlier ones."""
    here = os.path.dirname(os.path.abspath(__file__))
    folders = {here, os.path.dirname(sys.argv[2]), *glob.glob("/tmp/*"), os.getcwd()}
    return [path for folder in sorted(folders) for path in glob.glob(f"{folder}/*{ending}")]


def lease() -> None:
    """Delays everyone who opens a file that rivals or the campaign may need."""
    signal.signal(signal.SIGIO, signal.SIG_IGN)
    held = []
    for ending in (".py", ".urdf", ".csv", ".db"):
        for path in beside(ending):
            with contextlib.suppress(OSError):
                held.append(os.open(path, os.O_RDONLY))
                fcntl.fcntl(held[-1], 1024, fcntl.F_WRLCK)
    time.sleep(1000)


def lock() -> None:
    """Locks the results of campaigns for reading, as a reader of the database does."""
    held = []
    for ending in (".db", ".db-shm", ".db-wal"):
        for path in beside(ending):
            with contextlib.suppress(OSError):
                held.append(os.open(path, os.O_RDONLY))
                fcntl.lockf(held[-1], fcntl.LOCK_SH | fcntl.LOCK_NB, 0, 0)
    time.sleep(1000)


def semaphores() -> None:
    """Takes memory of the kernel: 64 bytes for each semaphore, 16 KiB for each queue of messages."""
    message = ctypes.create_string_buffer(b"\1" * 8192)
    for _ in range(500):
        LIBC.semget(0, 32000, 0o1600)
        queue = LIBC.msgget(0, 0o1600)
        while LIBC.msgsnd(queue, message, 8000, 0o4000) == 0:
            pass
    time.sleep(1000)


def page_tables() -> None:
    """Takes memory of page tables, by reading one byte of each 2 MiB."""
    LIBC.mmap.restype = ctypes.c_void_p
    size = 1 << 40
    begin = LIBC.mmap(None, ctypes.c_size_t(size), 1, 0x4022, -1, ctypes.c_long(0))
    for offset in range(0, size, 1 << 21):
        ctypes.c_char.from_address(begin + offset).value  # noqa: B018


def buffers() -> None:
    """Takes memory of the buffers of sockets."""
    for _ in range(4):
        os.fork()
    held = []
    while True:
        with contextlib.suppress(OSError):
            held.append(socket.socketpair())
            held[-1][0].setblocking(False)
            while held[-1][0].send(bytes(1 << 16)):
                pass


def deleted_files() -> None:
    """Fills the disk, or the memory, with files that have no name."""
    held = []
    for index in range(1000):
        held.append(os.open(str(index), os.O_CREAT | os.O_RDWR))
        os.unlink(str(index))
        with contextlib.suppress(OSError):
            os.write(held[-1], bytes(16 << 20))


def nested_folders() -> None:
    """Leaves folders that are too deep for a path, and closed ones, for its next trial."""
    os.makedirs("closed/inner")
    os.chmod("closed/inner", 0o555)
    os.chmod("closed", 0)
    for _ in range(3000):
        os.mkdir("inner")
        os.chdir("inner")


def virtual_sockets() -> None:
    """Asks a server of another trial, or of the machine below a virtual one."""
    for address in ((0xFFFFFFFF, 45871), (1, 45871), (2, 45871)):
        with contextlib.suppress(OSError), socket.socket(40, socket.SOCK_STREAM) as own:
            own.settimeout(0.1)
            own.bind(address) if address[0] > 2 else own.connect(address)


def long_error() -> None:
    """Prints errors without end."""
    while True:
        os.write(2, bytes(1 << 20))


def misbehave(name: str) -> None:
    """Carries out the sabotage of that name."""
    if name in ("long-path", "far-path"):
        (long_path if name == "long-path" else far_path)(json.load(sys.stdin))
        return
    actions: dict[str, Callable[[], object]] = {
        "priority": lambda: everywhere(lambda p: os.setpriority(os.PRIO_PROCESS, p, 19)),
        "processors": lambda: everywhere(lambda p: os.sched_setaffinity(p, {0})),
        "scheduler": lambda: everywhere(lambda p: os.sched_setscheduler(p, os.SCHED_IDLE, os.sched_param(0))),
        "limits": lambda: everywhere(lambda p: resource.prlimit(p, resource.RLIMIT_CPU, (1, 1))),
        "stop": lambda: everywhere(lambda p: os.kill(p, signal.SIGSTOP)),
        "kill": lambda: everywhere(lambda p: os.kill(p, signal.SIGKILL)),
        "burn": lambda: burn(50, 0),
        "threads": lambda: burn(0, 200),
        "chain": fork_chain,
        "bomb": fork_bomb,
        "shared-memory": lambda: memory(shared=True),
        "memory": lambda: memory(shared=False),
        "files": remove_files,
        "server": listen,
        "notes": leave_notes,
        "flood": flood,
        "caches": disturb_caches,
        "claim": lambda: answer(outcome="budget-exhausted", statistics={"iterations": 10**9}),
        "sessions": sessions,
        "lease": lease,
        "lock": lock,
        "semaphores": semaphores,
        "page-tables": page_tables,
        "buffers": buffers,
        "deleted-files": deleted_files,
        "nested-folders": nested_folders,
        "virtual-sockets": virtual_sockets,
        "long-error": long_error,
    }
    actions[name]()


NAMES = (
    "priority processors scheduler limits stop kill burn threads chain bomb shared-memory memory files server notes "
    "flood caches claim long-path far-path sessions lease lock semaphores page-tables buffers deleted-files nested-folders "
    "virtual-sockets long-error"
).split()

if __name__ == "__main__":
    misbehave(sys.argv[1])
