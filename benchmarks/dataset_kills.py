"""A generation of demonstrations that is killed (SIGKILL) at random moments, and continued each time:
`dataset_kills.py [KILLS] [ROWS]`. Runs the command named by `CRANNY_BIN`, or the one in `target/release`.

The moments are spread over the time that an uninterrupted run takes; every fourth interruption is Ctrl-C instead, which must
end within seconds with exit code 1. In the end all files must have the bytes of the uninterrupted run, and nothing else may be there.
"""

from __future__ import annotations

import hashlib
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

COMMAND = os.environ.get("CRANNY_BIN") or str(Path(__file__).resolve().parents[1] / "target/release/cranny")


def contents(folder: Path) -> dict[str, str]:
    """Hash of each file below a folder."""
    files = (path for path in folder.rglob("*") if path.is_file())
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


def chunks(folder: Path) -> int:
    """Number of complete chunks."""
    return len(list((folder / "scenes").glob("*.parquet")))


def main(kills: int, rows: int) -> bool:
    """Runs, kills and compares; returns whether all is as it must be."""
    draw = random.Random(7)
    with TemporaryDirectory() as temporary:
        place = Path(temporary)
        recipe = place / "recipe.yaml"
        recipe.write_text(f"count: {rows}\nfamilies: [gap, table]\nqueries_per_scene: 4\n", encoding="utf-8")

        def words(name: str) -> list[str]:
            return [COMMAND, "dataset", "generate", str(recipe), "-o", str(place / name), "--quiet"]

        begin = time.monotonic()
        subprocess.run(words("whole"), check=True)
        whole_s = time.monotonic() - begin
        print(f"uninterrupted: {rows} rows, {chunks(place / 'whole')} chunks in {whole_s:.1f} s", flush=True)
        done, ended, codes, answers_s = [], 0, [], []
        for number in range(kills):
            run = subprocess.Popen(words("set"), stdout=subprocess.DEVNULL)
            # At least one kill falls into the start, while the grasps are sampled and the folder is made.
            time.sleep(draw.uniform(0.0, 0.3 * whole_s) if number else 0.1)
            is_kill = number % 4 != 3
            run.send_signal(signal.SIGKILL if is_kill else signal.SIGINT)
            told = time.monotonic()
            code = run.wait()
            if code == 0:
                ended += 1
            elif not is_kill:
                codes.append(code)
                answers_s.append(time.monotonic() - told)
            done.append(chunks(place / "set"))
            if code == 0 and number + 1 < kills:
                # All rows are there before the last kill: the rest begins anew, in a folder of its own.
                (place / "set").rename(place / f"ended {number}")
        subprocess.run(words("set"), check=True)
        whole = contents(place / "whole")
        sets = [folder for folder in place.iterdir() if folder.is_dir() and folder.name != "whole"]
        same = [contents(folder) == whole for folder in sets]
        left = [folder.name for folder in place.iterdir() if folder.name.startswith(".")]
        check = subprocess.run([COMMAND, "dataset", "check", str(place / "set"), "--all", "--quiet"], check=False, stdout=subprocess.DEVNULL)
    print(f"{kills} interruptions, {len(codes)} of them Ctrl-C (exit codes {sorted(set(codes))}, at most {max(answers_s, default=0.0):.1f} s to end)")
    print(f"complete chunks after each: {done}; {ended} runs had ended before")
    print(f"{sum(same)} of {len(same)} sets equal to the uninterrupted one, byte for byte; left beside them: {left}; check: exit code {check.returncode}")
    return all(same) and not left and check.returncode == 0 and set(codes) <= {1}


if __name__ == "__main__":
    given = [int(word) for word in sys.argv[1:]]
    sys.exit(0 if main(*given, *[20, 6000][len(given) :]) else 1)
