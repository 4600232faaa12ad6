#!/usr/bin/env python3
"""`weft adapt` in subdomains beside one mesh: quality, time, memory, for every combination of the options given.

Each row is one run with one thread a rank. "ratio" is its adaptation time to that of one mesh with as many threads as the
row has ranks; the one mesh runs again right before each row with --paired, else once for each number of threads.
Everything also goes to build/bench/distributed.csv. One thread a rank gives the same mesh for any number of ranks:
--ranks concerns time and memory alone."""

import argparse
import csv
import itertools
import json
import os

import bench
from bench import OUT, WEFT

CASES = ("cube", "delta")
COLUMNS = ["case", "subdomains", "ranks", "partitioner", "seconds", "ratio", "beside %", "shifts", "peak MB", "Q mean", "Q 1%",
           "Q min", "unit %", "interface Q 1%", "interface unit %", "collectives"]


def adapt(start, target, *options, ranks=1):
    """The report of one run."""
    report = OUT / "report"
    launcher = ["mpirun", "-n", ranks, "--oversubscribe", "--bind-to", "none", "--mca", "mpi_yield_when_idle", 1]
    launcher += ["--allow-run-as-root"] if os.geteuid() == 0 else []
    bench.run([*(launcher if ranks > 1 else []), WEFT, "adapt", start[0], "--metric", start[1], "--complexity", target, "-o", OUT / "distributed.meshb",
               "--report", report, "--progress", "none", *options])
    return json.loads((report / "report.json").read_text())


def common(case, measures, seconds, peak):
    quality = measures["quality"]
    return {"case": case, "seconds": f"{seconds:.1f}", "peak MB": f"{peak / 1e6:.0f}", "Q mean": f"{quality['mean']:.3f}",
            "Q 1%": f"{quality['quantile_0.01']:.3f}", "Q min": f"{quality['min']:.3f}",
            "unit %": f"{100 * measures['edge_length']['share_unit']:.1f}"}


def row_of_one_mesh(case, report, threads):
    row = dict.fromkeys(COLUMNS, "")
    row.update(common(case, report["after"], report["seconds"]["adapt"], report["peak_memory_bytes"]))
    row.update({"subdomains": 1, "partitioner": f"one mesh, {threads} thread{'s' * (threads > 1)}", "ratio": "1.00"})
    return row


def row_of(case, report, ranks, partitioner, seconds_of_one_mesh):
    parts = report["subdomains"]
    interface = parts["former_interface"]
    seconds = report["seconds"]["adapt"]
    row = common(case, report["after"], seconds, report["peak_memory_bytes"])
    row.update({"subdomains": parts["subdomains"], "ranks": ranks, "partitioner": partitioner,
                "ratio": f"{seconds / seconds_of_one_mesh:.2f}", "beside %": f"{100 * parts['share_beside_adaptation']:.1f}",
                "shifts": len(parts["shifts"]), "collectives": parts["engine"]["collective_calls"],
                "interface Q 1%": f"{interface['quality']['quantile_0.01']:.3f}",
                "interface unit %": f"{100 * interface['edge_length']['share_unit']:.1f}"})
    return row


def print_row(row):
    widths = [5, 10, 5, 20, 8, 5, 8, 6, 7, 6, 6, 6, 6, 14, 16, 11]
    print("  ".join(str(row[column]).rjust(width) for column, width in zip(COLUMNS, widths)), flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", nargs="+", choices=CASES, default=CASES)
    parser.add_argument("--complexity", type=int, default=100_000, help="(default 100000)")
    parser.add_argument("--subdomains", nargs="+", type=int, default=[2, 16, 128], help="(default 2 16 128)")
    parser.add_argument("--ranks", nargs="+", type=int, default=[2], help="(default 2)")
    parser.add_argument("--partitioners", nargs="+", default=["graph"], help="slabs (pqr:Nx1x1), bisection, graph")
    parser.add_argument("--paired", action="store_true", help="run the one mesh again before each row")
    options = parser.parse_args()
    OUT.mkdir(parents=True, exist_ok=True)
    with open(OUT / "distributed.csv", "w", newline="") as file:
        out = csv.DictWriter(file, COLUMNS)
        out.writeheader()
        print_row(dict(zip(COLUMNS, COLUMNS)))

        def add(row):
            print_row(row)
            out.writerow(row)
            file.flush()

        for case in options.cases:
            start = bench.start_of(case)
            if not start:
                print(f"bench: {case} left out: its start mesh is not in WEFT_CASES")
                continue
            alone = {}
            for ranks, subdomains, partitioner in itertools.product(options.ranks, options.subdomains, options.partitioners):
                if options.paired or ranks not in alone:
                    report = adapt(start, options.complexity, "--threads", ranks)
                    if ranks not in alone:
                        add(row_of_one_mesh(case, report, ranks))
                    alone[ranks] = report["seconds"]["adapt"]
                name = f"pqr:{subdomains}x1x1" if partitioner == "slabs" else partitioner
                report = adapt(start, options.complexity, "--threads", 1, "--subdomains", subdomains, "--partitioner", name, ranks=ranks)
                add(row_of(case, report, ranks, name, alone[ranks]))


if __name__ == "__main__":
    main()
