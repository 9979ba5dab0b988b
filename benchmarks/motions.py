"""Duration of smooth trajectories against those with stops, and the search for upright motions: `motions.py smooth|upright
SEEDS`, with the command in `target/release`."""

import json
import statistics
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

COMMAND = Path(__file__).resolve().parents[1] / "target/release/cranny"
KINDS = {"reach": [], "carry": ["--carry", "home"], "place": ["--place", "outside"]}
SCENARIOS = ["011", "013", "015", "021", "023", "025", "031", "033", "035", "041", "043", "045"]


def plan(folder: str, scenario: str, seed: int, flags: list[str]) -> dict[str, Any]:
    """The plan file of a scenario and seed."""
    file = Path(folder) / "x.plan.json"
    command = [str(COMMAND), "plan", scenario, "--seed", str(seed), "-q", "-o", str(file), "--time-limit", "5", *flags]
    subprocess.run(command, check=False, capture_output=True)
    return dict(json.loads(file.read_text()))


def smooth(folder: str, seeds: int) -> None:
    """Durations as a share of those with a stop at each corner."""
    for kind, flags in KINDS.items():
        shares = []
        for scenario in SCENARIOS:
            for seed in range(seeds):
                pair = [plan(folder, scenario, seed, [*flags, *more]) for more in ([], ["--stop-at-corners"])]
                times = [found["timing"]["duration_s"] for found in pair if found.get("timing")]
                if len(times) == 2:
                    shares.append(times[0] / times[1])
        middle, mean = statistics.median(shares), statistics.mean(shares)
        print(f"{kind}: {len(shares)} plans, median {middle:.3f}, mean {mean:.3f}, {min(shares):.3f} to {max(shares):.3f}")


def upright(folder: str, seeds: int) -> None:
    """Plans that were found, and milliseconds of planning, without a bound on the tilt and with two."""
    for kind in ("carry", "place"):
        for scenario in ("011", "013", "015", "025", "035", "043"):
            row = []
            for degrees in (None, 15, 5):
                flags = KINDS[kind] + ([] if degrees is None else ["--upright", str(degrees)])
                found = [plan(folder, scenario, seed, flags) for seed in range(seeds)]
                times = [1e3 * plan["statistics"]["planning_time_s"] for plan in found]
                solved = sum(plan["outcome"] == "solved" for plan in found)
                row.append(f"{degrees}: {solved}/{seeds}, median {statistics.median(times):.1f}, max {max(times):.0f} ms")
            print(kind, scenario, " | ".join(row), flush=True)


if __name__ == "__main__":
    with TemporaryDirectory() as temporary:
        {"smooth": smooth, "upright": upright}[sys.argv[1]](temporary, int(sys.argv[2]))
