"""Test whether the computed load of a grasp predicts holding: twenty objects made here, in rapier and in MuJoCo.

    python benchmarks/own_objects.py --cranny target/release/cranny
    python benchmarks/own_objects.py --cranny target/release/cranny --built-in    four built-in sets instead
    python benchmarks/own_objects.py --cranny target/release/cranny --folder new  keep the objects and all rows

Half of an object's grasps are sampled at its friction and half at 1, so that some slip; all are simulated at 0.35.
Grasps that do not close in both engines are omitted. Needs the packages numpy and mujoco.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import math
import re
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

try:
    from cranny import mujoco_grasps
except ImportError:
    SPEC = importlib.util.spec_from_file_location(
        "mujoco_grasps", Path(__file__).parent.parent / "python/cranny/mujoco_grasps.py"
    )
    mujoco_grasps = sys.modules["mujoco_grasps"] = importlib.util.module_from_spec(SPEC)
    SPEC.loader.exec_module(mujoco_grasps)

FRICTION = "0.35"
BUILT_IN = {"012": "screwdriver", "021": "ball", "031": "box", "041": "banana"}
ENGINES = ("rapier", "mujoco")
SIDES = 32
NOT_CLOSED = {"never-closed", "knocked-away"}


@dataclass
class Mesh:
    """Vertices in metres, and faces with three or four of them, anticlockwise as seen from outside."""

    corners: list[Any]
    faces: list[tuple[int, ...]]

    def write(self, path: Path) -> None:
        lines = [f"v {x:.7f} {y:.7f} {z:.7f}" for x, y, z in self.corners]
        for first, *rest in self.faces:
            lines += [f"f {first + 1} {b + 1} {c + 1}" for b, c in zip(rest, rest[1:])]
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")


@dataclass
class Thing:
    """An object, its mass, and the settings of its test."""

    name: str
    mesh: Mesh
    mass_kg: float
    pose: int | None = 0
    """Index of the resting pose; None: it floats until the hand has closed."""
    shift_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Displacement of the centre of mass from that of the mesh by an insert with 0.6 of the mass."""
    flags: list[str] = field(default_factory=list)


def lathe(*profile_mm: tuple[float, float], closed: bool = False) -> Mesh:
    """Solid of revolution about z from (radius, height) points, ordered upwards along the axis; closed: from a closed
    profile beside the axis. Face i * SIDES + j belongs to segment i of the profile and is centred on angle j."""
    steps = [*profile_mm, profile_mm[0]] if closed else list(profile_mm)
    corners: list[Any] = []
    rows = []
    for r, z in profile_mm:
        angles = (np.arange(SIDES if r > 0 else 1) - 0.5) * math.tau / SIDES
        rows.append([len(corners) + (j if r > 0 else 0) for j in range(SIDES)])
        corners += [np.array([r * math.cos(a), r * math.sin(a), z]) * 1e-3 for a in angles]
    if closed:
        rows.append(rows[0])
    faces = []
    for low, high in zip(rows[: len(steps) - 1], rows[1:]):
        for j in range(SIDES):
            k = (j + 1) % SIDES
            faces.append(tuple(dict.fromkeys((low[j], low[k], high[k], high[j]))))
    return Mesh(corners, faces)


def extrude(thickness_mm: float, *outline_mm: tuple[float, float]) -> Mesh:
    """Extrusion along z of an anticlockwise outline in x and y."""
    count, points = len(outline_mm), np.array(outline_mm, dtype=float)
    corners = [np.array([x, y, z]) * 1e-3 for z in (0.0, thickness_mm) for x, y in outline_mm]
    faces: list[tuple[int, ...]] = []
    faces += [(i, (i + 1) % count, (i + 1) % count + count, i + count) for i in range(count)]
    left = list(range(count))

    def area(a: int, b: int, c: int) -> float:
        (ux, uy), (vx, vy) = points[b] - points[a], points[c] - points[a]
        return float(ux * vy - uy * vx)

    while len(left) > 2:  # ear clipping
        for i in range(len(left)):
            a, b, c = left[i - 1], left[i], left[(i + 1) % len(left)]
            others = (p for p in left if p not in (a, b, c))
            inside = (min(area(a, b, p), area(b, c, p), area(c, a, p)) >= 0 for p in others)
            if area(a, b, c) > 0 and not any(inside):
                faces += [(c, b, a), (a + count, b + count, c + count)]
                left.remove(b)
                break
        else:
            raise ValueError("the outline is not anticlockwise, or crosses itself")
    return Mesh(corners, faces)


def box(x_mm: float, y_mm: float, z_mm: float) -> Mesh:
    return extrude(z_mm, (0, 0), (x_mm, 0), (x_mm, y_mm), (0, y_mm))


def with_handle(mesh: Mesh, step: int, path_mm: list[tuple[float, ...]], into: int | None = None) -> Mesh:
    """Adds a bar at angle 0 from the face of a segment of a lathed profile, through points (x, z) with their rotation
    in degrees, to the face of another segment or to a free end."""
    start = mesh.faces[step * SIDES]
    low = [mesh.corners[i] for i in start]
    half_y, half_z = abs(low[0][1]), 0.5 * (low[3][2] - low[0][2])
    rings = [start]
    for x, z, degrees in path_mm:
        sine, cosine = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
        rings.append(tuple(len(mesh.corners) + i for i in range(4)))
        for y, up in ((-half_y, -half_z), (half_y, -half_z), (half_y, half_z), (-half_y, half_z)):
            mesh.corners.append(np.array([x * 1e-3 + up * sine, y, z * 1e-3 + up * cosine]))
    gone = [step * SIDES]
    if into is None:
        mesh.faces.append(rings[-1])
    else:
        a, b, c, d = mesh.faces[into * SIDES]
        rings.append((d, c, b, a))
        gone.append(into * SIDES)
    for near, far in zip(rings, rings[1:]):
        mesh.faces += [(near[i], near[(i + 1) % 4], far[(i + 1) % 4], far[i]) for i in range(4)]
    mesh.faces = [face for i, face in enumerate(mesh.faces) if i not in gone]
    return mesh


def things() -> list[Thing]:
    """The objects, numbered from 1."""
    arc = [(58 + 18 * math.sin(a), 48 + 29 * math.cos(a), math.degrees(a)) for a in np.linspace(0.0, math.pi, 9)]
    mug = lathe((0, 0), (40, 0), (40, 14), (40, 24), (40, 72), (40, 82), (40, 95), (36, 95), (36, 5), (0, 5))
    ladle = lathe((0, 0), (20, 4), (31, 16), (34, 26), (34, 34), (31, 34), (28, 17), (18, 7), (0, 3))
    torus = [(40 + 8 * math.cos(a), 8 * math.sin(a)) for a in np.arange(12) * math.tau / 12]
    hammer = [(0, -10), (150, -10), (150, -55), (180, -55), (180, 45), (150, 45), (150, 10), (0, 10)]
    wrench = [(0, -9), (140, -7), (155, -20), (185, -18), (185, -9), (165, -8), (165, 8), (185, 9)]
    wrench += [(185, 18), (155, 20), (140, 7), (0, 9)]
    tee = [(-10, 0), (10, 0), (10, 110), (55, 110), (55, 130), (-55, 130), (-55, 110), (-10, 110)]
    dumbbell = [(0, 0), (32, 0), (32, 50), (12, 55), (12, 145), (20, 150), (20, 175), (0, 175)]
    return [
        Thing("mug with a handle", with_handle(mug, 4, arc, into=2), 0.35),
        Thing("can", lathe((0, 0), (33, 0), (33, 110), (0, 110)), 0.4),
        Thing("bottle", lathe((0, 0), (32, 0), (34, 150), (14, 190), (14, 230), (0, 230)), 0.5),
        Thing("flat box, on edge", box(160, 110, 30), 0.4, pose=1),
        Thing("ladle", with_handle(ladle, 3, [(60, 34, 0), (210, 60, 0)]), 0.12),
        Thing("cube", box(55, 55, 55), 0.25),
        Thing("long box, end heavy", box(220, 50, 40), 0.6, shift_m=(0.06, 0.0, 0.0)),
        Thing("carton, bottom heavy", box(60, 45, 150), 0.5, shift_m=(0.0, 0.0, -0.045)),
        Thing("hammer", extrude(24, *hammer), 0.6),
        Thing("dumbbell, one end heavier", lathe(*dumbbell), 0.8),
        Thing("plate", lathe((0, 0), (55, 0), (95, 15), (95, 19), (54, 4), (0, 4)), 0.3, pose=None),
        Thing("bowl", lathe((0, 0), (30, 0), (60, 25), (70, 55), (66, 55), (56, 27), (28, 4), (0, 4)), 0.3),
        Thing("cone", lathe((0, 0), (38, 0), (6, 120), (0, 120)), 0.3),
        Thing("wrench", extrude(9, *wrench), 0.25),
        Thing("T", extrude(20, *tee), 0.3),
        Thing("L profile", extrude(160, (0, 0), (50, 0), (50, 5), (5, 5), (5, 60), (0, 60)), 0.35, pose=1),
        Thing("ring", lathe(*torus, closed=True), 0.2),
        Thing("thin tube", lathe((23, 0), (25, 0), (25, 200), (23, 200), closed=True), 0.3),
        Thing("light block, pressed by 4 N", box(90, 45, 35), 0.06, flags=["--closing-force", "4"]),
        Thing("heavy bar", box(240, 25, 25), 1.2),
    ]


def shift_mass(path: Path, thing: Thing) -> None:
    """Shifts the centre of mass in an object.yaml along an axis of the object, as an insert would."""
    text, share = path.read_text(encoding="utf-8"), 0.6

    def block(key: str) -> tuple[str, Any]:
        lines = re.search(rf"^{key}:\n((?:- .+\n)+)", text, re.MULTILINE)
        assert lines is not None
        return lines[1], np.array([float(line[2:]) for line in lines[1].splitlines()])

    def listed(values: Any) -> str:
        return "".join(f"- {value}\n" for value in values.tolist())

    (centers, center), (inertias, inertia) = block("center_of_mass"), block("inertia_kg_m2")
    shift = np.array(thing.shift_m)
    insert = shift / share
    inertia[:3] *= 1.0 - share
    inertia[:3] += share * (1.0 - share) * thing.mass_kg * (insert @ insert - insert * insert)
    text = text.replace(centers, listed(center + shift), 1).replace(inertias, listed(inertia), 1)
    path.write_text(text, encoding="utf-8")


def run(*command: str) -> str:
    """Output of a command; it is no failure if `simulate grasps` finds that no grasp holds."""
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode > (command[1:3] == ("simulate", "grasps")):
        sys.exit(f"{' '.join(command)}\n{done.stderr}")
    return done.stdout


def both_engines(cranny: str, subject: list[str], folder: Path) -> dict[str, Any]:
    """Rows of the grasps of an object in both engines, those that closed in both, and the seconds for each."""
    times = [time.perf_counter()]
    rows = json.loads(run(cranny, "simulate", "grasps", *subject, "--json", "-q"))["rows"]
    times.append(time.perf_counter())
    run(cranny, "simulate", "export", *subject, "-q", "--force", "-o", str(folder / "experiment.json"))
    experiment = mujoco_grasps.load(folder / "experiment.json")
    times.append(time.perf_counter())
    for row, other in zip(rows, mujoco_grasps.run_all(experiment), strict=True):
        row["mujoco"] = vars(other)
        row["held"] = {"rapier": row["outcome"] == "held", "mujoco": other.outcome == "held"}
    times.append(time.perf_counter())
    closed = [row for row in rows if NOT_CLOSED.isdisjoint((row["outcome"], row["mujoco"]["outcome"]))]
    return {"rows": rows, "closed": closed, "seconds": [times[1] - times[0], times[3] - times[2]]}


def try_thing(cranny: str, number: int, thing: Thing, folder: Path, count: int) -> dict[str, Any]:
    """Makes an object, samples its grasps, and tests them."""
    mesh, object_, grasps = folder / f"{number:02}.obj", str(folder / f"{number:02}"), folder / f"{number:02}.csv"
    thing.mesh.write(mesh)
    run(cranny, "object", "add", str(mesh), "--mass", str(thing.mass_kg), "--friction", FRICTION, "-o", object_)
    if any(thing.shift_m):
        shift_mass(Path(object_) / "object.yaml", thing)
    pose = [] if thing.pose is None else ["--pose", str(thing.pose)]
    lines: list[str] = []
    for flags in (["--friction", FRICTION, "--depth", "-10", "10"], ["--friction", "1", "--depth", "-18", "18"]):
        some = [*pose, *flags, "--count", str(count // 2), "--seed", "1", "-q", "--force", "-o", str(grasps)]
        run(cranny, "grasps", "sample", object_, *some)
        lines += grasps.read_text(encoding="utf-8").splitlines()[bool(lines) :]
    grasps.write_text("\n".join(lines) + "\n", encoding="utf-8")
    subject = [object_, "--grasps", str(grasps), *pose, *thing.flags]
    return both_engines(cranny, subject, folder)


def area(rows: list[dict[str, Any]], engine: str) -> str:
    """Area under the ROC curve of the load at rest."""
    yes, no = ([row["load"]["at_rest"] for row in rows if row["held"][engine] is wanted] for wanted in (True, False))
    return f"{np.mean([(a > b) + 0.5 * (a == b) for a in yes for b in no]):.3f}" if yes and no else "–"


def summary(rows: list[dict[str, Any]]) -> str:
    """Table cells: number of grasps, held in each engine, agreement, and the area in each."""
    counts = [str(sum(row["held"][engine] for row in rows)) for engine in ENGINES]
    agreed = sum(row["held"]["rapier"] == row["held"]["mujoco"] for row in rows) / max(len(rows), 1)
    return " | ".join([str(len(rows)), *counts, f"{agreed:.1%}", *(area(rows, engine) for engine in ENGINES)])


def print_shares(rows: list[dict[str, Any]]) -> None:
    """Prints the shares of held grasps by load."""
    print("\n| of the grasps with | held in rapier | in MuJoCo |\n|---|---|---|")
    for words, key, low, high in (
        ("at rest of 2 or more", "at_rest", 2.0, math.inf),
        ("at rest of 3 or more", "at_rest", 3.0, math.inf),
        ("at rest of 0.8 to 2", "at_rest", 0.8, 2.0),
        ("at rest below 0.8", "at_rest", 0.0, 0.8),
        ("in motion of 1.5 or more", "in_motion", 1.5, math.inf),
    ):
        meant = [row for row in rows if low <= row["load"][key] < high]
        counts = [sum(row["held"][engine] for row in meant) for engine in ENGINES]
        cells = [f"{count} of {len(meant)} ({count / max(len(meant), 1):.1%})" for count in counts]
        print(f"| load {words} | {' | '.join(cells)} |")


def measure(cranny: str, is_built_in: bool, count: int, folder: Path) -> None:
    """Tests all objects, and prints the tables."""
    print("| object | closed | held in rapier | in MuJoCo | agreement | area in rapier | in MuJoCo |")
    print("|---|---|---|---|---|---|---|")
    known: list[dict[str, Any]] = []
    for number, test in enumerate(BUILT_IN if is_built_in else things(), 1):
        if isinstance(test, Thing):
            name, tried = f"{number} {test.name}", try_thing(cranny, number, test, folder, count)
        else:
            name, tried = f"{BUILT_IN[test]} ({test})", both_engines(cranny, [test, "--support-only"], folder)
        known.append({"name": name, "number": number, **tried})
        (folder / "rows.json").write_text(json.dumps(known), encoding="utf-8")
        print(f"| {name} | {summary(tried['closed'])} |", flush=True)
    for words, numbers in (("odd: tuning", {1}), ("even: held out", {0}), ("all", {0, 1})):
        rows = [row for tried in known if tried["number"] % 2 in numbers for row in tried["closed"]]
        if words == "all" or not is_built_in:
            print(f"| {words} | {summary(rows)} |")
    print_shares(rows)
    tried_count = sum(len(tried["rows"]) for tried in known)
    rates = [tried_count / sum(tried["seconds"][engine] for tried in known) for engine in (0, 1)]
    print(f"\n{tried_count} grasps tried; rapier {rates[0]:.1f} grasps/s, MuJoCo {rates[1]:.1f} grasps/s")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cranny", default="cranny", help="the program")
    parser.add_argument("--built-in", action="store_true")
    parser.add_argument("--folder", type=Path, help="new: where to keep the objects and all rows")
    parser.add_argument("--count", type=int, default=60, help="grasps of each object")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as passing:
        folder = given.folder or Path(passing)
        folder.mkdir(parents=True, exist_ok=True)
        measure(given.cranny, given.built_in, given.count, folder)


if __name__ == "__main__":
    main()
