# Types of the module written in Rust; `mypy.stubtest` checks that both agree. Written by hand, because a single
# configuration and a batch give different types, which no generator derives (docs/decisions).
import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final, Literal, Protocol, TypeAlias, final, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import Never

from cranny.notebook import View

__all__ = [
    "Body",
    "Cell",
    "Contact",
    "CrannyError",
    "DepthView",
    "Grasps",
    "LivePage",
    "Motion",
    "MoveItProblem",
    "Plan",
    "Planner",
    "ResultsFile",
    "Robot",
    "Samples",
    "Scenario",
    "Verification",
    "__version__",
    "_points_of_message",
    "_restored",
    "_restored_contact",
    "_restored_grasps",
    "_restored_motion",
    "_restored_plan",
    "_restored_samples",
    "_with_views",
    "filter_cloud",
    "grasp_experiment",
    "licences",
    "lift_file_limits",
    "moving_picture",
    "page",
    "picture",
    "plan",
    "plan_experiment",
    "planner_names",
    "run_campaign",
    "sample_grasps",
    "scenario_ids",
    "serve_trials",
    "simulate_grasps",
    "simulate_plan",
    "verify_path",
]

_Path: TypeAlias = str | os.PathLike[str]
_Floats: TypeAlias = NDArray[np.float64]
_ViewName: TypeAlias = Literal["three-quarter", "front", "side", "top"]

class _Mesh(Protocol):
    @property
    def vertices(self) -> Any: ...
    @property
    def faces(self) -> Any: ...

_MeshLike: TypeAlias = _Mesh | tuple[ArrayLike, ArrayLike]

__version__: Final[str]

class CrannyError(ValueError): ...

@final
class Robot:
    # There is no constructor; the error of a call names the functions that make robots.
    def __new__(cls, *_arguments: Never, **_keywords: Never) -> Robot: ...
    @staticmethod
    def from_urdf(
        path: _Path,
        *,
        srdf: _Path | None = None,
        tip: str | None = None,
        joints: Sequence[str] | None = None,
        group: str | None = None,
        fixed: Mapping[str, float] | None = None,
        packages: Sequence[_Path] | None = None,
        meshes: Literal["hull", "solid"] = "hull",
        unchecked_pairs: Sequence[tuple[str, str]] | None = None,
    ) -> Robot: ...
    @staticmethod
    def from_urdf_text(text: str, *, tip: str | None = None) -> Robot: ...
    @staticmethod
    def panda_mobile() -> Robot: ...
    @staticmethod
    def builtin(name: str) -> Robot: ...
    @property
    def name(self) -> str: ...
    @property
    def dof(self) -> int: ...
    @property
    def joint_names(self) -> list[str]: ...
    @property
    def joint_units(self) -> list[str]: ...
    @property
    def link_names(self) -> list[str]: ...
    @property
    def tip(self) -> str: ...
    @property
    def lower(self) -> _Floats: ...
    @property
    def upper(self) -> _Floats: ...
    @property
    def velocity(self) -> _Floats: ...
    @property
    def acceleration(self) -> _Floats: ...
    def fk(self, q: ArrayLike, link: str | None = None, *, threads: int | None = 1) -> _Floats: ...
    def jacobian(self, q: ArrayLike, link: str | None = None, *, threads: int | None = 1) -> _Floats: ...
    def joint_forces(
        self,
        q: ArrayLike,
        velocity: ArrayLike,
        acceleration: ArrayLike,
        *,
        up: tuple[float, float, float] = (0, 0, 1),
    ) -> _Floats: ...
    # One pose (4, 4) gives an array (K, dof), a batch (N, 4, 4) a list of N arrays.
    def ik(
        self,
        pose: ArrayLike,
        *,
        count: int = 1,
        attempts: int = 200,
        seed: int = 0,
        start: ArrayLike | None = None,
        cell: Cell | None = None,
        threads: int | None = 1,
    ) -> Any: ...
    def sample(self, count: int, *, seed: int = 0) -> _Floats: ...

@final
class Body:
    @staticmethod
    def box(name: str, size: ArrayLike, *, pose: ArrayLike | None = None) -> Body: ...
    @staticmethod
    def sphere(name: str, radius: float, *, pose: ArrayLike | None = None) -> Body: ...
    @staticmethod
    def cylinder(name: str, radius: float, *, length: float, pose: ArrayLike | None = None) -> Body: ...
    @staticmethod
    def capsule(name: str, radius: float, *, length: float, pose: ArrayLike | None = None) -> Body: ...
    @staticmethod
    def mesh(name: str, mesh: _MeshLike, *, pose: ArrayLike | None = None, hull: bool = False) -> Body: ...
    @staticmethod
    def cloud(name: str, points: ArrayLike, radius_m: float, *, pose: ArrayLike | None = None) -> Body: ...
    @staticmethod
    def floor(height: float = 0.0) -> Body: ...
    @property
    def name(self) -> str: ...
    @property
    def kinds(self) -> list[str]: ...
    @property
    def sizes(self) -> list[list[float]]: ...
    @property
    def poses(self) -> _Floats: ...
    def triangles(self) -> tuple[_Floats, NDArray[np.int64]]: ...

@final
class DepthView:
    def __new__(
        cls,
        image: ArrayLike,
        intrinsics: ArrayLike,
        pose: ArrayLike,
        *,
        name: str = "view",
        scale: float | None = None,
        q: ArrayLike | None = None,
        depth_error_m: float | None = None,
        depth_error_share: float | None = None,
        lateral_error_px: float | None = None,
        position_error_m: float | None = None,
        turn_error_deg: float | None = None,
        nearest_m: float | None = None,
        farthest_m: float | None = None,
    ) -> DepthView: ...
    @staticmethod
    def load(path: _Path) -> list[DepthView]: ...
    @property
    def name(self) -> str: ...
    @property
    def shape(self) -> tuple[int, int]: ...
    @property
    def depths(self) -> NDArray[np.float32]: ...
    @property
    def intrinsics(self) -> tuple[float, float, float, float]: ...
    @property
    def pose(self) -> _Floats: ...
    @property
    def q(self) -> _Floats | None: ...
    def with_q(self, q: ArrayLike | None) -> DepthView: ...
    @property
    def valid(self) -> int: ...
    @property
    def dropped(self) -> dict[str, int]: ...
    def points(self) -> NDArray[np.float32]: ...

@final
class Contact:
    @property
    def first(self) -> str: ...
    @property
    def second(self) -> str: ...
    @property
    def clearance_m(self) -> float: ...
    @property
    def required_m(self) -> float: ...
    @property
    def depth_m(self) -> float: ...
    @property
    def point(self) -> _Floats | None: ...

@final
class Motion:
    @property
    def kind(self) -> str: ...
    @property
    def at(self) -> float | None: ...
    @property
    def contact(self) -> Contact | None: ...
    @property
    def joint(self) -> str | None: ...
    @property
    def bound(self) -> str | None: ...
    def __bool__(self) -> bool: ...

@final
class Cell:
    def __new__(cls, robot: Robot, bodies: Sequence[Body], *, margin_m: float = 0.0) -> Cell: ...
    @property
    def robot(self) -> Robot: ...
    @property
    def world(self) -> list[Body]: ...
    @property
    def self_pairs(self) -> list[tuple[str, str]]: ...
    # A flat list gives one result; for an array, the shape at run time decides between one result and a batch.
    @overload
    def is_free(self, q: Sequence[float], *, threads: int | None = 1) -> bool: ...
    @overload
    def is_free(self, q: ArrayLike, *, threads: int | None = 1) -> Any: ...
    @overload
    def clearance(self, q: Sequence[float], *, threads: int | None = 1) -> float: ...
    @overload
    def clearance(self, q: ArrayLike, *, threads: int | None = 1) -> Any: ...
    @overload
    def first_contact(self, q: Sequence[float], *, threads: int | None = 1) -> Contact | None: ...
    @overload
    def first_contact(self, q: ArrayLike, *, threads: int | None = 1) -> Any: ...
    def contacts(self, q: ArrayLike) -> list[Contact]: ...
    @overload
    def motion_is_free(self, a: Sequence[float], b: Sequence[float], *, threads: int | None = 1) -> bool: ...
    @overload
    def motion_is_free(self, a: ArrayLike, b: ArrayLike, *, threads: int | None = 1) -> Any: ...
    @overload
    def motion(self, a: Sequence[float], b: Sequence[float], *, threads: int | None = 1) -> Motion: ...
    @overload
    def motion(self, a: ArrayLike, b: ArrayLike, *, threads: int | None = 1) -> Any: ...
    def least_clearance(self, a: ArrayLike, b: ArrayLike) -> float: ...

@final
class Grasps:
    def __new__(
        cls,
        poses: ArrayLike,
        scores: ArrayLike | None = None,
        *,
        widths: ArrayLike | None = None,
        robust_scores: ArrayLike | None = None,
        robust_trials: ArrayLike | None = None,
        loads: ArrayLike | None = None,
    ) -> Grasps: ...
    @staticmethod
    def load(path: _Path) -> Grasps: ...
    def save(self, path: _Path) -> None: ...
    @property
    def poses(self) -> _Floats: ...
    @property
    def scores(self) -> _Floats: ...
    @property
    def widths(self) -> _Floats: ...
    @property
    def robust_scores(self) -> _Floats: ...
    @property
    def robust_trials(self) -> _Floats: ...
    @property
    def loads(self) -> _Floats: ...
    def by_score(self) -> NDArray[np.int64]: ...
    def nearest(self, pose: ArrayLike) -> tuple[int, float, float] | None: ...
    def covered_by(self, other: Grasps, *, threshold: float = 15.0) -> float: ...
    def __len__(self) -> int: ...

@final
class Scenario:
    def __new__(
        cls,
        what: _Path,
        *,
        criterion: str | None = None,
        robot: _Path | None = None,
        geometry: str | None = None,
        grasps: _Path | None = None,
    ) -> Scenario: ...
    @staticmethod
    def load(
        path: _Path,
        *,
        criterion: str | None = None,
        robot: _Path | None = None,
        geometry: str | None = None,
        grasps: _Path | None = None,
    ) -> Scenario: ...
    @staticmethod
    def of(
        robot: Robot,
        bodies: Sequence[Body],
        *,
        start: ArrayLike | None = None,
        target: str | None = None,
        grasps: Grasps | None = None,
        name: str = "scene",
    ) -> Scenario: ...
    @staticmethod
    def from_world(
        world: _Path,
        folder: _Path,
        *,
        robot: _Path,
        target: str,
        joints: Mapping[str, float] | None = None,
        at: Sequence[float] | None = None,
        leave_out: Sequence[str] | None = None,
        model_path: Sequence[_Path] | None = None,
    ) -> Scenario: ...
    @property
    def id(self) -> str: ...
    @property
    def criterion(self) -> str: ...
    @property
    def robot(self) -> Robot: ...
    @property
    def world(self) -> list[Body]: ...
    @property
    def target(self) -> Body | None: ...
    @property
    def seen(self) -> dict[str, Any] | None: ...
    @property
    def start(self) -> _Floats: ...
    @property
    def grasps(self) -> Grasps: ...
    @property
    def places(self) -> list[str]: ...
    @property
    def regions(self) -> dict[str, dict[str, Any]]: ...
    def grasp_regions(self, grasp: int) -> list[dict[str, Any]]: ...
    @property
    def tasks(self) -> dict[str, list[dict[str, Any]]]: ...
    @property
    def goals(self) -> _Floats | None: ...
    @property
    def known_goals(self) -> _Floats: ...
    def cell(
        self, *, margin_m: float = 0.0, grasp_margin_m: float = 0.0, object_margin_m: float = 0.0
    ) -> Cell: ...
    def with_body(self, body: Body) -> Scenario: ...
    def with_box(self, name: str, size: ArrayLike, *, pose: ArrayLike | None = None) -> Scenario: ...
    def without_body(self, name: str) -> Scenario: ...
    def with_object_moved(self, motion: ArrayLike) -> Scenario: ...
    def with_goals(self, goals: ArrayLike) -> Scenario: ...
    def with_grasps(self, grasps: Grasps) -> Scenario: ...
    def without_grasps(self) -> Scenario: ...
    def with_target(self, name: str) -> Scenario: ...
    def after(self, plan: Plan) -> Scenario: ...
    def with_start(self, start: ArrayLike) -> Scenario: ...
    def with_criterion(self, criterion: str) -> Scenario: ...
    def save(self, folder: _Path) -> None: ...
    def save_moveit_scene(self, path: _Path) -> None: ...
    def with_moveit_scene(self, path: _Path) -> Scenario: ...
    def show(
        self,
        plan: Plan | None = None,
        *,
        view: str = "three-quarter",
        width: int = 640,
        height: int = 480,
    ) -> View: ...

@final
class MoveItProblem:
    def __new__(
        cls, scene: _Path, request: _Path, *, robot: _Path | None = None, srdf: _Path | None = None
    ) -> MoveItProblem: ...
    @property
    def id(self) -> str: ...
    @property
    def robot(self) -> Robot: ...
    @property
    def world(self) -> list[Body]: ...
    @property
    def start(self) -> _Floats: ...
    @property
    def goals(self) -> _Floats: ...
    @property
    def deviations(self) -> list[str]: ...
    def cell(self, *, margin_m: float = 0.0) -> Cell: ...

@final
class Planner:
    def __new__(
        cls,
        robot: _Path,
        *,
        srdf: _Path | None = None,
        margin_m: float = 0.0,
        rate: float = 100.0,
        time_limit_s: float = 30.0,
    ) -> Planner: ...
    @property
    def robot_name(self) -> str: ...
    @property
    def groups(self) -> list[str]: ...
    def plan(self, request: Mapping[str, Any]) -> dict[str, Any]: ...

@final
class LivePage:
    def __new__(cls, scenario: Scenario, plan: Plan | None = None, *, port: int = 0) -> LivePage: ...
    @property
    def url(self) -> str: ...
    def pose(self, q: ArrayLike | None) -> None: ...
    def plan(self, plan: Plan | None) -> None: ...
    def close(self) -> None: ...
    def __enter__(self) -> LivePage: ...
    def __exit__(self, _kind: object, _value: object, _trace: object) -> None: ...

@final
class Verification:
    @property
    def valid(self) -> bool: ...
    @property
    def violations(self) -> list[dict[str, Any]]: ...
    @property
    def goal(self) -> dict[str, Any] | None: ...
    @property
    def own_grasp(self) -> dict[str, Any] | None: ...
    @property
    def clearance_m(self) -> float | None: ...
    @property
    def clearance_limit(self) -> dict[str, Any] | None: ...
    @property
    def not_checked(self) -> list[dict[str, Any]]: ...
    def __bool__(self) -> bool: ...

@final
class Samples:
    @property
    def joint_names(self) -> list[str]: ...
    @property
    def times(self) -> _Floats: ...
    @property
    def positions(self) -> _Floats: ...
    @property
    def velocities(self) -> _Floats: ...
    @property
    def accelerations(self) -> _Floats: ...
    @property
    def openings(self) -> _Floats | None: ...
    def __len__(self) -> int: ...

@final
class Plan:
    @staticmethod
    def load(path: _Path, scenario: Scenario | MoveItProblem | None = None) -> Plan: ...
    @property
    def path(self) -> _Floats: ...
    @property
    def segments(self) -> list[dict[str, Any]]: ...
    @property
    def task(self) -> list[dict[str, Any]]: ...
    @property
    def task_name(self) -> str | None: ...
    @property
    def robustness(self) -> dict[str, Any] | None: ...
    @property
    def least_length(self) -> float | None: ...
    @property
    def tilt(self) -> dict[str, Any] | None: ...
    @property
    def tool(self) -> list[dict[str, Any]]: ...
    @property
    def hold(self) -> dict[str, Any] | None: ...
    @property
    def tries(self) -> list[dict[str, Any]]: ...
    @property
    def times(self) -> _Floats | None: ...
    @property
    def duration_s(self) -> float | None: ...
    @property
    def outcome(self) -> str: ...
    @property
    def solved(self) -> bool: ...
    @property
    def grasp(self) -> int | None: ...
    @property
    def own_grasp(self) -> dict[str, Any] | None: ...
    @property
    def clearance_m(self) -> float | None: ...
    @property
    def not_checked(self) -> list[dict[str, Any]]: ...
    @property
    def joint_names(self) -> list[str]: ...
    @property
    def differs(self) -> list[dict[str, Any]]: ...
    @property
    def unjudged(self) -> list[str]: ...
    @property
    def report(self) -> dict[str, Any]: ...
    def sample(self, rate: float = 100.0) -> Samples: ...
    def sample_ways(self, rate: float = 100.0) -> list[Samples]: ...
    def _closing(self) -> tuple[list[float], float] | None: ...
    def verify(self) -> Verification: ...
    def save(self, path: _Path) -> None: ...
    def save_trajectory(self, path: _Path, rate: float = 100.0) -> None: ...
    def __bool__(self) -> bool: ...

@final
class ResultsFile:
    def __new__(cls, path: _Path) -> ResultsFile: ...
    @property
    def path(self) -> os.PathLike[str]: ...
    def close(self) -> None: ...
    def trials(self) -> dict[str, list[Any]]: ...
    def path_of(self, id: int) -> _Floats: ...
    def summary(self) -> dict[str, Any]: ...
    def html(self) -> str: ...

def plan(
    scenario: Scenario | MoveItProblem,
    planner: str | None = None,
    *,
    start: ArrayLike | None = None,
    seed: int = 0,
    time_limit_s: float = 120.0,
    iterations: int | None = None,
    margin_m: float = 0.0,
    grasp_margin_m: float | None = None,
    strict_pairs: bool = False,
    settings: Mapping[str, Any] | None = None,
    goal_threshold: float | None = None,
    shortcut: bool = True,
    optimise_s: float | None = None,
    cost: str | None = None,
    score_weight: float = 1.0,
    jerk_limited: bool | None = None,
    blend: bool = True,
    speed: float | Mapping[str, float] | None = None,
    acceleration: float | Mapping[str, float] | None = None,
    tool_speed_m_s: float | Mapping[str, float] | None = None,
    turn_speed_deg_s: float | Mapping[str, float] | None = None,
    torque: bool = False,
    upright_deg: float | None = None,
    score: str | None = None,
    min_score: float | None = None,
    carry: str | ArrayLike | None = None,
    goal_region: str | Mapping[str, Any] | Sequence[str] | Sequence[Mapping[str, Any]] | None = None,
    place: str | None = None,
    task: str | Sequence[Mapping[str, Any]] | None = None,
    then: str | None = None,
    clear_m: float | None = None,
    approach_m: float | None = None,
    retreat_m: float | None = None,
    robust: tuple[float, float] | None = None,
    hold: float = 1.5,
    try_in_physics: int | None = None,
    watch: LivePage | None = None,
) -> Plan: ...
def verify_path(
    scenario: Scenario | MoveItProblem,
    path: ArrayLike,
    *,
    margin_m: float = 0.0,
    grasp_margin_m: float = 0.0,
    strict_pairs: bool = False,
    any_end: bool = False,
) -> Verification: ...
def filter_cloud(
    points: ArrayLike,
    *,
    pose: ArrayLike | None = None,
    crop: ArrayLike | None = None,
    robot: Robot | None = None,
    q: ArrayLike | None = None,
    own_margin_m: float | None = None,
    known: Sequence[Body] | None = None,
    known_margin_m: float | None = None,
    voxel_m: float | None = None,
) -> tuple[NDArray[np.float32], dict[str, int]]: ...
def licences() -> str: ...
def lift_file_limits() -> None: ...
def planner_names() -> list[str]: ...
def scenario_ids() -> list[str]: ...
def sample_grasps(
    mesh: _MeshLike,
    gripper: _Path | None = None,
    *,
    count: int = 200,
    candidates: int | None = None,
    friction: float = 0.35,
    approaches: int = 12,
    approach_m: float = 0.05,
    bare: bool = False,
    seed: int = 0,
) -> Grasps: ...
def simulate_grasps(
    scenario: Scenario,
    grasps: Grasps | None = None,
    *,
    support_only: bool = False,
    gripper: _Path | None = None,
    mass_kg: float | None = None,
    friction: float | None = None,
    closing_force_n: float | None = None,
    trials: int = 0,
    seed: int = 0,
) -> list[dict[str, Any]]: ...
def grasp_experiment(
    scenario: Scenario,
    grasps: Grasps | None = None,
    *,
    support_only: bool = False,
    gripper: _Path | None = None,
    mass_kg: float | None = None,
    friction: float | None = None,
    closing_force_n: float | None = None,
) -> dict[str, Any]: ...
@overload
def simulate_plan(
    plan: Plan,
    *,
    lift_m: float = 0.03,
    mass_kg: float | None = None,
    friction: float | None = None,
    closing_force_n: float | None = None,
    disturb: int | None = None,
) -> dict[str, Any]: ...
@overload
def simulate_plan(
    plan: Sequence[Plan],
    *,
    lift_m: float = 0.03,
    mass_kg: float | None = None,
    friction: float | None = None,
    closing_force_n: float | None = None,
    disturb: int | None = None,
) -> list[dict[str, Any]]: ...
def plan_experiment(
    plan: Plan,
    *,
    lift_m: float = 0.03,
    mass_kg: float | None = None,
    friction: float | None = None,
    closing_force_n: float | None = None,
) -> dict[str, Any]: ...
def picture(
    scenario: Scenario,
    plan: Plan | None = None,
    *,
    view: str = "three-quarter",
    width: int = 960,
    height: int = 720,
) -> bytes: ...
def moving_picture(
    scenario: Scenario,
    plan: Plan,
    *,
    view: str = "three-quarter",
    width: int = 640,
    height: int = 480,
    rate: int = 10,
) -> bytes: ...
def page(scenario: Scenario, plan: Plan | None = None) -> str | None: ...
def run_campaign(
    scenarios: Sequence[str],
    planners: Sequence[tuple[str, str | Sequence[str], Mapping[str, Any] | None]],
    output: _Path,
    worker: Sequence[str],
    *,
    criteria: Sequence[str],
    runs: int,
    first_seed: int,
    time_limit_s: float,
    iterations: int | None,
    memory_limit_mb: int,
    workers: int,
    judge_both: bool,
    measure_clearance: bool,
    carry: str | None,
    task: str | None,
    grasps: str | None,
    margin_m: float,
    grasp_margin_m: float,
    robust: tuple[float, float] | None,
    hold: float | None,
    try_in_physics: int | None,
    sandbox: str,
    again: list[str],
    shard: tuple[int, int] | None,
    command: str,
    heard: Callable[[int, int, int], None] | None = None,
) -> None: ...
def serve_trials() -> None: ...

# Functions that other modules of the package call.
def _points_of_message(
    height: int,
    width: int,
    fields: Sequence[tuple[str, int, int, int]],
    is_bigendian: bool,
    point_step: int,
    row_step: int,
    data: bytes,
) -> tuple[NDArray[np.float32], int]: ...
def _with_views(
    scenario: Scenario,
    views: Sequence[DepthView],
    *,
    unseen: str = "solid",
    cell_m: float | None = None,
    fine_m: float | None = None,
    region: ArrayLike | None = None,
    robot_reach_m: float | None = None,
    floor_reach_m: float | None = None,
    tolerance_m: float | None = None,
) -> Scenario: ...

# Functions that pickles call.
def _restored(function: Callable[..., Any], arguments: tuple[Any, ...], known: int, version: str) -> Any: ...
def _restored_contact(
    first: str, second: str, lengths: tuple[float, float, float], point: Sequence[float]
) -> Contact: ...
def _restored_grasps(rows: ArrayLike) -> Grasps: ...
def _restored_motion(
    kind: str, at: float | None, contact: Contact | None, joint: str | None, bound: str | None
) -> Motion: ...
def _restored_plan(scenario: Scenario | MoveItProblem, text: str, path: ArrayLike) -> Plan: ...
def _restored_samples(
    joint_names: Sequence[str],
    times: ArrayLike,
    positions: ArrayLike,
    velocities: ArrayLike,
    accelerations: ArrayLike,
    openings: ArrayLike | None,
) -> Samples: ...
