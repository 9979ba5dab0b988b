"""MoveIt's requests and responses as dictionaries, over HTTP, and as typed messages of a bag of ROS 2."""

from __future__ import annotations

import json
import math
import os
import pickle
import shutil
import subprocess
import urllib.error
import urllib.request
from pathlib import Path
from typing import Any

import cranny
import numpy as np
import pytest
from conftest import lacking, package

JOINTS = [f"fr3_joint{number}" for number in range(1, 8)]
HOME = [0.0, -0.8, 0.0, -2.4, 0.0, 1.6, 0.8]
TURNED = [1.2, *HOME[1:]]

POSE = {"position": {"x": 0.5, "y": 0.25, "z": 0.45}, "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}}
ORIGIN = {"position": {"x": 0.0, "y": 0.0, "z": 0.0}, "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}}


def request() -> dict[str, Any]:
    """A crate between start and goal."""
    crate = {
        "header": {"frame_id": "fr3_link0"},
        "id": "crate",
        "pose": POSE,
        "primitives": [{"type": 1, "dimensions": [0.1, 0.1, 0.3]}],
        "primitive_poses": [ORIGIN],
        "operation": 0,
    }
    constraints = [{"joint_name": joint, "position": value} for joint, value in zip(JOINTS, TURNED, strict=True)]
    return {
        "planning_scene": {"name": "cell", "world": {"collision_objects": [crate]}},
        "motion_plan_request": {
            "group_name": "arm",
            "start_state": {"joint_state": {"name": JOINTS, "position": HOME}},
            "goal_constraints": [{"joint_constraints": constraints}],
            "allowed_planning_time": 5.0,
        },
    }


@pytest.fixture(scope="module")
def planner() -> cranny.moveit.Planner:
    """A planner of a built-in robot, with a margin of 2 mm."""
    return cranny.moveit.Planner("fr3", margin_m=0.002)


def test_a_request_gets_a_motion_and_its_proof(planner: cranny.moveit.Planner) -> None:
    assert planner.robot_name == "fr3" and "arm" in planner.groups and "arm" in repr(planner)
    answer = planner.plan(request())
    assert set(answer) == {"motion_plan_response", "cranny"}
    response, proof = answer["motion_plan_response"], answer["cranny"]
    assert set(response) == {"trajectory_start", "group_name", "trajectory", "planning_time", "error_code"}
    assert response["error_code"] == {"val": 1, "message": "solved", "source": "cranny"}
    assert proof["valid"] and proof["clearance_m"] >= 0.002 and proof["outcome"] == "solved"
    times, positions = cranny.ros.positions_of(response["trajectory"]["joint_trajectory"])
    assert positions.joint_names == tuple(JOINTS)
    assert positions.tolist()[0] == HOME and positions.tolist()[-1] == TURNED
    assert times[1] == pytest.approx(0.01) and 0.0 < response["planning_time"] < 5.0
    assert planner.plan(request())["motion_plan_response"]["trajectory"] == response["trajectory"]


def test_a_planner_is_pickled(planner: cranny.moveit.Planner) -> None:
    copy = pickle.loads(pickle.dumps(planner))
    assert repr(copy) == repr(planner)
    assert copy.plan(request())["cranny"]["clearance_m"] >= 0.002


def test_what_is_wrong_is_named_by_its_entry(planner: cranny.moveit.Planner) -> None:
    asked = request()
    asked["motion_plan_request"]["goal_constraints"][0]["joint_constraints"][3]["position"] = math.nan
    with pytest.raises(cranny.CrannyError, match=r"^motion_plan_request\.goal_constraints\[0\]\.joint_constraints\[3\]\.position: "):
        planner.plan(asked)
    asked = request()
    asked["planning_scene"]["world"]["collision_objects"][0]["primitives"][0]["type"] = 7
    with pytest.raises(cranny.CrannyError, match=r"^planning_scene\.world\.collision_objects\[0\]\.primitives\[0\]: "):
        planner.plan(asked)
    with pytest.raises(cranny.CrannyError, match="motion_plan_request"):
        planner.plan({"planning_scene": {}})
    with pytest.raises(TypeError, match="a dictionary of plain values is expected"):
        planner.plan({"planning_scene": np.zeros(3)})
    for words in ({"robot": "nowhere.urdf"}, {"robot": "fr3", "rate": 0.0}, {"robot": "fr3", "time_limit_s": -1.0}):
        with pytest.raises(ValueError, match=r"nowhere\.urdf|sample rate|time_limit_s"):
            cranny.moveit.Planner(**words)  # type: ignore[arg-type]


def program() -> str:
    """The command `cranny`, as `cargo xtask test` names it, or of the path."""
    found = os.environ.get("CRANNY_BIN") or shutil.which("cranny")
    if not found:
        lacking("no program cranny (CRANNY_BIN names it)")
    return found or ""


def test_the_server_gives_the_same_response(planner: cranny.moveit.Planner) -> None:
    words = [program(), "serve", "--robot", "fr3", "--margin", "2", "--json"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as server:
        try:
            assert server.stdout
            printed = ""
            while not printed.endswith("}\n") or printed.count("{") != printed.count("}"):
                printed += server.stdout.readline()
            url = json.loads(printed)["url"]
            with urllib.request.urlopen(url) as about:
                assert json.load(about)["robot"] == "fr3"
            asked = urllib.request.Request(url + "plan", data=json.dumps(request()).encode())
            with urllib.request.urlopen(asked) as reply:
                served = json.load(reply)
            with pytest.raises(urllib.error.HTTPError, match="400") as refused:
                urllib.request.urlopen(urllib.request.Request(url + "plan", data=b"{}"))
            assert "planning_scene" in json.load(refused.value)["error"]
        finally:
            server.terminate()
    planned = planner.plan(request())
    for answer in (served, planned):
        del answer["motion_plan_response"]["planning_time"]
    assert served == planned


MESSAGES = {
    "PlanningScene": "string name\nRobotState robot_state\nstring robot_model_name\nPlanningSceneWorld world\nbool is_diff",
    "PlanningSceneWorld": "CollisionObject[] collision_objects",
    "CollisionObject": "byte ADD=0\nstd_msgs/Header header\ngeometry_msgs/Pose pose\nstring id\n"
    "shape_msgs/SolidPrimitive[] primitives\ngeometry_msgs/Pose[] primitive_poses\nshape_msgs/Mesh[] meshes\n"
    "geometry_msgs/Pose[] mesh_poses\nbyte operation",
    "RobotState": "sensor_msgs/JointState joint_state\nbool is_diff",
    "JointConstraint": "string joint_name\nfloat64 position\nfloat64 tolerance_above\nfloat64 tolerance_below\nfloat64 weight",
    "Constraints": "string name\nJointConstraint[] joint_constraints",
    "MotionPlanRequest": "RobotState start_state\nConstraints[] goal_constraints\nstring group_name\n"
    "int32 num_planning_attempts\nfloat64 allowed_planning_time\nfloat64 max_velocity_scaling_factor\n"
    "float64 max_acceleration_scaling_factor",
    "RobotTrajectory": "trajectory_msgs/JointTrajectory joint_trajectory",
    "MoveItErrorCodes": "int32 val\nint32 SUCCESS=1\nstring message\nstring source",
    "MotionPlanResponse": "RobotState trajectory_start\nstring group_name\nRobotTrajectory trajectory\n"
    "float64 planning_time\nMoveItErrorCodes error_code",
}
"""Fields of `moveit_msgs` that the test uses. A bag holds the definitions of its messages, so that one with all fields is
read in the same manner."""


def plain(store: Any, value: Any) -> Any:
    """Lists and dictionaries of a message of `rosbags`, as JSON has them."""
    if name := getattr(value, "__msgtype__", None):
        return {field: plain(store, getattr(value, field)) for field, _ in store.fielddefs[name][1]}
    if isinstance(value, np.ndarray):
        return value.tolist()
    return [plain(store, item) for item in value] if isinstance(value, list) else value


def typed(store: Any, name: str, value: dict[str, Any]) -> Any:
    """The message of that type with these fields; others have the value of a new message."""
    from rosbags.interfaces import Nodetype

    def of(kind: Any, given: Any) -> Any:
        node, detail = kind
        if node == Nodetype.NAME:
            return typed(store, detail, given or {})
        if node in (Nodetype.ARRAY, Nodetype.SEQUENCE):
            element = detail[0]
            if element[0] == Nodetype.BASE and element[1][0] != "string":
                return np.array(given or [], dtype=element[1][0].replace("octet", "uint8"))
            return [of(element, item) for item in given or []]
        return given if given is not None else {"string": "", "bool": False}.get(detail[0], 0)

    _, fields = store.fielddefs[name]
    return store.types[name](**{field: of(kind, value.get(field)) for field, kind in fields})


def test_scene_request_and_trajectory_are_messages_of_a_bag(planner: cranny.moveit.Planner, tmp_path: Path) -> None:
    package("rosbags")
    from rosbags.rosbag2 import Reader, Writer
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    for name, text in MESSAGES.items():
        store.register(get_types_from_msg(text, f"moveit_msgs/msg/{name}"))
    asked = request()
    kinds = {
        "planning_scene": "moveit_msgs/msg/PlanningScene",
        "motion_plan_request": "moveit_msgs/msg/MotionPlanRequest",
        "motion_plan_response": "moveit_msgs/msg/MotionPlanResponse",
    }

    def write(bag: Path, messages: dict[str, Any]) -> None:
        with Writer(bag, version=9) as writer:
            for stamp, (topic, message) in enumerate(messages.items()):
                connection = writer.add_connection(f"/{topic}", kinds[topic], typestore=store)
                writer.write(connection, stamp, store.serialize_cdr(message, kinds[topic]))

    def read(bag: Path) -> dict[str, Any]:
        # As with a bag of other people: only the definitions in the bag are known.
        found, known = {}, get_typestore(Stores.ROS2_HUMBLE)
        with Reader(bag) as reader:
            for connection in reader.connections:
                known.register(get_types_from_msg(connection.msgdef.data, connection.msgtype))
            for connection, _, raw in reader.messages():
                found[connection.topic[1:]] = plain(known, known.deserialize_cdr(raw, connection.msgtype))
        return found

    write(tmp_path / "asked", {topic: typed(store, kinds[topic], message) for topic, message in asked.items()})
    messages = read(tmp_path / "asked")
    assert messages["planning_scene"]["world"]["collision_objects"][0]["pose"] == POSE
    answer = planner.plan(messages)
    assert answer["cranny"]["valid"]
    expected = planner.plan(asked)["motion_plan_response"]["trajectory"]
    assert answer["motion_plan_response"]["trajectory"] == expected

    response = typed(store, kinds["motion_plan_response"], answer["motion_plan_response"])
    write(tmp_path / "answered", {**{topic: typed(store, kinds[topic], asked[topic]) for topic in asked},
                                  "motion_plan_response": response})
    again = read(tmp_path / "answered")
    assert list(again) == list(kinds)
    assert again["motion_plan_response"]["trajectory"] == expected
    assert again["motion_plan_response"]["error_code"]["val"] == 1
    times, _ = cranny.ros.positions_of(again["motion_plan_response"]["trajectory"]["joint_trajectory"])
    assert (np.diff(times) > 0.0).all()
