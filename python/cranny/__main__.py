"""The program `cranny` that the wheel brings: `python -m cranny plan 021` is `cranny plan 021`.

For environments whose folder of commands is not on the PATH.
"""

from __future__ import annotations

import os
import subprocess
import sys
from importlib.metadata import files
from pathlib import Path

NAMES = ("cranny", "cranny.exe")


def program() -> Path:
    """Path of the program of this installation; ends with exit code 2 if it has none."""
    listed = [Path(str(file.locate())) for file in files("cranny") or [] if file.name in NAMES]
    # `pip install --target FOLDER` moves the programs without a note in its list of files.
    beside = [Path(__file__).parents[1] / "bin" / name for name in NAMES]
    for path in [*listed, *beside]:
        if path.is_file():
            return path
    print(
        "error: this installation of the package has no program (a wheel brings it, an editable installation does not)\n"
        "  hint: in a checkout, `cargo install --path crates/cli` builds and installs it",
        file=sys.stderr,
    )
    sys.exit(2)


def main() -> None:
    """Runs the program with the words of the command line; exit code and signals are the program's own."""
    command = [str(program()), *sys.argv[1:]]
    if os.name == "posix":
        os.execv(command[0], command)
    # Elsewhere there is no replacement of a process. Ctrl-C reaches both, and the program decides how it ends.
    child = subprocess.Popen(command)
    while True:
        try:
            sys.exit(child.wait())
        except KeyboardInterrupt:
            continue


if __name__ == "__main__":
    main()
