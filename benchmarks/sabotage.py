"""Compares the trials of `reach` in a campaign of its own and beside saboteurs (`saboteur.py`). Ends with 1 if they differ.

usage: sabotage.py CRANNY [RUNS] [WORKERS]   the program; seeds of each scenario (10); simultaneous trials (4)
"""

from __future__ import annotations

import math
import sqlite3
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

from saboteur import NAMES

SCENARIOS = "021,031,041,012,015"

# Level of the test: one of a hundred runs without any effect fails.
LEAST_P = 0.01


def campaign(program: str, folder: Path, planners: list[str], runs: str, workers: str) -> list[tuple[str, str, str, int, float]]:
    """Runs a campaign and returns planner, outcome, scenario, seed and time in seconds of each trial."""
    results = folder / f"{len(planners)}.db"
    words = [word for planner in planners for word in ("--planner", planner)]
    limits = ["--time-limit", "0.5", "--memory-limit", "300", "--workers", workers, "--sandbox", "require"]
    command = [program, "bench", "run", "-o", str(results), "--scenarios", SCENARIOS, "--runs", runs, *limits, *words]
    subprocess.run(command, check=True, cwd=folder, stdout=subprocess.DEVNULL)
    with sqlite3.connect(results) as stored:
        columns = "planner, outcome, scenario, seed, planning_time_s"
        return stored.execute(f"select {columns} from trials").fetchall()


def rank_sum(first: list[float], second: list[float]) -> float:
    """Returns the two-sided p-value of the Wilcoxon rank-sum test, by its normal approximation."""
    ordered = sorted([(value, 0) for value in first] + [(value, 1) for value in second])
    ranks = sum(rank for rank, (_, sample) in enumerate(ordered, 1) if sample == 0)
    n, m = len(first), len(second)
    z = (ranks - n * (n + m + 1) / 2) / math.sqrt(n * m * (n + m + 1) / 12)
    return math.erfc(abs(z) / math.sqrt(2))


def main(program: str, runs: str = "10", workers: str = "4") -> bool:
    """Runs both campaigns, prints the comparison, and returns True if the saboteurs changed nothing and solved nothing."""
    here = Path(__file__).resolve().parent
    # Within the folder of the input files, which some of them attack.
    saboteurs = [f"{name}=exec:python3 {here / 'saboteur.py'} {name} {{grasps}}" for name in NAMES]
    program = str(Path(program).resolve())
    with tempfile.TemporaryDirectory() as folder:
        alone = campaign(program, Path(folder), ["reach"], runs, workers)
        beside = campaign(program, Path(folder), ["reach", *saboteurs], runs, workers)
    for name in NAMES:
        outcomes = sorted({outcome for planner, outcome, *_ in beside if planner == name})
        print(f"{name}: {', '.join(outcomes)}")
    reach = [{row[2:4]: (row[1], row[4]) for row in rows if row[0] == "reach"} for rows in (alone, beside)]
    same = sum(reach[0][trial][0] == reach[1][trial][0] for trial in reach[0])
    print(f"outcomes of reach: {same} of {len(reach[0])} are the same")
    times = [[1e3 * time for _, time in trials.values()] for trials in reach]
    medians = [statistics.median(values) for values in times]
    print(f"median time of reach: {medians[0]:.2f} ms alone, {medians[1]:.2f} ms beside saboteurs")
    p = rank_sum(*times)
    print(f"rank-sum test: p = {p:.3f}")
    solved = {planner for planner, outcome, *_ in beside if planner != "reach" and outcome == "solved"}
    return same == len(reach[0]) == len(reach[1]) and p >= LEAST_P and not solved


if __name__ == "__main__":
    sys.exit(0 if main(*sys.argv[1:]) else 1)
