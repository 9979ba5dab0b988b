"""Sets of proven demonstrations: rows, trajectories, batches for training, HDF5 for robomimic.

`cranny dataset generate` makes a set; this module reads its folder. It needs `pyarrow`; `Dataset.torch` needs `torch`,
`Dataset.pictures` Pillow, and `to_robomimic` `h5py`.

>>> from cranny import dataset
>>> rows = dataset.load("demonstrations")                 # doctest: +SKIP
>>> rows.table, rows.scenes                               # two Arrow tables    # doctest: +SKIP
>>> rows.path(0).shape                                    # way points of a row # doctest: +SKIP
(4, 9)
"""

from __future__ import annotations

import io
import json
import operator
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import pyarrow

__all__ = ["GRASP_RESULTS", "MODES", "Dataset", "Picture", "Samples", "TorchSamples", "load", "to_robomimic"]

#: Modes of a segment, by their numbers in the column `segments`.
MODES = ("reach", "approach", "lift-off", "carry", "set-down", "retreat", "return")

#: Results at a grasp, by their bytes in the column `grasp_results` of the scenes.
GRASP_RESULTS = (
    "reachable",
    "too-wide",
    "out-of-reach",
    "hand-collides",
    "no-ik",
    "arm-collides",
    "self-collision",
    "not-tried",
    "other",
)


class Dataset:
    """Rows of a set and their scenes, as Arrow tables that are mapped from disk.

    A position is that of a row in `table`; negative ones count from the end, and others raise IndexError."""

    def __init__(self, path: str | Path) -> None:
        """Opens the folder of a set. A shard and a set that is not complete have the rows of their finished chunks."""
        parquet = _parquet()
        self.folder = Path(path)
        description = self.folder / "dataset.json"
        if not description.is_file():
            raise ValueError(f"{self.folder}: no data set: expected a folder written by `cranny dataset generate`")
        #: Content of `dataset.json`.
        self.description: dict[str, Any] = json.loads(description.read_text(encoding="utf-8"))
        if self.description["format"] != "cranny-dataset/1":
            raise ValueError(f"{description}: unknown format {self.description['format']!r}")
        finished = sorted(file.name for file in (self.folder / "scenes").glob("*.parquet"))
        if not finished:
            raise ValueError(f"{self.folder}: the data set has no complete chunk yet")

        def whole(part: str) -> pyarrow.Table:
            files = [parquet.read_table(self.folder / part / name) for name in finished]
            return _arrow().concat_tables(files)

        #: Demonstrations, a row each: see the data card in the folder for the columns.
        self.table: pyarrow.Table = whole("demonstrations")
        #: Scenes, a row each.
        self.scenes: pyarrow.Table = whole("scenes")

    def __len__(self) -> int:
        """Number of rows, those without a path included."""
        return int(self.table.num_rows)

    def __repr__(self) -> str:
        return f"Dataset({str(self.folder)!r}: {len(self)} rows, {len(self.solved)} solved)"

    @cached_property
    def solved(self) -> NDArray[np.int64]:
        """Positions in `table` of the rows with a proven path."""
        outcomes = np.asarray(self.table["outcome"].to_pylist(), dtype=object)
        return np.flatnonzero(outcomes == "solved")

    @cached_property
    def _paths(self) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        return _flat(self.table["waypoints"])

    @cached_property
    def _times(self) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        return _flat(self.table["times_s"])

    @cached_property
    def _scene_places(self) -> dict[int, int]:
        return {int(scene): place for place, scene in enumerate(self.scenes["scene"].to_pylist())}

    def _position(self, place: int) -> int:
        """Position from the beginning."""
        count = len(self)
        if not -count <= operator.index(place) < count:
            raise IndexError(f"there is no position {place} among {count} rows")
        return int(place) % count

    def dof(self, place: int) -> int:
        """Number of joints of the robot of the row at a position."""
        return len(self.table["start"][self._position(place)])

    def path(self, place: int) -> NDArray[np.float64]:
        """Way points of the row at a position, (N, dof) in m and rad; (0, dof) unless solved."""
        place = self._position(place)
        values, offsets = self._paths
        return values[offsets[place] : offsets[place + 1]].reshape(-1, self.dof(place))

    def times(self, place: int) -> NDArray[np.float64]:
        """Times at which the way points are passed, (N,) in seconds. The motion stops at each."""
        place = self._position(place)
        values, offsets = self._times
        return values[offsets[place] : offsets[place + 1]]

    def scene(self, place: int) -> dict[str, Any]:
        """Row of the scene of the row at a position, as a dictionary, with `boxes` as (N, 10) and names of grasp results."""
        scene = self.scenes.slice(self._scene_places[int(self.table["scene"][self._position(place)].as_py())], 1).to_pylist()[0]
        scene["boxes"] = np.asarray(scene["boxes"], dtype=np.float32).reshape(-1, 10)
        scene["grasp_results"] = [GRASP_RESULTS[result] for result in scene["grasp_results"]]
        return dict(scene)

    def samples(self, task: str | None = "reach") -> Samples:
        """Pairs of a state and the way point to move to next, for training: one for each edge of each path of a task (of all tasks for `None`)."""
        return Samples(self, task)

    def torch(self, task: str | None = "reach") -> TorchSamples:
        """The `samples` for PyTorch's `DataLoader`: each item is a pair of tensors, observation and action."""
        return TorchSamples(self.samples(task))

    @cached_property
    def _pictures(self) -> pyarrow.Table | None:
        folder = self.folder / "pictures"
        if "cameras" not in self.description["recipe"]:
            return None
        parquet = _parquet()
        finished = sorted(file.name for file in (self.folder / "scenes").glob("*.parquet"))
        return _arrow().concat_tables([parquet.read_table(folder / name) for name in finished])

    @cached_property
    def _picture_places(self) -> dict[int, list[int]]:
        places: dict[int, list[int]] = {}
        scenes = self._pictures["scene"].to_pylist() if self._pictures is not None else []
        for place, scene in enumerate(scenes):
            places.setdefault(int(scene), []).append(place)
        return places

    def pictures(self, place: int) -> list[Picture]:
        """Pictures of the scene of the row at a position, one for each camera; the robot is at its own start. Needs Pillow."""
        places = self._picture_places.get(int(self.table["scene"][self._position(place)].as_py()), [])
        if self._pictures is None:
            return []
        return [Picture.of_row(self._pictures.slice(picture, 1).to_pylist()[0]) for picture in places]


@dataclass(frozen=True)
class Picture:
    """What a camera sees of a scene, without errors."""

    camera: str
    """Name of the camera."""
    depth_m: NDArray[np.float32]
    """Depths along the optical axis (height, width), NaN for none; in steps of a millimetre."""
    segments: NDArray[np.uint16]
    """Number of the body that each pixel shows (height, width), 0 for none."""
    names: list[str]
    """Names of the bodies, from number 1; the last is the robot."""
    intrinsics_px: NDArray[np.float64]
    """Focal lengths along x and y, then the principal point; pixel centres are whole numbers."""
    pose: NDArray[np.float64]
    """Optical frame in the planning frame: position (m), unit quaternion (w, x, y, z)."""

    @classmethod
    def of_row(cls, row: dict[str, Any]) -> Picture:
        """Picture of a row of the files in `pictures`."""
        millimetres = _png(row["depth_png"])
        return cls(
            camera=row["camera"],
            depth_m=np.where(millimetres > 0, millimetres * np.float32(1e-3), np.float32("nan")).astype(np.float32),
            segments=_png(row["segments_png"]),
            names=list(row["segments"]),
            intrinsics_px=np.asarray(row["intrinsics_px"]),
            pose=np.asarray(row["pose"]),
        )


class TorchSamples:
    """Samples as tensors, a map-style dataset for `torch.utils.data.DataLoader`.

    A `DataLoader` with the default settings gets all items of a batch in one call; `loader` makes one that also skips their
    collation, which is several times faster.
    """

    def __init__(self, samples: Samples) -> None:
        """Takes over the arrays without a copy."""
        import torch

        #: Observations, (N, dof + 8).
        self.observations: Any = torch.from_numpy(samples.observations)
        #: Actions, (N, dof).
        self.actions: Any = torch.from_numpy(samples.actions)

    def __len__(self) -> int:
        """Number of samples."""
        return len(self.observations)

    def __getitem__(self, index: int | Sequence[int]) -> tuple[Any, Any]:
        """Observation and action of a sample, or those of several at once."""
        return self.observations[index], self.actions[index]

    def __getitems__(self, indices: Sequence[int]) -> list[tuple[Any, Any]]:
        """Pairs of several samples, which `DataLoader` collates."""
        observations, actions = self[indices]
        return list(zip(observations, actions, strict=True))

    def loader(self, batch_size: int = 1024, *, shuffle: bool = True, workers: int = 0, seed: int = 0) -> Any:
        """A `DataLoader` whose batches are indexed as a whole; `seed` determines the order of each epoch."""
        import torch
        from torch.utils import data

        random = torch.Generator()
        random.manual_seed(seed)
        order = data.RandomSampler(self, generator=random) if shuffle else data.SequentialSampler(self)
        batches = data.BatchSampler(order, batch_size, drop_last=False)
        # Without a batch size of its own, the loader passes each batch of indices to `__getitem__`.
        return data.DataLoader(self, sampler=batches, batch_size=None, num_workers=workers, persistent_workers=workers > 0)


class Samples:
    """Pairs of an observation and an action, as single precision arrays.

    An observation is the present way point, the pose of the object (7) and the difficulty parameter of the scene; an action is the
    step to the next way point. Rows of robots with another number of joints than the first are left out.
    """

    def __init__(self, dataset: Dataset, task: str | None) -> None:
        """Collects the edges of the solved rows of a task."""
        tasks = dataset.table["task"].to_pylist()
        rows = [int(place) for place in dataset.solved if task is None or tasks[place] == task]
        if not rows:
            raise ValueError(f"{dataset.folder}: no solved row of the task {task!r}")
        poses = np.asarray(dataset.scenes["target_pose"].to_pylist() or [[]], dtype=object)
        parameters = dataset.scenes["parameter_m"].to_numpy()
        scenes = dataset.table["scene"].to_pylist()
        places = dataset._scene_places
        dof = dataset.dof(rows[0])
        observations, actions, of_rows = [], [], []
        for row in rows:
            if dataset.dof(row) != dof:
                continue
            path = dataset.path(row)
            scene = places[scenes[row]]
            context = np.concatenate([np.asarray(poses[scene], dtype=float), [parameters[scene]]])
            edges = len(path) - 1
            observations.append(np.hstack([path[:-1], np.tile(context, (edges, 1))]))
            actions.append(np.diff(path, axis=0))
            of_rows.append(np.full(edges, row))
        #: Observations, (N, dof + 8).
        self.observations: NDArray[np.float32] = np.concatenate(observations).astype(np.float32)
        #: Actions, (N, dof).
        self.actions: NDArray[np.float32] = np.concatenate(actions).astype(np.float32)
        #: Position of the row of each sample, (N,).
        self.rows: NDArray[np.int64] = np.concatenate(of_rows).astype(np.int64)

    def __len__(self) -> int:
        """Number of samples."""
        return len(self.observations)

    def batches(self, size: int, seed: int = 0) -> Iterator[tuple[NDArray[np.float32], NDArray[np.float32]]]:
        """Batches of observations and actions of one epoch, in an order drawn from a seed; the last one may be smaller."""
        order = np.random.default_rng(seed).permutation(len(self))
        for begin in range(0, len(order), size):
            chosen = order[begin : begin + size]
            yield self.observations[chosen], self.actions[chosen]


def load(path: str | Path) -> Dataset:
    """Opens the folder of a set that `cranny dataset generate` made."""
    return Dataset(path)


def to_robomimic(lerobot: str | Path, output: str | Path, env_name: str = "cranny") -> int:
    """Writes the episodes of `cranny dataset export --format lerobot` as one HDF5 file in the layout of robomimic.

    Returns the number of demonstrations. Actions are the steps of the state, divided by the greatest of each element, so that they
    are within [-1, 1]; the attribute `action_scale` of `data` has the divisors. Needs `h5py` and `pyarrow`.
    """
    import h5py

    parquet = _parquet()
    folder = Path(lerobot)
    info = json.loads((folder / "meta" / "info.json").read_text(encoding="utf-8"))
    files = sorted((folder / "data").glob("chunk-*/file-*.parquet"))
    keys = ("observation.state", "observation.environment_state")

    def frames() -> Iterator[tuple[NDArray[np.float32], ...]]:
        for file in files:
            table = parquet.read_table(file)
            episodes = table["episode_index"].to_numpy()
            state, environment = (np.stack(table[key].to_numpy()) for key in keys)
            bounds = np.flatnonzero(np.diff(episodes, prepend=-1, append=-1))
            for begin, end in zip(bounds[:-1], bounds[1:], strict=True):
                yield state[begin:end], environment[begin:end]

    scale = np.zeros(info["features"]["action"]["shape"])
    for state, _ in frames():
        scale = np.maximum(scale, np.abs(np.diff(state, axis=0)).max(axis=0, initial=0.0))
    scale[scale == 0.0] = 1.0
    count = total = 0
    with h5py.File(output, "w") as file:
        data = file.create_group("data")
        for state, environment in frames():
            following = np.vstack([state[1:], state[-1:]])
            demonstration = data.create_group(f"demo_{count}")
            demonstration.attrs["num_samples"] = len(state)
            demonstration["states"] = np.hstack([state, environment])
            demonstration["actions"] = np.clip((following - state) / scale, -1.0, 1.0).astype(np.float32)
            rewards = np.zeros(len(state), dtype=np.float32)
            rewards[-1] = 1.0
            demonstration["rewards"] = rewards
            demonstration["dones"] = rewards.astype(np.int64)
            for name, values in (("obs", state), ("next_obs", following)):
                demonstration[f"{name}/state"] = values
                demonstration[f"{name}/object"] = environment
            count += 1
            total += len(state)
        data.attrs["total"] = total
        data.attrs["action_scale"] = scale
        data.attrs["env_args"] = json.dumps({"env_name": env_name, "env_type": 4, "env_kwargs": {"fps": info["fps"]}})
        names = [f"demo_{index}".encode() for index in range(count)]
        held_out = max(1, count // 10)
        file["mask/train"] = names[:-held_out] or names
        file["mask/valid"] = names[-held_out:]
    return count


def _arrow() -> Any:
    try:
        import pyarrow
    except ImportError as fault:
        raise ImportError("cranny.dataset reads Parquet by pyarrow: pip install pyarrow") from fault
    return pyarrow


def _parquet() -> Any:
    _arrow()
    import pyarrow.parquet

    return pyarrow.parquet


def _png(content: bytes) -> NDArray[np.uint16]:
    try:
        from PIL import Image
    except ImportError as fault:
        raise ImportError("pictures are decoded by Pillow: pip install pillow") from fault
    return np.asarray(Image.open(io.BytesIO(content))).astype(np.uint16)


def _flat(column: Any) -> tuple[NDArray[Any], NDArray[np.int64]]:
    """Values of a column of lists one after another, and where each list begins, with the end."""
    lists = column.combine_chunks()
    lengths = lists.value_lengths().to_numpy(zero_copy_only=False)
    return lists.flatten().to_numpy(), np.concatenate([[0], np.cumsum(lengths)])
