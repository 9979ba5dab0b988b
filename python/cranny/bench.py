"""Comparison of planners: campaigns of trials, with results as tables and curves.

>>> from cranny import bench
>>> results = bench.run(["021"], ["reach"], output="results.db", runs=10)  # doctest: +SKIP
>>> results.trials  # doctest: +SKIP
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

from cranny._cranny import ResultsFile, planner_names, run_campaign
from cranny.own_planner import PlannerFunction, end_if_read_for_planner, registered

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

PlannerChoice = str | PlannerFunction | Sequence[str] | tuple[str, Mapping[str, Any]]
"""Name of a built-in or registered planner; a registered function; a built-in planner with settings, as (name,
settings); or the words of a command that speaks the exec protocol."""

Heard = Callable[[int, int, int], None]
"""Callback with three numbers: trials that have ended (as a rule 0 at the first call), trials to run, and trials solved."""


class Results:
    """Results of campaigns, in a file that stays open until `close` or until the end of a `with` block."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self._file = ResultsFile(Path(path))

    @property
    def path(self) -> Path:
        """Path of the results file."""
        return Path(self._file.path)

    @property
    def trials(self) -> Any:
        """All trials, one per row: a pandas data frame, or a dictionary of lists if pandas is not installed."""
        return _frame(self._file.trials())

    @property
    def summary(self) -> dict[str, Any]:
        """All figures of a report: `rows`, `curves`, `comparisons`, `worst`, …, as in `cranny bench report`."""
        return self._file.summary()

    @property
    def rows(self) -> Any:
        """One row for each planner on each scenario: success with Wilson intervals, times as censored data. A data
        frame, or a dictionary of lists without pandas."""
        return _frame(_columns(self.summary["rows"]))

    @property
    def comparisons(self) -> Any:
        """One row for each of at most 500 pairs of planners on a scenario: `finding` ("too-few-runs", "no-difference",
        "first-is-faster", "second-is-faster", "differ"), the p-values of two permutation tests, adjusted over all
        comparisons, and the difference of restricted means with its interval (s); NaN or None if there are too few
        runs. A data frame, or a dictionary of lists without pandas."""
        return _frame(_columns(self.summary["comparisons"]))

    @property
    def curves(self) -> Any:
        """Share of solved runs over time, one row for each step of a curve: `scenario_name`, `planner_name`,
        `criterion`, `over` ("time" in seconds or "iterations"), `at`, `success`, `low` and `high`. A data frame, or a
        dictionary of lists without pandas."""
        keys, steps = ("scenario_name", "environment", "planner_name", "criterion", "over"), ("at", "success", "low", "high")
        rows = [
            {**{key: curve[key] for key in keys}, **dict(zip(steps, step, strict=True))}
            for curve in self.summary["curves"]
            for step in zip(*(curve[key] for key in steps), strict=True)
        ]
        return _frame(_columns(rows, (*keys, *steps)))

    def path_of(self, trial: int) -> NDArray[np.float64]:
        """Path that the planner returned in a trial, (N, dof); no rows if it returned none."""
        return self._file.path_of(trial)

    def html(self) -> str:
        """The report as one self-contained HTML page."""
        return self._file.html()

    def save_html(self, path: str | os.PathLike[str]) -> None:
        """Writes the report page."""
        Path(path).write_text(self._file.html(), encoding="utf-8")

    def plot(
        self,
        scenario: str | None = None,
        *,
        over: str = "time",
        criterion: str | None = None,
        axes: Axes | None = None,
    ) -> Axes:
        """Plots the curves of a scenario with matplotlib, one for each planner: the share of solved runs over time (s)
        or iterations, with its Greenwood band. None: the first scenario, and its first criterion."""
        from cranny.plots import draw_curves

        return draw_curves(self.summary["curves"], scenario, over, criterion, axes)

    def close(self) -> None:
        """Closes the file; later access raises ValueError."""
        self._file.close()

    def __enter__(self) -> Results:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<cranny.bench.Results {self.path}>"


def load(path: str | os.PathLike[str]) -> Results:
    """Opens a results file of `bench.run` or `cranny bench run`."""
    return Results(path)


def run(
    scenarios: Sequence[str],
    planners: Sequence[PlannerChoice] | Mapping[str, PlannerChoice],
    *,
    output: str | os.PathLike[str] = "results.db",
    runs: int = 100,
    first_seed: int = 0,
    criteria: Sequence[str] = ("exact",),
    time_limit_s: float = 120.0,
    iterations: int | None = None,
    memory_limit_mb: int = 4096,
    workers: int = 1,
    judge_both: bool = False,
    measure_clearance: bool = True,
    carry: str | None = None,
    task: str | None = None,
    grasps: str | None = None,
    margin_m: float = 0.0,
    grasp_margin_m: float = 0.0,
    robust: tuple[float, float] | None = None,
    hold: float | None = None,
    try_in_physics: int | None = None,
    sandbox: str = "auto",
    again: Sequence[str] = (),
    shard: tuple[int, int] | None = None,
    heard: Heard | None = None,
) -> Results:
    """Runs a campaign: each of `scenarios` (ids, `01x`, `all`, folders, archives) with each of `planners`, `criteria`
    and `runs` seeds from `first_seed` on. Each trial runs in a worker process, for at most `time_limit_s` or `iterations`.

    The same call continues a stopped campaign: trials in `output` are not run again. Ctrl-C stops it and keeps finished
    trials. With several `workers`, the results state that times are not those of an otherwise idle machine.

    A mapping as `planners` gives them names. `carry` ("home", "out" or "place") also carries the grasped target; `task`
    names a task that each scenario defines, which replaces the grasp; a planner of your own, whose path ends at a goal,
    raises ValueError with either. `robust` is the error (m, rad) of the target's pose
    that each path must tolerate, `hold` the factor by which the hand of a built-in planner must hold what it carries
    (None: 1.5), `try_in_physics` the number of its plans that may be executed in physics until one goes as planned
    (None: none is), `margin_m` and `grasp_margin_m` the clearances (m) of each path between any two bodies, and between hand
    and target. `grasps="none"` runs planners that make their own grasps.

    `sandbox` runs external programs with the protection that the machine supports ("auto"), without it ("off"), or
    refuses to run without all of it ("require"). `again` lists outcomes ("crashed", "killed", …) whose trials are run
    again. `shard`, such as (3, 8), runs the third of eight shards, which `cranny bench merge` joins. `heard` is called
    when the first trials begin, as a rule before any has ended, and then after trials end, with the numbers of trials that
    have ended, that are to run, and that are solved. The process of your own planner runs its script only up to the first
    call of this function.
    """
    end_if_read_for_planner()
    lists = {"scenarios": scenarios, "planners": planners, "criteria": criteria, "again": again}
    for what, given in lists.items():
        if isinstance(given, str):
            raise TypeError(f"{what}: a list is expected, not the string {given!r}")
    output = Path(output)
    folder = output.with_name(output.stem + "-planners")
    named: list[tuple[str | None, PlannerChoice]] = (
        list(planners.items()) if isinstance(planners, Mapping) else [(None, choice) for choice in planners]
    )
    own = [name or found.name for name, choice in named if (found := registered(choice)) is not None]
    if own and (carry is not None or task is not None):
        raise ValueError(
            f"planner '{own[0]}' is a Python function, whose path ends at a goal, but the campaign demands "
            f"{'carry' if carry is not None else 'task'}; write it as a program (docs/exec_protocol.md)"
        )
    run_campaign(
        [os.fspath(scenario) for scenario in scenarios],
        [_call(name, choice, folder) for name, choice in named],
        output,
        [sys.executable, "-m", "cranny.worker"],
        criteria=list(criteria),
        runs=runs,
        first_seed=first_seed,
        time_limit_s=time_limit_s,
        iterations=iterations,
        memory_limit_mb=memory_limit_mb,
        workers=workers,
        judge_both=judge_both,
        measure_clearance=measure_clearance,
        carry=carry,
        task=task,
        grasps=grasps,
        margin_m=margin_m,
        grasp_margin_m=grasp_margin_m,
        robust=robust,
        hold=hold,
        try_in_physics=try_in_physics,
        sandbox=sandbox,
        again=list(again),
        shard=shard,
        command=" ".join(sys.argv) or "python",
        heard=heard,
    )
    return Results(output)


def _call(
    name: str | None, choice: PlannerChoice, folder: Path
) -> tuple[str, str | list[str], dict[str, Any] | None]:
    """Name, call and settings for `run_campaign`."""
    if isinstance(choice, str) or callable(choice):
        own = registered(choice)
        if own is not None:
            return name or own.name, own.command(folder), None
        if not isinstance(choice, str):
            raise ValueError(f"{choice!r} is not registered: decorate it with @cranny.planner('a name')")
        if choice.startswith("exec:"):
            return name or choice, choice.removeprefix("exec:").split(), None
        if choice not in planner_names():
            raise ValueError(
                f"there is no planner '{choice}' (built in: {', '.join(planner_names())}; for your own, decorate a "
                "function with @cranny.planner)"
            )
        return name or choice, choice, None
    words = list(choice)
    if len(words) == 2 and isinstance(words[0], str) and isinstance(words[1], Mapping):
        return name or words[0], words[0], dict(words[1])
    if words and all(isinstance(word, str) for word in words):
        command = [str(word) for word in words]
        return name or "exec:" + Path(command[0]).name, command, None
    raise TypeError(f"{choice!r} is no planner: a name, a function, (name, settings) or a command is expected")


def _columns(rows: list[dict[str, Any]], keys: Sequence[str] = ()) -> dict[str, list[Any]]:
    names = list(rows[0]) if rows else list(keys)
    return {name: [row[name] for row in rows] for name in names}


def _frame(columns: dict[str, list[Any]]) -> Any:
    try:
        import pandas
    except ImportError:
        return columns
    return pandas.DataFrame(columns)
