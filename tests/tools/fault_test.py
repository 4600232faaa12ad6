"""One call fails or is late, by number: writes on a full disk, reads, fsync, rename, open, fork, allocations, address space, calls of MPI ... However
a run ends, the files that were there are whole: the old ones, or the new ones. What is late changes nothing.

WEFT_FAULTS: how many points of each kind are tried in each mode (nightly: 250), a sixth of it on ranks.
WEFT_FAULT_SEED: which.
"""

import collections
import os
import random
import subprocess
import unittest

from command import WEFT, CommandTest, solution_text

SHIM = os.environ["WEFT_FAULT_SHIM"]
MPIRUN = os.environ["WEFT_MPIRUN"].split(";")
FAULTS = int(os.environ.get("WEFT_FAULTS", "2"))
SEED = int(os.environ.get("WEFT_FAULT_SEED", "4"))
SECONDS = 120
RANKS = 2
LATE = 0.2  # seconds
MODES = {
    "one mesh": (0, ()),
    "threads": (0, ("--threads", 2)),
    "subdomains": (0, ("--subdomains", 3, "--threads", 1)),
    "checkpoints of one mesh": (0, ("--threads", 1, "--checkpoint", "ck", "--checkpoint-every", "0.01")),
    "checkpoints": (0, ("--subdomains", 3, "--threads", 1, "--checkpoint", "ck", "--checkpoint-every", "0.01")),
    "CGNS": (0, ("--threads", 1, "-o", "out.cgns")),
    "ranks": (RANKS, ("--subdomains", 3, "--threads", 1)),
    "ranks with checkpoints": (RANKS, ("--subdomains", 3, "--threads", 1, "--checkpoint", "ck", "--checkpoint-every", "0.01")),
}
ALWAYS = {"write", "read", "fsync", "close", "rename", "open", "new", "map"}  # calls that every run makes


class Faults(CommandTest):
    def setUp(self):
        super().setUp()
        self.box(2)
        self.weft("adapt", "box.meshb", "--metric-fn", "uniform:0.5", "-o", "out.meshb", "--threads", 1, "--quiet")
        self.weft("adapt", "box.meshb", "--metric-fn", "uniform:0.5", "-o", "out.cgns", "--threads", 1, "--quiet")
        self.old = {name: (self.folder / name).read_bytes() for name in ("out.meshb", "out.solb", "out.cgns")}

    def run_with(self, fault, mode, rank=0, words_beside=("--quiet",), mesh="box.meshb", metric="uniform:0.3"):
        ranks, words = MODES[mode]
        fault_words = {"LD_PRELOAD": SHIM, "WEFT_FAULT": fault, "WEFT_FAULT_COUNT": str(self.folder / "count"), "WEFT_FAULT_RANK": str(rank)}
        launcher = [*MPIRUN, "-n", str(ranks)] if ranks else []
        out = () if "-o" in words else ("-o", "out.meshb")
        return subprocess.run([*launcher, "env", *(f"{name}={value}" for name, value in fault_words.items()), str(WEFT), "adapt", mesh,
                               "--metric-fn", metric, *out, *words_beside, *map(str, words)],
                              cwd=self.folder, capture_output=True, text=True, timeout=SECONDS)

    def calls(self, mode, rank, *words, **more_words):
        done = self.run_with("none:0", mode, rank, *words, **more_words)
        self.assertIn(done.returncode, (0, 1), done.stderr)
        lines = (self.folder / "count").read_text().split()
        counts = dict(zip(lines[::2], map(int, lines[1::2])))
        needed = ALWAYS | ({"mpi"} if MODES[mode][0] else set()) | ({"fork"} if mode == "CGNS" else set())
        if rank == 0:
            self.assertEqual([kind for kind in needed if counts[kind] == 0], [], f"calls are not seen: {counts}")
        return counts

    @staticmethod
    def points(chance, count, ranks):
        """Which of `count` calls fail; runs on ranks take longer."""
        return chance.sample(range(1, count + 1), min(max(1, FAULTS // 6) if ranks else FAULTS, count))

    def take_results(self):
        """The files of results, which get their old bytes back."""
        now = {}
        for name, old in self.old.items():
            now[name] = (self.folder / name).read_bytes()
            (self.folder / name).write_bytes(old)
        return now

    def assert_nothing_is_lost(self, done, kind, on_ranks, told):
        # An MPI that cannot start or end ends the run by itself, with a code of its own; 128 and more are signals.
        codes = range(128) if on_ranks and kind in ("mpi", "shm") else (0, 1, 2)
        self.assertIn(done.returncode, codes, told)
        if done.returncode == 2 and not on_ranks:
            self.assertTrue(done.stderr.startswith(("weft", "error")), told)
        elif done.returncode == 2:
            # Open MPI's mpirun may lose what a rank wrote before MPI_Abort, and complains of itself then.
            self.assertRegex(done.stderr, r"(?m)^(weft|error)|ORTE_ERROR_LOG", told)
        new = {name for name, old in self.old.items() if (self.folder / name).read_bytes() != old}
        for name in new - {"out.solb"}:
            self.weft("verify", name, "--against", "box.meshb")
        if not on_ranks:  # MPI may end another rank between two renames
            self.assertIn(len(new), (0, 2), f"{told}\nnew: {new}")
        self.take_results()
        left = [name for name in self.files() if name.startswith(".weft")]
        self.assertEqual(left, [], told)

    def every_point(self):
        """Mode, rank, kind, and the fault."""
        chance = random.Random(SEED)
        for mode, (ranks, _) in MODES.items():
            for rank in range(max(1, ranks)):
                counts = self.calls(mode, rank)
                self.take_results()
                for kind, count in counts.items():
                    for point in sorted(self.points(chance, count, ranks)):
                        yield mode, rank, kind, f"{kind}:{point}"

    def test_every_kind_in_every_mode(self):
        ends = collections.Counter()
        for mode, rank, kind, fault in self.every_point():
            with self.subTest(fault=fault, mode=mode, rank=rank):
                done = self.run_with(fault, mode, rank)
                told = f"{fault} in {mode}, rank {rank}: exit {done.returncode}\n{done.stdout}{done.stderr}"
                ends[kind, done.returncode] += 1
                self.assert_nothing_is_lost(done, kind, MODES[mode][0] > 0, told)
        print("\nkind, exit code: runs")
        for (kind, code), count in sorted(ends.items()):
            print(f"{kind:7} {code:4}: {count}")

    def test_ranks_whose_first_reads_fail(self):
        """Those of the launcher's processes, before MPI starts."""
        for point in range(1, 5):
            done = self.run_with(f"read:{point}", "ranks")
            self.assert_nothing_is_lost(done, "read", True, f"read:{point}: exit {done.returncode}\n{done.stdout}{done.stderr}")

    def test_an_allocation_that_fails_in_a_pass_leaves_a_mesh(self):
        """The adaptation ends there; what it has is whole, and is written. Few allocations are in a pass."""
        for mode in ("one mesh", "subdomains"):
            count = self.calls(mode, 0)["new"]
            self.take_results()
            left = 0
            for point in random.Random(SEED).sample(range(1, count + 1), count):
                done = self.run_with(f"new:{point}", mode, words_beside=("--progress", "none"))
                told = f"new:{point} of {count} in {mode}: exit {done.returncode}\n{done.stdout}{done.stderr}"
                left += done.returncode == 1 and "out of memory: this is the valid mesh" in done.stdout
                self.assert_nothing_is_lost(done, "new", False, told)
                if left == 2:
                    break
            self.assertEqual(left, 2, mode)

    def test_arrays_that_cannot_grow_leave_a_mesh(self):
        """Those of a subdomain that was small when its room was reserved: each growth from the N-th on is refused."""
        self.box(1, "cell.meshb")
        words = {"words_beside": ("--progress", "none"), "mesh": "cell.meshb", "metric": "uniform:0.035"}
        count = self.calls("subdomains", 0, **words)["grow"]
        self.take_results()
        self.assertGreater(count, 0)
        for point in sorted({1, 2, count // 2, count}):
            done = self.run_with(f"grow:{point}", "subdomains", **words)
            told = f"grow:{point} of {count}: exit {done.returncode}\n{done.stdout}{done.stderr}"
            self.assertNotEqual(done.returncode, 0, told)
            self.assert_nothing_is_lost(done, "grow", False, told)

    def test_an_allocation_that_fails_once_the_mesh_is_there_costs_the_fields_alone(self):
        self.write("f.sol", solution_text([(i,) for i in range(27)], kind=1))
        words = ("--progress", "none", "--field", "f.sol")
        count = self.calls("one mesh", 0, words)["new"]
        self.take_results()
        chance, without = random.Random(SEED), 0
        for point in chance.sample(range(count * 4 // 5, count), count // 5):  # the last ones, and a few before
            done = self.run_with(f"new:{point}", "one mesh", words_beside=words)
            told = f"new:{point} of {count}: exit {done.returncode}\n{done.stdout}{done.stderr}"
            if "the fields are not carried along" in done.stdout:
                without += 1
                self.assertEqual(done.returncode, 1, told)
                self.assertNotEqual((self.folder / "out.meshb").read_bytes(), self.old["out.meshb"], told)
            self.assert_nothing_is_lost(done, "new", False, told)
            if without == 3:
                break
        self.assertEqual(without, 3)

    def test_what_is_late_changes_nothing(self):
        chance = random.Random(SEED)
        for mode in ("subdomains", "ranks"):
            ranks = MODES[mode][0]
            for rank in range(max(1, ranks)):
                counts = self.calls(mode, rank)
                right = self.take_results()
                for kind in ("write", "read", "rename", "mpi"):
                    for point in self.points(chance, counts[kind], ranks):
                        fault = f"{kind}:{point}:{LATE}"
                        done = self.run_with(fault, mode, rank)
                        told = f"{fault} in {mode}, rank {rank}\n{done.stdout}{done.stderr}"
                        self.assertIn(done.returncode, (0, 1), told)
                        self.assertEqual(self.take_results(), right, told)


if __name__ == "__main__":
    unittest.main()
