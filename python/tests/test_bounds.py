"""Bounds of tool, joints and speeds in scenario.yaml, and the lower bound of a path's length."""

from __future__ import annotations

import pickle
import shutil
from pathlib import Path

import cranny
import numpy as np
import pytest

BOUNDS = """tool_bounds:
  - {name: lane, pose: {position: [0.4, 0, 0.8]}, size: [1.6, 2, 1.4]}
  - {name: level, axis: [0, 0, 1], toward: [1, 0, -1], within_deg: 60}
joint_bounds: {panda_joint1: [-1.2, 1.2]}
speeds: {all: {speed: 0.5}}
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Scenario of `cranny scenario new`: a can on a board."""
    template = Path(__file__).parents[2] / "crates/scenario/src/layout/template"
    return Path(shutil.copytree(template, tmp_path / "own"))


def test_a_plan_keeps_the_bounds_and_states_how_far(folder: Path) -> None:
    free = cranny.plan(cranny.Scenario(folder))
    file = folder / "scenario.yaml"
    file.write_text(file.read_text() + BOUNDS)
    scenario = cranny.Scenario(folder)
    plan = cranny.plan(scenario)
    assert plan.solved and free.solved and free.tool == []
    assert [bound["name"] for bound in plan.tool] == ["lane", "level"]
    assert plan.tool[0]["slack_m"] > 0 and plan.tool[1]["slack_rad"] > 0
    poses = scenario.robot.fk(plan.sample(rate=200).positions)
    angles = np.arccos(np.clip(poses[:, :3, 2] @ np.array([1, 0, -1]) / np.sqrt(2), -1, 1))
    assert angles.max() <= np.radians(60) - plan.tool[1]["slack_rad"] + 1e-9
    joint = scenario.robot.joint_names.index("panda_joint1")
    assert np.abs(plan.path[:, joint]).max() <= 1.2
    assert {segment["pace"]["velocity"] for segment in plan.report["segments"]} == {0.5}
    assert plan.verify()


def test_a_motion_out_of_bounds_names_the_bound_and_is_pickled(folder: Path) -> None:
    file = folder / "scenario.yaml"
    file.write_text(file.read_text() + "tool_bounds: [{name: low, pose: {position: [0, 0, 0.1]}, size: [9, 9, 0.1]}]\n")
    scenario = cranny.Scenario(folder)
    start = scenario.start
    motion = scenario.cell().motion(start, start + 0.01)
    again = pickle.loads(pickle.dumps(motion))
    assert not motion and motion.kind == "out-of-bounds" and motion.bound == "low"
    assert (again.kind, again.at, again.bound) == (motion.kind, motion.at, motion.bound)
    assert cranny.plan(scenario).outcome == "start-invalid"


def test_no_path_is_shorter_than_the_lower_bound() -> None:
    scenario = cranny.Scenario("041")
    plans = [cranny.plan(scenario, seed=seed) for seed in range(3)]
    bounds = [plan.least_length for plan in plans]
    lengths = [np.linalg.norm(np.diff(plan.path, axis=0), axis=1).sum() for plan in plans]
    assert all(bound is not None and 0.0 < bound <= min(lengths) for bound in bounds)
