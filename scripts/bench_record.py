#!/usr/bin/env python3
"""The record: seconds of weft, of Mmg where it is found, and what others have published, as table, picture and history.

Programs take turns, `--repeats` times; the fastest run of each counts, since all others were disturbed. Cases: adaptation on one
thread and on two, coarsening of the result to a tenth, adapting the result again, and with --meshing the initial meshes of
bench_meshing.py beside TetGen's. Rows are appended to scripts/record.csv, by commit and processor; build/bench/record.md and
record.svg show this run beside the published figures and the best that the history has for this processor."""

import argparse
import collections
import csv
import json
import os
import pathlib
import shutil
import subprocess
import sys

import matplotlib
from matplotlib import pyplot

import bench

ROOT, OUT = bench.ROOT, bench.OUT
HISTORY = ROOT / "scripts/record.csv"
COLUMNS = ["date", "commit", "processor", "case", "task", "program", "seconds", "Q mean", "Q 1%", "Q min", "unit %", "tets"]

# Seconds that authors have published for one core, on their machines: case, task -> program -> seconds. feflo.a: UGAWG's cube.
PUBLISHED = {("cube-500k", "adapt, 1 thread"): {"feflo.a (published)": 43.9}}


def commit():
    told = subprocess.run(["git", "-C", ROOT, "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=False)
    changed = subprocess.run(["git", "-C", ROOT, "diff", "--quiet", "HEAD", "--", ".", f":!{HISTORY.relative_to(ROOT)}"], check=False).returncode != 0
    return told.stdout.strip() + ("+" if changed else "")


def processor():
    models = [line.split(":", 1)[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")]
    return (models or ["unknown"])[0]


class Task:
    """One kind of run of one case: programs by name, each a function that runs once and returns seconds and measures."""

    def __init__(self, case, name, programs):
        self.case, self.name, self.programs = case, name, programs
        self.runs = collections.defaultdict(list)

    def take_turns(self, repeats):
        for turn in range(repeats):
            for program, run in self.programs.items():
                seconds, measures = run()
                self.runs[program].append((seconds, measures))
                print(f"  {self.case}, {self.name}, {program}, {turn + 1} of {repeats}: {seconds:.2f} s", flush=True)

    def rows(self, about):
        for program, runs in self.runs.items():
            seconds, measures = min(runs, key=lambda one: one[0])
            quality = measures["quality"]
            yield {**about, "case": self.case, "task": self.name, "program": program, "seconds": f"{seconds:.2f}",
                   "Q mean": f"{quality['mean']:.4f}", "Q 1%": f"{quality['quantile_0.01']:.4f}",
                   "Q min": f"{quality['min']:.4f}", "unit %": f"{100 * measures['edge_length']['share_unit']:.2f}",
                   "tets": measures["tets"]}


def measures_of(mesh, metric):
    text = subprocess.run([bench.WEFT, "stat", mesh, "--metric", metric, "--json"], check=True, capture_output=True).stdout
    return json.loads(text)["measures"]


def weft_run(start, result, threads, *options):
    """Without --report, which draws the mesh: the others draw nothing either."""
    def run():
        seconds, _ = bench.run([bench.WEFT, "adapt", start[0], "--metric", start[1], "-o", result, "--threads", threads,
                                "--progress", "none", *options])
        return seconds, measures_of(result, result.with_suffix(".solb"))
    return run


def mmg_run(program, start, result, target):
    def run():
        row = bench.bench_mmg(program, result.stem, start, target, 1)
        return float(row["seconds"]), measures_of(OUT / f"{result.stem}-mmg.meshb", mmg_metric(result))
    return run


def mmg_metric(result):
    mesh = OUT / f"{result.stem}-mmg.meshb"
    return next(file for file in (mesh.with_suffix(".solb"), mesh.with_suffix(".sol")) if file.exists())


def tasks_of(case, mmg):
    """In the order in which they must be run: later ones start from results of the first."""
    name, target = bench.TARGETS[case]
    start = bench.start_of(name)
    if not start:
        print(f"record: {case} left out: its start mesh is not in WEFT_CASES")
        return []
    fine = OUT / f"record-{case}.meshb"
    again = fine, fine.with_suffix(".solb")
    first = {"weft": weft_run(start, fine, 1, "--complexity", target)}
    coarse = {"weft": weft_run(again, OUT / "record-coarse.meshb", 1, "--complexity", target // 10)}
    if mmg:
        first["Mmg"] = mmg_run(mmg, start, fine, target)
        coarse["Mmg"] = mmg_run(mmg, again, OUT / "record-coarse.meshb", target // 10)
    return [Task(case, "adapt, 1 thread", first),
            Task(case, "adapt, 2 threads", {"weft": weft_run(start, OUT / "record-2.meshb", 2, "--complexity", target)}),
            Task(case, "coarsen to a tenth", coarse),
            Task(case, "adapt again", {"weft": weft_run(again, OUT / "record-again.meshb", 1)})]


def meshing_rows(about):
    """Of bench_meshing.py, which compares by itself."""
    path = OUT / "meshing" / "meshing.csv"
    subprocess.run([sys.executable, "-B", ROOT / "scripts/bench_meshing.py"], check=True)
    if not path.exists():
        return
    with open(path, newline="") as file:
        for row in csv.DictReader(file):
            if not row["seconds"]:  # no mesh within the limit
                continue
            yield {**about, "case": row["surface"], "task": "initial mesh", "program": row["program"],
                   "seconds": f"{float(row['seconds']):.2f}", "tets": row["tets"],
                   **{name: f"{float(row[name]):.4f}" for name in ("Q mean", "Q 1%", "Q min")}}


def read_history():
    if not HISTORY.exists():
        return []
    with open(HISTORY, newline="") as file:
        return list(csv.DictReader(file))


def append_history(rows):
    fresh = not HISTORY.exists()
    with open(HISTORY, "a", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        if fresh:
            writer.writeheader()
        writer.writerows(rows)


def bars_of(rows, history, about):
    """Case and task -> program -> seconds: this run, the best before it on such a processor, what was published."""
    bars = collections.defaultdict(dict)
    for row in rows:
        key = row["case"], row["task"]
        bars[key][row["program"]] = float(row["seconds"])
        before = [float(old["seconds"]) for old in history
                  if (old["case"], old["task"], old["program"]) == (*key, row["program"]) and old["processor"] == about["processor"]]
        if before and row["program"] == "weft":
            bars[key]["weft, best before"] = min(before)
        bars[key].update(PUBLISHED.get(key, {}))
    return bars


def write_table(bars, about):
    lines = [f"Commit {about['commit']}, {about['processor']}, {about['date']}; seconds, the fastest of alternating runs", "",
             "| case | task | program | s | times weft |", "|---|---|---|---|---|"]
    for (case, task), programs in bars.items():
        for program, seconds in sorted(programs.items(), key=lambda one: one[1]):
            lines.append(f"| {case} | {task} | {program} | {seconds:.2f} | {seconds / programs['weft']:.2f} |")
    (OUT / "record.md").write_text("\n".join(lines) + "\n")
    print("\n".join(lines))


def draw(bars, about):
    matplotlib.use("svg")
    figure, axes = pyplot.subplots(len(bars), 1, figsize=(8, 0.6 + sum(0.4 + 0.3 * len(b) for b in bars.values())), squeeze=False,
                                   gridspec_kw={"height_ratios": [1 + len(b) for b in bars.values()]})
    for ((case, task), programs), plot in zip(bars.items(), axes[:, 0]):
        names = sorted(programs, key=programs.get, reverse=True)
        colours = ["tab:orange" if name == "weft" else "tab:gray" for name in names]
        plot.bar_label(plot.barh(names, [programs[name] for name in names], color=colours), fmt="%.1f s", padding=3)
        plot.set_title(f"{case}: {task}", loc="left", fontsize=9)
        plot.spines[["top", "right"]].set_visible(False)
        plot.margins(x=0.15)
    figure.suptitle(f"{about['commit']}, {about['date']}", fontsize=9, x=0.99, ha="right")
    figure.tight_layout()
    figure.savefig(OUT / "record.svg")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cases", nargs="*", metavar="CASE", help=f"of {', '.join(bench.TARGETS)} (default: the two of 500,000)")
    parser.add_argument("--repeats", type=int, default=3, help="turns of each program (default 3)")
    parser.add_argument("--meshing", action="store_true", help="initial meshes too")
    parser.add_argument("--no-history", action="store_true", help="leaves scripts/record.csv as it is")
    options = parser.parse_args()
    unknown = set(options.cases) - set(bench.TARGETS)
    if unknown:
        parser.error(f"no case {', '.join(unknown)}")
    OUT.mkdir(parents=True, exist_ok=True)
    mmg = os.environ.get("MMG3D") or shutil.which("mmg3d") or shutil.which("mmg3d_O3")
    date = subprocess.run(["date", "-u", "+%Y-%m-%d"], capture_output=True, text=True, check=True).stdout.strip()
    about = {"date": date, "commit": commit(), "processor": processor()}
    rows = []
    for case in options.cases or ["cube-500k", "delta-500k"]:
        for task in tasks_of(case, mmg):
            task.take_turns(options.repeats)
            rows += task.rows(about)
    if options.meshing:
        rows += meshing_rows(about)
    if not rows:
        sys.exit("record: no case could be run")
    bars = bars_of(rows, read_history(), about)
    if not options.no_history:
        append_history(rows)
    write_table(bars, about)
    draw(bars, about)
    print(f"picture: {(OUT / 'record.svg').relative_to(ROOT)}")


if __name__ == "__main__":
    main()
