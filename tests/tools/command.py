"""Runs build/bin/weft as a user would, in a folder of its own, and looks at what it leaves behind."""

import os
import pathlib
import subprocess
import tempfile
import unittest

WEFT = pathlib.Path(os.environ["WEFT"]).resolve()
DATA = pathlib.Path(os.environ["WEFT_TEST_DATA"]).resolve()


class CommandTest(unittest.TestCase):
    """Each test works in an empty folder, which also is the current one of the command."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="weft-command-test-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def weft(self, *words, expect=0):
        """Runs the command, which must end with `expect` (a code or several); returns what it printed."""
        done = subprocess.run([str(WEFT), *map(str, words)], cwd=self.folder, capture_output=True, text=True, timeout=250)
        # Said of simulated ranks by the sanitizer, not by weft.
        done.stderr = "".join(line for line in done.stderr.splitlines(keepends=True)
                              if "WARNING: ASan doesn't fully support makecontext" not in line)
        codes = expect if isinstance(expect, tuple) else (expect,)
        self.assertIn(done.returncode, codes, f"weft {' '.join(map(str, words))}\n{done.stdout}{done.stderr}")
        return done

    def box(self, cells=2, name="box.meshb"):
        self.weft("mesh", "box", "-o", name, "--cells", cells, cells, cells)
        return name

    def write(self, name, text):
        (self.folder / name).write_text(text)
        return name

    def files(self):
        return sorted(path.name for path in self.folder.iterdir())

    def assert_fails(self, *words, says, code=2):
        """The command ends with `code`, one line on stderr (two for usage) with all of `says`, and no new file."""
        before = self.files()
        done = self.weft(*words, "--quiet", expect=code) if words[0] == "adapt" else self.weft(*words, expect=code)
        for word in [says] if isinstance(says, str) else says:
            self.assertIn(word, done.stderr)
        self.assertTrue(done.stderr.startswith("weft"), done.stderr)
        self.assertLessEqual(len(done.stderr.splitlines()), 1 if code == 2 else 2, done.stderr)
        self.assertEqual(self.files(), before)
        return done


def mesh_text(points, tets, triangles=(), edges=()):
    """A .mesh file; indices from 1, every reference 1."""
    def section(name, rows):
        lines = "".join(" ".join(map(str, row)) + " 1\n" for row in rows)
        return f"{name}\n{len(rows)}\n{lines}" if rows else ""

    return ("MeshVersionFormatted 2\nDimension 3\n" + section("Vertices", points) + section("Tetrahedra", tets) +
            section("Triangles", triangles) + section("Edges", edges) + "End\n")


def without_first_triangle(text):
    """The text of a .mesh file less one triangle."""
    before, triangles, rest = text.partition("\nTriangles\n")
    count, _, others = rest.split("\n", 2)
    return f"{before}{triangles}{int(count) - 1}\n{others}"


def solution_text(rows, kind=3):
    """A .sol file with one field: kind 1 scalar, 2 vector, 3 symmetric tensor."""
    lines = "".join(" ".join(map(str, row)) + "\n" for row in rows)
    return f"MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n{len(rows)}\n1 {kind}\n{lines}End\n"


ONE_TET_POINTS = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
ONE_TET_FACES = [(2, 3, 4), (1, 4, 3), (1, 2, 4), (1, 3, 2)]
ONE_TET = mesh_text(ONE_TET_POINTS, [(1, 2, 3, 4)], ONE_TET_FACES)
