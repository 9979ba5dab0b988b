"""Grasps of scenarios simulated in both engines: how often they hold, and how often the engines agree.

    python benchmarks/compare_engines.py CRANNY SCENARIO… [--support-only]

CRANNY is the program; the package `cranny[mujoco]` must be installed. Prints a row of Markdown for each scenario. Each
kind of disagreement has its number of grasps and the first of them, which `cranny simulate grasps SCENARIO --grasp K
--record k.gif` shows.
"""

from __future__ import annotations

import argparse
import json
import math
import subprocess
import tempfile
from collections import defaultdict
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from cranny import mujoco_grasps


MODEL: mujoco_grasps.GraspModel
"""Model of this process."""

RARE = 0.1
"""Share of the rarer outcome above which κ is meaningful."""


def read_model(path: str) -> None:
    """Creates the model of a process."""
    global MODEL
    MODEL = mujoco_grasps.GraspModel(mujoco_grasps.load(path))


def second_opinion(index: int) -> str:
    """Outcome of one grasp in MuJoCo."""
    return MODEL.run(index).outcome


def kappa(first: list[bool], second: list[bool]) -> tuple[float, float]:
    """Raw agreement and Cohen's κ; NaN if one outcome is rare."""
    count = len(first)
    agreed = sum(a == b for a, b in zip(first, second)) / count
    chance = sum((first.count(kind) / count) * (second.count(kind) / count) for kind in (True, False))
    rarer = min(kinds.count(kind) / count for kinds in (first, second) for kind in (True, False))
    return agreed, (agreed - chance) / (1.0 - chance) if rarer > RARE else float("nan")


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("cranny")
    parser.add_argument("scenarios", nargs="+")
    parser.add_argument("--support-only", action="store_true")
    arguments = parser.parse_args()
    flags = ["--support-only"] if arguments.support_only else []
    print("| scenario | held here | held in MuJoCo | agreement | κ | same outcome | disagreements (here / MuJoCo) |")
    print("|---|---|---|---|---|---|---|")
    for scenario in arguments.scenarios:
        with tempfile.TemporaryDirectory() as folder:
            path = str(Path(folder) / "experiment.json")
            subprocess.run([arguments.cranny, "simulate", "export", scenario, *flags, "-o", path, "-q"], check=True)
            answer = subprocess.run(
                [arguments.cranny, "simulate", "grasps", scenario, *flags, "--json", "-q"], stdout=subprocess.PIPE
            )
            ours = [row["outcome"] for row in json.loads(answer.stdout)["rows"]]
            with ProcessPoolExecutor(initializer=read_model, initargs=(path,)) as pool:
                theirs = list(pool.map(second_opinion, range(len(ours)), chunksize=10))
        agreed, agreement = kappa([o == "held" for o in ours], [t == "held" for t in theirs])
        same = sum(o == t for o, t in zip(ours, theirs)) / len(ours)
        kinds: dict[tuple[str, str], list[int]] = defaultdict(list)
        for grasp, kind in enumerate(zip(ours, theirs)):
            if kind[0] != kind[1]:
                kinds[kind].append(grasp)
        most_first = sorted(kinds.items(), key=lambda item: -len(item[1]))
        said = ", ".join(f"{o} / {t} {len(all_)} ({all_[0]})" for (o, t), all_ in most_first)
        print(
            f"| {Path(scenario).name} | {ours.count('held')} of {len(ours)} | {theirs.count('held')} | {agreed:.1%} | "
            f"{'' if math.isnan(agreement) else f'{agreement:.2f}'} | {same:.1%} | {said} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
