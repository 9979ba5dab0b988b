"""Measures the policy on scenes that it has not seen, in a campaign beside `reach`, and as the beginning of its search:
`python measure.py unseen/*/ --policy policy.npz`."""

from __future__ import annotations

import argparse
import math
import os
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from policy import Policy, paths, scene_features

import cranny
from cranny import bench

GOALS = 16
"""Goal configurations for which the policy proposes paths."""


def goal_configurations(scenario: cranny.Scenario, cell: cranny.Cell, seed: int) -> NDArray[np.float64]:
    """Free goal configurations (N, dof) at grasps in random order, those from which nothing was learned included."""
    poses, found = scenario.grasps.poses, []
    for grasp in np.random.default_rng(seed).permutation(len(poses)):
        found.extend(scenario.robot.ik(poses[grasp], attempts=50, seed=seed, cell=cell))
        if len(found) >= GOALS:
            break
    return np.asarray(found).reshape(-1, scenario.robot.dof)[:GOALS]


def proposals(policy: Policy, scenario: cranny.Scenario, goals: NDArray[np.float64]) -> NDArray[np.float64]:
    """Paths (N, POINTS + 2, dof) to the goals, unproven."""
    target = scenario.target
    assert target is not None
    fixed = [body for body in scenario.world if body.name != target.name and set(body.kinds) == {"box"}]
    boxes = np.array(
        [np.concatenate([size, at[:3, 3]]) for body in fixed for size, at in zip(body.sizes, body.poses, strict=True)]
    )
    scene = scene_features(boxes, target.poses[0])
    starts = np.tile(scenario.start, (len(goals), 1)).astype(np.float32)
    inputs = np.hstack([starts, goals.astype(np.float32), np.tile(scene, (len(goals), 1))])
    found = np.clip(paths(starts, goals, policy.propose(inputs)), scenario.robot.lower, scenario.robot.upper)
    # Single precision has moved the ends.
    found[:, :, 0], found[:, :, -1] = scenario.start, goals[:, None]
    return found.reshape(-1, *found.shape[2:])


def free_shares(cell: cranny.Cell, candidates: NDArray[np.float64]) -> NDArray[np.float64]:
    """Share of the edges of each path that is proven free; 1 for a proven path."""
    a, b = candidates[:, :-1].reshape(-1, candidates.shape[2]), candidates[:, 1:].reshape(-1, candidates.shape[2])
    return np.asarray(np.asarray(cell.motion_is_free(a, b), dtype=float).reshape(len(candidates), -1).mean(axis=1))


def best(cell: cranny.Cell, candidates: NDArray[np.float64]) -> tuple[NDArray[np.float64] | None, bool]:
    """The path with the largest proven share, of several the shortest; and whether it is proven."""
    if not len(candidates):
        return None, False
    shares = free_shares(cell, candidates)
    lengths = np.linalg.norm(np.diff(candidates, axis=1), axis=2).sum(axis=1)
    chosen = np.lexsort((lengths, -shares))[0]
    return candidates[chosen], bool(shares[chosen] == 1.0)


def loaded() -> Policy:
    """The policy that the environment names."""
    return Policy.load(os.environ["CRANNY_POLICY"])


@cranny.planner("straight")
def straight(problem: cranny.Problem, budget: cranny.Budget, seed: int) -> NDArray[np.float64] | None:
    """Goes straight to one of the goals: what the policy must be better than."""
    goals = goal_configurations(problem.scenario, problem.cell, seed)
    candidates = np.stack([np.tile(problem.start, (len(goals), 1)), goals], axis=1)
    path, is_proven = best(problem.cell, candidates)
    return path if is_proven else None


@cranny.planner("policy")
def policy_alone(problem: cranny.Problem, budget: cranny.Budget, seed: int) -> NDArray[np.float64] | None:
    """A proven path of the policy, if it proposes one."""
    goals = goal_configurations(problem.scenario, problem.cell, seed)
    path, is_proven = best(problem.cell, proposals(loaded(), problem.scenario, goals))
    return path if is_proven else None


@cranny.planner("policy-reach")
def policy_reach(problem: cranny.Problem, budget: cranny.Budget, seed: int) -> NDArray[np.float64] | None:
    """The search of `reach`, which begins along the best path of the policy."""
    goals = goal_configurations(problem.scenario, problem.cell, seed)
    guess, _ = best(problem.cell, proposals(loaded(), problem.scenario, goals))
    settings = {} if guess is None else {"guess": guess.tolist()}
    plan = cranny.plan(problem.scenario, "reach", seed=seed, settings=settings, time_limit_s=max(0.1, budget.left_s()))
    return plan.path if plan.solved else None


def wilson(solved: int, count: int) -> tuple[float, float]:
    """95 % interval of a share (Wilson 1927)."""
    z, share = 1.96, solved / count
    middle, half = share + z * z / (2 * count), z * math.sqrt(share * (1 - share) / count + z * z / (4 * count * count))
    return (middle - half) / (1 + z * z / count), (middle + half) / (1 + z * z / count)


def warm_starts(policy: Policy, scenarios: list[str]) -> None:
    """Prints the work of `reach` without a guess, with the policy's best path, and with a straight line to the same goal."""
    figures: dict[str, list[tuple[int, float, bool]]] = {"no guess": [], "straight line": [], "policy": []}
    proven, spent = 0, []
    for number, name in enumerate(scenarios):
        scenario = cranny.Scenario(name)
        cell = scenario.cell()
        begin = time.perf_counter()
        guess, is_proven = best(cell, proposals(policy, scenario, goal_configurations(scenario, cell, number)))
        spent.append(time.perf_counter() - begin)
        proven += is_proven
        for what, settings in (
            ("no guess", {}),
            ("straight line", {} if guess is None else {"guess": guess[[0, -1]].tolist()}),
            ("policy", {} if guess is None else {"guess": guess.tolist()}),
        ):
            plan = cranny.plan(scenario, "reach", seed=number, settings=settings, iterations=20_000, shortcut=False)
            spending = plan.report["statistics"]
            figures[what].append((spending["iterations"], spending["planning_time_s"], plan.solved))
    print(f"policy: {proven} of {len(scenarios)} best paths proven as they are; {1e3 * np.median(spent):.0f} ms to propose and prove")
    for what, found in figures.items():
        iterations, times, solved = (np.array(values, dtype=float) for values in zip(*found, strict=True))
        print(
            f"reach, {what:13}: {solved.sum():.0f} solved; iterations: median {np.median(iterations):.0f}, mean {iterations.mean():.0f}, "
            f"p95 {np.percentile(iterations, 95):.0f}; search: median {1e3 * np.median(times):.2f} ms, mean {1e3 * times.mean():.2f} ms"
        )


def main() -> None:
    """Runs the campaign, and prints success rates with their intervals."""
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("scenarios", nargs="+", help="folders of scenarios")
    words.add_argument("--policy", default="policy.npz")
    words.add_argument("--time-limit", type=float, default=10.0, help="seconds for a trial")
    words.add_argument("--output", default="policy.db", help="results of the campaign")
    given = words.parse_args()
    os.environ["CRANNY_POLICY"] = str(Path(given.policy).resolve())
    scenarios = [str(Path(folder)) for folder in given.scenarios if (Path(folder) / "scenario.yaml").is_file()]
    with bench.run(
        scenarios, ["straight", "policy", "policy-reach", "reach"], output=given.output, runs=1, time_limit_s=given.time_limit
    ) as results:
        for row in sorted({(str(row["planner_name"])) for row in results.summary["rows"]}):
            own = [one for one in results.summary["rows"] if one["planner_name"] == row]
            solved, count = sum(one["solved"] for one in own), sum(one["runs"] for one in own)
            low, high = wilson(solved, count)
            print(f"{row:14} {solved} of {count} solved: {100 * solved / count:.0f} % [{100 * low:.0f}, {100 * high:.0f}]")
    warm_starts(Policy.load(given.policy), scenarios)


if __name__ == "__main__":
    main()
