#!/usr/bin/env python3
"""Draws what threads do while a mesh is adapted in subdomains: on two ranks of two threads, and on one rank with more threads than subdomains.

Each lane is a thread: a worker, which runs tasks, or a helper, an idle thread that shares the passes of another's adaptation."""

import argparse
import json
import os
import pathlib
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
MPIRUN = ["mpirun", *(["--allow-run-as-root"] if os.geteuid() == 0 else []), "--oversubscribe", "--bind-to", "none", "--mca",
          "mpi_yield_when_idle", "1", "-n"]
COLOURS = {"adaptation": "#4269d0", "shifts": "#efb118", "help": "#3ca951"}
ADAPTATION = ("adapt interior", "adapt shifted")
RUNS = [(2, 2, 8), (1, 4, 2)]  # ranks, threads a rank, subdomains


def kind_of(event):
    if event.get("cat") == "help":
        return "help"
    if event.get("cat") == "node":
        return "adaptation" if event["name"] in ADAPTATION else "shifts"
    return None


def lanes_of(options, folder, ranks, threads, subdomains):
    """The busy times by kind of each thread, in seconds since the loop began."""
    trace = folder / "trace.json"
    launcher = [*MPIRUN, str(ranks)] if ranks > 1 else []
    words = [options.weft, "adapt", folder / "box.meshb", "--metric-fn", options.metric, "--complexity", options.complexity, "--subdomains",
             subdomains, "--threads", threads, "-o", folder / "out.meshb", "--trace", trace, "--quiet", "--force"]
    done = subprocess.run([*launcher, *map(str, words)], stderr=subprocess.PIPE, text=True)
    if done.returncode not in (0, 1):
        raise SystemExit(f"timelines: {done.stderr[-2000:]}")
    events = json.loads(trace.read_text())
    events = events["traceEvents"] if isinstance(events, dict) else events
    names = {(e["pid"], e["tid"]): f"rank {e['pid']}, {e['args']['name']}" for e in events if e["name"] == "thread_name"}
    spans = [(e, kind_of(e)) for e in events if e["ph"] == "X" and kind_of(e)]
    begin = min(e["ts"] for e, _ in spans)
    lanes = {name: {kind: [] for kind in COLOURS} for place, name in sorted(names.items()) if not name.endswith("communication")}
    for event, kind in spans:
        lanes[names[event["pid"], event["tid"]]][kind].append(((event["ts"] - begin) / 1e6, event["dur"] / 1e6))
    return lanes


def draw(axis, title, lanes):
    for i, (name, by_kind) in enumerate(lanes.items()):
        for kind, spans in by_kind.items():
            axis.broken_barh(spans, (i - 0.4, 0.8), color=COLOURS[kind], linewidth=0)
    axis.set_yticks(range(len(lanes)), list(lanes))
    axis.invert_yaxis()
    axis.set_xlim(0, None)
    axis.set_title(title, loc="left", fontsize=9)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("picture", type=pathlib.Path, help=".svg")
    parser.add_argument("--weft", default=ROOT / "build/bin/weft", type=pathlib.Path)
    parser.add_argument("--metric", default="polar-1")
    parser.add_argument("--complexity", type=float, default=20000)
    options = parser.parse_args()
    options.weft = options.weft.resolve()
    import matplotlib
    matplotlib.use("svg")
    matplotlib.rcParams.update({"svg.hashsalt": "weft", "font.size": 8})
    from matplotlib import patches, pyplot
    figure, axes = pyplot.subplots(len(RUNS), 1, figsize=(9, 5), constrained_layout=True)
    with tempfile.TemporaryDirectory(prefix="weft-timelines-") as name:
        folder = pathlib.Path(name)
        subprocess.run([options.weft, "mesh", "box", "--cells", "16", "-o", folder / "box.meshb", "--quiet"], check=True)
        for axis, (ranks, threads, subdomains) in zip(axes, RUNS):
            title = f"{subdomains} subdomains on {ranks} rank{'s' if ranks > 1 else ''} of {threads} threads"
            draw(axis, title, lanes_of(options, folder, ranks, threads, subdomains))
    axes[-1].set_xlabel("seconds since the loop began")
    figure.legend(handles=[patches.Patch(color=colour, label=kind) for kind, colour in COLOURS.items()], loc="upper right", ncol=3, frameon=False)
    figure.savefig(options.picture, metadata={"Date": None})


if __name__ == "__main__":
    main()
