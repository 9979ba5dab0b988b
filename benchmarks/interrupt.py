"""Interrupts each command that runs longer than a second at random moments, by Ctrl-C and by `kill -9`.

usage: interrupt.py CRANNY [MOMENTS [NAME…]]   the program; moments of each kind (10); commands (default: all)

After each interruption, the same command is run to its end. It must succeed, write the same files as without an interruption
where these depend on no time, know finished work of the interrupted run, and leave no hidden file or folder, in its folder or in
the temporary folder.
"""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

COMMANDS = {
    "plan": "plan 045 --optimise 2 -o p.plan.json",
    "plan --try-in-physics": "plan 011 --place outside --try-in-physics 3 -o p.plan.json",
    "scenario generate": "scenario generate --family shelf --seed 1 --count 40 -o set",
    "ik": "ik 045",
    "roadmap": "roadmap 021 -o roadmap.prm --nodes 4000",
    "grasps sample": "grasps sample 011 --count 20000 -o grasps.csv",
    "simulate grasps": "simulate grasps 011 --trials 2 -o simulated.csv",
    "simulate plan": "simulate plan 011 plan.plan.json",
    "bench run": "bench run -o r.db --scenarios 021,031,045 --planner reach --planner rrt-connect --runs 5 --time-limit 1",
    "bench report": "bench report results.db -o report.html",
    "bench merge": "bench merge results.db other.db -o merged.db",
    "simulate results": "simulate results results.db",
    "render picture": "render 021 plan.plan.json -o picture.png --size 4096x3072",
    "render film": "render 011 plan.plan.json -o film.gif",
    "render page": "render 021 -o page.html",
    "verify": "verify 011 plan.plan.json",
    "dataset generate": "dataset generate recipe.yaml -o set",
    "dataset check": "dataset check made",
    "sense": "sense 041 --default-cameras 8 --noise-seed 1 --clouds -o views",
    "sense --scenario": "sense 021 --default-cameras 4 --noise-seed 1 --scenario -o seen",
    "certify": "certify 011 plan.plan.json -o p.cert",
    "robot add": "robot add fr3/fr3.urdf -o arm",
}
"""Commands by name; files that they read are made first."""

TIMED = {"plan", "plan --try-in-physics", "ik", "bench run", "bench report", "bench merge", "simulate plan", "simulate results"}
"""Commands whose files contain measured times."""

RESUMED = {"bench run", "simulate grasps"}
"""Commands that report the finished work of an earlier run as `known`."""


def run(program: str, words: str, folder: Path, environment: dict[str, str], moment: float = 0.0, number: int = 0) -> subprocess.CompletedProcess[str]:
    """Runs a command; after `moment` seconds it gets the signal `number`, unless that is 0 or the command has ended."""
    process = subprocess.Popen(
        [program, *words.split()], cwd=folder, env=environment, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    if number:
        try:
            process.wait(moment)
        except subprocess.TimeoutExpired:
            process.send_signal(number)
    output, error = process.communicate(timeout=600)
    return subprocess.CompletedProcess(process.args, process.returncode, output, error)


def hidden(folder: Path, program_files: bool) -> list[str]:
    """Returns the hidden files below a folder, and all files in a temporary folder of the program."""
    paths = sorted(str(path.relative_to(folder)) for path in folder.rglob("*"))
    return paths if program_files else [path for path in paths if any(name.startswith(".") for name in path.split("/"))]


INPUTS = {"plan.plan.json", "results.db", "other.db"}
"""Files that are made anew before each run, with other measured times."""


def written(folder: Path) -> dict[str, bytes]:
    """Returns the files below a folder by name, without inputs."""
    files = (path for path in sorted(folder.rglob("*")) if path.is_file() and path.name not in INPUTS)
    return {str(path.relative_to(folder)): path.read_bytes() for path in files}


def main(program: str, moments: str = "10", *names: str) -> int:
    """Prints a line for each command and returns the number of faults."""
    program = str(Path(program).resolve())
    draw = random.Random(1)
    faults = 0
    for name, words in COMMANDS.items():
        if names and name not in names:
            continue
        problems: list[str] = []
        with tempfile.TemporaryDirectory() as top:
            folder, scratch = Path(top) / "work", Path(top) / "tmp"

            def fresh() -> dict[str, str]:
                subprocess.run(["rm", "-rf", str(folder), str(scratch)], check=True)
                folder.mkdir()
                scratch.mkdir()
                environment = {**os.environ, "TMPDIR": str(scratch)}
                if "plan.plan.json" in words:
                    source = words.split()[2 if words.startswith("simulate") else 1]
                    run(program, f"plan {source} -q -o plan.plan.json", folder, environment)
                if "results.db" in words:
                    campaign = "bench run -q --scenarios 021 --planner reach --runs 20 --time-limit 1 -o"
                    run(program, f"{campaign} results.db", folder, environment)
                    run(program, f"{campaign} other.db --first-seed 20", folder, environment)
                if words.startswith("dataset"):
                    (folder / "recipe.yaml").write_text("count: 1000\n")
                if words.startswith("dataset check"):
                    run(program, "dataset generate recipe.yaml -q -o made", folder, environment)
                if words.startswith("robot add"):
                    run(program, "robot export fr3 -o fr3", folder, environment)
                return environment

            environment = fresh()
            begin = time.monotonic()
            whole = run(program, words, folder, environment)
            duration = time.monotonic() - begin
            expected = written(folder)
            if whole.returncode not in (0, 1):
                problems.append(f"exit code {whole.returncode}: {whole.stderr.strip()[-200:]}")
            for number in (signal.SIGINT, signal.SIGKILL) if not problems else ():
                for _ in range(int(moments)):
                    environment = fresh()
                    moment = draw.uniform(0.0, duration)
                    stopped = run(program, words, folder, environment, moment, number)
                    if stopped.returncode == whole.returncode and name not in TIMED and written(folder) == expected:
                        continue  # It ended before the signal.
                    mark = f"{signal.Signals(number).name} after {moment:.2f} s"
                    if number == signal.SIGINT and stopped.returncode not in (0, 1):
                        problems.append(f"{mark}: exit code {stopped.returncode}")
                    again = run(program, f"{words} --json" if name in RESUMED else words, folder, environment)
                    if again.returncode != whole.returncode:
                        problems.append(f"{mark}, then: exit code {again.returncode}: {again.stderr.strip()[-200:]}")
                    elif name not in TIMED and written(folder) != expected:
                        problems.append(f"{mark}, then: other files")
                    elif name in RESUMED and moment > 0.7 * duration and '"known":0' in again.stdout.replace(" ", ""):
                        problems.append(f"{mark}, then: nothing was kept")
                    if left := hidden(folder, False) + hidden(scratch, True):
                        problems.append(f"{mark}, then: left {left[:4]}")
        faults += len(problems)
        print(f"{name}: {duration:.1f} s, {'; '.join(problems[:4]) if problems else 'sound'}", flush=True)
    return faults


if __name__ == "__main__":
    sys.exit(1 if main(*sys.argv[1:]) else 0)
