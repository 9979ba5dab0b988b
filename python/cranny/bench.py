"""How well planners do: campaigns of trials, their results as tables and curves.

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
"""A built-in planner or one of one's own by its name; a registered function; a built-in planner with settings, as
(name, settings); or the words of a command that speaks the exec protocol."""

Heard = Callable[[int, int, int], None]
"""Called with the trials that ended, those to run, and those solved."""


class Results:
    """The results of campaigns: a file that is open until `close`, or until the end of a `with` block."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self._file = ResultsFile(Path(path))

    @property
    def path(self) -> Path:
        """The file."""
        return Path(self._file.path)

    @property
    def trials(self) -> Any:
        """All trials, one a row: a pandas data frame, or where there is no pandas a dictionary of lists."""
        return _frame(self._file.trials())

    @property
    def summary(self) -> dict[str, Any]:
        """Every figure of a report: `rows`, `curves`, `comparisons`, `worst`, … as `cranny bench report` gives them."""
        return self._file.summary()

    @property
    def rows(self) -> Any:
        """One row for each planner on each scenario: success with Wilson intervals, times as censored data. A data
        frame, or where there is no pandas a dictionary of lists."""
        return _frame(_columns(self.summary["rows"]))

    @property
    def comparisons(self) -> Any:
        """Each pair of planners on each scenario: one row with `finding` ("too-few-runs", "no-difference",
        "first-is-faster", "second-is-faster", "differ"), the p-values of two permutation tests, adjusted over all
        comparisons, and the difference of restricted means with its interval (s); NaN or None where the runs support
        none. A data frame, or where there is no pandas a dictionary of lists."""
        return _frame(_columns(self.summary["comparisons"]))

    @property
    def curves(self) -> Any:
        """Which share of runs was solved when: one row a step, with `scenario_name`, `planner_name`, `criterion`,
        `over` ("time" in seconds or "iterations"), `at`, `success`, `low` and `high`. A data frame, or where there
        is no pandas a dictionary of lists."""
        keys, steps = ("scenario_name", "environment", "planner_name", "criterion", "over"), ("at", "success", "low", "high")
        rows = [
            {**{key: curve[key] for key in keys}, **dict(zip(steps, step, strict=True))}
            for curve in self.summary["curves"]
            for step in zip(*(curve[key] for key in steps), strict=True)
        ]
        return _frame(_columns(rows, (*keys, *steps)))

    def path_of(self, trial: int) -> NDArray[np.float64]:
        """The path that the planner of a trial gave, (N, dof); no rows where it gave none."""
        return self._file.path_of(trial)

    def html(self) -> str:
        """The report as one page that opens without a network."""
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
        """Draws the curves of a scenario with matplotlib, one a planner: the share of runs solved over time (s) or
        iterations, with its Greenwood band. None: the first scenario, and its first criterion."""
        from cranny.plots import draw_curves

        return draw_curves(self.summary["curves"], scenario, over, criterion, axes)

    def close(self) -> None:
        """Closes the file; whatever is asked afterwards raises ValueError."""
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
    """Opens the results in a file, of `bench.run` or `cranny bench run`."""
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
    sandbox: str = "auto",
    again: Sequence[str] = (),
    shard: tuple[int, int] | None = None,
    heard: Heard | None = None,
) -> Results:
    """Runs a campaign: `scenarios` (ids, `01x`, `all`, folders, archives) by `planners` by `criteria` by `runs` seeds
    from `first_seed` on, each trial in a worker process, at most `time_limit_s` seconds or `iterations`.

    It goes on where it was stopped: trials that are in `output` are not run again. Ctrl-C stops it; what has ended
    stays. With more than one of `workers`, times are not those of a machine at rest, and the results say so.
    With `carry`, "home", "out" or "place", the target is carried on once it is grasped; with `task` the task of that name
    is done in each scenario. `robust`: how far (m, rad) it may
    be from where it is thought to be; `hold`: factor by which the hand of a built-in planner holds what it carries (None:
    1.5). With `grasps`, "none", no set of grasps is
    given, for planners that make grasps of their own. `margin_m` and `grasp_margin_m` are the
    clearances (m) that each path must keep: between any two things, and between the hand and what it grasps.
    `sandbox`: "auto" runs the programs of others within the walls that the machine has, "off" without, "require" within
    all of them or not at all. Trials that ended in one of the outcomes `again` ("crashed", "killed", …) are run again.
    In the process of a planner of one's own, its script is run up to the first call of this function.
    With `shard`, (3, 8), only the third of eight parts is run, which `cranny bench merge` joins.
    A mapping of `planners` gives them
    names. `heard` is called whenever trials have ended, with the numbers of those that ended, that are to be run, and
    that were solved.
    """
    end_if_read_for_planner()
    for what, given in (("scenarios", scenarios), ("planners", planners)):
        if isinstance(given, str):
            raise TypeError(f"{what}: a list is expected, not the string {given!r}")
    output = Path(output)
    folder = output.with_name(output.stem + "-planners")
    named: list[tuple[str | None, PlannerChoice]] = (
        list(planners.items()) if isinstance(planners, Mapping) else [(None, choice) for choice in planners]
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
    """Name, call and settings, as `run_campaign` takes them."""
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
