"""What a notebook shows."""

from __future__ import annotations

from pathlib import Path

import cranny
import pytest

PNG = b"\x89PNG\r\n\x1a\n"


def test_a_scenario_and_a_plan_have_pictures(
    scenario: cranny.Scenario, plan: cranny.Plan, tmp_path: Path
) -> None:
    view = scenario.show(plan, view="side", width=160, height=120)
    assert view.png().startswith(PNG) and view._repr_png_() == view.png()
    moving = view.apng(rate=2)
    assert moving.startswith(PNG) and b"acTL" in moving
    shown = view.html()
    assert shown.startswith(("<iframe", "<img")) and 'width="160"' in shown
    view.save(tmp_path / "a.png")
    assert (tmp_path / "a.png").read_bytes() == view.png()
    for path, message in ((tmp_path / "a.bmp", "bmp"), (tmp_path / "a.jpg", "jpg")):
        with pytest.raises(ValueError, match=message):
            view.save(path)
    with pytest.raises(ValueError, match="no plan"):
        scenario.show().apng()
    with pytest.raises(ValueError, match="no view"):
        scenario.show(view="below").png()
    with pytest.raises(ValueError, match="8192"):
        scenario.show(width=100_000).png()


def test_the_object_of_a_plan_that_carries_it_home_is_seen_in_the_hand(scenario: cranny.Scenario) -> None:
    plan = cranny.plan(scenario, carry="home")
    show = {"width": 160, "height": 120}
    assert plan.times is not None and plan.path[0].tolist() == plan.path[-1].tolist()
    carried, standing = scenario.show(plan, **show), scenario.show(**show)
    assert carried.png() != standing.png()
    assert carried.html().startswith(("<iframe", "<img"))
