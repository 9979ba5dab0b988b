"""What physics makes of plans that put their target down, and how many grasps survive reach, carry and place.

`python benchmarks/placing.py simulate CRANNY SEEDS [TASK…]` plans each place task and each insertion (or those named) with margins of 5 and 1 mm and
executes it (`simulate plan`); `python benchmarks/placing.py plot TABLE.md…` draws the tables of `carrying grasps` as
placing.svg beside this file (needs matplotlib)."""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

OUTSIDE = [f"0{family}{level}" for family in range(1, 5) for level in range(1, 6)]
INSIDE = [f"1{family}{level}" for family in range(1, 5) for level in (1, 3, 5)]


def call(cranny: str, *arguments: str) -> dict:
    """What a command answers."""
    run = subprocess.run([cranny, *arguments, "--json"], capture_output=True, text=True, check=False)
    return json.loads(run.stdout) if run.stdout else {"error": run.stderr.strip()}


def simulate(cranny: str, seeds: int, tasks: list[str]) -> None:
    """A row a task: how many plans end with the target held until it is put down, and standing where it was to be."""
    print("| task | planned | held all the way | stands within 10 mm, 10° | worst of those, mm | ° |")
    print("|---|---|---|---|---|---|")
    for scenario in tasks or OUTSIDE + INSIDE:
        place = "outside" if scenario in OUTSIDE else "inside"
        planned = held = there = 0
        worst = [0.0, 0.0]
        for seed in range(seeds):
            with tempfile.TemporaryDirectory() as folder:
                file = str(Path(folder) / "x.plan.json")
                margins = ["--margin", "5", "--grasp-margin", "1"]
                plan = call(cranny, "plan", scenario, "--place", place, *margins, "--seed", str(seed),
                            "--time-limit", "20", "-o", file)
                if plan.get("outcome") != "solved":
                    continue
                planned += 1
                run = call(cranny, "simulate", "plan", scenario, file)
                held += run.get("outcome") == "held"
                placed = run.get("placed")
                if run.get("outcome") == "held" and placed:
                    off_mm, off_deg = placed["translation_m"] * 1e3, placed["rotation_rad"] * 57.29578
                    if off_mm <= 10 and off_deg <= 10:
                        there += 1
                        worst = [max(worst[0], off_mm), max(worst[1], off_deg)]
        print(f"| {scenario} | {planned} of {seeds} | {held} | {there} | {worst[0]:.1f} | {worst[1]:.1f} |", flush=True)


def plot(tables: list[str]) -> None:
    """Bars of the grasps that are left after each stage."""
    import matplotlib.pyplot as plt

    rows = []
    for table in tables:
        lines = Path(table).read_text().splitlines()
        rows += [[cell.strip() for cell in line.split("|")[1:6]] for line in lines if line[:3] in ("| 0", "| 1")]
    figure, axes = plt.subplots(figsize=(11, 3.6))
    stages = [("reached", "#9ecae9"), ("carried home", "#4c8ac9"), ("put down", "#17406d")]
    for index, (stage, colour) in enumerate(stages):
        places = [place + 0.27 * (index - 1) for place in range(len(rows))]
        axes.bar(places, [int(row[2 + index]) for row in rows], width=0.26, color=colour, label=stage)
    axes.set_xticks(range(len(rows)), [row[0] for row in rows], rotation=90)
    axes.set_ylabel("grasps")
    axes.legend(frameon=False, ncols=3)
    axes.spines[["top", "right"]].set_visible(False)
    figure.tight_layout()
    figure.savefig(Path(__file__).with_suffix(".svg"))


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["simulate", cranny, seeds, *tasks]:
            simulate(cranny, int(seeds), tasks)
        case ["plot", *tables] if tables:
            plot(tables)
        case _:
            sys.exit(__doc__)
