"""SVG plots and HTML tables of the scripts that report figures: paper.py, scaling.py."""

import html
import math

COLOURS = "#2f6fb0 #e07b16 #2f9e77 #b0529c #7aa52b #2aa3bd #c4a000 #8d6e63 #8795a5 #9cc3ea #d4d9e0".split()
WIDTH, HEIGHT, LEFT, BOTTOM, LEGEND = 860, 360, 64, 48, 270


def ticks(low, high, logarithmic):
    if logarithmic:
        decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
        steps = (1, 2, 5) if high < 100 * low else (1,)
        return [m * 10.0 ** e for e in decades for m in steps if low <= m * 10.0 ** e <= high]
    step = 10 ** math.floor(math.log10((high - low) or 1))
    step = next(s for s in (step / 5, step / 2, step, 2 * step) if (high - low) / s <= 10)
    return [step * i for i in range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1)]


def opening(title, height=HEIGHT):
    return [f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{height}" font-family="sans-serif" font-size="11">',
            f'<text x="{(WIDTH - LEGEND) / 2}" y="16" text-anchor="middle" font-size="13">{html.escape(title)}</text>']


def plot(title, x_label, y_label, series, log_x=False, log_y=False):
    """series: name -> (points, dashed, marks). What a logarithmic axis has no place for is left out."""
    points = [p for pts, _, _ in series.values() for p in pts if (p[0] > 0 or not log_x) and (p[1] > 0 or not log_y)]
    if not points:
        return ""
    (x0, x1), (y0, y1) = ((min(c), max(c)) for c in zip(*points))
    if not log_y:
        y0 = min(0, y0)
    x1, y1 = x1 if x1 > x0 else x0 + 1, y1 if y1 > y0 else y0 + 1
    right = WIDTH - LEGEND

    def place(value, low, high, logarithmic, length):
        if logarithmic:
            value, low, high = math.log(value), math.log(low), math.log(high)
        return length * (value - low) / (high - low)

    def at(x, y):
        return LEFT + place(x, x0, x1, log_x, right - LEFT - 10), HEIGHT - BOTTOM - place(y, y0, y1, log_y, HEIGHT - BOTTOM - 30)

    out = opening(title)
    values, last = sorted({p[0] for p in points}), -math.inf
    for x in values if log_x and len(values) <= 16 else ticks(x0, x1, log_x):  # cores are few: each has its mark
        if at(x, y0)[0] < last + 25:
            continue
        last = at(x, y0)[0]
        out.append(f'<text x="{at(x, y0)[0]:.1f}" y="{HEIGHT - BOTTOM + 15}" text-anchor="middle">{x:g}</text>')
    for y in ticks(y0, y1, log_y):
        px = at(x0, y)[1]
        out.append(f'<line x1="{LEFT}" x2="{right - 10}" y1="{px:.1f}" y2="{px:.1f}" stroke="#ddd"/><text x="{LEFT - 4}" y="{px + 4:.1f}" text-anchor="end">{y:g}</text>')
    for index, (name, (pts, dashed, marks)) in enumerate(series.items()):
        colour, dashes = COLOURS[index % len(COLOURS)], ' stroke-dasharray="5,4"' if dashed else ""
        shown = [at(*p) for p in pts if (p[0] > 0 or not log_x) and (p[1] > 0 or not log_y)]
        line = " ".join(f"{x:.1f},{y:.1f}" for x, y in shown)
        out.append(f'<polyline points="{line}" fill="none" stroke="{colour}" stroke-width="1.5"{dashes}/>')
        if marks:
            out += [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3" fill="{colour}"/>' for x, y in shown]
        out.append(f'<text x="{right}" y="{40 + 15 * index}" fill="{colour}">{"- - " if dashed else "&#8212; "}{html.escape(name)}</text>')
    out.append(f'<text x="{right / 2}" y="{HEIGHT - 12}" text-anchor="middle">{html.escape(x_label)}</text>'
               f'<text x="12" y="{HEIGHT / 2}" transform="rotate(-90 12 {HEIGHT / 2})" text-anchor="middle">{html.escape(y_label)}</text></svg>')
    return "\n".join(out)


def shares(title, names, rows):
    """A bar for each of rows, label -> values by name, divided by what the values make up of their sum."""
    left, length, step = 130, WIDTH - LEGEND - 140, 30
    out = opening(title, 40 + max(step * len(rows) + 20, 15 * len(names) + 10))
    colours = {name: COLOURS[i % len(COLOURS)] for i, name in enumerate(names)}
    for row, (label, values) in enumerate(rows.items()):
        y, x, whole = 32 + step * row, left, sum(values.values())
        out.append(f'<text x="{left - 6}" y="{y + 15}" text-anchor="end">{html.escape(label)}</text>')
        for name in names:
            share = values.get(name, 0) / whole if whole else 0
            out.append(f'<rect x="{x:.1f}" y="{y}" width="{length * share:.1f}" height="22" fill="{colours[name]}" fill-opacity="0.7"><title>'
                       f'{html.escape(label)}: {html.escape(name)} {100 * share:.1f} %</title></rect>')
            if share > 0.05:
                out.append(f'<text x="{x + length * share / 2:.1f}" y="{y + 15}" text-anchor="middle">{100 * share:.0f} %</text>')
            x += length * share
    out += [f'<text x="{WIDTH - LEGEND + 10}" y="{44 + 15 * i}" fill="{colours[name]}">&#9632; {html.escape(name)}</text>' for i, name in enumerate(names)]
    return "\n".join(out + ["</svg>"])


def table(head, rows):
    def line(row, tag):
        return "<tr>" + "".join(f"<{tag}>{html.escape(str(c))}</{tag}>" for c in row) + "</tr>"

    return "<table>" + line(head, "th") + "".join(line(r, "td") for r in rows) + "</table>"
