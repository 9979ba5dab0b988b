"""Tasks of several stages."""

from __future__ import annotations

import json
import pickle
from pathlib import Path

import numpy as np
import pytest

import cranny


@pytest.fixture(scope="module")
def scenario() -> cranny.Scenario:
    return cranny.Scenario("235")


@pytest.fixture(scope="module")
def steps(scenario: cranny.Scenario) -> cranny.Plan:
    return cranny.plan(scenario, task="steps")


def test_a_task_is_planned_each_stage_in_the_world_that_those_before_leave(
    scenario: cranny.Scenario, steps: cranny.Plan
) -> None:
    stages = scenario.tasks["steps"]
    assert [stage["pick"] for stage in stages if "pick" in stage] == ["column 1", "column 2", "box"]
    assert steps and steps.verify() and steps.duration_s is not None and steps.task_name == "steps"
    assert steps.task == stages
    assert [segment["stage"] for segment in steps.segments] == sorted(segment["stage"] for segment in steps.segments)
    moved = scenario.after(steps)
    places = [{body.name: body.poses[0] for body in world.world} for world in (scenario, moved)]
    for name in ("column 1", "column 2", "box"):
        assert np.linalg.norm(places[1][name][:3, 3] - places[0][name][:3, 3]) > 0.3
    assert np.array_equal(moved.start, steps.path[-1])
    again = pickle.loads(pickle.dumps(moved))
    assert np.array_equal(again.start, moved.start)


def test_a_task_goes_with_a_body_that_it_names(scenario: cranny.Scenario) -> None:
    bare = scenario.without_body("column 1")
    assert bare.tasks == {} and bare.places == scenario.places and len(bare.world) == len(scenario.world) - 1
    crate = scenario.with_box("crate", [0.1, 0.1, 0.1], pose=[-1.0, -1.0, 0.5])
    assert crate.without_body("crate").tasks == scenario.tasks == crate.with_target("column 1").tasks


def test_stages_can_be_given_in_the_call(scenario: cranny.Scenario) -> None:
    column = {"pick": "column 1"}
    plan = cranny.plan(scenario, task=[column, {"place": "other side"}, {"move": "home"}])
    assert plan and plan.verify() and plan.task_name is None
    away = cranny.plan(scenario, task=[column, {"move": "clear", "clear_m": 0.02}])
    assert away and away.segments[-1]["attached"] == "column 1"
    for wrong, says in [
        ([{"place": "outside"}], "stage 1: nothing is in the hand"),
        ([column, {"pick": "column 2"}], "stage 2: the hand already holds"),
        ([{"pick": "moon"}], "moon"),
        ([{"pick": "box", "place": "outside"}], "a stage has one of"),
        ([{"move": "up"}], "'home', 'clear', configurations or a region"),
        (3, "task"),
    ]:
        with pytest.raises((ValueError, TypeError), match=says):
            cranny.plan(scenario, task=wrong)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="no task 'tidy'.*'steps'"):
        cranny.plan(scenario, task="tidy")


def test_a_plan_of_a_task_is_written_and_read_and_judged_anew(steps: cranny.Plan, tmp_path: Path) -> None:
    file = tmp_path / "235.plan.json"
    steps.save(file)
    read = cranny.Plan.load(file)
    assert read and np.array_equal(read.path, steps.path) and not read.differs
    document = json.loads(file.read_text())
    assert document["format"] == "cranny-plan/2" and len(document["timing"]["hand_s"]) == 6
    document["task"][0], document["task"][3] = document["task"][3], document["task"][0]
    file.write_text(json.dumps(document))
    assert not cranny.Plan.load(file), "the stages are not those of the task that it names"


def test_a_task_is_shown_as_one_motion(scenario: cranny.Scenario, steps: cranny.Plan) -> None:
    assert "235" in scenario.show(steps).html()
    assert scenario.show(steps, width=64, height=48).png().startswith(b"\x89PNG")


def test_what_puts_nothing_down_leaves_no_other_world(scenario: cranny.Scenario, steps: cranny.Plan) -> None:
    with pytest.raises(ValueError, match="moon"):
        scenario.with_target("moon")
    carried = cranny.plan(cranny.Scenario("031"), carry="home")
    with pytest.raises(ValueError, match="put nothing down"):
        cranny.Scenario("031").after(carried)
    with pytest.raises(ValueError, match="no body"):
        cranny.Scenario("021").after(steps)
