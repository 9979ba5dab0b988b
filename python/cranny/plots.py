"""Plots of results with matplotlib."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LABELS = {"time": "time (s)", "iterations": "iterations"}
"""Axis labels of the quantities over which curves are drawn."""


def draw_curves(
    curves: Sequence[dict[str, Any]],
    scenario: str | None = None,
    over: str = "time",
    criterion: str | None = None,
    axes: Axes | None = None,
) -> Axes:
    """Draws the curves of one scenario: a step function with its band for each planner."""
    try:
        import matplotlib.pyplot as plt
    except ImportError as reason:
        raise ImportError("curves are drawn with matplotlib: pip install cranny[plots]") from reason

    if over not in LABELS:
        raise ValueError(f"over is '{over}', but 'time' or 'iterations' is expected")
    chosen = [curve for curve in curves if curve["over"] == over and curve["scenario_name"] is not None]
    known = sorted({str(curve["scenario_name"]) for curve in chosen})
    scenario = scenario or next((str(curve["scenario_name"]) for curve in chosen), None)
    chosen = [curve for curve in chosen if curve["scenario_name"] == scenario]
    criterion = criterion or next((str(curve["criterion"]) for curve in chosen), None)
    chosen = [curve for curve in chosen if curve["criterion"] == criterion]
    if not chosen:
        raise ValueError(f"there are no curves of '{scenario}' under '{criterion}' (scenarios: {', '.join(known)})")
    if axes is None:
        _, axes = plt.subplots()
    for curve in chosen:
        at = [*curve["at"], curve["until"]]
        ends = {key: [*curve[key], curve[key][-1]] if curve[key] else [0.0] for key in ("success", "low", "high")}
        (line,) = axes.step(at, ends["success"], where="post", label=curve["planner_name"])
        axes.fill_between(at, ends["low"], ends["high"], step="post", color=line.get_color(), alpha=0.15, linewidth=0)
    axes.set(xlabel=LABELS[over], ylabel="share of runs solved", ylim=(0.0, 1.02), title=f"{scenario} ({criterion})")
    axes.set_xscale("log")
    axes.legend(loc="lower right", frameon=False)
    return axes
