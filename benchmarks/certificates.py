"""Plans, certifies and checks: sizes of certificates, times to write and to check them (the least of three).

usage: certificates.py CRANNY CHECKER SEEDS [FLAGS OF PLAN…]
"""

import json
import resource
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

SCENARIOS = [f"0{family}{step}" for family in range(1, 5) for step in range(1, 6)]


def run(*words):
    return subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False)


def cpu_s():
    """Returns the time that finished programs have computed."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def row(name, values, unit):
    values = sorted(values)
    at = lambda share: values[min(len(values) - 1, int(share * len(values)))]
    numbers = [statistics.median(values), statistics.mean(values), at(0.95), at(0.99), values[-1]]
    print(f"| {name} | " + " | ".join(f"{x:.3g}" for x in numbers) + f" | {unit} |")


def main(cranny, checker, seeds, *flags):
    kilobytes, write_ms, check_ms, planes, counts = [], [], [], [], {}
    with tempfile.TemporaryDirectory() as folder:
        plan, certificate = Path(folder, "it.plan.json"), Path(folder, "it.cert")
        for scenario in SCENARIOS:
            for seed in range(int(seeds)):
                planned = run(cranny, "plan", scenario, "--seed", seed, "-o", plan, *flags)
                if planned.returncode != 0:
                    counts["not solved"] = counts.get("not solved", 0) + 1
                    continue
                written = run(cranny, "certify", scenario, plan, "-o", certificate, "--json")
                answer = json.loads(written.stdout)
                if written.returncode != 0:
                    counts["refused"] = counts.get("refused", 0) + 1
                    print(f"{scenario} {seed}: {answer['refused']}", file=sys.stderr)
                    continue
                times = []
                for _ in range(3):
                    begin = cpu_s()
                    checked = run(checker, certificate)
                    times.append(cpu_s() - begin)
                check_ms.append(1e3 * min(times))
                is_certified = checked.stdout.startswith("certified\n")
                outcome = "certified" if is_certified else "NOT accepted"
                counts[outcome] = counts.get(outcome, 0) + 1
                if not is_certified:
                    print(f"{scenario} {seed}: {checked.stdout}{checked.stderr}", file=sys.stderr)
                text = certificate.read_text()
                marks = [mark for line in text.split("\n") if line.startswith("p ") for mark in line.split()[1:]]
                planes.append(sum(mark not in ("h", "a", "b") for mark in marks))
                kilobytes.append(len(text) / 1000)
                write_ms.append(1e3 * answer["time_s"])
    print(f"{counts}\n\n| | median | mean | p95 | p99 | max | |\n|---|---|---|---|---|---|---|")
    row("size", kilobytes, "kB")
    row("planes written", planes, "")
    row("time to write", write_ms, "ms")
    row("time of the processor to check, with the start of the program", check_ms, "ms")


if __name__ == "__main__":
    main(*sys.argv[1:])
