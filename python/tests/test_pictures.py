"""Display in notebooks."""

from __future__ import annotations

import json
import threading
import urllib.request
from pathlib import Path
from typing import Any

import cranny
import numpy as np
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
    with pytest.raises(ValueError, match="unknown view"):
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


def _asked(url: str) -> Any:
    with urllib.request.urlopen(url, timeout=30) as answer:
        return json.load(answer)


def test_a_live_page_hears_postures_and_plans_as_they_come(scenario: cranny.Scenario) -> None:
    plan = cranny.plan(scenario)
    with cranny.show(scenario, live=True, open_browser=False) as page:
        first = _asked(f"{page.url}page.json")
        assert (first["name"], first["plans"], first["feed"], first["is_live"]) == (scenario.id, [], 0, True)
        page.pose(plan.path[1])
        news = _asked(f"{page.url}news?after=0")
        assert (news["changes"], news["page"]) == (1, 0)
        np.testing.assert_array_equal(news["q"], plan.path[1])
        threading.Timer(0.3, lambda: page.plan(plan)).start()
        news = _asked(f"{page.url}news?after=1")
        assert (news["changes"], news["page"], news["q"]) == (2, 1, None)
        second = _asked(f"{page.url}page.json")
        assert len(second["plans"]) == 1 and second["feed"] == 1
        with pytest.raises(ValueError, match="q"):
            page.pose([0.0])
    with pytest.raises(ValueError, match="closed"):
        page.pose(None)
    page.close()
    with pytest.raises(OSError):
        _asked(f"{page.url}page.json")


def test_a_search_is_watched_while_it_runs(scenario: cranny.Scenario) -> None:
    seen: list[int] = []
    with cranny.show(scenario, live=True, open_browser=False) as page:

        def look() -> None:
            after = 0
            while True:
                news = _asked(f"{page.url}news?after={after}")
                if news["page"] == 1:
                    return
                after = news["changes"]
                if news["tree"]:
                    seen.append(news["tree"]["nodes"])

        browser = threading.Thread(target=look)
        browser.start()
        plan = cranny.plan(scenario, "rrt", iterations=20_000, watch=page)
        browser.join()
        assert seen == sorted(seen) and seen[-1] > 0
        (shown,) = _asked(f"{page.url}page.json")["plans"]
        assert shown["outcome"] and shown["search_tree"]["parents"]
        assert cranny.plan(scenario, "rrt", iterations=20_000).path.tobytes() == plan.path.tobytes()
        other = cranny.Scenario.of(cranny.Robot.builtin("ur5e"), [], name="other")
        with pytest.raises(ValueError, match="other joints"):
            cranny.plan(other.with_goals(other.robot.sample(1)), watch=page)
    with pytest.raises(ValueError, match="closed"):
        cranny.plan(scenario, watch=page)


def test_a_scenario_that_is_shown_is_a_view(scenario: cranny.Scenario) -> None:
    assert isinstance(cranny.show(scenario), cranny.View)
