#!/usr/bin/env python3
"""Compares the speed of two versions of Cranny: the median ratio over alternating pairs of runs, with its interval.

    cargo build --release -p cranny-measure --bin check_rate --bin motion_bench --bin campaign
    benchmarks/compare_versions.py OLD NEW --pairs 15

OLD and NEW are folders with these three programs, from target/release of each version. CRANNY_DATA names the data.
Each run is bound to one core, and the version that runs first alternates. The interval contains the median of the
ratios with a probability of 95 % (order statistics).
"""

import argparse
import os
import re
import statistics
import subprocess
from pathlib import Path

SCENARIOS = ["012", "022", "033", "041", "043", "045"]
FAMILIES = ["bookshelf_small_panda", "bookshelf_tall_panda", "bookshelf_thin_panda", "box_panda", "table_pick_panda", "all"]


def output(folder: Path, program: str, *arguments: str, core: int) -> list[str]:
    """Output lines of a program."""
    command = ["taskset", "-c", str(core), str(folder / program), *arguments]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()


def measured(folder: Path, data: Path, core: int) -> dict[str, float]:
    """Figures by name; times have different units."""
    scenarios = data / "jogramop/scenarios"
    figures: dict[str, float] = {}
    rates = output(folder, "check_rate", *(str(scenarios / name) for name in ("011", "044")), core=core)
    for name, line in zip(("011", "044"), (line for line in rates if "verdicts" in line)):
        one, batch = re.findall(r"(\d+) (?:verdicts/s one|in batches)", line)[:2]
        figures[f"check_rate {name}, one at a time"] = 1e9 / float(one)
        figures[f"check_rate {name}, in batches"] = 1e9 / float(batch)
        if prepared := re.search(r"(\d+) ms to prepare", line):
            figures[f"check_rate {name}, preparation"] = float(prepared[1])
    for line in output(folder, "motion_bench", str(data / "motion_bench_maker"), "reach", "1", core=core):
        words = line.replace("|", " ").split()
        if len(words) >= 12 and words[0] in FAMILIES:
            figures[f"motion_bench {words[0]}, search"] = float(words[-6])
            figures[f"motion_bench {words[0]}, with proof"] = float(words[-3])
    for line in output(folder, "campaign", "reach", "10", "0", "0", *(str(scenarios / s) for s in SCENARIOS), core=core):
        cells = [cell.strip() for cell in line.split("|")]
        if len(cells) > 10 and cells[1] in SCENARIOS:
            figures[f"campaign {cells[1]}, median"] = float(cells[4])
            figures[f"campaign {cells[1]}, shortcut"] = float(cells[10])
    return figures


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old", type=Path)
    parser.add_argument("new", type=Path)
    parser.add_argument("--pairs", type=int, default=15)
    parser.add_argument("--core", type=int, default=0)
    arguments = parser.parse_args()
    data = Path(os.environ["CRANNY_DATA"])
    pairs = []
    for pair in range(arguments.pairs):
        order = [("old", arguments.old), ("new", arguments.new)]
        if pair % 2:
            order.reverse()
        pairs.append({name: measured(folder, data, arguments.core) for name, folder in order})
    spread = 0.98 * len(pairs) ** 0.5
    low, high = max(0, int(len(pairs) / 2 - spread)), min(len(pairs) - 1, int(len(pairs) / 2 + spread))
    print("| figure | new/old | 95 % interval |\n|---|---|---|")
    for figure in pairs[0]["old"]:
        ratios = sorted(pair["new"][figure] / max(pair["old"][figure], 1e-9) for pair in pairs)
        print(f"| {figure} | {statistics.median(ratios):.3f} | {ratios[low]:.3f} to {ratios[high]:.3f} |")


if __name__ == "__main__":
    main()
