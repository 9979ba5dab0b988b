"""Support for your own planner: a function, registered under a name, that campaigns call in a separate process."""

from __future__ import annotations

import hashlib
import os
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from cranny._cranny import Cell, Grasps, Robot, Scenario
from cranny.function_source import source_of
from cranny.ros import JointPositions

if TYPE_CHECKING:
    # NumPy takes longer to load than this package, so it is imported only when an array is needed.
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

PlannerFunction = Callable[["Problem", "Budget", int], "ArrayLike | None"]
"""Signature of a planner: from problem, budget and seed to way points (N, dof) from the start to a goal, or None; way points as
`cranny.ros.JointPositions` are reordered by the names of their joints."""

_Function = TypeVar("_Function", bound=PlannerFunction)


@dataclass(frozen=True)
class Budget:
    """Limits of a planner. The campaign measures the time from outside, until the process has ended: keep a reserve of
    some tenths of a second, since a path after the limit does not count."""

    time_s: float
    """Seconds from the start of the process, imports included; outside of Linux, from the end of the import of Cranny."""
    iterations: int | None = None
    """Number of iterations, as the planner defines them; None: no limit."""
    begin: float = field(default_factory=time.monotonic, repr=False)
    """Start of the clock, from `time.monotonic`."""

    def left_s(self) -> float:
        """Remaining time in seconds, at least 0."""
        return max(0.0, self.time_s - (time.monotonic() - self.begin))

    def is_spent(self) -> bool:
        """True if no time is left."""
        return self.left_s() <= 0.0


@dataclass(frozen=True)
class Problem:
    """Problem for your own planner: find a collision-free path from `start` to one of `grasps`, or to one of the goal
    configurations that `goal` or the scenario states (`Scenario.goals`)."""

    scenario: Scenario
    """The scenario, which gives access to all other data."""
    start: NDArray[np.float64]
    """Start configuration, (dof,), m or rad."""
    goal: NDArray[np.float64] | None = None
    """The only goal configuration, (dof,); None: any goal of the scenario is one."""
    margins: Mapping[str, float] = field(default_factory=dict)
    """Clearances (m) that the campaign demands of each path: `margin_m` between any two bodies, `grasp_margin_m` between
    the hand and the target or its support, and `object_margin_m`, in addition, around the target, whose pose may be
    inexact by that (`robust`)."""

    @property
    def robot(self) -> Robot:
        """The robot."""
        return self.scenario.robot

    @property
    def grasps(self) -> Grasps:
        """Grasps of the target."""
        return self.scenario.grasps

    @cached_property
    def cell(self) -> Cell:
        """The robot in its world, with `margins`: `is_free`, `motion_is_free`, …"""
        return self.scenario.cell(**{name: margin_m for name, margin_m in self.margins.items() if margin_m > 0.0})

    def goals(self, count: int = 10, *, seed: int = 0, attempts: int = 100) -> NDArray[np.float64]:
        """Free configurations that reach a grasp, (K, dof), K ≤ `count`, one per grasp in the order of falling scores;
        `attempts` random starts for each. Of a scenario with goal configurations (`Scenario.with_goals`): its first free
        ones."""
        import numpy as np

        if self.goal is not None:
            return self.goal[None, :]
        if (stated := self.scenario.goals) is not None:
            free: NDArray[np.bool_] = self.cell.is_free(stated)
            return stated[free][:count]
        found: list[NDArray[np.float64]] = []
        poses = self.grasps.poses
        for index in self.grasps.by_score():
            if len(found) == count:
                break
            found.extend(self.robot.ik(poses[index], attempts=attempts, seed=seed, cell=self.cell))
        return np.array(found).reshape(-1, self.robot.dof)


@dataclass(frozen=True)
class OwnPlanner:
    """A registered planner."""

    name: str
    """Name in reports."""
    function: PlannerFunction
    """Function that is called."""

    def command(self, folder: Path) -> list[str]:
        """Command that runs the function by the exec protocol. A notebook function is first written to a file in
        `folder`, with everything that it refers to."""
        name = self.function.__name__
        file = Path(self.function.__code__.co_filename)
        if not file.is_file():
            text = source_of(self.function)
            folder.mkdir(parents=True, exist_ok=True)
            # The file name contains a hash of the source: a changed planner counts as another one.
            file = folder / f"{name}-{hashlib.sha256(text.encode()).hexdigest()[:12]}.py"
            file.write_text(text, encoding="utf-8")
        return [sys.executable, "-m", "cranny.worker", str(file.resolve()), name]


class ScriptEnds(BaseException):
    """Ends a script that is read for its planner, as soon as it would run a campaign."""


_is_read_for_planner = False


@contextmanager
def reading_for_planner() -> Iterator[None]:
    """Suppresses campaigns while a script is read for its planner; otherwise each trial would start a campaign."""
    global _is_read_for_planner
    _is_read_for_planner = True
    try:
        with suppress(ScriptEnds):
            yield
    finally:
        _is_read_for_planner = False


def end_if_read_for_planner() -> None:
    """Raises ScriptEnds if the script is read for its planner."""
    if _is_read_for_planner:
        raise ScriptEnds


_registered: dict[str, OwnPlanner] = {}


def planner(name: str) -> Callable[[_Function], _Function]:
    """Registers a function of a module or a notebook cell as a planner: `bench.run` then accepts its name like that of
    a built-in one, calls it in a separate process for each trial, and judges its paths by the same rules.

    >>> import cranny
    >>> @cranny.planner("straight")
    ... def straight(problem, budget, seed):
    ...     goals = problem.goals(5, seed=seed)
    ...     free = problem.cell.motion_is_free(problem.start, goals)
    ...     return [problem.start, goals[free][0]] if free.any() else None
    """
    if not isinstance(name, str) or not name:
        raise TypeError("give the planner a name: @cranny.planner('mine')")

    def register(function: _Function) -> _Function:
        if not hasattr(function, "__code__"):
            raise TypeError(f"a planner is a function of problem, budget and seed, not {function!r}")
        if function.__qualname__ != function.__name__:
            raise ValueError(
                f"planner '{name}': {function.__qualname__} is defined inside of something else; define it at the top "
                "of a module or a cell, so that another process finds it"
            )
        _registered[name] = OwnPlanner(name, function)
        return function

    return register


def registered(what: object) -> OwnPlanner | None:
    """Registered planner with this name or function; None for anything else."""
    if isinstance(what, str):
        return _registered.get(what)
    return next((own for own in _registered.values() if own.function is what), None)


def process_begin() -> float:
    """Start of this process on the clock of `time.monotonic`; outside of Linux, which alone states it, now."""
    now = time.monotonic()
    if sys.platform != "linux":
        return now
    try:
        # The name of the program, in parentheses, may contain spaces. Field 22 counts ticks since the start of the system.
        ticks = int(Path("/proc/self/stat").read_text(encoding="utf-8", errors="replace").rpartition(")")[2].split()[19])
        age_s = time.clock_gettime(time.CLOCK_BOOTTIME) - ticks / os.sysconf("SC_CLK_TCK")
    except (OSError, ValueError, IndexError):
        return now
    return now - max(0.0, age_s)


def answer(function: PlannerFunction, question: dict[str, Any], begin: float) -> dict[str, Any]:
    """Runs a planner on a request of the exec protocol, and returns its answer.

    `question` is the document described in docs/exec_protocol.md, `begin` the start of the clock, from `time.monotonic`.
    """
    import numpy as np

    scenario = Scenario.load(question["files"]["cranny"], criterion=question["criterion"])
    goal = question.get("goal_configuration")
    problem = Problem(
        scenario,
        np.asarray(question["start"], dtype=np.float64),
        None if goal is None else np.asarray(goal, dtype=np.float64),
        {name: float(question[name]) for name in ("margin_m", "grasp_margin_m", "object_margin_m")},
    )
    budget = Budget(float(question["time_limit_s"]), question.get("iteration_limit"), begin)
    path = function(problem, budget, int(question["seed"]))
    if path is None:
        return {"outcome": "budget-exhausted"}
    if isinstance(path, JointPositions):
        path = path.in_order_of(problem.robot.joint_names)
    rows = np.asarray(path, dtype=np.float64)
    if rows.ndim != 2 or rows.shape[1] != problem.robot.dof:
        raise ValueError(f"the path has shape {rows.shape}, but (N, {problem.robot.dof}) is expected")
    if not np.isfinite(rows).all():
        raise ValueError("the path has a value that is not finite")
    return {"waypoints": rows.tolist()}
