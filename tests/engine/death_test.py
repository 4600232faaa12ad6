"""Processes that fail, are told to stop, or are killed: the others end within seconds, and one says why."""

import os
import re
import signal
import subprocess
import time
import unittest

VICTIM = os.environ["WEFT_VICTIM"]
HELLO = os.environ["WEFT_HELLO"]
TRANSPORT = os.environ["WEFT_TRANSPORT_TESTS"]
MPIRUN = os.environ["WEFT_MPIRUN"].split(";")
SECONDS = 20  # far above what it takes, far below a hang


def start(ranks, *way):
    return subprocess.Popen([*MPIRUN, "-n", str(ranks), VICTIM, *way], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                            text=True)


def processes_of(run, ranks):
    """The process ids of the ranks, once all have said theirs."""
    ids = {}
    while len(ids) < ranks:
        match = re.search(r"rank (\d+) is process (\d+)", run.stdout.readline())
        if match:
            ids[int(match[1])] = int(match[2])
    return ids


class Death(unittest.TestCase):
    def end_of(self, run):
        begin = time.monotonic()
        self.output, errors = run.communicate(timeout=SECONDS)
        self.assertNotEqual(run.returncode, 0)
        return errors, time.monotonic() - begin

    def messages(self, errors):
        return [line for line in errors.splitlines() if line.startswith("error: ")]

    def assert_named(self, rank, errors):
        """The dead rank, by the others; MPICH's mpirun may be faster: it kills them at once and names the signal."""
        if os.environ.get("WEFT_MPI") == "mpich" and "Killed (signal 9)" in self.output + errors:
            return
        self.assertIn(f"error: rank {rank} died: its process is gone", self.messages(errors), errors + self.output)

    def test_a_failure_is_reported_once(self):
        for ranks in (1, 3):
            errors, _ = self.end_of(start(ranks, "fail"))
            self.assertEqual(self.messages(errors),
                             [f"error: the root function on rank {ranks - 1}: I was asked to"], errors)

    def test_sigterm_to_mpirun_stops_all(self):
        run = start(3, "last")
        processes_of(run, 3)
        run.send_signal(signal.SIGTERM)
        errors, _ = self.end_of(run)
        self.assertEqual(self.messages(errors), ["error: stopped from outside (SIGTERM)"], errors)

    def test_sigterm_to_one_rank_stops_all(self):
        run = start(3, "last")
        os.kill(processes_of(run, 3)[1], signal.SIGTERM)
        errors, _ = self.end_of(run)
        self.assertEqual(self.messages(errors), ["error: stopped from outside (SIGTERM)"], errors)

    def test_sigusr1_shows_the_state_and_the_run_goes_on(self):
        run = start(3, "last")
        self.addCleanup(run.terminate)
        ids = processes_of(run, 3)
        os.kill(ids[2], signal.SIGUSR1)  # one rank
        lines = iter(run.stderr.readline, "")
        self.assertRegex(next(lines), r"^state of rank 2 of 3, [0-9.]+ s into the run$")
        self.assertRegex(next(lines), r"^  messages: 0 bytes to be sent, 0 received and not handled")
        self.assertRegex(next(lines), r"^  load: 1 of 1 workers busy.*1 objects: 1 running")
        self.assertRegex(next(lines), r"^  object 2.1: runs Victim::last for [0-9.]+ s$")
        run.send_signal(signal.SIGUSR1)  # mpirun passes it on to all
        shown = set()
        while len(shown) < 3:  # mpirun says something itself, too
            shown.update(re.findall(r"^state of rank ([0-9]) of 3", next(lines)))
        run.send_signal(signal.SIGTERM)
        errors, _ = self.end_of(run)
        self.assertEqual(self.messages(errors), ["error: stopped from outside (SIGTERM)"], errors)

    def test_a_killed_rank_is_named(self):
        for victim in (1, 0):
            run = start(3, "last")
            os.kill(processes_of(run, 3)[victim], signal.SIGKILL)
            errors, seconds = self.end_of(run)
            self.assert_named(victim, errors)
            self.assertLess(seconds, 10)

    def test_a_killed_rank_is_named_though_handlers_do_not_stop_and_data_is_under_way(self):
        for way in ("deaf", "flood"):
            run = start(3, way)
            os.kill(processes_of(run, 3)[1], signal.SIGKILL)
            errors, seconds = self.end_of(run)
            self.assert_named(1, errors)
            self.assertLess(seconds, 10)

    def pause(self, ids):
        """Stops processes for longer than the silence after which a rank counts as dead."""
        for process in ids:
            os.kill(process, signal.SIGSTOP)
        time.sleep(8)
        for process in ids:
            os.kill(process, signal.SIGCONT)
        time.sleep(4)  # whoever counts the pause as silence says so now

    def test_a_job_that_is_suspended_goes_on_and_so_does_one_with_a_rank_stopped_under_the_eyes_of_the_others(self):
        runs = [start(3, *way) for way in (["last"], ["apart", "last"], ["last"])]
        ids = [processes_of(run, 3) for run in runs]
        self.pause([*ids[0].values(), *ids[1].values(), ids[2][1]])
        for run, its in zip(runs, ids):
            self.assertIsNone(run.poll())
            os.kill(its[0], signal.SIGTERM)
            errors, _ = self.end_of(run)
            self.assertEqual(self.messages(errors), ["error: stopped from outside (SIGTERM)"], errors)

    def test_a_rank_that_is_stopped_on_another_node_counts_as_dead(self):
        run = start(3, "apart", "last")
        ids = processes_of(run, 3)
        time.sleep(4)  # it has been heard of
        os.kill(ids[1], signal.SIGSTOP)
        self.addCleanup(lambda: os.path.exists(f"/proc/{ids[1]}") and os.kill(ids[1], signal.SIGKILL))
        errors, _ = self.end_of(run)
        self.assertIn("error: rank 1 died: it has been silent for too long", self.messages(errors), errors)

    @unittest.skipIf(os.environ.get("WEFT_MPI") == "mpich", "MPICH's mpirun kills the others at once")
    def test_a_network_whose_rank_has_died_is_not_closed(self):
        command = [*MPIRUN, "--enable-recovery", "-n", "3", TRANSPORT, "--a-rank-dies"]
        run = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS)
        self.assertIn("found dead: 2 ", run.stdout, run.stderr)
        self.assertIn("close refused: rank 2 has died", run.stdout, run.stderr)

    def test_a_program_that_a_rank_starts_is_no_rank(self):
        command = [*MPIRUN, "-n", "2", VICTIM, "system", HELLO]
        run = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS)
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertEqual(sum(map(int, re.findall(r"had (\d+) visits", run.stdout))), 2 * 1001)

    def test_a_program_that_a_script_starts_under_mpirun_is_a_rank(self):
        command = [*MPIRUN, "-n", "2", "sh", "-c", f"{HELLO}; true"]
        run = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS)
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertEqual(sum(map(int, re.findall(r"had (\d+) visits", run.stdout))), 1001)

    def test_sigterm_without_mpirun_stops_even_a_handler_that_does_not_listen(self):
        run = subprocess.Popen([VICTIM, "deaf"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        os.kill(processes_of(run, 1)[0], signal.SIGTERM)
        errors, seconds = self.end_of(run)
        self.assertEqual(self.messages(errors), ["error: stopped from outside (SIGTERM)"], errors)
        self.assertEqual(run.returncode, 2)

    def test_without_mpirun_a_program_runs_alone(self):
        run = subprocess.run([HELLO], capture_output=True, text=True, timeout=SECONDS)
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertEqual(sum(map(int, re.findall(r"had (\d+) visits", run.stdout))), 1001)

    def test_the_example_runs_on_several_ranks(self):
        run = subprocess.run([*MPIRUN, "-n", "3", HELLO], capture_output=True, text=True, timeout=SECONDS)
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertEqual(sum(map(int, re.findall(r"had (\d+) visits", run.stdout))), 1001)

    def test_the_example_is_the_one_in_the_readme(self):
        with open(os.environ["WEFT_HELLO_SOURCE"]) as source, open(os.environ["WEFT_ENGINE_README"]) as readme:
            self.assertIn(source.read().split("\n\n", 1)[1].strip(), readme.read())


if __name__ == "__main__":
    unittest.main()
