#!/usr/bin/env python3
"""What looking on costs: `weft adapt` in subdomains with and without tracing, in pairs, by processor time.

Each pair runs both ways one after the other, the order changing from pair to pair, and the median of the pairs' ratios
counts: a machine that others use shifts single times by more than what is measured here. How much it does the line
"nothing" shows: it compares a run with itself. Ends with 1 where full tracing surely costs more than 2 %: where even
the lower quartile of the ratios says so."""

import argparse
import os
import pathlib
import statistics
import subprocess
import sys

from bench import OUT, WEFT, start_of

LIMIT = 0.02
WAYS = {
    "nothing": ["--progress", "none"],
    "tracing": ["--trace", OUT / "trace.json"],
    "tracing, graph and report": ["--trace", OUT / "trace.json", "--graph", OUT / "graph.json", "--report", OUT / "report"],
    "progress": ["--progress", "plain"],
}


def processor_seconds(words):
    with open(OUT / "last.log", "w") as output:
        process = subprocess.Popen([str(word) for word in words], stdout=output, stderr=subprocess.STDOUT)
        _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode not in (0, 1):
        sys.exit(f"bench: {' '.join(map(str, words))} failed:\n{pathlib.Path(output.name).read_text()[-2000:]}")
    return usage.ru_utime + usage.ru_stime


def compare(words, more, pairs):
    """Quartiles of the ratios of processor time, and the median of the plain seconds."""
    ratios, seconds = [], []
    quiet = [] if "--progress" in more else ["--progress", "none"]
    for pair in range(pairs):
        ways = [words + ["--progress", "none"], words + quiet + more]
        times = [processor_seconds(words) for words in (ways if pair % 2 == 0 else reversed(ways))]
        without, with_it = times if pair % 2 == 0 else reversed(times)
        ratios.append(with_it / without)
        seconds.append(without)
    return statistics.quantiles(ratios, n=4, method="inclusive"), statistics.median(seconds)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pairs", type=int, default=7, help="runs each way (default 7)")
    parser.add_argument("--complexity", type=int, default=50_000, help="of the cube (default 50000)")
    parser.add_argument("--subdomains", type=int, default=32, help="(default 32)")
    options = parser.parse_args()
    OUT.mkdir(parents=True, exist_ok=True)
    mesh, metric = start_of("cube")
    plain = [WEFT, "adapt", mesh, "--metric", metric, "--complexity", options.complexity, "--subdomains", options.subdomains,
             "--threads", 1, "-o", OUT / "traced.meshb"]
    too_much = False
    for name, more in WAYS.items():
        (low, median, high), seconds = compare(plain, more, options.pairs)
        print(f"{name}: {100 * (median - 1):+.2f} % (quartiles {100 * (low - 1):+.2f} and {100 * (high - 1):+.2f} %) of "
              f"{seconds:.1f} s of processor time", flush=True)
        too_much |= name == "tracing" and low > 1 + LIMIT
    return 1 if too_much else 0


if __name__ == "__main__":
    sys.exit(main())
