#!/usr/bin/env python3
"""Regenerates the paper's figures with weft: runs it, draws SVG, and writes one index of all with what was found.

The delta wing's start mesh and solution come from the folder --cases; without it the figures of numbers are of a cube's
shock layer, and the pictures of a wing that weft meshes itself. --quick: a small cube and few runs, in minutes."""

import argparse
import html
import json
import os
import pathlib
import shutil
import sys

import interface_shift
from drawing import plot, shares, table
from interface_shift import shifts_made
from published import efficiency_curves, histogram_curves
from recordings import ROOT, Recording, Recordings

ADAPTATION = ("interior adaptation", "MII adaptation", "interface refinement", "help")  # as report.json's share_beside_adaptation counts
NETWORKS = {"2 us, 10 GB/s": "2us,10GB/s", "50 us, 1 GB/s": "50us,1GB/s"}
CORES_HERE = len(os.sched_getaffinity(0))


class Case:
    """A mesh and what it is adapted to."""

    def __init__(self, name, mesh, metric, complexity, published=None):
        self.name, self.mesh, self.metric, self.complexity, self.published = name, mesh, metric, complexity, published

    def words(self):
        return [self.mesh, *self.metric, "--complexity", self.complexity]


class Sizes:
    """How much is run."""

    def __init__(self, quick):
        self.subdomains = 8 if quick else 128  # the paper's
        self.shifts = (0, 1, 2, 6) if quick else (0, 1, 2, 3, 4, 6, 9, 12)
        self.layers = (1, 2, 5) if quick else (1, 2, 3, 5, 10)
        self.breakdown = (4, 16, 64) if quick else (16, 32, 64, 128, 256)  # cores and subdomains, simulated
        self.recorded = 64 if quick else 1024  # subdomains of time against cores
        self.cores = (1, 2, 4, 16, 64) if quick else (1, 2, 4, 8, 16, 64, 128, 256, 512, 1024)


class Book(Recordings):
    """Runs weft, keeps what it leaves, collects figures."""

    def __init__(self, options):
        super().__init__(options)
        self.figures, self.missing = [], []
        self.load = os.getloadavg()[0]

    def call(self, *words, allowed=(0,)):
        return self.run(self.command(*words), allowed)

    def adapt(self, case, name, *words, ranks=1, result=None):
        """Adapts, with a report; a missed goal still gives a mesh. Returns the report."""
        on_ranks = self.mpirun(ranks) if ranks > 1 else []
        self.run([*on_ranks, *self.command("adapt", *case.words(), "-o", result or f"{name}.meshb", "--report", name, "--quiet", *words)], (0, 1))
        return json.loads((self.folder / name / "report.json").read_text())

    def picture(self, name, mesh, *words):
        self.call("view", mesh, "-o", f"{name}.png", "--size", "800x600", "--quiet", *words)
        return f'<a href="{name}.png"><img src="{name}.png"></a>\n'

    def add(self, title, paper, found, *bodies):
        self.figures.append((title, paper, found, "".join(bodies)))
        self.say(title)

    def write(self, case, sizes, quick):
        parts = [f"<h2>{html.escape(title)}</h2><p><b>The paper:</b> {html.escape(paper)}<br><b>weft:</b> {html.escape(found)}</p>{body}"
                 for title, paper, found, body in self.figures]
        missing = "".join(f"<li>{html.escape(m)}</li>" for m in self.missing)
        note = "<p><b>Quick: a small mesh in place of the paper's; shapes of curves compare, figures do not.</b></p>" if quick else ""
        page = (f"<!doctype html><meta charset=utf-8><title>The paper by weft</title><style>body{{font-family:sans-serif;max-width:72em;"
                f"margin:2em auto}}table{{border-collapse:collapse}}td,th{{padding:.2em .8em;text-align:right;border-bottom:1px solid #ccc}}td{{white-space:nowrap}}"
                f"img{{width:32%}}</style><h1>The paper's figures by weft</h1><p>Where no other is named: {html.escape(case.name)}, complexity "
                f"{case.complexity:,}, {sizes.subdomains} subdomains. {CORES_HERE} cores; load average at the beginning {self.load:.1f}: times of a "
                f"machine that has other work mean little.</p>{note}{''.join(parts)}<h2>Not here</h2><ul>{missing}</ul>")
        path = self.folder / "index.html"
        path.write_text(page)
        return path


# --- Histograms

def without(all_of_it, part):
    """The histogram of what is in the first and not in the second, which is a part of it."""
    counts = [a - b for a, b in zip(all_of_it["counts"], part["counts"], strict=True)]
    rest = {**all_of_it, "counts": counts, **{end: all_of_it[end] - part[end] for end in ("below", "above")}}
    if min(counts) < 0 or rest["below"] < 0 or rest["above"] < 0:
        raise ValueError("the histogram of a part has more than that of the whole")
    return rest


def size_of(histogram):
    return sum(histogram["counts"]) + histogram["below"] + histogram["above"]


def density(histogram):
    """Points of the density of values: the area under them is 1, as in the published curves."""
    counts, lo, hi = histogram["counts"], histogram["lo"], histogram["hi"]
    total = size_of(histogram)
    ends = [lo + (hi - lo) * i / len(counts) for i in range(len(counts) + 1)]
    if histogram["logarithmic"]:
        ends = [10 ** e for e in ends]
    return [((a + b) / 2, n / total / (b - a)) for a, b, n in zip(ends, ends[1:], counts)] if total else []


def difference(one, other):
    """The share that would have to move to other bins to make the second histogram of the first."""
    bins = [[h["below"], *h["counts"], h["above"]] for h in (one, other)]
    a, b = (max(1, sum(counts)) for counts in bins)
    return sum(abs(x / a - y / b) for x, y in zip(*bins, strict=True)) / 2


MEASURES = (("quality", "mean_ratio", "Mean ratio (fig. MR)", "mean ratio", "tets"),
            ("edge_length", "edge_length", "Edge lengths (fig. EL)", "length in the metric", "edges"))


def both_scales(title, label, curves):
    return plot(f"{title}, linear", label, "density", curves) + plot(f"{title}, logarithmic", label, "density", curves, log_y=True)


def curve(histogram):
    return density(histogram), False, False


def by_place(book, case, sizes, serial):
    """One mesh, the interior and the interface of a run in subdomains, and others' curves."""
    run = book.adapt(case, "run", "--subdomains", sizes.subdomains, "--threads", 1)
    for key, measure, title, label, things in MEASURES:
        one, whole, interface = (m[key]["histogram"] for m in (serial["after"], run["after"], run["subdomains"]["former_interface"]))
        interior = without(whole, interface)
        curves = {"weft, one mesh": curve(one), f"weft, {sizes.subdomains} subdomains, interior": curve(interior),
                  f"weft, {sizes.subdomains} subdomains, former interface": curve(interface), **histogram_curves(case.published, measure, one["hi"])}
        book.add(title, "The histogram of 128 subdomains comes near that of the shared memory code.",
                 f"of {size_of(whole):,} {things} {size_of(interface):,} are where the interface was; {100 * difference(interface, one):.1f} % of these and "
                 f"{100 * difference(interior, one):.1f} % of the interior's would have to move to other bins to be distributed as in one mesh", both_scales(title, label, curves))


def as_the_paper_runs(book, case, sizes, serial):
    """Slabs across x, frozen tets, 5 layers, 6 and 12 shifts; and 10 layers."""
    runs = {}
    for shifts, layers in ((6, 5), (12, 5), (12, 10)):
        runs[f"{shifts} shifts, {layers} layers"] = book.adapt(
            case, f"slabs-{shifts}-{layers}", "--subdomains", sizes.subdomains, "--partitioner", f"pqr:{sizes.subdomains}x1x1", "--freeze", "tets",
            "--no-interface-refinement", "--layers", layers, "--shifts", shifts, "--threads", 1)
    for key, _, title, label, things in MEASURES:
        one = serial["after"][key]["histogram"]
        curves, found = {"one mesh": curve(one)}, []
        for name, run in runs.items():
            whole, interface = run["after"][key]["histogram"], run["subdomains"]["former_interface"][key]["histogram"]
            curves[name] = curve(whole)
            curves[f"{name}, former interface"] = density(interface), True, False
            found.append(f"{name}: {100 * difference(whole, one):.1f} % ({shifts_made(run)} shifts made)")
        title = f"{title}, 6 against 12 iterations, slabs across x"
        book.add(title, "With 12 iterations the mesh exhibits good overall quality, similar to that of the shared memory code; 5 layers, 10 from adapted subdomains.",
                 f"what would have to move of all {things} to be distributed as in one mesh: {'; '.join(found)}", both_scales(title, label, curves))


# --- Where the time goes

def percentages(seconds):
    """Of the busy time, by operation."""
    busy = {name: s for name, s in seconds.items() if name != "idle"}
    whole = sum(busy.values())
    return {name: 100 * s / whole for name, s in busy.items()}


def idle_share(seconds):
    """Of the time of all workers; that of the communication threads is not theirs."""
    return seconds["idle"] / (sum(seconds.values()) - seconds["communication"])


def breakdown(book, case, sizes):
    """As many subdomains as cores, as in the paper: real ranks on the cores that there are, simulated ranks beyond."""
    bars, rows = {}, []
    for cores in dict.fromkeys([*cores_to_measure(CORES_HERE), *sizes.breakdown]):
        if cores < 2 or (cores <= CORES_HERE and not shutil.which("mpirun")):
            continue
        simulated = [] if cores <= CORES_HERE else ["--simulate-ranks", cores, "--simulate-network", NETWORKS["2 us, 10 GB/s"]]
        report = book.adapt(case, f"breakdown-{cores}", "--subdomains", cores, "--threads", 1, *simulated, ranks=1 if simulated else cores)
        account = report["subdomains"]
        seconds, how = account["seconds_by_operation"], "simulated" if simulated else "measured"
        bars[f"{cores} cores, {how}"] = {name: s for name, s in seconds.items() if name != "idle"}
        share = percentages(seconds)
        rows.append((cores, how, f"{account['decomposition_seconds']:.2g}", f"{account['adaptation_seconds']:.3g}",
                     f"{100 * account['share_beside_adaptation']:.1f} %", f"{share['interior adaptation']:.1f} %", f"{share['MII adaptation']:.1f} %",
                     f"{share['communication']:.1f} %", f"{100 * idle_share(seconds):.1f} %"))
    names = [name for name in seconds if any(bar.get(name) for bar in bars.values())]
    names.sort(key=lambda name: (name not in ADAPTATION, name != "communication"))
    shown = [f"{cores} cores ({how}) {beside}" for cores, how, _, _, beside, *_ in rows]
    book.add("Percentage breakdown by number of cores (fig. percentage breakdown)",
             "With as many subdomains as cores, all but the adaptation takes less than 15 % of the time on average, about 5 % on the largest numbers; "
             "MII adaptation takes much of the rest; decomposition takes about 1 s.",
             f"not adaptation: {', '.join(shown)}",
             shares("Shares of the time that cores are busy", names, bars),
             table(("cores = subdomains", "", "decomposition s", "loop s", "not adaptation", "interior", "MII", "communication thread", "idle, of workers"), rows))


def cores_to_measure(here):
    """1, 2, 4 and so on, and all."""
    return sorted({2 ** i for i in range(here.bit_length()) if 2 ** i <= here} | {here})


def scaling(book, case, sizes):
    """The loop, from the first task's begin to the last one's end: measured with real ranks, and replayed from the recording on one."""
    book.adapt(case, "recorded", "--subdomains", sizes.recorded, "--threads", 1)
    recording = Recording(book.folder / "recorded", bool(book.processor_times))
    measured = [(1, recording.loop)]
    for cores in cores_to_measure(CORES_HERE)[1:] if shutil.which("mpirun") else []:
        book.adapt(case, f"on-{cores}", "--subdomains", sizes.recorded, "--threads", 1, ranks=cores)
        measured.append((cores, Recording(book.folder / f"on-{cores}", False).loop))
    rows = [("measured", n, f"{s:.3g}", f"{100 * measured[0][1] / (n * s):.1f} %", "", "", "", "") for n, s in measured]
    curves, found = {"measured": (measured, False, True)}, []
    efficiency = {"weft, measured": ([(n, measured[0][1] / (n * s)) for n, s in measured], False, True)}
    for words, network in NETWORKS.items():
        replays = [(n, book.replay("recorded", n, network)) for n in sizes.cores]
        rows += [(f"simulated, {words}", n, f"{r['seconds']:.3g}", f"{100 * r['efficiency']:.1f} %", f"{100 * r['idle_share']:.0f} %",
                  f"{r['critical_path_seconds']:.3g}", r["packets"]["packets"], r["migrations"]["messages"]) for n, r in replays]
        curves[f"simulated, {words}"] = ([(n, r["seconds"]) for n, r in replays], True, True)
        efficiency[f"weft, simulated, {words}"] = ([(n, r["efficiency"]) for n, r in replays], True, True)
        found.append(f"{100 * replays[-1][1]['efficiency']:.0f} % on {replays[-1][0]} cores with {words}")
    times = ", ".join(f"{s:.3g} s on {n}" for n, s in measured)
    book.add("Time against cores", "Scaling is left to the final manuscript; others have published efficiencies.",
             f"measured {times}; efficiency simulated (weft replay) from the recording on one core, {sizes.recorded} subdomains: {', '.join(found)}",
             plot("The adaptation's loop", "cores", "seconds", curves, log_x=True, log_y=True),
             plot("Efficiency against one core", "cores", "efficiency", {**efficiency, **efficiency_curves()}, log_x=True),
             table(("", "cores", "loop s", "efficiency", "idle", "critical path s", "packets", "migrations"), rows))


# --- Shifts and layers

def quality_row(report):
    q, former = report["after"]["quality"], report["subdomains"]["former_interface"]["quality"]
    return [f"{v:.3f}" for v in (q["mean"], q["quantile_0.01"], q["min"], former["mean"], former["quantile_0.01"])]


QUALITY_HEAD = ("Q mean", "Q 1 %", "Q min", "interface mean", "interface 1 %")


def shifts(book, case, sizes):
    reports = {n: book.adapt(case, f"shifts-{n}", "--subdomains", sizes.subdomains, "--threads", 1, "--shifts", n) for n in sizes.shifts}
    former = [(n, r["subdomains"]["former_interface"]["quality"]) for n, r in reports.items()]
    found = "; ".join(f"at most {n} shifts {q['mean']:.3f}, {100 * q['share_below_0.2']:.2g} % below 0.2" for n, q in former)
    book.add("Shifts against quality", "Several iterations of shift and adaptation are needed; with 12 the quality is similar to that of the shared memory code.",
             f"mean of Q where the interface was: {found}",
             plot("Quality where the interface was", "shifts at most", "mean ratio",
                  {"mean": ([(n, q["mean"]) for n, q in former], False, True), "1 %": ([(n, q["quantile_0.01"]) for n, q in former], False, True)}),
             table(("shifts at most", "shifts made", *QUALITY_HEAD), [(n, shifts_made(r), *quality_row(r)) for n, r in reports.items()]))


def layers(book, case, sizes):
    reports = {n: book.adapt(case, f"layers-{n}", "--subdomains", sizes.subdomains, "--threads", 1, "--layers", n) for n in sizes.layers}
    moved = {n: sum(s["tets_moved"] for s in r["subdomains"]["shifts"]) for n, r in reports.items()}
    first, last = sizes.layers[0], sizes.layers[-1]
    low = {n: r["after"]["quality"]["quantile_0.01"] for n, r in reports.items()}
    best = max(low, key=low.get)
    book.add("Layers", "5 layers, 10 from subdomains that have been adapted; which numbers are best is being investigated.",
             f"{last} layers hand over {moved[last] / max(1, moved[first]):.1f} times the tets of {first}; Q 1 % from {min(low.values()):.3f} to {low[best]:.3f}, the highest with {best}",
             table(("layers", *QUALITY_HEAD, "shifts made", "tets handed over"),
                   [(n, *quality_row(r), shifts_made(r), f"{moved[n]:,}") for n, r in reports.items()]))


# --- Pictures

def delta_wing(book, case):
    report = book.adapt(case, "wing", "--threads", CORES_HERE)
    after, edges = report["after"], report["after"]["edge_length"]
    book.add("The adapted delta wing (fig. delta wing)", "A delta wing with a multiscale metric of a laminar flow, complexity 50,000; about 2 vertices and 12 tets a unit of complexity.",
             f"{case.name}, complexity {after['complexity']:,.0f} of {case.complexity:,}: {after['vertices'] / after['complexity']:.2f} vertices and "
             f"{after['tets'] / after['complexity']:.1f} tets a unit of it, {100 * edges['share_unit']:.1f} % of the edges unit, Q mean {after['quality']['mean']:.3f}",
             book.picture("wing-surface", "wing.meshb", "--only", "1,2,3,4", "--from", "-60,35", "--title", "the wing's surface"),
             book.picture("wing-symmetry", "wing.meshb", "--from", "-y", "--focus", "-0.4,0,-0.5,1.6,1,0.5", "--title", "symmetry plane"),
             book.picture("wing-cut", "wing.meshb", "--clip", "x=0.9", "--from", "x", "--focus", "0.8,0,-0.3,0.9,0.5,0.3", "--title", "cut at x = 0.9"))


# --- All of it

def start_of(cases):
    """The delta wing's start mesh and solution, where they are at hand."""
    if not cases:
        return None
    folder = pathlib.Path(cases).resolve() / "delta-wing"
    found = sorted(folder.glob("*start*.meshb")), sorted(folder.glob("*start*mach*.solb"))
    return (found[0][0], found[1][0]) if all(found) else None


def wings(book, start, quick):
    """The wing of its picture, and that of the interface shift: a mesh that must become finer, as an interface that fits already shows nothing."""
    coarse, fine = (2000, 10000) if quick else (10000, 50000)
    if start:
        name, mesh, metric, complexity = "delta wing", start[0], ["--sol", start[1]], 50000
        of_shift = [*metric, "--background", mesh]
    else:
        name, mesh, metric, complexity = "delta wing with the sizes of an initial mesh, isotropic", "wing-initial.meshb", ["--implied"], fine
        of_shift = metric
        book.call("mesh", "delta-wing", "--size", 0.05, "-o", mesh, "--quiet")
    book.call("adapt", mesh, *metric, "--complexity", coarse, "-o", "wing-start.meshb", "--threads", 1, "--quiet", allowed=(0, 1))
    return Case(name, mesh, metric, complexity), Case(name, "wing-start.meshb", of_shift, fine)


def numbers(book, options, start):
    """What the figures of numbers are of."""
    if options.start:
        return Case(book.case, book.start_mesh(options.complexity), book.metric, options.complexity)
    if start and not options.quick:
        return Case("delta wing", start[0], ["--sol", start[1]], options.complexity, "delta-wing-500000")
    return Case("cube, polar-2", book.start_mesh(options.complexity), book.metric, options.complexity, "cube-polar2-500000")


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    Recordings.add_options(parser, "paper", None)
    parser.add_argument("--cases", default=os.environ.get("WEFT_CASES"), help="folder with delta-wing/ (default: WEFT_CASES)")
    parser.add_argument("--quick", action="store_true", help="a small cube (complexity 8,000 in place of 500,000), fewer runs")
    options = parser.parse_args()
    options.complexity = options.complexity or (8000 if options.quick else 500000)
    return options


def main():
    options = parse()
    book, sizes, start = Book(options), Sizes(options.quick), start_of(options.cases)
    wing, shifted = wings(book, start, options.quick)
    case = numbers(book, options, start)
    delta_wing(book, wing)
    found, body = interface_shift.sequence(book, shifted)
    book.add("The interface shift in pictures (fig. interface shift)",
             "Red elements do not conform, as they are affected by the frozen interface; the shift hands them over with layers around them, and they are adapted.",
             f"{shifted.name}, complexity {shifted.complexity:,}, 2 subdomains: {found}", body)
    serial = book.adapt(case, "serial", "--threads", 1)
    by_place(book, case, sizes, serial)
    as_the_paper_runs(book, case, sizes, serial)
    breakdown(book, case, sizes)
    scaling(book, case, sizes)
    shifts(book, case, sizes)
    layers(book, case, sizes)
    book.missing += left_out(options, start)
    print(f"paper: {book.write(case, sizes, options.quick)}")


def left_out(options, start):
    yield "fig. CDT3D pipelines, isotropic and anisotropic, and the high-level algorithm: drawings of programs; weft's own graph is `weft graph recorded/graph.json --plan`"
    yield "5 layers from subdomains that have not been adapted beside 10 from those that have: weft takes one number for all that hand over, so that both are run"
    if options.complexity < 5000000:
        yield f"the breakdown at complexity 5,000,000, which is here at {options.complexity:,}: a run has 60 million tets, and every number of cores needs one; --complexity 5000000 does it"
    if options.quick or not start:
        yield "the delta wing's numbers: " + ("in the whole run" if start else "its start mesh comes from --cases or WEFT_CASES") + (", not with --quick" if options.quick else "")
    if not shutil.which("mpirun"):
        yield "what is measured on several cores: there is no mpirun"


if __name__ == "__main__":
    sys.exit(main())
