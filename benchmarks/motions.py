"""Durations of smooth trajectories relative to those with stops, and the search for upright motions: `motions.py
smooth|upright|cups|bottles|straight SEEDS`, with the command in `target/release`."""

import json
import statistics
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

COMMAND = Path(__file__).resolve().parents[1] / "target/release/cranny"
SCENARIOS_OF_OURS = Path(__file__).resolve().parents[1] / "crates/scenario/scenarios"
TASKS = Path(__file__).resolve().parents[1] / "examples/tasks"
KINDS = {"reach": [], "carry": ["--carry", "home"], "place": ["--place", "outside"]}
SCENARIOS = ["011", "013", "015", "021", "023", "025", "031", "033", "035", "041", "043", "045"]


def plan(folder: str, scenario: str, seed: int, flags: list[str]) -> dict[str, Any]:
    """Plan file for a scenario and seed."""
    file = Path(folder) / "x.plan.json"
    command = [str(COMMAND), "plan", scenario, "--seed", str(seed), "--json", "-o", str(file), "--time-limit", "5", *flags]
    answer = json.loads(subprocess.run(command, check=False, capture_output=True).stdout)
    return dict(json.loads(file.read_text())) | {"timing_time_s": answer.get("timing_time_s")}


def smooth(folder: str, seeds: int) -> None:
    """Durations relative to those with a stop at each corner."""
    for kind, flags in KINDS.items():
        shares, rounding = [], []
        for scenario in SCENARIOS:
            for seed in range(seeds):
                pair = [plan(folder, scenario, seed, [*flags, *more]) for more in ([], ["--stop-at-corners"])]
                times = [found["timing"]["duration_s"] for found in pair if found.get("timing")]
                if len(times) == 2:
                    shares.append(times[0] / times[1])
                    rounding.append(1e3 * pair[0]["timing_time_s"])
        middle, mean = statistics.median(shares), statistics.mean(shares)
        print(f"{kind}: {len(shares)} plans, median {middle:.3f}, mean {mean:.3f}, {min(shares):.3f} to {max(shares):.3f}")
        print("  of those with a corner:", f"{statistics.median([share for share in shares if share < 1]):.3f} of {sum(share < 1 for share in shares)}")
        print(f"  to round and time: median {statistics.median(rounding):.1f}, max {max(rounding):.1f} ms")


def of_plans(found: list[dict[str, Any]]) -> str:
    """Number of plans found, and milliseconds of planning."""
    times = [1e3 * plan["statistics"]["planning_time_s"] for plan in found]
    solved = sum(plan["outcome"] == "solved" for plan in found)
    return f"{solved}/{len(found)}, median {statistics.median(times):.1f}, max {max(times):.0f} ms"


def upright(folder: str, seeds: int) -> None:
    """Plans found and milliseconds of planning, without a tilt limit and with two limits."""
    for kind in ("carry", "place"):
        for scenario in ("011", "013", "015", "025", "035", "043"):
            row = []
            for degrees in (None, 15, 5):
                flags = KINDS[kind] + ([] if degrees is None else ["--upright", str(degrees)])
                found = [plan(folder, scenario, seed, flags) for seed in range(seeds)]
                row.append(f"{degrees}: {of_plans(found)}")
            print(kind, scenario, " | ".join(row), flush=True)


def bottles(folder: str, seeds: int) -> None:
    """The same for a 0.5 l bottle instead of the screwdriver in the shelf of 011 to 015, put down outside."""
    for number in range(1, 6):
        text = (SCENARIOS_OF_OURS / f"01{number}" / "scenario.yaml").read_text()
        before, after = text.split("target:")[0], text.split("places:")[1]
        depth = 0.7 + 0.1 * (number - 1)
        target = f"""target:
  name: "bottle"
  pose: {{position: [0.988, {depth:.3f}, 0.6]}}
  shapes:
    - cylinder: {{radius: 0.032, length: 0.2}}
  mass_kg: 0.52
  friction: 0.5
"""
        bottle = Path(folder) / f"bottle_01{number}"
        bottle.mkdir()
        row = []
        for degrees in (None, 15, 5):
            mark = "" if degrees is None else f"  upright_deg: {degrees}\n"
            bottle.joinpath("scenario.yaml").write_text(before + target + mark + "places:" + after)
            found = [plan(folder, str(bottle), seed, ["--place", "outside"]) for seed in range(seeds)]
            row.append(f"{degrees}: {of_plans(found)}")
        print(bottle.name, " | ".join(row), flush=True)


def cups(folder: str, seeds: int) -> None:
    """The same for the cans and mugs of `examples/tasks`."""
    for name in ("can_shelf", "can_gap", "mug_shelf", "mug_gap"):
        text = (TASKS / name / "scenario.yaml").read_text()
        free = Path(folder) / name
        free.mkdir()
        free.joinpath("scenario.yaml").write_text(text.replace("  upright_deg: 15\n", ""))
        row = []
        for degrees in (None, 15, 5):
            scenario, limit = (str(free), []) if degrees is None else (str(TASKS / name), ["--upright", str(degrees)])
            found = [plan(folder, scenario, seed, ["--place", "tray", *limit]) for seed in range(seeds)]
            row.append(f"{degrees}: {of_plans(found)}")
        print(name, " | ".join(row), flush=True)


def straight(folder: str, seeds: int) -> None:
    """Plans found in the twenty scenarios and planning times (ms), with and without straight lines and torque
    limits."""
    kinds = {
        "reach": [],
        "reach, approach 5 cm": ["--approach", "5"],
        "place": KINDS["place"],
        "place, approach 5 cm, retreat 10 cm": [*KINDS["place"], "--approach", "5", "--retreat", "10"],
        "carry": KINDS["carry"],
        "carry, torque": [*KINDS["carry"], "--torque"],
    }
    scenarios = [f"0{family}{level}" for family in range(1, 5) for level in range(1, 6)]
    for kind, flags in kinds.items():
        found = [plan(folder, scenario, seed, flags) for scenario in scenarios for seed in range(seeds)]
        print(f"{kind}: {of_plans(found)}", flush=True)


if __name__ == "__main__":
    with TemporaryDirectory() as temporary:
        parts = {"smooth": smooth, "upright": upright, "cups": cups, "bottles": bottles, "straight": straight}
        parts[sys.argv[1]](temporary, int(sys.argv[2]))
