"""Trajectories as ROS 2 messages, without ROS: dictionaries and YAML of `trajectory_msgs/JointTrajectory`.

>>> import cranny
>>> message = cranny.ros.joint_trajectory(cranny.plan(cranny.Scenario("021")), rate=50)
>>> sorted(message)
['header', 'joint_names', 'points']
"""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cranny._cranny import Plan, Samples

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
    """Positions (T, dof) in m and rad, one column per joint, with the joints' names. All functions of this package that
    accept configurations reorder the columns by these names for their robot, and refuse unknown and missing joints.
    `numpy.asarray(positions)` has the columns in the original order; `in_order_of` reorders them."""

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
