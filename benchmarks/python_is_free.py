"""Rate of `is_free` through NumPy: 10⁶ uniform random configurations in one call, on one core.

    $ python benchmarks/python_is_free.py 021
"""

from __future__ import annotations

import sys
import time

import cranny

COUNT = 1_000_000
ROUNDS = 10

for name in sys.argv[1:]:
    scenario = cranny.Scenario(name)
    cell = scenario.cell()
    q = scenario.robot.sample(COUNT, seed=0)
    fastest_s = float("inf")
    for _ in range(ROUNDS):
        begin = time.perf_counter()
        free = cell.is_free(q)
        fastest_s = min(fastest_s, time.perf_counter() - begin)
    print(f"{name}: {COUNT / fastest_s:.0f} verdicts/s through NumPy; {free.sum()} of {COUNT} free")
