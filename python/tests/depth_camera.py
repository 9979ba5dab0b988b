"""A planar arm under a camera, with a ray caster of boxes in NumPy, which shares no code with Cranny."""

from __future__ import annotations

import cranny
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

ARM = """<robot name="arm"><link name="foot"/>
<link name="upper"><collision><origin xyz="0.2 0 0"/><geometry><box size="0.4 0.05 0.05"/></geometry></collision></link>
<link name="fore"><collision><origin xyz="0.2 0 0"/><geometry><box size="0.4 0.04 0.04"/></geometry></collision></link>
<joint name="shoulder" type="revolute"><parent link="foot"/><child link="upper"/><axis xyz="0 0 1"/>
<limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
<joint name="elbow" type="revolute"><origin xyz="0.42 0 0"/><parent link="upper"/><child link="fore"/><axis xyz="0 0 1"/>
<limit lower="-2" upper="2" velocity="1" effort="1"/></joint></robot>"""

FLOOR = -0.3
"""Height of the floor (m)."""

POST = np.array([0.1, 0.1, 0.4])
"""Lengths of a post that stands on the floor and reaches above the arm (m)."""

SIZE, FOCAL = 320, 220.0
"""Side of the images and focal length, in pixels."""

INTRINSICS = (FOCAL, FOCAL, 0.5 * (SIZE - 1), 0.5 * (SIZE - 1))

REGION = [[-0.3, -0.9, -0.3], [1.0, 0.9, 0.2]]
"""Region that is mapped (m)."""

ABOVE = np.array([[1.0, 0.0, 0.0, 0.35], [0.0, -1.0, 0.0, 0.0], [0.0, 0.0, -1.0, 1.4], [0.0, 0.0, 0.0, 1.0]])
"""Pose of a camera above the arm that looks down."""


def moved(x: float, y: float, z: float) -> Floats:
    """Translation, (4, 4)."""
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


def arm() -> cranny.Robot:
    """Arm of two links in the plane z = 0."""
    return cranny.Robot.from_urdf_text(ARM, tip="fore")


def post_at(x: float, y: float) -> cranny.Body:
    """The post at a place."""
    return cranny.Body.box("post", POST, pose=[x, y, FLOOR + 0.5 * POST[2]])


def image(robot: cranny.Robot, q: list[float], posts: list[tuple[float, float]], pose: Floats = ABOVE, seed: int = 0) -> Floats:
    """Depths (H, W) of floor, posts and arm, with errors drawn within the default bounds of the sensor."""
    boxes = [(moved(x, y, FLOOR + 0.5 * POST[2]), 0.5 * POST) for x, y in posts]
    for link, width in (("upper", 0.05), ("fore", 0.04)):
        boxes.append((robot.fk(q, link) @ moved(0.2, 0.0, 0.0), 0.5 * np.array([0.4, width, width])))
    u, v = np.meshgrid(np.arange(SIZE), np.arange(SIZE))
    rays = np.stack([(u - INTRINSICS[2]) / FOCAL, (v - INTRINSICS[3]) / FOCAL, np.ones((SIZE, SIZE))], axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        down = (rays @ pose[:3, :3].T)[..., 2]
        depth = np.where(down < 0.0, (FLOOR - pose[2, 3]) / down, np.inf)
        for world_from_box, half in boxes:
            box_from_camera = np.linalg.inv(world_from_box) @ pose
            along, begin = rays @ box_from_camera[:3, :3].T, box_from_camera[:3, 3]
            near, far = (-half - begin) / along, (half - begin) / along
            enter, leave = np.minimum(near, far).max(axis=-1), np.maximum(near, far).min(axis=-1)
            hit = (enter <= leave) & (enter > 0.0)
            depth = np.where(hit, np.minimum(depth, enter), depth)
    bound = 0.001 + 0.005 * depth
    return np.asarray(depth + bound * np.random.default_rng(seed).uniform(-0.95, 0.95, depth.shape))
