#!/usr/bin/env python3
"""A run in subdomains on ranks that one thread simulates, beside the run on one rank and on real ranks.

On --ranks (1024) simulated ranks, under work stealing and diffusion: the same bytes as on one rank, a mesh that `weft
verify` passes, time and memory of the simulation. On --real (2 and 4) ranks of mpirun and as many simulated: the same
bytes, as many values between subdomains, and how many subdomains have moved. Prints tables; ends with 1 where bytes or
values differ."""

import argparse
import hashlib
import json
import os
import subprocess
import sys
import tempfile
import time
import pathlib

ROOT = pathlib.Path(__file__).resolve().parent.parent
BALANCERS = ("stealing", "diffusion")


class Runs:
    def __init__(self, options, folder):
        self.options, self.folder, self.wrong = options, pathlib.Path(folder), 0
        self.weft = str(pathlib.Path(options.weft).resolve())
        self.call([self.weft, "mesh", "box", "-o", "box.meshb", "--cells", "6", "6", "6"])

    def call(self, words, allowed=(0,)):
        """Seconds and MB of the process."""
        begin = time.monotonic()
        with open(self.folder / "log", "w") as log:
            process = subprocess.Popen(words, cwd=self.folder, stdout=log, stderr=subprocess.STDOUT)
            _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode not in allowed:
            sys.exit(f"many_ranks: {' '.join(words)} has ended with {process.returncode}:\n{(self.folder / 'log').read_text()[-2000:]}")
        return {"seconds": time.monotonic() - begin, "cpu": usage.ru_utime + usage.ru_stime, "MB": usage.ru_maxrss / 1024}

    def adapt(self, launcher, *more):
        o = self.options
        measured = self.call([*launcher, self.weft, "adapt", "box.meshb", "--metric-fn", "polar-2", "--complexity", str(o.complexity), "--subdomains",
                              str(o.subdomains), "--threads", "1", "-o", "out.meshb", "--report", "report", "--quiet", *map(str, more)], (0, 1))
        report = json.loads((self.folder / "report/report.json").read_text())
        graph = json.loads((self.folder / "report/graph.json").read_text())
        remote = {i for i, edge in enumerate(graph["graph"]["edges"]) if edge["kind"] == "remote"}
        measured["values"] = sorted((e, b) for e, b in zip(graph["uses"]["edge"], graph["uses"]["bytes"]) if e in remote)
        measured["hash"] = [hashlib.sha256((self.folder / name).read_bytes()).hexdigest() for name in ("out.meshb", "out.solb")]
        measured["engine"], measured["times"] = report["subdomains"]["engine"], report["seconds"]
        return measured

    def simulate(self, ranks, balancer):
        return self.adapt([], "--simulate-ranks", ranks, "--balancer", balancer, "--force")

    def compare(self, name, run, expected):
        same = run["hash"] == expected["hash"] and run["values"] == expected["values"] and run["engine"]["consistent"]["pairs"]
        self.wrong += not same
        migrations = run["engine"]["traffic"]["migrate"]["sent"]["messages"]
        messages = run["engine"]["traffic"]["invoke"]["sent"]["messages"]
        print(f"| {name} | {'same' if same else 'DIFFER'} | {messages} | {migrations} | {run['times']['total']:.3g} | {run['seconds']:.3g} | {run['cpu']:.3g} | "
              f"{run['MB']:.0f} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--weft", default=ROOT / "build/bin/weft")
    parser.add_argument("--ranks", nargs="*", type=int, default=[1024])
    parser.add_argument("--real", nargs="*", type=int, default=[2, 4])
    parser.add_argument("--subdomains", type=int, default=256, help="(default 256)")
    parser.add_argument("--complexity", type=int, default=2000, help="(default 2000)")
    options = parser.parse_args()
    mpirun = ["mpirun", *(["--allow-run-as-root"] if os.geteuid() == 0 else []), "--oversubscribe", "--bind-to", "none", "--mca", "mpi_yield_when_idle", "1"]
    with tempfile.TemporaryDirectory(prefix="weft-many-ranks-") as folder:
        runs = Runs(options, folder)
        print("| run | bytes and values | messages between ranks | moved | command s | took s | processor s | MB |\n|---|---|---|---|---|---|---|---|")
        one = runs.adapt([])
        runs.compare("one rank", one, one)
        for balancer in BALANCERS:
            for ranks in options.real:
                runs.compare(f"{ranks} real ranks, {balancer}", runs.adapt([*mpirun, "-n", str(ranks)], "--balancer", balancer), one)
                runs.compare(f"{ranks} simulated, {balancer}", runs.simulate(ranks, balancer), one)
            for ranks in options.ranks:
                runs.compare(f"{ranks} simulated, {balancer}", runs.simulate(ranks, balancer), one)
                runs.call([runs.weft, "verify", "out.meshb", "--against", "box.meshb"])
        return 1 if runs.wrong else 0


if __name__ == "__main__":
    sys.exit(main())
