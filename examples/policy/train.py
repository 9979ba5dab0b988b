"""Trains the policy on a set of demonstrations: `python train.py demonstrations -o policy.npz`."""

from __future__ import annotations

import argparse
import time

import numpy as np
from policy import Floats, Policy, displacements, scene_features

from cranny import dataset

HELD_OUT = 10
"""Every tenth scene is not trained on."""


def pose(numbers: list[float]) -> Floats:
    """Pose (4, 4) from position and unit quaternion (w, x, y, z)."""
    *position, w, x, y, z = numbers
    matrix = np.eye(4)
    matrix[:3, 3] = position
    matrix[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.asarray(matrix, dtype=np.float32)


def examples(rows: dataset.Dataset) -> tuple[Floats, Floats, Floats]:
    """Inputs (N, in), displacements (N, POINTS, dof) and numbers of the scenes (N,) of all reaches with a path."""
    scenes = rows.scenes.to_pylist()
    known = {
        scene["scene"]: scene_features(np.reshape(scene["boxes"], (-1, 10))[:, :6], pose(scene["target_pose"]))
        for scene in scenes
        if scene["target_pose"]
    }
    tasks, numbers = rows.table["task"].to_pylist(), rows.table["scene"].to_pylist()
    inputs, outputs, of_scene = [], [], []
    for place in map(int, rows.solved):
        if tasks[place] == "reach":
            path = rows.path(place)
            inputs.append(np.concatenate([path[0], path[-1], known[numbers[place]]]))
            outputs.append(displacements(path))
            of_scene.append(numbers[place])
    return np.asarray(inputs, np.float32), np.asarray(outputs, np.float32), np.asarray(of_scene)


def main() -> None:
    """Trains and prints the losses."""
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("demonstrations", help="folder of the set")
    words.add_argument("-o", "--output", default="policy.npz", help="file of the policy")
    words.add_argument("--epochs", type=int, default=120)
    words.add_argument("--seed", type=int, default=0)
    given = words.parse_args()
    begin = time.monotonic()
    inputs, outputs, scenes = examples(dataset.load(given.demonstrations))
    held_out = scenes % HELD_OUT == HELD_OUT - 1
    print(f"{len(inputs)} demonstrations in {len(set(scenes))} scenes, {held_out.sum()} of them held out; {inputs.shape[1]} inputs")
    policy = Policy.new(inputs[~held_out], outputs[~held_out], given.seed)
    for epoch, loss in enumerate(policy.train(inputs[~held_out], outputs[~held_out], given.epochs, given.seed)):
        if epoch % 10 == 9 or epoch == given.epochs - 1:
            left, _ = policy.gradient(inputs[held_out], outputs[held_out])
            print(f"epoch {epoch + 1:4}: loss {loss:.4f}, {left:.4f} held out; {time.monotonic() - begin:.0f} s", flush=True)
    policy.save(given.output)


if __name__ == "__main__":
    main()
