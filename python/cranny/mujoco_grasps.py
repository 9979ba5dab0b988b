"""A second opinion on simulated grasps: runs in MuJoCo what Cranny runs in an engine of its own, by the same rules.

An experiment is the document that `cranny simulate export` writes: the model of hand, object and
surroundings, what the hand does, what counts as held, and the grasps.

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
    """What came of a grasp."""

    outcome: str
    """`held`, `slipped`, `dropped`, `never-closed` or `knocked-away`."""
    translation_error_m: float
    """How far the object's centre of mass is from where it was in the hand when that had closed; where it never closed,
    from where it was in the world."""
    rotation_error_rad: float
    """How far it is turned against that."""
    held_s: float
    """From the closing to the first moment when the object was elsewhere in the hand; to the end if there is none."""
    contact_force_n: float
    """With what a finger pressed when the hand had closed: the mean of the fingers."""


@dataclass(frozen=True)
class PlanRun:
    """What came of a plan, from where the hand closes."""

    grasp: GraspRun
    """The object in the hand, up to where the plan ends or releases it."""
    released: tuple[float, float] | None
    """How far (m) and how much turned (rad) the object was from where it is to be put down when it was released; None if it
    was not."""
    placed: tuple[float, float] | None
    """The same 2 s after the arm has stopped."""
    stands: bool
    """True if that is within the limits of the plan."""

    @property
    def is_kept(self) -> bool:
        """True if the object was in the hand up to there, and slipped no farther than the limit."""
        return self.grasp.outcome == "held"


def load(path: str | os.PathLike[str]) -> dict[str, Any]:
    """The experiment in a file."""
    experiment = json.loads(Path(path).read_text(encoding="utf-8"))
    if not isinstance(experiment, dict) or "mjcf" not in experiment:
        raise ValueError(f"{os.fspath(path)} is no experiment: it has no model ('mjcf')")
    return experiment


def run_all(experiment: Mapping[str, Any]) -> list[GraspRun]:
    """Runs all grasps of an experiment, one after the other, in their order."""
    model = GraspModel(experiment)
    return [model.run(index) for index in range(len(experiment["grasps"]))]


def run_plan(experiment: Mapping[str, Any]) -> PlanRun:
    """Runs a plan of one pick that `cranny simulate plan --export` or `cranny.plan_experiment` wrote."""
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
    """A pose in the planning frame, or in another body's."""

    position: Array
    """(3,), in metres."""
    quaternion: Array
    """(4,), of unit length, the real part first."""


class GraspModel:
    """An experiment as a model of MuJoCo, and the state of its one world.

    The palm is a body of great mass whose pose and velocity are set before every step: MuJoCo's own bodies that are
    moved from outside have no velocity, so that friction would not carry anything with them.
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
        """How many steps of the drive were made."""
        self._opens_from: tuple[int, float] | None = None
        self._strokes = np.array(experiment["strokes_m"], dtype=np.float64)
        names = [f"finger {number}" for number in range(1, len(self._strokes) + 1)]
        self._palm, self._object = (self.model.joint(name) for name in ("palm", "object"))
        joints = [self.model.joint(name) for name in names]
        self._finger_positions = np.array([joint.qposadr[0] for joint in joints])
        self._finger_velocities = np.array([joint.dofadr[0] for joint in joints])
        self._finger_of_body = {self.model.body(name).id: index for index, name in enumerate(names)}
        self._object_body = self.model.body("object").id
        self._center = np.array(experiment["center_in_object"], dtype=np.float64)
        self._gravity = np.array([0.0, 0.0, -float(experiment["gravity"])])

    def run(self, index: int) -> GraspRun:
        """Runs one of the experiment's grasps."""
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
        """Closes the hand at one of the grasps: with what a finger presses then (N), or how it ended."""
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
        """Takes the hand, and what it has closed on, to these poses, one for each step of the drive."""
        return self._follow(self._between(poses), force_n)

    def open(self, poses: list[Pose]) -> None:
        """Opens the hand while it goes to these poses, one for each step of the drive."""
        self._opens_from = (self.steps, self.closed()[0] * float(self._strokes.max()))
        for some in self._between(poses):
            self.step(some)

    def grasp(self, index: int) -> Pose:
        """The pose of the gripper at one of the experiment's grasps."""
        return _read_pose(self.experiment["grasps"][index])

    def open_at(self, world_from_palm: Pose) -> None:
        """The open hand at a pose, the object at rest."""
        self._mujoco.mj_resetData(self.model, self.data)
        self.steps = 0
        self._opens_from = None
        self._world_from_palm = world_from_palm

    def step(self, next_poses: list[Pose] | None = None) -> None:
        """A step of the drive; the palm goes through these poses, one for each step of the model, or stands still."""
        figures = self.experiment
        speed = figures["course"]["closing_speed"]
        driven_m = speed * self.time_s
        if self._opens_from is not None:
            since, closed_m = self._opens_from
            driven_m = max(closed_m - speed * (self.steps - since) * figures["step_s"], 0.0)
        for finger, stroke_m in enumerate(self._strokes):
            # Behind the end of the stroke the place goes on until the force is whole.
            end_m = stroke_m + figures["closing_force_n"] / figures["drive_stiffness"]
            self.data.ctrl[finger] = min(driven_m, end_m)
        for step in range(figures["model_steps"]):
            self._move_palm(self._world_from_palm if next_poses is None else next_poses[step])
            self._mujoco.mj_step(self.model, self.data)
        self.steps += 1

    @property
    def time_s(self) -> float:
        """Since the hand began to close."""
        return self.steps * float(self.experiment["step_s"])

    def closed(self) -> tuple[float, float]:
        """How far the hand has closed, 0 to 1, and how fast it closes (1/s): the mean of the fingers."""
        shares = self.data.qpos[self._finger_positions] / self._strokes
        rates = self.data.qvel[self._finger_velocities] / self._strokes
        return float(shares.mean()), float(rates.mean())

    def pressures(self) -> list[float | None]:
        """With what each finger presses on the object (N); None where it does not touch it."""
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
        """How a grasp ends at which the open hand stands in something: it has pushed the object away on its way there, or
        cannot close there."""
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
        """Closes the hand. With what the fingers press while they are still, the mean (N); None if not all of them touch
        the object."""
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
            if share > 1.0 - figures["closed_share"]:
                return None
            if abs(share - still_share) * stroke_m > figures["still_speed"] * figures["still_s"] or self.time_s <= lead_s:
                still_share, still = share, []
                continue
            # Contacts are asked only now, for they take longest.
            pressed = [pressure for pressure in self.pressures() if pressure is not None]
            if len(pressed) < len(self._strokes):
                still_share, still = share, []
                continue
            still.append(sum(pressed) / len(pressed))
            if len(still) == lead_steps + full_steps:
                # While its lead grew, the drive had not its whole force.
                return sum(still[lead_steps:]) / full_steps
        return None

    def _follow(self, ways: Iterable[list[Pose]], force_n: float) -> GraspRun:
        """Follows a way, given for each step of the drive as a pose for each step of the model."""
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
        """The way to each of these poses from the one before, in steps of the model."""
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
        """Where the hand is, that long after it has closed: lifted by a polynomial of the fifth degree, then shaken along
        and about each of its axes by A sin²(π t / T) sin(2π f t)."""
        import numpy as np

        course = self.experiment["course"]
        share = min(time_s / course["lift_s"], 1.0)
        risen_m = course["lift_m"] * share**3 * (10.0 - share * (15.0 - 6.0 * share))
        lifted = Pose(world_from_closed.position + np.array([0.0, 0.0, risen_m]), world_from_closed.quaternion)
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
        """Gives the palm the velocity that takes it from where it is to `target` in the next step of the model."""
        import numpy as np

        start, dt = self._world_from_palm, self.model.opt.timestep
        turn = np.zeros(3)
        self._mujoco.mju_subQuat(turn, target.quaternion, start.quaternion)
        at, of = self._palm.qposadr[0], self._palm.dofadr[0]
        self.data.qpos[at : at + 3], self.data.qpos[at + 3 : at + 7] = start.position, start.quaternion
        self.data.qvel[of : of + 3], self.data.qvel[of + 3 : of + 6] = (target.position - start.position) / dt, turn / dt
        self._world_from_palm = target

    def world_from_object(self) -> Pose:
        """The pose of the object in the planning frame."""
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
        """How far the centre of mass is from where it should be (m), and how far the object is seen to be turned (rad)."""
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
    """The package of that name."""
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
    """How long the course takes."""
    return course["lift_s"] + 3.0 * course["shake_periods"] / course["shake_hz"] + course["rest_s"]


def _is_held(course: Mapping[str, float], error: tuple[float, float]) -> bool:
    return error[0] <= course["slip_m"] and error[1] <= course["slip_rad"]
