#!/usr/bin/env python3
"""Messages and distinct peers of a rank before, in and after the loop of adaptation and shifts, against the number of ranks.

As many tets and subdomains on each rank however many there are (weak scaling): on --ranks simulated ranks in this process, for
each balancer, and on --real ranks of mpirun. Prints a table of means and of the largest of any rank; --plot draws the means.
"""

import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
PHASES = {"before_loop": "before", "in_loop": "in the loop", "after_loop": "after"}
MPIRUN = ["mpirun", *(["--allow-run-as-root"] if os.geteuid() == 0 else []), "--oversubscribe", "--bind-to", "none", "--mca",
          "mpi_yield_when_idle", "1", "-n"]


def run(options, folder, ranks, balancer, real):
    """What a rank exchanges in each phase, by name."""
    cells = round((options.tets * ranks / 6) ** (1 / 3))
    box = folder / f"{cells}.meshb"
    if not box.exists():
        subprocess.run([options.weft, "mesh", "box", "--cells", str(cells), "-o", box, "--quiet"], check=True)
    words = [options.weft, "adapt", box, "--metric-fn", f"uniform:{1 / cells}", "--subdomains", str(options.subdomains * ranks),
             "--balancer", balancer, "--threads", "1", "-o", folder / "out.meshb", "--report", folder / "report", "--quiet", "--force"]
    launcher = [*MPIRUN, str(ranks)] if real else []
    words += [] if real else ["--simulate-ranks", str(ranks)]
    done = subprocess.run([*launcher, *map(str, words)], capture_output=True, text=True)
    if done.returncode not in (0, 1):
        sys.exit(f"messages: {ranks} ranks: {done.stderr[-2000:]}")
    return json.loads((folder / "report/report.json").read_text())["subdomains"]["exchanged_by_rank"]


def line(name, exchanged):
    cells = (f"{x['messages']:.0f} to {x['peers']:.1f} | {x['most_messages']} to {x['most_peers']}" for x in map(exchanged.get, PHASES))
    print(f"| {name} | {' | '.join(cells)} |", flush=True)


def plot(path, curves):
    """Of each phase, messages and peers (means) against ranks."""
    import matplotlib
    matplotlib.use("svg")
    matplotlib.rcParams.update({"svg.hashsalt": "weft", "font.size": 9})
    from matplotlib import pyplot
    figure, axes = pyplot.subplots(1, 2, figsize=(9, 3.2), constrained_layout=True)
    for axis, what in zip(axes, ("messages", "peers")):
        for name, points in curves.items():
            ranks = sorted(points)
            axis.plot(ranks, [points[r][what] for r in ranks], marker="o", markersize=3, label=name)
        axis.set(xscale="log", xlabel="ranks", ylabel=f"{what} of a rank, mean", ylim=(0, None))
        axis.set_xscale("log", base=2)
        axis.grid(alpha=0.3)
    axes[1].set_yscale("symlog", linthresh=32)
    axes[1].legend(fontsize=7)
    figure.savefig(path, metadata={"Date": None})


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--weft", default=ROOT / "build/bin/weft", type=pathlib.Path)
    parser.add_argument("--ranks", nargs="*", type=int, default=[8, 16, 32, 64, 128, 256])
    parser.add_argument("--real", nargs="*", type=int, default=[8, 16])
    parser.add_argument("--balancers", nargs="*", default=["none", "stealing", "diffusion"])
    parser.add_argument("--tets", type=int, default=780, help="of the input on each rank (default 780)")
    parser.add_argument("--subdomains", type=int, default=4, help="of each rank (default 4)")
    parser.add_argument("--plot", type=pathlib.Path, help="a picture, .svg")
    options = parser.parse_args()
    options.weft = options.weft.resolve()
    print("| ranks | " + " | ".join(f"{name}, mean | most" for name in PHASES.values()) + " |\n|---" + "|---" * 6 + "|")
    curves = {}
    with tempfile.TemporaryDirectory(prefix="weft-messages-") as name:
        folder = pathlib.Path(name)
        for balancer in options.balancers:
            for ranks in options.ranks:
                exchanged = run(options, folder, ranks, balancer, False)
                line(f"{ranks}, {balancer}", exchanged)
                curves.setdefault(f"in the loop, {balancer}", {})[ranks] = exchanged["in_loop"]
                for phase in ("before_loop", "after_loop"):
                    curves.setdefault(f"{PHASES[phase]} it", {})[ranks] = exchanged[phase]
        for ranks in options.real:
            line(f"{ranks} real, {options.balancers[0]}", run(options, folder, ranks, options.balancers[0], True))
    if options.plot:
        plot(options.plot, curves)


if __name__ == "__main__":
    main()
