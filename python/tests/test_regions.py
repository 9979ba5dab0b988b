"""Regions of poses as goals."""

from __future__ import annotations

import shutil
from pathlib import Path

import cranny
import numpy as np
import pytest

REGIONS = """regions:
  above: {frames: [{pose: {position: [0.5, 0, 0.8]}, x: [-0.1, 0.1], y: [-0.2, 0.2], yaw_deg: [-180, 180],
                    end: {rotation_rpy_deg: [180, 0, 0]}}]}
  far: {frames: [{pose: {position: [9, 9, 9]}}]}
tasks: [{name: look, stages: [{move: {regions: [above]}}, {move: home}]}]
"""


@pytest.fixture
def scenario(tmp_path: Path) -> cranny.Scenario:
    """Scenario of `cranny scenario new` with regions, without grasps."""
    template = Path(__file__).parents[2] / "crates/scenario/src/layout/template"
    folder = Path(shutil.copytree(template, tmp_path / "own"))
    file = folder / "scenario.yaml"
    file.write_text(file.read_text() + REGIONS)
    return cranny.Scenario(folder)


@pytest.mark.parametrize("planner", [None, "cbirrt2", "rrt-connect"])
def test_a_plan_ends_in_the_region(scenario: cranny.Scenario, planner: str | None) -> None:
    assert sorted(scenario.regions) == ["above", "far"]
    plan = cranny.plan(scenario, planner, goal_region="above")
    assert plan.solved and plan.verify()
    pose = scenario.robot.fk(plan.path[-1])
    middle = scenario.regions["above"]["frames"][0]["pose"]["position"]
    assert np.all(np.abs(pose[:3, 3] - middle) <= [0.101, 0.201, 0.001])
    assert pose[2, 2] <= -np.cos(np.radians(1)), "z of the hand is against z of the frame"
    assert np.array_equal(plan.path, cranny.plan(scenario, planner, goal_region=["above"]).path)


def test_a_region_may_be_given_in_the_call_and_in_a_task(scenario: cranny.Scenario) -> None:
    inline = cranny.plan(scenario, goal_region=scenario.regions["above"])
    assert inline.solved and inline.verify()
    there_and_back = cranny.plan(scenario, task="look")
    assert there_and_back.solved and there_and_back.verify()
    assert np.allclose(there_and_back.path[-1], scenario.start)
    assert cranny.plan(scenario, goal_region="far").outcome == "region-out-of-reach"


@pytest.mark.parametrize(
    ("region", "message"),
    [
        ("nowhere", "unknown region 'nowhere'"),
        ({"frames": [{"x": [0.1, -0.1]}]}, "empty"),
        ({"frames": [{"x": [float("nan"), 0.1]}]}, "goal_region"),
        ({"frames": []}, "goal_region"),
        ([], "names no region"),
        (3, "goal_region"),
    ],
)
def test_a_bad_region_is_refused(scenario: cranny.Scenario, region: object, message: str) -> None:
    with pytest.raises((cranny.CrannyError, ValueError, TypeError), match=message):
        cranny.plan(scenario, goal_region=region)


def test_the_symmetry_of_a_target_makes_regions_of_a_grasp() -> None:
    scenario = cranny.Scenario("031")
    regions = scenario.grasp_regions(0)
    assert regions and all(region["moves"] == "hand" for region in regions)
    assert cranny.plan(scenario, goal_region=regions).outcome in {"solved", "budget-exhausted"}
    with pytest.raises(ValueError, match="grasps"):
        scenario.grasp_regions(10**6)
