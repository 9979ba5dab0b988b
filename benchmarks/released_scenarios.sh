#!/usr/bin/env bash
# Plans every released scenario with every baseline planner under both criteria, and prints a Markdown table.
# Usage: CRANNY_DATA=… benchmarks/released_scenarios.sh [seed] > table.md   (CRANNY=… takes another binary)
set -euo pipefail
cd "$(dirname "$0")/.."
seed=${1:-0}
scenarios="$CRANNY_DATA/jogramop/scenarios"
cranny=${CRANNY:-target/release/cranny}
[ -n "${CRANNY:-}" ] || cargo build --release --quiet
declare -A limit=([ik-rrt-exact]=60 [j-plus-rrt-exact]=20 [ik-rrt-paper]=45 [j-plus-rrt-paper]=45)
echo "| scenario | ik-rrt exact (60 s) | j-plus-rrt exact (20 s) | ik-rrt paper (45 s) | j-plus-rrt paper (45 s) |"
echo "|---|---|---|---|---|"
for scenario in "$scenarios"/*/; do
  id=$(basename "$scenario")
  row="| $id"
  for criterion in exact paper; do
    for planner in ik-rrt j-plus-rrt; do
      plan=$(mktemp --suffix .plan.json)
      cell=$("$cranny" plan "$scenario" --planner "$planner" --criterion "$criterion" \
        --seed "$seed" --time-limit "${limit[$planner-$criterion]}" -o "$plan" --json --quiet | python3 -c '
import json, sys
plan = json.load(sys.stdin)
time = plan["planning_time_s"]
iterations = plan["iterations"]
word = "" if plan["outcome"] == "solved" else plan["outcome"] + ", "
print(f"{word}{time:.3f} s, {iterations} iterations")') || true
      if [[ $cell != *budget* ]]; then
        "$cranny" verify "$scenario" "$plan" --criterion "$criterion" --quiet || cell="$cell, NOT VALID"
      fi
      rm -f "$plan"
      row="$row | $cell"
    done
  done
  echo "$row |"
done
