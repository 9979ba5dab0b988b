"""Verdicts on 10⁶ configurations through the C++ wrapper against the same batch in Rust, in alternating pairs.

    $ cargo xtask capi --prefix target/capi/bench
    $ c++ -O2 -std=c++17 benchmarks/cpp_is_free.cpp -Itarget/capi/bench/include -Ltarget/capi/bench/lib -lcranny \
        -Wl,-rpath,$PWD/target/capi/bench/lib -o target/cpp_is_free
    $ cargo build --release -p cranny-measure --bin batch_verdicts
    $ python benchmarks/cpp_is_free.py target/cpp_is_free target/release/batch_verdicts 21 011 021
"""

from __future__ import annotations

import statistics
import subprocess
import sys


def run(program: str, scenario: str) -> tuple[float, str]:
    """Seconds of the batch, and the verdicts as text."""
    seconds, verdicts = subprocess.check_output([program, scenario], text=True).split(maxsplit=1)
    return float(seconds), verdicts.strip()


cpp, rust, pairs = sys.argv[1], sys.argv[2], int(sys.argv[3])
for scenario in sys.argv[4:]:
    ratios, times, verdicts = [], {cpp: [], rust: []}, set()
    for pair in range(pairs):
        # The first of each pair alternates too.
        for program in (cpp, rust) if pair % 2 else (rust, cpp):
            seconds, found = run(program, scenario)
            times[program].append(seconds)
            verdicts.add(found)
        ratios.append(times[cpp][-1] / times[rust][-1])
    quartiles = statistics.quantiles(ratios, n=4)
    print(
        f"{scenario}: C++ {statistics.median(times[cpp]):.3f} s, Rust {statistics.median(times[rust]):.3f} s (medians); "
        f"ratio median {statistics.median(ratios):.3f}, quartiles {quartiles[0]:.3f} to {quartiles[2]:.3f}, "
        f"of {pairs} pairs; verdicts {'equal' if len(verdicts) == 1 else 'DIFFERENT'}: {', '.join(sorted(verdicts))}"
    )
