#!/usr/bin/env bash
# A campaign of 2000 trials: twenty times the campaign is killed with SIGKILL at a random moment, twenty times a worker is,
# five times it is told to end (SIGTERM), once its disk is full (as root). Then it ends, trials of killed workers are run
# again, and every trial must be there once, and no temporary folder.
# Usage: benchmarks/campaign_kills.sh   (CRANNY=… takes another binary)
set -euo pipefail
cd "$(dirname "$0")/.."
cranny=$(realpath "${CRANNY:-target/release/cranny}")
folder=$(mktemp -d)
export TMPDIR=$folder/tmp
mkdir "$TMPDIR" "$folder/disk"
trap 'umount "$folder/disk" 2> /dev/null || true; rm -rf "$folder"' EXIT
cd "$folder"
mount -t tmpfs -o size=600k none disk 2> /dev/null || echo "no small disk without root"
campaign=("$cranny" bench run --scenarios 021,022 --planners reach --runs 1000 --time-limit 5 -o disk/results.db)

# Begins the campaign, and lets a random while pass.
begin() {
  "${campaign[@]}" --quiet &
  run=$!
  sleep "0.$((RANDOM % 500 + 300))"
}

told() { "$cranny" bench status disk/results.db 2> /dev/null | head -1 || true; }

"${campaign[@]}" --quiet || echo "disk full: exit $?, $(told)"
mount -o remount,size=100m disk 2> /dev/null || true
for _ in $(seq 20); do
  begin
  kill -9 "$run" 2> /dev/null || true
  wait "$run" 2> /dev/null || true
done
echo "20 campaigns killed: $(told)"
for _ in $(seq 20); do
  begin
  pkill -9 --parent "$run" || true
  sleep 0.2
  kill -TERM "$run" 2> /dev/null || true
  wait "$run" 2> /dev/null || true
done
echo "20 workers killed: $(told)"
for _ in $(seq 5); do
  begin
  kill -TERM "$run" 2> /dev/null || true
  wait "$run" 2> /dev/null || true
done
echo "5 times told to end: $(told)"
"${campaign[@]}"
"${campaign[@]}" --again killed
echo "temporary folders: $(find "$TMPDIR" -maxdepth 1 -name 'cranny-bench-*' | wc -l)"
python3 - <<'PYTHON'
import sqlite3
connection = sqlite3.connect("disk/results.db")
print(connection.execute("SELECT count(*) FROM trials").fetchone()[0], "trials,",
      connection.execute("SELECT count(*) FROM (SELECT DISTINCT scenario, seed FROM trials)").fetchone()[0], "distinct,",
      connection.execute("SELECT count(*) FROM trials WHERE outcome = 'solved'").fetchone()[0], "solved,",
      connection.execute("SELECT count(*) FROM runs").fetchone()[0], "runs, integrity_check:",
      connection.execute("PRAGMA integrity_check").fetchone()[0])
PYTHON
