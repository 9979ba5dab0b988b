"""OMPL's RRTConnect, BIT* and KPIECE in one campaign with Cranny's planners.

They get Cranny's IK goals and Cranny's checks: a configuration is valid if the cell is free there, a motion if it is
proven free. Only the search and its language differ: OMPL calls the checks through Python, one motion at a time, and its
process is started again for each trial; starting and ending it counts as time.

    $ pip install ./python ompl==2.0.1
    $ python examples/ompl_planners.py --runs 20 --page ompl.html

BIT* improves its path until its time is spent; here it stops at its first path, like the others.
"""

from __future__ import annotations

import argparse
import os
from typing import Any

import cranny
import numpy as np
from cranny import bench
from numpy.typing import NDArray

GOALS = 10
"""Number of goal configurations: one for each of the best grasps that have one."""

RESERVE_S = 1.0
"""Seconds kept back from the time limit: the process began before this function, and OMPL reads its clock only between
two motions."""


def solve(problem: cranny.Problem, budget: cranny.Budget, seed: int, name: str) -> Any:
    """Way points from the OMPL planner with this name, or None."""
    from ompl import base, geometric, util

    util.setLogLevel(util.LogLevel.LOG_NONE)
    util.RNG.setSeed(seed + 1)
    robot, cell = problem.robot, problem.cell
    goals = problem.goals(GOALS, seed=seed)
    if len(goals) == 0:
        return None

    space = base.RealVectorStateSpace(robot.dof)
    bounds = base.RealVectorBounds(robot.dof)
    for joint, (lower, upper) in enumerate(zip(robot.lower, robot.upper, strict=True)):
        bounds.setLow(joint, lower)
        bounds.setHigh(joint, upper)
    space.setBounds(bounds)

    def values(state: Any) -> NDArray[np.float64]:
        return np.array([state[joint] for joint in range(robot.dof)])

    class Proof(base.MotionValidator):  # type: ignore[misc]
        """Accepts a motion only if all of it is proven free."""

        def checkMotion(self, a: Any, b: Any, last_valid: Any = None) -> bool:  # noqa: N802
            return bool(cell.motion_is_free(values(a), values(b)))

    setup = geometric.SimpleSetup(space)
    information = setup.getSpaceInformation()
    setup.setStateValidityChecker(lambda state: bool(cell.is_free(values(state))))
    proof = Proof(information)
    information.setMotionValidator(proof)

    def state_of(q: NDArray[np.float64]) -> Any:
        state = information.allocState()
        for joint, value in enumerate(q):
            state[joint] = float(value)
        return state

    setup.addStartState(state_of(problem.start))
    goal = base.GoalStates(information)
    for q in goals:
        goal.addState(state_of(q))
    setup.setGoal(goal)
    setup.setPlanner(getattr(geometric, name)(information))
    if name == "BITstar":
        objective = base.PathLengthOptimizationObjective(information)
        objective.setCostThreshold(base.Cost(float("inf")))
        setup.setOptimizationObjective(objective)
    setup.solve(max(0.01, budget.left_s() - RESERVE_S))
    if not setup.haveExactSolutionPath():
        return None
    return [values(state) for state in setup.getSolutionPath().getStates()]


@cranny.planner("ompl-rrt-connect")
def rrt_connect(problem: cranny.Problem, budget: cranny.Budget, seed: int) -> Any:
    """Two trees that grow towards each other (Kuffner & LaValle 2000)."""
    return solve(problem, budget, seed, "RRTConnect")


@cranny.planner("ompl-bit-star")
def bit_star(problem: cranny.Problem, budget: cranny.Budget, seed: int) -> Any:
    """Batches of samples, searched in the order of path length (Gammell et al. 2015)."""
    return solve(problem, budget, seed, "BITstar")


@cranny.planner("ompl-kpiece")
def kpiece(problem: cranny.Problem, budget: cranny.Budget, seed: int) -> Any:
    """A tree that grows where its projection has few samples (Şucan & Kavraki 2008)."""
    return solve(problem, budget, seed, "KPIECE1")


def main() -> None:
    """Runs the campaign and writes its report page."""
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--scenarios", default="011,021,031,041", help="ids, comma-separated")
    words.add_argument("--runs", type=int, default=20, help="seeds for each planner in each scenario")
    words.add_argument("--time-limit", type=float, default=10.0, help="seconds for a trial")
    words.add_argument("--output", default="ompl.db", help="where the results are, or shall be")
    words.add_argument("--page", default="ompl.html", help="the report page")
    given = words.parse_args()
    planners = ["reach", "ik-rrt", "ompl-rrt-connect", "ompl-bit-star", "ompl-kpiece"]
    with bench.run(
        given.scenarios.split(","),
        planners,
        output=given.output,
        runs=given.runs,
        time_limit_s=given.time_limit,
        heard=lambda ended, to_run, solved: print(f"\r{ended} of {to_run} trials, {solved} solved", end="", flush=True),
    ) as results:
        print()
        results.save_html(given.page)
        for row in results.summary["rows"]:
            median = "     —" if row["median_s"] is None else f"{row['median_s']:6.3f}"
            print(f"{row['scenario']}  {row['planner_name']:18} {row['solved']:3} of {row['runs']}  median {median} s")
        print(f"{os.path.getsize(given.page) // 1024} KiB in {given.page}")


if __name__ == "__main__":
    main()
