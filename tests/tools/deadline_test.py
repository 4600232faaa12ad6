"""`weft adapt` that has to end before it is done: time limits, memory limits, signals to all ranks or to one."""

import json
import os
import pathlib
import re
import resource
import signal
import subprocess
import time
import unittest

from command import WEFT, CommandTest
from on_ranks import MPIRUN, ranks_of

SECONDS = 300  # far above what anything here takes
LONG = ("--metric-fn", "polar-2", "--complexity", 200000, "--threads", 1, "--progress", "none", "-o", "out.meshb",
        "--report", "r")


def catches(process, number):
    """Whether it has a handler for that signal."""
    status = pathlib.Path(f"/proc/{process}/status").read_text()
    return int(re.search(r"SigCgt:\s*(\w+)", status)[1], 16) >> (number - 1) & 1


class Deadline(CommandTest):
    def start(self, ranks, *words, at_start=None):
        launcher = [*MPIRUN, "-n", str(ranks)] if ranks else []
        return subprocess.Popen([*launcher, str(WEFT), "adapt", self.box(8), *map(str, words)], cwd=self.folder,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=at_start)

    def assert_valid_result(self, process, ended_by):
        out, errors = process.communicate(timeout=SECONDS)
        self.assertEqual(process.returncode, 1, out + errors)
        report = json.loads((self.folder / "r/report.json").read_text())
        self.assertIs(report["interrupted"], True)
        self.assertEqual(report["ended_by"], ended_by)
        if process.args[0] == str(WEFT):  # what ranks print mpirun may lose when it ends them, a second after the first
            self.assertIn("GOAL NOT MET: ", out)
        self.weft("verify", "out.meshb", "--against", "box.meshb")
        self.assertEqual(self.files(), ["box.meshb", "out.meshb", "out.solb", "r"])


class OfAnInitialMesh(Deadline):
    def test_a_limit_leaves_a_valid_mesh_or_none(self):
        for limit in ("0.5", "2", "6"):
            done = subprocess.run([WEFT, "mesh", "ball", "--size", "0.01", "--time-limit", limit, "--threads", "1", "-o", "ball.meshb"],
                                  cwd=self.folder, capture_output=True, text=True)
            self.assertIn(done.returncode, (1, 2), done.stdout + done.stderr)
            if done.returncode == 1:
                self.assertIn("ended early: time limit", done.stdout)
                self.weft("verify", "ball.meshb")
            else:
                self.assertEqual(self.files(), [])

    def test_a_limit_of_memory(self):
        done = subprocess.run([WEFT, "mesh", "ball", "--size", "0.02", "--max-memory", "90M", "-o", "ball.meshb"], cwd=self.folder,
                              capture_output=True, text=True)
        self.assertIn(done.returncode, (1, 2), done.stdout + done.stderr)
        self.assertIn("memory", done.stdout + done.stderr)
        if done.returncode == 1:
            self.weft("verify", "ball.meshb")


class TimeLimit(Deadline):
    def test_of_one_mesh(self):
        self.assert_valid_result(self.start(0, *LONG, "--time-limit", 1), "time limit")

    def test_in_subdomains(self):
        self.assert_valid_result(self.start(0, *LONG, "--subdomains", 6, "--time-limit", 1), "time limit")

    def test_on_two_ranks(self):
        self.assert_valid_result(self.start(2, *LONG, "--time-limit", 2), "time limit")

    def test_before_anything_is_done(self):
        self.assert_valid_result(self.start(2, *LONG, "--time-limit", 0.01), "time limit")

    def test_that_is_not_reached_changes_nothing(self):
        words = (self.box(3), "--metric-fn", "uniform:0.2", "--threads", 1, "--quiet", "-o")
        self.weft("adapt", *words, "a.meshb")
        self.weft("adapt", *words, "b.meshb", "--time-limit", 1000, "--max-memory", "4G")
        self.assertEqual((self.folder / "a.meshb").read_bytes(), (self.folder / "b.meshb").read_bytes())

    def test_that_is_no_time(self):
        self.assert_fails("adapt", self.box(), "--metric-fn", "polar-2", "-o", "o.meshb", "--time-limit", "-1",
                          says="--time-limit", code=64)


class Memory(Deadline):
    def control_group(self, megabytes):
        """The folder of a new control group (a batch job, a container) that may take so much memory."""
        for parent, limit in (("/sys/fs/cgroup/memory", "memory.limit_in_bytes"), ("/sys/fs/cgroup", "memory.max")):
            group = pathlib.Path(parent) / f"weft-test-{os.getpid()}"
            try:
                group.mkdir()
                self.addCleanup(group.rmdir)
                (group / limit).write_text(f"{megabytes}M")
                return group
            except OSError:
                continue
        self.skipTest("no control group of memory can be made here")

    def test_that_a_control_group_limits(self):
        """Who takes more is killed: the run ends before, with the mesh that it has."""
        if "ASAN_OPTIONS" in os.environ:
            self.skipTest("the address sanitizer takes memory that no mesh can give back")
        group = self.control_group(150)
        process = self.start(0, *LONG, "--force", at_start=lambda: (group / "cgroup.procs").write_text(str(os.getpid())))
        self.assert_valid_result(process, "memory limit")

    def test_that_is_used_up(self):
        """The prediction is overruled; what the run really takes ends it."""
        process = self.start(0, *LONG, "--max-memory", "150M", "--force")
        self.assert_valid_result(process, "memory limit")

    def test_that_allocations_cannot_have(self):
        """ulimit -v: arrays are refused at the start or in the middle of the run, and the result still has room."""
        if {"ASAN_OPTIONS", "TSAN_OPTIONS"} & set(os.environ):
            self.skipTest("sanitizers reserve more address space than any limit leaves")
        most = 300 << 20
        for complexity in (200000, 400000):  # takes about as much, twice as much
            words = [complexity if word == 200000 else word for word in LONG]
            process = self.start(0, *words, "--force", at_start=lambda: resource.setrlimit(resource.RLIMIT_AS, (most, most)))
            out, errors = process.communicate(timeout=SECONDS)
            self.assertEqual(process.returncode, 1, out + errors)
            self.weft("verify", "out.meshb", "--against", "box.meshb")
            report = json.loads((self.folder / "r/report.json").read_text())
            self.assertRegex("\n".join([report["ended_by"], *report["warnings"]]), "out of memory|the mesh has room for")

    def test_that_cannot_be_enough(self):
        for ranks in ([], ["--subdomains", 4]):
            self.assert_fails("adapt", self.box(), *LONG[:-4], "--max-memory", "50M", *ranks, "-o", "o.meshb",
                              says=["complexity", "memory", "52 MB are allowed"])


class Signals(Deadline):
    def running(self, ranks):
        process = self.start(ranks, *LONG, "--subdomains", 6)
        for _ in range(10 * SECONDS):
            time.sleep(0.1)
            if process.poll() is not None or sum(catches(rank, signal.SIGTERM) for rank in ranks_of(process.pid)) == ranks:
                break
        time.sleep(1)  # into the adaptation, or near it: either is to end well
        return process

    def test_to_one_rank_reaches_all(self):
        for rank in (0, 1):
            process = self.running(2)
            os.kill(ranks_of(process.pid)[rank], signal.SIGTERM)
            self.assert_valid_result(process, "interrupted")

    def test_that_mpirun_passes_on(self):
        process = self.running(2)
        process.send_signal(signal.SIGALRM)
        self.assert_valid_result(process, "interrupted")

    def test_a_second_time_ends_at_once(self):
        process = subprocess.Popen([str(WEFT), "adapt", self.box(8), *map(str, LONG)], cwd=self.folder,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        time.sleep(1)
        process.send_signal(signal.SIGTERM)
        process.send_signal(signal.SIGTERM)
        self.assertIn(process.wait(timeout=SECONDS), (-signal.SIGTERM, 1))  # 1: it was through before


if __name__ == "__main__":
    unittest.main()
