"""Several picks and places in order."""

from __future__ import annotations

import json
import pickle
from pathlib import Path

import numpy as np
import pytest

import cranny


@pytest.fixture(scope="module")
def steps() -> cranny.StepsPlan:
    return cranny.plan_steps(cranny.Scenario("235"))


def test_steps_are_planned_each_in_the_world_that_the_one_before_leaves(steps: cranny.StepsPlan) -> None:
    scenario = steps.scenario
    assert [step["pick"] for step in scenario.steps] == ["column 1", "column 2", "box"]
    assert steps and len(steps) == 3 and all(steps.verify()) and steps.duration_s is not None
    assert steps.duration_s == pytest.approx(sum(step.duration_s or 0.0 for step in steps))
    for before, after in zip(steps, steps[1:], strict=False):
        assert np.array_equal(before.path[-1], after.path[0])
    # The second column cannot be reached as if the first still stood there, nor the first once more.
    moved = scenario.after(steps[0])
    places = [{body.name: body.poses[0] for body in world.world} for world in (scenario, moved)]
    assert np.linalg.norm(places[1]["column 1"][:3, 3] - places[0]["column 1"][:3, 3]) > 0.3
    assert np.array_equal(places[1]["column 2"], places[0]["column 2"])
    assert np.array_equal(moved.start, steps[0].path[-1])
    again = pickle.loads(pickle.dumps(moved))
    assert np.array_equal(again.start, moved.start)


def test_steps_are_written_and_read_and_judged_anew(steps: cranny.StepsPlan, tmp_path: Path) -> None:
    file = tmp_path / "235.plan.json"
    steps.save(file)
    read = cranny.StepsPlan.load(file)
    assert read and all(np.array_equal(a.path, b.path) for a, b in zip(read, steps, strict=True))
    document = json.loads(file.read_text())
    assert document["format"] == "cranny-sequence/1" and document["duration_s"] == pytest.approx(steps.duration_s)
    document["steps"][0], document["steps"][1] = document["steps"][1], document["steps"][0]
    file.write_text(json.dumps(document))
    with pytest.raises(ValueError, match="does not put 'column 1' down"):
        cranny.StepsPlan.load(file)
    with pytest.raises(ValueError, match="no plan of several steps"):
        steps[0].save(tmp_path / "one.plan.json")
        cranny.StepsPlan.load(tmp_path / "one.plan.json")


def test_steps_are_shown_as_one_motion(steps: cranny.StepsPlan) -> None:
    page = steps.scenario.show(steps).html()
    assert "235" in page
    with pytest.raises(ValueError, match="step 2 was planned for another world"):
        steps.scenario.show([steps[0], steps[0]]).html()
    png = steps.scenario.show(steps, width=64, height=48).png()
    assert png.startswith(b"\x89PNG")


def test_what_is_no_task_of_steps_is_refused(steps: cranny.StepsPlan) -> None:
    with pytest.raises(ValueError, match="has no steps"):
        cranny.plan_steps(cranny.Scenario("021"))
    with pytest.raises(TypeError, match="place: the steps"):
        cranny.plan_steps(steps.scenario, place="outside")
    with pytest.raises(ValueError, match="moon"):
        steps.scenario.with_target("moon")
    reach = cranny.plan(cranny.Scenario("031"))
    with pytest.raises(ValueError, match="puts nothing down"):
        cranny.Scenario("031").after(reach)
    with pytest.raises(ValueError, match="column 1"):
        cranny.Scenario("021").after(steps[0])


def test_plans_of_another_scenario_are_no_steps_of_this_one(steps: cranny.StepsPlan) -> None:
    again = cranny.StepsPlan(steps.scenario, list(steps))
    assert again and len(again) == 3 and all(not step.differs for step in again)
    assert not cranny.StepsPlan(steps.scenario, steps[:2])
    with pytest.raises(ValueError, match="does not put 'column 1' down"):
        cranny.StepsPlan(cranny.Scenario("245"), [steps[1], steps[0], steps[2]])
    with pytest.raises(ValueError, match="3 plans of steps, but the scenario has 0"):
        cranny.StepsPlan(cranny.Scenario("021"), list(steps))
    with pytest.raises(AttributeError):
        steps.scenario = cranny.Scenario("021")  # type: ignore[misc]
