"""ROS 2 messages without ROS: trajectories as dictionaries and YAML of `trajectory_msgs/JointTrajectory`, and arrays of
`sensor_msgs/PointCloud2`, `Image` and `CameraInfo` in dictionaries.

>>> import cranny
>>> message = cranny.ros.joint_trajectory(cranny.plan(cranny.Scenario("021")), rate=50)
>>> sorted(message)
['header', 'joint_names', 'points']
"""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from operator import index
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cranny._cranny import DepthView, Plan, Samples, _points_of_message

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

NANOSECONDS = 1_000_000_000
"""Nanoseconds in a second."""


def duration(seconds: float) -> dict[str, int]:
    """`builtin_interfaces/Duration` with whole seconds and remaining nanoseconds."""
    sec, nanosec = divmod(round(seconds * NANOSECONDS), NANOSECONDS)
    return {"sec": sec, "nanosec": nanosec}


def joint_trajectory(plan: Plan, rate: float = 100.0, *, frame_id: str = "") -> dict[str, Any]:
    """`trajectory_msgs/JointTrajectory` of a plan, sampled at `rate` (Hz): a dictionary of plain lists and numbers for
    `rosidl_runtime_py.set_message_fields`. Contains positions in m or rad and their first two derivatives."""
    return of_samples(plan.sample(rate), frame_id=frame_id)


def task(plan: Plan, rate: float = 100.0, *, frame_id: str = "") -> list[tuple[str, dict[str, Any]]]:
    """Messages of a plan in the order in which to send them, each after the previous one has been executed: pairs of
    "arm" and a `trajectory_msgs/JointTrajectory`, or "gripper" and a `control_msgs/GripperCommand` (`position`, the
    distance between the fingers, in m; `max_effort` in N). A plan that carries its target opens the hand, reaches,
    closes it and moves on; any other plan has only its path to the grasp."""
    ways = [("arm", of_samples(samples, frame_id=frame_id)) for samples in plan.sample_ways(rate)]
    closing = plan._closing()
    if closing is None:
        return ways
    openings, force = closing
    hand = [("gripper", {"position": opening, "max_effort": force}) for opening in openings]
    return [step for pair in zip(hand, ways, strict=True) for step in pair]


FRANKA_LEAST_N = 30.0
"""Approximate least gripping force (N) of a Franka hand, even if less is requested (libfranka, issue 111)."""
FRANKA_MOST_N = 70.0
"""Greatest continuous gripping force (N) of a Franka hand."""


def franka_task(
    plan: Plan, rate: float = 100.0, *, frame_id: str = "", speed: float = 0.1, tolerance: float = 0.005
) -> list[tuple[str, dict[str, Any]]]:
    """Messages like those of `task` for a Franka hand: pairs of "arm" and a `trajectory_msgs/JointTrajectory`, "move" and a
    `franka_msgs/action/Move` goal (`width` in m, `speed` in m/s), or "grasp" and a `franka_msgs/action/Grasp` goal (`width`
    of the object between the fingers, `epsilon` with `inner` and `outer` (m), `speed`, and `force` (N)).

    A grasp that ends outside `width - inner` to `width + outer` fails, and the hand opens again; `tolerance` sets both. The
    force is the one for which the plan's hold was computed; ValueError unless it is from `FRANKA_LEAST_N` to
    `FRANKA_MOST_N`, and `speed` and `tolerance` are positive."""
    closing = plan._closing()
    steps = task(plan, rate, frame_id=frame_id)
    if closing is None:
        return steps
    openings, force = closing
    if not FRANKA_LEAST_N <= force <= FRANKA_MOST_N:
        raise ValueError(f"the plan's hand closes with {force} N, a Franka hand with {FRANKA_LEAST_N} to {FRANKA_MOST_N} N")
    if not (0.0 < speed and 0.0 < tolerance):
        raise ValueError(f"speed is {speed} m/s and tolerance {tolerance} m; both must be above 0")
    widest = max(openings)

    def of_hand(width: float) -> tuple[str, dict[str, Any]]:
        if width >= widest:
            return "move", {"width": width, "speed": speed}
        epsilon = {"inner": tolerance, "outer": tolerance}
        return "grasp", {"width": width, "epsilon": epsilon, "speed": speed, "force": force}

    return [of_hand(message["position"]) if whom == "gripper" else (whom, message) for whom, message in steps]


def of_samples(samples: Samples, *, frame_id: str = "") -> dict[str, Any]:
    """`trajectory_msgs/JointTrajectory` of existing samples, as `joint_trajectory` returns it."""
    rows = zip(samples.times, samples.positions, samples.velocities, samples.accelerations, strict=True)
    return {
        "header": {"stamp": duration(0.0), "frame_id": frame_id},
        "joint_names": list(samples.joint_names),
        "points": [
            {
                "positions": position.tolist(),
                "velocities": velocity.tolist(),
                "accelerations": acceleration.tolist(),
                "effort": [],
                "time_from_start": duration(float(time)),
            }
            for time, position, velocity, acceleration in rows
        ],
    }


class JointPositions:
    """Positions (T, dof) in m and rad, one column per joint, with the joints' names. Functions of this package that know the
    robot (arguments `q`, `path`, `start`, `goals`, `carry`, …, and the path of your own planner) reorder the columns by these
    names, and refuse unknown and missing joints; where one configuration is expected, a single row is one. DepthView, which
    knows no robot, and `settings` of a planner refuse them: give `in_order_of(robot.joint_names)`.
    `numpy.asarray(positions)` has the columns in the original order."""

    def __init__(self, joint_names: Sequence[str], values: ArrayLike) -> None:
        import numpy as np

        self.joint_names = tuple(joint_names)
        self._values = np.array(values, dtype=np.float64)
        if len(set(self.joint_names)) < len(self.joint_names):
            raise ValueError(f"a joint is named twice: {', '.join(self.joint_names)}")
        if self._values.ndim != 2 or self._values.shape[1] != len(self.joint_names):
            raise ValueError(f"positions of shape {self._values.shape} for {len(self.joint_names)} joint names")

    def in_order_of(self, joint_names: Sequence[str]) -> NDArray[np.float64]:
        """Positions (T, dof) with one column for each of these joints, in their order."""
        expected = list(joint_names)
        if set(expected) != set(self.joint_names):
            here = ", ".join(self.joint_names)
            raise ValueError(f"the positions are of joints {here}, but the robot has {', '.join(expected)}")
        return self._values[:, [self.joint_names.index(name) for name in expected]]

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of instants and joints."""
        instants, joints = self._values.shape
        return instants, joints

    def tolist(self) -> list[list[float]]:
        """Lists of the values, with columns in the original order."""
        rows: list[list[float]] = self._values.tolist()
        return rows

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[np.float64]:
        array = self._values.copy()
        return array if dtype is None else array.astype(dtype)

    def __len__(self) -> int:
        return len(self._values)

    def __getitem__(self, rows: slice) -> JointPositions:
        if not isinstance(rows, slice):
            raise TypeError("rows are taken by a slice; numpy.asarray(positions) has the values without their names")
        return JointPositions(self.joint_names, self._values[rows])

    def __repr__(self) -> str:
        return f"JointPositions({', '.join(self.joint_names)}: {len(self)} instants)"


def positions_of(message: dict[str, Any]) -> tuple[NDArray[np.float64], JointPositions]:
    """Times (T,) in seconds and positions (T, dof) of such a message from any source, with the names of its joints, by
    which `cranny.verify_path` puts them into the order of its robot. Decreasing times raise ValueError."""
    import numpy as np

    names, points = list(message["joint_names"]), message["points"]
    stamps = [point["time_from_start"] for point in points]
    times = np.array([stamp["sec"] + stamp["nanosec"] / NANOSECONDS for stamp in stamps], dtype=np.float64)
    for index, point in enumerate(points):
        if len(point["positions"]) != len(names):
            raise ValueError(f"points[{index}] has {len(point['positions'])} positions for {len(names)} joint names")
    if back := [index for index in range(1, len(times)) if not times[index] >= times[index - 1]]:
        raise ValueError(f"points[{back[0]}] is at {times[back[0]]} s, before the point that it follows")
    rows = np.array([point["positions"] for point in points], dtype=np.float64).reshape(len(points), len(names))
    return times, JointPositions(names, rows)


def points_of(message: dict[str, Any]) -> tuple[NDArray[np.float32], int]:
    """Points (N, 3) in metres of a `sensor_msgs/PointCloud2`, in the frame of the message, and the number of those that were dropped
    because a coordinate is not finite. Fields of any type, order and padding; sizes that contradict each other, missing
    coordinates and a cloud without a valid point raise ValueError."""
    try:
        fields = [
            (str(field["name"]), index(field["offset"]), index(field["datatype"]), index(field["count"]))
            for field in _entry(message, "fields", "PointCloud2")
        ]
        numbers = [index(_entry(message, key, "PointCloud2")) for key in ("height", "width", "point_step", "row_step")]
    except TypeError as reason:
        raise ValueError(f"PointCloud2: a size, an offset or the list of fields is none: {reason}") from None
    sizes = numbers + [number for field in fields for number in field[1:]]
    if any(not 0 <= number < 2**32 for number in sizes) or any(field[2] > 255 for field in fields):
        raise ValueError("PointCloud2: a size or an offset is out of range")
    height, width, point_step, row_step = numbers
    is_bigendian = _entry(message, "is_bigendian", "PointCloud2")
    if is_bigendian not in (False, True):
        raise ValueError(f"PointCloud2: is_bigendian is {is_bigendian!r}, but must be true or false")
    data = _bytes(_entry(message, "data", "PointCloud2"), "PointCloud2")
    try:
        return _points_of_message(height, width, fields, bool(is_bigendian), point_step, row_step, data)
    except ValueError as reason:
        raise ValueError(f"PointCloud2: {reason}") from None


DEPTH_ENCODINGS = {"32FC1": "f4", "16UC1": "u2", "mono16": "u2"}
"""Encodings of depth images, and the types of their pixels: metres in floats, millimetres in whole numbers (REP 118)."""


def depth_of(message: dict[str, Any]) -> NDArray[Any]:
    """Depths (H, W) of a `sensor_msgs/Image`: float32 in metres (`32FC1`) or uint16 in millimetres (`16UC1`, `mono16`), as
    `cranny.World.from_depth` reads them. Rows may be padded, and the bytes in either order; another encoding or data of another
    size raises ValueError."""
    import numpy as np

    height, width, step = (int(_entry(message, key, "Image")) for key in ("height", "width", "step"))
    encoding = _entry(message, "encoding", "Image")
    if encoding not in DEPTH_ENCODINGS:
        known = ", ".join(DEPTH_ENCODINGS)
        raise ValueError(f"Image: the encoding is '{encoding}', but depths have one of {known}")
    kind = np.dtype(DEPTH_ENCODINGS[encoding]).newbyteorder(">" if _entry(message, "is_bigendian", "Image") else "<")
    data = _bytes(_entry(message, "data", "Image"), "Image")
    if height < 1 or width < 1 or step < width * kind.itemsize or len(data) != height * step:
        raise ValueError(
            f"Image: {height} rows of {step} bytes are announced for {width} pixels of {kind.itemsize} bytes, but the data has "
            f"{len(data)} bytes"
        )
    rows = np.frombuffer(data, dtype=np.uint8).reshape(height, step)[:, : width * kind.itemsize]
    return np.ascontiguousarray(rows).view(kind).astype(kind.newbyteorder("="))


def intrinsics_of(message: dict[str, Any], *, rectified: bool = False) -> NDArray[np.float64]:
    """Camera matrix (3, 3) of a `sensor_msgs/CameraInfo` (keys of ROS 2 or 1): `k`, or with `rectified`, for images of which
    `image_proc` has removed the distortion, the left part of `p`. The image of a region of interest has the principal point of
    that region.

    ValueError for a camera with distortion unless `rectified`, one that is not calibrated, or binning, after which drivers differ
    in the centres of the pixels."""
    import numpy as np

    def entry(name: str) -> Any:
        return _entry(message, name if name in message or name.upper() not in message else name.upper(), "CameraInfo")

    distortion = np.asarray(entry("d"), dtype=np.float64)
    if not rectified and distortion.any():
        raise ValueError(
            f"CameraInfo: the camera has distortion (d = {distortion.tolist()}), and a depth image of it is no pinhole's: rectify "
            "the images (image_proc) and give rectified=True"
        )
    width, height = (int(entry(key)) for key in ("width", "height"))
    if any(int(message.get(f"binning_{axis}", 0)) > 1 for axis in "xy"):
        raise ValueError("CameraInfo: the image is binned; give the intrinsics of the binned image instead")
    matrix = np.asarray(entry("p" if rectified else "k"), dtype=np.float64)
    if matrix.size != (12 if rectified else 9):
        raise ValueError(f"CameraInfo: a matrix has {matrix.size} numbers, but {12 if rectified else 9} are expected")
    matrix = matrix.reshape(3, -1)[:, :3].copy()
    if not (matrix[0, 0] > 0.0 and matrix[1, 1] > 0.0):
        raise ValueError(f"CameraInfo: the focal lengths are {matrix[0, 0]} and {matrix[1, 1]}: the camera is not calibrated")
    left, top, wide, high = _region(message, width, height)
    if left < 0 or top < 0 or left + wide > width or top + high > height:
        raise ValueError(f"CameraInfo: the region of interest is not within the image of {width} × {height} pixels")
    matrix[0, 2] -= left
    matrix[1, 2] -= top
    return matrix


def depth_view(
    image: dict[str, Any],
    info: dict[str, Any],
    pose: ArrayLike,
    *,
    rectified: bool = False,
    name: str = "view",
    scale: float | None = None,
    q: ArrayLike | None = None,
    **sensor: float,
) -> DepthView:
    """View of a `sensor_msgs/Image` of depths with its `CameraInfo`, for `cranny.World`. `pose`: `world_from_camera`, (4, 4), of the
    optical frame that both messages name; look it up with `tf2` at the stamp of the image. `rectified`: as in `intrinsics_of`;
    the other keywords: those of DepthView. ValueError if the messages differ in their sizes or frames."""
    depth = depth_of(image)
    _, _, width, height = _region(info, int(_entry(info, "width", "CameraInfo")), int(_entry(info, "height", "CameraInfo")))
    if depth.shape != (height, width):
        raise ValueError(
            f"the image has {depth.shape[1]} × {depth.shape[0]} pixels, but its CameraInfo is for {width} × {height}"
        )
    frames = [message.get("header", {}).get("frame_id", "") for message in (image, info)]
    if frames[0] != frames[1]:
        raise ValueError(f"the image is in the frame '{frames[0]}', but its CameraInfo in '{frames[1]}'")
    matrix = intrinsics_of(info, rectified=rectified)
    return DepthView(depth, matrix, pose, name=name, scale=scale, q=q, **sensor)


def _region(info: dict[str, Any], width: int, height: int) -> tuple[int, int, int, int]:
    """Offset and size of the image in the whole one: all of it unless a region of interest is stated."""
    roi = info.get("roi") or {}
    left, top, wide, high = (int(roi.get(key, 0)) for key in ("x_offset", "y_offset", "width", "height"))
    return left, top, wide or width, high or height


def _entry(message: dict[str, Any], key: str, kind: str) -> Any:
    try:
        return message[key]
    except KeyError:
        raise ValueError(f"{kind}: there is no '{key}' in the message") from None


def _bytes(data: Any, kind: str) -> bytes:
    """Bytes of an array of `uint8` in a dictionary: bytes, a NumPy array or a list of numbers."""
    if isinstance(data, int) or getattr(data, "itemsize", 1) != 1:
        raise ValueError(f"{kind}: the data is no list of bytes")
    try:
        return bytes(data)
    except (TypeError, ValueError) as reason:
        raise ValueError(f"{kind}: the data is no list of bytes ({reason})") from None


def yaml_text(message: dict[str, Any]) -> str:
    """YAML of the message, as `ros2 topic pub` accepts and `ros2 topic echo` prints it."""
    return "\n".join(_lines(message, "")) + "\n"


def save_yaml(message: dict[str, Any], path: str | os.PathLike[str]) -> None:
    """Writes the message as YAML."""
    Path(path).write_text(yaml_text(message), encoding="utf-8")


def _lines(value: dict[str, Any], indent: str) -> list[str]:
    lines = []
    for key, entry in value.items():
        if isinstance(entry, dict):
            lines += [f"{indent}{key}:", *_lines(entry, indent + "  ")]
        elif isinstance(entry, list) and entry and isinstance(entry[0], dict):
            lines.append(f"{indent}{key}:")
            for item in entry:
                first, *rest = _lines(item, indent + "  ")
                lines += [f"{indent}- {first.removeprefix(indent + '  ')}", *rest]
        else:
            # Numbers, strings and lists of them have the same form in JSON and YAML.
            lines.append(f"{indent}{key}: {json.dumps(entry)}")
    return lines
