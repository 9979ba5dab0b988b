"""Grasps in MuJoCo: Coulomb's law in Cranny's exported model, with the figures from the tests of its own engine."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import REPOSITORY, package

import cranny
from cranny import mujoco_grasps
from cranny.mujoco_grasps import GraspModel

EXPERIMENT = REPOSITORY / "crates/sim/tests/golden/cube_experiment.json"


@pytest.fixture
def cube() -> GraspModel:
    """A cube of 4 cm and 200 g on the floor, and a small hand."""
    package("mujoco")
    return GraspModel(mujoco_grasps.load(EXPERIMENT))


def with_friction(cube: GraspModel, friction: float) -> None:
    """Changes the object's friction, and its torsional and rolling friction in proportion."""
    of_object = cube.model.geom_bodyid == cube.model.body("object").id
    cube.model.geom_friction[of_object] *= friction / cube.model.geom_friction[of_object][:, :1]


def slip_begins(cube: GraspModel, limit_s: float, before_step: Callable[[float], None]) -> float:
    """Simulates until the cube has moved at 1 mm/s for 0.02 s; returns the time at which that began (s)."""
    at = cube.model.joint("object").dofadr[0]
    slow_s, step_s = 0.0, float(cube.experiment["step_s"])
    while cube.time_s < limit_s:
        before_step(cube.time_s)
        cube.step()
        moves = np.linalg.norm(cube.data.qvel[at : at + 3]) > 1e-3 and cube.time_s > 0.5
        slow_s = slow_s + step_s if moves else 0.0
        if slow_s > 0.02:
            return cube.time_s - slow_s
    raise AssertionError("it does not slip")


@pytest.mark.parametrize("friction", [0.1, 0.24, 0.5, 0.9])
def test_on_a_plane_that_tilts_slip_begins_at_the_angle_of_friction(cube: GraspModel, friction: float) -> None:
    with_friction(cube, friction)
    cube.open_at(cube.grasp(1))
    expected = math.atan(friction)

    def angle(time_s: float) -> float:
        return expected * (0.9 + 0.05 * time_s)

    def tilt(time_s: float) -> None:
        cube.model.opt.gravity[:] = 9.81 * np.array([math.sin(angle(time_s)), 0.0, -math.cos(angle(time_s))])

    ratio = math.tan(angle(slip_begins(cube, 30.0, tilt))) / friction
    assert ratio == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize(("friction", "force_n"), [(0.24, 5.0), (0.24, 70.0), (0.5, 20.0), (0.9, 40.0)])
def test_in_a_hand_slip_begins_at_twice_the_friction_times_the_closing_force(
    cube: GraspModel, friction: float, force_n: float
) -> None:
    with_friction(cube, friction)
    cube.experiment = {**cube.experiment, "closing_force_n": force_n}
    cube.model.actuator_forcerange[:] = [-force_n, force_n]
    cube.open_at(cube.grasp(0))
    cube.model.opt.gravity[:] = 0.0
    limit_n = 2.0 * friction * force_n
    body = cube.model.body("object").id
    pressed: list[float | None] = []

    # The hand closes for 1 s; then the pull grows to 1.5 times the limit within 2 s.
    def pull_n(time_s: float) -> float:
        return 0.75 * limit_n * max(0.0, time_s - 1.0)

    def pull(time_s: float) -> None:
        if not pressed and time_s >= 1.0:
            pressed.extend(cube.pressures())
        cube.data.xfrc_applied[body, 2] = pull_n(time_s)

    ratio = pull_n(slip_begins(cube, 3.0, pull)) / limit_n
    assert ratio == pytest.approx(1.0, abs=0.02)
    assert pressed == [pytest.approx(force_n, rel=0.02)] * 2


def test_the_cube_is_held_and_the_air_is_not(cube: GraspModel) -> None:
    held, air = mujoco_grasps.run_all(cube.experiment)
    assert held.outcome == "held" and held.contact_force_n == pytest.approx(40.0, rel=0.02)
    assert held.translation_error_m < 1e-3 and held.rotation_error_rad < 0.02 and held.held_s == pytest.approx(1.8)
    assert air.outcome == "never-closed" and air.held_s == 0.0 and air.contact_force_n == 0.0


def test_without_friction_it_is_not_held(cube: GraspModel) -> None:
    with_friction(cube, 1e-5)
    assert cube.run(0).outcome in ("dropped", "slipped")


def test_the_same_experiment_gives_the_same_runs(cube: GraspModel) -> None:
    assert cube.run(0) == cube.run(0) == GraspModel(cube.experiment).run(0)


@pytest.mark.parametrize("task", [{"carry": "home"}, {"place": "outside"}])
def test_both_engines_execute_a_plan_alike(task: dict[str, str]) -> None:
    plan = cranny.plan(cranny.Scenario("012"), **task)
    assert plan.hold is not None and plan.hold["factor"] >= 1.5
    here = cranny.simulate_plan(plan)
    there = mujoco_grasps.run_plan(cranny.plan_experiment(plan))
    assert here["is_kept"] and there.is_kept
    assert ("placed" in here) == (there.placed is not None) == ("place" in task)
    if there.placed is not None:
        assert here["placed"]["is_there"] and there.stands
        assert here["placed"]["translation_m"] == pytest.approx(there.placed[0], abs=0.004)


@pytest.mark.parametrize("text", ["[]", "{}", '{"grasps": []}'])
def test_what_is_no_experiment_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "bad.json").write_text(text)
    with pytest.raises(ValueError, match=r"bad\.json is no experiment"):
        mujoco_grasps.load(tmp_path / "bad.json")


def test_without_the_package_it_is_said_what_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    hidden: Any = None
    monkeypatch.setitem(__import__("sys").modules, "mujoco", hidden)
    with pytest.raises(ImportError, match=r"pip install cranny\[mujoco\]"):
        GraspModel(mujoco_grasps.load(EXPERIMENT))
