"""The example with dolfinx on 1, 2 and 4 ranks: adapted meshes give less error than uniform ones of as many unknowns."""

import os
import pathlib
import re
import subprocess
import tempfile
import unittest

PYTHON = os.environ["WEFT_PYTHON"]
MPIRUN = os.environ["WEFT_MPIRUN"].split(";")
EXAMPLE = pathlib.Path(os.environ["WEFT_SOURCES"]) / "tools/bindings/python/examples/dolfinx_loop.py"
SECONDS = 800


def run(ranks, *options, **more):
    done = subprocess.run([*MPIRUN, "-n", str(ranks), PYTHON, "-B", str(EXAMPLE), *options],
                          env=dict(os.environ, OMP_NUM_THREADS="1"), capture_output=True, text=True, timeout=SECONDS, **more)
    if done.returncode != 0:
        raise AssertionError(done.stdout + done.stderr)
    return {(name, kind): (int(unknowns), float(error)) for name, kind, unknowns, error
            in re.findall(r"(\w+) (uniform|adapted): (\d+) unknowns, error (\S+)", done.stdout)}


def has_dolfinx():
    return subprocess.run([PYTHON, "-c", "import dolfinx, petsc4py"], capture_output=True).returncode == 0


@unittest.skipUnless(has_dolfinx(), "SKIPPED: no dolfinx for this Python: scripts/setup.sh --all")
class Dolfinx(unittest.TestCase):
    def check(self, ranks, problem, *options, **more):
        told = run(ranks, "--levels", "1", "--problem", problem, *options, **more)
        (coarse, before), (unknowns, error) = told[problem, "uniform"], told[problem, "adapted"]
        uniform = before * (coarse / unknowns) ** (2 / 3)  # second order on uniform meshes, at best
        self.assertLess(error, 0.5 * uniform, told)
        return unknowns, error

    def test_poisson_on_1_2_and_4_ranks(self):
        unknowns, errors = zip(*(self.check(ranks, "poisson") for ranks in (1, 2, 4)))
        self.assertLess(max(unknowns) / min(unknowns), 1.1)
        self.assertLess(max(errors) / min(errors), 1.3)

    def test_advection_and_diffusion_on_2_ranks_with_a_picture(self):
        with tempfile.TemporaryDirectory() as folder:
            self.check(2, "advection", "--plot", "errors.png", cwd=folder)
            self.assertTrue((pathlib.Path(folder) / "errors.png").read_bytes().startswith(b"\x89PNG"))


if __name__ == "__main__":
    unittest.main()
