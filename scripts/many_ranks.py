#!/usr/bin/env python3
"""A run in subdomains on ranks that one thread simulates, beside the run on one rank and on real ranks.

On --ranks (1024) simulated ranks, under work stealing and diffusion: the same bytes as on one rank, a mesh that `weft
verify` passes, time and memory of the simulation. On --real (2, 4 and 8) ranks of mpirun and as many simulated, which
share this machine's cores as real ones do: the same bytes and values between subdomains, and without balancing the same
messages between subdomains on different ranks, by their kinds.

Balancing goes by measured times, so that runs of one command, real or simulated, differ among themselves, by up to 2.6
times in how many subdomains have moved: the median of --repeats simulated runs is compared with the range of as many real
ones. It is told by how far it lies outside; with --judge-moves, for a machine that has nothing else to do, more than a
tenth is an error.

Prints tables; ends with 1 where bytes, values or messages differ, or moves that are judged."""

import argparse
import hashlib
import json
import os
import subprocess
import statistics
import sys
import tempfile
import time
import pathlib

ROOT = pathlib.Path(__file__).resolve().parent.parent
BALANCERS = ("stealing", "diffusion")
ALLOWED = 0.1  # share by which moves may lie outside the range of real runs


class Runs:
    """Runs of one case in so many subdomains, beside that on one rank."""

    def __init__(self, options, folder, complexity, subdomains):
        self.options, self.folder, self.wrong = options, pathlib.Path(folder), 0
        self.complexity, self.subdomains = complexity, subdomains
        self.weft = str(pathlib.Path(options.weft).resolve())
        as_root = ["--allow-run-as-root"] if os.geteuid() == 0 else []
        self.mpirun = ["mpirun", *as_root, "--oversubscribe", "--bind-to", "none", "--mca", "mpi_yield_when_idle", "1"]
        self.call([self.weft, "mesh", "box", "-o", "box.meshb", "--cells", "6", "6", "6"])
        print(f"\nComplexity {complexity}, {subdomains} subdomains\n\n| run | bytes and values | messages between subdomains | moved | command s | took s | processor s | MB |\n"
              "|---|---|---|---|---|---|---|---|")
        self.expected = self.adapt([])
        self.compare("one rank", self.expected)

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
        measured = self.call([*launcher, self.weft, "adapt", "box.meshb", "--metric-fn", "polar-2", "--complexity", str(self.complexity),
                              "--subdomains", str(self.subdomains), "--threads", "1", "-o", "out.meshb", "--report", "report", "--quiet",
                              *map(str, more)], (0, 1))
        report = json.loads((self.folder / "report/report.json").read_text())
        graph = json.loads((self.folder / "report/graph.json").read_text())
        remote = {i for i, edge in enumerate(graph["graph"]["edges"]) if edge["kind"] == "remote"}
        engine = report["subdomains"]["engine"]
        measured["values"] = sorted((e, b) for e, b in zip(graph["uses"]["edge"], graph["uses"]["bytes"]) if e in remote)
        measured["hash"] = [hashlib.sha256((self.folder / name).read_bytes()).hexdigest() for name in ("out.meshb", "out.solb")]
        measured["engine"], measured["times"] = engine, report["seconds"]
        # Those of the ranks to each other besides depend on who waits when.
        measured["messages"] = {m["name"]: m["sent"] for m in engine["methods"] if m["name"].startswith("subdomain::")}
        measured["moves"] = engine["traffic"]["migrate"]["sent"]["messages"]
        return measured

    def on_real(self, ranks, balancer):
        run = self.adapt([*self.mpirun, "-n", str(ranks)], "--balancer", balancer)
        self.compare(f"{ranks} real ranks, {balancer}", run)
        return run

    def simulate(self, ranks, balancer, *more):
        run = self.adapt([], "--simulate-ranks", ranks, "--balancer", balancer, "--force", *more)
        self.compare(f"{ranks} simulated, {balancer}", run)
        return run

    def compare(self, name, run):
        """Prints a row of the table."""
        same = run["hash"] == self.expected["hash"] and run["values"] == self.expected["values"] and run["engine"]["consistent"]["pairs"]
        self.wrong += not same
        messages = sum(sent["messages"] for sent in run["messages"].values())
        print(f"| {name} | {'same' if same else 'DIFFER'} | {messages} | {run['moves']} | {run['times']['total']:.3g} | {run['seconds']:.3g} | "
              f"{run['cpu']:.3g} | {run['MB']:.0f} |", flush=True)

    def beside_real(self, ranks):
        """What is to be said of simulated ranks beside as many real ones."""
        cores = ("--simulate-cores", min(ranks, len(os.sched_getaffinity(0))))
        real, simulated = self.on_real(ranks, "none"), self.simulate(ranks, "none", *cores)
        same = real["messages"] == simulated["messages"] and real["moves"] == simulated["moves"] == 0
        self.wrong += not same
        said = [f"{ranks} ranks, without balancing: {'the same messages between subdomains, real and simulated' if same else 'messages DIFFER'}"]
        for balancer in BALANCERS:
            pairs = [(self.on_real(ranks, balancer)["moves"], self.simulate(ranks, balancer, *cores)["moves"])
                     for _ in range(self.options.repeats)]
            moves, of_simulated = zip(*pairs)
            off = outside(statistics.median(of_simulated), min(moves), max(moves))
            wrong = self.options.judge_moves and abs(off) > ALLOWED
            self.wrong += wrong
            where = "within their range" if off == 0 else f"{100 * abs(off):.0f} % {'above' if off > 0 else 'below'} their range"
            said.append(f"{ranks} ranks, {balancer}: {min(moves)} to {max(moves)} moves in {len(moves)} real runs, {min(of_simulated)} to "
                        f"{max(of_simulated)} in as many simulated, whose median is {where}{', WRONG' if wrong else ''}")
        return said


def outside(value, least, most):
    """How far it lies outside, as a share of the nearer end."""
    nearest = min(max(value, least), most)
    return (value - nearest) / max(nearest, 1)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--weft", default=ROOT / "build/bin/weft")
    parser.add_argument("--ranks", nargs="*", type=int, default=[1024])
    parser.add_argument("--complexity", type=int, default=2000, help="on --ranks (default 2000)")
    parser.add_argument("--subdomains", type=int, default=256, help="on --ranks (default 256)")
    parser.add_argument("--real", nargs="*", type=int, default=[2, 4, 8])
    parser.add_argument("--real-complexity", type=int, default=20_000, help="on --real ranks: tasks that are worth moving (default 20,000)")
    parser.add_argument("--real-subdomains", type=int, default=64, help="on --real ranks (default 64)")
    parser.add_argument("--repeats", type=int, default=3, help="of each run under a balancer, real and simulated (default 3)")
    parser.add_argument("--judge-moves", action="store_true", help="a median of simulated moves more than 10 %% outside the range of real ones is an error")
    options = parser.parse_args()
    if options.repeats < 1:
        parser.error("--repeats: at least 1")
    wrong = 0
    with tempfile.TemporaryDirectory(prefix="weft-many-ranks-") as folder:
        if options.real:
            runs = Runs(options, folder, options.real_complexity, options.real_subdomains)
            said = [line for ranks in options.real for line in runs.beside_real(ranks)]
            print("\n" + "\n".join(f"- {line}" for line in said), flush=True)
            wrong += runs.wrong
        if options.ranks:
            runs = Runs(options, folder, options.complexity, options.subdomains)
            for balancer in BALANCERS:
                for ranks in options.ranks:
                    runs.simulate(ranks, balancer)
                    runs.call([runs.weft, "verify", "out.meshb", "--against", "box.meshb"])
            wrong += runs.wrong
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
