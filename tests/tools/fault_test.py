"""One call fails or is late, by number: writes on a full disk, reads, fsync, rename, open, fork, allocations, address space, calls of MPI ... However
a run ends, the files that were there are whole: the old ones, or the new ones. What is late changes nothing.

WEFT_FAULTS: how many points of each kind are tried in each mode (nightly: 250), a sixth of it on ranks.
WEFT_FAULT_SEED: which.
"""

import collections
import json
import math
import os
import random
import re
import subprocess
import typing
import unittest

from command import WEFT, CommandTest, solution_text

SHIM = os.environ["WEFT_FAULT_SHIM"]
MPIRUN = os.environ["WEFT_MPIRUN"].split(";")
FAULTS = int(os.environ.get("WEFT_FAULTS", "2"))
SEED = int(os.environ.get("WEFT_FAULT_SEED", "4"))
SECONDS = 120
RANKS = 2
LATE = 0.2  # seconds


class Mode(typing.NamedTuple):
    """How `weft adapt` is called."""

    words: tuple = ()
    ranks: int = 0
    mesh: str = "box.meshb"
    metric: tuple = ("--metric-fn", "uniform:0.3")
    out: str = "out.meshb"
    beside: tuple = ("--quiet",)

    def results(self):
        """The mesh, its metric, and what is carried along."""
        return {self.out, "out.solb"} | ({"out-fields.solb"} if "--field" in self.words else set())


SUBDOMAINS = ("--subdomains", 3, "--threads", 1)
CHECKPOINTS = ("--checkpoint", "ck", "--checkpoint-every", "0.01")
SOLUTION = ("--sol", "f.sol", "--complexity", 40, "--hgrad", "1.3")
MODES = {
    "one mesh": Mode(),
    "threads": Mode(("--threads", 2)),
    "subdomains": Mode(SUBDOMAINS),
    "checkpoints of one mesh": Mode(("--threads", 1, *CHECKPOINTS)),
    "checkpoints": Mode((*SUBDOMAINS, *CHECKPOINTS)),
    "resumed": Mode(("--threads", 1, "--resume", "one")),
    "resumed subdomains": Mode((*SUBDOMAINS, "--resume", "parts")),
    "CGNS": Mode(("--threads", 1), out="out.cgns"),
    "VTU": Mode(("--threads", 1), out="out.vtu"),
    "report": Mode(("--threads", 1, "--report", "r")),
    "report of subdomains": Mode((*SUBDOMAINS, "--report", "r", "--trace", "r/trace.json", "--graph", "r/graph.json")),
    "repair": Mode(("--threads", 1, "--repair", "--report", "r"), mesh="bad.mesh"),
    "fields": Mode(("--threads", 1, "--field", "f.sol")),
    "solution": Mode(("--threads", 1), metric=SOLUTION),
    "solution in subdomains": Mode(SUBDOMAINS, metric=SOLUTION),
    "ranks": Mode(SUBDOMAINS, RANKS),
    "ranks with checkpoints": Mode((*SUBDOMAINS, *CHECKPOINTS), RANKS),
}
ALWAYS = {"write", "read", "fsync", "close", "rename", "open", "new", "map"}  # calls that every run makes


class Faults(CommandTest):
    def setUp(self):
        super().setUp()
        self.box(2)
        self.write("f.sol", solution_text([(math.sin(i * i),) for i in range(27)], kind=1))
        self.box(2, "box.mesh")
        turned = re.sub(r"(Tetrahedra\s+\d+\s+)(\d+) (\d+)", r"\1\3 \2", (self.folder / "box.mesh").read_text())
        self.write("bad.mesh", turned)
        (self.folder / "r").mkdir()
        for folder, words in (("one", ()), ("parts", SUBDOMAINS)):
            self.weft("adapt", "box.meshb", *MODES["one mesh"].metric, "-o", "out.meshb", "--quiet", *words,
                      "--checkpoint", folder, "--checkpoint-every", "0.01")
        for out in sorted({mode.out for mode in MODES.values()}):
            # Finer than what any run here is to make: the mesh of a run that ended early must not be that by chance.
            self.weft("adapt", "box.meshb", "--metric-fn", "uniform:0.21", "-o", out, "--field", "f.sol", "--threads", 1, "--quiet")
        self.old = {name: (self.folder / name).read_bytes() for name in set().union(*(mode.results() for mode in MODES.values()))}

    def run_with(self, fault, mode, rank=0):
        # MPICH's UCX puts itself in the place of mmap, also of the shim's.
        fault_words = {"UCX_MEM_MMAP_HOOK_MODE": "none", "LD_PRELOAD": SHIM, "WEFT_FAULT": fault, "WEFT_FAULT_COUNT": str(self.folder / "count"), "WEFT_FAULT_RANK": str(rank)}
        launcher = [*MPIRUN, "-n", str(mode.ranks)] if mode.ranks else []
        return subprocess.run([*launcher, "env", *(f"{name}={value}" for name, value in fault_words.items()), str(WEFT), "adapt", mode.mesh,
                               *map(str, (*mode.metric, "-o", mode.out, *mode.beside, *mode.words))],
                              cwd=self.folder, capture_output=True, text=True, timeout=SECONDS)

    def calls(self, mode, rank=0):
        """How many calls of each kind a run makes; the results have their old bytes again."""
        done = self.run_with("none:0", mode, rank)
        self.assertIn(done.returncode, (0, 1), done.stderr)
        self.assertEqual(self.new_results(), mode.results())
        self.take_results()
        lines = (self.folder / "count").read_text().split()
        counts = dict(zip(lines[::2], map(int, lines[1::2])))
        needed = ALWAYS | ({"mpi"} if mode.ranks else set()) | ({"fork"} if mode.out == "out.cgns" else set())
        if rank == 0:
            self.assertEqual([kind for kind in needed if counts[kind] == 0], [], f"calls are not seen: {counts}")
        return counts

    @staticmethod
    def points(chance, count, ranks):
        """Which of `count` calls fail; runs on ranks take longer."""
        return chance.sample(range(1, count + 1), min(max(1, FAULTS // 6) if ranks else FAULTS, count))

    def new_results(self):
        return {name for name, old in self.old.items() if (self.folder / name).read_bytes() != old}

    def take_results(self):
        """The files of results, which get their old bytes back."""
        now = {}
        for name, old in self.old.items():
            now[name] = (self.folder / name).read_bytes()
            (self.folder / name).write_bytes(old)
        return now

    def assert_nothing_is_lost(self, done, kind, mode, told):
        # An MPI that cannot start or end ends the run by itself, with a code of its own; 128 and more are signals.
        # By whatever call: MPICH, or UCX below it, which may end without MPICH's words.
        of_mpi = kind in ("mpi", "shm") or re.search(r"Fatal error in internal_Init|UCX +ERROR", done.stderr)
        codes = range(128) if mode.ranks and of_mpi else (0, 1, 2)
        self.assertIn(done.returncode, codes, told)
        if done.returncode == 2 and not mode.ranks:
            self.assertTrue(done.stderr.startswith(("weft", "error")), told)
        elif done.returncode == 2:
            # Open MPI's mpirun may lose what a rank wrote before MPI_Abort, and complains of itself then.
            self.assertRegex(done.stderr, r"(?m)^(weft|error)|ORTE_ERROR_LOG", told)
        new = self.new_results()
        if mode.out in new:
            self.weft("verify", mode.out, "--against", "box.meshb")
        if not mode.ranks:  # MPI may end another rank between two renames
            without_fields = {mode.out, "out.solb"} if done.returncode == 1 else set()
            self.assertIn(new, (set(), mode.results(), without_fields), told)
        self.take_results()
        for account in (self.folder / "r").glob("*.json"):
            text = account.read_text()
            account.unlink()
            json.loads(text)
        left = [name for name in self.files() if name.startswith(".weft")]
        self.assertEqual(left, [], told)

    def every_point(self):
        """Mode, rank, kind, and the fault."""
        chance = random.Random(SEED)
        for name, mode in MODES.items():
            for rank in range(max(1, mode.ranks)):
                for kind, count in self.calls(mode, rank).items():
                    for point in sorted(self.points(chance, count, mode.ranks)):
                        yield name, rank, kind, f"{kind}:{point}"

    def test_every_kind_in_every_mode(self):
        ends = collections.Counter()
        for name, rank, kind, fault in self.every_point():
            with self.subTest(fault=fault, mode=name, rank=rank):
                done = self.run_with(fault, MODES[name], rank)
                told = f"{fault} in {name}, rank {rank}: exit {done.returncode}\n{done.stdout}{done.stderr}"
                ends[kind, done.returncode] += 1
                self.assert_nothing_is_lost(done, kind, MODES[name], told)
        print("\nkind, exit code: runs")
        for (kind, code), count in sorted(ends.items()):
            print(f"{kind:7} {code:4}: {count}")

    def test_allocations_of_the_start_fail(self):
        """Those of tables that are made once, such as that of the options, which no other allocation of a run is like."""
        mode = MODES["checkpoints of one mesh"]
        for point in range(1, 131):
            done = self.run_with(f"new:{point}", mode)
            self.assert_nothing_is_lost(done, "new", mode, f"new:{point}: exit {done.returncode}\n{done.stdout}{done.stderr}")

    def test_ranks_whose_first_reads_fail(self):
        """Those of the launcher's processes, before MPI starts."""
        for point in range(1, 5):
            done = self.run_with(f"read:{point}", MODES["ranks"])
            self.assert_nothing_is_lost(done, "read", MODES["ranks"], f"read:{point}: exit {done.returncode}\n{done.stdout}{done.stderr}")

    def test_an_allocation_that_fails_in_a_pass_leaves_a_mesh(self):
        """The adaptation ends there; what it has is whole, and is written. Few allocations are in a pass."""
        for name in ("one mesh", "subdomains"):
            mode = MODES[name]._replace(beside=("--progress", "none"))
            count = self.calls(mode)["new"]
            left = 0
            for point in random.Random(SEED).sample(range(1, count + 1), count):
                done = self.run_with(f"new:{point}", mode)
                told = f"new:{point} of {count} in {name}: exit {done.returncode}\n{done.stdout}{done.stderr}"
                left += done.returncode == 1 and "out of memory: this is the valid mesh" in done.stdout
                self.assert_nothing_is_lost(done, "new", mode, told)
                if left == 2:
                    break
            self.assertEqual(left, 2, name)

    def test_arrays_that_cannot_grow_leave_a_mesh(self):
        """Those of a subdomain that was small when its room was reserved: each growth from the N-th on is refused."""
        self.box(1, "cell.meshb")
        mode = MODES["subdomains"]._replace(beside=("--progress", "none"), mesh="cell.meshb", metric=("--metric-fn", "uniform:0.035"))
        count = self.calls(mode)["grow"]
        self.assertGreater(count, 0)
        for point in sorted({1, 2, count // 2, count}):
            done = self.run_with(f"grow:{point}", mode)
            told = f"grow:{point} of {count}: exit {done.returncode}\n{done.stdout}{done.stderr}"
            self.assertNotEqual(done.returncode, 0, told)
            self.assert_nothing_is_lost(done, "grow", mode, told)

    def test_an_allocation_that_fails_once_the_mesh_is_there_costs_the_fields_alone(self):
        mode = MODES["fields"]._replace(beside=("--progress", "none"))
        count = self.calls(mode)["new"]
        chance, without = random.Random(SEED), 0
        for point in chance.sample(range(count * 4 // 5, count), count // 5):  # the last ones, and a few before
            done = self.run_with(f"new:{point}", mode)
            told = f"new:{point} of {count}: exit {done.returncode}\n{done.stdout}{done.stderr}"
            if "the fields are not carried along" in done.stdout:
                without += 1
                self.assertEqual(done.returncode, 1, told)
                self.assertNotEqual((self.folder / "out.meshb").read_bytes(), self.old["out.meshb"], told)
            self.assert_nothing_is_lost(done, "new", mode, told)
            if without == 3:
                break
        self.assertEqual(without, 3)

    def test_what_is_late_changes_nothing(self):
        chance = random.Random(SEED)
        for name in ("subdomains", "ranks"):
            mode = MODES[name]
            for rank in range(max(1, mode.ranks)):
                counts = self.calls(mode, rank)
                self.run_with("none:0", mode, rank)
                right = self.take_results()
                for kind in ("write", "read", "rename", "mpi"):
                    for point in self.points(chance, counts[kind], mode.ranks):
                        fault = f"{kind}:{point}:{LATE}"
                        done = self.run_with(fault, mode, rank)
                        told = f"{fault} in {name}, rank {rank}\n{done.stdout}{done.stderr}"
                        self.assertIn(done.returncode, (0, 1), told)
                        self.assertEqual(self.take_results(), right, told)


if __name__ == "__main__":
    unittest.main()
