"""Node of ROS 2 that answers `moveit_msgs/srv/GetMotionPlan` by Cranny, in the planning scene of a running `move_group`.

    python3 planner_node.py --ros-args -p robot:=arm.urdf -p srdf:=arm.srdf

It was not run in ROS: the machines that test Cranny have none.
"""

from typing import Any

import cranny
import rclpy
from moveit_msgs.srv import GetMotionPlan, GetPlanningScene
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from rosidl_runtime_py import message_to_ordereddict, set_message_fields


class PlannerNode(Node):  # type: ignore[misc]
    """Service `plan_by_cranny`."""

    def __init__(self) -> None:
        super().__init__("cranny_planner")
        robot, srdf = (self.declare_parameter(name, "").value for name in ("robot", "srdf"))
        self.planner = cranny.moveit.Planner(robot, srdf=srdf or None)
        self.scenes = self.create_client(GetPlanningScene, "get_planning_scene", callback_group=ReentrantCallbackGroup())
        self.create_service(GetMotionPlan, "plan_by_cranny", self.answer)

    def answer(self, request: Any, response: Any) -> Any:
        """Answers a request; a malformed one with FAILURE, and its fault in the log."""
        # A request without components is answered with all of them.
        scene = self.scenes.call(GetPlanningScene.Request()).scene
        messages = {"planning_scene": scene, "motion_plan_request": request.motion_plan_request}
        try:
            answer = self.planner.plan({name: message_to_ordereddict(value) for name, value in messages.items()})
            set_message_fields(response.motion_plan_response, answer["motion_plan_response"])
        except cranny.CrannyError as fault:
            self.get_logger().error(str(fault))
            response.motion_plan_response.error_code.val = 99999
        return response


if __name__ == "__main__":
    rclpy.init()
    rclpy.spin(PlannerNode(), MultiThreadedExecutor())
