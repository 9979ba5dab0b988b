"""Inputs based on problems reported by users of other tools, each with the command and the answer from its README."""

import csv
import math
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import REPOSITORY, lacking, package

import cranny

REPORTS = REPOSITORY / "crates/cli/tests/fixtures/reports"
DEEP = "arm is 86.317 mm deep in wall"
BOX = "100.0 × 20.0 × 30.0 mm, 12 triangles"
VERIFY, PLAN, CHECK = "verify --robot bot.urdf --moveit", "plan -o out.plan.json --moveit", "robot check"
NOT_UNDERSTOOD = "is not understood, and may change where things are or how they move"

CASES: list[tuple[str, str, int, str]] = [
    *(
        ("scene_wrapped", f"{VERIFY} {scene} request.yaml path.csv", 1, DEEP)
        for scene in ("service.yaml", "planning_scene.yaml", "list.yaml", "world_only.yaml", "good.yaml", "rviz.scene")
    ),
    ("scene_wrapped", f"{VERIFY} typo.yaml request.yaml path.csv", 2, "typo.yaml:3: unknown field `collision_object`"),
    ("scene_wrapped", f"{VERIFY} empty.yaml request.yaml path.csv", 2, "no world"),
    ("scene_wrapped", f"{VERIFY} good.yaml r_typo.yaml path.csv", 2, "unknown field `joint_states`"),
    ("scene_wrapped", f"{VERIFY} good.yaml r_cons.yaml path.csv", 2, "unknown field `position_constraint`"),
    *(
        ("silent_urdf", f"{CHECK} {name}.urdf", 2, NOT_UNDERSTOOD)
        for name in ("XYZ", "degrees", "pos", "pose", "twogeo", "twogeo2", "upper")
    ),
    ("silent_urdf", f"{CHECK} nested.urdf", 2, "<collision> of link `bar` has no <geometry>"),
    ("silent_urdf", f"{CHECK} plain.urdf", 0, "1 joint moves"),
    ("virtual_fixed_in_group", f"{PLAN} scene.yaml request.yaml", 0, "solved by reach"),
    *(
        ("ros_dump", f"{PLAN} {scene}.yaml request.yaml", 0, "44.42 mm or more")
        for scene in ("scene", "doc_sep", "no_octomap", "null_octomap", "op_bin", "op_str")
    ),
    ("srdf_default", f"{PLAN} scene.yaml request.yaml", 1, "halo touches post, 0.17 mm deep"),
    ("start_outside", f"{PLAN} scene.yaml r2.00001.yaml", 1, "-2.00001"),
    ("start_outside", f"{PLAN} scene.yaml r2.001.yaml", 1, "j1 is -2.0010, outside its limits [-2.0000, 2.0000]"),
    ("joint_limits_yaml", f"{PLAN} scene.yaml request.yaml", 1, "j1 is 1.0000, outside its limits [-0.5000, 0.5000]"),
    ("quat_rounded", f"{PLAN} scene.yaml request.yaml", 0, "solved by reach"),
    *(("mesh_paths/my_arm/urdf", f"{CHECK} p{index}.urdf", 0, "1 joint moves") for index in (*range(1, 9), 14, 16)),
    *(("mesh_paths/my_arm/urdf", f"{CHECK} p{index}.urdf", 2, f"p{index}.urdf:1: link `b`") for index in (13, 15, 17, 18)),
    ("mesh_paths", f"{CHECK} my_arm/urdf/p1.urdf", 0, "1 joint moves"),
    *(("obj_forms", f"object show {path.name}", 0, BOX) for path in (REPORTS / "obj_forms").iterdir() if path.stem != "comma"),
    ("obj_forms", "object show comma.obj", 2, "line 2: '0,1' is no number"),
    *(("lfs_mesh", f"object show table.{ending}", 2, "it is a Git LFS pointer") for ending in ("dae", "obj", "ply", "stl")),
    *(
        ("xml_forms", f"{CHECK} {name}.urdf", 0, "1 joint moves")
        for name in ("bom", "deg", "gz", "jp", "newline", "ns", "plus", "single")
    ),
    *(
        ("xml_forms", f"{CHECK} {name}.urdf", 2, f"error: {name}.urdf")
        for name in ("comma", "dup_axis", "ellipsoid", "entity", "gbk", "pi", "radiusless", "scale1", "space_name", "utf16")
    ),
    ("xacro_args", "robot add arm.urdf.xacro --bare -o made", 2, "xacro:arg: missing attribute 'default'"),
    ("xacro_args", "robot add find.urdf.xacro --bare -o made", 2, "package my_arm_description is in no folder above the file"),
    ("xacro_args", "robot add ok.urdf.xacro --xacro reech=1 --bare -o made", 2, "no argument reech (it asks for: reach)"),
]


def run(folder: Path, words: str) -> subprocess.CompletedProcess[str]:
    program = os.environ.get("CRANNY_BIN")
    if not program:
        lacking("CRANNY_BIN is unset: no program")
    # The xacro of the test environment.
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    command = [str(program), *words.split(" ")]
    return subprocess.run(
        command, cwd=folder, env={**os.environ, "PATH": path}, capture_output=True, text=True, check=False
    )


@pytest.fixture(scope="module")
def reports(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy in which the tests may write plans and tables."""
    return Path(shutil.copytree(REPORTS, tmp_path_factory.mktemp("reports") / "reports"))


@pytest.mark.parametrize(("folder", "words", "code", "answer"), CASES)
def test_a_command_gives_the_right_answer(reports: Path, folder: str, words: str, code: int, answer: str) -> None:
    package("xacro")
    ended = run(reports / folder, words)
    assert ended.returncode == code and answer in ended.stdout + ended.stderr, ended.stdout + ended.stderr


def test_a_package_is_found_above_a_xacro_file(reports: Path) -> None:
    package("xacro")
    ended = run(reports / "xacro_args", "robot add ws/my_arm_description/urdf/find.urdf.xacro --bare -o made")
    assert ended.returncode == 0 and "nothing is free above the lowest point" in ended.stdout, ended.stdout + ended.stderr


def test_a_joint_keeps_the_limits_of_what_mimics_it(reports: Path) -> None:
    robot = cranny.Robot.from_urdf(reports / "mimic_limits/lift.urdf", tip="stage2")
    # The lower joint moves 1.5 times as far, at most 0.25 m and 0.1 m/s.
    assert np.allclose([robot.upper[0], robot.velocity[0]], [0.25 / 1.5, 0.1 / 1.5])
    scene = cranny.Scenario.of(robot, [cranny.Body.sphere("far", 0.03, pose=[3, 0, 0.8])], start=[0.0])
    refused = cranny.plan(scene.with_goals([[0.4]]))
    faults = str(refused.report["goal_faults"])
    assert refused.outcome == "goals-invalid" and "upper" in faults and "0.166" in faults, faults
    motion = cranny.plan(scene.with_goals([[0.16]])).sample(100)
    assert 1.5 * np.abs(motion.velocities).max() <= 0.1 + 1e-9
    assert not cranny.Cell(robot, []).is_free([0.4])


def test_a_continuous_joint_takes_the_least_turn(reports: Path) -> None:
    robot = cranny.Robot.from_urdf(reports / "continuous_far/roll.urdf", tip="fore")
    scene = cranny.Scenario.of(robot, [cranny.Body.sphere("s", 0.05, pose=[2, 0, 0])], start=[0, 3.0])
    goal = scene.with_goals([[0.5, -3.0]])
    assert math.isclose(cranny.plan(goal).path[-1][1] - 3.0, 2 * math.pi - 6, abs_tol=1e-9)
    assert cranny.verify_path(goal, [[0, 3.0], [0.5, -3.0 + 2 * math.pi]])
    assert cranny.plan(cranny.Scenario.of(robot, [], start=[0, 37.7]).with_goals([[0.5, 15.0]]))
    held = cranny.Robot.from_urdf(reports / "continuous_far/roll.urdf", tip="arm", joints=["lift"], fixed={"roll": 37.7})
    assert held.dof == 1


def test_a_message_is_judged_by_the_names_of_its_joints(reports: Path) -> None:
    case = reports / "ros_positions/case.py"
    ended = subprocess.run([sys.executable, case], capture_output=True, text=True, check=True)
    assert ended.stdout.endswith("False must be False: fore 68.6 mm deep in post\n"), ended.stdout


def test_no_grasp_is_on_a_face_that_is_sealed_inside(reports: Path) -> None:
    ended = run(reports / "inner_faces", "grasps sample off.obj --count 200 -o x.csv")
    assert ended.returncode == 0, ended.stderr
    with (reports / "inner_faces/x.csv").open(encoding="utf-8") as file:
        widths = [float(row["width_m"]) for row in csv.DictReader(file)]
    # The outer box is at least 50 mm wide, the inner one 20 mm.
    assert len(widths) == 200 and min(widths) > 0.03
