"""Trajectories as ROS 2 messages, and MoveIt's planning scenes."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import cranny
import numpy as np
import pytest
from conftest import package, released_folder
from cranny.own_planner import answer


def test_a_trajectory_is_a_message_and_comes_back(scenario: cranny.Scenario, plan: cranny.Plan) -> None:
    message = cranny.ros.joint_trajectory(plan, rate=25.0, frame_id="base")
    assert set(message) == {"header", "joint_names", "points"} and message["header"]["frame_id"] == "base"
    assert message["joint_names"] == scenario.robot.joint_names
    point = message["points"][3]
    assert set(point) == {"positions", "velocities", "accelerations", "effort", "time_from_start"}
    assert point["time_from_start"] == {"sec": 0, "nanosec": 120_000_000}
    times, positions = cranny.ros.positions_of(message)
    samples = plan.sample(25.0)
    assert np.array_equal(positions, samples.positions)
    np.testing.assert_allclose(times, samples.times, atol=1e-9)
    verdict = cranny.verify_path(scenario, positions)
    assert verdict, verdict.violations


def test_a_task_is_messages_to_arm_and_gripper(scenario: cranny.Scenario, plan: cranny.Plan) -> None:
    assert [whom for whom, _ in cranny.ros.task(plan)] == ["arm"]
    carried = cranny.plan(scenario, carry="home")
    steps = cranny.ros.task(carried, rate=50.0)
    assert [whom for whom, _ in steps] == ["gripper", "arm", "gripper", "arm"]
    (_, opened), (_, reach), (_, closed), (_, onward) = steps
    assert opened["position"] == 0.08 and closed["max_effort"] > 0.0
    assert abs(closed["position"] - carried.segments[1]["opening_m"]) < 1e-12
    assert reach["points"][-1]["positions"] == onward["points"][0]["positions"]
    assert onward["points"][-1]["positions"] == carried.path[-1].tolist()
    assert all(speed == 0.0 for speed in onward["points"][0]["velocities"])


def test_a_franka_hand_gets_width_tolerances_speed_and_force(scenario: cranny.Scenario, plan: cranny.Plan) -> None:
    assert [whom for whom, _ in cranny.ros.franka_task(plan)] == ["arm"]
    placed = cranny.plan(scenario, place="outside")
    steps = cranny.ros.franka_task(placed, rate=50.0, tolerance=0.003)
    assert [whom for whom, _ in steps] == ["move", "arm", "grasp", "arm", "move", "arm"]
    grasp = steps[2][1]
    assert grasp["epsilon"] == {"inner": 0.003, "outer": 0.003} and grasp["force"] == 70.0 and grasp["speed"] == 0.1
    assert 0.03 < grasp["width"] < 0.08
    with pytest.raises(ValueError, match="above 0"):
        cranny.ros.franka_task(placed, tolerance=0.0)


def test_its_yaml_is_what_a_yaml_reader_reads(plan: cranny.Plan, tmp_path: Path) -> None:
    yaml = package("yaml")
    message = cranny.ros.joint_trajectory(plan, rate=20.0)
    cranny.ros.save_yaml(message, tmp_path / "t.yaml")
    read = yaml.safe_load((tmp_path / "t.yaml").read_text())
    times, positions = cranny.ros.positions_of(read)
    assert positions.tolist() == cranny.ros.positions_of(message)[1].tolist() and len(times) == len(message["points"])
    assert read["points"][0]["effort"] == [] and read["header"] == message["header"]


ARM = """<robot name="arm"><link name="foot"/>
<link name="upper"><collision><origin xyz="0.2 0 0"/><geometry><box size="0.4 0.05 0.05"/></geometry></collision></link>
<link name="fore"><collision><origin xyz="0.2 0 0"/><geometry><box size="0.4 0.04 0.04"/></geometry></collision></link>
<joint name="shoulder" type="revolute"><parent link="foot"/><child link="upper"/><axis xyz="0 0 1"/>
<limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
<joint name="elbow" type="revolute"><origin xyz="0.42 0 0"/><parent link="upper"/><child link="fore"/><axis xyz="0 0 1"/>
<limit lower="-2" upper="2" velocity="1" effort="1"/></joint></robot>"""


def test_joints_are_known_by_their_names() -> None:
    robot = cranny.Robot.from_urdf_text(ARM, tip="fore")
    post = cranny.Body.sphere("post", 0.05, pose=[0.62, 0.45, 0])
    scene = cranny.Scenario.of(robot, [post], start=[0, 0])

    def message(names: list[str], *rows: list[float]) -> dict[str, object]:
        stamp = {"sec": 0, "nanosec": 0}
        return {"joint_names": names, "points": [{"positions": row, "time_from_start": stamp} for row in rows]}

    # The shoulder swings through the post; the elbow alone would not.
    _, path = cranny.ros.positions_of(message(["elbow", "shoulder"], [0.0, 0.0], [0.0, 1.3]))
    assert path.joint_names == ("elbow", "shoulder") and path.tolist() == [[0.0, 0.0], [0.0, 1.3]]
    assert not cranny.verify_path(scene, path, any_end=True)
    assert cranny.verify_path(scene, np.asarray(path), any_end=True)
    assert not cranny.verify_path(scene, path[0:2], any_end=True)
    assert np.array_equal(path.in_order_of(["shoulder", "elbow"]), [[0.0, 0.0], [1.3, 0.0]])
    assert scene.cell().is_free(path).tolist() == [True, True]
    # A single row is one configuration, also in a pickle.
    assert pickle.loads(pickle.dumps(scene.with_start(path[1:2]))).start.tolist() == [1.3, 0.0]
    goals = pickle.loads(pickle.dumps(scene.with_goals(path))).goals
    assert goals is not None and goals.tolist() == [[0.0, 0.0], [1.3, 0.0]]
    with pytest.raises(ValueError, match=r"start has shape \(2, 2\)"):
        scene.with_start(path)
    for names, row in [(["elbow"], [0.0]), (["elbow", "wrist"], [0.0, 0.0]), (["a", "elbow", "shoulder"], [0.0] * 3)]:
        _, other = cranny.ros.positions_of(message(names, row))
        with pytest.raises(ValueError, match="but the robot has shoulder, elbow"):
            cranny.verify_path(scene, other, any_end=True)
    with pytest.raises(ValueError, match=r"points\[0\] has 4 positions for 2"):
        cranny.ros.positions_of(message(["elbow", "shoulder"], [0.0] * 4))
    late = message(["elbow"], [0.0], [0.1])
    late["points"][0]["time_from_start"] = {"sec": 1, "nanosec": 0}  # type: ignore[index]
    with pytest.raises(ValueError, match=r"points\[1\] is at 0.0 s, before"):
        cranny.ros.positions_of(late)
    with pytest.raises(ValueError, match="named twice"):
        cranny.ros.positions_of(message(["elbow", "elbow"], [0.0, 0.0]))


def test_the_path_of_ones_own_planner_is_put_into_order(scenario: cranny.Scenario, tmp_path: Path) -> None:
    scenario.save(tmp_path / "scene")
    names, rows = scenario.robot.joint_names, scenario.robot.sample(3, seed=1)
    question: dict[str, Any] = {
        "files": {"cranny": str(tmp_path / "scene")},
        "criterion": "exact",
        "start": scenario.start.tolist(),
        "margin_m": 0.0,
        "grasp_margin_m": 0.0,
        "object_margin_m": 0.0,
        "time_limit_s": 10.0,
        "seed": 0,
    }

    def of(path: Any) -> Any:
        return answer(lambda problem, budget, seed: path, question, 0.0)["waypoints"]

    assert of(cranny.ros.JointPositions(names[::-1], rows[:, ::-1])) == of(rows) == rows.tolist()
    with pytest.raises(ValueError, match="but the robot has"):
        of(cranny.ros.JointPositions([*names[:-1], "wrist"], rows))


@pytest.mark.parametrize("scenario_id", ["011", "021", "034", "043"])
def test_a_world_survives_a_planning_scene(scenario_id: str, tmp_path: Path) -> None:
    yaml = package("yaml")
    scenario = cranny.Scenario(scenario_id)
    scenario.save_moveit_scene(tmp_path / "scene.yaml")
    message = yaml.safe_load((tmp_path / "scene.yaml").read_text())
    assert message["name"] == scenario_id
    assert message["robot_state"]["joint_state"]["position"] == pytest.approx(scenario.start.tolist())
    objects = {item["id"]: item for item in message["world"]["collision_objects"]}
    assert set(objects) == {body.name for body in scenario.world}
    assert objects["floor"]["primitives"][0] == {"type": "box", "dimensions": [20.0, 20.0, 1.0]}
    read = scenario.with_moveit_scene(tmp_path / "scene.yaml")
    target = scenario.target
    assert target is not None and read.target is not None and read.target.name == target.name
    q = scenario.robot.sample(5000, seed=9)
    here, there = scenario.cell(), read.cell()
    differ = here.is_free(q) != there.is_free(q)
    # The floor is now a box; all other verdicts must agree, except for contacts within rounding.
    assert (np.abs(here.clearance(q[differ]) - there.clearance(q[differ])) < 1e-6).all()
    assert cranny.plan(read).solved


def test_a_problem_of_motion_bench_maker_is_planned() -> None:
    folder = released_folder().parent / "motion_bench_maker"
    scene = sorted(folder.glob("*/scene0001.yaml"))[0]
    problem = cranny.MoveItProblem(scene, scene.with_name("request0001.yaml"))
    assert problem.goals.shape == (1, problem.robot.dof) and len(problem.world) > 0
    plan = cranny.plan(problem)
    assert plan.solved and plan.grasp is None
    np.testing.assert_allclose(plan.path[-1], problem.goals[0], atol=1e-12)
    assert problem.cell().motion_is_free(plan.path[:-1], plan.path[1:]).all()
    assert all(isinstance(deviation, str) for deviation in problem.deviations)


def test_damaged_scenes_are_refused(scenario: cranny.Scenario, tmp_path: Path) -> None:
    scenario.save_moveit_scene(tmp_path / "scene.yaml")
    text = (tmp_path / "scene.yaml").read_text()
    (tmp_path / "scene.yaml").write_text(text.replace("20.0, 20.0, 1.0", "20.0, .nan, 1.0"))
    with pytest.raises(cranny.CrannyError, match=r"scene\.yaml"):
        scenario.with_moveit_scene(tmp_path / "scene.yaml")
    with pytest.raises(cranny.CrannyError, match="nowhere"):
        cranny.MoveItProblem(tmp_path / "nowhere.yaml", tmp_path / "r.yaml")
