"""Forward kinematics, Jacobians and inverse kinematics, compared with Pinocchio."""

from __future__ import annotations

from pathlib import Path

import cranny
import numpy as np
import pytest
from conftest import HERE, ROBOTS, Reference, released_folder

ROBOT_NAMES = ["ur5_like", "fetch_like", "released"]
CONFIGURATIONS = 500
AGREEMENT = 1e-9
"""Tolerance in metres, or for entries of a rotation or a Jacobian."""


def open_robot(name: str) -> tuple[cranny.Robot, Reference]:
    """A robot as read by Cranny and by Pinocchio."""
    if name == "released":
        urdf = released_folder() / "robots/franka_panda/mobile_panda.urdf"
        fingers = {f"panda_finger_joint{k}": 0.04 for k in (1, 2)}
        robot = cranny.Robot.from_urdf(urdf, tip="panda_grasptarget", fixed=fingers)
        return robot, Reference(urdf, robot, fingers)
    urdf = ROBOTS / f"{name}.urdf"
    robot = cranny.Robot.from_urdf(urdf)
    return robot, Reference(urdf, robot)


@pytest.mark.parametrize("name", ROBOT_NAMES)
def test_poses_and_jacobians_of_every_link_agree_with_pinocchio(name: str) -> None:
    robot, reference = open_robot(name)
    configurations = robot.sample(CONFIGURATIONS, seed=7)
    for link in robot.link_names:
        poses = robot.fk(configurations, link)
        jacobians = robot.jacobian(configurations, link)
        for q, pose, jacobian in zip(configurations, poses, jacobians, strict=True):
            np.testing.assert_allclose(pose, reference.pose(q, link), rtol=0.0, atol=AGREEMENT)
            np.testing.assert_allclose(jacobian, reference.jacobian(q, link), rtol=0.0, atol=AGREEMENT)


@pytest.mark.parametrize("name", ROBOT_NAMES)
def test_limits_and_names_are_those_that_pinocchio_reads(name: str) -> None:
    robot, reference = open_robot(name)
    for index, joint in enumerate(reference.joints):
        if joint.nq == 1:
            assert robot.lower[index] == reference.model.lowerPositionLimit[joint.idx_q]
            assert robot.upper[index] == reference.model.upperPositionLimit[joint.idx_q]
        else:
            assert robot.upper[index] == -robot.lower[index] == 3 * np.pi
        assert robot.velocity[index] == reference.model.velocityLimit[joint.idx_v]
    assert set(robot.joint_units) <= {"m", "rad"} and len(robot.joint_names) == robot.dof


@pytest.mark.parametrize("name", ROBOT_NAMES)
def test_a_batch_gives_what_its_rows_give_on_any_number_of_threads(name: str) -> None:
    robot, _ = open_robot(name)
    configurations = robot.sample(1000, seed=1)
    poses = robot.fk(configurations)
    jacobians = robot.jacobian(configurations)
    assert poses.shape == (1000, 4, 4) and jacobians.shape == (1000, 6, robot.dof)
    for row in (0, 500, 999):
        assert np.array_equal(poses[row], robot.fk(configurations[row]))
        assert np.array_equal(jacobians[row], robot.jacobian(configurations[row]))
    for threads in (2, 5, None):
        assert np.array_equal(poses, robot.fk(configurations, threads=threads))
    assert robot.fk(configurations[:0]).shape == (0, 4, 4)


@pytest.mark.parametrize("name", ROBOT_NAMES)
def test_solutions_of_inverse_kinematics_lead_back_to_their_pose(name: str) -> None:
    robot, _ = open_robot(name)
    targets = robot.fk(robot.sample(20, seed=3))
    found = robot.ik(targets, count=3, seed=5, threads=2)
    assert len(found) == 20
    for target, solutions in zip(targets, found, strict=True):
        assert solutions.shape[1:] == (robot.dof,)
        assert ((robot.lower <= solutions) & (solutions <= robot.upper)).all()
        for pose in robot.fk(solutions):
            assert np.linalg.norm(pose[:3, 3] - target[:3, 3]) <= 1e-4
            turn = np.arccos(np.clip((np.trace(pose[:3, :3].T @ target[:3, :3]) - 1) / 2, -1, 1))
            assert turn <= 1e-3 + 1e-6
    assert sum(len(solutions) > 0 for solutions in found) >= 18
    again = robot.ik(targets, count=3, seed=5)
    assert all(np.array_equal(a, b) for a, b in zip(found, again, strict=True))


def test_inverse_kinematics_in_a_cell_gives_free_configurations(
    scenario: cranny.Scenario, cell: cranny.Cell
) -> None:
    robot, pose = scenario.robot, scenario.grasps.poses[139]
    solutions = robot.ik(pose, count=4, cell=cell, seed=2)
    assert len(solutions) > 0 and cell.is_free(solutions).all()
    near = robot.ik(pose, start=solutions[0])
    assert near.shape == (1, robot.dof) and np.abs(near[0] - solutions[0]).max() < 0.1


def test_a_robot_of_text_and_one_of_a_file_are_the_same(tmp_path: Path) -> None:
    text = (ROBOTS / "ur5_like.urdf").read_text()
    (tmp_path / "r.urdf").write_text(text)
    a, b = cranny.Robot.from_urdf_text(text), cranny.Robot.from_urdf(tmp_path / "r.urdf")
    q = a.sample(10)
    assert a.tip == "tool0" and np.array_equal(a.fk(q), b.fk(q))
    with pytest.raises(cranny.CrannyError, match=r"r\.urdf"):
        (tmp_path / "r.urdf").write_text(text[:200])
        cranny.Robot.from_urdf(tmp_path / "r.urdf")


def test_joints_can_be_chosen_and_ordered() -> None:
    names = ["elbow_flex_joint", "torso_lift_joint"]
    robot = cranny.Robot.from_urdf(ROBOTS / "fetch_like.urdf", joints=names, fixed={"base_slide_x": 0.5})
    assert robot.joint_names == names and robot.fk([0.0, 0.0]).shape == (4, 4)
    assert robot.fk([0.0, 0.0], "base_link")[0, 3] == 0.5


def test_forces_of_joints_agree_with_pinocchio() -> None:
    urdf = HERE.parents[1] / "crates" / "scenario" / "robots" / "fetch_like" / "fetch_like.urdf"
    robot = cranny.Robot.from_urdf(urdf)
    open_fingers = {f"{side}_gripper_finger_joint": 0.05 for side in "lr"}
    reference = Reference(urdf, robot, open_fingers)
    draws = np.random.default_rng(3)
    q = robot.sample(200, seed=11)
    velocity, acceleration = (draws.uniform(-2.0, 2.0, q.shape) for _ in range(2))
    reference.model.gravity.linear = np.array([0.0, 0.0, -9.81])
    forces = robot.joint_forces(q, velocity, acceleration)
    for row, force in enumerate(forces):
        expected = reference.forces(q[row], velocity[row], acceleration[row])
        np.testing.assert_allclose(force, expected, rtol=1e-9, atol=1e-9)
    single = robot.joint_forces(q[0], velocity[0], acceleration[0])
    np.testing.assert_array_equal(single, forces[0])
    with pytest.raises(ValueError, match="the same shape"):
        robot.joint_forces(q, velocity[0], acceleration[0])
    with pytest.raises(ValueError, match="up has the length 2"):
        robot.joint_forces(q[0], velocity[0], acceleration[0], up=(0, 0, 2))
