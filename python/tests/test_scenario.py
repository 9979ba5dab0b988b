"""Scenarios: opening, display, changes, saving; grasps sampled on meshes."""

from __future__ import annotations

import pickle
from pathlib import Path

import cranny
import numpy as np
import pytest
from conftest import package
from numpy.typing import NDArray


def test_a_built_in_scenario_gives_its_robot_world_start_and_grasps(scenario: cranny.Scenario) -> None:
    assert scenario.id == "021" and scenario.criterion == "exact"
    assert scenario.robot.dof == 9 and scenario.start.shape == (9,)
    assert [body.name for body in scenario.world] == ["table", "ball", "floor"]
    target = scenario.target
    assert target is not None and target.name == "ball" and target.kinds == ["sphere"]
    grasps = scenario.grasps
    assert len(grasps) == 200
    assert grasps.poses.shape == (200, 4, 4) and grasps.scores.shape == grasps.widths.shape == (200,)
    rotations = grasps.poses[:, :3, :3]
    np.testing.assert_allclose(rotations @ rotations.transpose(0, 2, 1), np.tile(np.eye(3), (200, 1, 1)), atol=1e-12)
    scores = grasps.scores[grasps.by_score()]
    assert (np.diff(scores) <= 0).all()
    assert cranny.scenario_ids()[0] == "011" and len(cranny.scenario_ids()) == 20


def test_a_box_in_the_way_is_seen_and_saved(scenario: cranny.Scenario, tmp_path: Path) -> None:
    place = scenario.robot.fk(scenario.start)[:3, 3]
    blocked = scenario.with_box("crate", [0.1, 0.2, 0.3], pose=place)
    assert not blocked.cell().is_free(scenario.start) and scenario.cell().is_free(scenario.start)
    contact = blocked.cell().first_contact(scenario.start)
    assert contact is not None and contact.second == "crate" and contact.depth_m > 0.0 and contact.point.shape == (3,)
    assert cranny.plan(blocked).outcome == "start-invalid"
    blocked.save(tmp_path / "blocked")
    read = cranny.Scenario.load(tmp_path / "blocked")
    assert [body.name for body in read.world] == ["table", "crate", "ball", "floor"]
    np.testing.assert_allclose(read.world[1].poses, blocked.world[1].poses, atol=1e-12)
    assert read.world[1].sizes == [[0.1, 0.2, 0.3]]
    q = scenario.robot.sample(2000, seed=4)
    assert np.array_equal(read.cell().is_free(q), blocked.cell().is_free(q))
    with pytest.raises(cranny.CrannyError, match="exists"):
        blocked.save(tmp_path / "blocked")
    assert [body.name for body in read.without_body("crate").world] == [body.name for body in scenario.world]


def test_an_object_is_moved_with_its_grasps(scenario: cranny.Scenario, tmp_path: Path) -> None:
    moved = scenario.with_object_moved([0.0, 0.05, 0.0])
    before, after = scenario.target, moved.target
    assert before is not None and after is not None
    np.testing.assert_allclose(after.poses[0, :3, 3] - before.poses[0, :3, 3], [0.0, 0.05, 0.0], atol=1e-15)
    shift = moved.grasps.poses - scenario.grasps.poses
    np.testing.assert_allclose(shift[:, :3, 3], np.tile([0.0, 0.05, 0.0], (200, 1)), atol=1e-15)
    plan = cranny.plan(moved)
    assert plan and not cranny.verify_path(scenario, plan.path)
    moved.with_criterion("paper").save(tmp_path / "moved")
    assert cranny.Scenario.load(tmp_path / "moved").criterion == "paper"
    bare = scenario.without_body("ball")
    assert bare.target is None
    with pytest.raises(cranny.CrannyError, match="no target"):
        bare.with_object_moved([0.1, 0.0, 0.0])


def test_start_and_grasps_can_be_others(scenario: cranny.Scenario, tmp_path: Path) -> None:
    start = scenario.start + 0.01
    chosen = scenario.grasps.by_score()[:5]
    few = cranny.Grasps(scenario.grasps.poses[chosen], scenario.grasps.scores[chosen])
    altered = scenario.with_start(start).with_grasps(few)
    plan = cranny.plan(altered)
    assert plan.solved and np.array_equal(plan.path[0], start)
    assert plan.grasp is not None and plan.grasp < 5
    few.save(tmp_path / "grasps.csv")
    read = cranny.Grasps.load(tmp_path / "grasps.csv")
    np.testing.assert_allclose(read.poses, few.poses, atol=1e-12)
    assert np.isnan(read.widths).all() and few.covered_by(scenario.grasps) == 1.0
    nearest = few.nearest(few.poses[3])
    assert nearest is not None and nearest[0] == 3 and nearest[1:] == pytest.approx((0.0, 0.0), abs=1e-9)


def test_a_mesh_of_trimesh_is_a_body_and_can_be_grasped(scenario: cranny.Scenario) -> None:
    trimesh = package("trimesh")
    can = trimesh.creation.cylinder(radius=0.03, height=0.12)
    body = cranny.Body.mesh("can", can, pose=[0.2, 0.3, 0.4])
    vertices, faces = body.triangles()
    assert trimesh.Trimesh(vertices, faces).volume == pytest.approx(can.volume)
    grasps = cranny.sample_grasps(can, count=50, seed=3)
    assert len(grasps) == 50 and ((grasps.scores >= 0) & (grasps.scores <= 1)).all()
    # Across the can, or from rim to rim.
    assert grasps.widths.max() <= 0.08 and grasps.widths.min() > 0.0
    again = cranny.sample_grasps((can.vertices, can.faces), count=50, seed=3)
    assert np.array_equal(grasps.poses, again.poses)
    assert scenario.with_body(body).cell().world[1].name == "can"
    with pytest.raises(cranny.CrannyError):
        cranny.Body.mesh("open", (can.vertices, can.faces[:-1]))
    assert cranny.Body.mesh("hull", (can.vertices, can.faces[:-1]), hull=True).kinds == ["mesh"]


def test_a_cell_of_ones_own_bodies_knows_contacts_and_motions() -> None:
    robot = cranny.Robot.panda_mobile()
    start = cranny.Scenario("021").start
    wall = cranny.Body.box("wall", [0.05, 4.0, 3.0], pose=[0.9, 0.0, 1.0])
    cell = cranny.Cell(robot, [wall, cranny.Body.floor(-0.05)])
    beyond = start.copy()
    beyond[1] = 1.0
    assert cell.is_free(start) and not cell.is_free(beyond)
    motion = cell.motion(start, beyond)
    assert not motion and motion.kind == "contact" and motion.at is not None and 0.0 < motion.at < 1.0
    assert motion.contact is not None and motion.contact.second == "wall"
    assert cell.motion(start, start + 0.01).kind == "proven"
    outside = start.copy()
    outside[0] = 2.0
    assert (cell.motion(start, outside).kind, cell.motion(start, outside).joint) == ("out-of-limits", "base_joint_y")
    targets = np.stack([beyond, start + 0.01, start])
    assert cell.motion_is_free(start, targets).tolist() == [False, True, True]
    assert [bool(m) for m in cell.motion(targets, start)] == [False, True, True]
    assert cell.least_clearance(start, start + 0.01) <= cell.clearance(start)
    demanding = cranny.Cell(robot, [wall], margin_m=cell.clearance(start) + 0.01)
    assert not demanding.is_free(start)


def test_batches_give_what_their_rows_give(cell: cranny.Cell, scenario: cranny.Scenario) -> None:
    near: NDArray[np.float64] = scenario.start + 0.3 * (scenario.robot.sample(400, seed=2) - scenario.start)
    free = cell.is_free(near)
    assert free.dtype == np.bool_ and 0 < free.sum() < 400
    assert free.tolist() == [cell.is_free(q) for q in near]
    assert np.array_equal(free, cell.is_free(near, threads=3))
    clearances = cell.clearance(near, threads=2)
    assert clearances.tolist() == [cell.clearance(q) for q in near]
    contacts = cell.first_contact(near, threads=2)
    within = ((scenario.robot.lower <= near) & (near <= scenario.robot.upper)).all(axis=1)
    assert [contact is None for contact in contacts] == (free | ~within & (clearances > 1e-5)).tolist()
    assert cell.is_free(near[:0]).shape == (0,) and cell.first_contact(near[:0]) == []
    assert cell.is_free(near.astype(np.float32)).shape == (400,)
    assert np.array_equal(cell.is_free(np.asfortranarray(near)), free)
    assert np.array_equal(cell.is_free(near[::2]), free[::2])


def test_a_scenario_is_made_of_a_robot_and_bodies_and_survives_a_pickle() -> None:
    robot = cranny.Robot.panda_mobile()
    board = cranny.Body.box("board", [0.4, 0.8, 0.02], pose=[0.9, 0, 0.55])
    can = cranny.Body.cylinder("can", 0.03, length=0.12, pose=[0.8, 0, 0.62])
    scene = cranny.Scenario.of(robot, [board, can, cranny.Body.floor(-0.05)], target="can")
    assert (scene.id, len(scene.world), len(scene.grasps)) == ("scene", 3, 0)
    assert scene.target is not None and scene.target.name == "can"
    made = cranny.plan(scene)
    assert made and made.own_grasp is not None and made.verify()
    again = pickle.loads(pickle.dumps(scene))
    np.testing.assert_array_equal(cranny.plan(again).path, made.path)

    pose = made.own_grasp["world_from_gripper"]
    given = scene.with_grasps(cranny.Grasps(np.array([pose])))
    reached = cranny.plan(given)
    assert reached.solved and reached.grasp == 0


def test_a_configuration_or_a_pose_is_a_goal_too() -> None:
    robot = cranny.Robot.panda_mobile()
    post = cranny.Body.box("post", [0.1, 0.1, 1.5], pose=[0.4, 0, 0.75])
    begin, end = np.array(cranny.Scenario("021").start), np.array(cranny.Scenario("021").start)
    begin[0], end[0] = -0.9, 0.9
    scene = cranny.Scenario.of(robot, [post], start=begin, name="post")
    with pytest.raises(ValueError):
        cranny.plan(scene)
    to_one = cranny.plan(scene.with_goals(end))
    assert to_one.solved and to_one.verify()
    np.testing.assert_array_equal(to_one.path[-1], end)
    blocked = end.copy()
    blocked[1] = 99.0
    either = cranny.plan(pickle.loads(pickle.dumps(scene.with_goals([blocked, end]))))
    np.testing.assert_array_equal(either.path[-1], end)
    to_pose = cranny.plan(scene.with_grasps(cranny.Grasps(robot.fk(end)[None])))
    assert to_pose.solved
    np.testing.assert_allclose(robot.fk(to_pose.path[-1])[:3, 3], robot.fk(end)[:3, 3], atol=1e-3)


def test_goals_are_named_and_are_not_lost_in_a_folder(scenario: cranny.Scenario, tmp_path: Path) -> None:
    q = scenario.robot.sample(40, seed=1)
    free = scenario.cell().is_free(q)
    goals = np.stack([q[free][0], q[~free][0], q[free][1]])
    given = scenario.with_goals(goals)
    assert scenario.goals is None and given.goals is not None and np.array_equal(given.goals, goals)
    assert "3 goals" in repr(given) and "grasps" not in repr(given) and "200 grasps" in repr(scenario)
    assert given.with_grasps(scenario.grasps).goals is None
    problem = cranny.Problem(given, given.start)
    assert np.array_equal(problem.goals(), goals[[0, 2]]) and np.array_equal(problem.goals(1), goals[:1])
    with pytest.raises(ValueError, match=r"goals of with_goals cannot be saved: .*call with_goals again after loading"):
        given.save(tmp_path / "given")
    assert not (tmp_path / "given").exists()


def test_places_go_with_the_body_that_they_are_on(scenario: cranny.Scenario, tmp_path: Path) -> None:
    assert scenario.places == ["outside"]
    for name, changed in (("gone", scenario.without_body("table")), ("other", scenario.with_target("table"))):
        assert changed.places == [] and pickle.loads(pickle.dumps(changed)).places == []
        changed.save(tmp_path / name)
        assert cranny.Scenario.load(tmp_path / name).places == []
    for kept in (scenario.without_body("ball"), scenario.with_target("ball"), scenario.with_box("b", [0.1] * 3)):
        assert kept.places == scenario.places


def test_a_scenario_of_a_built_in_robot_is_saved(scenario: cranny.Scenario, tmp_path: Path) -> None:
    bodies = [cranny.Body.box("crate", [0.2, 0.3, 0.4], pose=[1.2, 0.3, 0.2]), cranny.Body.floor(-0.05)]
    robots = [cranny.Robot.panda_mobile(), cranny.Robot.builtin("panda_mobile"), scenario.robot]
    for index, robot in enumerate(robots):
        made = cranny.Scenario.of(robot, bodies, target="crate", start=scenario.start)
        made.save(tmp_path / f"made{index}")
        read = cranny.Scenario.load(tmp_path / f"made{index}")
        assert [body.name for body in read.world] == ["crate", "floor"]
        np.testing.assert_allclose(read.start, made.start, atol=1e-12)
        q = robot.sample(500, seed=1)
        assert np.array_equal(read.cell().is_free(q), made.cell().is_free(q))


def test_what_makes_no_scenario_is_refused_by_name() -> None:
    robot, box = cranny.Robot.panda_mobile(), cranny.Body.box("box", [0.1, 0.1, 0.1], pose=[2, 0, 0])
    with pytest.raises(ValueError, match="two bodies are called 'box'"):
        cranny.Scenario.of(robot, [box, box])
    with pytest.raises(ValueError, match="target: no body is called 'can'"):
        cranny.Scenario.of(robot, [box], target="can")
    with pytest.raises(ValueError, match="start"):
        cranny.Scenario.of(robot, [box], start=[0.0])
    with pytest.raises(ValueError, match="goals"):
        cranny.Scenario.of(robot, [box]).with_goals([[0.0]])


def test_the_licences_of_others_go_with_the_package() -> None:
    assert "three.js" in cranny.licences() and "pyo3" in cranny.licences()
