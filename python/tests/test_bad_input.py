"""Any invalid argument raises a Python exception that states the given and the expected value."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cranny
import numpy as np
import pytest
from cranny import _cranny
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

NAN = float("nan")


@pytest.mark.parametrize(
    ("q", "kind", "message"),
    [
        (np.zeros(8), ValueError, r"q has shape \(8,\), but \(9,\) or \(N, 9\) for the 9 joints of panda"),
        (np.zeros((3, 10)), ValueError, r"q has shape \(3, 10\), but \(9,\) or \(N, 9\)"),
        (np.zeros((2, 3, 9)), ValueError, r"\(2, 3, 9\)"),
        (0.0, ValueError, r"q has shape \(\)"),
        ([], ValueError, r"q has shape \(0,\)"),
        (np.zeros(9, dtype=complex), TypeError, "q has dtype complex128, but float64 is expected"),
        (np.zeros(9, dtype=bool), TypeError, "dtype bool"),
        (np.array(["a"] * 9), TypeError, "dtype <U1"),
        (np.array([None] * 9), TypeError, "dtype object"),
        ([[0.0] * 9, [0.0] * 8], TypeError, "an array of numbers is expected"),
        (None, TypeError, "dtype object"),
        ({"q": 1}, TypeError, "dtype object"),
        ([0.0] * 8 + [NAN], ValueError, r"NaN at \[8\], but every value must be finite"),
        ([[0.0] * 9, [0.0] * 3 + [np.inf] + [0.0] * 5], ValueError, r"inf at \[1, 3\]"),
        ([10**400] * 9, TypeError, "dtype object"),
    ],
)
def test_what_is_no_configuration_is_refused_everywhere(
    cell: cranny.Cell, q: Any, kind: type[Exception], message: str
) -> None:
    robot = cell.robot
    good = np.zeros(9)
    calls: list[Callable[[], Any]] = [
        lambda: robot.fk(q),
        lambda: robot.jacobian(q),
        lambda: cell.is_free(q),
        lambda: cell.clearance(q),
        lambda: cell.first_contact(q),
    ]
    for call in calls:
        with pytest.raises(kind, match=message):
            call()
    for call in (lambda: cell.motion_is_free(q, good), lambda: cell.motion(good, q), lambda: cell.least_clearance(q, good)):
        with pytest.raises(kind):
            call()


def test_two_batches_of_different_length_are_shown_side_by_side(cell: cranny.Cell) -> None:
    with pytest.raises(ValueError, match=r"a has shape \(2, 9\) and b has shape \(3, 9\)"):
        cell.motion_is_free(np.zeros((2, 9)), np.zeros((3, 9)))


@pytest.mark.parametrize(
    ("pose", "message"),
    [
        (np.eye(3), r"pose has shape \(3, 3\), but \(4, 4\) or \(N, 4, 4\) is expected"),
        (np.ones((4, 4)), "pose: "),
        (np.diag([1.0, 1.0, -1.0, 1.0]), "pose: "),
        (np.stack([np.eye(4), 2 * np.eye(4)]), r"pose\[1\]: "),
        (np.full((4, 4), NAN), "finite"),
    ],
)
def test_what_is_no_pose_is_refused(scenario: cranny.Scenario, pose: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        scenario.robot.ik(pose)
    with pytest.raises(ValueError, match="pose"):
        cranny.Body.box("b", [1.0, 1.0, 1.0], pose=pose)


@pytest.mark.parametrize(
    "call",
    [
        lambda s: cranny.Body.box("b", [1.0, -1.0, 1.0]),
        lambda s: cranny.Body.box("b", [1.0, 1.0]),
        lambda s: cranny.Body.sphere("b", NAN),
        lambda s: cranny.Body.floor(float("inf")),
        lambda s: cranny.Body.box("b", [1.0, 1.0, 1.0], pose=[1e9, 0.0, 0.0]).name and s.with_box("b", [1, 1, 1], pose=[1e9, 0, 0]),
        lambda s: cranny.Body.mesh("b", ([[0.0, 0.0, 0.0]], [[0, 1, 2]])),
        lambda s: cranny.Body.mesh("b", (np.zeros((3, 3)), [[0, 1, 0.5]])),
        lambda s: cranny.Body.mesh("b", (np.zeros((3, 2)), [[0, 1, 2]])),
        lambda s: cranny.Body.mesh("b", (np.zeros((0, 3)), np.zeros((0, 3), dtype=int))),
        lambda s: cranny.sample_grasps((np.zeros((3, 3)), [[0, 1, 2]])),
        lambda s: cranny.sample_grasps((np.eye(3), [[0, 1, 2]]), friction=-1.0, count=1),
        lambda s: cranny.sample_grasps((np.eye(3), [[0, 1, 2]]), count=10**12),
        lambda s: cranny.sample_grasps((np.eye(3), [[0, 1, 2]]), approaches=0, count=1),
        lambda s: s.with_box("ball", [1.0, 1.0, 1.0]),
        lambda s: s.without_body("no such body"),
        lambda s: s.cell(margin_m=-1.0),
        lambda s: s.cell(margin_m=NAN),
        lambda s: cranny.Cell(s.robot, [cranny.Body.sphere("b", 1.0)] * 2),
        lambda s: s.with_start(np.zeros(3)),
        lambda s: s.with_criterion("exakt"),
        lambda s: cranny.Grasps(np.eye(4)[None], scores=[1.5]),
        lambda s: cranny.Grasps(np.eye(4)[None], widths=[-0.1]),
        lambda s: cranny.Grasps(np.eye(4)[None], scores=[0.5, 0.5]),
        lambda s: cranny.Grasps(np.eye(4)[None], robust_scores=[1.5], robust_trials=[32]),
        lambda s: cranny.Grasps(np.eye(4)[None], robust_scores=[0.5], robust_trials=[2.5]),
        lambda s: cranny.Grasps(np.eye(4)[None], robust_scores=[0.5]),
        lambda s: s.grasps.nearest(np.eye(4)[None]),
        lambda s: s.grasps.covered_by(s.grasps, threshold=NAN),
        lambda s: s.grasps.covered_by(s.grasps, threshold=-1.0),
        lambda s: s.robot.sample(10**15),
        lambda s: s.robot.ik(np.eye(4), attempts=10**12),
        lambda s: s.robot.ik(np.eye(4), cell=cranny.Cell(cranny.Robot.from_urdf_text(SLIDE), [])),
        lambda s: s.robot.fk(s.start, threads=0),
        lambda s: s.robot.fk(s.start, threads=10**9),
        lambda s: cranny.plan(s, "no such planner"),
        lambda s: cranny.plan(s, settings={"no such setting": 1}),
        lambda s: cranny.plan(s, "ik-rrt", settings={"p_goal": "often"}),
        lambda s: cranny.plan(s, time_limit_s=0.0),
        lambda s: cranny.plan(s, time_limit_s=NAN),
        lambda s: cranny.plan(s, optimise_s=1.0, score_weight=-1.0),
        lambda s: cranny.plan(s, optimise_s=1.0, cost="speed"),
        lambda s: cranny.plan(s.with_criterion("paper"), "ik-rrt", margin_m=0.1),
        lambda s: cranny.plan(s).sample(0.0),
        lambda s: cranny.plan(s).sample(1e9),
        lambda s: cranny.plan(s).sample(1e-300),
        lambda s: cranny.plan(s).sample_ways(9e-4),
        lambda s: cranny.plan(s, "j-plus-rrt", iterations=1).sample(),
        lambda s: cranny.plan(s, "j-plus-rrt", iterations=1).verify(),
        lambda s: cranny.verify_path(s, np.zeros((0, 9))),
        lambda s: cranny.verify_path(s, np.zeros((2, 8))),
        lambda s: cranny.Scenario("999"),
        lambda s: cranny.Scenario.load("021"),
        lambda s: cranny.Scenario("021", robot="no such.urdf"),
        lambda s: cranny.Robot.from_urdf("no such.urdf"),
        lambda s: cranny.Robot.from_urdf_text("<robot"),
        lambda s: cranny.Robot.from_urdf_text(SLIDE, tip="no such link"),
        lambda s: cranny.Grasps.load("no such.csv"),
        lambda s: cranny.Plan.load("no such.plan.json"),
        lambda s: cranny.Plan.load(__file__),
        lambda s: _cranny.moving_picture(s, cranny.plan(s), rate=0),
    ],
)
def test_values_that_are_none_are_refused(scenario: cranny.Scenario, call: Callable[[cranny.Scenario], Any]) -> None:
    with pytest.raises(ValueError) as refusal:
        call(scenario)
    assert len(str(refusal.value)) > 15, "a message says what is wrong"


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: cranny.Body.box("b", [1.0, -1.0, 1.0]), "each length of a box must be .* at most 2000, but is -1$"),
        (lambda: cranny.Body.box("b", [1.0, 1.0, 3000.0]), "each length of a box .* is 3000$"),
        (lambda: cranny.Body.cylinder("b", 0.1, length=-1.0), "the length of a cylinder .* is -1$"),
        (lambda: cranny.Body.capsule("b", 0.1, length=NAN), "the length of a capsule .* is NaN$"),
    ],
)
def test_a_length_is_shown_as_it_was_given(call: Callable[[], Any], message: str) -> None:
    with pytest.raises(cranny.CrannyError, match=message):
        call()


HUGE = 10**5000
"""Too large for Python itself to print."""


@pytest.mark.parametrize(
    ("name", "call"),
    [
        ("seed", lambda s, n: cranny.plan(s, seed=n)),
        ("iterations", lambda s, n: cranny.plan(s, iterations=n)),
        ("seed", lambda s, n: s.robot.sample(1, seed=n)),
        ("count", lambda s, n: s.robot.sample(n)),
        ("seed", lambda s, n: s.robot.ik(np.eye(4), seed=n)),
        ("count", lambda s, n: s.robot.ik(np.eye(4), count=n)),
        ("attempts", lambda s, n: s.robot.ik(np.eye(4), attempts=n)),
        ("threads", lambda s, n: s.robot.fk(s.start, threads=n)),
        ("threads", lambda s, n: s.cell().is_free(s.start, threads=n)),
        ("threads", lambda s, n: s.cell().clearance(s.start, threads=n)),
        ("threads", lambda s, n: s.cell().motion(s.start, s.start, threads=n)),
        ("count", lambda s, n: cranny.sample_grasps((np.eye(3), [[0, 1, 2]]), count=n)),
        ("candidates", lambda s, n: cranny.sample_grasps((np.eye(3), [[0, 1, 2]]), candidates=n)),
        ("approaches", lambda s, n: cranny.sample_grasps((np.eye(3), [[0, 1, 2]]), approaches=n)),
        ("seed", lambda s, n: cranny.sample_grasps((np.eye(3), [[0, 1, 2]]), seed=n)),
        ("width", lambda s, n: s.show(width=n)),
        ("height", lambda s, n: _cranny.picture(s, height=n)),
        ("rate", lambda s, n: _cranny.moving_picture(s, cranny.plan(s), rate=n)),
        ("runs", lambda s, n: cranny.bench.run(["021"], ["reach"], output="none.db", runs=n)),
        ("first_seed", lambda s, n: cranny.bench.run(["021"], ["reach"], output="none.db", first_seed=n)),
        ("iterations", lambda s, n: cranny.bench.run(["021"], ["reach"], output="none.db", iterations=n)),
        ("memory_limit_mb", lambda s, n: cranny.bench.run(["021"], ["reach"], output="none.db", memory_limit_mb=n)),
        ("workers", lambda s, n: cranny.bench.run(["021"], ["reach"], output="none.db", workers=n)),
    ],
)
def test_a_whole_number_out_of_range_is_shown_with_its_range(
    scenario: cranny.Scenario, name: str, call: Callable[[cranny.Scenario, Any], Any]
) -> None:
    for number, shown in ((-1, "-1"), (2**64, str(2**64)), (-(2**200), str(-(2**200))), (HUGE, "huge")):
        with pytest.raises(ValueError, match=f"{name} is {shown}, but a whole number from [01]?[0-9]* to [0-9]+ is expected"):
            call(scenario, number)
    for thing in (1.5, "1", [1]):
        with pytest.raises(TypeError, match=f"{name}: a whole number is expected, not "):
            call(scenario, thing)


def test_a_robot_that_is_called_says_how_one_is_made() -> None:
    for call in (lambda: cranny.Robot(), lambda: cranny.Robot("panda.urdf"), lambda: cranny.Robot(path="x")):  # type: ignore
        with pytest.raises(TypeError, match=r"Robot\.from_urdf\(path\).*Robot\.builtin\(name\).*scenario\.robot"):
            call()


SLIDE = """<robot name="slide"><link name="rail"/><link name="cart"/>
  <joint name="drive" type="prismatic"><parent link="rail"/><child link="cart"/><axis xyz="1 0 0"/>
    <limit lower="-1" upper="1" velocity="0.5" effort="1"/></joint></robot>"""


@pytest.mark.parametrize(
    "call",
    [
        lambda s: cranny.Body.mesh("b", object()),
        lambda s: cranny.Body.mesh("b", (1, 2, 3)),
        lambda s: cranny.plan("021"),
        lambda s: cranny.plan(s, settings=[1]),
        lambda s: cranny.plan(s, settings={"x": object()}),
        lambda s: cranny.plan(s, seed="1"),
        lambda s: cranny.Cell(s.robot, [1]),
        lambda s: cranny.Scenario(21),
        lambda s: s.with_body("box"),
        lambda s: cranny.bench.run("021", ["reach"]),
        lambda s: cranny.Robot(),
        lambda s: cranny.planner(3),
    ],
)
def test_things_of_another_kind_are_refused(scenario: cranny.Scenario, call: Callable[[cranny.Scenario], Any]) -> None:
    with pytest.raises(TypeError):
        call(scenario)


def test_objects_outlive_what_they_came_from() -> None:
    cell = cranny.Scenario("021").cell()
    robot = cell.robot
    poses = cranny.Scenario("021").grasps.poses
    del cell
    assert robot.fk(np.zeros(9)).shape == (4, 4) and poses.sum() == poses.sum()
    with pytest.raises(AttributeError):
        robot.name = "other"  # type: ignore[misc]


def test_an_array_that_is_not_aligned_or_not_writeable_is_read(cell: cranny.Cell) -> None:
    q = np.zeros(9)
    shifted = np.frombuffer(b"x" + q.tobytes(), dtype=np.float64, offset=1)
    assert cell.is_free(shifted) == cell.is_free(q)
    swapped = q.astype(">f8")
    assert cell.is_free(swapped) == cell.is_free(q)
    q.flags.writeable = False
    assert cell.is_free(q) in (True, False)


NUMBERS = st.one_of(
    st.floats(),
    st.integers(),
    st.complex_numbers(),
    st.none(),
    st.text(max_size=5),
    st.binary(max_size=5),
)
SHAPES = arrays.array_shapes(min_dims=0, max_dims=4, min_side=0, max_side=10)
DTYPES = st.sampled_from(["f8", "f4", "f2", ">f8", "i8", "u1", "c16", "?", "O", "U3", "M8[s]"])
ANYTHING = st.one_of(
    NUMBERS,
    st.lists(NUMBERS, max_size=10),
    st.lists(st.lists(st.floats(), max_size=9), max_size=3),
    st.dictionaries(st.text(max_size=3), NUMBERS, max_size=2),
    st.builds(np.empty, SHAPES, DTYPES),
    arrays.arrays(np.float64, st.sampled_from([(9,), (4, 4), (3,), (2, 9), (0, 9), (1, 4, 4)])),
    arrays.arrays(np.float64, st.sampled_from([(9,), (5, 9)]), elements=st.floats(-4, 4)),
    st.just(np.eye(4)),
    st.tuples(st.builds(np.ones, SHAPES), st.builds(np.zeros, SHAPES, st.just("i8"))),
)

CRASHING = (SystemError, MemoryError, RecursionError)
"""Exceptions that must never reach a caller; a panic is noticed by its class, which is not an Exception."""


@settings(
    max_examples=300,
    deadline=None,
    suppress_health_check=list(HealthCheck),
    # Plain runs repeat the same cases; runs with CRANNY_LONG=1 draw others.
    derandomize=os.environ.get("CRANNY_LONG") != "1",
)
@given(data=st.data())
def test_nothing_that_a_caller_passes_crashes_the_interpreter(
    data: st.DataObject, scenario: cranny.Scenario, cell: cranny.Cell, tmp_path_factory: pytest.TempPathFactory
) -> None:
    robot, grasps = scenario.robot, scenario.grasps
    small = st.one_of(ANYTHING, st.integers(-3, 40))
    folder = tmp_path_factory.getbasetemp()
    calls = [
        lambda a, b: robot.fk(a, threads=b),
        lambda a, b: robot.fk(a, b),
        lambda a, b: robot.jacobian(a, b),
        lambda a, b: robot.ik(a, start=b, attempts=5),
        lambda a, b: robot.ik(a, count=b, attempts=5),
        lambda a, b: robot.sample(a, seed=b),
        lambda a, b: cell.is_free(a, threads=b),
        lambda a, b: cell.clearance(a, threads=b),
        lambda a, b: cell.first_contact(a, threads=b),
        lambda a, b: cell.contacts(a),
        lambda a, b: cell.motion_is_free(a, b),
        lambda a, b: cell.motion(a, b),
        lambda a, b: cell.least_clearance(a, b),
        lambda a, b: cranny.Cell(a, b),
        lambda a, b: cranny.Cell(robot, [cranny.Body.box("b", a, pose=b)]).is_free(scenario.start),
        lambda a, b: cranny.Cell(robot, [cranny.Body.cylinder("b", a, length=b)]).clearance(scenario.start),
        lambda a, b: cranny.Cell(robot, [cranny.Body.mesh("b", (a, b), hull=True)]).is_free(scenario.start),
        lambda a, b: cranny.Body.mesh("b", a, pose=b),
        lambda a, b: cranny.Body.capsule(a, b, length=b),
        lambda a, b: cranny.Grasps(a, b),
        lambda a, b: grasps.nearest(a),
        lambda a, b: grasps.covered_by(a, threshold=b),
        lambda a, b: cranny.sample_grasps((a, b), count=3),
        lambda a, b: cranny.sample_grasps(a, count=b),
        lambda a, b: cranny.plan(scenario.with_start(a), iterations=b, time_limit_s=0.2),
        lambda a, b: cranny.plan(scenario, settings=a, seed=b, time_limit_s=0.2),
        lambda a, b: cranny.plan(scenario, margin_m=a, grasp_margin_m=b, time_limit_s=0.2),
        lambda a, b: cranny.verify_path(scenario, a, margin_m=b),
        lambda a, b: scenario.with_object_moved(a),
        lambda a, b: scenario.with_box(a, b),
        lambda a, b: cranny.Scenario(a, criterion=b),
        lambda a, b: cranny.Robot.from_urdf_text(a, tip=b),
        lambda a, b: cranny.Robot.from_urdf(a, joints=b),
        lambda a, b: cranny.MoveItProblem(a, b),
        lambda a, b: cranny.bench.run(a, b, output=folder / "x.db"),
        lambda a, b: cranny.bench.load(a),
        lambda a, b: scenario.show(width=a, height=b, view="top"),
    ]
    call = data.draw(st.sampled_from(range(len(calls))))
    a, b = data.draw(small), data.draw(small)
    try:
        calls[call](a, b)
    except CRASHING:
        raise
    except (ValueError, TypeError, KeyError, OSError, DeprecationWarning):
        # KeyError: an unknown link; OSError: an invalid path. NumPy warns of a one-element array used as a number.
        pass


def test_a_masked_value_is_not_the_one_below_its_mask() -> None:
    poses = np.tile(np.eye(4), (2, 1, 1))
    scores = np.ma.masked_array([0.5, 0.7], mask=[False, True])
    found = cranny.Grasps(poses, scores).scores
    assert found[0] == 0.5
    assert np.isnan(found[1])
    mask = np.zeros((2, 4, 4), dtype=bool)
    mask[1, 0, 3] = True
    with pytest.raises(ValueError, match="nan|NaN"):
        cranny.Grasps(np.ma.masked_array(poses, mask=mask))
