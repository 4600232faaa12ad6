#!/usr/bin/env python3
"""Runs that are killed at random moments, and go on from their checkpoints on other ranks and threads until they are done.

    kill_runs.py WEFT [--runs N] [--limits N] [--seed N] [--ranks R] [--size F] [--keep DIR] [--case SEED]

Killed (SIGKILL) are any rank, rank 0, two ranks, mpirun itself, or all at once, as a power cut does; one mesh in one process, with one
thread and more, subdomains, and ranks, some with `--check`. A quarter are interrupted instead (SIGALRM). The result must pass `weft verify`, and where all had one thread its bytes must be those of
the run that nobody disturbs. Besides, `--limits` runs have a `--time-limit` at random: they must end within it and two seconds more,
with a valid mesh. Ends with a table of counts by kind; exit code 1 where any failed: its command lines are printed, and its files
with these lines are kept in DIR, to be run again by `--case SEED`.
"""

import argparse
import collections
import hashlib
import os
import pathlib
import random
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time

from ranks import is_weft, ranks_of

SECONDS = 300  # far above what any of these takes
AT_START = 0.3  # that mpirun takes until its ranks begin
OF_MPIRUN = 1  # Open MPI's mpirun waits that long after a rank has ended with another code than 0
MPIRUN = [*os.environ.get("WEFT_MPIRUN", "mpirun;--oversubscribe;--bind-to;none").split(";"), "-n"]
INTERRUPTED = 0.25  # of those that are struck: by a signal that ends them early
MOST_KILLS = 4  # of a run; then it is left alone
# Name, how the mesh is made, the metric, the complexity.
MESHES = {
    "box": (["box", "--cells", 6, 6, 6], ["--metric-fn", "polar-2"], 4000),
    "coarse box": (["box", "--cells", 1, 1, 1], ["--metric-fn", "polar-1"], 3000),
    "ball": (["ball", "--size", 0.3], ["--curvature", 12], 3000),
}
MODES = ("one mesh", "subdomains", "ranks", "ranks")


class Failure(Exception):
    """Says what is wrong."""


class Run:
    """One run in a folder of its own, killed until it is done."""

    def __init__(self, weft, seed, folder, most_ranks, size, grace):
        self.weft, self.folder = weft, folder
        self.random = random.Random(seed)
        self.mesh = self.random.choice(list(MESHES))
        self.mode = self.random.choice(MODES)
        self.one_thread = self.random.random() < 0.6
        self.subdomains = self.random.choice((2, 5, 9))
        self.checked = self.mode != "one mesh" and self.random.random() < 0.25
        self.most_ranks, self.size, self.grace = most_ranks, size, grace
        self.lines, self.kinds = [], collections.Counter()

    def kind(self):
        return self.mode + ("" if self.one_thread else ", threads") + (", checked" if self.checked else "")

    def make_mesh(self):
        words, self.metric, complexity = MESHES[self.mesh]
        self.complexity = round(self.size * complexity)
        self.call("mesh", *words, "-o", "start.meshb", "--quiet")

    def call(self, *words, codes=(0,)):
        done = subprocess.run([self.weft, *map(str, words)], cwd=self.folder, capture_output=True, text=True, timeout=SECONDS, check=False)
        if done.returncode not in codes:
            raise Failure(f"code {done.returncode} of {shlex.join(map(str, words))}\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
        return done.stdout

    def adaptation(self, threads, *words):
        parts = ["--subdomains", self.subdomains] if self.mode != "one mesh" else []
        parts += ["--check"] if self.checked else []
        return ["adapt", "start.meshb", *self.metric, "--complexity", self.complexity, *parts, "--threads", threads, "--progress", "none",
                *words]

    def reference(self):
        """Seconds that the run takes undisturbed, and its bytes with one thread."""
        begin = time.monotonic()
        self.call(*self.adaptation(1, "-o", "whole.meshb"), codes=(0, 1))
        return time.monotonic() - begin, self.digest("whole")

    def digest(self, name):
        return hashlib.sha256(b"".join((self.folder / (name + end)).read_bytes() for end in (".meshb", ".solb"))).hexdigest()

    def start(self, ranks, words):
        launcher = [*MPIRUN, str(ranks)] if self.mode == "ranks" else []
        command = [*launcher, self.weft, *map(str, words)]
        self.lines.append(shlex.join(command))
        with open(self.folder / "log", "w", encoding="utf-8") as log:
            return subprocess.Popen(command, cwd=self.folder, stdout=log, stderr=log, start_new_session=True)

    def log(self):
        return (self.folder / "log").read_text(errors="replace")

    def attempt(self, every, after):
        """Whether it has come to its end: `after` seconds, if any, somebody is killed."""
        threads = 1 if self.one_thread else self.random.randint(1, 3)
        ranks = self.random.randint(1, self.most_ranks)
        process = self.start(ranks, self.adaptation(threads, "--checkpoint", "ck", "--checkpoint-every", every, "--resume", "ck",
                                                    "-o", "out.meshb"))
        if after is not None:
            self.wait(process, after)
            if process.poll() is None:
                self.kill(process, after)
                return False
        self.end(process, SECONDS)
        if process.returncode not in (0, 1):
            raise Failure(f"code {process.returncode}\n{self.log()[-3000:]}")
        self.kinds["gone on" if "gone on from checkpoint" in self.log() else "begun anew"] += 1
        return True

    @staticmethod
    def wait(process, seconds):
        try:
            process.wait(seconds)
        except subprocess.TimeoutExpired:
            pass

    def end(self, process, seconds):
        try:
            process.wait(seconds)
        except subprocess.TimeoutExpired:
            strike(process.pid, *ranks_of(process.pid))
            raise Failure(f"no end within {seconds} s\n{self.log()[-3000:]}") from None

    def kill(self, process, after):
        ranks = ranks_of(process.pid) if self.mode == "ranks" else []
        victims = {"all": [process.pid, *ranks]}
        if ranks:
            victims |= {"a rank": [self.random.choice(ranks)], "rank 0": ranks[:1], "mpirun": [process.pid]}
        if len(ranks) > 1:
            victims["two ranks"] = self.random.sample(ranks, 2)
        if self.random.random() < INTERRUPTED:  # it ends with the mesh that it has; who goes on wants the whole one
            what = "interrupted"
            process.send_signal(signal.SIGALRM)
        else:
            name = self.random.choice(sorted(victims))
            what = f"killed: {name}"
            strike(*victims[name])
        self.lines.append(f"# after {after:.3f} s {what}")
        self.kinds[what] += 1
        self.end(process, SECONDS)
        deadline = time.monotonic() + SECONDS  # the ranks of a dead mpirun end by themselves, but later
        while any(is_weft(rank) for rank in ranks):
            if time.monotonic() > deadline:
                strike(*ranks)
                raise Failure(f"ranks outlive what was {what} by {SECONDS} s")
            time.sleep(0.05)
        if (self.folder / "out.meshb").exists():  # the moment was after the end: what is there is whole
            self.verify()

    def verify(self):
        against = ["--against", "start.meshb"] if self.mesh != "ball" else []
        self.call("verify", "out.meshb", *against, "--quiet")

    def killed(self):
        self.make_mesh()
        seconds, expected = self.reference()
        every = round(self.random.uniform(0.005, 0.05) * seconds, 4)
        kills = self.random.randint(1, MOST_KILLS)
        for left in range(kills, -1, -1):
            if self.attempt(every, self.random.uniform(0.2, 1.5) * seconds + (AT_START if self.mode == "ranks" else 0) if left else None):
                break
        self.verify()
        if self.one_thread:
            if self.digest("out") != expected:
                raise Failure("bytes differ from those of the undisturbed run")
            self.kinds["equal bytes"] += 1
        self.kinds["valid mesh"] += 1

    def limited(self):
        """The limit is anything from nothing to more than enough."""
        self.make_mesh()
        seconds, _ = self.reference()
        limit = round(self.random.uniform(0.05, 1.2 * seconds), 3)
        begin = time.monotonic()
        process = self.start(min(2, self.most_ranks), self.adaptation(1 if self.one_thread else 2, "--time-limit", limit, "-o", "out.meshb"))
        self.end(process, SECONDS)
        over = time.monotonic() - begin - limit - (OF_MPIRUN if self.mode == "ranks" else 0)
        if process.returncode not in (0, 1):
            raise Failure(f"code {process.returncode}\n{self.log()[-3000:]}")
        if over > self.grace:
            raise Failure(f"ended {over:.1f} s after its limit of {limit} s")
        self.verify()
        self.kinds["ended by its limit" if "time limit" in self.log() else "done before its limit"] += 1
        self.kinds["valid mesh"] += 1


def strike(*pids):
    for pid in pids:
        try:
            os.kill(pid, signal.SIGKILL)
        except ProcessLookupError:
            pass


def table(counts):
    columns = ["runs", "valid mesh", "equal bytes", "gone on", "begun anew", "ended by its limit", "FAILED"]
    columns += sorted({what for _, what in counts} - set(columns))
    print(f"{'':34}" + "".join(f"{c:>{len(c) + 2}}" for c in columns))
    kinds = sorted({kind for kind, _ in counts})
    rows = [(kind, [counts[kind, c] for c in columns]) for kind in kinds]
    for kind, row in [*rows, ("all", [sum(counts[kind, c] for kind in kinds) for c in columns])]:
        print(f"{kind:34}" + "".join(f"{n:>{len(c) + 2}}" for c, n in zip(columns, row)))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("weft", help="the command")
    parser.add_argument("--runs", type=int, default=200)
    parser.add_argument("--limits", type=int, help="runs with a time limit besides; default: a quarter")
    parser.add_argument("--seed", type=int, default=random.SystemRandom().randrange(10**6))
    parser.add_argument("--ranks", type=int, default=4, help="at most")
    parser.add_argument("--size", type=float, default=1, help="of the meshes, as a factor")
    parser.add_argument("--grace", type=float, default=2, help="seconds that a run may take beyond its limit; more on a loaded machine")
    parser.add_argument("--keep", type=pathlib.Path, default=pathlib.Path("kill-failures"))
    parser.add_argument("--case", type=int, help="run this one again: SEED, negative for one with a limit")
    asked = parser.parse_args()
    weft = str(pathlib.Path(asked.weft).resolve())
    os.environ.update(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
    limits = asked.runs // 4 if asked.limits is None else asked.limits
    seeds = [asked.seed * 10**6 + i + 1 for i in range(asked.runs)] + [-(asked.seed * 10**6 + i + 1) for i in range(limits)]
    counts, failures, begin = collections.Counter(), 0, time.monotonic()
    for seed in [asked.case] if asked.case else seeds:
        with tempfile.TemporaryDirectory(prefix="weft-kill-") as name:
            run = Run(weft, seed, pathlib.Path(name), asked.ranks, asked.size, asked.grace)
            kind = run.kind() if seed > 0 else "time limit, " + run.kind()
            counts[kind, "runs"] += 1
            try:
                if seed > 0:
                    run.killed()
                else:
                    run.limited()
            except Failure as failure:
                failures += 1
                counts[kind, "FAILED"] += 1
                told = "\n".join([f"# case {seed}, {run.mesh}, {kind}: {failure}", *run.lines])
                print(told, flush=True)
                target = asked.keep / f"case{seed}"
                shutil.copytree(run.folder, target, dirs_exist_ok=True)
                (target / "lines").write_text(told + "\n")
            for what, count in run.kinds.items():
                counts[kind, what] += count
    table(counts)
    print(f"seed {asked.seed}: {sum(n for (_, what), n in counts.items() if what == 'runs')} runs, {failures} failed, "
          f"{time.monotonic() - begin:.0f} s")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
