"""MoveIt's requests and responses as dictionaries, without ROS.

>>> import cranny
>>> planner = cranny.moveit.Planner("fr3")
>>> home, goal = [0.0, -0.8, 0.0, -2.4, 0.0, 1.6, 0.8], [0.6, -0.8, 0.0, -2.4, 0.0, 1.6, 0.8]
>>> joints = [f"fr3_joint{number}" for number in range(1, 8)]
>>> constraints = [{"joint_name": joint, "position": value} for joint, value in zip(joints, goal)]
>>> answer = planner.plan({
...     "planning_scene": {"world": {"collision_objects": []}},
...     "motion_plan_request": {
...         "group_name": "arm",
...         "start_state": {"joint_state": {"name": joints, "position": home}},
...         "goal_constraints": [{"joint_constraints": constraints}],
...     },
... })
>>> answer["motion_plan_response"]["error_code"]["val"], answer["cranny"]["valid"]
(1, True)

`cranny serve` answers the same documents over HTTP. docs/ros.md lists what is read and what is refused.
"""

from __future__ import annotations

from cranny._cranny import Planner

__all__ = ["Planner"]
