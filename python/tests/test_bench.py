"""Campaigns with built-in and custom planners; results as tables, curves and pages."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import cranny
import numpy as np
import pytest
from conftest import package
from cranny import bench
from cranny.function_source import source_of


@cranny.planner("straight")
def straight(problem: cranny.Problem, budget: cranny.Budget, seed: int) -> Any:
    """Moves straight to the first goal that it can reach, or through a random configuration."""
    goals = problem.goals(5, seed=seed)
    draws = np.vstack([problem.start, problem.robot.sample(50, seed=seed)])
    print("this is no path")
    for via in draws:
        if not problem.cell.motion_is_free(problem.start, via):
            continue
        free = problem.cell.motion_is_free(via, goals)
        if free.any():
            return [problem.start, via, goals[free][0]]
        if budget.is_spent():
            break
    return None


@cranny.planner("through-walls")
def through_walls(problem: cranny.Problem, budget: cranny.Budget, seed: int) -> Any:
    """Moves straight, regardless of collisions."""
    return [problem.start, problem.start + 0.5]


@cranny.planner("broken")
def broken(problem: cranny.Problem, budget: cranny.Budget, seed: int) -> Any:
    """Fails."""
    raise RuntimeError("out of order")


@cranny.planner("with-margins")
def with_margins(problem: cranny.Problem, budget: cranny.Budget, seed: int) -> Any:
    """Fails unless its cell has the margins of the campaign."""
    assert dict(problem.margins) == {"margin_m": 0.02, "grasp_margin_m": 0.001, "object_margin_m": 0.0}
    q = problem.robot.sample(2000, seed=seed)
    demanded = problem.scenario.cell(margin_m=0.02, grasp_margin_m=0.001).is_free(q)
    assert (problem.cell.is_free(q) == demanded).all()
    assert (problem.scenario.cell().is_free(q) != demanded).any()


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> bench.Results:
    """Two built-in and three custom planners, with two seeds each."""
    told: list[tuple[int, int, int]] = []
    planners: list[Any] = ["reach", ("ik-rrt", {"p_goal": 0.2}), straight, "through-walls", "broken"]
    output = tmp_path_factory.mktemp("bench") / "results.db"
    results = bench.run(
        ["021"], planners, output=output, runs=2, time_limit_s=20, heard=lambda *counts: told.append(counts)
    )
    assert told[-1][:2] == (10, 10)
    return results


def test_a_planner_of_ones_own_is_judged_like_any_other(results: bench.Results) -> None:
    trials = results.trials
    trials = trials if isinstance(trials, dict) else trials.to_dict("list")
    outcomes = {
        planner: {o for o, p in zip(trials["outcome"], trials["planner"], strict=True) if p == planner}
        for planner in set(trials["planner"])
    }
    details = dict(zip(trials["planner"], trials["detail"], strict=True))
    assert outcomes["reach"] == {"solved"} and outcomes["ik-rrt"] == {"solved"}
    assert outcomes["straight"] <= {"solved", "budget-exhausted"}, details["straight"]
    assert outcomes["through-walls"] == {"rejected"}
    assert outcomes["broken"] == {"crashed"} and "out of order" in details["broken"]


def test_results_are_tables_and_pages(results: bench.Results, scenario: cranny.Scenario) -> None:
    pandas = package("pandas")
    trials = results.trials
    assert isinstance(trials, pandas.DataFrame) and len(trials) == 10
    assert set(trials.planner) == {"reach", "ik-rrt", "straight", "through-walls", "broken"}
    first = trials[trials.planner == "reach"].iloc[0]
    path = results.path_of(int(first.id))
    assert path.shape[1] == 9 and cranny.verify_path(scenario, path)
    rows = results.rows.set_index("planner_name")
    assert rows.loc["reach", "success_rate"] == 1.0 and rows.loc["broken", "solved"] == 0
    curves = results.curves
    assert {"at", "success", "low", "high"} <= set(curves.columns) and curves.success.between(0, 1).all()
    assert "<html" in results.html() and results.summary["trials"] == 10


def test_curves_are_drawn(results: bench.Results, tmp_path: Path) -> None:
    matplotlib = package("matplotlib")
    matplotlib.use("Agg")
    axes = results.plot("021")
    assert len(axes.get_lines()) == 5 and "021" in axes.get_title()
    axes.figure.savefig(tmp_path / "curves.png")
    matplotlib.pyplot.close(axes.figure)
    with pytest.raises(ValueError, match="021"):
        results.plot("no such scenario")


def test_a_campaign_goes_on_where_it_was_stopped(results: bench.Results) -> None:
    told: list[tuple[int, int, int]] = []
    bench.run(["021"], ["reach"], output=results.path, runs=3, time_limit_s=20, heard=lambda *c: told.append(c)).close()
    assert told[-1][:2] == (1, 1)


def test_closed_results_and_foreign_files_are_refused(results: bench.Results, tmp_path: Path) -> None:
    with bench.load(results.path) as opened:
        assert opened.summary["trials"] >= 10
    with pytest.raises(ValueError, match="closed"):
        opened.trials  # noqa: B018
    opened.close()
    with pytest.raises(cranny.CrannyError, match="nothing"):
        bench.load(tmp_path / "nothing.db")
    (tmp_path / "text.db").write_text("no database " * 100)
    with pytest.raises(cranny.CrannyError):
        bench.load(tmp_path / "text.db")


@pytest.mark.parametrize(
    ("planners", "message"),
    [
        (["reech"], "reech.*reach"),
        (["reach", "reach"], "reach"),
        ([lambda p, b, s: None], "not registered"),
        ([3], "3 is no planner|not iterable"),
        ([("reach", {"p_gaol": 1})], "p_gaol"),
        ([["no such program at all/x"]], "no such program"),
    ],
)
def test_what_is_no_planner_is_refused(planners: Any, message: str, tmp_path: Path) -> None:
    with pytest.raises((ValueError, TypeError), match=message):
        bench.run(["021"], planners, output=tmp_path / "x.db", runs=1)


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"carry": "home"}, "planner 'straight' is a Python function.*carry"),
        ({"task": "steps"}, "planner 'straight' is a Python function.*task"),
        ({"criteria": "exact"}, "criteria: a list is expected, not the string 'exact'"),
        ({"again": "killed"}, "again: a list is expected, not the string 'killed'"),
    ],
)
def test_a_campaign_that_no_trial_could_serve_is_refused(keywords: Any, message: str, tmp_path: Path) -> None:
    with pytest.raises((ValueError, TypeError), match=message):
        bench.run(["021"], ["reach", straight], output=tmp_path / "x.db", runs=1, **keywords)
    assert not (tmp_path / "x.db").exists()


def test_the_cell_of_a_planner_has_the_margins_of_the_campaign(tmp_path: Path) -> None:
    keywords: dict[str, Any] = {"margin_m": 0.02, "grasp_margin_m": 0.001, "time_limit_s": 20, "runs": 1}
    with bench.run(["021"], [with_margins], output=tmp_path / "x.db", **keywords) as results:
        trials = results.trials
    assert list(trials["outcome"]) == ["gave-up"], list(trials["detail"])


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux states the start of a process")
def test_the_budget_of_a_planner_includes_its_imports(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text(
        "import time\n"
        "import cranny\n"
        "time.sleep(1.5)  # As a large library.\n"
        "@cranny.planner('patient')\n"
        "def patient(problem, budget, seed):\n"
        "    while budget.left_s() > 2.0:\n        time.sleep(0.02)\n"
        "results = cranny.bench.run(['021'], [patient], output='results.db', runs=1, time_limit_s=4)\n"
        "print(results.trials['planning_time_s'][0])\n"
    )
    run = subprocess.run([sys.executable, script], cwd=tmp_path, capture_output=True, text=True, timeout=100)
    # It began with 4 s, and the rest is for the end of the process.
    assert 1.9 < float(run.stdout) < 3.4, run


def test_a_campaign_without_pandas_gives_columns(results: bench.Results, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    columns = results.trials
    assert isinstance(columns, dict) and len(columns["seed"]) >= 10


def test_a_function_of_a_notebook_is_written_down_with_what_it_uses(tmp_path: Path) -> None:
    script = tmp_path / "cells.py"
    script.write_text(NOTEBOOK)
    told = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=60, cwd=tmp_path)
    assert told.returncode == 0, told.stderr
    namespace: dict[str, Any] = {}
    exec(told.stdout, namespace)  # noqa: S102
    assert namespace["mine"](None, None, 4) == [7.0, 3, 1.5]
    assert str(namespace["EDGES"]) == "[(inf, -inf), {'a': nan}]"


NOTEBOOK = '''
import math
import numpy as np
from cranny.function_source import source_of
LIMIT = 3
STEP = np.float64(1.5)
EDGES = [(math.inf, -math.inf), {"a": math.nan}]
floor = object()  # As an attribute is called below.

def add(a, *, summand=LIMIT):
    return helper(a) + summand

def helper(x):
    return float(np.floor(x)) if x < 5 else mine(None, None, x)

def mine(problem, budget, seed, step=STEP, sum_of=add):
    return [sum_of(seed), math.floor(3.5), min(step, EDGES[0][0])]

print(source_of(mine))
'''


@pytest.mark.parametrize(
    ("cell", "message"),
    [
        ("class Tree:\n    pass\ndef mine(problem, budget, seed):\n    return Tree()", "class `Tree` is not known outside"),
        ("free = lambda q: True\ndef mine(problem, budget, seed):\n    return free(1)", "`free` is not defined by `def`"),
        ("lock = object()\ndef mine(problem, budget, seed):\n    return lock", "`lock`, a object, cannot be written"),
    ],
)
def test_what_a_notebook_cannot_pass_on_is_named(cell: str, message: str, tmp_path: Path) -> None:
    script = tmp_path / "cells.py"
    script.write_text(f"from cranny.function_source import source_of\n{cell}\nprint(source_of(mine))\n")
    run = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=60, cwd=tmp_path)
    assert run.returncode == 1 and message in run.stderr, run


def test_what_cannot_be_written_down_is_said() -> None:
    assert "def source_of" not in source_of(straight)
    with pytest.raises(ValueError, match="inside of something else"):

        @cranny.planner("inner")
        def inner(problem: Any, budget: Any, seed: int) -> None:
            return None

    with pytest.raises(TypeError, match="name"):
        cranny.planner(straight)  # type: ignore[arg-type]


STOPPED = """
import os, signal, sys, threading
from cranny import bench
# Shells let what they run in the background ignore it.
signal.signal(signal.SIGINT, signal.default_int_handler)
threading.Timer(3.0, os.kill, (os.getpid(), signal.SIGINT)).start()
try:
    bench.run(["045"], ["j-plus-rrt"], output=sys.argv[1], runs=50, time_limit_s=30)
except KeyboardInterrupt:
    print("stopped")
"""


@pytest.mark.skipif(os.name == "nt", reason="signals of this kind are those of Unix")
def test_an_interrupt_ends_a_campaign_and_its_workers(tmp_path: Path) -> None:
    told = subprocess.run(
        [sys.executable, "-c", STOPPED, str(tmp_path / "r.db")], capture_output=True, text=True, timeout=60
    )
    assert told.stdout.split() == ["stopped"], told


def test_a_script_that_runs_its_own_campaign_does_not_begin_anew_in_each_trial(tmp_path: Path) -> None:
    """Scripts without `if __name__ == "__main__"` must work; earlier, their planners hung until the time limit."""
    script = tmp_path / "script.py"
    script.write_text(
        "import cranny\n"
        "@cranny.planner('given-up')\n"
        "def given_up(problem, budget, seed):\n    return None\n"
        "results = cranny.bench.run(['021'], [given_up], output='results.db', runs=2, time_limit_s=30)\n"
        "print(list(results.trials['outcome']))\n"
    )
    run = subprocess.run([sys.executable, script], cwd=tmp_path, capture_output=True, text=True, timeout=100)
    assert run.stdout.strip() == "['gave-up', 'gave-up']", run.stderr
