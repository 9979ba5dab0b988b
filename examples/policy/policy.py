"""A small motion policy in NumPy: from a start, a goal and a scene to way points between them.

The network proposes several paths for each problem, as displacements from the straight line. It is a plain perceptron, trained
by Adam so that the best of its proposals is near the demonstration ("winner takes all"): the way around an obstacle is often
on either side, and the mean of both is in it.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float32]

POINTS = 5
"""Way points between start and goal."""
PROPOSALS = 6
"""Paths that the network proposes."""
HIDDEN = (256, 256, 256)
RELAXED = 0.05
"""Share of the loss that goes to the proposals that are not the best, so that none of them is never trained."""


def along(path: NDArray[np.float64], shares: NDArray[np.float64]) -> NDArray[np.float64]:
    """Configurations at shares of the length of a path (N, dof)."""
    at = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    at /= max(at[-1], 1e-12)
    return np.stack([np.interp(shares, at, joint) for joint in path.T], axis=1)


def displacements(path: NDArray[np.float64]) -> NDArray[np.float64]:
    """Displacements (POINTS, dof) of a path from the straight line between its ends."""
    shares = np.linspace(0.0, 1.0, POINTS + 2)[1:-1]
    return along(path, shares) - along(path[[0, -1]], shares)


def paths(starts: NDArray[Any], goals: NDArray[Any], moved: Floats) -> NDArray[np.float64]:
    """Paths (N, PROPOSALS, POINTS + 2, dof) from displacements (N, PROPOSALS, POINTS, dof)."""
    shares = np.linspace(0.0, 1.0, POINTS + 2)[:, None]
    straight = starts[:, None].astype(float) * (1.0 - shares) + goals[:, None].astype(float) * shares
    whole = np.repeat(straight[:, None], moved.shape[1], axis=1)
    whole[:, :, 1:-1] += moved
    return whole


def scene_features(boxes: NDArray[Any], target: NDArray[Any]) -> Floats:
    """Features of a scene: sides and middle of each box (N, 6), pose of the target (4, 4); all in the planning frame."""
    return np.concatenate([np.ravel(boxes), target[:3, 3], target[:3, 0], target[:3, 1]]).astype(np.float32)


class Policy:
    """Network with the scale of its inputs and outputs."""

    def __init__(self, weights: list[Floats], scale: dict[str, Floats]) -> None:
        self.weights, self.scale = weights, scale

    @classmethod
    def new(cls, inputs: Floats, outputs: Floats, seed: int) -> Policy:
        """Untrained policy for inputs (N, in) and outputs (N, POINTS, dof)."""
        random = np.random.default_rng(seed)
        sizes = [inputs.shape[1], *HIDDEN, PROPOSALS * outputs[0].size]
        weights: list[Floats] = []
        for a, b in zip(sizes[:-1], sizes[1:], strict=True):
            weights += [random.normal(0.0, np.sqrt(2.0 / a), (a, b)).astype(np.float32), np.zeros(b, np.float32)]
        # Different proposals from the beginning.
        weights[-1] = random.normal(0.0, 0.3, sizes[-1]).astype(np.float32)
        deviation = inputs.std(axis=0)
        scale = {
            "mean": inputs.mean(axis=0),
            # What is the same in all scenes has no effect.
            "gain": np.where(deviation > 1e-6, 1.0 / np.maximum(deviation, 1e-6), 0.0).astype(np.float32),
            "unit": outputs.std(axis=(0, 1)) + np.float32(1e-3),
        }
        return cls(weights, scale)

    @classmethod
    def load(cls, file: str | Path) -> Policy:
        """Reads a policy."""
        with np.load(file) as stored:
            count = sum(name.startswith("w") for name in stored.files)
            scale = {name: stored[name] for name in ("mean", "gain", "unit")}
            return cls([stored[f"w{index}"] for index in range(count)], scale)

    def save(self, file: str | Path) -> None:
        """Writes the policy."""
        weights = {f"w{index}": weight for index, weight in enumerate(self.weights)}
        np.savez(file, **weights, **self.scale)

    def layers(self, inputs: Floats) -> list[Floats]:
        """Values of all layers, the output last."""
        values = [(inputs - self.scale["mean"]) * self.scale["gain"]]
        for index in range(0, len(self.weights), 2):
            value = values[-1] @ self.weights[index] + self.weights[index + 1]
            values.append(np.maximum(value, 0.0) if index + 2 < len(self.weights) else value)
        return values

    def propose(self, inputs: Floats) -> Floats:
        """Displacements (N, PROPOSALS, POINTS, dof)."""
        out = self.layers(inputs)[-1]
        return np.asarray(out.reshape(len(inputs), PROPOSALS, POINTS, -1) * self.scale["unit"])

    def gradient(self, inputs: Floats, outputs: Floats) -> tuple[float, list[Floats]]:
        """Loss of a batch and its gradient by all weights."""
        values = self.layers(inputs)
        wanted = (outputs / self.scale["unit"]).reshape(len(inputs), 1, -1)
        error = values[-1].reshape(len(inputs), PROPOSALS, -1) - wanted
        losses = (error**2).mean(axis=2)
        share = np.full(losses.shape, RELAXED / (PROPOSALS - 1), np.float32)
        share[np.arange(len(inputs)), losses.argmin(axis=1)] = 1.0 - RELAXED
        loss = float((share * losses).sum(axis=1).mean())
        slope = (2.0 / error.shape[2] / len(inputs) * share[:, :, None] * error).reshape(len(inputs), -1)
        slopes: list[Floats] = []
        for index in range(len(self.weights) - 2, -1, -2):
            before = values[index // 2]
            slopes += [slope.sum(axis=0), before.T @ slope]
            slope = (slope @ self.weights[index].T) * (before > 0.0)
        return loss, slopes[::-1]

    def train(self, inputs: Floats, outputs: Floats, epochs: int, seed: int, batch: int = 512) -> Iterator[float]:
        """Trains by Adam (Kingma & Ba 2015, algorithm 1) with a falling rate; the mean loss of each epoch."""
        random = np.random.default_rng(seed)
        first, second = ([np.zeros_like(weight) for weight in self.weights] for _ in range(2))
        steps, done = epochs * -(-len(inputs) // batch), 0
        for _ in range(epochs):
            order, losses = random.permutation(len(inputs)), []
            for begin in range(0, len(order), batch):
                chosen = order[begin : begin + batch]
                loss, slopes = self.gradient(inputs[chosen], outputs[chosen])
                losses.append(loss)
                rate = 1e-3 * 0.5 * (1.0 + np.cos(np.pi * done / steps))
                done += 1
                for weight, slope, one, two in zip(self.weights, slopes, first, second, strict=True):
                    one += 0.1 * (slope - one)
                    two += 0.001 * (slope**2 - two)
                    mean, square = one / (1.0 - 0.9**done), two / (1.0 - 0.999**done)
                    weight -= (rate * mean / (np.sqrt(square) + 1e-8)).astype(np.float32)
            yield float(np.mean(losses))
