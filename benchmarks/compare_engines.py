"""Grasps of scenarios in both engines: how often they hold, and how often the engines agree.

    python benchmarks/compare_engines.py CRANNY SCENARIO… [--support-only]

CRANNY is the program; the package `cranny[mujoco]` must be installed. Prints a row of Markdown for each scenario and the
kinds of disagreement.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import tempfile
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

from cranny import mujoco_grasps


def second_opinion(path: str, index: int) -> str:
    """What MuJoCo says of one grasp."""
    return mujoco_grasps.GraspModel(mujoco_grasps.load(path)).run(index).outcome


def kappa(first: list[bool], second: list[bool]) -> tuple[float, float]:
    """Raw agreement and Cohen's κ."""
    count = len(first)
    agreed = sum(a == b for a, b in zip(first, second)) / count
    chance = sum((first.count(kind) / count) * (second.count(kind) / count) for kind in (True, False))
    return agreed, (agreed - chance) / (1.0 - chance) if chance < 1.0 else float("nan")


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
            with ProcessPoolExecutor() as pool:
                theirs = list(pool.map(partial(second_opinion, path), range(len(ours)), chunksize=10))
        agreed, agreement = kappa([o == "held" for o in ours], [t == "held" for t in theirs])
        same = sum(o == t for o, t in zip(ours, theirs)) / len(ours)
        kinds = Counter((o, t) for o, t in zip(ours, theirs) if o != t)
        said = ", ".join(f"{o} / {t} {count}" for (o, t), count in kinds.most_common())
        print(
            f"| {Path(scenario).name} | {ours.count('held')} of {len(ours)} | {theirs.count('held')} | {agreed:.1%} | "
            f"{agreement:.2f} | {same:.1%} | {said} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
