"""Cranny: joint grasp and motion planning in confined spaces.

>>> import cranny
>>> scenario = cranny.Scenario("021")
>>> plan = cranny.plan(scenario)
>>> bool(plan), plan.path.shape[1]
(True, 9)

Lengths are in metres, angles in radians, times in seconds; poses are (4, 4) homogeneous matrices in the planning
frame, which is the robot's root frame; a configuration `q` is (dof,), a batch of them (N, dof). Invalid arguments
raise `TypeError` or `ValueError`, an unknown link `KeyError` (`Robot.fk`, `Robot.jacobian`); an invalid file or scene raises
`CrannyError`, a `ValueError` that states the fault.

`World` updates its obstacles from depth images and point clouds.

`cranny.bench` runs campaigns and reads their results, `cranny.planner` adds your own planner to them, `cranny.ros`
writes trajectories as ROS 2 messages and reads depth images and clouds, `cranny.moveit` answers MoveIt's requests, `cranny.mujoco_grasps` repeats simulated grasps in MuJoCo.
"""

from cranny import bench, moveit, ros
from cranny._cranny import (
    Body,
    Cell,
    Contact,
    CrannyError,
    DepthView,
    Grasps,
    LivePage,
    Motion,
    MoveItProblem,
    Plan,
    Robot,
    Samples,
    Scenario,
    Verification,
    __version__,
    filter_cloud,
    grasp_experiment,
    licences,
    lift_file_limits,
    plan,
    plan_experiment,
    planner_names,
    sample_grasps,
    scenario_ids,
    simulate_grasps,
    simulate_plan,
    verify_path,
)
from cranny.notebook import View, show
from cranny.own_planner import Budget, Problem, planner
from cranny.world import World

__all__ = [
    "Body",
    "Budget",
    "Cell",
    "Contact",
    "CrannyError",
    "DepthView",
    "Grasps",
    "LivePage",
    "Motion",
    "MoveItProblem",
    "Plan",
    "Problem",
    "Robot",
    "Samples",
    "Scenario",
    "Verification",
    "View",
    "World",
    "__version__",
    "bench",
    "filter_cloud",
    "grasp_experiment",
    "licences",
    "lift_file_limits",
    "moveit",
    "plan",
    "plan_experiment",
    "planner",
    "planner_names",
    "ros",
    "sample_grasps",
    "scenario_ids",
    "show",
    "simulate_grasps",
    "simulate_plan",
    "verify_path",
]
