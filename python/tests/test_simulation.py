"""Grasps in simulation."""

from __future__ import annotations

import json
import os
import pickle
import signal
import subprocess
import time
from pathlib import Path

import cranny
import numpy as np
import pytest
from test_front_ends import program


def first_grasps(scenario: cranny.Scenario, count: int) -> cranny.Grasps:
    """The first grasps of a scenario."""
    return cranny.Grasps(scenario.grasps.poses[:count], scenario.grasps.scores[:count])


def test_the_package_and_the_command_line_give_the_same_rows() -> None:
    scenario = cranny.Scenario("021")
    some = first_grasps(scenario, 3)
    rows = cranny.simulate_grasps(scenario, some, support_only=True, trials=2, seed=4)
    assert [row["grasp"] for row in rows] == [0, 1, 2]
    assert rows == cranny.simulate_grasps(scenario, some, support_only=True, trials=2, seed=4)
    words = ["simulate", "grasps", "021", "--support-only", "--trials", "2", "--seed", "4", "--json", "--grasp", "1"]
    answer = subprocess.run([program(), *words], check=True, capture_output=True)
    (row,) = json.loads(answer.stdout)["rows"]
    assert (row["outcome"], row["robust"]) == (rows[1]["outcome"], rows[1]["robust"])
    # The pose was converted to a matrix and back.
    assert row["translation_error_m"] == pytest.approx(rows[1]["translation_error_m"], abs=1e-5)


def test_robust_scores_stand_beside_the_geometric_ones(tmp_path: Path) -> None:
    scenario = cranny.Scenario("021")
    some = first_grasps(scenario, 3)
    assert np.isnan(some.robust_scores).all()
    assert np.isnan(some.robust_trials).all()
    rows = cranny.simulate_grasps(scenario, some, support_only=True, trials=2)
    scores = [row["robust"]["score"] for row in rows[:2]] + [np.nan]
    robust = cranny.Grasps(some.poses, some.scores, robust_scores=scores, robust_trials=[2, 2, np.nan])
    robust.save(tmp_path / "robust.csv")
    for known in (robust, cranny.Grasps.load(tmp_path / "robust.csv"), pickle.loads(pickle.dumps(robust))):
        np.testing.assert_array_equal(known.scores, some.scores)
        np.testing.assert_array_equal(known.robust_scores, scores)
        np.testing.assert_array_equal(known.robust_trials, [2, 2, np.nan])


def test_physics_counts_where_a_plan_is_asked_so() -> None:
    scenario = cranny.Scenario("021")
    grasps = scenario.grasps
    held = np.where(np.arange(len(grasps)) == 139, 4, 1) / 4
    robust = cranny.Grasps(
        grasps.poses,
        grasps.scores,
        widths=grasps.widths,
        robust_scores=held,
        robust_trials=np.full(len(grasps), 4),
    )
    plan = cranny.plan(scenario.with_grasps(robust), "ik-rrt", iterations=3000, score="physics")
    assert (plan.grasp, plan.report["score"]) == (139, "physics")
    with pytest.raises(ValueError, match="'geometric', 'physics' or 'load'"):
        cranny.plan(scenario, score="best")


def test_what_weighs_too_much_is_not_held() -> None:
    scenario = cranny.Scenario("021")
    (row,) = cranny.simulate_grasps(scenario, first_grasps(scenario, 1), mass_kg=50.0)
    assert row["outcome"] != "held"
    assert row["held_s"] < 1.0


@pytest.mark.skipif(os.name == "nt", reason="signals of this kind are those of Unix")
def test_a_signal_handler_that_raises_stops_the_tests() -> None:
    class Enough(Exception):
        pass

    def handler(*_: object) -> None:
        raise Enough

    scenario = cranny.Scenario("021")
    before = signal.signal(signal.SIGALRM, handler)
    begin = time.monotonic()
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.3)
        # All of them take many minutes.
        with pytest.raises(Enough):
            cranny.simulate_grasps(scenario, trials=1000)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
    assert time.monotonic() - begin < 30.0
    assert len(cranny.simulate_grasps(scenario, first_grasps(scenario, 1))) == 1


def test_the_package_and_the_command_line_execute_a_plan_alike(tmp_path: Path) -> None:
    plan = cranny.plan(cranny.Scenario("021"), "ik-rrt", iterations=3000, margin_m=0.005, grasp_margin_m=0.001)
    plan.save(tmp_path / "a.plan.json")
    row = cranny.simulate_plan(plan, lift_m=0.05)
    words = ["simulate", "plan", "021", str(tmp_path / "a.plan.json"), "--lift", "50", "--json"]
    answer = subprocess.run([program(), *words], check=False, capture_output=True)
    assert row == json.loads(answer.stdout)
    assert row["scenario"] == "021"
    # A batch returns one row per plan, in the same order.
    heavy, light = (cranny.simulate_plan([plan, plan], lift_m=lift_m, mass_kg=mass_kg) for lift_m, mass_kg in [(0, 50), (0.05, None)])
    assert light == [row, row]
    assert heavy[0] == heavy[1] != row
    assert cranny.simulate_plan([]) == []


def test_what_is_no_plan_is_not_executed() -> None:
    plan = cranny.plan(cranny.Scenario("021"), iterations=1)
    with pytest.raises(ValueError, match="no path"):
        cranny.simulate_plan(plan)
    with pytest.raises(TypeError, match="a Plan or a sequence"):
        cranny.simulate_plan("021.plan.json")  # type: ignore[call-overload]
    with pytest.raises(TypeError, match="a Plan or a sequence"):
        cranny.simulate_plan([plan, None])  # type: ignore[list-item]


def test_bad_input_is_refused() -> None:
    scenario = cranny.Scenario("021")
    with pytest.raises(cranny.CrannyError, match="closing force"):
        cranny.simulate_grasps(scenario, closing_force_n=-1.0)
    with pytest.raises(cranny.CrannyError, match="mass"):
        cranny.simulate_grasps(scenario, mass_kg=0.0)
    with pytest.raises(ValueError, match="trials"):
        cranny.simulate_grasps(scenario, trials=100_000)
