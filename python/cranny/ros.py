"""Trajectories as ROS 2 has them, without ROS: dictionaries and YAML of `trajectory_msgs/JointTrajectory`.

>>> import cranny
>>> message = cranny.ros.joint_trajectory(cranny.plan(cranny.Scenario("021")), rate=50)
>>> sorted(message)
['header', 'joint_names', 'points']
"""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cranny._cranny import Plan, Samples

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

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


def positions_of(message: dict[str, Any]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Times (T,) in seconds and positions (T, dof) of such a message, from anybody; `cranny.verify_path` judges the
    positions."""
    import numpy as np

    points = message["points"]
    stamps = [point["time_from_start"] for point in points]
    times = np.array([stamp["sec"] + stamp["nanosec"] / NANOSECONDS for stamp in stamps], dtype=np.float64)
    dof = len(message["joint_names"])
    return times, np.array([point["positions"] for point in points], dtype=np.float64).reshape(-1, dof)


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
