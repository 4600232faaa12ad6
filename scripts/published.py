"""What others have published, for the plots of paper.py and scaling.py."""

import csv
import pathlib

CURVES = pathlib.Path(__file__).resolve().parent.parent / "tools/report/published_curves.csv"
# Efficiencies against one core, by cores (docs of the UGAWG's parallel cases).
EFFICIENCY = {
    "refine, cube": {40: 0.64, 400: 0.23}, "refine, wing": {40: 0.87, 400: 0.49}, "CDT3D": {16: 0.66, 40: 0.59},
    "EPIC": {256: 0.29}, "feflo.a": {16: 0.21},
}


def efficiency_curves():
    return {name: (sorted(points.items()), False, True) for name, points in EFFICIENCY.items()}


def histogram_curves(case, measure, most):
    """Densities of a measure up to `most`, by program and cores, as drawing.plot() takes them."""
    curves = {}
    with open(CURVES, newline="") as file:
        for row in csv.DictReader(line for line in file if not line.startswith("#")):
            if row["case"] == case and row["measure"] == measure:
                ends, values = ([float(v) for v in row[k].split()] for k in ("bin edges", "densities"))
                cores = "1 core" if row["cores"] == "1" else f"{row['cores']} cores"
                points = [((a + b) / 2, v) for a, b, v in zip(ends, ends[1:], values) if b <= most]
                curves[f"{row['program']}, {cores}"] = points, True, False
    return curves
