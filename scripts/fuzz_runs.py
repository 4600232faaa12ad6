#!/usr/bin/env python3
"""Runs at random: meshes (several materials, curved, thin, distorted), metrics, partitions, ranks, and some damage.

    fuzz_runs.py WEFT [--runs N | --seconds S] [--seed N] [--ranks R] [--keep DIR]

Each run must end in time with a code that fits, the result must pass `weft verify`, and with one thread its bytes must be the
same in one process and on several ranks. A run that fails is made smaller, one property after the other, as long as it fails
in the same way; what is left is printed as JSON (to be run again by `--case FILE`), its files are kept in DIR. Ends with a
table of the runs by kind; exit code 1 where any failed.
"""

import argparse
import collections
import hashlib
import json
import math
import os
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile
import time

SECONDS = 240  # far above what any of these takes
MPIRUN = [*os.environ.get("WEFT_MPIRUN", "mpirun;--oversubscribe;--bind-to;none").split(";"), "-n"]
DAMAGE = ("inverted tet", "index out of range", "metric not finite", "metric too short", "indefinite metric")
PLANAR = ("box", "slab", "sheared box")

# What a smaller run has, in the order in which it is tried.
SIMPLER = {
    "damage": None, "ranks": 1, "subdomains": 0, "threads": 1, "switches": [], "limits": [], "sources": ["uniform"], "materials": 1,
    "jitter": 0.0, "shape": "box", "cells": 1, "complexity": 20, "partitioner": "graph", "balancer": "stealing", "layers": 2,
    "freeze": "vertices",
}


def random_case(seed, most_ranks):
    r = random.Random(seed)
    many = r.random() < 0.75
    return {
        "seed": seed,
        "shape": r.choice(("box", "box", "slab", "sheared box", "ball", "cylinder", "quarter ring", "quarter ring")),
        "cells": r.choice((1, 1, 2, 3, 4)),
        "materials": r.choice((1, 1, 2)),
        "jitter": r.choice((0.0, 0.0, 0.15)),
        "sources": r.choice((["uniform"], ["polar"], ["layers"], ["solution"], ["tensors"], ["implied"], ["solution", "implied"],
                             ["solution", "uniform"], ["tensors", "solution"])),
        "complexity": r.choice((20, 80, 300, 800)) if r.random() < 0.97 else 20000,  # arrays grow, pieces are divided
        "limits": r.sample((["--hmax", "0.5"], ["--hmin", "0.02"], ["--aspect", "20"], ["--hgrad", "1.5"],
                            ["--hgrad", "1.3", "--hgrad-space", "mixed"], ["--recovery", "l2"]), r.choice((0, 1, 2))),
        "subdomains": r.choice((1, 2, 3, 5, 9)) if many else 0,
        "partitioner": r.choice(("graph", "bisection", "pqr:2x2x1", "pqr:3x1x1")),
        "balancer": r.choice(("stealing", "diffusion", "none")),
        "layers": r.choice((0, 1, 2, 4)),
        "freeze": r.choice(("vertices", "vertices", "tets")),
        "switches": r.sample((["--no-interface-refinement"], ["--layers-by", "faces"], ["--equal", "tets"], ["--shifts", "1"],
                              ["--check"], ["--no-insert"], ["--no-swap"], ["--no-move"]), r.choice((0, 0, 1, 2))),
        "ranks": r.randint(1, most_ranks) if many else 1,
        "threads": r.choice((1, 1, 1, 3)),
        "damage": r.choice(DAMAGE) if r.random() < 0.1 else None,
    }


class Failure(Exception):
    """Says what is wrong; `kind` is what stays the same while the case gets smaller."""

    def __init__(self, kind, text):
        super().__init__(f"{kind}: {text}")
        self.kind = kind


class Mesh:
    """A text file of points, tets and triangles, as lists of words."""

    def __init__(self, path):
        words = path.read_text().split()
        self.sections = {}
        for name, width in (("Vertices", 4), ("Tetrahedra", 5), ("Triangles", 4)):
            at = words.index(name)
            count = int(words[at + 1])
            self.sections[name] = [words[at + 2 + width * i:at + 2 + width * (i + 1)] for i in range(count)]
        self.points = [list(map(float, row[:3])) for row in self.sections["Vertices"]]

    def write(self, path, keep_triangles):
        """Without triangles the boundary is what the tets have."""
        lines = ["MeshVersionFormatted 2", "Dimension 3", "Vertices", str(len(self.points))]
        lines += [" ".join(f"{x:.17g}" for x in p) + " 0" for p in self.points]
        for name in ("Tetrahedra", "Triangles") if keep_triangles else ("Tetrahedra",):
            lines += [name, str(len(self.sections[name])), *(" ".join(row) for row in self.sections[name])]
        path.write_text("\n".join([*lines, "End"]) + "\n")


class Trial:
    """One case in a folder of its own."""

    def __init__(self, weft, case, folder):
        self.weft, self.case, self.folder = weft, case, folder
        self.random = random.Random(case["seed"])

    def run(self, *words, ranks=1, codes=(0,)):
        launcher = [*MPIRUN, str(ranks)] if ranks > 1 else []
        command = [*launcher, self.weft, *map(str, words)]
        try:
            done = subprocess.run(command, cwd=self.folder, capture_output=True, text=True, timeout=SECONDS)
        except subprocess.TimeoutExpired:
            raise Failure("no end", " ".join(command)) from None
        if done.returncode not in codes:
            raise Failure(f"code {done.returncode}", " ".join(command) + "\n" + done.stdout[-2000:] + done.stderr[-2000:])
        return done

    def make_mesh(self):
        case = self.case
        cells = case["cells"]
        if case["shape"] in (*PLANAR, "quarter ring"):
            self.run("mesh", "box", "-o", "start.mesh", "--cells", cells, max(1, cells - 1), cells + 1, "--quiet")
        else:
            self.run("mesh", case["shape"], "--size", 1.2 / (1 + cells), "-o", "start.mesh", "--quiet")
        mesh = Mesh(self.folder / "start.mesh")
        if case["shape"] == "slab":
            mesh.points = [[x, y, 0.02 * z] for x, y, z in mesh.points]
        if case["shape"] == "sheared box":
            mesh.points = [[x + 0.7 * y, y - 0.4 * z, z + 0.3 * x] for x, y, z in mesh.points]
        if case["shape"] == "quarter ring":  # a few chords: its boundary moves far while it is adapted
            mesh.points = [[(0.5 + 0.5 * x) * math.cos(math.pi / 2 * z), (0.5 + 0.5 * x) * math.sin(math.pi / 2 * z), -y]
                           for x, y, z in mesh.points]
        self.move_inner_points(mesh)
        if case["materials"] > 1:  # by sides of a plane through cells: their common boundary is jagged
            for tet in mesh.sections["Tetrahedra"]:
                middle = sum(mesh.points[int(v) - 1][0] for v in tet[:4]) / 4
                tet[4] = "1" if middle < 0.5 * max(p[0] for p in mesh.points) else "2"
        self.damage_mesh(mesh)
        mesh.write(self.folder / "start.mesh", keep_triangles=case["materials"] == 1)
        return mesh

    def move_inner_points(self, mesh):
        """By a share of the nearest edge, which inverts no tet of these meshes; checked, and taken back where one is."""
        if not self.case["jitter"]:
            return
        boundary = {int(v) - 1 for row in mesh.sections["Triangles"] for v in row[:3]}
        tets = [[int(v) - 1 for v in row[:4]] for row in mesh.sections["Tetrahedra"]]
        around = collections.defaultdict(list)
        for tet in tets:
            for v in tet:
                around[v].append(tet)
        for v in range(len(mesh.points)):
            if v in boundary:
                continue
            old = list(mesh.points[v])
            shortest = min(math.dist(old, mesh.points[u]) for tet in around[v] for u in tet if u != v)
            mesh.points[v] = [x + self.case["jitter"] * shortest * self.random.uniform(-1, 1) for x in old]
            if any(volume(mesh.points, tet) <= 0 for tet in around[v]):
                mesh.points[v] = old

    def damage_mesh(self, mesh):
        tets = mesh.sections["Tetrahedra"]
        tet = self.random.choice(tets)
        if self.case["damage"] == "inverted tet":
            tet[0], tet[1] = tet[1], tet[0]
        elif self.case["damage"] == "index out of range":
            tet[2] = str(len(mesh.points) + 7)

    def make_metric(self, mesh):
        """Words for the command; files of solutions and tensors are written where asked for."""
        words = []
        for source in self.case["sources"]:
            if source == "uniform":
                words += ["--metric-fn", "uniform:0.4"]
            elif source == "polar":
                words += ["--metric-fn", "polar-1"]
            elif source == "layers":
                words += ["--metric-fn", "polar-2"]
            elif source == "implied":
                words += ["--implied"]
            elif source == "solution":
                k = self.random.uniform(2, 12)
                values = [[math.tanh(k * (p[0] - 0.4 + 0.3 * p[1] * p[2]))] for p in mesh.points]
                self.write_solution("u.sol", values, 1)
                words += ["--sol", "u.sol"]
            else:
                self.write_solution("m.sol", [self.random_tensor() for _ in mesh.points], 3)
                words += ["--metric", "m.sol"]
        if self.case["damage"] in DAMAGE[2:] and "m.sol" not in words:
            self.write_solution("m.sol", [self.random_tensor() for _ in mesh.points], 3)
            words = ["--metric", "m.sol"]
        return words

    def random_tensor(self):
        """Sizes between 0.05 and 1 along random directions: a sum of squares."""
        total = [0.0] * 6
        for _ in range(3):
            n = [self.random.gauss(0, 1) for _ in range(3)]
            scale = self.random.uniform(1, 20) ** 2 / sum(x * x for x in n)
            for i, (a, b) in enumerate(((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2))):
                total[i] += scale * n[a] * n[b]
        return [t + 1e-3 * (i in (0, 2, 5)) for i, t in enumerate(total)]

    def write_solution(self, name, rows, kind):
        damage = self.case["damage"]
        if kind == 3 and damage:
            at = self.random.randrange(len(rows))
            if damage == "metric not finite":
                rows[at][1] = math.nan
            elif damage == "indefinite metric":
                rows[at][0] = -1.0
            elif damage == "metric too short":
                rows.pop()
        lines = "".join(" ".join(f"{x:.17g}" for x in row) + "\n" for row in rows)
        (self.folder / name).write_text(
            f"MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n{len(rows)}\n1 {kind}\n{lines}End\n")

    def words(self, metric):
        case = self.case
        words = ["adapt", "start.mesh", *metric, "--complexity", case["complexity"], "--threads", case["threads"], "--quiet",
                 "-o", "out.meshb"]
        seen = set()
        for limit in case["limits"]:
            if limit[0] not in seen and (limit[0] != "--recovery" or "--sol" in words):
                words += limit
                seen.add(limit[0])
        words += ["--hmax", "1"] if "--hmax" not in words else []
        plain = [s for s in case["switches"] if s[0] in ("--no-insert", "--no-swap", "--no-move")]
        for switch in plain if case["subdomains"] == 0 else case["switches"]:
            words += switch
        if case["subdomains"] > 0:
            words += ["--partitioner", case["partitioner"], "--balancer", case["balancer"], "--layers", case["layers"],
                      "--freeze", case["freeze"]]
            words += ["--subdomains", case["subdomains"]] if not case["partitioner"].startswith("pqr") else []
        return words

    def adapt(self, words, ranks):
        before = {path.name for path in self.folder.iterdir()}
        damaged = self.case["damage"] is not None
        done = self.run(*words, ranks=ranks, codes=(0, 1, 2) if damaged else (0, 1))
        left = {path.name for path in self.folder.iterdir()} - before - {"out.meshb", "out.solb"}
        if left:
            raise Failure("files left", ", ".join(sorted(left)))
        if done.returncode == 2:
            told = [line for line in done.stderr.splitlines() if line.startswith(("weft", "error"))]
            if len(told) != 1:
                raise Failure("error not told once", done.stderr[-2000:])
            return told[0].removeprefix("error: ").removeprefix("weft: ")
        # A curved boundary, and one of materials that is jagged, is smoothed: volumes are kept by planar ones.
        planar = self.case["shape"] in PLANAR and self.case["materials"] == 1
        against = ["--against", "start.mesh"] if planar and not damaged else []
        self.run("verify", "out.meshb", *against, "--quiet")
        files = [self.folder / name for name in ("out.meshb", "out.solb")]
        digest = hashlib.sha256(b"".join(path.read_bytes() for path in files)).hexdigest()
        for path in files:
            path.unlink()
        return digest

    def check(self):
        words = self.words(self.make_metric(self.make_mesh()))
        result = self.adapt(words, self.case["ranks"])
        if self.case["threads"] == 1 and self.case["ranks"] > 1 and self.case["subdomains"] > 0:
            alone = self.adapt(words, 1)
            if alone != result and not (self.case["damage"] and len(alone) != 64 and len(result) != 64):
                raise Failure("bytes differ", f"{alone} on 1 rank, {result} on {self.case['ranks']}")


def volume(points, tet):
    a, b, c, d = (points[v] for v in tet)
    u, v, w = ([x - y for x, y in zip(p, a)] for p in (b, c, d))
    return (u[0] * (v[1] * w[2] - v[2] * w[1]) - u[1] * (v[0] * w[2] - v[2] * w[0]) + u[2] * (v[0] * w[1] - v[1] * w[0])) / 6


def failure_of(weft, case, keep=None):
    """What is wrong with a case, or None."""
    with tempfile.TemporaryDirectory(prefix="weft-fuzz-") as name:
        folder = pathlib.Path(name)
        try:
            Trial(weft, case, folder).check()
        except Failure as failure:
            if keep:
                target = keep / f"case-{case['seed']}"
                shutil.copytree(folder, target, dirs_exist_ok=True)
                (target / "case.json").write_text(json.dumps(case, indent=1) + "\n")
            return failure
    return None


def shrunk(weft, case, failure):
    """The case with every property simplified that the failure does not need."""
    case = dict(case)
    for name, simple in SIMPLER.items():
        smaller = [{**case, name: simple}] if case[name] != simple else []
        if isinstance(case[name], list):  # one entry after the other
            smaller += [{**case, name: [e for e in case[name] if e != gone]} for gone in case[name] if len(case[name]) > 1]
        for candidate in smaller:
            found = failure_of(weft, candidate)
            if found and found.kind == failure.kind:
                case = candidate
                break
    return case


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("weft", help="the command")
    parser.add_argument("--runs", type=int, default=0)
    parser.add_argument("--seconds", type=float, default=0)
    parser.add_argument("--seed", type=int, default=random.SystemRandom().randrange(10**6))
    parser.add_argument("--ranks", type=int, default=4, help="at most")
    parser.add_argument("--keep", type=pathlib.Path, default=pathlib.Path("fuzz-failures"))
    parser.add_argument("--case", type=pathlib.Path, help="run this one again")
    asked = parser.parse_args()
    weft = str(pathlib.Path(asked.weft).resolve())
    os.environ.update(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
    if asked.case:
        failure = failure_of(weft, json.loads(asked.case.read_text()), asked.keep)
        print(failure or "no failure")
        return 1 if failure else 0

    begin, runs, failures, kinds = time.monotonic(), 0, 0, collections.Counter()
    most = asked.runs or (10**9 if asked.seconds else 100)
    while runs < most and (not asked.seconds or time.monotonic() - begin < asked.seconds):
        case = random_case(asked.seed * 10**6 + runs, asked.ranks)
        runs += 1
        kinds[(case["shape"], "subdomains" if case["subdomains"] else "one mesh", case["damage"] or "sound")] += 1
        failure = failure_of(weft, case)
        if not failure:
            continue
        failures += 1
        small = shrunk(weft, case, failure)
        failure = failure_of(weft, small, asked.keep) or failure
        print(f"{failure}\n{json.dumps(small)}", flush=True)
    print(f"{'shape':12} {'run':12} {'input':20} runs")
    for (shape, run, damage), count in sorted(kinds.items()):
        print(f"{shape:12} {run:12} {damage:20} {count}")
    print(f"seed {asked.seed}: {runs} runs, {failures} failed, {time.monotonic() - begin:.0f} s")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
