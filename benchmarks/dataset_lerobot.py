"""An export of a set of demonstrations, opened by LeRobot itself: `dataset_lerobot.py EXPORT SET`. Needs the packages
`lerobot[dataset]` and pyarrow, but not `cranny`.

All frames are read through its `LeRobotDataset` and PyTorch's `DataLoader`, and compared with the way points of the set: each
episode begins and ends where its row does. Exits with 1 if a figure differs.
"""

from __future__ import annotations

import os
import sys
import time
from importlib.metadata import version
from pathlib import Path

# Nothing is to be fetched.
os.environ["HF_HUB_OFFLINE"] = "1"
os.environ["HF_DATASETS_OFFLINE"] = "1"

import numpy as np  # noqa: E402
import pyarrow.parquet  # noqa: E402
import torch  # noqa: E402
from lerobot.datasets.lerobot_dataset import LeRobotDataset  # noqa: E402


def main(export: Path, folder: Path) -> bool:
    """Reads everything and prints the figures; returns whether they agree."""
    begin = time.monotonic()
    opened = LeRobotDataset("cranny/demonstrations", root=export)
    print(f"lerobot {version('lerobot')}, torch {torch.__version__}, datasets {version('datasets')}")
    print(f"opened in {time.monotonic() - begin:.1f} s: {opened.num_episodes} episodes, {opened.num_frames} frames, {opened.fps} Hz")
    print("features:", ", ".join(f"{name} {tuple(feature['shape'])}" for name, feature in opened.features.items()))
    rows = {row["row"]: row for row in pyarrow.parquet.read_table(folder / "demonstrations").to_pylist()}
    solved = [row for _, row in sorted(rows.items()) if row["outcome"] == "solved"]
    begin, frames, words = time.monotonic(), 0, set()
    ends: dict[int, list[np.ndarray]] = {}
    for batch in torch.utils.data.DataLoader(opened, batch_size=256):
        words.update(batch["task"])
        for episode, state in zip(batch["episode_index"].tolist(), batch["observation.state"].numpy(), strict=True):
            ends.setdefault(episode, [state, state])[1] = state
        frames += len(batch["index"])
    seconds = time.monotonic() - begin
    print(f"{frames} frames in {seconds:.1f} s, {frames / seconds:.0f} a second; tasks: {sorted(words)}")
    apart = []
    for episode, row in enumerate(solved):
        dof = len(row["start"])
        path = np.reshape(row["waypoints"], (-1, dof))
        first, last = ends[episode]
        apart += [np.abs(first[:dof] - path[0]).max(), np.abs(last[:dof] - path[-1]).max()]
    print(f"ends of {len(ends)} episodes differ from those of the rows by {max(apart):.1e} at most (m, rad)")
    window = LeRobotDataset("cranny/demonstrations", root=export, delta_timestamps={"action": [k / opened.fps for k in range(8)]})
    print(f"a window of 8 actions: {tuple(window[0]['action'].shape)}")
    return len(ends) == len(solved) and frames == opened.num_frames and max(apart) < 1e-5


if __name__ == "__main__":
    sys.exit(0 if main(Path(sys.argv[1]), Path(sys.argv[2])) else 1)
