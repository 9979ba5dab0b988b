"""Collision verdicts compared with Coal's convex shapes and primitives, on random configurations of all released scenarios.

Coal gets the robot from the URDF through Pinocchio, with convex hulls as link meshes, the bodies of the world by their
kinds and sizes, and the list of checked link pairs. Contact begins below 10 µm here and below 0 in Coal, so
disagreements within 0.1 mm of contact do not count. All others are decided by triangles in rational numbers
(exact_triangles.py) and listed; none may be Cranny's fault.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cranny
import numpy as np
import pytest
from conftest import ROBOTS, Reference, package, released_folder
from exact_triangles import Mesh, meshes_touch
from numpy.typing import NDArray

CONFIGURATIONS = 10_000
NEAR_M = 1e-4
"""Disagreements closer to contact than this are within tolerance."""

IDS = [f"0{environment}{level}" for environment in range(1, 5) for level in range(1, 6)]


class CoalCell:
    """Coal's model of a robot in a world."""

    def __init__(self, reference: Reference, cell: cranny.Cell) -> None:
        self.coal, self.pin = package("coal"), reference.pin
        self.reference, self.model = reference, reference.model
        self.geometry = self.pin.GeometryModel()
        self.links: dict[str, list[int]] = {}
        for item in reference.geometry.geometryObjects:
            link = self.model.frames[item.parentFrame].name
            shape = item.geometry
            if isinstance(shape, self.coal.BVHModelBase) and link not in reference.solid_meshes:
                shape.buildConvexHull(True, "Qt")
                shape = shape.convex
            placed = self.pin.GeometryObject(item.name, item.parentJoint, item.parentFrame, item.placement, shape)
            self.links.setdefault(link, []).append(self.geometry.addGeometryObject(placed))
        self.bodies: dict[str, list[int]] = {}
        for body in cell.world:
            for number, (shape, pose) in enumerate(self.shapes(body)):
                name = f"{body.name}/{number}"
                placed = self.pin.GeometryObject(name, 0, 0, self.pin.SE3(pose), shape)
                self.bodies.setdefault(body.name, []).append(self.geometry.addGeometryObject(placed))
        moved = [link for link in self.links if self.geometry.geometryObjects[self.links[link][0]].parentJoint > 0]
        pairs = [(self.links[link], body) for link in moved for body in self.bodies.values()]
        pairs += [(self.links[a], self.links[b]) for a, b in cell.self_pairs]
        for first, second in pairs:
            for a in first:
                for b in second:
                    self.geometry.addCollisionPair(self.pin.CollisionPair(a, b))
        self.data, self.geometry_data = self.model.createData(), self.pin.GeometryData(self.geometry)

    def shapes(self, body: cranny.Body) -> Iterator[tuple[Any, NDArray[np.float64]]]:
        """Coal's shapes of a body with their poses."""
        for kind, sizes, pose in zip(body.kinds, body.sizes, body.poses, strict=True):
            if kind == "box":
                yield self.coal.Box(*sizes), pose
            elif kind == "sphere":
                yield self.coal.Sphere(*sizes), pose
            elif kind in ("cylinder", "capsule"):
                yield getattr(self.coal, kind.capitalize())(*sizes), pose
            elif kind == "floor":
                yield self.coal.Halfspace(np.array([0.0, 0.0, 1.0]), 0.0), pose
        if "mesh" in body.kinds:
            vertices, faces = body.triangles()
            mesh = self.coal.BVHModelOBBRSS()
            mesh.beginModel(len(faces), len(vertices))
            mesh.addVertices(vertices)
            mesh.addTriangles(faces)
            mesh.endModel()
            yield mesh, np.eye(4)

    def touches(self, q: NDArray[np.float64]) -> bool:
        """Whether any pair touches."""
        return bool(
            self.pin.computeCollisions(
                self.model, self.data, self.geometry, self.geometry_data, self.reference.configuration(q), True
            )
        )

    def distances(self, q: NDArray[np.float64]) -> list[tuple[float, int, int]]:
        """Signed distance (m) of every pair, nearest first, with the numbers of the two geometries."""
        self.pin.computeDistances(
            self.model, self.data, self.geometry, self.geometry_data, self.reference.configuration(q)
        )
        found = [
            (float(result.min_distance), pair.first, pair.second)
            for result, pair in zip(
                self.geometry_data.distanceResults, self.geometry.collisionPairs, strict=True
            )
        ]
        return sorted(found)

    def mesh(self, number: int) -> Mesh | None:
        """Triangles of a geometry at the last configuration, in the root frame; None for curved shapes."""
        shape = self.geometry.geometryObjects[number].geometry
        placement = self.geometry_data.oMg[number]
        if isinstance(shape, self.coal.Box):
            half = np.asarray(shape.halfSide).ravel()
            vertices = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * half
            faces = np.array(BOX_FACES)
        elif isinstance(shape, self.coal.BVHModelBase):
            vertices = np.array([shape.vertex(k) for k in range(shape.num_vertices)])
            faces = np.array([[shape.tri_indices(k)[c] for c in range(3)] for k in range(shape.num_tris)])
        elif isinstance(shape, self.coal.ConvexBase):
            vertices = np.array([shape.point(k) for k in range(shape.num_points)])
            faces = np.array([[shape.polygons(k)[c] for c in range(3)] for k in range(shape.num_polygons)])
        else:
            return None
        moved = vertices.reshape(-1, 3) @ placement.rotation.T + placement.translation
        return np.asarray(moved, dtype=np.float64), np.asarray(faces, dtype=np.int64)


BOX_FACES = [
    [0, 1, 3], [0, 3, 2], [4, 7, 5], [4, 6, 7], [0, 5, 1], [0, 4, 5],
    [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3],
]  # fmt: skip
"""Triangles of a box whose corners are ordered by their coordinates."""


def settled(cell: cranny.Cell, coal_cell: CoalCell, q: NDArray[np.float64]) -> list[dict[str, Any]]:
    """Correct verdict on each pair on which the two checks disagree by more than 0.1 mm from contact."""
    touching = {(contact.first, contact.second) for contact in cell.contacts(q)}
    name_of = {number: name for group in (coal_cell.links, coal_cell.bodies) for name in group for number in group[name]}
    # A link and a body count as one pair, regardless of their numbers of solids.
    nearest: dict[tuple[str, str], float] = {}
    solids: dict[tuple[str, str], list[tuple[int, int]]] = {}
    for distance, first, second in coal_cell.distances(q):
        pair = name_of[first], name_of[second]
        nearest.setdefault(pair, distance)
        solids.setdefault(pair, []).append((first, second))
    settled = []
    for (a, b), distance in nearest.items():
        here = (a, b) in touching or (b, a) in touching
        if here == (distance <= 0.0) or abs(distance) < NEAR_M:
            continue
        meshes = [(coal_cell.mesh(first), coal_cell.mesh(second)) for first, second in solids[a, b]]
        flat = [(s, t) for s, t in meshes if s is not None and t is not None]
        truth = any(meshes_touch(s, t) for s, t in flat) if len(flat) == len(meshes) else None
        settled.append({"q": q.tolist(), "pair": [a, b], "coal_m": distance, "cranny": here, "triangles": truth})
    return settled


def compare(cell: cranny.Cell, coal_cell: CoalCell, configurations: NDArray[np.float64]) -> list[dict[str, Any]]:
    """All disagreements more than 0.1 mm from contact, with the correct verdicts."""
    verdicts = cell.is_free(configurations)
    disagreements: list[dict[str, Any]] = []
    for q, is_free in zip(configurations, verdicts, strict=True):
        if bool(is_free) == coal_cell.touches(q):
            disagreements += settled(cell, coal_cell, q)
    return disagreements


def report(name: str, disagreements: list[dict[str, Any]]) -> None:
    """Lists disagreements on the terminal, and in the folder named by CRANNY_DISAGREEMENTS."""
    for one in disagreements:
        print(f"{name}: {one}")
    folder = os.environ.get("CRANNY_DISAGREEMENTS")
    if folder:
        (Path(folder) / f"{name}.json").write_text(json.dumps(disagreements, indent=1))


@pytest.mark.parametrize("scenario_id", IDS)
def test_verdicts_in_a_released_scenario_agree_with_coal(scenario_id: str) -> None:
    released = released_folder()
    scenario = cranny.Scenario.load(released / "scenarios" / scenario_id)
    urdf = released / "robots/franka_panda/mobile_panda.urdf"
    fingers = {f"panda_finger_joint{k}": 0.04 for k in (1, 2)}
    cell = scenario.cell()
    coal_cell = CoalCell(Reference(urdf, scenario.robot, fingers), cell)
    configurations = scenario.robot.sample(CONFIGURATIONS, seed=int(scenario_id))
    # Half of them are near the start, where the robot is mostly free.
    span = scenario.robot.upper - scenario.robot.lower
    near = scenario.start + 0.15 * span * (configurations[1::2] - scenario.robot.lower) / span - 0.075 * span
    configurations[1::2] = np.clip(near, scenario.robot.lower, scenario.robot.upper)
    verdicts = cell.is_free(configurations)
    assert 0.05 < verdicts.mean() < 0.95, "a test in which everything or nothing is free shows little"
    disagreements = compare(cell, coal_cell, configurations)
    report(scenario_id, disagreements)
    wrong = [one for one in disagreements if one["triangles"] != one["cranny"]]
    assert not wrong, f"Cranny is wrong, or nobody knows: {wrong}"


@pytest.mark.parametrize("name", ["ur5_like", "fetch_like"])
def test_verdicts_among_primitives_agree_with_coal(name: str) -> None:
    urdf = ROBOTS / f"{name}.urdf"
    robot = cranny.Robot.from_urdf(urdf)
    tilted = np.eye(4)
    tilted[:3, :3] = [[0.8, -0.6, 0.0], [0.48, 0.64, -0.6], [0.36, 0.48, 0.8]]
    tilted[:3, 3] = [0.5, 0.4, 0.6]
    bodies = [
        cranny.Body.box("block", [0.3, 0.5, 0.2], pose=tilted),
        cranny.Body.sphere("ball", 0.15, pose=[-0.5, 0.3, 0.7]),
        cranny.Body.cylinder("post", 0.08, length=1.2, pose=[0.4, -0.5, 0.6]),
        cranny.Body.capsule("rail", 0.05, length=0.8, pose=[-0.4, -0.6, 0.5]),
        cranny.Body.floor(-0.2),
    ]
    cell = cranny.Cell(robot, bodies)
    coal_cell = CoalCell(Reference(urdf, robot), cell)
    configurations = robot.sample(CONFIGURATIONS, seed=11)
    assert 0.01 < cell.is_free(configurations).mean() < 0.99
    disagreements = compare(cell, coal_cell, configurations)
    report(name, disagreements)
    assert not disagreements


def test_the_exact_test_of_triangles_knows_boxes_and_their_insides() -> None:
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=np.float64)
    faces = np.array(BOX_FACES)

    def box(half: float, x: float) -> Mesh:
        return corners * half + [x, 0.0, 0.0], faces

    assert meshes_touch(box(1.0, 0.0), box(1.0, 1.5))
    assert meshes_touch(box(1.0, 0.0), box(1.0, 2.0)), "faces that only meet"
    assert not meshes_touch(box(1.0, 0.0), box(1.0, np.nextafter(2.0, 3.0)))
    assert meshes_touch(box(1.0, 0.0), box(0.1, 0.3)), "one inside the other"
    assert not meshes_touch(box(1.0, 0.0), box(0.1, 5.0))
