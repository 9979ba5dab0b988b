"""The examples run unchanged."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import REPOSITORY, package

EXAMPLES = REPOSITORY / "examples"


@pytest.mark.filterwarnings("ignore")
def test_every_cell_of_the_tour_runs_and_shows_something() -> None:
    nbformat, nbclient = package("nbformat"), package("nbclient")
    for name in ("pandas", "matplotlib", "ipykernel"):
        package(name)
    notebook = nbformat.read(EXAMPLES / "tour.ipynb", as_version=4)
    assert all(not cell.get("outputs") for cell in notebook.cells), "the tour is kept without its outputs"
    client = nbclient.NotebookClient(notebook, timeout=120, kernel_name="python3")
    client.execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    errors = [output for output in outputs if output.output_type == "error"]
    assert not errors
    shown = [output.data for output in outputs if "data" in output]
    assert sum("text/html" in data for data in shown) >= 3 and any("image/png" in data for data in shown)
    text = "".join(output.get("text", "") for output in outputs)
    assert "solved by reach" in text and "not valid" in text


def test_planners_of_ompl_take_part_in_a_campaign(tmp_path: Path) -> None:
    package("ompl")
    words = ["--scenarios", "021", "--runs", "1", "--time-limit", "30"]
    told = subprocess.run(
        [sys.executable, str(EXAMPLES / "ompl_planners.py"), *words],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
        timeout=300,
    )
    assert told.returncode == 0, told.stderr
    lines = [line for line in told.stdout.splitlines() if line.startswith("021")]
    assert len(lines) == 5
    for planner in ("reach", "ompl-rrt-connect", "ompl-bit-star", "ompl-kpiece"):
        assert any(planner in line and "1 of 1" in line for line in lines), told.stdout
    assert (tmp_path / "ompl.html").stat().st_size > 10_000


def test_a_policy_is_trained_and_measured(tmp_path: Path) -> None:
    package("pyarrow")
    folder = EXAMPLES / "policy"

    def run(*words: object) -> str:
        told = subprocess.run(
            [sys.executable, *map(str, words)], capture_output=True, text=True, cwd=tmp_path, timeout=300
        )
        assert told.returncode == 0, told.stderr
        return told.stdout

    cranny = ("-m", "cranny")
    run(*cranny, "dataset", "generate", folder / "recipe.yaml", "--count", 80, "-o", "demonstrations")
    losses = run(folder / "train.py", "demonstrations", "--epochs", 20).splitlines()
    first, last = (float(line.split("loss ")[1].split(",")[0]) for line in (losses[1], losses[-1]))
    assert "held out" in losses[0]
    assert last < first, losses
    run(*cranny, "scenario", "generate", "--family", "gap", "--count", 2, "--clutter", 0, "--seed", 99, "-o", "unseen")
    scenarios = sorted((tmp_path / "unseen").glob("*/scenario.yaml"))
    assert len(scenarios) == 2
    figures = run(folder / "measure.py", *(scenario.parent for scenario in scenarios), "--time-limit", 20)
    for planner in ("straight", "policy", "policy-reach", "reach"):
        assert any(line.startswith(f"{planner} ") and "of 2 solved" in line for line in figures.splitlines()), figures
    assert "reach, policy" in figures and "2 solved" in figures
