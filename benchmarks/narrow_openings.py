"""Openings of a gap and of a gate that are just wide enough for the base, and proven too narrow.

    python3 benchmarks/narrow_openings.py target/release/cranny

Plans in openings around the width of the mobile platform, 400 mm. The gap's box stands 0.55 m farther behind the walls than in the
paper, and only the width of the gate changes, so that the base must pass both. Prints a table with the outcome of each.
"""

import json
import pathlib
import re
import subprocess
import sys
import tempfile

WIDTHS_MM = [390, 395, 400, 405, 410, 420, 440]
DEEPER_M = 0.55
TIME_LIMIT_S = 10


def run(*words: object) -> None:
    subprocess.run([str(word) for word in words], check=False, capture_output=True)


def deepen(scene: pathlib.Path) -> None:
    """Moves target and grasps away from the robot, along y of the scene and x of the robot's root."""
    file = scene / "scenario.yaml"
    text = file.read_text()
    target = re.search(r"target:.*?pose: \{position: \[([^\]]*)\]", text, re.S)
    x, y, z = (float(value) for value in target[1].split(","))
    file.write_text(text[: target.start(1)] + f"{x}, {y + DEEPER_M}, {z}" + text[target.end(1) :])
    grasps = scene / "grasps.csv"
    head, *rows = (line.split(",") for line in grasps.read_text().splitlines())
    for row in rows:
        row[3] = repr(float(row[3]) + DEEPER_M)
    grasps.write_text("\n".join(",".join(row) for row in [head, *rows]) + "\n")


def narrow(scene: pathlib.Path, width_m: float) -> None:
    """Moves the posts of a gate that is 860 mm wide and high."""
    file = scene / "scenario.yaml"
    post = (2 - width_m) / 2
    text = file.read_text().replace("size: [0.57, 0.1, 0.86]", f"size: [{post}, 0.1, 0.86]")
    text = text.replace("position: [0.285, 0.05", f"position: [{post / 2}, 0.05")
    file.write_text(text.replace("position: [1.715, 0.05", f"position: [{2 - post / 2}, 0.05"))


def main(program: str) -> None:
    folder = pathlib.Path(tempfile.mkdtemp())
    print("| opening | mm | outcome | time, s | squares | every goal beyond reach by, mm |\n|---|---|---|---|---|---|")
    for family in ["gap", "gate"]:
        for width_mm in WIDTHS_MM:
            width_m = width_mm / 1000
            # The sweep needs two ends, of which only the first is used.
            first, last = (0.86, 0.85) if family == "gate" else (width_m, width_m - 0.01)
            sweep = folder / f"{family}-{width_mm}"
            run(program, "scenario", "sweep", family, "--from", first, "--to", last, "--steps", 2, "-o", sweep, "-q")
            scene = sweep / f"{family}-{first:.4f}"
            narrow(scene, width_m) if family == "gate" else deepen(scene)
            plan_file = folder / "plan.json"
            run(program, "plan", scene, "-o", plan_file, "--time-limit", TIME_LIMIT_S, "-q")
            plan = json.loads(plan_file.read_text())
            no_grasp = plan.get("no_grasp") or {}
            proof = [no_grasp.get("squares", "–"), f"{no_grasp['beyond_m'] * 1e3:.1f}" if "beyond_m" in no_grasp else "–"]
            time_s = f"{plan['statistics']['planning_time_s']:.3g}"
            print("|", " | ".join(str(cell) for cell in [family, width_mm, plan["outcome"], time_s, *proof]), "|")


main(sys.argv[1])
