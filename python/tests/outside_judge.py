"""A judge of plans that knows nothing of Cranny's geometry.

It reads URDF, SRDF, scenario.yaml and plan files itself, has the kinematics from Pinocchio and the distances from Coal, and
samples what was called proven. Only one thing may touch what it should not: the object its support, by 0.1 mm, while it is
lifted off or set down.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from conftest import package
from numpy.typing import NDArray

Floats = NDArray[np.float64]

TOUCHING_M = 1e-5
"""Deeper than this is contact; what is nearer to it is a matter of rounding."""
SUPPORT_M = 1e-4
"""So deep an object may be in what it rests on."""
SAMPLES = 40
"""Places of an edge that are looked at."""


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


def shape_of(entry: dict[str, Any]) -> Any:
    """A shape of scenario.yaml as Coal has it; None for one that only Cranny knows."""
    coal = package("coal")
    if "box" in entry:
        return coal.Box(*[float(size) for size in entry["box"]["size"]])
    if "sphere" in entry:
        return coal.Sphere(float(entry["sphere"]["radius"]))
    for kind in ("cylinder", "capsule"):
        if kind in entry:
            return getattr(coal, kind.capitalize())(float(entry[kind]["radius"]), float(entry[kind]["length"]))
    return None


class Solids:
    """Coal's shapes of one thing, each with its pose in the thing's frame."""

    def __init__(self, shapes: list[tuple[Any, Floats]]) -> None:
        self.shapes = shapes

    @classmethod
    def of_body(cls, entry: dict[str, Any]) -> Solids:
        """A body of scenario.yaml, in its own frame."""
        found = [(shape_of(shape), pose_of(shape.get("pose"))) for shape in entry["shapes"]]
        return cls([(shape, pose) for shape, pose in found if shape is not None])

    def balls(self, pose: Floats) -> tuple[Floats, Floats]:
        """Of each shape at a pose the middle and the radius of a ball around it."""
        for shape, _ in self.shapes:
            shape.computeLocalAABB()
        middles = [pose @ at @ np.append(shape.aabb_center, 1.0) for shape, at in self.shapes]
        return np.array(middles)[:, :3], np.array([shape.aabb_radius for shape, _ in self.shapes])

    def distance(self, pose: Floats, other: Solids, other_pose: Floats) -> float:
        """The signed distance of two things (m), or a centimetre where it is more than that."""
        coal, least = package("coal"), 0.01
        if not self.shapes or not other.shapes:
            return least
        if any(isinstance(shape, coal.Halfspace) for shape, _ in other.shapes):
            near = np.ones((len(self.shapes), len(other.shapes)), dtype=bool)
        else:
            (middles, radii), (others, far) = self.balls(pose), other.balls(other_pose)
            gaps = np.linalg.norm(middles[:, None] - others[None], axis=2) - radii[:, None] - far[None]
            near = gaps < least
        for first, second in zip(*np.nonzero(near), strict=True):
            (a, at), (b, place) = self.shapes[first], other.shapes[second]
            here, there = pose @ at, other_pose @ place
            one, two = (coal.Transform3s(at[:3, :3], at[:3, 3]) for at in (here, there))
            least = min(least, coal.distance(a, one, b, two, coal.DistanceRequest(), coal.DistanceResult()))
        return float(least)


class Robot:
    """A robot from its URDF, and which pairs of links its SRDF declares."""

    def __init__(self, urdf: Path, srdf: Path | None) -> None:
        self.pin, coal = package("pinocchio"), package("coal")
        self.model = self.pin.buildModelFromUrdf(str(urdf))
        kind = self.pin.GeometryType.COLLISION
        geometry = self.pin.buildGeomFromUrdf(self.model, str(urdf), kind, package_dirs=[str(urdf.parent)])
        self.data = self.model.createData()
        self.links: dict[str, tuple[int, Solids]] = {}
        for item in geometry.geometryObjects:
            shape = item.geometry
            if isinstance(shape, coal.BVHModelBase):
                shape.buildConvexHull(True, "Qt")
                shape = shape.convex
            frame = self.model.frames[item.parentFrame]
            # A shape's placement is in the frame of its joint.
            frame_from_shape = (frame.placement.inverse() * item.placement).homogeneous
            self.links.setdefault(frame.name, (item.parentFrame, Solids([])))[1].shapes.append((shape, frame_from_shape))
        disabled = ElementTree.parse(srdf).findall("disable_collisions") if srdf else []
        self.declared = {frozenset((str(pair.get("link1")), str(pair.get("link2")))) for pair in disabled}

    def pairs(self) -> list[tuple[str, str]]:
        """Pairs of links that move against each other and are not declared."""
        names, joint = list(self.links), lambda link: self.model.frames[self.links[link][0]].parentJoint
        pairs = [(a, b) for k, a in enumerate(names) for b in names[:k]]
        return [(a, b) for a, b in pairs if joint(a) != joint(b) and frozenset((a, b)) not in self.declared]

    def place(self, values: dict[str, float]) -> None:
        """Puts all links where joints of these values have them, the others at 0."""
        q = self.pin.neutral(self.model)
        for name, value in values.items():
            joint = self.model.joints[self.model.getJointId(name)]
            q[joint.idx_q : joint.idx_q + joint.nq] = [value] if joint.nq == 1 else [np.cos(value), np.sin(value)]
        self.pin.framesForwardKinematics(self.model, self.data, q)

    def pose(self, link: str) -> Floats:
        """`root_from_link`, (4, 4)."""
        return np.asarray(self.data.oMf[self.model.getFrameId(link)].homogeneous)

    def deepest(self, pairs: list[tuple[str, str]]) -> tuple[float, tuple[str, str]]:
        """The least signed distance of any pair, and the pair."""
        found = [(self.between(*pair), pair) for pair in pairs]
        return min(found)

    def between(self, a: str, b: str) -> float:
        """The signed distance of two links (m)."""
        return self.links[a][1].distance(self.pose(a), self.links[b][1], self.pose(b))


class Task:
    """A scenario of the built-in mobile Panda, as scenario.yaml has it."""

    def __init__(self, folder: Path, robot: Robot, meshes: dict[str, Solids] | None = None) -> None:
        self.robot = robot
        self.entry = package("yaml").safe_load((folder / "scenario.yaml").read_text())
        self.root_from_scene = np.linalg.inv(pose_of(self.entry.get("frame")))
        meshes = meshes or {}
        bodies = [*self.entry.get("obstacles", []), self.entry["target"]]
        self.solids = {body["name"]: meshes.get(body["name"], Solids.of_body(body)) for body in bodies}
        self.poses = {body["name"]: self.root_from_scene @ pose_of(body.get("pose")) for body in bodies}
        self.floor = self.entry.get("floor")
        self.hand = {"panda_hand", "panda_leftfinger", "panda_rightfinger"}
        self.pairs = robot.pairs()
        self.false: list[str] = []
        self.edges = 0

    def judge(self, plan: dict[str, Any], target: str) -> None:
        """Samples every edge of a plan of one step, and leaves the object where the plan puts it."""
        names, opening, tip_from_object = plan["joint_names"], 0.08, None
        for segment in plan["segments"]:
            mode, way_points = segment["mode"], np.array(segment["waypoints"])
            opening = segment.get("opening_m") or (0.08 if mode != "lift-off" else opening)
            if mode == "lift-off" or (segment.get("attached") and tip_from_object is None):
                self.place(names, way_points[0], opening)
                tip_from_object = np.linalg.inv(self.robot.pose("panda_grasptarget")) @ self.poses[target]
            held = target if segment.get("attached") else None
            for a, b in zip(way_points, way_points[1:], strict=False):
                self.edges += 1
                for share in np.linspace(0.0, 1.0, SAMPLES):
                    self.place(names, a + (b - a) * share, opening)
                    if held:
                        self.poses[held] = self.robot.pose("panda_grasptarget") @ tip_from_object
                    self.look(mode, held, target)
            if mode == "retreat":
                tip_from_object = None

    def place(self, names: list[str], q: Floats, opening_m: float) -> None:
        fingers = {f"panda_finger_joint{k}": 0.5 * opening_m for k in (1, 2)}
        self.robot.place({**dict(zip(names, q, strict=True)), **fingers})

    def look(self, mode: str, held: str | None, target: str) -> None:
        """Notes what touches at the configuration at hand."""
        depth, pair = self.robot.deepest(self.pairs)
        self.note(depth, TOUCHING_M, f"{mode}: {pair}")
        moved = [link for link in self.robot.links if self.robot.model.frames[self.robot.links[link][0]].parentJoint > 0]
        for link in moved:
            for body, solids in self.solids.items():
                # The pads close on the object, and begin to open on it.
                if body == target and link in self.hand and mode != "reach" and mode != "return":
                    continue
                distance = self.robot.links[link][1].distance(self.robot.pose(link), solids, self.poses[body])
                self.note(distance, TOUCHING_M, f"{mode}: {link} and {body}")
        if held is None:
            return
        near = {
            body: self.solids[held].distance(self.poses[held], solids, self.poses[body])
            for body, solids in self.solids.items()
            if body != held and solids.shapes
        }
        if self.floor is not None:
            corners = package("coal").Halfspace(np.array([0.0, 0.0, 1.0]), float(self.floor))
            floor = Solids([(corners, np.eye(4))])
            near["floor"] = self.solids[held].distance(self.poses[held], floor, self.root_from_scene)
        # What it rests on is right below it; nothing else is.
        rests = mode in ("lift-off", "set-down")
        for body, distance in near.items():
            below = rests and self.is_below(body, held)
            self.note(distance, SUPPORT_M + 1e-6 if below else TOUCHING_M, f"{mode}: held {held} and {body}")
        for link in moved:
            if link not in self.hand:
                distance = self.robot.links[link][1].distance(self.robot.pose(link), self.solids[held], self.poses[held])
                self.note(distance, TOUCHING_M, f"{mode}: {link} and held {held}")

    def is_below(self, body: str, held: str) -> bool:
        """Whether a body is lower than the middle of what is held, right under it."""
        if body == "floor":
            return True
        down = self.root_from_scene[:3, :3] @ np.array([0.0, 0.0, -1.0])
        coal = package("coal")
        probe = Solids([(coal.Sphere(1e-3), np.eye(4))])
        for depth in np.linspace(0.0, 0.5, 501):
            at = np.eye(4)
            at[:3, 3] = self.poses[held][:3, 3] + depth * down
            if probe.distance(at, self.solids[body], self.poses[body]) <= 0.0:
                return True
        return False

    def note(self, distance: float, allowed_m: float, what: str) -> None:
        if distance < -allowed_m:
            self.false.append(f"{what}: {-1e3 * distance:.3f} mm deep")
