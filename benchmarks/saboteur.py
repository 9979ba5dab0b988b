"""Twenty planners that cheat or sabotage, for a campaign beside an honest one (`sabotage.py`).

`saboteur.py NAME` speaks the exec protocol. None of them plans.
"""

from __future__ import annotations

import contextlib
import ctypes
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
    }
    actions[name]()


NAMES = (
    "priority processors scheduler limits stop kill burn threads chain bomb shared-memory memory files server notes "
    "flood caches claim long-path far-path"
).split()

if __name__ == "__main__":
    misbehave(sys.argv[1])
