#!/usr/bin/env python3
"""Error against complexity: adapts the unit cube to known fields and plots the L2 error of their linear interpolation.

Every field goes through `weft loop`, with the example solver of tests/ that samples it ("sample") or solves
Poisson's equation for it ("poisson"): a few cycles at each complexity, of which the last counts. Theory in 3D, second
order: error ~ C^(-2/3). Writes convergence.csv and convergence.svg; prints for every field the rate between the first
and the last complexity, by least squares, as a share of 2/3, and ends with 1 where it is below --least."""

import argparse
import csv
import json
import math
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
COMPLEXITIES = [1000, 4000, 16000, 64000, 256000]
FIELDS = ["smooth", "layer", "shock"]
THEORY = 2 / 3
COLUMNS = ["field", "method", "target", "complexity", "vertices", "tets", "l2_error", "adapt_seconds"]


def run(words, cwd):
    done = subprocess.run([str(word) for word in words], cwd=cwd, capture_output=True, text=True)
    if done.returncode not in (0, 1):
        sys.exit(f"convergence: {' '.join(map(str, words))} failed:\n{done.stdout}{done.stderr}")


def configuration(field, options):
    return {
        "mesh": "box.meshb",
        "solver": f"'{options.bin.resolve()}/weft_example_solver' {options.method} {field} {{mesh}} {{solution}}",
        "complexities": options.complexities,
        "cycles": options.cycles,
        "metric": {"norm": 2, "hgrad": options.hgrad} if options.hgrad > 1 else {"norm": 2},
        "adapt": {"threads": options.threads},
    }


def rows_of(field, options):
    """Runs the loop (or takes what an earlier run left) and reads the last cycle at each complexity."""
    name = f"{field}-{options.method}"
    (options.out / f"{name}.json").write_text(json.dumps(configuration(field, options)))
    run([options.bin.resolve() / "weft", "loop", f"{name}.json"], options.out)
    with open(options.out / name / "cycles.csv") as table:
        cycles = list(csv.DictReader(table))
    for i, target in enumerate(options.complexities, 1):
        cycle = cycles[i * options.cycles]
        log = json.loads((options.out / name / f"{int(cycle['cycle']):03}" / "solver.log").read_text())
        yield {**{column: cycle.get(column) for column in COLUMNS}, "field": field, "method": options.method,
               "target": target, "l2_error": log["l2_error"]}


def rate(rows):
    """Minus the slope of log error against log complexity."""
    x = [math.log(float(row["complexity"])) for row in rows]
    y = [math.log(row["l2_error"]) for row in rows]
    mx, my = sum(x) / len(x), sum(y) / len(y)
    return -sum((a - mx) * (b - my) for a, b in zip(x, y)) / sum((a - mx) ** 2 for a in x)


def raised(exponent):
    """An exponent as SVG text, with a true minus."""
    return f'<tspan dy="-5" font-size="9">{str(exponent).replace("-", chr(0x2212))}</tspan>'


class Plot:
    """A plot with logarithmic axes as SVG."""

    WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM = 660, 440, 70, 170, 16, 50
    THEORY_STYLE = 'stroke="#888" stroke-dasharray="5 4"'
    COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7"]

    def __init__(self, xs, ys, x_name, y_name):
        self.x_name, self.y_name = x_name, y_name
        self.x0, self.x1 = math.log10(min(xs)) - 0.1, math.log10(max(xs)) + 0.1
        self.y0, self.y1 = math.log10(min(ys)) - 0.2, math.log10(max(ys)) + 0.2
        self.parts, self.labels = [], 0
        self.axes()

    def x(self, value):
        return self.LEFT + (math.log10(value) - self.x0) / (self.x1 - self.x0) * (self.WIDTH - self.LEFT - self.RIGHT)

    def y(self, value):
        return self.TOP + (self.y1 - math.log10(value)) / (self.y1 - self.y0) * (self.HEIGHT - self.TOP - self.BOTTOM)

    def line(self, x1, y1, x2, y2, style):
        self.parts.append(f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" {style}/>')

    def text(self, x, y, text, anchor="middle", colour="#222"):
        self.parts.append(f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" fill="{colour}">{text}</text>')

    def axes(self):
        """A frame with a tick for every digit, grid lines at the powers of ten."""
        right, bottom = self.WIDTH - self.RIGHT, self.HEIGHT - self.BOTTOM
        for axis, low, high in (("x", self.x0, self.x1), ("y", self.y0, self.y1)):
            for e in range(math.floor(low), math.ceil(high) + 1):
                for value in (digit * 10.0**e for digit in range(1, 10)):
                    if low <= math.log10(value) <= high:
                        self.tick(axis, value, e if value == 10.0**e else None)
        self.parts.append(f'<rect x="{self.LEFT}" y="{self.TOP}" width="{right - self.LEFT}" '
                          f'height="{bottom - self.TOP}" fill="none" stroke="#222"/>')
        self.text((self.LEFT + right) / 2, self.HEIGHT - 10, self.x_name)
        middle = (self.TOP + bottom) / 2
        self.parts.append(f'<text x="18" y="{middle}" text-anchor="middle" fill="#222" '
                          f'transform="rotate(-90 18 {middle})">{self.y_name}</text>')

    def tick(self, axis, value, exponent):
        """A short line, or a line through the plot with its label where `exponent` is given."""
        major, right, bottom = exponent is not None, self.WIDTH - self.RIGHT, self.HEIGHT - self.BOTTOM
        style = 'stroke="#ddd"' if major else 'stroke="#222" stroke-width="0.6"'
        power = "10" + raised(exponent) if major else ""
        if axis == "x":
            self.line(self.x(value), bottom, self.x(value), self.TOP if major else bottom - 4, style)
            self.text(self.x(value), bottom + 18, power)
        else:
            self.line(self.LEFT, self.y(value), right if major else self.LEFT + 4, self.y(value), style)
            self.text(self.LEFT - 8, self.y(value) + 4, power, "end")

    def curve(self, name, points):
        colour = self.COLOURS[self.labels % len(self.COLOURS)]
        self.theory(points[-1], points[0][0])
        path = " ".join(f"{self.x(x):.1f},{self.y(y):.1f}" for x, y in points)
        self.parts.append(f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="2"/>')
        for x, y in points:
            self.mark(self.labels, self.x(x), self.y(y), colour)
        self.text(self.x(points[-1][0]) + 20, self.y(points[-1][1]) + 4, name, "start", colour)
        self.labels += 1

    def mark(self, kind, x, y, colour):
        """A circle, square, triangle or diamond, so that curves differ in print too."""
        outlines = [None, [(-1, -1), (1, -1), (1, 1), (-1, 1)], [(-1.2, 1), (1.2, 1), (0, -1.2)],
                    [(-1.3, 0), (0, -1.3), (1.3, 0), (0, 1.3)]]
        outline = outlines[kind % len(outlines)]
        if outline:
            path = " ".join(f"{x + 3.2 * dx:.1f},{y + 3.2 * dy:.1f}" for dx, dy in outline)
            self.parts.append(f'<polygon points="{path}" fill="{colour}"/>')
        else:
            self.parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3.5" fill="{colour}"/>')

    def theory(self, end, start):
        """The slope of theory through a curve's last point, as far as the plot reaches."""
        start = max(start, end[0] * (end[1] / 10**self.y1) ** (1 / THEORY))
        y = end[1] * (end[0] / start) ** THEORY
        self.line(self.x(start), self.y(y), self.x(end[0]), self.y(end[1]), self.THEORY_STYLE)

    def legend(self):
        left, y = self.WIDTH - self.RIGHT + 14, self.TOP + 14
        self.line(left, y - 4, left + 26, y - 4, self.THEORY_STYLE)
        self.text(left + 32, y, "theory: C" + raised("-2/3"), "start")

    def write(self, path):
        body = "\n".join(self.parts)
        path.write_text(f'<svg xmlns="http://www.w3.org/2000/svg" width="{self.WIDTH}" height="{self.HEIGHT}" '
                        f'font-family="sans-serif" font-size="12">\n<rect width="100%" height="100%" fill="white"/>\n'
                        f"{body}\n</svg>\n")


def plot(rows, rates, error, path):
    chart = Plot([float(row["complexity"]) for row in rows], [row["l2_error"] for row in rows],
                 "complexity of the metric", error)
    for field, value in rates.items():
        mine = [(float(row["complexity"]), row["l2_error"]) for row in rows if row["field"] == field]
        chart.curve(f"{field}: C{raised(f'{-value:.2f}')}", mine)
    chart.legend()
    chart.write(path)


def parsed_options():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fields", nargs="+", choices=FIELDS, default=FIELDS)
    parser.add_argument("--complexities", nargs="+", type=int, default=COMPLEXITIES)
    parser.add_argument("--cycles", type=int, default=3, help="at each complexity; default 3")
    parser.add_argument("--method", choices=["sample", "poisson"], default="sample")
    parser.add_argument("--hgrad", type=float, default=0, help="gradation; default none")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--least", type=float, default=0.95, help="least share of the rate of theory; default 0.95")
    parser.add_argument("--bin", type=pathlib.Path, default=ROOT / "build/bin", help="where weft lies")
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "build/convergence")
    options = parser.parse_args()
    if len(options.complexities) < 2:
        parser.error("--complexities: a rate needs two")
    return options


def main():
    options = parsed_options()
    options.out.mkdir(parents=True, exist_ok=True)
    run([options.bin.resolve() / "weft", "mesh", "box", "-o", "box.meshb", "--cells", 8, 8, 8], options.out)
    rows, rates = [], {}
    for field in options.fields:
        mine = list(rows_of(field, options))
        rows += mine
        rates[field] = rate(mine)
        for row in mine:
            print(f"{field:<8}{float(row['complexity']):>10,.0f}{int(row['vertices']):>10,}   {row['l2_error']:.3e}")
        print(f"{field}: rate {rates[field]:.3f}, {rates[field] / THEORY:.1%} of theory", flush=True)
    with open(options.out / "convergence.csv", "w", newline="") as file:
        table = csv.DictWriter(file, COLUMNS)
        table.writeheader()
        table.writerows(rows)
    error = {"sample": "L2 error of linear interpolation", "poisson": "L2 error of the solution"}[options.method]
    plot(rows, rates, error, options.out / "convergence.svg")
    print(f"{options.out / 'convergence.csv'}, {options.out / 'convergence.svg'}")
    return 0 if min(rates.values()) >= options.least * THEORY else 1


if __name__ == "__main__":
    sys.exit(main())
