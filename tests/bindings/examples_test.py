"""The same input gives the same bytes from every language, as one mesh; and in parts for any number of ranks."""

import os
import pathlib
import re
import subprocess
import tempfile
import unittest

SOURCES = pathlib.Path(__file__).resolve().parents[2]
MPIRUN = os.environ["WEFT_MPIRUN"].split(";")
SECONDS = 250


def run(*words, **more):
    done = subprocess.run([str(w) for w in words], capture_output=True, text=True, timeout=SECONDS, **more)
    if done.returncode != 0:
        raise AssertionError(f"{' '.join(map(str, words))}\n{done.stdout}{done.stderr}")
    return done.stdout


def programs():
    """Language -> the words that run its example, for those that have been built."""
    known = {"C++": [os.environ["WEFT_CPP"]], "C": [os.environ["WEFT_C"]]}
    if "WEFT_FORTRAN" in os.environ:
        known["Fortran"] = [os.environ["WEFT_FORTRAN"]]
    if "WEFT_PYTHON" in os.environ:
        known["Python"] = [os.environ["WEFT_PYTHON"], "-B", SOURCES / "tools/bindings/python/examples/adapt_file.py"]
    return known


class Examples(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)

    def weft(self, *words):
        return run(os.environ["WEFT"], *words, cwd=self.folder)

    def test_all_languages_give_the_bytes_of_the_command(self):
        self.weft("mesh", "box", "--cells", 5, 5, 5, "-o", "start.meshb")
        self.weft("metric", "start.meshb", "--metric-fn", "polar-2", "--complexity", 1500, "-o", "start.solb")
        self.weft("adapt", "start.meshb", "--metric", "start.solb", "--hgrad", 1.5, "--threads", 1,
                  "-o", "fine.meshb")
        expected = [(self.folder / name).read_bytes() for name in ("fine.meshb", "fine.solb")]
        for language, words in programs().items():
            with self.subTest(language):
                run(*words, "start.meshb", "start.solb", f"{language}.meshb", cwd=self.folder)
                got = [(self.folder / f"{language}.{end}").read_bytes() for end in ("meshb", "solb")]
                self.assertEqual(got == expected, True)

    def test_parts_give_the_same_mesh_for_any_number_of_ranks(self):
        for name in ("WEFT_C_PARTS", "WEFT_FORTRAN_PARTS"):
            if name not in os.environ:
                continue
            with self.subTest(name):
                told = {run(*MPIRUN, "-n", ranks, os.environ[name]).strip() for ranks in (1, 2, 4)}
                self.assertEqual(len(told), 1, told)
                self.assertRegex(told.pop(), r"^all: \d+ tets, volume *(1|0\.99999999\d+|1\.00000000\d+)$")

    def test_shares_of_a_file_give_the_same_mesh_for_any_number_of_ranks(self):
        self.weft("mesh", "box", "--cells", 4, 4, 4, "-o", "start.meshb")
        self.weft("metric", "start.meshb", "--metric-fn", "polar-2", "-o", "start.solb")
        told = {run(*MPIRUN, "-n", ranks, os.environ["WEFT_C_SHARES"], "start.meshb", "start.solb", 500,
                    cwd=self.folder).strip() for ranks in (1, 2, 4)}
        self.assertEqual(len(told), 1, told)


if __name__ == "__main__":
    unittest.main()
