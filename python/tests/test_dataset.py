"""Sets of demonstrations: read by pyarrow, compared with their own way points, and written for other programs."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import cranny
import numpy as np
import pytest
from conftest import package
from cranny import dataset

RECIPE = """
count: 40
queries_per_scene: 5
families: [gap, table]
tasks: {reach: 5, carry: 1, place: 1}
rate_hz: 10
cameras: {default: 2}
"""


def program(*arguments: Any) -> None:
    """Runs the command of the package."""
    subprocess.run([sys.executable, "-m", "cranny", *map(str, arguments)], check=True, capture_output=True)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small set, and its export for LeRobot."""
    package("pyarrow")
    place = tmp_path_factory.mktemp("dataset")
    (place / "recipe.yaml").write_text(RECIPE, encoding="utf-8")
    program("dataset", "generate", place / "recipe.yaml", "-o", place / "set")
    program("dataset", "export", place / "set", "--format", "lerobot", "-o", place / "lerobot")
    return place


def test_rows_are_what_their_way_points_give(folder: Path) -> None:
    rows = dataset.load(folder / "set")
    assert len(rows) == 40 and len(rows.solved) > 30 and "40 rows" in repr(rows)
    table = rows.table.to_pylist()
    robot = cranny.Scenario("021").robot
    assert list(rows.description["joint_names"].values()) == [robot.joint_names]
    for place in map(int, rows.solved):
        row, path = table[place], rows.path(place)
        assert np.isclose(np.linalg.norm(np.diff(path, axis=0), axis=1).sum(), row["path_length"])
        assert (path[0] == row["start"]).all()
        times = rows.times(place)
        assert len(times) == len(path) and (np.diff(times) > 0).all() and times[-1] <= row["duration_s"]
        scene = rows.scene(place)
        assert scene["grasp_results"][row["grasp"]] in dataset.GRASP_RESULTS
        assert scene["boxes"].shape[1] == 10
        stages = np.reshape(row["segments"], (-1, 3))
        assert stages[:, 2].sum() - (len(stages) - 1) == len(path)
        # The gripper is at the grasp where the reach ends, within the tolerance of `exact`, or at its twin.
        tip = robot.fk(path[stages[0, 2] - 1])
        assert np.linalg.norm(tip[:3, 3] - row["grasp_pose"][:3]) < 1e-3


def test_negative_positions_count_from_the_end(folder: Path) -> None:
    rows = dataset.load(folder / "set")
    for place in (0, len(rows) - 1, int(rows.solved[-1])):
        back = place - len(rows)
        assert rows.path(back).tolist() == rows.path(place).tolist() and rows.dof(back) == rows.dof(place)
        assert rows.times(back).tolist() == rows.times(place).tolist()
        assert rows.scene(back)["scene"] == rows.scene(place)["scene"]
        pictures = [[picture.pose.tolist() for picture in rows.pictures(at)] for at in (back, place)]
        assert pictures[0] == pictures[1]
    assert len(rows.path(int(rows.solved[-1]) - len(rows))) > 0
    for read in (rows.path, rows.times, rows.scene, rows.pictures, rows.dof):
        for place in (len(rows), -len(rows) - 1):
            with pytest.raises(IndexError, match=f"no position {place} among 40 rows"):
                read(place)


def test_paths_are_free_in_the_extracted_scenes(folder: Path, tmp_path: Path) -> None:
    rows = dataset.load(folder / "set")
    tasks = rows.table["task"].to_pylist()
    place = next(int(place) for place in rows.solved if tasks[place] == "reach")
    program("dataset", "extract", folder / "set", place, "-o", tmp_path / "row")
    scenario = cranny.Scenario(str(tmp_path / "row"))
    assert scenario.cell().motion_is_free(rows.path(place)[:-1], rows.path(place)[1:]).all()
    program("verify", tmp_path / "row", tmp_path / "row" / "demonstration.plan.json")


def test_samples_are_steps_along_paths(folder: Path) -> None:
    rows = dataset.load(folder / "set")
    samples = rows.samples()
    assert samples.observations.shape[1] == 9 + 8 and samples.actions.shape == (len(samples), 9)
    batches = list(samples.batches(7, seed=1))
    assert sum(len(observations) for observations, _ in batches) == len(samples)
    path = rows.path(int(samples.rows[0]))
    assert np.allclose(samples.observations[0, :9], path[0], atol=1e-6)
    assert np.allclose(samples.actions[0], path[1] - path[0], atol=1e-6)
    with pytest.raises(ValueError, match="no solved row of the task"):
        rows.samples("fetch")


def test_pictures_are_those_of_the_command_sense(folder: Path, tmp_path: Path) -> None:
    image = package("PIL.Image")
    rows = dataset.load(folder / "set")
    # The first query of a scene begins at the robot's own start, where the pictures are taken.
    place = next(int(place) for place in rows.solved if place % 5 == 0)
    program("dataset", "extract", folder / "set", place, "-o", tmp_path / "row")
    program("sense", tmp_path / "row", "--default-cameras", 2, "-o", tmp_path / "views")
    pictures = rows.pictures(place)
    assert [picture.camera for picture in pictures] == ["camera1", "camera2"]
    for picture in pictures:
        depth_mm = np.asarray(image.open(tmp_path / "views" / f"{picture.camera}.depth.png")).astype(float)
        segments = np.asarray(image.open(tmp_path / "views" / f"{picture.camera}.segments.png"))
        assert picture.depth_m.shape == picture.segments.shape == (240, 320)
        # Text rounds the scene, so that a pixel at an edge may show something else.
        apart = np.abs(np.nan_to_num(1e3 * picture.depth_m) - depth_mm)
        assert (apart <= 1.001).mean() > 0.9999 and (picture.segments == segments).mean() > 0.9999
        scene = rows.scene(place)
        target = picture.names.index(cranny.Scenario(str(tmp_path / "row")).target.name) + 1
        assert picture.names[-1] == "robot" and len(picture.intrinsics_px) == 4
        # A seen point of the target is near its pose.
        v, u = np.argwhere(picture.segments == target)[0]
        focal, center, depth_m = picture.intrinsics_px[:2], picture.intrinsics_px[2:], picture.depth_m[v, u]
        ray = np.append((np.array([u, v]) - center) / focal * depth_m, depth_m)
        w, x, y, z = picture.pose[3:]
        turned = ray + 2 * np.cross([x, y, z], np.cross([x, y, z], ray) + w * ray)
        assert np.linalg.norm(turned + picture.pose[:3] - scene["target_pose"][:3]) < 0.3


def test_batches_for_torch_are_the_samples(folder: Path) -> None:
    pytest.importorskip("torch")
    from torch.utils.data import DataLoader

    rows = dataset.load(folder / "set")
    samples, of_torch = rows.samples(), rows.torch()
    assert len(of_torch) == len(samples)
    in_order = list(DataLoader(of_torch, batch_size=7))
    assert np.array_equal(np.vstack([batch[0] for batch in in_order]), samples.observations)
    for loader in (of_torch.loader(7, shuffle=False), of_torch.loader(7, seed=3)):
        found = np.vstack([np.hstack(batch) for batch in loader])
        wanted = np.hstack([samples.observations, samples.actions])
        assert np.array_equal(np.unique(found, axis=0), np.unique(wanted, axis=0)) and len(found) == len(wanted)


def test_the_export_has_the_layout_of_lerobot(folder: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    info = json.loads((folder / "lerobot/meta/info.json").read_text(encoding="utf-8"))
    frames = parquet.read_table(folder / "lerobot/data/chunk-000/file-000.parquet").to_pandas()
    episodes = parquet.read_table(folder / "lerobot/meta/episodes/chunk-000/file-000.parquet").to_pandas()
    tasks = parquet.read_table(folder / "lerobot/meta/tasks.parquet").to_pandas()
    assert info["total_frames"] == len(frames) and info["total_episodes"] == len(episodes)
    assert list(frames["index"]) == list(range(len(frames)))
    assert tasks.index.name == "task" and tasks.loc[episodes["tasks"][0][0], "task_index"] == frames["task_index"][0]
    state, action = (np.stack(frames[name]) for name in ("observation.state", "action"))
    assert state.shape == action.shape == (len(frames), 10)
    same = frames["episode_index"].to_numpy()[1:] == frames["episode_index"].to_numpy()[:-1]
    assert (action[:-1][same] == state[1:][same]).all()
    statistics = json.loads((folder / "lerobot/meta/stats.json").read_text(encoding="utf-8"))["action"]
    assert np.allclose(statistics["mean"], action.mean(axis=0), atol=1e-5)
    assert np.allclose(statistics["std"], action.std(axis=0), atol=1e-5)
    assert np.allclose(statistics["max"], action.max(axis=0)) and statistics["count"] == [len(frames)]
    rows = dataset.load(folder / "set")
    # The frames pass through the last way point of each path.
    last = state[episodes["dataset_to_index"].to_numpy() - 1, :9]
    ends = np.stack([rows.path(int(row))[-1] for row in episodes["cranny/row"]])
    assert np.allclose(last, ends, atol=1e-5)


def test_robomimic_gets_one_file(folder: Path, tmp_path: Path) -> None:
    h5py = package("h5py")
    count = dataset.to_robomimic(folder / "lerobot", tmp_path / "set.hdf5")
    with h5py.File(tmp_path / "set.hdf5") as file:
        assert len(file["data"]) == count and len(file["mask/train"]) + len(file["mask/valid"]) == count
        demonstration = file["data/demo_0"]
        assert demonstration["actions"].shape == (demonstration.attrs["num_samples"], 10)
        scale = file["data"].attrs["action_scale"]
        steps = demonstration["next_obs/state"][:] - demonstration["obs/state"][:]
        assert np.allclose(demonstration["actions"][:] * scale, steps, atol=1e-5)
        assert np.abs(demonstration["actions"][:]).max() <= 1.0


def test_another_folder_is_refused(tmp_path: Path) -> None:
    package("pyarrow")
    with pytest.raises(ValueError, match="no data set"):
        dataset.load(tmp_path)
