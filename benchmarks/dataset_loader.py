"""Samples a second of a set of demonstrations through PyTorch's `DataLoader`, in batches of 1024:
`dataset_loader.py SET [SECONDS]`. Needs the package `cranny` with pyarrow, and torch."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterable
from typing import Any

import torch
from torch.utils.data import DataLoader, TensorDataset

from cranny import dataset

BATCH = 1024


def rate(make: Callable[[], Iterable[Any]], seconds: float) -> tuple[float, float]:
    """Samples a second over whole epochs, and samples for a second of this process's processor time, which other programs do not
    affect; the start of workers in the first epoch does not count."""
    loader = make()
    for _ in loader:
        pass
    count, begin, spent = 0, time.monotonic(), time.process_time()
    while time.monotonic() - begin < seconds:
        for observations, _ in loader:
            count += len(observations)
    return count / (time.monotonic() - begin), count / max(1e-9, time.process_time() - spent)


def main(folder: str, seconds: float) -> None:
    """Prints the rates."""
    begin = time.monotonic()
    rows = dataset.load(folder)
    samples = rows.torch()
    print(f"{len(rows)} rows, {len(samples)} samples, opened in {time.monotonic() - begin:.1f} s; torch {torch.__version__}")
    plain = TensorDataset(samples.observations, samples.actions)
    for workers in (0, 2):
        kept = {"num_workers": workers, "persistent_workers": workers > 0, "batch_size": BATCH, "shuffle": True}
        for name, make in (
            ("item by item (TensorDataset)", lambda kept=kept: DataLoader(plain, **kept)),
            ("DataLoader(rows.torch())", lambda kept=kept: DataLoader(samples, **kept)),
            ("rows.torch().loader()", lambda workers=workers: samples.loader(BATCH, workers=workers)),
        ):
            wall, own = rate(make, seconds)
            print(f"{workers} workers, {name:30} {wall:12,.0f} samples a second; {own:12,.0f} for a second of the main process", flush=True)


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]) if len(sys.argv) > 2 else 3.0)
