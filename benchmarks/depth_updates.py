"""Times `cranny.World` with new images: `python benchmarks/depth_updates.py ID FOLDER`.

FOLDER is that of `cranny sense ID --default-cameras 4 --noise-seed 1 -o FOLDER`. What is known of the scenario is its robot, start,
target, grasps and floor. For one and for four of the images: the median and 95 % of `World.update` (arrays to obstacles), of
the first check after it (which builds the cell), of a check of 1000 configurations, and the median of one plan with its proof.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

import cranny
import numpy as np

RUNS = 20


def milliseconds(work: Callable[[], object]) -> float:
    """Time of a call."""
    begin = time.perf_counter()
    work()
    return 1e3 * (time.perf_counter() - begin)


def main() -> None:
    """Prints one line for each number of images."""
    known, views = cranny.Scenario(sys.argv[1]), cranny.DepthView.load(sys.argv[2])
    target = known.target
    for body in known.world:
        if body.kinds != ["floor"] and (target is None or body.name != target.name):
            known = known.without_body(body.name)
    q = known.robot.sample(1000, seed=1)
    for count in (1, 4):
        some = views[:count]
        images, poses = [view.depths for view in some], [view.pose for view in some]
        world = cranny.World(known, views=some)
        given = ([view.intrinsics for view in some], poses)
        updates, first, checks = [], [], []
        for _ in range(RUNS):
            updates.append(milliseconds(lambda: world.update(images, *given)))
            first.append(milliseconds(lambda: world.is_free(known.start)))
            checks.append(milliseconds(lambda: world.is_free(q)))
        outcomes: list[str] = []
        plan = milliseconds(lambda: outcomes.append(world.plan(time_limit_s=5.0).outcome))
        of = lambda times: f"{np.median(times):.1f} ({np.quantile(times, 0.95):.1f})"  # noqa: E731
        print(
            f"{count} images of {some[0].shape[1]} × {some[0].shape[0]}: update {of(updates)} ms, {1e3 / np.median(updates):.1f} Hz; "
            f"first check {of(first)} ms; 1000 checks {of(checks)} ms; a plan {plan:.0f} ms ({outcomes[0]})"
        )


if __name__ == "__main__":
    main()
