"""Checkpoints: runs that are killed go on from them to the same bytes, on any number of ranks.

WEFT_KILLS: how many runs are killed at random moments (scripts/kill_runs.py does more); WEFT_SEED: of these moments.
"""

import json
import os
import pathlib
import random
import shutil
import signal
import subprocess
import tempfile
import time

import unittest

from command import WEFT, CommandTest
from on_ranks import MPICH, MPIRUN, is_weft, ranks_of

SECONDS = 300  # far above what anything here takes
KILLS = int(os.environ.get("WEFT_KILLS", "3"))
SEED = int(os.environ.get("WEFT_SEED", "20261123"))
ATTEMPTS = 20
COMPLEXITY = 4000  # long enough for two checkpoints though others take the processor, and to be killed in
RUN = ("box.meshb", "--metric-fn", "polar-2", "--subdomains", 9, "--quiet")


class Checkpoints(CommandTest):
    def setUp(self):
        super().setUp()
        self.box(6)

    def start(self, ranks, *words, complexity=COMPLEXITY, threads=1):
        words = (*words, "--complexity", complexity, "--threads", threads)
        launcher = [*MPIRUN, "-n", str(ranks)] if ranks else []
        return subprocess.Popen([*launcher, str(WEFT), "adapt", *map(str, RUN), *map(str, words)], cwd=self.folder,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def run_on(self, ranks, *words, expect=(0, 1), **options):
        process = self.start(ranks, *words, **options)
        out, errors = process.communicate(timeout=SECONDS)
        self.assertIn(process.returncode, expect, f"{words}\n{out}{errors}")
        return out + errors

    def complete(self):
        return sorted(int(path.parent.name) for path in (self.folder / "ck").glob("*/complete"))

    def damage(self, number):
        file = self.folder / "ck" / str(number) / "rank-0"
        data = bytearray(file.read_bytes())
        data[len(data) // 3] ^= 1
        file.write_bytes(data)

    def bytes_of(self, name):
        return (self.folder / name).read_bytes()

    def reference(self):
        """The bytes of the run that nobody disturbs: one for all classes."""
        if Checkpoints.whole is None:
            self.run_on(0, "-o", "whole.meshb")
            Checkpoints.whole = self.bytes_of("whole.meshb")
        return Checkpoints.whole

    def until_two_are_kept(self, run):
        """Again and again: on a slow disk a run may be over before its second checkpoint is there."""
        for _ in range(ATTEMPTS):
            shutil.rmtree(self.folder / "ck", ignore_errors=True)
            run()
            if len(self.complete()) >= 2:
                break
        self.assertEqual(len(self.complete()), 2, "two are kept")

    whole = None
    made = None  # by the first test of a class that asks for some_checkpoints()

    def once(self, run):
        """Files that `run` writes into the test's folder; in the class's further tests copies of them."""
        if type(self).made is None:
            self.until_two_are_kept(run)
            type(self).made = tempfile.TemporaryDirectory(prefix="weft-checkpoint-test-")
            self.addClassCleanup(type(self).made.cleanup)
            shutil.copytree(self.folder, type(self).made.name, dirs_exist_ok=True)
        else:
            shutil.copytree(type(self).made.name, self.folder, dirs_exist_ok=True)

    def some_checkpoints(self):
        """A run that is through, and has left two."""
        self.once(lambda: self.run_on(2, "--checkpoint", "ck", "--checkpoint-every", 0.02, "-o", "first.meshb"))


class Writing(Checkpoints):
    def test_changes_no_byte_and_keeps_two(self):
        self.until_two_are_kept(lambda: self.run_on(
            2, "--checkpoint", "ck", "--checkpoint-every", 0.02, "-o", "first.meshb", "--report", "r"))
        self.assertEqual(self.bytes_of("first.meshb"), self.reference())
        self.assertEqual(len(list((self.folder / "ck").iterdir())), 2, "what was not finished in time is gone")
        account = json.loads((self.folder / "r/report.json").read_text())["subdomains"]["checkpoints"]
        self.assertGreaterEqual(account["written"], 2)
        self.assertEqual(account["failure"], "")

    def test_of_one_process_with_threads(self):
        self.until_two_are_kept(lambda: self.run_on(
            0, "--checkpoint", "ck", "--checkpoint-every", 0.02, "-o", "first.meshb", threads=2))
        for ranks in (0, 2):
            self.run_on(ranks, "--resume", "ck", "-o", "second.meshb")
            self.weft("verify", "second.meshb", "--against", "box.meshb")

    def test_when_asked_by_a_signal(self):
        process = self.start(2, "--checkpoint", "ck", "--checkpoint-every", 0, "-o", "first.meshb", complexity=60000)
        while process.poll() is None and not (self.folder / "ck").exists():
            time.sleep(0.1)  # before that a signal kills

        def send(number):
            if MPICH:  # its mpirun does not know the first, and may end with 0 after the second
                os.kill(ranks_of(process.pid)[0], number)
            else:
                process.send_signal(number)

        while process.poll() is None and not self.complete():
            time.sleep(0.2)
            send(signal.SIGUSR2)
        self.assertTrue(self.complete())
        send(signal.SIGALRM)
        process.communicate(timeout=SECONDS)
        self.assertEqual(process.returncode, 1)

    def test_that_fails_costs_the_checkpoint_alone(self):
        in_the_way = [self.folder / "ck" / str(number) for number in range(1, 400)]
        in_the_way[0].parent.mkdir()
        for file in in_the_way:
            file.write_text("in the way")
        text = self.run_on(2, "--checkpoint", "ck", "--checkpoint-every", 0.02, "-o", "first.meshb", "--report", "r")
        self.assertEqual(self.bytes_of("first.meshb"), self.reference(), text)
        report = json.loads((self.folder / "r/report.json").read_text())
        self.assertEqual(report["subdomains"]["checkpoints"]["written"], 0)
        self.assertRegex("\n".join(report["warnings"]), "the latest checkpoint could not be written: .*ck/")
        self.assertTrue(all(file.is_file() for file in in_the_way))


class Resuming(Checkpoints):
    def test_gives_the_same_bytes_on_any_ranks(self):
        self.some_checkpoints()
        expected = self.bytes_of("first.meshb")
        for ranks in (0, 1, 2, 3):
            out = self.run_on(ranks, "--resume", "ck", "-o", "second.meshb", "--report", "r")
            self.assertEqual(self.bytes_of("second.meshb"), expected, f"on {ranks} ranks: {out}")
            account = json.loads((self.folder / "r/report.json").read_text())["subdomains"]["checkpoints"]
            self.assertIn("ck/", account["resumed"])

    def test_keeps_the_number_of_subdomains(self):
        self.some_checkpoints()
        words = ["adapt", *(4 if word == 9 else word for word in RUN if word != "--quiet"), "--complexity", COMPLEXITY, "--threads", 1]
        told = self.weft(*words, "--resume", "ck", "-o", "second.meshb", expect=(0, 1)).stdout
        self.assertIn("warning: --subdomains 4 has no effect: the run in ck has 9\n", told)
        self.assertEqual(self.bytes_of("second.meshb"), self.bytes_of("first.meshb"))

    def test_of_a_run_with_checks(self):
        words = ("--check", "--report", "r")
        self.until_two_are_kept(lambda: self.run_on(
            2, *words, "--checkpoint", "ck", "--checkpoint-every", 0.02, "-o", "first.meshb"))
        self.assertEqual(self.bytes_of("first.meshb"), self.reference())
        checks = json.loads((self.folder / "r/report.json").read_text())["subdomains"]["checks"]
        for ranks in (0, 3):
            self.run_on(ranks, *words, "--resume", "ck", "-o", "second.meshb")
            self.assertEqual(self.bytes_of("second.meshb"), self.reference())
            account = json.loads((self.folder / "r/report.json").read_text())["subdomains"]
            self.assertIn("ck/", account["checkpoints"]["resumed"])
            self.assertIn(account["checks"], range(1, checks + 1))
        text = self.run_on(2, "--resume", "ck", "-o", "third.meshb", expect=(2,))
        self.assertIn("another run", text)

    def test_of_nothing_begins_anew(self):
        self.run_on(2, "--resume", "ck", "-o", "second.meshb")
        self.assertEqual(self.bytes_of("second.meshb"), self.reference())

    def test_passes_over_what_is_not_whole(self):
        self.some_checkpoints()
        older, latest = self.complete()
        with open(self.folder / "ck" / str(latest) / "rank-1", "r+b") as file:
            file.truncate(100)
        self.run_on(2, "--resume", "ck", "-o", "second.meshb", "--report", "r")
        account = json.loads((self.folder / "r/report.json").read_text())["subdomains"]["checkpoints"]
        self.assertEqual(account["resumed"], f"ck/{older}")
        self.assertEqual(self.bytes_of("second.meshb"), self.bytes_of("first.meshb"))

    def test_that_is_damaged_gives_way_to_the_older(self):
        self.some_checkpoints()
        older, latest = self.complete()
        self.damage(latest)
        for ranks in (0, 2):
            self.run_on(ranks, "--resume", "ck", "-o", "second.meshb", "--report", "r")
            report = json.loads((self.folder / "r/report.json").read_text())
            self.assertEqual(report["subdomains"]["checkpoints"]["resumed"], f"ck/{older}")
            self.assertRegex("\n".join(report["warnings"]), f"ck/{latest}/rank-0.*damaged")
            self.assertEqual(self.bytes_of("second.meshb"), self.bytes_of("first.meshb"))

    def test_of_which_all_are_damaged_is_refused(self):
        self.some_checkpoints()
        for number in self.complete():
            self.damage(number)
        for ranks in (0, 2):
            text = self.run_on(ranks, "--resume", "ck", "-o", "second.meshb", expect=(2,))
            self.assertIn("damaged", text)
            self.assertNotIn("second.meshb", self.files())

    def test_of_another_run_is_refused(self):
        self.some_checkpoints()
        for words, options in ((), {"complexity": 5000}), (("--ridge-angle", 50), {}), (("--hausd", 0.01), {}), (("--layers", 3), {}):
            text = self.run_on(2, "--resume", "ck", "-o", "second.meshb", *words, expect=(2,), **options)
            self.assertIn("another run", text)

    def test_of_a_run_that_was_interrupted_is_of_whole_work(self):
        """Subdomains end with what they have then, and nobody goes on from that."""
        for moment in (0.1, 0.2, 0.4):
            shutil.rmtree(self.folder / "ck", ignore_errors=True)
            process = self.start(2, "--checkpoint", "ck", "--checkpoint-every", 0.01, "-o", "first.meshb")
            while process.poll() is None and not (self.folder / "ck").exists():
                time.sleep(0.01)  # before that a signal kills
            time.sleep(moment)
            if process.poll() is None:
                process.send_signal(signal.SIGALRM)
            process.communicate(timeout=SECONDS)
            self.run_on(3, "--resume", "ck", "-o", "second.meshb")
            self.assertEqual(self.bytes_of("second.meshb"), self.reference(), f"interrupted after {moment} s")

    def test_waits_for_a_run_that_still_writes_there(self):
        slow = self.start(2, "--checkpoint", "ck", "--checkpoint-every", 0.05, "-o", "first.meshb", complexity=4 * COMPLEXITY)
        while slow.poll() is None and not self.complete():
            time.sleep(0.01)
        self.run_on(0, "--checkpoint", "ck", "--checkpoint-every", 1, "-o", "second.meshb")
        self.assertIn("first.meshb", self.files(), "its run had the folder first")
        slow.communicate(timeout=SECONDS)


class OneMesh(Checkpoints):
    """Runs without subdomains: their states are those between passes."""

    WORDS = ("box.meshb", "--metric-fn", "polar-2", "--complexity", COMPLEXITY, "--report", "r")

    def adapt(self, *words, threads=1, expect=(0, 1)):
        done = self.weft("adapt", *self.WORDS, "--threads", threads, *words, expect=expect)
        return done.stdout + done.stderr

    def account(self):
        return json.loads((self.folder / "r/report.json").read_text())["checkpoints"]

    def checkpoints_of(self, threads):
        self.adapt("--checkpoint", "ck", "--checkpoint-every", 0.01, "-o", "first.meshb", threads=threads)

    def some_checkpoints(self):
        self.once(lambda: self.checkpoints_of(threads=1))

    def assert_first_again(self, *words):
        text = self.adapt("--resume", "ck", "-o", "second.meshb", *words)
        self.assertEqual(self.bytes_of("second.meshb"), self.bytes_of("first.meshb"), text)
        self.assertEqual(self.bytes_of("second.solb"), self.bytes_of("first.solb"), text)
        return text

    def test_written_changes_no_byte(self):
        self.some_checkpoints()
        self.assertGreaterEqual(self.account()["written"], 2)
        self.assertEqual(self.account()["failure"], "")
        self.adapt("-o", "whole.meshb")
        self.assertEqual(self.bytes_of("first.meshb"), self.bytes_of("whole.meshb"))

    def test_resumed_gives_the_same_bytes(self):
        self.some_checkpoints()
        text = self.assert_first_again()
        self.assertIn("gone on from checkpoint ck/", text)
        self.assertEqual(self.account()["resumed"], f"ck/{self.complete()[-1]}")

    def test_goes_on_with_other_threads(self):
        for before, after in ((2, 1), (1, 2)):
            self.until_two_are_kept(lambda: self.checkpoints_of(threads=before))
            self.adapt("--resume", "ck", "-o", "second.meshb", threads=after)
            self.weft("verify", "second.meshb", "--against", "box.meshb")
            shutil.rmtree(self.folder / "ck")

    def test_of_nothing_begins_anew(self):
        self.adapt("-o", "first.meshb")
        self.assert_first_again()
        self.assertIsNone(self.account())

    def test_passes_over_what_is_not_whole(self):
        self.some_checkpoints()
        older, latest = self.complete()
        with open(self.folder / "ck" / str(latest) / "rank-0", "r+b") as file:
            file.truncate(100)
        self.assert_first_again()
        self.assertEqual(self.account()["resumed"], f"ck/{older}")

    def test_that_is_damaged_gives_way_to_the_older(self):
        self.some_checkpoints()
        older, latest = self.complete()
        self.damage(latest)
        text = self.assert_first_again()
        self.assertEqual(self.account()["resumed"], f"ck/{older}")
        self.assertRegex(text, f"warning: .*ck/{latest}/rank-0.*damaged")

    def test_of_which_all_are_damaged_is_refused(self):
        self.some_checkpoints()
        for number in self.complete():
            self.damage(number)
        before = self.files()
        text = self.adapt("--resume", "ck", "-o", "second.meshb", expect=2)
        self.assertIn(f"ck/{self.complete()[-1]}/rank-0", text)
        self.assertIn("damaged", text)
        self.assertEqual(self.files(), before)

    def test_of_another_run_is_refused(self):
        self.some_checkpoints()
        for words in (("--hmin", "0.05"), ("--no-swap",), ("--hausd", "0.01")):
            self.assertIn("another run", self.adapt("--resume", "ck", "-o", "second.meshb", *words, expect=2))
        self.assertIn("one mesh", self.adapt("--resume", "ck", "-o", "second.meshb", "--subdomains", 3, expect=2))

    def test_of_subdomains_is_refused(self):
        long = (*self.WORDS[:4], 10 * COMPLEXITY, "--threads", 1, "--quiet")
        self.weft("adapt", *long, "--subdomains", 3, "--checkpoint", "ck", "--checkpoint-every", 0.02, "-o", "first.meshb", expect=(0, 1))
        self.assertIn("in subdomains", self.weft("adapt", *long, "--resume", "ck", "-o", "second.meshb", expect=2).stderr)

    def test_when_asked_by_a_signal(self):
        words = [*map(str, self.WORDS[:-3]), "200000", "--threads", "1", "--quiet", "-o", "first.meshb"]
        process = subprocess.Popen([str(WEFT), "adapt", *words, "--checkpoint", "ck", "--checkpoint-every", "0"], cwd=self.folder)
        while process.poll() is None and not (self.folder / "ck").exists():
            time.sleep(0.1)  # before that a signal kills
        while process.poll() is None and not self.complete():
            time.sleep(0.2)
            process.send_signal(signal.SIGUSR2)
        self.assertTrue(self.complete())
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=SECONDS)
        self.assertEqual(process.returncode, 1)


class Kills(Checkpoints):
    """Whoever is killed, and when: another number of ranks goes on, perhaps to be killed again."""

    def kill(self, process, chance):
        ranks = ranks_of(process.pid)
        victims = {"a rank": [chance.choice(ranks)] if ranks else [], "rank 0": ranks[:1], "two ranks": ranks[:2],
                   "mpirun": [process.pid], "all": [process.pid, *ranks]}
        name = chance.choice(list(victims))
        for victim in victims[name]:
            try:
                os.kill(victim, signal.SIGKILL)
            except ProcessLookupError:
                pass
        return name

    def wait_for_the_end(self, process, ranks):
        process.communicate(timeout=SECONDS)
        for rank in ranks:  # those of a dead mpirun end by themselves, but later
            for _ in range(SECONDS):
                if not is_weft(rank):
                    break
                time.sleep(0.1)

    def test_at_random_moments(self):
        expected = self.reference()
        chance = random.Random(SEED)
        killed = 0
        while killed < KILLS:
            shutil.rmtree(self.folder / "ck", ignore_errors=True)
            history = []
            while True:
                ranks = chance.choice((2, 3, 4))
                process = self.start(ranks, "--checkpoint", "ck", "--checkpoint-every", 0.05, "--resume", "ck", "-o", "out.meshb")
                time.sleep(chance.uniform(0.3, 3))
                running = ranks_of(process.pid)
                if process.poll() is None and killed < KILLS:
                    history.append((ranks, self.kill(process, chance), self.complete()))
                    killed += 1
                    self.wait_for_the_end(process, running)
                else:
                    out, errors = process.communicate(timeout=SECONDS)
                    self.assertIn(process.returncode, (0, 1), f"{history}\n{out}{errors}")
                    break
            self.assertEqual(self.bytes_of("out.meshb"), expected, history)
            self.weft("verify", "out.meshb", "--against", "box.meshb")
            (self.folder / "out.meshb").unlink()


if __name__ == "__main__":
    unittest.main()
