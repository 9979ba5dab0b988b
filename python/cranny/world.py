"""Worlds that sensors update: depth images and point clouds around what is known."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import count as numbers_from
from typing import TYPE_CHECKING, Any, Literal

from cranny._cranny import Body, Cell, DepthView, Plan, Scenario, _with_views, filter_cloud
from cranny._cranny import plan as plan_of_scenario

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    Sensor = Mapping[str, float] | Sequence[Mapping[str, float]]


@dataclass(frozen=True)
class _Images:
    """Arguments of the images that were given last, for an update that leaves some of them out."""

    intrinsics: list[Any]
    poses: list[Any]
    scale: float | None
    sensors: list[Mapping[str, float]]
    names: list[str]


@dataclass
class _State:
    """Everything that an update replaces, as a whole; the cell is made when it is needed."""

    known: Scenario
    views: tuple[DepthView, ...]
    images: _Images | None
    clouds: dict[str, tuple[Body, dict[str, int]]]
    scenario: Scenario
    cell: Cell | None = None


class World:
    """World around a robot, of what is known, what depth cameras have seen, and point clouds.

    `scenario`: what is known, a Scenario: the robot at its start, obstacles whose places are known, the object to grasp, the
    floor, the goals. With `views` (a list of DepthView), all surfaces that they show are obstacles too, and all space that none of
    them shows to be free. `q`: configuration of the robot now, from which `plan` starts (None: the start of the scenario). The robot is
    cut out of the map, in each view at the `q` of the view (None: as now), as are the bodies of the scenario. The other keywords are
    those of `seen` in a `scenario.yaml` (docs/sensing.md): `unseen` "solid" or "free",
    `cell_m`, `fine_m`, `region` (2, 3), the least and the greatest coordinates, rounded up to whole cubes of 16 `cell_m`,
    `robot_reach_m`, `floor_reach_m`, `tolerance_m`; None: the default there.

    `update`, `add_cloud` and `remove_cloud` replace the obstacles as a whole or, if they raise an exception, not at all. A check
    or a plan that has begun uses those of its beginning. `scenario` and `cell` are immutable, as they are now."""

    def __init__(
        self,
        scenario: Scenario,
        *,
        views: Sequence[DepthView] = (),
        q: ArrayLike | None = None,
        unseen: Literal["solid", "free"] = "solid",
        cell_m: float | None = None,
        fine_m: float | None = None,
        region: ArrayLike | None = None,
        robot_reach_m: float | None = None,
        floor_reach_m: float | None = None,
        tolerance_m: float | None = None,
    ) -> None:
        self._options: dict[str, Any] = {
            "unseen": unseen,
            "cell_m": cell_m,
            "fine_m": fine_m,
            "region": region,
            "robot_reach_m": robot_reach_m,
            "floor_reach_m": floor_reach_m,
            "tolerance_m": tolerance_m,
        }
        known = scenario if q is None else scenario.with_start(q)
        self._state = self._built(known, tuple(views), None, {})

    @classmethod
    def from_depth(
        cls,
        images: Sequence[ArrayLike],
        intrinsics: ArrayLike | Sequence[ArrayLike] | None,
        poses: ArrayLike | Sequence[ArrayLike],
        *,
        scenario: Scenario,
        q: ArrayLike | None = None,
        scale: float | None = None,
        sensor: Sensor | None = None,
        names: Sequence[str] | None = None,
        unseen: Literal["solid", "free"] = "solid",
        cell_m: float | None = None,
        fine_m: float | None = None,
        region: ArrayLike | None = None,
        robot_reach_m: float | None = None,
        floor_reach_m: float | None = None,
        tolerance_m: float | None = None,
    ) -> World:
        """World of depth images: a list of arrays (H, W), uint16 in millimetres or floats in metres;
        all of them are in units of `scale` metres if that is given.

        `intrinsics`: (fx, fy, cx, cy) or a camera matrix (3, 3), one for all images or a list; pixels. `poses`:
        `world_from_camera`, (N, 4, 4), of the optical frames. `sensor`: bounds of the errors as keywords of DepthView, one
        dictionary for all images or a list. The other keywords are those of World. See DepthView for valid depths; `report`
        counts the others."""
        world = cls(
            scenario,
            q=q,
            unseen=unseen,
            cell_m=cell_m,
            fine_m=fine_m,
            region=region,
            robot_reach_m=robot_reach_m,
            floor_reach_m=floor_reach_m,
            tolerance_m=tolerance_m,
        )
        if intrinsics is None:
            raise ValueError("intrinsics: there are none; give (fx, fy, cx, cy) or a camera matrix (3, 3), in pixels")
        world.update(images, intrinsics, poses, scale=scale, sensor=sensor, names=names)
        return world

    @classmethod
    def from_cloud(
        cls,
        points: ArrayLike,
        radius_m: float,
        *,
        scenario: Scenario,
        q: ArrayLike | None = None,
        pose: ArrayLike | None = None,
        voxel_m: float | None = None,
        crop: ArrayLike | None = None,
        own_margin_m: float | None = None,
        target_margin_m: float | None = None,
        name: str = "cloud",
    ) -> World:
        """World with a point cloud, (N, 3) in metres, as an obstacle: see `add_cloud`. Space without points counts as free."""
        world = cls(scenario, q=q)
        world.add_cloud(
            points,
            radius_m,
            name=name,
            pose=pose,
            voxel_m=voxel_m,
            crop=crop,
            own_margin_m=own_margin_m,
            target_margin_m=target_margin_m,
        )
        return world

    def update(
        self,
        images: Sequence[ArrayLike],
        intrinsics: ArrayLike | Sequence[ArrayLike] | None = None,
        poses: ArrayLike | Sequence[ArrayLike] | None = None,
        *,
        add: bool = False,
        q: ArrayLike | None = None,
        scale: float | None = None,
        sensor: Sensor | None = None,
        names: Sequence[str] | None = None,
    ) -> None:
        """Replaces the views by new images, or adds them (`add`), and maps the space that they show. Arguments that are left out are
        those of the last images, which must then be as many. `q`: configuration of the robot now, in these images (None: as before);
        views that are kept show it where it was. `names`: names of the new views, which no other view has (None: those of the last
        images, or "view1", "view2", …)."""
        state = self._state
        known = state.known
        if q is not None:
            known = known.with_start(q)
        taken = tuple(view.name for view in state.views) if add else ()
        given = _images(images, intrinsics, poses, scale, sensor, names, state.images, taken)
        views = tuple(_view(image, index, given) for index, image in enumerate(images))
        before = state.known.start
        kept = tuple(view.with_q(before) if view.q is None else view for view in state.views) if add else ()
        self._state = self._built(known, kept + views, given, state.clouds)

    def add_cloud(
        self,
        points: ArrayLike,
        radius_m: float,
        *,
        name: str = "cloud",
        pose: ArrayLike | None = None,
        voxel_m: float | None = None,
        crop: ArrayLike | None = None,
        own_margin_m: float | None = None,
        target_margin_m: float | None = None,
    ) -> None:
        """Adds the points (N, 3) of a cloud, in metres, as an obstacle: a ball of `radius_m` around each. The radius must cover the
        noise and the gaps: at least half of the diagonal between neighbouring points. A cloud of that name is replaced.

        `pose`: `world_from_cloud`. `crop`: box (2, 3) of the points that are kept. `own_margin_m`: distance (m) from the robot
        within which points are its own and dropped; `target_margin_m`: the same for the object to grasp. `voxel_m`: side of voxels
        of which one point each is kept; the balls then grow by their diagonal, so that they cover what is left out. `report`
        counts what was dropped."""
        state = self._state
        target = state.known.target
        if target_margin_m is not None and target is None:
            raise ValueError("target_margin_m: the scenario has no target")
        is_own = own_margin_m is not None
        kept, counts = filter_cloud(
            points,
            pose=pose,
            crop=crop,
            robot=state.known.robot if is_own else None,
            q=state.known.start if is_own else None,
            own_margin_m=own_margin_m,
            known=[target] if target is not None and target_margin_m is not None else None,
            known_margin_m=target_margin_m,
            voxel_m=voxel_m,
        )
        if counts["kept"] == 0:
            dropped = ", ".join(f"{count} {why}" for why, count in counts.items() if why not in ("points", "kept"))
            raise ValueError(f"points: none of the {counts['points']} points is left ({dropped})")
        body = Body.cloud(name, kept, radius_m + math.sqrt(3.0) * (voxel_m or 0.0))
        clouds = {**state.clouds, name: (body, counts)}
        self._state = self._built(state.known, state.views, state.images, clouds)

    def remove_cloud(self, name: str = "cloud") -> None:
        """Removes the cloud of that name."""
        state = self._state
        if name not in state.clouds:
            raise ValueError(f"there is no cloud '{name}' (there are: {', '.join(state.clouds) or 'none'})")
        clouds = {key: value for key, value in state.clouds.items() if key != name}
        self._state = self._built(state.known, state.views, state.images, clouds)

    @property
    def scenario(self) -> Scenario:
        """Scenario with all obstacles as they are now, for `cranny.plan`, `cranny.show` and all else that takes a scenario."""
        return self._state.scenario

    @property
    def views(self) -> list[DepthView]:
        """Views of which the map is made."""
        return list(self._state.views)

    @property
    def report(self) -> dict[str, Any]:
        """Dictionary of "views", for each its "name", "valid" pixels and those "dropped" by the reason, of "clouds", for each its
        "name" and counts, and of "seen", as `Scenario.seen`."""
        state = self._state
        return {
            "views": [{"name": view.name, "valid": view.valid, "dropped": view.dropped} for view in state.views],
            "clouds": [{"name": name, **counts} for name, (_, counts) in state.clouds.items()],
            "seen": state.scenario.seen,
        }

    @property
    def cell(self) -> Cell:
        """Robot among all obstacles, as `Scenario.cell()`."""
        state = self._state
        if state.cell is None:
            # Another thread may do the same; both cells are equal.
            state.cell = state.scenario.cell()
        return state.cell

    def is_free(self, q: ArrayLike, *, threads: int | None = 1) -> Any:
        """As `Cell.is_free`."""
        return self.cell.is_free(q, threads=threads)

    def clearance(self, q: ArrayLike, *, threads: int | None = 1) -> Any:
        """As `Cell.clearance`."""
        return self.cell.clearance(q, threads=threads)

    def motion_is_free(self, a: ArrayLike, b: ArrayLike, *, threads: int | None = 1) -> Any:
        """As `Cell.motion_is_free`."""
        return self.cell.motion_is_free(a, b, threads=threads)

    def plan(self, planner: str | None = None, *, start: ArrayLike | None = None, **keywords: Any) -> Plan:
        """Plans as `cranny.plan` among the obstacles as they are now, from `start` (None: the configuration in the last images).
        The keywords are those of `cranny.plan`."""
        return plan_of_scenario(self.scenario, planner, start=start, **keywords)

    def __repr__(self) -> str:
        state = self._state
        return f"<cranny.World of '{state.known.id}': {len(state.views)} views, {len(state.clouds)} clouds>"

    def _built(
        self,
        known: Scenario,
        views: tuple[DepthView, ...],
        images: _Images | None,
        clouds: dict[str, tuple[Body, dict[str, int]]],
    ) -> _State:
        scenario = _with_views(known, list(views), **self._options) if views else known
        for body, _ in clouds.values():
            scenario = scenario.with_body(body)
        return _State(known, views, images, clouds, scenario)


def _images(
    images: Sequence[ArrayLike],
    intrinsics: ArrayLike | Sequence[ArrayLike] | None,
    poses: ArrayLike | Sequence[ArrayLike] | None,
    scale: float | None,
    sensor: Sensor | None,
    names: Sequence[str] | None,
    last: _Images | None,
    taken: Sequence[str],
) -> _Images:
    """The arguments of images, one of each for each image; missing ones are those of the last images. `taken`: names of the views
    that are kept."""
    count = len(images)
    if count == 0:
        raise ValueError("images: the list is empty, but at least one image is expected")
    of_last = last is not None and len(last.poses) == count

    def listed(what: str, given: Any, shape: str, is_one: bool, previous: Any) -> list[Any]:
        if given is None:
            if previous is None or not of_last:
                known = "none are known" if last is None else f"those of {len(last.poses)} images are known"
                raise ValueError(f"{what}: there are none for {count} images, and {known}; give {shape}")
            return list(previous)
        if is_one:
            return [given] * count
        entries = list(given)
        if len(entries) != count:
            raise ValueError(f"{what}: {len(entries)} are given for {count} images")
        return entries

    is_pose = poses is not None and _depth_of(poses) == 2
    if is_pose and count != 1:
        raise ValueError(f"poses: one pose is given for {count} images, but (N, 4, 4) is expected")
    camera = "(fx, fy, cx, cy) or a camera matrix (3, 3), in pixels"
    is_one = intrinsics is not None and (_depth_of(intrinsics) == 1 or _is_matrix(intrinsics))
    if sensor is None and not of_last:
        sensor = {}
    if names is None and (taken or not of_last):
        free = (name for name in map("view{}".format, numbers_from(len(taken) + 1)) if name not in taken)
        names = [next(free) for _ in range(count)]
    called = listed("names", names, "a list", False, last and last.names)
    if twice := [name for index, name in enumerate(called) if name in (*taken, *called[:index])]:
        raise ValueError(f"names: there is a view '{twice[0]}' already; give each view a name of its own")
    return _Images(
        intrinsics=listed("intrinsics", intrinsics, camera, is_one, last and last.intrinsics),
        poses=listed("poses", poses, "`world_from_camera`, (N, 4, 4)", is_pose, last and last.poses),
        scale=scale if scale is not None or last is None else last.scale,
        sensors=listed("sensor", sensor, "a dictionary", isinstance(sensor, Mapping), last and last.sensors),
        names=called,
    )


def _depth_of(value: Any) -> int:
    """Number of indices of an array or nested lists, by the first entries."""
    if (dimensions := getattr(value, "ndim", None)) is not None:
        return int(dimensions)
    return 1 + _depth_of(value[0]) if isinstance(value, Sequence) and not isinstance(value, str) and value else 0


def _is_matrix(intrinsics: Any) -> bool:
    """True for a camera matrix (3, 3), False for a list of (fx, fy, cx, cy) or of matrices."""
    return _depth_of(intrinsics) == 2 and len(intrinsics) == 3 and len(intrinsics[0]) == 3


def _view(image: ArrayLike, index: int, given: _Images) -> DepthView:
    try:
        return DepthView(
            image,
            given.intrinsics[index],
            given.poses[index],
            name=given.names[index],
            scale=given.scale,
            **given.sensors[index],
        )
    except (ValueError, TypeError) as reason:
        raise type(reason)(f"image {index}: {reason}") from None
