"""Tests of the command on ranks of mpirun."""

import os
import pathlib
import subprocess
import sys

from command import WEFT, CommandTest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent.parent / "scripts"))

from ranks import is_weft, ranks_of  # noqa: E402, F401: for the tests on ranks

MPIRUN = os.environ["WEFT_MPIRUN"].split(";")
MPICH = os.environ["WEFT_MPI"] == "mpich"
LONG = bool(os.environ.get("WEFT_LONG_TESTS"))  # scripts/nightly.sh: on all numbers of ranks
SECONDS = 200  # far above what anything here takes


def some_of(ranks, turn):
    """Of several numbers of ranks those that turn `turn` (from 0) of a loop over cases is run on: all in the first turn and in
    long tests, else one, by turns: each run of mpirun takes a second."""
    return ranks if LONG or turn == 0 else (ranks[turn % len(ranks)],)


class Subdomains(CommandTest):
    def run_on(self, ranks, *words, expect=0):
        """`weft adapt` on so many ranks of mpirun, or (0) without it; returns what it printed."""
        return self.command_on(ranks, "adapt", *words, expect=expect)

    def command_on(self, ranks, *words, expect=0):
        launcher = [*MPIRUN, "-n", str(ranks)] if ranks else []
        done = subprocess.run([*launcher, str(WEFT), *map(str, words)], cwd=self.folder, capture_output=True, text=True,
                              timeout=SECONDS)
        self.assertIn(done.returncode, expect if isinstance(expect, tuple) else (expect,),
                      f"{ranks} ranks: {words}\n{done.stdout}{done.stderr}")
        return done

    def bytes_of(self, *names):
        return [(self.folder / name).read_bytes() for name in names]

    def assert_same_on_all(self, *words, outputs=("out.meshb", "out.solb"), ranks=(2, 3), expect=0):
        """The same bytes without mpirun and on so many ranks; returns the last run, which is not quiet."""
        words = (*words, "-o", outputs[0], "--threads", 1)
        self.run_on(0, *words, "--quiet", expect=expect)
        expected = self.bytes_of(*outputs)
        for n in ranks:
            for name in outputs:
                (self.folder / name).unlink()
            done = self.run_on(n, *words, *(["--quiet"] if n != ranks[-1] else []), expect=expect)
            self.assertEqual(self.bytes_of(*outputs), expected, f"on {n} ranks")
        return done

    def assert_all_ranks_fail(self, *words, says, code=2, ranks=2):
        """All end with `code`; one line says why, once; nothing is left behind."""
        before = self.files()
        done = self.run_on(ranks, *words, "--quiet", expect=code)
        lines = [line for line in done.stderr.splitlines() if line.startswith(("weft", "error"))]
        self.assertEqual(len(lines), 1, done.stderr)
        self.assertIn(says, lines[0])
        self.assertEqual(self.files(), before)
