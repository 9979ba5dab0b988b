"""Objects sent to another process arrive unchanged, or an error names what to send instead."""

from __future__ import annotations

import pickle
import shutil
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any, TypeVar

import cranny
import numpy as np
import pytest
from conftest import ROBOTS
from numpy.typing import NDArray

Thing = TypeVar("Thing")


def again(thing: Thing) -> Thing:
    """The object after a round trip through pickle."""
    copy: Thing = pickle.loads(pickle.dumps(thing))
    return copy


def verdicts(cell: cranny.Cell, q: NDArray[np.float64]) -> Any:
    """Verdicts from another process."""
    return cell.is_free(q)


def test_a_scenario_and_its_cell_reach_other_processes(scenario: cranny.Scenario) -> None:
    cell = scenario.cell(margin_m=0.002)
    q = scenario.robot.sample(200, seed=3)
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        there = pool.submit(verdicts, cell, q).result()
    assert (there == cell.is_free(q)).all() and there.any() and not there.all()


def test_an_altered_scenario_keeps_every_alteration(scenario: cranny.Scenario) -> None:
    shift = np.array([0.0, 0.05, 0.0])
    start = scenario.start
    altered = scenario.with_box("crate", [0.1, 0.2, 0.3], pose=[0.9, -0.6, 0.2])
    altered = altered.with_body(cranny.Body.capsule("post", 0.03, length=0.4, pose=[0.0, 1.5, 0.2])).with_object_moved(shift)
    start[0] += 0.1
    altered = altered.with_start(start).without_body("floor").with_grasps(altered.grasps).with_criterion("paper")
    # Later changes of the caller's array must not affect the scenario.
    start[:], shift[:] = 0.0, 9.0
    copy = again(altered)
    assert repr(copy) == repr(altered) and copy.criterion == "paper"
    assert (copy.start == altered.start).all() and copy.start[0] != 0.0
    assert [body.name for body in copy.world] == [body.name for body in altered.world]
    for mine, other in zip(altered.world, copy.world, strict=True):
        assert mine.kinds == other.kinds and (mine.poses == other.poses).all()
    assert (copy.grasps.poses == altered.grasps.poses).all()


def test_a_plan_keeps_its_digits(scenario: cranny.Scenario, plan: cranny.Plan) -> None:
    copy = again(plan)
    assert copy and (copy.path == plan.path).all() and copy.grasp == plan.grasp
    assert plan.times is not None and copy.times is not None and (copy.times == plan.times).all()
    assert copy.verify().clearance_m == plan.verify().clearance_m
    failed = again(cranny.plan(scenario, "j-plus-rrt", iterations=1))
    assert not failed and failed.path.shape == (0, 9) and failed.outcome == "budget-exhausted"


def test_grasps_samples_robots_and_bodies_are_the_same(scenario: cranny.Scenario, plan: cranny.Plan) -> None:
    grasps = again(scenario.grasps)
    assert (grasps.poses == scenario.grasps.poses).all()
    assert np.array_equal(grasps.scores, scenario.grasps.scores, equal_nan=True)
    assert np.array_equal(grasps.widths, scenario.grasps.widths, equal_nan=True)
    samples = plan.sample(50.0)
    assert (again(samples).positions == samples.positions).all() and again(samples).joint_names == samples.joint_names
    q = scenario.robot.sample(5)
    for robot in (
        scenario.robot,
        scenario.cell().robot,
        cranny.Robot.panda_mobile(),
    ):
        assert (again(robot).fk(q) == robot.fk(q)).all()
    for arm in (cranny.Robot.from_urdf(ROBOTS / "ur5_like.urdf"), cranny.Robot.builtin("ur5e")):
        assert again(arm).joint_names == arm.joint_names
    with pytest.raises(ValueError, match="fetch_like"):
        cranny.Robot.builtin("nobody")
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    for body in (
        cranny.Body.box("a", [1.0, 2.0, 3.0]),
        cranny.Body.sphere("b", 0.1, pose=[1.0, 0.0, 0.0]),
        cranny.Body.cylinder("c", 0.1, length=0.2, pose=np.eye(4)),
        cranny.Body.mesh("d", (corners, faces)),
        cranny.Body.mesh("e", (corners, faces), hull=True),
        cranny.Body.floor(-0.1),
    ):
        copy = again(body)
        assert (copy.name, copy.kinds, copy.sizes) == (body.name, body.kinds, body.sizes)
        assert all((mine == other).all() for mine, other in zip(copy.triangles(), body.triangles(), strict=True))


def test_what_a_cell_says_is_plain(cell: cranny.Cell) -> None:
    start, inside = np.array(cell.robot.lower), np.array(cell.robot.upper)
    answers: list[Any] = [cell.motion(start, inside), *cell.contacts(inside), *cell.contacts(start)]
    assert len(answers) > 1
    for answer in answers:
        assert repr(again(answer)) == repr(answer)


def test_files_that_have_changed_are_noticed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cranny.Scenario("021").save(tmp_path / "mine")
    monkeypatch.chdir(tmp_path)
    kept = pickle.dumps(cranny.Scenario("mine"))
    # Relative paths keep their meaning in another folder.
    monkeypatch.chdir("/")
    assert pickle.loads(kept).id == "mine"
    text = (tmp_path / "mine/scenario.yaml").read_text()
    (tmp_path / "mine/scenario.yaml").write_text(text.replace("0.03235]", "0.0324]", 1))
    with pytest.raises(cranny.CrannyError, match="changed since it was pickled: open it anew"):
        pickle.loads(kept)
    shutil.rmtree(tmp_path / "mine")
    with pytest.raises(cranny.CrannyError, match="mine"):
        pickle.loads(kept)


@pytest.mark.parametrize(
    ("thing", "hint"),
    [
        (lambda s: s.world[0], "this Body cannot be pickled: it is part of a scene"),
        (lambda s: cranny.plan(s).verify(), "this Verification cannot be pickled: pickle its violations"),
    ],
)
def test_what_cannot_be_pickled_says_what_to_send(
    scenario: cranny.Scenario, thing: Callable[[cranny.Scenario], Any], hint: str
) -> None:
    with pytest.raises(TypeError, match=hint):
        pickle.dumps(thing(scenario))
