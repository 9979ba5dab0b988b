"""A planner of one's own: a function, registered under a name, that campaigns call in a process of its own."""

from __future__ import annotations

import hashlib
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from cranny._cranny import Cell, Grasps, Robot, Scenario
from cranny.function_source import source_of

if TYPE_CHECKING:
    # NumPy takes longer to load than all of this package: the first array brings it.
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

PlannerFunction = Callable[["Problem", "Budget", int], "ArrayLike | None"]
"""What a planner is: problem, budget and seed to way points (N, dof) from the start to a goal, or None."""

_Function = TypeVar("_Function", bound=PlannerFunction)


@dataclass(frozen=True)
class Budget:
    """How much a planner may spend. The campaign measures from outside; a path after the limit counts as none."""

    time_s: float
    """Seconds from the start of the process."""
    iterations: int | None = None
    """Iterations, whatever the planner calls one; None: no limit."""
    begin: float = field(default_factory=time.monotonic, repr=False)
    """When the clock began to run, as `time.monotonic` tells it."""

    def left_s(self) -> float:
        """Seconds that are left, 0 at least."""
        return max(0.0, self.time_s - (time.monotonic() - self.begin))

    def is_spent(self) -> bool:
        """Whether no time is left."""
        return self.left_s() <= 0.0


@dataclass(frozen=True)
class Problem:
    """What a planner of one's own is asked: from `start` to any of `grasps`, free of collision all the way."""

    scenario: Scenario
    """The scenario, for whatever else it tells."""
    start: NDArray[np.float64]
    """The configuration to start from, (dof,), m or rad."""
    goal: NDArray[np.float64] | None = None
    """The one configuration to aim at, (dof,); None: any grasp will do."""

    @property
    def robot(self) -> Robot:
        """The robot."""
        return self.scenario.robot

    @property
    def grasps(self) -> Grasps:
        """How the target can be grasped."""
        return self.scenario.grasps

    @cached_property
    def cell(self) -> Cell:
        """The robot in its world: `is_free`, `motion_is_free`, …"""
        return self.scenario.cell()

    def goals(self, count: int = 10, *, seed: int = 0, attempts: int = 100) -> NDArray[np.float64]:
        """Free configurations that reach a grasp, (K, dof), K ≤ `count`, one for each grasp from the highest score
        down; `attempts` random starts for each."""
        import numpy as np

        if self.goal is not None:
            return self.goal[None, :]
        found: list[NDArray[np.float64]] = []
        poses = self.grasps.poses
        for index in self.grasps.by_score():
            if len(found) == count:
                break
            found.extend(self.robot.ik(poses[index], attempts=attempts, seed=seed, cell=self.cell))
        return np.array(found).reshape(-1, self.robot.dof)


@dataclass(frozen=True)
class OwnPlanner:
    """A planner of one's own, as it was registered."""

    name: str
    """What reports call it."""
    function: PlannerFunction
    """What is called."""

    def command(self, folder: Path) -> list[str]:
        """The command that speaks the exec protocol for it. A function of a notebook is first written, with what it
        refers to, to a file in `folder`."""
        name = self.function.__name__
        file = Path(self.function.__code__.co_filename)
        if not file.is_file():
            text = source_of(self.function)
            folder.mkdir(parents=True, exist_ok=True)
            # The content names the file: a planner that was changed is another one.
            file = folder / f"{name}-{hashlib.sha256(text.encode()).hexdigest()[:12]}.py"
            file.write_text(text, encoding="utf-8")
        return [sys.executable, "-m", "cranny.worker", str(file.resolve()), name]


class ScriptEnds(BaseException):
    """A script that is read for its planner has come to where it runs a campaign: what it defines is known by then."""


_is_read_for_planner = False


@contextmanager
def reading_for_planner() -> Iterator[None]:
    """While a script is run for the planner that it defines, it runs no campaign: the one that asks would begin anew in
    each of its trials."""
    global _is_read_for_planner
    _is_read_for_planner = True
    try:
        with suppress(ScriptEnds):
            yield
    finally:
        _is_read_for_planner = False


def end_if_read_for_planner() -> None:
    """Ends a script that is read for its planner."""
    if _is_read_for_planner:
        raise ScriptEnds


_registered: dict[str, OwnPlanner] = {}


def planner(name: str) -> Callable[[_Function], _Function]:
    """Registers a function of a module or a notebook cell as a planner: `bench.run` then takes its name like that of
    a built-in one, calls it in a process of its own for every trial, and judges its path like anybody's.

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


def registered(what: str | PlannerFunction) -> OwnPlanner | None:
    """The planner of that name, or of that function; None if it was not registered."""
    if isinstance(what, str):
        return _registered.get(what)
    return next((own for own in _registered.values() if own.function is what), None)


def answer(function: PlannerFunction, question: dict[str, Any]) -> dict[str, Any]:
    """Asks a planner as the exec protocol does, and returns what it prints.

    `question` is the document of docs/exec_protocol.md.
    """
    import numpy as np

    begin = time.monotonic()
    scenario = Scenario.load(question["files"]["cranny"], criterion=question["criterion"])
    goal = question.get("goal_configuration")
    problem = Problem(
        scenario,
        np.asarray(question["start"], dtype=np.float64),
        None if goal is None else np.asarray(goal, dtype=np.float64),
    )
    budget = Budget(float(question["time_limit_s"]), question.get("iteration_limit"), begin)
    path = function(problem, budget, int(question["seed"]))
    if path is None:
        return {"outcome": "budget-exhausted"}
    rows = np.asarray(path, dtype=np.float64)
    if rows.ndim != 2 or rows.shape[1] != problem.robot.dof:
        raise ValueError(f"the path has shape {rows.shape}, but (N, {problem.robot.dof}) is expected")
    if not np.isfinite(rows).all():
        raise ValueError("the path has a value that is not finite")
    return {"waypoints": rows.tolist()}
