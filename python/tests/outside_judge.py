"""Judge of plans that shares no code with Cranny, only its files.

It reads URDF, SRDF, scenario.yaml, meshes and plans itself, uses the kinematics of Pinocchio and the distances of Coal,
and samples motions that Cranny calls proven. Two bodies may touch only if one rests on a supporting shape below it, by
0.1 mm, during lift-off and set-down. Finger pads may touch the held object.
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from conftest import package
from numpy.typing import NDArray

Floats = NDArray[np.float64]

ROUNDING_M = 1e-5
"""Depth above which two bodies count as in contact, and tolerance for a stated clearance."""
SUPPORT_M = 1e-4 + 5e-6
"""Permitted depth of an object in its support."""
RESTING_M = 3.5e-4
"""Greatest height above the support at which an object may be released."""
STEP_M = 5e-4
"""Movement of a link's point between two samples, unless their number is limited."""


def pose_of(entry: dict[str, Any] | None) -> Floats:
    """A pose of scenario.yaml, (4, 4)."""
    pin = package("pinocchio")
    pose, entry = np.eye(4), entry or {}
    if "quaternion_xyzw" in entry:
        pose[:3, :3] = pin.Quaternion(np.array(entry["quaternion_xyzw"], dtype=float)).normalized().toRotationMatrix()
    elif "rotation_rpy_deg" in entry:
        pose[:3, :3] = pin.rpy.rpyToMatrix(*np.radians(entry["rotation_rpy_deg"]))
    pose[:3, 3] = entry.get("position", [0.0, 0.0, 0.0])
    return pose


def numbers(text: str | None, count: int) -> Floats:
    """Numbers of an XML attribute; zeros if it is absent."""
    return np.array([float(word) for word in text.split()]) if text else np.zeros(count)


class Thing:
    """A rigid body: Coal's shapes, each with its pose in the body's frame and its bounding box."""

    def __init__(self, shapes: list[tuple[Any, Floats]]) -> None:
        self.shapes = [shape for shape, _ in shapes]
        self.thing_from_shape = np.array([pose for _, pose in shapes]).reshape(-1, 4, 4)
        for shape in self.shapes:
            shape.computeLocalAABB()
        boxes = [(shape.aabb_local.min_, shape.aabb_local.max_) for shape in self.shapes]
        low, high = np.array(boxes).reshape(-1, 2, 3).transpose(1, 0, 2)
        self.middle, self.half = 0.5 * (low + high), 0.5 * (high - low)
        self.radius = np.linalg.norm(self.half, axis=1)

    @classmethod
    def of_body(cls, entry: dict[str, Any], mesh: Callable[[str], Any]) -> Thing:
        """Body of scenario.yaml in its own frame; `mesh` returns the shape of a built-in object."""
        coal, shapes = package("coal"), []
        for shape in entry["shapes"]:
            if "box" in shape:
                solid = coal.Box(*[float(size) for size in shape["box"]["size"]])
            elif "sphere" in shape:
                solid = coal.Sphere(float(shape["sphere"]["radius"]))
            elif "cylinder" in shape:
                solid = coal.Cylinder(float(shape["cylinder"]["radius"]), float(shape["cylinder"]["length"]))
            else:
                solid = mesh(shape["object"])
            shapes.append((solid, pose_of(shape.get("pose"))))
        return cls(shapes)

    @classmethod
    def of_link(cls, link: ElementTree.Element) -> Thing:
        """Collision shapes of a link of a URDF, in the link's frame."""
        pin, coal, shapes = package("pinocchio"), package("coal"), []
        for collision in link.findall("collision"):
            pose, origin = np.eye(4), collision.find("origin")
            if origin is not None:
                pose[:3, :3] = pin.rpy.rpyToMatrix(*numbers(origin.get("rpy"), 3))
                pose[:3, 3] = numbers(origin.get("xyz"), 3)
            [entry] = list(collision.findall("geometry")[0])
            if entry.tag == "box":
                solid = coal.Box(*numbers(entry.get("size"), 3))
            elif entry.tag == "sphere":
                solid = coal.Sphere(float(entry.attrib["radius"]))
            else:
                kind = {"cylinder": coal.Cylinder, "capsule": coal.Capsule}[entry.tag]
                solid = kind(float(entry.attrib["radius"]), float(entry.attrib["length"]))
            shapes.append((solid, pose))
        return cls(shapes)

    def at(self, poses: Floats) -> Floats:
        """Poses of the shapes (n, shapes, 4, 4) for body poses `poses` (n, 4, 4)."""
        return np.asarray(poses[:, None] @ self.thing_from_shape)


def gaps(a: Thing, at: Floats, b: Thing, there: Floats) -> Floats:
    """Lower bound of the distance of each pair of shapes (n, shapes of a, shapes of b): from the bounding ball of one
    to the box of the other, the larger of both choices."""

    def one_way(ball: Thing, balls: Floats, box: Thing, boxes: Floats) -> Floats:
        middles = (balls[..., :3, :3] @ ball.middle[..., None])[..., 0] + balls[..., :3, 3]
        apart = middles[:, :, None] - boxes[:, None, :, :3, 3]
        inside = np.einsum("nabi,nbij->nabj", apart, boxes[..., :3, :3]) - box.middle
        outside = np.maximum(np.abs(inside) - box.half, 0.0)
        return np.asarray(np.linalg.norm(outside, axis=-1) - ball.radius[None, :, None])

    return np.maximum(one_way(a, at, b, there), one_way(b, there, a, at).transpose(0, 2, 1))


def distances(a: Thing, poses: Floats, b: Thing, others: Floats, limit_m: float) -> Floats:
    """Signed distance of each pair of shapes in each sample (n, shapes of a, shapes of b), or a lower bound that is at
    least the limit."""
    coal = package("coal")
    at, there = a.at(poses), b.at(others)
    found = gaps(a, at, b, there)
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    for n, i, j in zip(*np.nonzero(found < limit_m), strict=True):
        one, two = (coal.Transform3s(pose[:3, :3], pose[:3, 3]) for pose in (at[n, i], there[n, j]))
        result.clear()
        found[n, i, j] = coal.distance(a.shapes[i], one, b.shapes[j], two, request, result)
    return found


class Robot:
    """Robot from its URDF, with the pairs of links that its SRDF disables and their reasons."""

    def __init__(self, urdf: Path, srdf: Path | None) -> None:
        self.pin = package("pinocchio")
        self.model = self.pin.buildModelFromUrdf(str(urdf))
        self.data = self.model.createData()
        links = {str(link.get("name")): Thing.of_link(link) for link in ElementTree.parse(urdf).findall("link")}
        self.links = {name: thing for name, thing in links.items() if thing.shapes}
        disabled = ElementTree.parse(srdf).findall("disable_collisions") if srdf else []
        self.declared = {frozenset((pair.attrib["link1"], pair.attrib["link2"])): pair.get("reason", "") for pair in disabled}
        self.frame = {name: self.model.getFrameId(name) for name in links}
        joint = {name: self.model.frames[self.frame[name]].parentJoint for name in self.links}
        self.moved = [name for name in self.links if joint[name] > 0]
        names = list(self.links)
        self.all_pairs = [(b, a) for k, a in enumerate(names) for b in names[:k] if joint[a] != joint[b]]
        self.pairs = [pair for pair in self.all_pairs if frozenset(pair) not in self.declared]

    def poses(self, configurations: list[dict[str, float]], links: list[str]) -> dict[str, Floats]:
        """`root_from_link` of each link (n, 4, 4) at these joint values; other joints are at 0."""
        poses: dict[str, Floats] = {link: np.empty((len(configurations), 4, 4)) for link in links}
        for k, values in enumerate(configurations):
            q = self.pin.neutral(self.model)
            for name, value in values.items():
                joint = self.model.joints[self.model.getJointId(name)]
                q[joint.idx_q : joint.idx_q + joint.nq] = [value] if joint.nq == 1 else [np.cos(value), np.sin(value)]
            self.pin.framesForwardKinematics(self.model, self.data, q)
            for link in links:
                poses[link][k] = self.data.oMf[self.frame[link]].homogeneous
        return poses

    def outside_limits(self, values: dict[str, float]) -> list[str]:
        """Joints outside their limits."""
        ids = {name: self.model.joints[self.model.getJointId(name)] for name in values}
        low, high = self.model.lowerPositionLimit, self.model.upperPositionLimit
        single = {name: joint.idx_q for name, joint in ids.items() if joint.nq == 1}
        return [name for name, at in single.items() if not low[at] - 1e-9 <= values[name] <= high[at] + 1e-9]

    def between(self, pair: tuple[str, str], poses: dict[str, Floats], limit_m: float) -> Floats:
        """Signed distance of two links in each sample (n,)."""
        a, b = pair
        apart = distances(self.links[a], poses[a], self.links[b], poses[b], limit_m)
        return np.asarray(apart.min(axis=(1, 2)))


def along(a: Floats, b: Floats, most: int) -> Floats:
    """Samples of an edge (n, joints) including both ends; a radian moves points by about a metre."""
    count = int(np.clip(np.abs(b - a).sum() / STEP_M, 8, most))
    return np.asarray(a + (b - a) * np.linspace(0.0, 1.0, count)[:, None])


@dataclass
class Tally:
    """Numbers of checks by kind, and descriptions of the false statements."""

    counts: Counter[str] = field(default_factory=Counter)
    false: list[str] = field(default_factory=list)

    def check(self, kind: str, apart: Floats, least_m: float, what: str) -> None:
        """Records a distance that is less than stated."""
        if apart.size and (least := float(apart.min())) < least_m - ROUNDING_M:
            self.note(kind, f"{what}: {1e3 * least:.4f} mm apart, {1e3 * least_m:.4f} stated")

    def note(self, kind: str, what: str) -> None:
        """Counts a false statement, and prints it at once, so that an interrupted run also reports it."""
        self.counts[f"false {kind}"] += 1
        self.false.append(f"{kind}: {what}")
        print(f"false {self.false[-1]}", file=sys.stderr, flush=True)

    def __str__(self) -> str:
        counts = ", ".join(f"{count} {kind}" for kind, count in sorted(self.counts.items()))
        return f"{counts or 'nothing judged'}, {len(self.false)} false"


class Task:
    """Scenario of the built-in mobile Panda from scenario.yaml, and its world as plans change it."""

    TIP, HAND = "panda_grasptarget", "panda_hand"
    FINGERS = ("panda_leftfinger", "panda_rightfinger")
    OPEN_M = 0.08

    def __init__(self, folder: Path, robot: Robot, mesh: Callable[[str], Any], tally: Tally, most: int) -> None:
        self.robot, self.tally, self.most = robot, tally, most
        self.carrying: dict[str, NDArray[np.bool_]] = {}
        # Links beyond the last joint before the hand: while the fingers rest, they move as one body.
        wrist = robot.model.frames[robot.frame[self.TIP]].parentJoint
        after = [name for name in robot.moved if wrist in robot.model.supports[robot.model.frames[robot.frame[name]].parentJoint]]
        self.moving_as_hand = set(after)
        self.entry = package("yaml").safe_load((folder / "scenario.yaml").read_text())
        root_from_scene: Floats = np.asarray(np.linalg.inv(pose_of(self.entry.get("frame"))), dtype=np.float64)
        self.up = root_from_scene[:3, :3] @ np.array([0.0, 0.0, 1.0])
        bodies = [*self.entry.get("obstacles", []), self.entry["target"]]
        self.things = {body["name"]: Thing.of_body(body, mesh) for body in bodies}
        self.poses: dict[str, Floats] = {body["name"]: root_from_scene @ pose_of(body.get("pose")) for body in bodies}
        if self.entry.get("floor") is not None:
            # Thick enough that its lower face affects no depth.
            below = pose_of({"position": [0.0, 0.0, self.entry["floor"] - 0.5]})
            self.things["floor"] = Thing([(package("coal").Box(20.0, 20.0, 1.0), below)])
            self.poses["floor"] = root_from_scene

    def judge(self, plan: dict[str, Any], target: str, name: str) -> None:
        """Samples all edges of a plan with one pick, and moves the object to the pose at which the plan leaves it."""
        joints, opening_m, was_held = plan["joint_names"], self.OPEN_M, False
        tip_from_object: Floats = np.eye(4)
        margin_m = plan["margins"]["margin_m"]
        resting = {(one["segment"], one["second"]) for one in plan["not_checked"] if one["reason"] == "resting"}
        spared = {target} | {body for _, body in resting}
        named = {frozenset((one["first"], one["second"])) for one in plan["not_checked"]}
        pairs = [pair for pair in self.robot.pairs if frozenset(pair) not in named]
        for segment in plan["segments"]:
            mode, way_points = segment["mode"], np.array(segment["waypoints"])
            where = f"{name}: {mode}"
            supports = {body for at, body in resting if at == mode}
            for q in way_points:
                if outside := self.robot.outside_limits(dict(zip(joints, q, strict=True))):
                    self.tally.note("limits", f"{where}: {outside}")
            held = target if segment["attached"] else None
            was_m, opening_m = opening_m, segment["opening_m"] if held else self.OPEN_M
            if held and not was_held:
                [tip] = self.place(joints, way_points[:1], self.OPEN_M)[self.TIP]
                tip_from_object = np.linalg.inv(tip) @ self.poses[target]
            if was_m != opening_m:
                self.fingers(joints, way_points[0], (was_m, opening_m), target, where)
            was_held = bool(held)
            for body in supports:
                self.carries(body, target, self.place(joints, way_points[[0, -1]], opening_m), tip_from_object, where)
            for k, (a, b) in enumerate(zip(way_points, way_points[1:], strict=False)):
                self.tally.counts["edges, held" if held else "edges, empty"] += 1
                stated_m = segment["clearances_m"][k]
                poses = self.place(joints, along(a, b, self.most), opening_m)
                case = f"{where} edge {k}"
                for pair in pairs:
                    # Links that move together keep their distance: they do not count for the clearance, but may not touch.
                    least_m = 0.0 if self.moving_as_hand.issuperset(pair) else max(stated_m, margin_m)
                    apart = self.robot.between(pair, poses, least_m)
                    self.tally.check("clearance of links", apart, least_m, f"{case}: {pair}")
                self.against_world(poses, held, spared, (stated_m, margin_m), case)
                if held:
                    self.of_held(held, poses, tip_from_object, supports, (stated_m, margin_m), case)
            if mode == "set-down":
                [tip] = self.place(joints, way_points[-1:], opening_m)[self.TIP]
                self.poses[target] = tip @ tip_from_object

    def place(self, joints: list[str], samples: Floats, opening_m: float | Floats) -> dict[str, Floats]:
        """Poses of all links, with the hand opened by this distance."""
        openings = np.broadcast_to(opening_m, len(samples))
        values = [
            {**dict(zip(joints, q, strict=True)), "panda_finger_joint1": 0.5 * wide, "panda_finger_joint2": 0.5 * wide}
            for q, wide in zip(samples, openings, strict=True)
        ]
        return self.robot.poses(values, [*self.robot.links, self.TIP])

    def to(self, thing: Thing, poses: Floats, body: str, limit_m: float) -> Floats:
        """Distances of a body's shapes to those of a body of the world (n, shapes, shapes)."""
        others = np.broadcast_to(self.poses[body], poses.shape)
        return distances(thing, poses, self.things[body], others, limit_m)

    def against_world(
        self,
        poses: dict[str, Floats],
        held: str | None,
        spared: set[str],
        demand: tuple[float, float],
        case: str,
    ) -> None:
        """Checks links against all bodies of the world; the hand has its own margin to the target."""
        stated_m, _ = demand
        for link in self.robot.moved:
            in_hand = link in (self.HAND, *self.FINGERS)
            for body in self.things:
                if body == held:
                    continue
                # The hand has a separate margin to the target and its support, which is 0 here.
                least_m = stated_m if in_hand and body in spared else max(demand)
                apart = self.to(self.robot.links[link], poses[link], body, least_m)
                self.tally.check("clearance of links and world", apart, least_m, f"{case}: {link} and {body}")

    def of_held(
        self,
        held: str,
        poses: dict[str, Floats],
        tip_from_object: Floats,
        supports: set[str],
        demand: tuple[float, float],
        case: str,
    ) -> None:
        """Checks the held object against world and links; only the supporting shape may touch it."""
        thing, at = self.things[held], poses[self.TIP] @ tip_from_object
        for body in self.things:
            if body == held:
                continue
            apart = self.to(thing, at, body, max(demand)).min(axis=1)
            if body in supports:
                carrying, least_m = self.carrying[body], -SUPPORT_M + ROUNDING_M
                self.tally.check("contact of what rests", apart[:, carrying], least_m, f"{case}: {held} in {body}")
                apart = apart[:, ~carrying]
            self.tally.check("clearance of held", apart, max(demand), f"{case}: held {held} and {body}")
        for link in self.robot.moved:
            if link not in self.FINGERS:
                least_m = 0.0 if link in self.moving_as_hand else max(demand)
                apart = distances(self.robot.links[link], poses[link], thing, at, least_m)
                self.tally.check("clearance of held", apart, least_m, f"{case}: {link} and held {held}")

    def carries(self, body: str, held: str, poses: dict[str, Floats], tip_from_object: Floats, where: str) -> None:
        """Finds the shapes of a body that support the object at rest: they are below it, so a lift increases their
        distance."""
        thing, at = self.things[held], poses[self.TIP] @ tip_from_object
        rest = np.argmin([self.to(thing, pose[None], body, 0.1).min() for pose in at])
        apart = self.to(thing, at[rest][None], body, 0.1).min(axis=(0, 1))
        lift_m = 1e-3
        lifted = at[rest].copy()
        lifted[:3, 3] += lift_m * self.up
        freed = self.to(thing, lifted[None], body, 0.1).min(axis=(0, 1))
        touching = apart < RESTING_M
        self.carrying[body] = touching
        self.tally.counts["supports"] += 1
        # The supporting face is within 45 degrees of level.
        if not touching.any() or (freed - apart)[touching].min() < 0.7 * lift_m:
            self.tally.note("support", f"{where}: {body} does not carry {held}: {apart} m apart, {freed} m lifted by 1 mm")

    def fingers(
        self, joints: list[str], q: Floats, openings: tuple[float, float], target: str, where: str
    ) -> None:
        """Checks the fingers against everything except the object between them, while the hand closes or opens."""
        count = 20
        poses = self.place(joints, np.tile(q, (count, 1)), np.linspace(*openings, count, dtype=np.float64))
        self.tally.counts["closings and openings"] += 1
        for link in self.FINGERS:
            for body in self.things:
                if body != target:
                    apart = self.to(self.robot.links[link], poses[link], body, 0.0)
                    self.tally.check("way of a finger", apart, 0.0, f"{where}: {link} and {body}")
