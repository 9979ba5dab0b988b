#!/usr/bin/env bash
# Kills a campaign of 2000 trials of `reach` twenty times with SIGKILL at random moments, lets it end, and checks that
# every trial is there once. Usage: benchmarks/campaign_kills.sh   (CRANNY=… takes another binary)
set -euo pipefail
cd "$(dirname "$0")/.."
cranny=$(realpath "${CRANNY:-target/release/cranny}")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
campaign=("$cranny" bench run --scenarios 021,022 --planners reach --runs 1000 --time-limit 5 -o results.db)
for kill in $(seq 20); do
  "${campaign[@]}" --quiet &
  sleep "0.$((RANDOM % 500 + 100))"
  kill -9 $! 2>/dev/null || true
  wait $! 2>/dev/null || true
  "$cranny" bench merge results.db results.db --json 2>/dev/null |
    python3 -c "import json, sys; print('kill $kill:', json.load(sys.stdin)['trials'], 'trials')" || echo "kill $kill: no results yet"
done
"${campaign[@]}"
python3 - <<'PYTHON'
import sqlite3
connection = sqlite3.connect("results.db")
print(connection.execute("SELECT count(*) FROM trials").fetchone()[0], "trials,",
      connection.execute("SELECT count(*) FROM (SELECT DISTINCT scenario, seed FROM trials)").fetchone()[0], "distinct,",
      connection.execute("SELECT count(*) FROM runs").fetchone()[0], "runs, integrity_check:",
      connection.execute("PRAGMA integrity_check").fetchone()[0])
PYTHON
