"""OMPL's constrained planning compared with `reach` on the same motions: `ompl_upright.py SEEDS`, with the command in
`target/release`, the package and `ompl==2.0.1`.

A plan of `examples/tasks` that keeps its object upright within 5° gives two configurations, the ends of its carry motion.
Both planners get these, the same obstacles and joint limits, and the same constraint: the axis of the gripper frame that is
vertical at both ends stays within 5° of vertical. OMPL's `ProjectedStateSpace` gets it as two equations, the horizontal
components of the axis, with that tolerance, and runs RRTConnect; the cell checks its states, and motions are checked at
the steps of the space. Its path is judged by the proof of `reach`.
"""

from __future__ import annotations

import json
import math
import statistics
import subprocess
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import cranny
import numpy as np

COMMAND = Path(__file__).resolve().parents[1] / "target/release/cranny"
TASKS = Path(__file__).resolve().parents[1] / "examples/tasks"
WITHIN_DEG = 5.0
LIMIT_S = 5.0


def task_of(folder: Path, name: str, seed: int) -> tuple[cranny.Scenario, list[float], list[float], Any] | None:
    """Scenario with the constraint, and start, goal and axis of a carry motion."""
    file = folder / "x.plan.json"
    words = [str(COMMAND), "plan", str(TASKS / name), "--place", "tray", "--upright", str(WITHIN_DEG), "--seed", str(seed)]
    subprocess.run([*words, "-q", "-o", str(file)], check=False)
    plan = json.loads(file.read_text())
    if plan["outcome"] != "solved":
        return None
    carry = next(piece for piece in plan["segments"] if piece["mode"] == "carry")["waypoints"]
    grasped = plan["segments"][0]["waypoints"][-1]
    scenario = cranny.Scenario(str(TASKS / name))
    axis = scenario.robot.fk(grasped)[:3, :3].T @ [0, 0, 1]
    text = (TASKS / name / "scenario.yaml").read_text().split("target:")[0]
    bound = f"tool_bounds: [{{name: upright, axis: {axis.tolist()}, toward: [0, 0, 1], within_deg: {WITHIN_DEG}}}]\n"
    free = folder / f"{name}_{seed}"
    free.mkdir()
    (free / "scenario.yaml").write_text(text + bound)
    (free / "grasps.csv").write_text("1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1\n")
    return cranny.Scenario(str(free)), carry[0], carry[-1], axis


def by_ompl(scenario: cranny.Scenario, start: list[float], goal: list[float], axis: Any, seed: int) -> tuple[float, bool, bool]:
    """Time in seconds, whether a path was found, and whether it is proven."""
    from ompl import base, geometric, util

    util.setLogLevel(util.LogLevel.LOG_NONE)
    util.RNG.setSeed(seed + 1)
    robot, cell = scenario.robot, scenario.cell()
    dof = robot.dof

    class Upright(base.Constraint):  # type: ignore[misc]
        """Constraint on the horizontal components of the axis."""

        def __init__(self) -> None:
            super().__init__(dof, 2, math.sin(math.radians(WITHIN_DEG)))

        def function(self, q: Any, out: Any) -> None:
            out[:] = (robot.fk(np.array(q))[:3, :3] @ axis)[:2]

        def jacobian(self, q: Any, out: Any) -> None:
            turns = robot.jacobian(np.array(q))[3:]
            up = robot.fk(np.array(q))[:3, :3] @ axis
            out[:, :] = np.cross(turns.T, up).T[:2]

    inner = base.RealVectorStateSpace(dof)
    bounds = base.RealVectorBounds(dof)
    for joint, (lower, upper) in enumerate(zip(robot.lower, robot.upper, strict=True)):
        bounds.setLow(joint, lower)
        bounds.setHigh(joint, upper)
    inner.setBounds(bounds)
    constraint = Upright()
    space = base.ProjectedStateSpace(inner, constraint)
    information = base.ConstrainedSpaceInformation(space)
    setup = geometric.SimpleSetup(information)

    def values(state: Any) -> Any:
        return np.array([space.getValueAddressAtIndex(state, joint) for joint in range(dof)])

    setup.setStateValidityChecker(lambda state: bool(cell.is_free(values(state))))
    ends = []
    for q in (start, goal):
        state = space.allocState()
        state.copy(np.array(q, dtype=float))
        ends.append(state)
    setup.setStartAndGoalStates(*ends)
    setup.setPlanner(geometric.RRTConnect(information))
    begin = time.perf_counter()
    is_found = bool(setup.solve(LIMIT_S))
    seconds = time.perf_counter() - begin
    if not (is_found and setup.haveExactSolutionPath()):
        return seconds, False, False
    path = [values(state) for state in setup.getSolutionPath().getStates()]
    proven = all(cell.motion_is_free(a, b) for a, b in zip(path[:-1], path[1:], strict=True))
    return seconds, True, proven


def main() -> None:
    """Prints one line for each scene and planner."""
    with TemporaryDirectory() as temporary:
        for name in ("can_shelf", "can_gap", "mug_shelf", "mug_gap"):
            rows: dict[str, list[tuple[float, bool, bool]]] = {"reach": [], "OMPL": []}
            for seed in range(int(sys.argv[1])):
                task = task_of(Path(temporary), name, seed)
                if task is None:
                    continue
                scenario, start, goal, axis = task
                asked = scenario.with_start(start).with_goals([goal])
                plan = cranny.plan(asked, seed=seed, time_limit_s=LIMIT_S)
                rows["reach"].append((plan.report["statistics"]["planning_time_s"], plan.solved, plan.solved))
                rows["OMPL"].append(by_ompl(scenario, start, goal, axis, seed))
            for who, row in rows.items():
                times = [1e3 * seconds for seconds, _, _ in row]
                print(
                    f"{name} {who}: {sum(found for _, found, _ in row)} of {len(row)} found, {sum(p for _, _, p in row)} proven, "
                    f"median {statistics.median(times):.1f}, max {max(times):.0f} ms",
                    flush=True,
                )


if __name__ == "__main__":
    main()
