"""Shared resources of the tests: released data, external packages, robots."""

from __future__ import annotations

import importlib
import os
from collections.abc import Container
from pathlib import Path
from types import ModuleType
from typing import Any

import cranny
import numpy as np
import pytest
from numpy.typing import NDArray

HERE = Path(__file__).parent
ROBOTS = HERE / "robots"
REPOSITORY = HERE.parents[1]


def lacking(what: str) -> None:
    """Skips a test, or fails it if CRANNY_REQUIRE_ALL forbids skipping."""
    if os.environ.get("CRANNY_REQUIRE_ALL") == "1":
        pytest.fail(what)
    pytest.skip(what)


def package(name: str) -> ModuleType:
    """Imports an external package; skips the test without it."""
    try:
        return importlib.import_module(name)
    except ImportError as reason:
        lacking(f"no package {name} ({reason}); xtask/python-requirements.txt names its version")
        raise


def released_folder() -> Path:
    """Folder of the paper's released data."""
    named = os.environ.get("CRANNY_DATA")
    if not named:
        lacking("CRANNY_DATA is unset: no released data")
    return Path(named or "") / "jogramop"


@pytest.fixture(scope="session")
def scenario() -> cranny.Scenario:
    """A ball under a table."""
    return cranny.Scenario("021")


@pytest.fixture(scope="session")
def cell(scenario: cranny.Scenario) -> cranny.Cell:
    """The built-in robot in the scenario."""
    return scenario.cell()


@pytest.fixture(scope="session")
def plan(scenario: cranny.Scenario) -> cranny.Plan:
    """A plan for the scenario."""
    return cranny.plan(scenario)


class Reference:
    """Pinocchio's model of a robot, with the joints of a Cranny robot."""

    solid_meshes: Container[str] = ()
    """Links whose meshes represent solids."""

    def __init__(self, urdf: Path, robot: cranny.Robot, fixed: dict[str, float] | None = None) -> None:
        self.pin: Any = package("pinocchio")
        whole = self.pin.buildModelFromUrdf(str(urdf))
        fixed = fixed or {}
        locked = [whole.getJointId(name) for name in fixed]
        at = self.pin.neutral(whole)
        for name, value in fixed.items():
            at[whole.joints[whole.getJointId(name)].idx_q] = value
        collision, folders = self.pin.GeometryType.COLLISION, [str(urdf.parent)]
        geometry = self.pin.buildGeomFromUrdf(whole, str(urdf), collision, package_dirs=folders)
        self.model, self.geometry = self.pin.buildReducedModel(whole, geometry, locked, at)
        self.data = self.model.createData()
        self.robot = robot
        self.joints = [self.model.joints[self.model.getJointId(name)] for name in robot.joint_names]

    def configuration(self, q: NDArray[np.float64]) -> NDArray[np.float64]:
        """Configuration in Pinocchio's format, in which a continuous joint is a cosine and a sine."""
        configuration = self.pin.neutral(self.model)
        for joint, value in zip(self.joints, q, strict=True):
            values = [value] if joint.nq == 1 else [np.cos(value), np.sin(value)]
            configuration[joint.idx_q : joint.idx_q + joint.nq] = values
        return np.asarray(configuration)

    def pose(self, q: NDArray[np.float64], link: str) -> NDArray[np.float64]:
        """`root_from_link`, (4, 4)."""
        self.pin.framesForwardKinematics(self.model, self.data, self.configuration(q))
        return np.asarray(self.data.oMf[self.model.getFrameId(link)].homogeneous)

    def forces(self, q: NDArray[np.float64], *rates: NDArray[np.float64]) -> NDArray[np.float64]:
        """Forces of the robot's joints at these velocities and accelerations."""
        velocity, acceleration = np.zeros(self.model.nv), np.zeros(self.model.nv)
        for joint, *of_joint in zip(self.joints, *rates, strict=True):
            velocity[joint.idx_v], acceleration[joint.idx_v] = of_joint
        forces = self.pin.rnea(self.model, self.data, self.configuration(q), velocity, acceleration)
        return np.asarray(forces)[[joint.idx_v for joint in self.joints]]

    def jacobian(self, q: NDArray[np.float64], link: str) -> NDArray[np.float64]:
        """(6, dof) at the link's origin, in the axes of the root frame, columns in the robot's order."""
        frame = self.model.getFrameId(link)
        axes = self.pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        whole = self.pin.computeFrameJacobian(self.model, self.data, self.configuration(q), frame, axes)
        return np.asarray(whole[:, [joint.idx_v for joint in self.joints]])
