"""Independent check of simulated grasps: repeats in MuJoCo, by the same rules, the runs of Cranny's own engine.

An experiment is the document that `cranny simulate export` writes: the model of hand, object and surroundings, the
motion of the hand, the criterion for a held grasp, and the grasps.

>>> from cranny import mujoco_grasps
>>> runs = mujoco_grasps.run_all(mujoco_grasps.load("experiment.json"))  # doctest: +SKIP
>>> sum(run.outcome == "held" for run in runs) / len(runs)  # doctest: +SKIP

It needs the package `mujoco` (`pip install cranny[mujoco]`).
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]


@dataclass(frozen=True)
class GraspRun:
    """Result of a simulated grasp."""

    outcome: str
    """`held`, `slipped`, `dropped`, `never-closed` or `knocked-away`."""
    translation_error_m: float
    """Displacement of the object's centre of mass since the hand closed: in the hand, or in the world if it never
    closed."""
    rotation_error_rad: float
    """Rotation of the object against the same reference."""
    held_s: float
    """Time from the closing of the hand until the object exceeded the slip limit, or until the end of the run."""
    contact_force_n: float
    """Contact force of a finger after closing: the mean over the fingers."""


@dataclass(frozen=True)
class PlanRun:
    """Result of a simulated plan, from the closing of the hand."""

    grasp: GraspRun
    """Result for the object in the hand, until its release or the end of the plan."""
    released: tuple[float, float] | None
    """Displacement (m) and rotation (rad) of the object from its planned goal at release; None without a release."""
    placed: tuple[float, float] | None
    """The same errors 2 s after the arm has stopped."""
    stands: bool
    """True if the errors in `placed` are within the plan's limits."""

    @property
    def is_kept(self) -> bool:
        """True if the object stayed in the hand until then, within the slip limit."""
        return self.grasp.outcome == "held"


def load(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Reads an experiment from a file."""
    experiment = json.loads(Path(path).read_text(encoding="utf-8"))
    if not isinstance(experiment, dict) or "mjcf" not in experiment:
        raise ValueError(f"{os.fspath(path)} is no experiment: it has no model ('mjcf')")
    return experiment


def run_all(experiment: Mapping[str, Any]) -> list[GraspRun]:
    """Runs all grasps of an experiment in their order."""
    model = GraspModel(experiment)
    return [model.run(index) for index in range(len(experiment["grasps"]))]


def run_plan(experiment: Mapping[str, Any]) -> PlanRun:
    """Runs the plan of one pick from `cranny simulate plan --export` or `cranny.plan_experiment`."""
    model = GraspModel(experiment)
    grasp = model.close_on(0)
    if not isinstance(grasp, float):
        return PlanRun(grasp, None, None, False)
    run = model.carry([_read_pose(pose) for pose in experiment["held"]], grasp)
    planned = experiment["world_from_planned"]
    if planned is None or run.outcome == "dropped":
        return PlanRun(run, None, None, False)
    there = _read_pose(planned)
    released = model.error(there, model.world_from_object())
    model.open([_read_pose(pose) for pose in experiment["left"]])
    placed = model.error(there, model.world_from_object())
    stands = placed[0] <= experiment["placed_m"] and placed[1] <= experiment["placed_rad"]
    return PlanRun(run, released, placed, stands)


@dataclass(frozen=True)
class Pose:
    """Pose in the planning frame or in the frame of another body."""

    position: Array
    """(3,), in metres."""
    quaternion: Array
    """(4,), of unit length, the real component first."""


class GraspModel:
    """MuJoCo model of an experiment, with the state of its simulation.

    The palm is a body of great mass, and its pose and velocity are set before each step: MuJoCo's mocap bodies have no
    velocity, so their friction would not move the object.
    """

    def __init__(self, experiment: Mapping[str, Any]) -> None:
        import numpy as np

        self._mujoco = _mujoco()
        self.experiment = experiment
        self.model: Any = self._mujoco.MjModel.from_xml_string(experiment["mjcf"])
        """The `MjModel`."""
        self.data: Any = self._mujoco.MjData(self.model)
        """The `MjData`."""
        self.steps = 0
        """Number of completed steps of the drive."""
        self._opens_from: tuple[int, float] | None = None
        self._strokes = np.array(experiment["strokes_m"], dtype=np.float64)
        names = [f"finger {number}" for number in range(1, len(self._strokes) + 1)]
        self._palm, self._object = (self.model.joint(name) for name in ("palm", "object"))
        joints = [self.model.joint(name) for name in names]
        self._finger_positions = np.array([joint.qposadr[0] for joint in joints])
        self._finger_velocities = np.array([joint.dofadr[0] for joint in joints])
        self._finger_of_body = {self.model.body(name).id: index for index, name in enumerate(names)}
        for body, parent in enumerate(self.model.body_parentid.tolist()):
            # The springs of a pad belong to their finger.
            if parent in self._finger_of_body:
                self._finger_of_body[body] = self._finger_of_body[parent]
        self._object_body = self.model.body("object").id
        self._center = np.array(experiment["center_in_object"], dtype=np.float64)
        self._up = np.array(experiment["up"], dtype=np.float64)
        self._gravity = -float(experiment["gravity"]) * self._up

    def run(self, index: int) -> GraspRun:
        """Simulates one of the experiment's grasps."""
        closed = self.close_on(index)
        if not isinstance(closed, float):
            return closed
        figures, course = self.experiment, self.experiment["course"]
        step_s, world_from_grasp = figures["step_s"], self.grasp(index)
        steps = range(1, round(_duration_s(course) / step_s) + 1)
        parts = figures["model_steps"]
        times = ([(step - 1 + (part + 1) / parts) * step_s for part in range(parts)] for step in steps)
        return self._follow(([self._on_course(world_from_grasp, time_s) for time_s in some] for some in times), closed)

    def close_on(self, index: int) -> float | GraspRun:
        """Closes the hand at a grasp; returns the contact force of a finger (N), or the result if it does not close."""
        course = self.experiment["course"]
        self.open_at(self.grasp(index))
        blocked = self._blocked()
        if blocked is not None:
            return GraspRun(blocked, 0.0, 0.0, 0.0, 0.0)
        self.model.opt.gravity[:] = self._gravity if self.experiment["is_carried"] else 0.0
        world_from_rest = self.world_from_object()
        force_n = self._close()
        self.model.opt.gravity[:] = self._gravity
        if force_n is None:
            error = self.error(world_from_rest, self.world_from_object())
            return GraspRun("never-closed" if _is_held(course, error) else "knocked-away", *error, 0.0, 0.0)
        return force_n

    def carry(self, poses: list[Pose], force_n: float) -> GraspRun:
        """Moves the closed hand with the object through these poses, one for each step of the drive."""
        return self._follow(self._between(poses), force_n)

    def open(self, poses: list[Pose]) -> None:
        """Opens the hand while it moves through these poses, one for each step of the drive."""
        self._opens_from = (self.steps, self.closed()[0] * float(self._strokes.max()))
        for some in self._between(poses):
            self.step(some)

    def grasp(self, index: int) -> Pose:
        """Pose of the gripper at one of the experiment's grasps."""
        return _read_pose(self.experiment["grasps"][index])

    def open_at(self, world_from_palm: Pose) -> None:
        """Resets the simulation: the open hand at a pose, the object at rest."""
        self._mujoco.mj_resetData(self.model, self.data)
        self.steps = 0
        self._opens_from = None
        self._world_from_palm = world_from_palm

    def step(self, next_poses: list[Pose] | None = None) -> None:
        """Advances the drive by one step; the palm follows these poses, one per step of the model, or stands still."""
        figures = self.experiment
        speed = figures["course"]["closing_speed"]
        driven_m = speed * self.time_s
        if self._opens_from is not None:
            since, closed_m = self._opens_from
            driven_m = max(closed_m - speed * (self.steps - since) * figures["step_s"], 0.0)
        for finger, stroke_m in enumerate(self._strokes):
            # Past the end of the stroke, the set point advances until the drive has its full force.
            end_m = stroke_m + figures["closing_force_n"] / figures["drive_stiffness"]
            self.data.ctrl[finger] = min(driven_m, end_m)
        for step in range(figures["model_steps"]):
            self._move_palm(self._world_from_palm if next_poses is None else next_poses[step])
            self._mujoco.mj_step(self.model, self.data)
        self.steps += 1

    @property
    def time_s(self) -> float:
        """Time since the hand began to close (s)."""
        return self.steps * float(self.experiment["step_s"])

    def closed(self) -> tuple[float, float]:
        """Closed fraction of the hand, 0 to 1, and its rate (1/s): means over the fingers."""
        shares = self.data.qpos[self._finger_positions] / self._strokes
        rates = self.data.qvel[self._finger_velocities] / self._strokes
        return float(shares.mean()), float(rates.mean())

    def pressures(self) -> list[float | None]:
        """Contact force of each finger on the object (N); None without contact."""
        import numpy as np

        forces: list[Array | None] = [None] * len(self._strokes)
        wrench = np.zeros(6)
        for number in range(self.data.ncon):
            contact = self.data.contact[number]
            bodies = self.model.geom_bodyid[contact.geom]
            if contact.efc_address < 0 or self._object_body not in bodies:
                continue
            is_second = int(bodies[0] == self._object_body)
            finger = self._finger_of_body.get(int(bodies[is_second]))
            if finger is None:
                continue
            self._mujoco.mj_contactForce(self.model, self.data, number, wrench)
            force = contact.frame[:3] * wrench[0] * (-1.0 if is_second else 1.0)
            known = forces[finger]
            forces[finger] = force if known is None else known + force
        return [None if force is None else float(np.linalg.norm(force)) for force in forces]

    def _blocked(self) -> str | None:
        """Result if the open hand is in collision: it has knocked the object away or cannot close; None if it is
        free."""
        self._move_palm(self._world_from_palm)
        self._mujoco.mj_forward(self.model, self.data)
        hand = {self.model.body("palm").id, *self._finger_of_body}
        blocked = None
        for contact in self.data.contact[: self.data.ncon]:
            bodies = {int(body) for body in self.model.geom_bodyid[contact.geom]}
            if contact.dist < -self.experiment["blocked_m"] and bodies & hand:
                if self._object_body in bodies:
                    return "knocked-away"
                blocked = "never-closed"
        return blocked

    def _close(self) -> float | None:
        """Closes the hand; returns the mean contact force (N) of the fingers at rest, or None if not all touch the
        object."""
        figures, speed = self.experiment, float(self.experiment["course"]["closing_speed"])
        stroke_m = float(self._strokes.max())
        lead_s = float(figures["closing_force_n"]) / float(figures["drive_stiffness"]) / speed
        limit_s = stroke_m / speed + lead_s + figures["closing_grace_s"]
        step_s = float(figures["step_s"])
        lead_steps, full_steps = (max(round(time_s / step_s), 1) for time_s in (lead_s, float(figures["still_s"])))
        still_share = 0.0
        still: list[float] = []
        for _ in range(round(limit_s / figures["step_s"])):
            self.step()
            share, _ = self.closed()
            # Pads yield, so that a hand on a thin sheet may reach the end of its stroke.
            if share > 1.0 - figures["closed_share"] and all(pressure is None for pressure in self.pressures()):
                return None
            if abs(share - still_share) * stroke_m > figures["still_speed"] * figures["still_s"] or self.time_s <= lead_s:
                still_share, still = share, []
                continue
            # Contacts come last because they are the slowest to compute.
            pressed = [pressure for pressure in self.pressures() if pressure is not None]
            if len(pressed) < len(self._strokes):
                still_share, still = share, []
                continue
            still.append(sum(pressed) / len(pressed))
            if len(still) == lead_steps + full_steps:
                # The drive does not have its full force while its lead still grows.
                return sum(still[lead_steps:]) / full_steps
        return None

    def _follow(self, ways: Iterable[list[Pose]], force_n: float) -> GraspRun:
        """Follows a path, given for each step of the drive as one pose for each step of the model."""
        figures, course = self.experiment, self.experiment["course"]
        step_s = figures["step_s"]
        closed_from_object = self._hand_from_object()
        held_s: float | None = None
        error, duration_s = (0.0, 0.0), 0.0
        for step, way in enumerate(ways, 1):
            self.step(way)
            duration_s = step * step_s
            error = self.error(closed_from_object, self._hand_from_object())
            if held_s is None and not _is_held(course, error):
                held_s = duration_s
            if error[0] > figures["lost_m"]:
                return GraspRun("dropped", *error, duration_s if held_s is None else held_s, force_n)
        if all(pressure is None for pressure in self.pressures()):
            outcome = "dropped"
        else:
            outcome = "held" if _is_held(course, error) else "slipped"
        return GraspRun(outcome, *error, duration_s if held_s is None else held_s, force_n)

    def _between(self, poses: list[Pose]) -> Iterable[list[Pose]]:
        """Interpolated path from each pose to the next, in steps of the model."""
        import numpy as np

        parts = self.experiment["model_steps"]
        for pose in poses:
            start, turn = self._world_from_palm, np.zeros(3)
            self._mujoco.mju_subQuat(turn, pose.quaternion, start.quaternion)
            way = []
            for part in range(1, parts + 1):
                share, quaternion = part / parts, start.quaternion.copy()
                self._mujoco.mju_quatIntegrate(quaternion, turn, share)
                way.append(Pose(start.position + share * (pose.position - start.position), quaternion))
            yield way

    def _on_course(self, world_from_closed: Pose, time_s: float) -> Pose:
        """Pose of the hand at a time after closing: it is lifted by a polynomial of the fifth degree, then shaken along
        and about each of its axes by A sin²(π t / T) sin(2π f t)."""
        import numpy as np

        course = self.experiment["course"]
        share = min(time_s / course["lift_s"], 1.0)
        risen_m = course["lift_m"] * share**3 * (10.0 - share * (15.0 - 6.0 * share))
        lifted = Pose(world_from_closed.position + self._up * risen_m, world_from_closed.quaternion)
        since_s, axis_s = time_s - course["lift_s"], course["shake_periods"] / course["shake_hz"]
        if since_s <= 0.0 or since_s >= 3.0 * axis_s:
            return lifted
        axis = min(int(since_s / axis_s), 2)
        in_axis_s = since_s - axis * axis_s
        wave = math.sin(math.pi * in_axis_s / axis_s) ** 2 * math.sin(math.tau * course["shake_hz"] * in_axis_s)
        direction, turn = np.zeros(3), np.zeros(4)
        direction[axis] = 1.0
        self._mujoco.mju_axisAngle2Quat(turn, direction, wave * course["shake_rad"])
        return self._times(lifted, Pose(direction * wave * course["shake_m"], turn))

    def _move_palm(self, target: Pose) -> None:
        """Sets the velocity of the palm so that the next step of the model moves it to `target`."""
        import numpy as np

        start, dt = self._world_from_palm, self.model.opt.timestep
        turn = np.zeros(3)
        self._mujoco.mju_subQuat(turn, target.quaternion, start.quaternion)
        at, of = self._palm.qposadr[0], self._palm.dofadr[0]
        self.data.qpos[at : at + 3], self.data.qpos[at + 3 : at + 7] = start.position, start.quaternion
        self.data.qvel[of : of + 3], self.data.qvel[of + 3 : of + 6] = (target.position - start.position) / dt, turn / dt
        self._world_from_palm = target

    def world_from_object(self) -> Pose:
        """Pose of the object in the planning frame."""
        at = self._object.qposadr[0]
        return Pose(self.data.qpos[at : at + 3].copy(), self.data.qpos[at + 3 : at + 7].copy())

    def _hand_from_object(self) -> Pose:
        import numpy as np

        palm = self._world_from_palm
        inverse = Pose(np.zeros(3), np.zeros(4))
        self._mujoco.mju_negPose(inverse.position, inverse.quaternion, palm.position, palm.quaternion)
        return self._times(inverse, self.world_from_object())

    def _times(self, a: Pose, b: Pose) -> Pose:
        import numpy as np

        product = Pose(np.zeros(3), np.zeros(4))
        self._mujoco.mju_mulPose(
            product.position, product.quaternion, a.position, a.quaternion, b.position, b.quaternion
        )
        return product

    def error(self, expected: Pose, actual: Pose) -> tuple[float, float]:
        """Distance of the centre of mass from its expected position (m), and visible rotation of the object (rad)."""
        import numpy as np

        turn, a, b = np.zeros(3), np.zeros(3), np.zeros(3)
        self._mujoco.mju_trnVecPose(a, actual.position, actual.quaternion, self._center)
        self._mujoco.mju_trnVecPose(b, expected.position, expected.quaternion, self._center)
        self._mujoco.mju_subQuat(turn, actual.quaternion, expected.quaternion)
        unseen = self.experiment["unseen_turns"]
        if unseen == "all":
            angle = 0.0
        elif isinstance(unseen, Mapping):
            first, second = np.zeros(3), np.zeros(3)
            for axis, pose in ((first, expected), (second, actual)):
                self._mujoco.mju_rotVecQuat(axis, np.array(unseen["about"]), pose.quaternion)
            angle = math.atan2(float(np.linalg.norm(np.cross(first, second))), float(np.dot(first, second)))
        else:
            angle = float(np.linalg.norm(turn))
        return float(np.linalg.norm(a - b)), angle


def _mujoco() -> Any:
    """Imports MuJoCo; raises ImportError with the command that installs it."""
    try:
        import mujoco
    except ImportError as reason:
        raise ImportError("simulating grasps in MuJoCo needs its package: pip install cranny[mujoco]") from reason
    return mujoco


def _read_pose(written: Mapping[str, Any]) -> Pose:
    import numpy as np

    x, y, z, w = written["quaternion_xyzw"]
    return Pose(np.array(written["position"], dtype=np.float64), np.array([w, x, y, z], dtype=np.float64))


def _duration_s(course: Mapping[str, float]) -> float:
    """Duration of the course."""
    return course["lift_s"] + 3.0 * course["shake_periods"] / course["shake_hz"] + course["rest_s"]


def _is_held(course: Mapping[str, float], error: tuple[float, float]) -> bool:
    return error[0] <= course["slip_m"] and error[1] <= course["slip_rad"]
