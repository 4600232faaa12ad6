#!/usr/bin/env python3
"""The CAD cases, adapted on their models and without: what must hold of each run, and a table.

    cad_cases.py WEFT [--cases DIR] [--complexity N ...] [--only NAME ...] [--ranks R ...]

From their coarse meshes to a metric of curvature and to layers (polar-2): every vertex of the boundary is on the model, no triangle
is turned against it, the result passes `weft verify`, its mean quality is within 1 % of the run without the model, and in
subdomains the bytes are the same on all numbers of ranks. Skips loudly where the cases are not there. Exit code 1 where any
fails.
"""

import argparse
import hashlib
import json
import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
CASES = {  # name: mesh, model
    "hemisphere-cylinder": ("cad/hemisphere-cylinder/hsc01.meshb", "cad/hemisphere-cylinder/hemisph-cyl.egads"),
    "hemisphere-cylinder, STEP": ("cad/hemisphere-cylinder/hsc01.meshb", "cad/hemisphere-cylinder/hemisph-cyl.stp"),
    "revolve-cylinder": ("cad/revolve-cylinder/cylinder01.meshb", "cad/revolve-cylinder/cylinder.egads"),
    "revolve-pencil": ("cad/revolve-pencil/pencil.meshb", "cad/revolve-pencil/pencil.egads"),
    "cube-sphere": ("cad/cube-sphere/cube-sphere.meshb", "cad/cube-sphere/cube-sphere.egads"),
    "cone-cone": ("cad/cone-cone/cone-cone-no-geom.meshb", "cad/cone-cone/cone-cone.egads"),
    "cube-cylinder": ("ugawg/cube-cylinder.meshb", "ugawg/cube-cylinder.step"),
}
METRICS = {"curvature": ["--curvature", "24", "--hgrad", "1.5"], "polar-2": ["--metric-fn", "polar-2"]}
LEAST_OF_QUALITY = 0.99  # of that of the run without the model
SUBDOMAINS = 8
MPIRUN = ["mpirun", *(["--allow-run-as-root"] if os.geteuid() == 0 else []), "--oversubscribe", "--bind-to", "none", "--mca",
          "mpi_yield_when_idle", "1", "-n"]


class Case:
    def __init__(self, weft, cases, name, folder):
        mesh, model = CASES[name]
        self.weft, self.folder, self.mesh, self.model = weft, folder, cases / mesh, cases / model
        self.faults = []

    def adapt(self, words, on_model, ranks=0):
        """Measures, and of a mesh on the model how it lies there. `ranks`: in subdomains on so many."""
        out = self.folder / "out.meshb"
        command = [*([*MPIRUN, str(ranks)] if ranks > 1 else []), self.weft, "adapt", self.mesh, *words, "--threads", "1", "-o", out,
                   "--quiet", *(["--geometry", self.model] if on_model else []), *(["--subdomains", SUBDOMAINS] if ranks else [])]
        done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
        if done.returncode not in (0, 1):
            sys.exit(f"cad_cases: {' '.join(map(str, command))}: {done.stderr[-1000:]}")
        if subprocess.run([self.weft, "verify", out, "--quiet"]).returncode != 0:
            self.faults.append("the result does not conform")
        stat = [self.weft, "stat", out, "--metric", self.folder / "out.solb", "--json", *(["--geometry", self.model] if on_model else [])]
        told = json.loads(subprocess.run(list(map(str, stat)), capture_output=True, text=True, check=True).stdout)
        hashed = hashlib.sha256(out.read_bytes() + (self.folder / "out.solb").read_bytes()).hexdigest()
        if on_model:
            self.judge(told["model"])
        return told["measures"], told.get("model"), hashed

    def judge(self, account):
        if account["off"] > 0:
            self.faults.append(f"{account['off']} vertices off, the farthest by {account['largest']:.3g}")
        if account["least_normal"] < 0:
            self.faults.append(f"triangles are turned: {account['least_normal']:.3g}")

    def run(self, words, ranks):
        """A row of the table."""
        there, account, _ = self.adapt(words, True)
        without, _, _ = self.adapt(words, False)
        if there["quality"]["mean"] < LEAST_OF_QUALITY * without["quality"]["mean"]:
            self.faults.append("its mean quality is lower than without the model")
        hashes = {self.adapt(words, True, r)[2] for r in ranks}
        if len(hashes) > 1:
            self.faults.append("bytes differ between numbers of ranks")
        cells = []
        for m in (there, without):
            q = m["quality"]
            cells.append(f"{m['tets']:,} | {q['mean']:.4f} | {q['quantile_0.01']:.3f} | {q['min']:.3f} | {100 * m['edge_length']['share_unit']:.1f}")
        return " | ".join(cells) + f" | {account['largest']:.1e} | {account['least_normal']:.3f} | {'; '.join(self.faults) or 'holds'}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("weft", type=pathlib.Path)
    parser.add_argument("--cases", type=pathlib.Path, default=ROOT.parent / "shared/cases")
    parser.add_argument("--complexity", nargs="*", type=int, default=[10000, 100000])
    parser.add_argument("--only", nargs="*", default=list(CASES))
    parser.add_argument("--ranks", nargs="*", type=int, default=[1, 2, 4])
    asked = parser.parse_args()
    if not (asked.cases / "cad").is_dir():
        print(f"cad_cases: SKIPPED: {asked.cases} has no cases", file=sys.stderr)
        return 0
    faults = 0
    print("| case, metric, complexity | tets | Q mean | Q 1 % | least | unit % | tets without | Q mean | Q 1 % | least | unit % | farthest vertex | least normal | |")
    print("|---" * 14 + "|")
    for complexity in asked.complexity:
        for name in asked.only:
            for metric, words in METRICS.items():
                with tempfile.TemporaryDirectory(prefix="weft-cad-") as folder:
                    case = Case(asked.weft.resolve(), asked.cases, name, pathlib.Path(folder))
                    row = case.run([*words, "--complexity", complexity], asked.ranks)
                faults += len(case.faults) > 0
                print(f"| {name}, {metric}, {complexity:,} | {row} |", flush=True)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
