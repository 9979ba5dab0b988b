"""Simulation of plans that carry and put down: how many keep their object, and how many leave it standing.

    python benchmarks/holding.py place 10              32 tasks, rapier
    python benchmarks/holding.py place 4 --mujoco      the same in MuJoCo
    python benchmarks/holding.py place 10 --disturb    with small random errors in all quantities
    python benchmarks/holding.py home 10               20 scenarios, carried to the robot's start
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from typing import Any

import cranny
from cranny import mujoco_grasps

TWENTY = [f"0{family}{level}" for family in range(1, 5) for level in range(1, 6)]
INSERTIONS = [f"1{family}{level}" for family in range(1, 5) for level in (1, 3, 5)]


def tasks(which: str) -> Iterator[tuple[str, dict[str, Any]]]:
    """Scenarios with keywords of `cranny.plan`."""
    if which == "home":
        yield from ((name, {"carry": "home"}) for name in TWENTY)
        return
    yield from ((name, {"place": "outside"}) for name in TWENTY)
    yield from ((name, {"place": "inside"}) for name in INSERTIONS)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("which", choices=["place", "home"])
    parser.add_argument("seeds", type=int)
    parser.add_argument("--mujoco", action="store_true")
    parser.add_argument("--disturb", action="store_true")
    parser.add_argument("--hold", type=float, default=1.5)
    given = parser.parse_args()
    planned = kept = stand = number = 0
    for name, task in tasks(given.which):
        scenario = cranny.Scenario(name)
        for seed in range(given.seeds):
            number += 1
            plan = cranny.plan(scenario, seed=seed, hold=given.hold, **task)
            if not plan:
                print(f"{name} seed {seed}: {plan.outcome}")
                continue
            planned += 1
            if given.mujoco:
                run = mujoco_grasps.run_plan(cranny.plan_experiment(plan))
                is_kept, stands = run.is_kept, run.stands
            else:
                row = cranny.simulate_plan(plan, disturb=number if given.disturb else None)
                is_kept, stands = row["is_kept"], row.get("placed", {}).get("is_there", False)
            kept, stand = kept + is_kept, stand + stands
            if not is_kept or (given.which == "place" and not stands):
                print(f"{name} seed {seed}: {'kept' if is_kept else 'lost'}, {'stands' if stands else 'does not stand'}")
            sys.stdout.flush()
    print(f"{number} tasks, {planned} planned, {kept} kept, {stand} stand")


if __name__ == "__main__":
    main()
