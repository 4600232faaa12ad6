#!/usr/bin/env python3
"""Regenerates the paper's figures with weft: runs it, draws SVG, and writes one index of all with what was found."""

import argparse
import csv
import html
import json
import math
import os
import pathlib
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
COLOURS = "#2f6fb0 #e07b16 #2f9e77 #b0529c #7aa52b #2aa3bd #c4a000 #8d6e63 #8795a5 #9cc3ea #d4d9e0".split()
WIDTH, HEIGHT, LEFT, BOTTOM = 640, 360, 64, 48
# Efficiencies against one core that others have published, by cores (docs of the UGAWG's parallel cases).
PUBLISHED_EFFICIENCY = {
    "refine, cube": {40: 0.64, 400: 0.23}, "refine, wing": {40: 0.87, 400: 0.49}, "CDT3D": {16: 0.66, 40: 0.59},
    "EPIC": {256: 0.29}, "feflo.a": {16: 0.21},
}


class Case:
    """What is adapted: the wing of the paper where its start mesh is at hand, else the cube's shock layer."""

    def __init__(self, options, folder):
        self.quick = options.quick
        wing = pathlib.Path(options.cases, "delta-wing") if options.cases else None
        start = sorted(wing.glob("*start*.meshb")) if wing else []
        solution = sorted(wing.glob("*start*mach*.solb")) if wing else []
        self.wing = bool(start and solution)
        self.subdomains = 16 if options.quick else 128
        self.complexity = options.complexity or (3000 if options.quick else 500000)
        if self.wing and not options.quick:
            self.name, self.published = "delta wing", "delta-wing-500000"
            self.mesh, self.metric = start[0], ["--sol", solution[0]]
        else:
            self.name, self.published = "cube, polar-2", "cube-polar2-500000"
            self.mesh, self.metric = folder / "start.meshb", ["--metric-fn", "polar-2"]

    def words(self):
        return [self.mesh, *self.metric, "--complexity", self.complexity]


class Figure:
    def __init__(self, title, paper, found, body):
        self.title, self.paper, self.found, self.body = title, paper, found, body


class Book:
    """Runs weft, keeps what it leaves, collects figures."""

    def __init__(self, options):
        self.weft, self.folder = pathlib.Path(options.weft).resolve(), pathlib.Path(options.out).resolve()
        self.folder.mkdir(parents=True, exist_ok=True)
        self.figures, self.missing, self.begin = [], [], time.monotonic()

    def run(self, *words, allowed=(0,)):
        command = [str(self.weft), *map(str, words)]
        done = subprocess.run(command, capture_output=True, text=True, cwd=self.folder)
        if done.returncode not in allowed:
            sys.exit(f"paper: {' '.join(command)} has ended with {done.returncode}:\n{done.stderr}")
        return done.stdout

    def adapt(self, case, name, *words):
        """Adapts, with a report; a missed goal still gives a mesh. Returns the report."""
        self.run("adapt", *case.words(), "-o", f"{name}.meshb", "--report", name, "--quiet", *words, allowed=(0, 1))
        return json.loads((self.folder / name / "report.json").read_text())

    def add(self, title, paper, found, *bodies):
        self.figures.append(Figure(title, paper, found, "".join(bodies)))
        print(f"paper: {title} ({time.monotonic() - self.begin:.0f} s)", flush=True)

    def write(self, case):
        parts = [f"<h2>{html.escape(f.title)}</h2><p><b>The paper:</b> {html.escape(f.paper)}<br><b>weft:</b> "
                 f"{html.escape(f.found)}</p>{f.body}" for f in self.figures]
        missing = "".join(f"<li>{html.escape(m)}</li>" for m in self.missing)
        quick = "<p><b>Quick: a small mesh in place of the paper's; shapes of curves compare, figures do not.</b></p>" if case.quick else ""
        page = (f"<!doctype html><meta charset=utf-8><title>The paper by weft</title><style>body{{font-family:sans-serif;max-width:70em;"
                f"margin:2em auto}}table{{border-collapse:collapse}}td,th{{padding:.2em .8em;text-align:right;border-bottom:1px solid #ccc}}"
                f"img{{max-width:32%}}</style><h1>The paper's figures by weft</h1><p>Case: {case.name}, complexity {case.complexity:,}, "
                f"{case.subdomains} subdomains.</p>{quick}{''.join(parts)}<h2>Not here</h2><ul>{missing}</ul>")
        path = self.folder / "index.html"
        path.write_text(page)
        return path


# --- Drawing

def ticks(low, high, logarithmic):
    if logarithmic:
        return [10.0 ** e for e in range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1) if low <= 10.0 ** e <= high]
    step = 10 ** math.floor(math.log10((high - low) or 1))
    step = next(s for s in (step / 5, step / 2, step, 2 * step) if (high - low) / s <= 10)
    return [step * i for i in range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1)]


def plot(title, x_label, y_label, series, log_x=False, log_y=False):
    """series: name -> (points, dashed, marks)."""
    points = [p for pts, _, _ in series.values() for p in pts if (p[0] > 0 or not log_x) and (p[1] > 0 or not log_y)]
    if not points:
        return ""
    (x0, x1), (y0, y1) = ((min(c), max(c)) for c in zip(*points))
    if not log_y:
        y0 = min(0, y0)
    x1, y1 = x1 if x1 > x0 else x0 + 1, y1 if y1 > y0 else y0 + 1

    def place(value, low, high, logarithmic, length):
        if logarithmic:
            value, low, high = math.log(value), math.log(low), math.log(high)
        return length * (value - low) / (high - low)

    def at(x, y):
        return LEFT + place(x, x0, x1, log_x, WIDTH - LEFT - 10), HEIGHT - BOTTOM - place(y, y0, y1, log_y, HEIGHT - BOTTOM - 30)

    out = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{HEIGHT}" font-family="sans-serif" font-size="11">',
           f'<text x="{WIDTH / 2}" y="16" text-anchor="middle" font-size="13">{html.escape(title)}</text>']
    for x in ticks(x0, x1, log_x):
        out.append(f'<text x="{at(x, y0)[0]:.1f}" y="{HEIGHT - BOTTOM + 15}" text-anchor="middle">{x:g}</text>')
    for y in ticks(y0, y1, log_y):
        px = at(x0, y)[1]
        out.append(f'<line x1="{LEFT}" x2="{WIDTH - 10}" y1="{px:.1f}" y2="{px:.1f}" stroke="#ddd"/><text x="{LEFT - 4}" y="{px + 4:.1f}" text-anchor="end">{y:g}</text>')
    for index, (name, (pts, dashed, marks)) in enumerate(series.items()):
        colour = COLOURS[index % len(COLOURS)]
        shown = [at(*p) for p in pts if (p[0] > 0 or not log_x) and (p[1] > 0 or not log_y)]
        line = " ".join(f"{x:.1f},{y:.1f}" for x, y in shown)
        out.append(f'<polyline points="{line}" fill="none" stroke="{colour}" stroke-width="1.5"{" stroke-dasharray=5,4" if dashed else ""}/>')
        if marks:
            out += [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3" fill="{colour}"/>' for x, y in shown]
        out.append(f'<text x="{WIDTH - 180}" y="{34 + 14 * index}" fill="{colour}">{"- - " if dashed else "&#8212; "}{html.escape(name)}</text>')
    out.append(f'<text x="{WIDTH / 2}" y="{HEIGHT - 12}" text-anchor="middle">{html.escape(x_label)}</text>'
               f'<text x="12" y="{HEIGHT / 2}" transform="rotate(-90 12 {HEIGHT / 2})" text-anchor="middle">{html.escape(y_label)}</text></svg>')
    return "\n".join(out)


def table(head, rows):
    cells = lambda row, tag: "<tr>" + "".join(f"<{tag}>{html.escape(str(c))}</{tag}>" for c in row) + "</tr>"
    return "<table>" + cells(head, "th") + "".join(cells(r, "td") for r in rows) + "</table>"


def density(histogram):
    """Points of the density of values: the area under them is 1, as in the published curves."""
    counts, lo, hi = histogram["counts"], histogram["lo"], histogram["hi"]
    total = sum(counts) + histogram["below"] + histogram["above"]
    ends = [lo + (hi - lo) * i / len(counts) for i in range(len(counts) + 1)]
    if histogram["logarithmic"]:
        ends = [10 ** e for e in ends]
    return [((a + b) / 2, n / total / (b - a)) for a, b, n in zip(ends, ends[1:], counts)] if total else []


def published_curves(case_name, measure):
    curves = {}
    with open(ROOT / "tools/report/published_curves.csv", newline="") as file:
        for row in csv.DictReader(line for line in file if not line.startswith("#")):
            if row["case"] != case_name or row["measure"] != measure:
                continue
            ends, values = ([float(v) for v in row[k].split()] for k in ("bin edges", "densities"))
            curves[f"{row['program']}, {row['cores']} cores"] = ([((a + b) / 2, v) for a, b, v in zip(ends, ends[1:], values)], True, False)
    return curves


# --- The figures

def histograms(book, case, serial, run):
    former = run["subdomains"]["former_interface"]
    for key, measure, title, label in (("quality", "mean_ratio", "Mean ratio (fig. MR)", "mean ratio"),
                                       ("edge_length", "edge_length", "Edge lengths (fig. EL)", "length in the metric")):
        mine = {"weft, one mesh": (density(serial["after"][key]["histogram"]), False, False),
                f"weft, {case.subdomains} subdomains": (density(run["after"][key]["histogram"]), False, False),
                "weft, where the interface was": (density(former[key]["histogram"]), False, False)}
        curves = {**mine, **published_curves(case.published, measure)}
        name = "share_unit" if key == "edge_length" else "quantile_0.01"
        figures = [(w, m[key]["mean"], m[key][name]) for w, m in (("one mesh", serial["after"]), ("subdomains", run["after"]), ("where the interface was", former))]
        found = "; ".join(f"{w}: mean {mean:.3f}, {'unit' if key == 'edge_length' else '1 %'} {x:.3f}" for w, mean, x in figures)
        book.add(title, "12 shifts bring the histogram of 128 subdomains near that of one mesh; poor tets are left at the interface.",
                 found, plot(f"{title}, linear", label, "density", curves), plot(f"{title}, logarithmic", label, "density", curves, log_y=True))


def breakdown(book, name):
    profile = json.loads((book.folder / name / "profile.json").read_text())
    (book.folder / "breakdown.svg").write_text(subprocess.run(
        [sys.executable, "-B", ROOT / "tools/report/breakdown.py", book.folder / name / "profile.json"], check=True, capture_output=True, text=True).stdout)
    seconds = profile["total"]["seconds"]
    total = sum(seconds.values())
    book.add("Where the time goes (fig. percentage breakdown)",
             "Adaptation of the shifted regions takes most of the time, more than that of the interiors; communication a small share.",
             ", ".join(f"{k} {100 * v / total:.1f} %" for k, v in sorted(seconds.items(), key=lambda e: -e[1])[:4]),
             '<object data="breakdown.svg" type="image/svg+xml"></object>')


def shifts(book, case, most):
    rows, mean, low = [], [], []
    for n in most:
        report = book.adapt(case, f"shifts-{n}", "--subdomains", case.subdomains, "--threads", 1, "--shifts", n)
        q, former = report["after"]["quality"], report["subdomains"]["former_interface"]["quality"]
        rows.append((n, f"{q['mean']:.3f}", f"{q['quantile_0.01']:.3f}", f"{q['min']:.3f}", f"{former['mean']:.3f}", f"{former['quantile_0.01']:.3f}"))
        mean.append((n, former["mean"])), low.append((n, former["quantile_0.01"]))
    book.add("Shifts against quality", "6 against 12 iterations of shift and adaptation: the second half still removes poor tets at the interface.",
             f"mean of Q where the interface was {mean[0][1]:.3f} with at most {most[0]} shifts, {mean[-1][1]:.3f} with {most[-1]}",
             plot("Quality where the interface was", "shifts at most", "mean ratio", {"mean": (mean, False, True), "1 %": (low, False, True)}),
             table(("shifts at most", "Q mean", "Q 1 %", "Q min", "interface mean", "interface 1 %"), rows))
    pictures = []
    for n in most:
        picture = f"shift-{n}.png"
        book.run("view", f"shifts-{n}.meshb", "--metric", f"shifts-{n}.solb", "-o", picture, "--color-by", "nonconforming", "--clip",
                 "z=0.5" if not case.wing else "y=0.1", "--size", "800x600", "--title", f"at most {n} shifts")
        pictures.append(f'<img src="{picture}">')
    book.add("The interface shift in pictures (fig. interface shift)", "Edges that do not conform lie along the frozen interface, and go as it is shifted.",
             "cut through the mesh after at most so many shifts; what does not conform is coloured", *pictures)


def layers(book, case, depths):
    rows = []
    for n in depths:
        report = book.adapt(case, f"layers-{n}", "--subdomains", case.subdomains, "--threads", 1, "--layers", n)
        q, s = report["after"]["quality"], report["subdomains"]
        rows.append((n, f"{q['mean']:.3f}", f"{q['quantile_0.01']:.3f}", f"{q['min']:.3f}", len(s["shifts"]), sum(t["tets_moved"] for t in s["shifts"])))
    book.add("Layers", "5 layers in the first shifts, 10 from subdomains that have been adapted; the best number is left open.",
             f"Q 1 % from {min(r[2] for r in rows)} to {max(r[2] for r in rows)}; more layers move more tets",
             table(("layers", "Q mean", "Q 1 %", "Q min", "shifts", "tets moved"), rows))


def scaling(book, case, run, cores):
    measured = [(1, run["subdomains"]["adaptation_seconds"])]
    two = book.adapt(case, "two", "--subdomains", case.subdomains, "--threads", 2)
    measured.append((2, two["subdomains"]["adaptation_seconds"]))
    rows, curves, efficiency = [], {"measured": (measured, False, True)}, {}
    for words, network in (("2 us, 10 GB/s", "2us,10GB/s"), ("50 us, 1 GB/s", "50us,1GB/s")):
        times, shares = [], []
        for n in cores:
            book.run("replay", "run/graph.json", "--ranks", n, "--network", network, "--report", "replayed", "--quiet")
            replay = json.loads((book.folder / "replayed/replay.json").read_text())
            times.append((n, replay["seconds"])), shares.append((n, replay["efficiency"]))
            rows.append((words, n, f"{replay['seconds']:.3g}", f"{100 * replay['efficiency']:.1f} %", f"{100 * replay['idle_share']:.0f} %",
                         f"{replay['critical_path_seconds']:.3g}", replay["packets"]["packets"], replay["migrations"]["messages"]))
        curves[f"simulated, {words}"] = (times, True, True)
        efficiency[f"weft, simulated, {words}"] = (shares, True, True)
    for name, points in PUBLISHED_EFFICIENCY.items():
        efficiency[name] = (sorted(points.items()), False, True)
    book.add("Time against cores", "Scaling is left to the final manuscript; others have published efficiencies.",
             f"measured {measured[0][1]:.3g} s on one core and {measured[1][1]:.3g} s on two; dashed lines are simulated (weft replay) from the recording on one core",
             plot("The adaptation's loop", "cores", "seconds", curves, log_x=True, log_y=True),
             plot("Efficiency against one core", "cores", "efficiency", efficiency, log_x=True),
             table(("network", "cores", "seconds", "efficiency", "idle", "critical path s", "packets", "migrations"), rows))


def parse():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--weft", default=ROOT / "build/bin/weft")
    parser.add_argument("--out", default=ROOT / "build/paper")
    parser.add_argument("--cases", help="folder with the delta wing's start mesh (also WEFT_CASES); without it the cube's is made")
    parser.add_argument("--quick", action="store_true", help="a small cube, fewer runs")
    parser.add_argument("--complexity", type=int, help="of the adapted mesh")
    options = parser.parse_args()
    options.cases = options.cases or os.environ.get("WEFT_CASES")
    return options


def main():
    options = parse()
    book = Book(options)
    case = Case(options, book.folder)
    if not case.wing or case.quick:
        book.run("mesh", "box", "-o", "start-0.meshb", "--cells", 6, 6, 6)
        book.run("adapt", "start-0.meshb", "--metric-fn", "polar-2", "--complexity", max(1000, case.complexity // 10), "-o", "start.meshb", "--quiet", allowed=(0, 1))
    serial = book.adapt(case, "serial", "--threads", 1)
    run = book.adapt(case, "run", "--subdomains", case.subdomains, "--threads", 1)
    histograms(book, case, serial, run)
    breakdown(book, "run")
    shifts(book, case, (0, 1, 2, 6) if case.quick else (0, 1, 2, 3, 4, 6, 9, 12))
    layers(book, case, (1, 2, 5) if case.quick else (1, 2, 3, 5, 10))
    scaling(book, case, run, (1, 2, 4, 16, 64) if case.quick else (1, 2, 4, 8, 16, 64, 256, 512, 1024, 4096))
    book.missing.append("fig. CDT3D pipelines and the high-level algorithm: drawings of another program; weft's own graph is `weft graph run/graph.json --plan`")
    if case.quick or not case.wing:
        book.missing.append("the delta wing itself: its start mesh comes from WEFT_CASES, in the whole run")
    print(f"paper: {book.write(case)} in {time.monotonic() - book.begin:.0f} s")


if __name__ == "__main__":
    main()
