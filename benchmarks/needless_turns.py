"""Joint travel of delivered paths beyond need, for arms with joints of ±2π or without limits.

    python benchmarks/needless_turns.py PROGRAM [--seeds 25] [--robot ur5e …] [--family shelf …]

The travel beyond need of a joint is its travel along the path, minus the distance from its start value to the nearest
value, whole turns apart and within its range, that gives the hand the same pose as at the end of the path. Prints a line
for each robot and family: number of paths, how many turn a joint more than 180° beyond need, the maximum and the 95th
percentile, and how many end a whole turn farther away than needed.
"""

import argparse
import json
import math
import re
import subprocess
import tempfile
from pathlib import Path

arguments = argparse.ArgumentParser(description=__doc__)
arguments.add_argument("program")
arguments.add_argument("--seeds", type=int, default=25)
arguments.add_argument("--robot", nargs="+", default=["ur5e", "ur5e_mobile", "fetch_like"])
arguments.add_argument("--family", nargs="+", default=["shelf", "table", "gap", "gate"])
given = arguments.parse_args()


Range = tuple[float, float, bool]
"""Lower and upper limit of a joint, and whether it is a revolute joint."""


def ranges(robot: str) -> list[Range]:
    """Ranges of a robot's joints from `robot check`."""
    checked = subprocess.run([given.program, "robot", "check", robot, "--json"], capture_output=True, text=True)
    said = (re.search(r": (\S+) to (\S+) (m|rad)", joint) for joint in json.loads(checked.stdout)["joints"])
    return [(float(one[1]), float(one[2]), one[3] == "rad") for one in said if one]


def beyond_need(path: list[list[float]], joints: list[Range]) -> tuple[float, bool]:
    """Greatest travel beyond need of a path's joints, and whether a joint ends a whole turn too far away."""
    most, too_far = 0.0, False
    for values, (low, high, turns) in zip(zip(*path, strict=True), joints, strict=True):
        travel = sum(abs(b - a) for a, b in zip(values, values[1:]))
        ends = [values[-1] + 2.0 * math.pi * k for k in range(-3, 4)] if turns else [values[-1]]
        needed = min(abs(end - values[0]) for end in ends if low - 1e-3 <= end <= high + 1e-3)
        most = max(most, travel - needed)
        too_far = too_far or abs(values[-1] - values[0]) > needed + 1e-6
    return most, too_far


print("| robot | family | paths | over 180° beyond need | most (°) | 95th percentile (°) | end a turn too far |")
print("|---|---|---|---|---|---|---|")
for robot in given.robot:
    joints = ranges(robot)
    for family in given.family:
        with tempfile.TemporaryDirectory() as folder:
            scenes = Path(folder) / "scenes"
            words = ["scenario", "generate", "--family", family, "--count", str(given.seeds), "--robot", robot]
            subprocess.run([given.program, *words, "-o", str(scenes)], check=True, capture_output=True)
            excess, too_far = [], 0
            for seed, scene in enumerate(sorted(scenes.glob(f"{family}-*"))):
                plan = Path(folder) / "plan.json"
                words = ["plan", str(scene), "--seed", str(seed), "--time-limit", "20", "-o", str(plan)]
                if subprocess.run([given.program, *words], capture_output=True).returncode:
                    continue
                most, far = beyond_need(json.loads(plan.read_text())["waypoints"], joints)
                excess.append(math.degrees(most))
                too_far += far
            excess.sort()
            over = sum(one > 180.0 for one in excess)
            cells = [robot, family, len(excess), over, f"{excess[-1]:.0f}", f"{excess[int(0.95 * (len(excess) - 1))]:.0f}", too_far]
            print(f"| {' | '.join(map(str, cells))} |", flush=True)
