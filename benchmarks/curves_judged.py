"""Rounded corners of plans, checked by an independent judge (`python/tests/outside_judge.py`: Pinocchio and Coal):
`curves_judged.py CORNERS [SAMPLES]`. Needs the packages of `xtask/python-requirements.txt` but not `cranny`; runs the
command named by `CRANNY_BIN`, or the one in `target/release`.

Corners of motions to a grasp are evaluated here from their control points. Exits with 1 if a sample is in contact, closer
than the plan states or outside the joint limits, if a corner ends off its edge, or if the judge misses a planted contact.
"""

from __future__ import annotations

import importlib
import json
import os
import subprocess
import sys
from collections import Counter
from dataclasses import dataclass, field
from functools import cache
from itertools import product
from math import comb
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
from outside_judge import ROUNDING_M, Floats, Robot, Tally, Task, distances  # noqa: E402

COMMAND = os.environ.get("CRANNY_BIN") or str(ROOT / "target/release/cranny")
SCENARIOS = ["012", "013", "015", "023", "025", "031", "035", "041", "043", "045"]
FAR_M, SHORT_M, ON_EDGE = 0.1, 1e-4, 1e-9
"""Limit of measured distances, tolerance for a stated clearance, and tolerance in metres or radians for the distance of
a corner's end from its edge."""


@dataclass
class Seen:
    """Figures of all corners: measured and stated clearance of each, and numbers of samples."""

    least_m: list[float] = field(default_factory=list)
    stated_m: list[float] = field(default_factory=list)
    off_edge: list[float] = field(default_factory=list)
    in_contact: int = 0
    outside: int = 0
    found: int = 0


def cranny(*words: str | Path) -> int:
    """Runs the command; 1 is its regular negative result."""
    code = subprocess.run([COMMAND, *map(str, words)], check=False, stdout=subprocess.DEVNULL).returncode
    assert code in (0, 1), words
    return code


def curve(points: Floats, samples: int) -> Floats:
    """Configurations of a Bézier curve at equal steps of its parameter, including both ends (samples, joints)."""
    at, degree = np.linspace(0.0, 1.0, samples), len(points) - 1
    weights = [comb(degree, k) * at**k * (1.0 - at) ** (degree - k) for k in range(degree + 1)]
    return np.asarray(np.array(weights).T @ points)


def off(point: Floats, a: Floats, b: Floats) -> float:
    """Distance of a configuration from an edge."""
    share = float(np.clip((point - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0))
    return float(np.linalg.norm(point - a - share * (b - a)))


def apart(task: Task, poses: dict[str, Floats], named: set[frozenset[str]]) -> tuple[Floats, float]:
    """Least distance in each sample between any two bodies that may not touch, exact below 0.01 mm, and the least that
    counts for a clearance: links that move with the hand may not touch, but do not count. The pairs are those of
    `Task.judge`."""
    robot, nearest, least_m = task.robot, np.full(len(poses[task.TIP]), np.inf), FAR_M
    pairs = [pair for pair in robot.pairs if frozenset(pair) not in named]
    for a, b in [*pairs, *((link, body) for link in robot.moved for body in task.things)]:
        counts = not task.moving_as_hand.issuperset((a, b))
        limit_m = max(least_m, ROUNDING_M) if counts else ROUNDING_M
        other, at = (robot.links[b], poses[b]) if b in robot.links else (task.things[b], task.poses[b])
        found = distances(robot.links[a], poses[a], other, np.broadcast_to(at, poses[a].shape), limit_m)
        nearest = np.minimum(nearest, found.min(axis=(1, 2)))
        least_m = min(least_m, float(found.min())) if counts else least_m
    return nearest, least_m


def judge(plan: dict[str, Any], task: Task, case: str, samples: int, seen: Seen, most: int) -> None:
    """Judges the corners of motions to a grasp, up to `most` in total."""
    joints, target = plan["joint_names"], task.entry["target"]["name"]
    named = {frozenset((one["first"], one["second"])) for one in plan["not_checked"]}
    for segment in [segment for segment in plan["segments"] if segment["mode"] == "reach"]:
        way_points = np.array(segment["waypoints"])
        for corner in segment.get("corners", [])[: most - len(seen.least_m)]:
            k, points = corner["waypoint"], np.array(corner["control_points"])
            configurations = curve(points, samples)
            poses = task.place(joints, configurations, task.OPEN_M)
            nearest, least_m = apart(task, poses, named)
            seen.in_contact += int((nearest <= 0.0).sum())
            seen.outside += sum(bool(task.robot.outside_limits(dict(zip(joints, q, strict=True)))) for q in configurations)
            # A corner lies between two edges; neither states more than its own clearance, so the larger value applies.
            stated_m = max(segment["clearances_m"][k - 1 : k + 1])
            seen.least_m, seen.stated_m = [*seen.least_m, least_m], [*seen.stated_m, stated_m]
            seen.off_edge += [off(points[0], *way_points[k - 1 : k + 1]), off(points[-1], *way_points[k : k + 2])]
            if least_m < stated_m - ROUNDING_M:
                print(f"{case} corner at way point {k}: {1e3 * least_m:.5f} mm apart, {1e3 * stated_m:.5f} stated")
            # The judge must also find planted contacts: the target is moved to a finger in the middle of the corner.
            stood, task.poses[target] = task.poses[target], poses["panda_leftfinger"][samples // 2]
            seen.found += bool((apart(task, poses, named)[0] <= 0.0).any())
            task.poses[target] = stood


def main(most: int, samples: int) -> bool:
    """Plans for one seed after another and prints the figures; returns whether all statements are true."""
    seen, plans, corners = Seen(), 0, Counter[str]()
    with TemporaryDirectory() as temporary:
        folder = Path(temporary)
        cranny("robot", "export", "panda_mobile", "-o", folder / "robot")
        robot = Robot(folder / "robot/panda_mobile.urdf", folder / "robot/panda_mobile.srdf")

        @cache
        def mesh(name: str) -> Any:
            cranny("object", "export", name, "-o", folder / name)
            coal = importlib.import_module("coal")
            return coal.MeshLoader().load(str(folder / name / "mesh.obj"), np.ones(3))

        for seed, scenario in product(range(1000), SCENARIOS):
            file, known = folder / "x.plan.json", len(seen.least_m)
            if cranny("plan", scenario, "--seed", str(seed), "--json", "-o", file) == 0:
                task = Task(ROOT / "crates/scenario/scenarios" / scenario, robot, mesh, Tally(), samples)
                judge(json.loads(file.read_text()), task, f"{scenario} seed {seed}", samples, seen, most)
            plans, corners[scenario] = plans + 1, corners[scenario] + len(seen.least_m) - known
            if len(seen.least_m) == most:
                break
    more = np.array(seen.least_m) - np.array(seen.stated_m)
    [short, finer], off_edge = [int((more < -by_m).sum()) for by_m in (SHORT_M, ROUNDING_M)], max(seen.off_edge)
    print(f"{len(more)} corners with {len(more) * samples} samples, of {plans} plans; of scenarios: {dict(corners)}")
    print(f"in contact: {seen.in_contact} samples; outside the joint limits: {seen.outside} samples")
    print(f"least distance: {1e3 * min(seen.least_m):.5f} mm, median of the corners {1e3 * np.median(seen.least_m):.3f} mm")
    print(f"less the stated clearance: least {1e3 * more.min():.5f} mm, median {1e3 * np.median(more):.5f} mm")
    print(f"short of it by more than {1e3 * SHORT_M:g} mm: {short}, than {1e3 * ROUNDING_M:g} mm: {finer} corners")
    print(f"ends beside their edge: by {off_edge:.1e} at most; planted contacts: {seen.found} of {len(more)} found")
    return not (seen.in_contact or seen.outside or short) and off_edge <= ON_EDGE and seen.found == len(more)


if __name__ == "__main__":
    sys.exit(0 if main(int(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 200) else 1)
