"""Proven motions, sampled by an independent judge (outside_judge.py): robots with narrow windows, held objects close to
obstacles, plans of several steps. Only the command line of Cranny is used.

`CRANNY_LONG=1` judges the full numbers: 50 robots, 2000 edges with a held object, 200 plans of steps. False cases are
copied to the folder named by `CRANNY_CASES`.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import REPOSITORY, lacking, package
from outside_judge import ROUNDING_M, Floats, Robot, Tally, Task, Thing, along, distances
from window_robots import WindowRobot

IS_LONG = os.environ.get("CRANNY_LONG") == "1"
ROBOTS, EDGES, STEPS, SAMPLES = (50, 2000, 200, 200) if IS_LONG else (3, 16, 1, 40)
ROBOT_EDGES, TIME_LIMIT_S = (200, "5") if IS_LONG else (40, "0.5")
GRASPS = "t00,t01,t02,t03,t10,t11,t12,t13,t20,t21,t22,t23,t30,t31,t32,t33,score\n1,0,0,9,0,1,0,0,0,0,1,0,0,0,0,1,1\n"
"""One distant grasp."""
SCENARIOS = REPOSITORY / "crates/scenario/scenarios"


def run(*words: str | Path) -> subprocess.CompletedProcess[str]:
    program = os.environ.get("CRANNY_BIN")
    if not program:
        lacking("CRANNY_BIN is unset: no program")
    return subprocess.run([str(program), *map(str, words)], capture_output=True, text=True, check=False)


def progress(what: str, tally: Tally) -> None:
    """Prints progress at once, so that an interrupted run reports its checks."""
    print(f"{what}: {tally}", file=sys.stderr, flush=True)


def keep(case: Path) -> None:
    """Saves the files of a false answer."""
    if folder := os.environ.get("CRANNY_CASES"):
        for path in case.parent.glob(f"{case.name}*"):
            kept = Path(folder) / path.name
            kept.parent.mkdir(parents=True, exist_ok=True)
            shutil.copytree(path, kept, dirs_exist_ok=True) if path.is_dir() else shutil.copy(path, kept)


class WindowCase:
    """Robot made by `robot add`, in a scenario with boxes."""

    def __init__(self, made: WindowRobot, folder: Path, case: Path, rng: np.random.Generator) -> None:
        yaml, coal = package("yaml"), package("coal")
        self.made, self.case, self.rng = made, case, rng
        # The original URDF; only the declared link pairs come from the folder.
        self.robot = Robot(case.with_suffix(".urdf"), next(folder.glob("*.srdf"), None))
        start = yaml.safe_load((folder / "robot.yaml").read_text())["start"]
        self.joints = [name for name in self.robot.model.names if name in start]
        self.start = np.array([start[name] for name in self.joints], dtype=float)
        self.boxes: dict[str, tuple[Thing, Floats]] = {}
        entries: list[dict[str, Any]] = []
        at_start = self.poses(self.start[None])
        while len(entries) < 3:
            size, pose = rng.uniform(0.02, 0.3, 3), np.eye(4)
            pose[:3, 3] = [*rng.uniform(-0.6, 0.6, 2), rng.uniform(0.0, 1.2)]
            thing, name = Thing([(coal.Box(*size), np.eye(4))]), f"b{len(entries)}"
            links = self.robot.links.items()
            if min(distances(link, at_start[at], thing, pose[None], 0.1).min() for at, link in links) > 0.002:
                self.boxes[name] = thing, pose
                shape = {"box": {"size": size.tolist()}}
                entries.append({"name": name, "pose": {"position": pose[:3, 3].tolist()}, "shapes": [shape]})
        target = {"name": "far", "pose": {"position": [9.0, 0.0, 0.0]}, "shapes": [{"sphere": {"radius": 0.01}}]}
        self.scenario = case.parent / f"{case.name}.scene"
        self.scenario.mkdir()
        # A scenario without a hand needs a grasp; its paths may end anywhere.
        (self.scenario / "grasps.csv").write_text(GRASPS)
        scene = {"robot": str(folder), "start": self.start.tolist(), "floor": None, "obstacles": entries, "target": target}
        (self.scenario / "scenario.yaml").write_text(yaml.safe_dump(scene))

    def poses(self, samples: Floats) -> dict[str, Floats]:
        return self.robot.poses([dict(zip(self.joints, q, strict=True)) for q in samples], list(self.robot.links))

    def to_box(self, link: str, box: str, poses: dict[str, Floats], limit_m: float) -> Floats:
        """Distances of a link to a box of the scenario in each sample."""
        thing, pose = self.boxes[box]
        return distances(self.robot.links[link], poses[link], thing, np.broadcast_to(pose, poses[link].shape), limit_m)

    def least(self, poses: dict[str, Floats], pairs: list[tuple[str, str]]) -> float:
        """A number that is at most 0 if anything touches."""
        links = [self.robot.between(pair, poses, 0.0).min() for pair in pairs]
        return float(min(*links, *(self.to_box(link, box, poses, 0.0).min() for link in self.robot.moved for box in self.boxes)))

    def is_free(self, q: Floats) -> bool:
        return self.least(self.poses(q[None]), self.robot.pairs) > 0.0

    def drawn(self) -> Floats:
        """Random configuration inside windows, often other windows than the last one."""
        q: Floats = self.rng.uniform(*np.array([self.made.limits[name] for name in self.joints]).T)
        for k, name in enumerate(self.joints):
            if name in self.made.windows:
                middle, width = self.made.windows[name][self.rng.integers(len(self.made.windows[name]))]
                q[k] = middle + 0.49 * width * self.rng.uniform(-1.0, 1.0)
        return q

    def path(self, count: int) -> Floats:
        """Way points: small moves, jumps between windows, and some that end in contact."""
        limits = np.array([self.made.limits[name] for name in self.joints]).T
        wide = {name: windows[0][1] for name, windows in self.made.windows.items()}
        reach = np.array([wide.get(name, 1.0) for name in self.joints])
        path = [self.start]
        for _ in range(20 * count):
            if self.rng.random() < 0.2:
                q = self.drawn()
            else:
                moved = self.rng.random(len(reach)) < 0.5
                far = reach * self.rng.normal(size=len(reach)) * self.rng.choice([0.03, 0.1, 0.3, 1.0])
                q = np.clip(path[-1] + moved * far, *limits)
            if self.rng.random() < 0.1 or self.is_free(q):
                path.append(q)
            if len(path) > count:
                break
        return np.array(path)

    def judge(self, tally: Tally) -> None:
        path, csv = self.path(ROBOT_EDGES), self.case.parent / f"{self.case.name}.csv"
        np.savetxt(csv, path, delimiter=",", fmt="%.17g")
        # Rounded as Cranny reads them.
        path = np.loadtxt(csv, delimiter=",", ndmin=2)
        done = run("verify", self.scenario, csv, "--any-end", "--json")
        assert done.returncode in (0, 1), done.stderr
        verdict = json.loads(done.stdout)
        refused = {violation["edge"] for violation in verdict["violations"]}
        named = {frozenset((one["first"], one["second"])): one["reason"] for one in verdict["not_checked"]}
        pairs = [pair for pair in self.robot.pairs if frozenset(pair) not in named]
        seen: list[dict[str, Floats]] = [self.poses(np.array([self.drawn() for _ in range(SAMPLES)]))]
        for k, (a, b) in enumerate(zip(path, path[1:], strict=False)):
            poses = self.poses(along(a, b, SAMPLES))
            seen.append(poses)
            if k in refused:
                tally.counts["edges, refused"] += 1
                tally.counts["of these in contact"] += self.least(poses, pairs) <= 0.0
                continue
            tally.counts["edges, proven"] += 1
            stated_m, case = verdict["clearances_per_edge_m"][k], f"{self.case} edge {k}"
            for pair in pairs:
                tally.check("clearance of links", self.robot.between(pair, poses, stated_m), stated_m, f"{case}: {pair}")
            for link in self.robot.moved:
                for name in self.boxes:
                    apart = self.to_box(link, name, poses, stated_m)
                    tally.check("clearance of links and world", apart, stated_m, f"{case}: {link} and {name}")
        dropped = {**self.robot.declared, **named}
        for pair in self.robot.all_pairs:
            if frozenset(pair) in dropped:
                self.judge_dropped(pair, dropped[frozenset(pair)], seen, tally)

    def judge_dropped(self, pair: tuple[str, str], reason: str, seen: list[dict[str, Floats]], tally: Tally) -> None:
        """Checks that an omitted pair always or never touches, or is reported as a pair without proof."""
        tally.counts[f"pairs not compared ({reason})"] += 1
        apart = np.concatenate([self.robot.between(pair, poses, 1e-3) for poses in seen])
        is_free, is_deep = bool(apart.max() > ROUNDING_M), bool(apart.min() < -ROUNDING_M)
        if is_free and is_deep and reason in ("adjacent-at-joint", "adjacent-unproven"):
            tally.counts[f"of these free at times, {reason}"] += 1
        elif (is_free and is_deep) or (is_deep and "never" in reason) or (is_free and "always" in reason):
            tally.note("dropped pair", f"{self.case}: {pair} ({reason}): {apart.min()} to {apart.max()} m apart")


def test_robots_with_narrow_windows_are_never_called_free_where_coal_finds_contact(tmp_path: Path) -> None:
    """Windows of 0.5 to 5 % of a joint's range, between adjacent and other links."""
    tally = Tally()
    for seed in range(3 * ROBOTS):
        rng, case = np.random.default_rng(seed), tmp_path / f"w{seed}"
        made, urdf, folder = WindowRobot(rng), case.with_suffix(".urdf"), tmp_path / f"w{seed}.robot"
        urdf.write_text(made.urdf)
        added = run("robot", "add", urdf, "-o", folder, "--bare")
        if added.returncode != 0:
            assert "error" in added.stderr, added
            tally.counts["robots, refused"] += 1
            continue
        tally.counts["robots"] += 1
        known = len(tally.false)
        WindowCase(made, folder, case, rng).judge(tally)
        if len(tally.false) > known:
            keep(case)
        if IS_LONG:
            progress(f"robot {seed}", tally)
        if tally.counts["robots"] == ROBOTS:
            break
    progress("robots", tally)
    assert tally.counts["edges, proven"] > 10 * ROBOTS
    # The judge must find contacts, otherwise it would test nothing.
    assert tally.counts["of these in contact"] > 0
    assert not tally.false, "\n".join(tally.false[:20])


@pytest.fixture(scope="module")
def panda(tmp_path_factory: pytest.TempPathFactory) -> Robot:
    """The built-in mobile Panda, exported."""
    folder = tmp_path_factory.mktemp("robot") / "panda_mobile"
    assert run("robot", "export", "panda_mobile", "-o", folder).returncode == 0
    return Robot(folder / "panda_mobile.urdf", folder / "panda_mobile.srdf")


@pytest.fixture(scope="module")
def mesh(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Any]:
    """Surface of a built-in object, exported."""
    folder = tmp_path_factory.mktemp("objects")

    @cache
    def surface(name: str) -> Any:
        assert run("object", "export", name, "-o", folder / name).returncode == 0
        read, coal = package("trimesh").load_mesh(folder / name / "mesh.obj", process=False), package("coal")
        model = coal.BVHModelOBBRSS()
        model.beginModel(len(read.faces), len(read.vertices))
        model.addVertices(np.asarray(read.vertices))
        model.addTriangles(np.asarray(read.faces))
        model.endModel()
        return model

    return surface


def beside(name: str, position: list[float], half: float, rng: np.random.Generator) -> dict[str, Any]:
    """A post 0.5 to 5 mm beside an object that extends by `half` to all sides."""
    size, turn = rng.uniform(0.005, 0.03, 2), rng.uniform(-np.pi, np.pi)
    away = half + rng.uniform(0.0005, 0.005) + 0.5 * size[0]
    x, y, z = position
    return {
        "name": name,
        "pose": {
            "position": [float(x + away * np.cos(turn)), float(y + away * np.sin(turn)), float(z)],
            "quaternion_xyzw": [0.0, 0.0, float(np.sin(0.5 * turn)), float(np.cos(0.5 * turn))],
        },
        "shapes": [{"box": {"size": [float(size[0]), float(size[1]), 0.05]}}],
    }


def variant(scenario: str, rng: np.random.Generator, folder: Path, of: str) -> Path:
    """Built-in scenario with one or two posts beside a body, and one at each goal pose of the target."""
    yaml = package("yaml")
    source = SCENARIOS / scenario
    entry = yaml.safe_load((source / "scenario.yaml").read_text())
    for place in entry["places"]:
        # YAML 1.1 reads `on` as true.
        if True in place:
            place["on"] = place.pop(True)
    folder.mkdir()
    shutil.copy(source / "grasps.csv", folder)
    [body] = [body for body in [*entry["obstacles"], entry["target"]] if body["name"] == of]
    shape = body["shapes"][0]
    # The y axis of the built-in boxes points up.
    sides = [shape["sphere"]["radius"]] * 3 if "sphere" in shape else 0.5 * np.array(shape.get("box", {}).get("size", [0.06] * 3))
    around = float(sides[0] if "sphere" in shape else np.hypot(sides[0], sides[2] if of == "box" else sides[1]))
    posts = [beside(f"post {k}", body["pose"]["position"], around, rng) for k in range(rng.integers(1, 3))]
    for place in entry["places"]:
        if "target_pose" in place:
            posts.append(beside(f"post at {place['name']}", place["target_pose"]["position"], around, rng))
        elif rng.random() < 0.5 and "sphere" in shape:
            # The goal area is small, so that the post is next to the object that is put down.
            place["size"] = [0.01, 0.01]
            posts.append(beside(f"post at {place['name']}", place["pose"]["position"], around, rng))
            posts[-1]["pose"]["position"][2] += 0.0255
    entry["obstacles"] += posts
    (folder / "scenario.yaml").write_text(yaml.safe_dump(entry))
    return folder


def plans_with_held_objects(tmp_path: Path) -> Iterator[tuple[Path, Path, str]]:
    """Plans next to posts, each with its scenario and object; a third of them demand a margin."""
    kinds = ["021", "031", "123", "133", "023", "035", "121", "135", "025", "033", "012", "043"]
    for number in range(10_000):
        rng, scenario = np.random.default_rng(number), kinds[number % len(kinds)]
        entry = package("yaml").safe_load((SCENARIOS / scenario / "scenario.yaml").read_text())
        target = entry["target"]["name"]
        folder, plan = tmp_path / f"c{number}.scene", tmp_path / f"c{number}.plan.json"
        variant(scenario, rng, folder, target)
        words = ["--carry", "home"] if number % 4 == 3 else ["--place", entry["places"][0]["name"]]
        words += ["--margin", "2"] if number % 3 == 2 else []
        done = run("plan", folder, *words, "--time-limit", TIME_LIMIT_S, "--seed", str(number), "-o", plan)
        assert done.returncode in (0, 1, 2), done.stderr
        if done.returncode == 0:
            yield folder, plan, target


def test_held_objects_beside_near_neighbours_touch_nothing_but_their_support(
    panda: Robot, mesh: Callable[[str], Any], tmp_path: Path
) -> None:
    tally = Tally()
    for folder, plan, target in plans_with_held_objects(tmp_path):
        known = len(tally.false)
        Task(folder, panda, mesh, tally, SAMPLES).judge(json.loads(plan.read_text()), target, plan.name)
        tally.counts["plans"] += 1
        if len(tally.false) > known:
            keep(tmp_path / plan.name.split(".")[0])
        if IS_LONG and tally.counts["plans"] % 10 == 0:
            progress(plan.name, tally)
        if tally.counts["edges, held"] >= EDGES:
            break
    progress("held objects", tally)
    assert tally.counts["edges, held"] >= EDGES
    assert not tally.false, "\n".join(tally.false[:20])


def test_the_judge_finds_what_is_false(panda: Robot, mesh: Callable[[str], Any], tmp_path: Path) -> None:
    """Planted faults: clearances that are too large, an object too deep in its support, a post in the path."""
    folder, path = variant("021", np.random.default_rng(0), tmp_path / "p.scene", "ball"), tmp_path / "p.plan.json"
    assert run("plan", folder, "--place", "outside", "-o", path).returncode == 0
    plan = json.loads(path.read_text())

    def found(plan: dict[str, Any], change: Callable[[Task], None] = lambda _: None) -> set[str]:
        task = Task(folder, panda, mesh, Tally(), 20)
        change(task)
        task.judge(plan, "ball", "planted")
        return {kind for kind in task.tally.counts if kind.startswith("false")}

    def sunk(task: Task) -> None:
        task.poses["ball"][:3, 3] -= 2e-4 * task.up

    def in_the_way(task: Task, link: str) -> None:
        [carry] = [segment for segment in plan["segments"] if segment["mode"] == "carry"]
        [task.poses["post 0"]] = task.place(plan["joint_names"], np.array(carry["waypoints"][-1:]), task.OPEN_M)[link]

    assert not found(plan)
    assert {"false contact of what rests"} <= found(plan, sunk)
    assert {"false clearance of links and world"} <= found(plan, lambda task: in_the_way(task, task.HAND))
    assert {"false clearance of held"} <= found(plan, lambda task: in_the_way(task, task.TIP))
    for segment in plan["segments"]:
        segment["clearances_m"] = [0.05 + clearance for clearance in segment["clearances_m"]]
    assert {"false clearance of links", "false clearance of links and world", "false clearance of held"} <= found(plan)


def test_plans_of_steps_touch_nothing_but_what_things_rest_on(
    panda: Robot, mesh: Callable[[str], Any], tmp_path: Path
) -> None:
    tally = Tally()
    for number in range(STEPS * 4):
        scenario = ["235", "213", "245"][number % 3]
        folder, plan = tmp_path / f"s{number}.scene", tmp_path / f"s{number}.plan.json"
        variant(scenario, np.random.default_rng(number), folder, "column 1")
        done = run("plan", folder, "--steps", "--time-limit", "30", "--seed", str(number), "-o", plan)
        assert done.returncode in (0, 1, 2), done.stderr
        if done.returncode != 0:
            tally.counts["unsolved"] += 1
            continue
        known, document = len(tally.false), json.loads(plan.read_text())
        task = Task(folder, panda, mesh, tally, SAMPLES)
        picks = [stage for stage, row in enumerate(document["task"]) if "pick" in row]
        for first, end in zip(picks, [*picks[1:], len(document["task"])], strict=True):
            segments = [segment for segment in document["segments"] if first <= segment["stage"] < end]
            pick = document["task"][first]["pick"]
            others = [one for one in document["not_checked"] if one["reason"] != "resting" or one["first"] == pick]
            task.judge({**document, "segments": segments, "not_checked": others}, pick, f"{plan.name} stage {first + 1}")
        tally.counts["plans of steps"] += 1
        if len(tally.false) > known:
            keep(tmp_path / f"s{number}")
        if IS_LONG and tally.counts["plans of steps"] % 5 == 0:
            progress(plan.name, tally)
        if tally.counts["plans of steps"] == STEPS:
            break
    progress("steps", tally)
    assert tally.counts["plans of steps"] == STEPS
    assert not tally.false, "\n".join(tally.false[:20])
