"""`weft interpolate`: fields from one mesh to another."""

import unittest

from command import ONE_TET, CommandTest, solution_text


class Interpolate(CommandTest):
    def values(self, name):
        words = (self.folder / name).read_text().split()
        return list(map(float, words[words.index("SolAtVertices") + 4 : words.index("End")]))

    def test_a_linear_field_stays_linear(self):
        self.write("from.mesh", ONE_TET)
        self.write("s.sol", solution_text([(0,), (1,), (2,), (3,)], kind=1))  # x + 2 y + 3 z
        self.weft("mesh", "box", "-o", "to.mesh", "--cells", 1, 1, 1, "--max", 0.3, 0.3, 0.3)
        done = self.weft("interpolate", "from.mesh", "to.mesh", "--field", "s.sol", "--field", "s.sol", "-o", "t.sol")
        values = self.values("t.sol")
        self.assertEqual(len(values[-16:]), 16)
        self.assertAlmostEqual(max(values[-16:]), 1.8, places=9)
        self.assertIn("2 fields at 8 vertices", done.stdout)
        self.assertIn("field 1: integral", done.stdout)

    def test_outside_is_said(self):
        self.write("from.mesh", ONE_TET)
        self.write("s.sol", solution_text([(1,)] * 4, kind=1))
        done = self.weft("interpolate", "from.mesh", self.box(1), "--field", "s.sol", "-o", "t.sol")
        self.assertIn("warning: 4 vertices lie outside from.mesh", done.stdout)

    def test_bad_input(self):
        self.write("from.mesh", ONE_TET)
        self.write("s.sol", solution_text([(1,)] * 3, kind=1))
        self.assert_fails("interpolate", "from.mesh", "from.mesh", "--field", "s.sol", "-o", "t.sol",
                          says=["s.sol", "another mesh", "from.mesh has 4"])
        self.assert_fails("interpolate", "from.mesh", "none.mesh", "--field", "s.sol", "-o", "t.sol", says="none.mesh")
        self.assert_fails("interpolate", "from.mesh", "from.mesh", "-o", "t.sol", says="--field", code=64)


if __name__ == "__main__":
    unittest.main()
