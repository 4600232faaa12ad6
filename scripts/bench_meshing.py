#!/usr/bin/env python3
"""Fills closed surfaces with tets by `weft mesh`, TetGen and Gmsh in one run, and compares time and quality.

The surfaces are made here (meshing_surfaces.py) and kept by all three; each program has one thread and its own
default sizes, TetGen its usual quality options (-pYq1.3/14). Seconds are processor time of the whole process. Quality
is the mean ratio without a metric, measured by `weft stat` for all. Writes meshing.csv; prints a table; ends with 1 where a
mesh of weft's does not conform or its Q 1 % is below another's. Programs that are not installed are left out.

"needles" runs only when named: the triangles of a comb as a CAD program hands it out, whose worst one admits no tet
above 0.003; what the programs make of it differs by less than their numbers of tets."""

import argparse
import csv
import json
import os
import pathlib
import shutil
import subprocess
import sys

from meshing_surfaces import Surface, comb, cube, divided, extruded, merged, sphere, with_hole

ROOT = pathlib.Path(__file__).resolve().parent.parent
WEFT = ROOT / "build/bin/weft"
COLUMNS = ["surface", "triangles", "program", "seconds", "ratio", "tets", "Q mean", "Q 1%", "Q min", "dihedral", "note"]
WIDTHS = [12, 10, 8, 9, 7, 11, 7, 7, 9, 9]


def wing(options):
    """The surface of the small mesh in tests/data, read through weft: UGAWG's delta wing in its far-field box."""
    text = options.out / "wing.mesh"
    seconds_of([WEFT, "convert", ROOT / "tests/data/delta-wing-coarse.meshb", text], options)
    words = iter(text.read_text().split())
    section = {}
    for word in words:
        if word in ("Vertices", "Triangles"):
            section[word] = [[next(words) for _ in range(4)] for _ in range(int(next(words)))]
    points = [tuple(map(float, row[:3])) for row in section["Vertices"]]
    triangles = [tuple(int(v) - 1 for v in row[:3]) for row in section["Triangles"]]
    used = {v: i for i, v in enumerate(sorted({v for triangle in triangles for v in triangle}))}
    return Surface([points[v] for v in used], [tuple(used[v] for v in t) for t in triangles],
                   [(0, 1)] * len(triangles))


SURFACES = {
    "cube": lambda _: cube(8),
    "sphere": lambda _: sphere(16),
    "hole": lambda _: with_hole(cube(6), sphere(8, 0.3), (0.0, 0.0, 0.0)),
    "wing": wing,
    "needles": lambda _: extruded(merged(comb(7, 0.002)), 1.0),
    "comb": lambda _: divided(extruded(merged(comb(7, 0.005)), 1.0), 0.25, least=0.005),
    "blades": lambda _: divided(extruded(merged(comb(7, 0.005, 1.0)), 1.0), 0.25, least=0.005),
    "materials": lambda _: divided(extruded(comb(7, 0.005), 1.0), 0.25, least=0.005),
    "sphere-200k": lambda _: sphere(100),
}


def seconds_of(command, options):
    """Processor seconds of a command, or None (its output in last.log) where it fails or takes longer than allowed."""
    log = options.out / "last.log"
    before = os.times()
    with open(log, "w") as output:
        try:
            done = subprocess.run([str(word) for word in command], cwd=options.out, stdout=output,
                                  stderr=subprocess.STDOUT, timeout=options.limit)
        except subprocess.TimeoutExpired:
            return None
    after = os.times()
    if done.returncode != 0:
        return None
    return after.children_user + after.children_system - before.children_user - before.children_system


def write_mesh(path, surface):
    """Gamma Mesh Format in ASCII, which weft and Gmsh read; references are patches."""
    with open(path, "w") as file:
        file.write(f"MeshVersionFormatted 2\nDimension 3\nVertices\n{len(surface.points)}\n")
        file.writelines("%.17g %.17g %.17g 0\n" % point for point in surface.points)
        file.write(f"Triangles\n{len(surface.triangles)}\n")
        file.writelines(f"{a + 1} {b + 1} {c + 1} {ref}\n" for (a, b, c), ref in zip(surface.triangles, surface.refs()))
        file.write("End\n")


def write_smesh(path, surface):
    """TetGen's form: points, facets, holes."""
    with open(path, "w") as file:
        file.write(f"{len(surface.points)} 3 0 0\n")
        file.writelines("%d %.17g %.17g %.17g\n" % (i, *point) for i, point in enumerate(surface.points, 1))
        file.write(f"{len(surface.triangles)} 1\n")
        file.writelines(f"3 {a + 1} {b + 1} {c + 1} {ref}\n"
                        for (a, b, c), ref in zip(surface.triangles, surface.refs()))
        file.write(f"{len(surface.holes)}\n")
        file.writelines("%d %.17g %.17g %.17g\n" % (i, *hole) for i, hole in enumerate(surface.holes, 1))
        file.write("0\n")


def write_geo(path, surface, mesh):
    """Gmsh's script: the triangles as discrete surfaces, a volume for each region."""
    lines = [f'Merge "{mesh.name}";']
    for region, patches in surface.regions().items():
        lines += [f"Surface Loop({region}) = {{{', '.join(map(str, patches))}}};", f"Volume({region}) = {{{region}}};"]
    path.write_text("\n".join(lines) + "\n")


def by_weft(name, surface, options):
    result = options.out / f"{name}-weft.meshb"
    return seconds_of([WEFT, "mesh", f"{name}.mesh", "-o", result, "--threads", 1, "--quiet"], options), result


def by_tetgen(name, surface, options):
    write_smesh(options.out / f"{name}.smesh", surface)
    seconds = seconds_of(["tetgen", "-pYq1.3/14", "-gQ", f"{name}.smesh"], options)
    return seconds, options.out / f"{name}.1.mesh"


def by_gmsh(name, surface, options):
    result = options.out / f"{name}-gmsh.mesh"
    write_geo(options.out / f"{name}.geo", surface, options.out / f"{name}.mesh")
    return seconds_of(["gmsh", "-3", "-nt", 1, f"{name}.geo", "-o", result.name], options), result


PROGRAMS = {"weft": by_weft, "tetgen": by_tetgen, "gmsh": by_gmsh}


def row_of(name, surface, program, options):
    """One line of the table; without figures where the program made no mesh."""
    seconds, result = PROGRAMS[program](name, surface, options)
    row = {"surface": name, "triangles": len(surface.triangles), "program": program, "note": ""}
    stat = subprocess.run([WEFT, "stat", result, "--json"], capture_output=True, text=True) if seconds else None
    if not stat or stat.returncode != 0 or not json.loads(stat.stdout)["tets"]:
        return {**row, "note": f"no mesh within {options.limit} s" if not stat else "its file cannot be used"}
    measures = json.loads(stat.stdout)
    shape = measures["shape"]
    row.update({"seconds": seconds, "tets": measures["tets"], "Q mean": shape["quality"]["mean"],
                "Q 1%": shape["quality"]["quantile_0.01"], "Q min": shape["quality"]["min"],
                "dihedral": shape["least_dihedral_degrees"]})
    if program == "weft" and seconds_of([WEFT, "verify", result], options) is None:
        row["note"] = "DOES NOT CONFORM"
    return row


def judge(rows):
    """Adds times as ratios to weft's, and a note where weft's Q 1 % is the lower one; True where all is well."""
    weft, *others = rows
    if "tets" not in weft or weft["note"]:
        return False
    well = True
    for row in rows:
        if "tets" not in row:
            continue
        row["ratio"] = row["seconds"] / weft["seconds"]
        if row["Q 1%"] > weft["Q 1%"]:
            row["note"], well = "Q 1 % ABOVE WEFT'S", False
    return well


def text_of(column, value):
    formats = {"seconds": "{:.2f}", "ratio": "{:.2f}", "Q mean": "{:.3f}", "Q 1%": "{:.3f}", "Q min": "{:.2g}",
               "dihedral": "{:.2g}", "tets": "{:,}", "triangles": "{:,}"}
    return formats.get(column, "{}").format(value) if value != "" else "-"


def print_rows(rows):
    for row in rows:
        cells = [text_of(column, row.get(column, "")) for column in COLUMNS[:-1]]
        print("".join(cell.rjust(width) for cell, width in zip(cells, WIDTHS)) + "  " + row["note"], flush=True)


def parsed_options():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("surfaces", nargs="*", metavar="SURFACE", help=f"of {', '.join(SURFACES)} (default: all but needles)")
    parser.add_argument("--limit", type=float, default=600, help="seconds that a program may take; default 600")
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "build/bench/meshing")
    options = parser.parse_args()
    unknown = set(options.surfaces) - set(SURFACES)
    if unknown:
        parser.error(f"no surface {', '.join(unknown)}")
    options.out = options.out.resolve()
    return options


def main():
    options = parsed_options()
    options.out.mkdir(parents=True, exist_ok=True)
    programs = [program for program in PROGRAMS if program == "weft" or shutil.which(program)]
    print("".join(column.rjust(width) for column, width in zip(COLUMNS, WIDTHS)))
    rows, well = [], True
    for name in options.surfaces or [name for name in SURFACES if name != "needles"]:
        surface = SURFACES[name](options)
        write_mesh(options.out / f"{name}.mesh", surface)
        mine = [row_of(name, surface, program, options) for program in programs]
        well &= judge(mine)
        print_rows(mine)
        rows += mine
    with open(options.out / "meshing.csv", "w", newline="") as file:
        table = csv.DictWriter(file, COLUMNS, restval="")
        table.writeheader()
        table.writerows(rows)
    return 0 if well else 1


if __name__ == "__main__":
    sys.exit(main())
