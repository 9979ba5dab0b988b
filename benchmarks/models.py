"""Compares MJCF models as Cranny reads them with MuJoCo: link poses and contacts at random configurations.

    python benchmarks/models.py FOLDER... [--count 1000] [--markdown FILE]

FOLDER holds unpacked wheels (`pip download --no-deps robosuite==1.5.2 metaworld==3.1.1 dm-control==1.0.50
gymnasium-robotics==1.4.2`) or other models. Each file whose outermost element is `mujoco` and that MuJoCo opens is compared.

- pose: greatest difference of any entry of any link's pose from MuJoCo's (`mj_kinematics`), over all configurations; for a
  model without hinges and slides, of the poses of its primitives as a scenario, whose files keep 12 decimals.
- contacts: the pairs of links that Cranny checks, each at each configuration: how many verdicts differ from `mj_collision`,
  and how many of these are deeper or farther than 0.1 mm.
- unchecked: pairs of bodies in contact in MuJoCo that Cranny does not check, because they always touch or are adjacent.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections import defaultdict
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cranny
import numpy as np

HINGE, SLIDE = 3, 2
TOLERANCE_M = 1e-4
"""Depth or distance below which a differing verdict counts as rounding: MuJoCo's narrow phase iterates to 1e-6."""


@dataclass
class Row:
    """Comparison of one model."""

    model: str
    reason: str = ""
    links: int = 0
    joints: int = 0
    pose: float = float("nan")
    verdicts: int = 0
    touching: int = 0
    differing: int = 0
    grave: int = 0
    unchecked: int = 0
    examples: list[str] = field(default_factory=list)


def is_model(path: Path) -> bool:
    """True if the outermost element of the file is `mujoco`."""
    import xml.etree.ElementTree as xml

    try:
        return xml.parse(path).getroot().tag == "mujoco"
    except (xml.ParseError, OSError):
        return False


def names(model: Any, kind: str, count: int) -> list[str]:
    """Names of bodies or joints as Cranny forms them."""
    access = getattr(model, kind)
    return ["world" if kind == "body" and i == 0 else access(i).name or f"{kind}_{i}" for i in range(count)]


def follow(mujoco: Any, model: Any, qpos: Any) -> None:
    """Sets the joints that equality constraints couple to others."""
    for index in np.flatnonzero(model.eq_active0):
        if model.eq_type[index] != mujoco.mjtEq.mjEQ_JOINT:
            continue
        first, second = model.eq_obj1id[index], model.eq_obj2id[index]
        polynomial = model.eq_data[index][:5]
        place = model.jnt_qposadr[first]
        value = polynomial[0]
        if second >= 0:
            master = model.jnt_qposadr[second]
            value = np.polynomial.polynomial.polyval(qpos[master] - model.qpos0[master], polynomial)
        qpos[place] = model.qpos0[place] + value
    # A follower may lead another.
    for _ in range(2):
        for follower, leader, factor, offset in tendons(mujoco, model):
            qpos[model.jnt_qposadr[follower]] = factor * qpos[model.jnt_qposadr[leader]] + offset


def tendons(mujoco: Any, model: Any) -> list[tuple[int, int, float, float]]:
    """Joints that an equality constraint of a fixed tendon couples: follower, leader, factor and offset."""
    coupled = []
    taken: set[int] = set()
    for index in np.flatnonzero(model.eq_active0):
        if model.eq_type[index] != mujoco.mjtEq.mjEQ_TENDON:
            continue
        tendon = model.eq_obj1id[index]
        first = model.tendon_adr[tendon]
        if model.tendon_num[tendon] != 2:
            continue
        ends = [(int(model.wrap_objid[first + i]), float(model.wrap_prm[first + i])) for i in (0, 1)]
        if ends[1][0] in taken:
            ends.reverse()
        (leader, c1), (follower, c2) = ends
        taken.add(follower)
        leads, follows = model.qpos0[model.jnt_qposadr[leader]], model.qpos0[model.jnt_qposadr[follower]]
        coupled.append((follower, leader, -c1 / c2, model.eq_data[index][0] / c2 + follows + c1 / c2 * leads))
    return coupled


def compare(path: Path, name: str, count: int) -> Row | None:
    """Compares a model; None if MuJoCo does not open it."""
    import mujoco

    try:
        model = mujoco.MjModel.from_xml_path(str(path))
    except ValueError:
        return None
    row = Row(name)
    bodies, joints = names(model, "body", model.nbody), names(model, "joint", model.njnt)
    coupled = {
        joints[model.eq_obj1id[i]]
        for i in np.flatnonzero(model.eq_active0)
        if model.eq_type[i] == mujoco.mjtEq.mjEQ_JOINT
    } | {joints[follower] for follower, *_ in tendons(mujoco, model)}
    free = [
        joint
        for index, joint in enumerate(joints)
        if model.jnt_type[index] in (HINGE, SLIDE) and joint not in coupled
    ]
    if not free:
        return compare_world(mujoco, model, path, row)
    # Cranny checks contacts that a model switches off, and names that. Without constraints, MuJoCo finds no contacts either.
    for flag in (mujoco.mjtDisableBit.mjDSBL_CONTACT, mujoco.mjtDisableBit.mjDSBL_CONSTRAINT):
        model.opt.disableflags &= ~int(flag)
    try:
        robot = cranny.Robot.from_urdf(path, joints=free)
        cell = cranny.Cell(robot, [])
    except cranny.CrannyError as fault:
        row.reason = str(fault).replace(str(path), path.name).split("\n")[0]
        return row
    data = mujoco.MjData(model)
    row.joints, known = len(free), set(robot.link_names)
    row.links = len([body for body in bodies if body in known])
    places = [model.jnt_qposadr[joints.index(joint)] for joint in free]
    qs = robot.sample(count, seed=1)
    # Ranges of continuous joints and of slides without a range are Cranny's own.
    poses = {body: robot.fk(qs, body) for body in bodies if body in known}
    pairs: dict[frozenset[str], list[tuple[str, str]]] = defaultdict(list)
    for first, second in cell.self_pairs:
        pairs[frozenset((body_of(first, bodies), body_of(second, bodies)))].append((first, second))
    unchecked: set[frozenset[str]] = set()
    positions, axes = np.empty((count, model.nbody, 3)), np.empty((count, model.nbody, 3, 3))
    free_of_contact = cell.is_free(qs)
    for index, q in enumerate(qs):
        data.qpos[:] = model.qpos0
        data.qpos[places] = q
        follow(mujoco, model, data.qpos)
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_collision(model, data)
        positions[index], axes[index] = data.xpos, data.xmat.reshape(-1, 3, 3)
        depths: dict[frozenset[str], float] = {}
        for contact in data.contact[: data.ncon]:
            ends = frozenset(bodies[model.geom_bodyid[geom]] for geom in contact.geom)
            if not ends <= known or any(model.geom_type[geom] == 0 for geom in contact.geom):
                continue
            depths[ends] = min(depths.get(ends, np.inf), float(contact.dist))
        own: dict[frozenset[str], float] = {}
        for contact in [] if free_of_contact[index] else cell.contacts(q):
            ends = frozenset((body_of(contact.first, bodies), body_of(contact.second, bodies)))
            own[ends] = max(own.get(ends, 0.0), contact.depth_m)
        for ends in depths.keys() - pairs.keys():
            if depths[ends] < 0.0:
                unchecked.add(ends)
        row.verdicts += len(pairs)
        for ends in (depths.keys() | own.keys()) & pairs.keys():
            theirs, ours = depths.get(ends, np.inf) < 0.0, ends in own
            row.touching += ours
            if theirs == ours:
                continue
            row.differing += 1
            size = -depths.get(ends, 0.0) if theirs else own[ends]
            if size > TOLERANCE_M:
                row.grave += 1
                if len(row.examples) < 3:
                    who = "MuJoCo" if theirs else "Cranny"
                    row.examples.append(f"{' and '.join(sorted(ends))}: only {who}, {size * 1e3:.2f} mm")
    row.unchecked = len(unchecked)
    row.pose = 0.0
    for body, pose in poses.items():
        number = bodies.index(body)
        differences = pose[:, :3, 3] - positions[:, number], pose[:, :3, :3] - axes[:, number]
        row.pose = max(row.pose, *(float(np.abs(difference).max()) for difference in differences))
    return row


PRIMITIVES = {2: "sphere", 3: "capsule", 5: "cylinder", 6: "box"}
"""Types of MuJoCo's geoms that Cranny keeps as they are."""


def compare_world(mujoco: Any, model: Any, path: Path, row: Row) -> Row:
    """Compares the places of primitives that collide; for a model without hinges and slides, which moves as a world only."""
    collide = [i for i in range(model.ngeom) if model.geom_contype[i] or model.geom_conaffinity[i]]
    solid = [i for i in collide if model.geom_type[i] != 0]
    if not solid:
        row.reason = "nothing in it collides"
        return row
    bodies = names(model, "body", model.nbody)
    target = bodies[model.geom_bodyid[solid[0]]]
    top = model.body_parentid
    while model.body_parentid[bodies.index(target)] != 0 and any(
        model.jnt_type[j] == 0 for j in range(model.njnt) if model.jnt_bodyid[j] == top[bodies.index(target)]
    ):
        target = bodies[model.body_parentid[bodies.index(target)]]
    with tempfile.TemporaryDirectory() as folder:
        try:
            scenario = cranny.Scenario.from_world(
                path, Path(folder) / "world", robot="panda_mobile", target=target, at=[0, 0, 0, 0]
            )
        except cranny.CrannyError as fault:
            row.reason = str(fault).replace(str(path), path.name).split("\n")[0]
            return row
        shapes = [
            (kind, pose) for body in scenario.world for kind, pose in zip(body.kinds, body.poses, strict=True)
        ]
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    worst = 0.0
    for geom in solid:
        kind = PRIMITIVES.get(int(model.geom_type[geom]))
        if kind is None:
            continue
        expected = np.eye(4)
        expected[:3, :3] = data.geom_xmat[geom].reshape(3, 3)
        expected[:3, 3] = data.geom_xpos[geom]
        ends = slice(3, None) if kind == "sphere" else slice(0, None)
        found = [np.abs((pose - expected)[:3, ends]).max() for other, pose in shapes if other == kind]
        worst = max(worst, float(min(found, default=np.inf)))
    row.links, row.pose = len(scenario.world), worst
    return row


def body_of(link: str, bodies: list[str]) -> str:
    """Body that a link represents: a body has a further link for each further contact mask."""
    return link if link in bodies else link.split("_contact")[0]


def table(rows: list[Row]) -> str:
    """Markdown table of all rows."""
    lines = [
        "| model | links | joints | worst pose | verdicts | touching | differ | by > 0.1 mm | unchecked |",
        "|---|---:|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for row in rows:
        if row.reason:
            lines.append(f"| {row.model} | {row.reason} | | | | | | | |")
            continue
        numbers = [row.links, row.joints, f"{row.pose:.1e}", row.verdicts, row.touching]
        numbers += [row.differing, row.grave, row.unchecked]
        lines.append("| " + " | ".join(map(str, [row.model, *numbers])) + " |")
    return "\n".join(lines)


def main() -> None:
    """Compares all models of the folders."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--count", type=int, default=1000, help="configurations of each model")
    parser.add_argument("--markdown", type=Path, help="file for the table")
    parser.add_argument("--only", default="", help="part of the names of models")
    arguments = parser.parse_args()
    rows, start = [], time.monotonic()
    for folder in arguments.folders:
        for path in sorted(folder.rglob("*.xml")):
            name = str(path.relative_to(folder))
            if arguments.only not in name or not is_model(path):
                continue
            row = compare(path, name, arguments.count)
            if row is None:
                continue
            rows.append(row)
            print(f"{time.monotonic() - start:7.1f} s  {row}", file=sys.stderr, flush=True)
    text = table(rows)
    print(text)
    compared = [row for row in rows if not row.reason]
    refused = [row for row in rows if row.reason and row.reason != "nothing in it collides"]
    verdicts, differing = sum(row.verdicts for row in compared), sum(row.differing for row in compared)
    print(
        f"\n{len(rows)} models: {len(compared)} compared, {len(refused)} refused; worst pose "
        f"{max((row.pose for row in compared), default=0.0):.1e}; {verdicts} verdicts, {differing} differ, "
        f"{sum(row.grave for row in compared)} by more than 0.1 mm"
    )
    if arguments.markdown:
        arguments.markdown.write_text(text + "\n")


if __name__ == "__main__":
    main()
