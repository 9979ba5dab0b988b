"""Measures how time and memory of commands grow with the size of their input.

usage: scale.py CRANNY [NAME…]   the program; names of rows to measure (default: all)
"""

from __future__ import annotations

import math
import multiprocessing
import os
import shutil
import sqlite3
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

MOST_S = 600
"""Time limit of a command, in seconds."""


@dataclass
class Row:
    """Commands of one kind for several sizes of input."""

    name: str
    sizes: tuple[int, ...]
    prepare: Callable[[Path, int], list[str]]
    """Writes the input of a size into a folder and returns the words of the command."""


def grid(side: int) -> list[tuple[int, int, int]]:
    """Returns the corners of two triangles for each square of a grid of `side` squares."""
    squares = [(i * (side + 1) + j, side + 1) for i in range(side) for j in range(side)]
    return [face for at, n in squares for face in ((at, at + 1, at + n), (at + 1, at + n + 1, at + n))]


def ball(folder: Path, triangles: int) -> str:
    """Writes a bumpy ball of about that many triangles as an OBJ file and returns its name."""
    rows = max(3, round(math.sqrt(triangles / 4)))
    columns = 2 * rows
    lines = ["v 0 0 0.04"]
    for i in range(1, rows):
        polar = math.pi * i / rows
        for j in range(columns):
            around = 2 * math.pi * j / columns
            radius = 0.04 + 0.001 * math.sin(7 * polar) * math.sin(5 * around)
            x, y = math.sin(polar) * math.cos(around), math.sin(polar) * math.sin(around)
            lines.append(f"v {radius * x:.6f} {radius * y:.6f} {radius * math.cos(polar):.6f}")
    lines.append("v 0 0 -0.04")
    last = len(lines)

    def at(i: int, j: int) -> int:
        return 2 + (i - 1) * columns + j % columns

    for j in range(columns):
        lines += [f"f 1 {at(1, j)} {at(1, j + 1)}", f"f {last} {at(rows - 1, j + 1)} {at(rows - 1, j)}"]
    for i in range(1, rows - 1):
        for j in range(columns):
            a, b, c, d = at(i, j), at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)
            lines += [f"f {a} {c} {b}", f"f {b} {c} {d}"]
    (folder / "ball.obj").write_text("\n".join(lines) + "\n")
    return "ball.obj"


HEAD = """robot: panda_mobile
frame: {position: [0, 0, 0.05]}
start: {base_joint_y: 0, base_joint_x: 0, panda_joint1: -0.0178, panda_joint2: -0.7601, panda_joint3: 0.0198,
  panda_joint4: -2.3421, panda_joint5: 0.0298, panda_joint6: 1.5412, panda_joint7: 0.7534}
floor: 0
"""
CAN = "target:\n  name: can\n  pose: {position: [0.8, 0, 0.68]}\n  shapes: [{cylinder: {radius: 0.03, length: 0.1}}]\n"
GRASP = "0,1,0,0.8, 0,0,-1,0, -1,0,0,0.63, 0,0,0,1"


def scenario(folder: Path, obstacles: list[str], target: str = CAN, grasps: int = 0) -> Path:
    """Writes a scenario with these obstacles (YAML), whose grasps lie around the middle of its target."""
    text = HEAD + ("obstacles:\n" + "".join(obstacles) if obstacles else "obstacles: []\n") + target
    (folder / "scenario.yaml").write_text(text)
    lines = []
    for index in range(grasps):
        turn = 2 * math.pi * index / grasps
        c, s = math.cos(turn), math.sin(turn)
        # The palm points along a horizontal direction, the fingers close horizontally.
        lines.append(f"0,{-s:.6f},{c:.6f},{0.8:.4f},0,{c:.6f},{s:.6f},0,-1,0,0,{0.63:.4f},0,0,0,1,1,")
    if grasps:
        (folder / "grasps.csv").write_text("\n".join(lines) + "\n")
    return folder


def boxes(folder: Path, count: int) -> Path:
    """Writes a scenario with that many small boxes on the floor around the robot."""
    side = math.ceil(math.sqrt(count))
    entry = "  - name: b{n}\n    pose: {{position: [{x:.4f}, {y:.4f}, 0.05]}}\n    shapes: [{{box: {{size: [0.01, 0.01, 0.02]}}}}]\n"
    obstacles = [
        entry.format(n=n, x=1.5 + 3 * (n % side) / side, y=-1.5 + 3 * (n // side) / side) for n in range(count)
    ]
    return scenario(folder, obstacles, grasps=20)


def mesh_obstacle(folder: Path, triangles: int) -> Path:
    """Writes a scenario whose only obstacle is a mesh."""
    name = ball(folder, triangles)
    entry = f"  - name: rock\n    pose: {{position: [1.2, 0.3, 0.1]}}\n    shapes: [{{mesh: {{file: {name}}}}}]\n"
    return scenario(folder, [entry], grasps=20)


def mesh_target(folder: Path, triangles: int) -> Path:
    """Writes a scenario whose target is a mesh, without grasps."""
    name = ball(folder, triangles)
    target = f"target:\n  name: rock\n  pose: {{position: [0.8, 0, 0.68]}}\n  shapes: [{{mesh: {{file: {name}}}}}]\n"
    return scenario(folder, [], target)


def recording(folder: Path, triangles: int) -> Path:
    """Writes the recording of a mesh of triangles about one corner."""
    rim = [
        [0.1 * math.cos(2 * math.pi * i / triangles), 0.1 * math.sin(2 * math.pi * i / triangles), 0.0]
        for i in range(triangles)
    ]
    faces = [[0, 1 + i, 1 + (i + 1) % triangles] for i in range(triangles)]
    pose = "[0, 0, 0.2, 0, 0, 0, 1]"
    text = (
        '{"format": "cranny-recording/1", "name": "a cone", "times_s": [0.0, 0.04], '
        '"world_from_floor": [0, 0, 0, 0, 0, 0, 1], "bodies": [{"name": "cone", "is_grasped": true, '
        f'"world_from_body": [{pose}, {pose}], "vertices": {[[0.0, 0.0, 0.1], *rim]}, "triangles": {faces}}}]}}'
    )
    (folder / "cone.json").write_text(text)
    return folder / "cone.json"


def chain(folder: Path, joints: int) -> Path:
    """Writes an arm of that many joints with a gripper of two fingers."""
    lines = ['<robot name="arm">', '<link name="base"/>']
    parent = "base"
    length = 2.0 / joints
    box = '<collision><origin xyz="0 0 {z:.4f}"/><geometry><box size="0.02 0.02 {l:.4f}"/></geometry></collision>'
    for index in range(joints):
        name = f"link{index}"
        axis = "0 1 0" if index % 2 else "0 0 1"
        lines.append(f'<link name="{name}">{box.format(z=length / 2, l=0.6 * length)}</link>')
        lines.append(
            f'<joint name="j{index}" type="revolute"><parent link="{parent}"/><child link="{name}"/>'
            f'<origin xyz="0 0 {length if index else 0.1:.4f}"/><axis xyz="{axis}"/>'
            '<limit lower="-2" upper="2" velocity="1" effort="10"/></joint>'
        )
        parent = name
    lines.append("</robot>")
    (folder / "arm.urdf").write_text("\n".join(lines))
    return folder / "arm.urdf"


def results(folder: Path, trials: int, settings: int, program: str) -> Path:
    """Writes results with that many trials of that many settings, from a small campaign."""
    file = folder / "results.db"
    words = ["bench", "run", "-q", "-o", str(file), "--scenarios", "021", "--runs", "1", "--planner", "reach"]
    subprocess.run([program, *words, "--time-limit", "1"], check=True, stdout=subprocess.DEVNULL)
    with sqlite3.connect(file) as stored:
        table = next(name for (name,) in stored.execute("select name from sqlite_master where name = 'trials'"))
        columns = [row[1] for row in stored.execute(f"pragma table_info({table})")]
        first = dict(zip(columns, stored.execute(f"select * from {table}").fetchone(), strict=True))
        keys = [column for column in columns if column != "id"]
        rows = []
        for index in range(1, trials):
            row = dict(first)
            row["seed"] = index // settings
            row["planner"] = f"reach{index % settings}"
            row["planning_time_s"] = 0.001 * (1 + (index * 7919) % 1000)
            rows.append([row[key] for key in keys])
        marks = ", ".join("?" * len(keys))
        stored.executemany(f"insert into {table} ({', '.join(keys)}) values ({marks})", rows)
    return file


def rows(program: str) -> list[Row]:
    """Returns all rows of the table."""
    triangles = (10_000, 100_000, 1_000_000)
    trials = (10_000, 100_000, 1_000_000)
    counts = (1000, 10_000, 100_000)

    def merged(folder: Path, size: int) -> list[str]:
        file = results(folder, size, 10, program)
        shutil.copy(file, folder / "other.db")
        return ["bench", "merge", str(file), str(folder / "other.db"), "-o", str(folder / "all.db")]

    return [
        Row("boxes: plan", counts, lambda f, n: ["plan", str(boxes(f, n)), "-o", str(f / "p.plan.json")]),
        Row("boxes: page", counts, lambda f, n: ["render", str(boxes(f, n)), "-o", str(f / "page.html")]),
        Row("boxes: picture", counts, lambda f, n: ["render", str(boxes(f, n)), "-o", str(f / "page.png")]),
        Row("obstacle of triangles: plan", triangles, lambda f, n: ["plan", str(mesh_obstacle(f, n)), "-o", str(f / "p.plan.json")]),
        Row("target of triangles: info", triangles, lambda f, n: ["info", str(mesh_target(f, n))]),
        Row(
            "target of triangles: plan --grasps none",
            triangles,
            lambda f, n: ["plan", str(mesh_target(f, n)), "--grasps", "none", "-o", str(f / "p.plan.json"), "--time-limit", "5"],
        ),
        Row("triangles: page", triangles, lambda f, n: ["render", str(mesh_obstacle(f, n)), "-o", str(f / "page.html")]),
        Row("recording of triangles: page", (1000, 10_000, 100_000), lambda f, n: ["render", str(recording(f, n)), "-o", str(f / "page.html")]),
        Row("grasps: plan", counts, lambda f, n: ["plan", str(scenario(f, [], grasps=n)), "-o", str(f / "p.plan.json")]),
        Row("joints: robot check", (10, 30, 60), lambda f, n: ["robot", "check", str(chain(f, n))]),
        Row("trials: report", trials, lambda f, n: ["bench", "report", str(results(f, n, 10, program)), "-o", str(f / "r.html")]),
        Row("trials: status", trials, lambda f, n: ["bench", "status", str(results(f, n, 10, program))]),
        Row("trials: merge", trials, merged),
        Row("settings: report", (10, 100, 400), lambda f, n: ["bench", "report", str(results(f, 50 * n, n, program)), "-o", str(f / "r.html")]),
        Row("scenarios: one worker", (5, 50, 500), lambda f, n: many_scenarios(f, n)),
    ]


def many_scenarios(folder: Path, count: int) -> list[str]:
    """Writes that many scenarios and returns the campaign over them, with one worker."""
    names = []
    for index in range(count):
        own = folder / f"s{index}"
        own.mkdir()
        scenario(own, [f"  - name: b{index}\n    shapes: [{{box: {{size: [0.1, 0.1, 0.1]}}}}]\n    pose: {{position: [2, 0, 0.1]}}\n"], grasps=20)
        names.append(str(own))
    words = ["bench", "run", "-q", "-o", str(folder / "r.db"), "--planner", "reach", "--runs", "1", "--time-limit", "1"]
    return [*words, "--scenarios", ",".join(names)]


def prepared(row: Row, folder: Path, size: int) -> list[str]:
    """Prepares the input in a process of its own: the peak memory of a command includes that of its parent."""
    context = multiprocessing.get_context("fork")
    answers = context.SimpleQueue()
    process = context.Process(target=lambda: answers.put(row.prepare(folder, size)))
    process.start()
    words = answers.get()
    process.join()
    return words


def measure(command: list[str]) -> tuple[str, float, float]:
    """Runs a command and returns its end, time in seconds and peak memory of its processes in MiB."""
    # A pipe blocks a command once it is full of unread notes.
    notes = tempfile.TemporaryFile()
    begin = time.monotonic()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=notes)
    while True:
        done, status, usage = os.wait4(process.pid, os.WNOHANG)
        elapsed = time.monotonic() - begin
        if done:
            break
        if elapsed > MOST_S:
            process.kill()
            os.wait4(process.pid, 0)
            return ("ended", elapsed, math.nan)
        time.sleep(0.005)
    notes.seek(0)
    message = notes.read().decode().strip().splitlines()
    code = os.waitstatus_to_exitcode(status)
    end = "" if code == 0 else f"exit code {code}: {message[-1][:90] if message else ''}"
    return (end, elapsed, usage.ru_maxrss / 1024)


def main(program: str, *names: str) -> None:
    """Prints the table."""
    program = str(Path(program).resolve())
    print("| input: command | size | time | times | memory | times | output | remark |")
    print("|---|---|---|---|---|---|---|---|")
    for row in rows(program):
        if names and row.name not in names:
            continue
        before: tuple[float, float] | None = None
        for size in row.sizes:
            with tempfile.TemporaryDirectory() as folder:
                words = prepared(row, Path(folder), size)
                end, elapsed, memory = measure([program, *words])
                written = Path(words[words.index("-o") + 1]) if "-o" in words else None
                output = f"{written.stat().st_size / 1e6:.1f} MB" if written and written.exists() else ""
            ratios = [f"{now / then:.1f}" for now, then in zip((elapsed, memory), before, strict=True)] if before else ["", ""]
            print(f"| {row.name} | {size} | {elapsed:.2f} s | {ratios[0]} | {memory:.0f} MiB | {ratios[1]} | {output} | {end} |", flush=True)
            before = (elapsed, memory)


if __name__ == "__main__":
    main(*sys.argv[1:])
