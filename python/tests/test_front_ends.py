"""Command line and package produce the same plan file for the same request."""

from __future__ import annotations

import os
import re
import subprocess
from itertools import product
from pathlib import Path
from typing import Any

import cranny
import pytest
from conftest import lacking, released_folder

Request = tuple[list[str], dict[str, Any]]

SCENARIOS: list[Request] = [
    (["021"], {}),
    (["012", "--criterion", "paper"], {"criterion": "paper"}),
]
SEARCHES: list[Request] = [
    ([], {}),
    (["--planner", "ik-rrt", "--seed", "3", "--iterations", "3000"], {"planner": "ik-rrt", "seed": 3, "iterations": 3000}),
    (["--iterations", "1", "--seed", "7"], {"iterations": 1, "seed": 7}),
]
EXACT: list[Request] = [
    ([], {}),
    (["--margin", "2", "--grasp-margin", "0.5"], {"margin_m": 0.002, "grasp_margin_m": 0.0005}),
    (["--no-shortcut"], {"shortcut": False}),
    (["--strict-pairs"], {"strict_pairs": True}),
    (["--jerk-limited"], {"jerk_limited": True}),
    (["--timing", "time-optimal"], {"jerk_limited": False}),
    (["--stop-at-corners"], {"blend": False}),
    (["--speed", "0.5", "--speed", "reach=0.25", "--acceleration", "0.5"],
     {"speed": {"all": 0.5, "reach": 0.25}, "acceleration": 0.5}),
    (["--carry", "home", "--upright", "10", "--tool-speed", "0.3", "--iterations", "4000"],
     {"carry": "home", "upright_deg": 10.0, "tool_speed_m_s": 0.3, "iterations": 4000}),
    (["--carry", "home", "--iterations", "4000"], {"carry": "home", "iterations": 4000}),
    (["--place", "outside", "--then", "stay", "--clear", "30", "--iterations", "4000"],
     {"place": "outside", "then": "stay", "clear_m": 0.03, "iterations": 4000}),
    (["--robust", "1,0"], {"robust": (0.001, 0.0)}),
    (["--optimise", "60", "--iterations", "400"], {"optimise_s": 60.0, "iterations": 400}),
    (["--optimise", "60", "--iterations", "40", "--score-weight", "0"],
     {"optimise_s": 60.0, "iterations": 40, "score_weight": 0.0}),
    (["--optimise", "60", "--iterations", "40", "--cost", "time"],
     {"optimise_s": 60.0, "iterations": 40, "cost": "time"}),
]
PAPER: list[Request] = [
    ([], {}),
    (["--goal-threshold", "20"], {"goal_threshold": 20.0}),
]


def program() -> str:
    """Path of the program."""
    named = os.environ.get("CRANNY_BIN")
    if not named:
        lacking("CRANNY_BIN does not name the cranny command")
    return str(named)


def without_times(path: Path) -> str:
    """A plan file without measured times."""
    return re.sub(r'("(?:\w+_)?time_s": )[-+.e\d]+', r"\1-", path.read_text())


def both(folder: Path, task: list[str], scenario: cranny.Scenario, request: Request) -> tuple[str, str]:
    """Plan files of both front ends."""
    flags, keywords = request
    theirs, ours = folder / "cli.plan.json", folder / "python.plan.json"
    command = [program(), "plan", *task, *flags, "--quiet", "--force", "-o", str(theirs)]
    status = subprocess.run(command, cwd=folder, check=False).returncode
    plan = cranny.plan(scenario, **keywords)
    plan.save(ours)
    assert status == (0 if plan else 1), request
    return without_times(theirs), without_times(ours)


@pytest.mark.parametrize("task", SCENARIOS, ids=lambda task: " ".join(task[0]))
def test_both_write_the_same_plan(tmp_path: Path, task: Request) -> None:
    words, keywords = task
    scenario = cranny.Scenario(words[0], **keywords)
    grid = product(SEARCHES, PAPER if keywords else EXACT)
    for (search_flags, search_keywords), (flags, options) in grid:
        twice = "--iterations" in flags and "--iterations" in search_flags
        if twice or search_flags[:2] == ["--planner", "ik-rrt"] and "--optimise" in flags:
            continue
        request = ([*search_flags, *flags], {**search_keywords, **options})
        theirs, ours = both(tmp_path, words, scenario, request)
        assert theirs == ours, request


def test_both_name_the_robot_and_the_geometry(tmp_path: Path) -> None:
    folder = released_folder()
    scene = folder / "scenarios" / "011"
    urdf = scene.parents[1] / "robots" / "franka_panda" / "mobile_panda.urdf"
    flags = [str(scene), "--robot", str(urdf), "--geometry", "export"]
    scenario = cranny.Scenario(scene, robot=urdf, geometry="export")
    theirs, ours = both(tmp_path, flags, scenario, (["--iterations", "50"], {"iterations": 50}))
    assert theirs == ours and '"geometry": "export"' in ours


@pytest.mark.parametrize(
    ("flags", "keywords"),
    [
        (["--speed", "1.5"], {"speed": 1.5}),
        (["--tool-speed", "carry=nan"], {"tool_speed_m_s": {"carry": float("nan")}}),
        (["--turn-speed", "0"], {"turn_speed_deg_s": 0.0}),
        (["--approach", "60"], {"approach_m": 0.6}),
        (["--retreat", "5"], {"retreat_m": 0.05}),
        (["--criterion", "paper", "--optimise", "1"], {"optimise_s": 1.0}),
        (["--criterion", "paper", "--goal-threshold", "-1"], {"goal_threshold": -1.0}),
        (["--goal-threshold", "3"], {"goal_threshold": 3.0}),
        (["--optimise", "1", "--score-weight", "nan"], {"optimise_s": 1.0, "score_weight": float("nan")}),
        (["--planner", "nobody"], {"planner": "nobody"}),
        (["--score", "physics"], {"score": "physics"}),
    ],
)
def test_both_refuse_with_the_same_words(tmp_path: Path, flags: list[str], keywords: dict[str, Any]) -> None:
    told = subprocess.run([program(), "plan", "021", *flags], cwd=tmp_path, check=False, capture_output=True, text=True)
    assert told.returncode == 2
    criterion = "paper" if "paper" in flags else None
    with pytest.raises(ValueError) as caught:
        cranny.plan(cranny.Scenario("021", criterion=criterion), **keywords)
    said = told.stderr.split(": ")[-1].strip()
    assert str(caught.value).endswith(said), (said, str(caught.value))


KINDS: list[Request] = [
    (["021"], {}),
    (["021", "--carry", "home"], {"carry": "home"}),
    (["021", "--carry", "out"], {"carry": "out"}),
    (["021", "--place", "outside"], {"place": "outside"}),
    (["235", "--task", "steps"], {"task": "steps"}),
]
FLAGS: list[Request] = [
    (["--robust", "0.2,0.1"], {"robust": (0.0002, 0.0017453292519943296)}),
    (["--clear", "20"], {"clear_m": 0.02}),
    (["--margin", "0.01"], {"margin_m": 0.00001}),
    (["--then", "stay"], {"then": "stay"}),
    # With this seed, each of the tasks is solved within the iterations.
    (["--optimise", "60", "--iterations", "400", "--seed", "1"], {"optimise_s": 60.0, "iterations": 400, "seed": 1}),
    (["--optimise", "0.1", "--cost", "time"], {"optimise_s": 0.1, "cost": "time"}),
    (["--stop-at-corners"], {"blend": False}),
    (["--jerk-limited"], {"jerk_limited": True}),
    (["--upright", "30"], {"upright_deg": 30.0}),
    (["--tool-speed", "carry=0.2"], {"tool_speed_m_s": {"carry": 0.2}}),
    (["--turn-speed", "40"], {"turn_speed_deg_s": 40}),
    (["--torque"], {"torque": True}),
    (["--approach", "4"], {"approach_m": 0.04}),
    (["--rate", "50"], {}),
    (["--grasps", "none"], {}),
    (["--score", "physics"], {"score": "physics"}),
    (["--min-score", "0.1"], {"min_score": 0.1}),
    (["--no-shortcut"], {"shortcut": False}),
    (["--strict-pairs"], {"strict_pairs": True}),
]


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: " ".join(kind[0]))
@pytest.mark.parametrize("flag", FLAGS, ids=lambda flag: " ".join(flag[0]))
def test_every_flag_works_with_every_task_or_is_refused_by_one_message(
    tmp_path: Path, kind: Request, flag: Request
) -> None:
    (words, task), (flags, options) = kind, flag
    theirs, ours = tmp_path / "cli.plan.json", tmp_path / "python.plan.json"
    command = [program(), "plan", *words, *flags, "--quiet", "-o", str(theirs)]
    ended = subprocess.run(command, cwd=tmp_path, check=False, capture_output=True, text=True)
    grasps = "none" if flags == ["--grasps", "none"] else None
    scenario = cranny.Scenario(words[0], grasps=grasps)
    if ended.returncode == 2:
        message = ended.stderr.splitlines()[0].removeprefix("error: ").removeprefix("--")
        with pytest.raises(ValueError) as refused:
            cranny.plan(scenario, **task, **options)
        # A keyword has an underscore where a flag has a hyphen.
        assert str(refused.value).replace("_", "-") == message.replace("_", "-")
        return
    plan = cranny.plan(scenario, **task, **options)
    plan.save(ours)
    assert ended.returncode == (0 if plan else 1), ended.stderr
    if "--cost" not in flags:
        assert without_times(theirs) == without_times(ours)
    assert plan.verify()
