#!/usr/bin/env python3
"""Times `weft adapt` with 1 and 2 threads on the benchmark cases and prints a table.

Seconds and peak memory are of the whole process, files included. Mmg runs on the same inputs in the same run when
it is found (MMG3D=path or mmg3d in PATH); its mesh is measured in the metric that Mmg interpolated. Everything also
goes to build/bench/bench.csv, with commit and processor."""

import argparse
import csv
import json
import os
import pathlib
import shutil
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
WEFT = ROOT / "build/bin/weft"
OUT = ROOT / "build/bench"
CASES = pathlib.Path(os.environ.get("WEFT_CASES", ROOT / "../shared/cases"))

# Name -> (start mesh and metric, target complexity).
TARGETS = {
    "cube-50k": ("cube", 50_000),
    "cube-500k": ("cube", 500_000),
    "delta-500k": ("delta", 500_000),
}
COLUMNS = ["case", "program", "threads", "seconds", "tets/s", "peak MB", "bytes/tet", "Q mean", "Q 1%", "Q min",
           "unit %", "complexity", "note"]


def run(command):
    """Wall seconds and peak bytes of a command that must end with 0 or 1."""
    log = OUT / "last.log"
    start = time.monotonic()
    with open(log, "w") as output:
        process = subprocess.Popen([str(word) for word in command], stdout=output, stderr=subprocess.STDOUT)
        _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode not in (0, 1):
        sys.exit(f"bench: {' '.join(map(str, command))} failed:\n{log.read_text()[-2000:]}")
    return time.monotonic() - start, usage.ru_maxrss * 1024


def made_cube():
    """A start mesh like the shared one: the box adapted to the layer in stages."""
    mesh, metric = OUT / "cube-start.meshb", OUT / "cube-start-metric.solb"
    run([WEFT, "mesh", "box", "-o", OUT / "box.meshb", "--cells", 8, 8, 8])
    previous = OUT / "box.meshb"
    for complexity in (1000, 4000, 7627):
        run([WEFT, "adapt", previous, "--metric-fn", "polar-2", "--complexity", complexity, "-o", mesh])
        previous = mesh
    run([WEFT, "metric", mesh, "--metric-fn", "polar-2", "-o", metric])
    return mesh, metric


def start_of(name):
    """Mesh and metric that a case starts from, or None where the case is not at hand."""
    if name == "delta":
        files = CASES / "delta-wing/start.meshb", CASES / "delta-wing/start-metric.solb"
        return files if files[0].exists() else None
    files = CASES / "cube-polar2/start.meshb", CASES / "cube-polar2/start.solb"
    return files if files[0].exists() else made_cube()


def row_of(case, program, threads, seconds, peak, measures, note=""):
    quality, length = measures["quality"], measures["edge_length"]
    return {"case": case, "program": program, "threads": threads, "seconds": f"{seconds:.2f}",
            "tets/s": f"{measures['tets'] / seconds:.0f}", "peak MB": f"{peak / 1e6:.0f}",
            "bytes/tet": f"{peak / measures['tets']:.0f}", "Q mean": f"{quality['mean']:.3f}",
            "Q 1%": f"{quality['quantile_0.01']:.3f}", "Q min": f"{quality['min']:.3f}",
            "unit %": f"{100 * length['share_unit']:.1f}", "complexity": f"{measures['complexity']:.0f}", "note": note}


def weft_adapt(mesh, metric, result, threads, *options):
    report = OUT / "report"
    seconds, peak = run([WEFT, "adapt", mesh, "--metric", metric, "-o", result, "--threads", threads, "--report", report,
                         "--progress", "none", *options])
    return seconds, peak, json.loads((report / "report.json").read_text())


def bench_weft(case, start, target, repeats):
    """Rows for 1 and 2 threads and for adapting the result again; the best of the repeats counts."""
    rows, first = [], None
    for threads in (1, 2):
        result = OUT / f"{case}-{threads}.meshb"
        runs = [weft_adapt(*start, result, threads, "--complexity", target) for _ in range(repeats)]
        seconds, peak, report = min(runs, key=lambda one: one[0])
        first = first or (seconds, report["seconds"]["adapt"])
        note = "" if threads == 1 else f"{first[0] / seconds:.2f} times one thread"
        rows.append(row_of(case, "weft", threads, seconds, peak, report["after"], note))
    result = OUT / f"{case}-1.meshb"
    seconds, peak, report = weft_adapt(result, result.with_suffix(".solb"), OUT / "again.meshb", 1)
    note = f"again: {100 * report['seconds']['adapt'] / first[1]:.1f} % of the first adapt"
    rows.append(row_of(case, "weft", 1, seconds, peak, report["after"], note))
    return rows


def bench_mmg(program, case, start, target, weft_seconds):
    scaled, result = OUT / "scaled.solb", OUT / f"{case}-mmg.meshb"
    run([WEFT, "metric", start[0], "--metric", start[1], "--complexity", target, "-o", scaled])
    for old in (result.with_suffix(".sol"), result.with_suffix(".solb")):
        old.unlink(missing_ok=True)
    seconds, peak = run([program, "-in", start[0], "-sol", scaled, "-out", result, "-hgrad", "-1", "-v", "1"])
    metric = next(file for file in (result.with_suffix(".solb"), result.with_suffix(".sol")) if file.exists())
    text = subprocess.run([WEFT, "stat", result, "--metric", metric, "--json"], check=True, capture_output=True).stdout
    return row_of(case, "mmg3d", 1, seconds, peak, json.loads(text)["measures"],
                  f"{seconds / weft_seconds:.2f} times weft's time")


def print_table(rows):
    widths = [max(len(column), *(len(str(row[column])) for row in rows)) for column in COLUMNS]
    for cells in [COLUMNS] + [[str(row[column]) for column in COLUMNS] for row in rows]:
        print("  ".join(cell.rjust(width) for cell, width in zip(cells[:-1], widths)) + "  " + cells[-1])


def write_csv(rows):
    commit = subprocess.run(["git", "-C", ROOT, "rev-parse", "--short", "HEAD"], capture_output=True, text=True)
    models = [line.split(":", 1)[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")]
    about = {"commit": commit.stdout.strip(), "processor": (models or ["unknown"])[0], "cores": os.cpu_count()}
    with open(OUT / "bench.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, [*about, *COLUMNS])
        writer.writeheader()
        writer.writerows({**about, **row} for row in rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cases", nargs="*", metavar="CASE", help=f"of {', '.join(TARGETS)} (default: all)")
    parser.add_argument("--repeats", type=int, default=1, help="runs of each, the fastest counts (default 1)")
    options = parser.parse_args()
    unknown = set(options.cases) - set(TARGETS)
    if unknown:
        parser.error(f"no case {', '.join(unknown)}")
    OUT.mkdir(parents=True, exist_ok=True)
    mmg = os.environ.get("MMG3D") or shutil.which("mmg3d") or shutil.which("mmg3d_O3")
    rows = []
    for case in options.cases or TARGETS:
        name, target = TARGETS[case]
        start = start_of(name)
        if not start:
            print(f"bench: {case} left out: its start mesh is not in WEFT_CASES ({CASES.name}/)")
            continue
        rows += bench_weft(case, start, target, options.repeats)
        if mmg:
            rows.append(bench_mmg(mmg, case, start, target, float(rows[-3]["seconds"])))
    if rows:
        print_table(rows)
        write_csv(rows)


if __name__ == "__main__":
    main()
