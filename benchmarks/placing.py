"""Number of grasps that remain after reach, carry and place: `python benchmarks/placing.py plot TABLE.md…` draws the
tables of `carrying grasps` as placing.svg beside this file (needs matplotlib)."""

import sys
from pathlib import Path


def plot(tables: list[str]) -> None:
    """Bar chart of the remaining grasps after each stage."""
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
        case ["plot", *tables] if tables:
            plot(tables)
        case _:
            sys.exit(__doc__)
