#!/usr/bin/env python3
"""graph/examples on ranks: what each version computes, beside a serial computation. WEFT_RANKS of them."""

import array
import json
import math
import operator
import os
import pathlib
import subprocess
import tempfile
import unittest

FOLDER = pathlib.Path(os.environ["WEFT_EXAMPLES"])
MPIRUN = os.environ["WEFT_MPIRUN"].split(";")
RANKS = int(os.environ["WEFT_RANKS"])


def run(program, **options):
    """The result of a program on RANKS ranks, and its figures."""
    with tempfile.TemporaryDirectory(prefix="weft-examples-test-") as folder:
        out = pathlib.Path(folder) / "result"
        words = [word for name, value in options.items() for word in (f"--{name}", str(value))]
        done = subprocess.run([*MPIRUN, "-n", str(RANKS), FOLDER / f"weft_example_{program}", *words, "--out", out], stdout=subprocess.PIPE,
                              text=True, timeout=250, check=True)
        return array.array("d", out.read_bytes()), json.loads(done.stdout)


def heat(size, steps):
    grid = [[0.0] * (size + 2) for _ in range(size + 2)]
    for r in range(size):
        for c in range(size):
            grid[r + 1][c + 1] = (7 * r + 13 * c) % 101 / 100
    for _ in range(steps):
        now, grid = grid, [row[:] for row in grid]
        for r in range(1, size + 1):
            above, here, below = now[r - 1:r + 2]
            for c in range(1, size + 1):
                grid[r][c] += 0.2 * (above[c] + below[c] + here[c - 1] + here[c + 1] - 4 * here[c])
    return [value for row in grid[1:-1] for value in row[1:-1]]


def cholesky(size):
    """The lower half, row by row."""
    lower = []
    for r in range(size):
        row = []
        for c in range(r + 1):
            other = lower[c] if c < r else row
            rest = 1 / (1 + r - c) + (r == c) - sum(map(operator.mul, row, other[:c]))
            row.append(math.sqrt(rest) if r == c else rest / other[c])
        lower.append(row)
    return [value for row in lower for value in row]


def from_tiles(values, size, tile):
    """The lower half row by row, of one that is stored tile by tile, column by column of tiles, each columns first."""
    first, starts = 0, {}
    for column in range(size // tile):
        for row in range(column, size // tile):
            starts[row, column], first = first, first + tile * tile
    return [values[starts[r // tile, c // tile] + c % tile * tile + r % tile] for r in range(size) for c in range(r + 1)]


def particles(count, cells, steps):
    places = []
    for i in range(count):
        u, angle = i * 0.6180339887498949 % 1, 2 * math.pi * (i * 0.7548776662466927 % 1)
        places.append(((0.3 + 0.45 * u * u * math.cos(angle)) % 1, (0.3 + 0.45 * u * u * math.sin(angle)) % 1))
    for _ in range(steps):
        moved = []
        for x, y in places:
            fx = fy = 0
            for other_x, other_y in places:
                dx, dy = x - other_x, y - other_y
                dx, dy = dx - round(dx), dy - round(dy)
                distance = math.sqrt(dx * dx + dy * dy)
                if 0 < distance < 1 / cells:
                    strength = 1e-5 * (1 - distance * cells) / distance
                    fx, fy = fx + strength * dx, fy + strength * dy
            moved.append(((x + 0.01 + fx) % 1, (y + fy) % 1))
        places = moved
    return [value for place in places for value in place]


class Examples(unittest.TestCase):
    def compare(self, program, expected, unpack=lambda values: values, **options):
        """Both versions compute it, and to the same bits."""
        engine, figures = run(program, **options)
        plain, plain_figures = run(f"{program}_plain", **{name: value for name, value in options.items() if name != "balancer"})
        result = unpack(engine)
        self.assertEqual(len(result), len(expected))
        self.assertLess(max(abs(one - other) for one, other in zip(result, expected)), 1e-11)
        self.assertEqual(engine, plain)
        self.assertEqual((figures["ranks"], plain_figures["ranks"]), (RANKS, RANKS))
        self.assertEqual(plain_figures["messages"] > 0, RANKS > 1)
        return figures

    def test_heat(self):
        figures = self.compare("heat", heat(96, 30), size=96, tile=16, steps=30)
        # An update each block and step; edges that cross the ranks' borders, each way.
        self.assertEqual(figures["messages"], 30 * 2 * 6 * (RANKS - 1))
        self.assertEqual(figures["bytes"] > 30 * 2 * 96 * 8 * (RANKS - 1), RANKS > 1)

    def test_heat_of_blocks_that_move(self):
        figures = self.compare("heat", heat(64, 12), size=64, tile=8, steps=12, threads=2, balancer="rotate")
        self.assertEqual(figures["moves"] > 0, RANKS > 1)

    def test_cholesky(self):
        for tile in 16, 48:
            self.compare("cholesky", cholesky(192), lambda values: from_tiles(values, 192, tile), size=192, tile=tile, threads=2)

    def test_options_that_a_program_has_no_use_for_are_refused(self):
        for program, option in ("cholesky", "--balancer"), ("cholesky", "--steps"), ("heat_plain", "--balancer"):
            done = subprocess.run([FOLDER / f"weft_example_{program}", option, "3"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                  text=True, timeout=60, check=False)
            self.assertNotEqual(done.returncode, 0)
            self.assertIn(option, done.stdout)

    def test_particles(self):
        self.compare("particles", particles(500, 12, 5), size=500, tile=12, steps=5)

    def test_particles_of_cells_that_move(self):
        figures = self.compare("particles", particles(500, 12, 5), size=500, tile=12, steps=5, threads=2, balancer="rotate")
        self.assertEqual(figures["moves"] > 0, RANKS > 1)


if __name__ == "__main__":
    unittest.main()
