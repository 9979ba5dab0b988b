"""Trajectories as ROS 2 has them, without ROS: dictionaries and YAML of `trajectory_msgs/JointTrajectory`.

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
    """`builtin_interfaces/Duration`: whole seconds and the nanoseconds beyond them."""
    sec, nanosec = divmod(round(seconds * NANOSECONDS), NANOSECONDS)
    return {"sec": sec, "nanosec": nanosec}


def joint_trajectory(plan: Plan, rate: float = 100.0, *, frame_id: str = "") -> dict[str, Any]:
    """A `trajectory_msgs/JointTrajectory` of a plan, sampled at `rate` (Hz): a dictionary of plain lists and numbers,
    which `rosidl_runtime_py.set_message_fields` takes. Positions in m or rad, and their first two derivatives."""
    return of_samples(plan.sample(rate), frame_id=frame_id)


def task(plan: Plan, rate: float = 100.0, *, frame_id: str = "") -> list[tuple[str, dict[str, Any]]]:
    """What to send to whom, one after the other, each once the one before has ended: pairs of "arm" and a
    `trajectory_msgs/JointTrajectory`, or "gripper" and a `control_msgs/GripperCommand` (`position`, between the fingers, in
    m; `max_effort` in N). A plan that carries its target opens the hand, reaches, closes, and goes on; another one is its
    way to the grasp."""
    ways = [("arm", of_samples(samples, frame_id=frame_id)) for samples in plan.sample_ways(rate)]
    closing = plan._closing()
    if closing is None:
        return ways
    openings, force = closing
    hand = [("gripper", {"position": opening, "max_effort": force}) for opening in openings]
    return [step for pair in zip(hand, ways, strict=True) for step in pair]


FRANKA_LEAST_N = 30.0
"""What a Franka hand presses with whatever less it is asked for, about (libfranka, issue 111)."""
FRANKA_MOST_N = 70.0
"""What it can press with for long."""


def franka_task(
    plan: Plan, rate: float = 100.0, *, frame_id: str = "", speed: float = 0.1, tolerance: float = 0.005
) -> list[tuple[str, dict[str, Any]]]:
    """The same for a Franka hand: pairs of "arm" and a `trajectory_msgs/JointTrajectory`, "move" and a goal of
    `franka_msgs/action/Move` (`width` in m, `speed` in m/s), or "grasp" and one of `franka_msgs/action/Grasp`: `width` of
    the object between the fingers, `epsilon` with `inner` and `outer` (m), `speed` and `force` (N).

    A grasp that ends outside of width - inner to width + outer counts as failed, and the hand opens again: `tolerance` is
    for both. The force is that by which the plan's hold was computed; a hand that does not press with it, from
    `FRANKA_LEAST_N` to `FRANKA_MOST_N`, is refused."""
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
    """The same of samples that are there already."""
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
    """Positions (T, dof) in m and rad with the names of their joints, one a column. Everything in this package that takes
    configurations puts the columns into the order of its robot by these names, and refuses names that the robot does not
    have and joints without a name. `numpy.asarray(positions)` has the columns as they came; `in_order_of` reorders them."""

    def __init__(self, joint_names: Sequence[str], values: ArrayLike) -> None:
        import numpy as np

        self.joint_names = tuple(joint_names)
        self._values = np.array(values, dtype=np.float64)
        if len(set(self.joint_names)) < len(self.joint_names):
            raise ValueError(f"a joint is named twice: {', '.join(self.joint_names)}")
        if self._values.ndim != 2 or self._values.shape[1] != len(self.joint_names):
            raise ValueError(f"positions of shape {self._values.shape} for {len(self.joint_names)} joint names")

    def in_order_of(self, joint_names: Sequence[str]) -> NDArray[np.float64]:
        """The same, (T, dof), with one column for each of these joints, in their order."""
        expected = list(joint_names)
        if set(expected) != set(self.joint_names):
            here = ", ".join(self.joint_names)
            raise ValueError(f"the positions are of joints {here}, but the robot has {', '.join(expected)}")
        return self._values[:, [self.joint_names.index(name) for name in expected]]

    @property
    def shape(self) -> tuple[int, int]:
        """Instants and joints."""
        instants, joints = self._values.shape
        return instants, joints

    def tolist(self) -> list[list[float]]:
        """Lists of the values, the columns as they came."""
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
    """Times (T,) in seconds and positions (T, dof) of such a message, from anybody, with the names of its joints:
    `cranny.verify_path` judges them in the order of its robot. Times that decrease are a `ValueError`."""
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
    """The message as YAML, as `ros2 topic pub` takes and `ros2 topic echo` prints it."""
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
            # JSON of numbers, strings and lists of them is YAML.
            lines.append(f"{indent}{key}: {json.dumps(entry)}")
    return lines
