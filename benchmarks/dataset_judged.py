"""Rows of a set of demonstrations, checked by an independent judge (`python/tests/outside_judge.py`: Pinocchio and Coal):
`dataset_judged.py SET [ROWS] [SAMPLES]`. Needs the packages of `xtask/python-requirements.txt` but not `cranny`; runs the
command named by `CRANNY_BIN`, or the one in `target/release`.

Rows with a path are drawn at random from all chunks and extracted as a scenario and a plan. Each edge is sampled, up to
SAMPLES times; no two bodies may touch except as declared, or come closer than the plan states. Exits with 1 if a statement
is false, or if the judge misses an obstacle that is put in the way of the hand.
"""

from __future__ import annotations

import importlib
import json
import os
import subprocess
import sys
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from types import ModuleType
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
# The judge needs only `package` from the tests' conftest.py, which would also load the package `cranny`.
sys.modules["conftest"] = ModuleType("conftest")
vars(sys.modules["conftest"])["package"] = importlib.import_module
sys.path.insert(0, str(ROOT / "python/tests"))
from outside_judge import Robot, Tally, Task  # noqa: E402

COMMAND = os.environ.get("CRANNY_BIN") or str(ROOT / "target/release/cranny")
SEED = 1
CORES = 2
PLANTED_SAMPLES = 15
"""Samples of an edge with a planted obstacle, an odd number: the middle is one of them."""


def cranny(*words: str | Path) -> None:
    """Runs the command."""
    subprocess.run([COMMAND, *map(str, words)], check=True, stdout=subprocess.DEVNULL)


def drawn_rows(folder: Path, count: int) -> list[tuple[int, str]]:
    """Numbers and tasks of random rows with a path."""
    parquet = importlib.import_module("pyarrow.parquet")
    table = parquet.read_table(folder / "demonstrations", columns=["row", "task", "outcome"]).to_pylist()
    solved = [(row["row"], row["task"]) for row in table if row["outcome"] == "solved"]
    chosen = np.random.default_rng(SEED).choice(len(solved), size=min(count, len(solved)), replace=False)
    return [solved[place] for place in sorted(chosen)]


def is_missed(plan: dict[str, Any], task: Task, target: str) -> bool:
    """Puts the first obstacle around the hand in the middle of the first edge, and returns true if the judge does not notice it."""
    whole = plan["segments"][0]
    reach = {**whole, "waypoints": whole["waypoints"][:2], "clearances_m": whole["clearances_m"][:1]}
    middle = np.array(reach["waypoints"]).mean(axis=0)
    body = task.entry["obstacles"][0]["name"]
    task.poses[body] = task.place(plan["joint_names"], middle[None], task.OPEN_M)[task.HAND][0] @ np.linalg.inv(
        task.things[body].thing_from_shape[0]
    )
    task.tally = Tally()
    before, sys.stderr = sys.stderr, Path(os.devnull).open("w", encoding="utf-8")
    try:
        task.judge({**plan, "segments": [reach], "not_checked": []}, target, "planted")
    finally:
        sys.stderr.close()
        sys.stderr = before
    return not task.tally.false


def main(folder: Path, count: int, samples: int) -> bool:
    """Judges the rows and prints the figures; returns whether all statements are true."""
    tally, tasks, missed, begin = Tally(), Counter[str](), 0, time.monotonic()
    with TemporaryDirectory() as temporary, ThreadPoolExecutor(CORES) as pool:
        place = Path(temporary)
        cranny("robot", "export", "panda_mobile", "-o", place / "robot")
        robot = Robot(place / "robot/panda_mobile.urdf", place / "robot/panda_mobile.srdf")

        @cache
        def mesh(name: str) -> Any:
            cranny("object", "export", name, "-o", place / name)
            coal = importlib.import_module("coal")
            return coal.MeshLoader().load(str(place / name / "mesh.obj"), np.ones(3))

        rows = drawn_rows(folder, count)
        extracted = pool.map(lambda row: cranny("dataset", "extract", folder, str(row[0]), "-o", place / str(row[0])), rows)
        for (row, kind), _ in zip(rows, extracted, strict=True):
            task = Task(place / str(row), robot, mesh, tally, samples)
            plan = json.loads((place / str(row) / "demonstration.plan.json").read_text())
            target = task.entry["target"]["name"]
            task.judge(plan, target, f"row {row}")
            tasks[kind] += 1
            missed += is_missed(plan, Task(place / str(row), robot, mesh, tally, PLANTED_SAMPLES), target)
    print(f"{len(rows)} rows ({', '.join(f'{kind} {many}' for kind, many in sorted(tasks.items()))}): {tally}")
    print(f"planted obstacles: {len(rows) - missed} of {len(rows)} found; {time.monotonic() - begin:.0f} s")
    return not tally.false and missed == 0


if __name__ == "__main__":
    given = [int(word) for word in sys.argv[2:]]
    sys.exit(0 if main(Path(sys.argv[1]), *given, *[200, 100][len(given) :]) else 1)
