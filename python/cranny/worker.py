"""Processes of a campaign.

`python -m cranny.worker` serves trials; `python -m cranny.worker FILE FUNCTION` runs your own planner by the exec
protocol (docs/exec_protocol.md).
"""

from __future__ import annotations

import contextlib
import importlib.util
import json
import sys
from pathlib import Path

from cranny._cranny import serve_trials
from cranny.own_planner import PlannerFunction, answer, process_begin, reading_for_planner

MODULE = "__cranny_planner__"
"""Module name of a planner in its process; it is not `__main__`, so that a script does not run its main block."""


def load(file: Path, function: str) -> PlannerFunction:
    """Loads the function with this name from a Python file."""
    specification = importlib.util.spec_from_file_location(MODULE, file)
    if specification is None or specification.loader is None:
        raise SystemExit(f"{file}: no file of Python")
    module = importlib.util.module_from_spec(specification)
    sys.modules[MODULE] = module
    sys.path.insert(0, str(file.parent))
    with reading_for_planner():
        specification.loader.exec_module(module)
    found: PlannerFunction | None = getattr(module, function, None)
    if found is None:
        raise SystemExit(f"{file}: there is no function `{function}`")
    return found


def main(words: list[str]) -> None:
    """Serves trials without `words`, or runs the planner that they name."""
    if not words:
        serve_trials()
        return
    if len(words) != 2:
        raise SystemExit("usage: python -m cranny.worker [FILE FUNCTION]")
    begin = process_begin()
    # The planner's own output must not mix with the answer.
    with contextlib.redirect_stdout(sys.stderr):
        told = answer(load(Path(words[0]), words[1]), json.load(sys.stdin), begin)
    json.dump(told, sys.stdout)
    sys.stdout.flush()


if __name__ == "__main__":
    main(sys.argv[1:])
