"""`weft interpolate`, and `weft adapt --field`: fields from one mesh to another."""

import json
import math
import unittest

from command import ONE_TET, ONE_TET_FACES, ONE_TET_POINTS, CommandTest, mesh_text, solution_text


class Fields(CommandTest):
    def values(self, name):
        words = (self.folder / name).read_text().split()
        return list(map(float, words[words.index("SolAtVertices") + 4 : words.index("End")]))

    def points(self, name):
        """The vertices of a text mesh."""
        lines = (self.folder / name).read_text().split("\n")
        at = next(i for i, line in enumerate(lines) if line.strip() == "Vertices")
        count = int(lines[at + 1])
        return [tuple(map(float, line.split()[:3])) for line in lines[at + 2 : at + 2 + count]]

    def solution(self, function, name, mesh="box.mesh"):
        return self.write(name, solution_text([(function(*p),) for p in self.points(mesh)], kind=1))


class Interpolate(Fields):
    def test_a_linear_field_stays_linear(self):
        self.write("from.mesh", ONE_TET)
        self.write("s.sol", solution_text([(0,), (1,), (2,), (3,)], kind=1))  # x + 2 y + 3 z
        self.weft("mesh", "box", "-o", "to.mesh", "--cells", 1, 1, 1, "--max", 0.3, 0.3, 0.3)
        done = self.weft("interpolate", "from.mesh", "to.mesh", "--field", "s.sol", "--field", "s.sol", "-o", "t.sol")
        values = self.values("t.sol")
        self.assertEqual(len(values[-16:]), 16)
        self.assertAlmostEqual(max(values[-16:]), 1.8, places=9)
        self.assertIn("2 fields at 8 vertices", done.stdout)
        self.assertRegex(done.stdout, r"(?m)^fields, linear +integral +changed by +back, L2 +back, most$")
        self.assertEqual(done.stdout.count("\n  s "), 2)

    def test_conservative_keeps_the_integral(self):
        self.box(5, "box.mesh")
        self.box(3, "to.mesh")
        self.solution(lambda x, y, z: math.tanh(30 * (x - 0.4)), "s.sol")
        changes = {}
        for how in ("linear", "conservative"):
            done = self.weft("interpolate", "box.mesh", "to.mesh", "--field", "s.sol", "--transfer", how, "-o", "t.sol")
            line = next(line for line in done.stdout.split("\n") if line.startswith("  s "))
            changes[how] = abs(float(line.split()[2]))
            self.assertLessEqual(max(map(abs, self.values("t.sol"))), 1)
        self.assertGreater(changes["linear"], 1e-6)
        self.assertLess(changes["conservative"], 1e-12)

    def test_outside_is_said(self):
        self.write("from.mesh", ONE_TET)
        self.write("s.sol", solution_text([(1,)] * 4, kind=1))
        done = self.weft("interpolate", "from.mesh", self.box(1), "--field", "s.sol", "-o", "t.sol")
        self.assertIn("warning: 4 vertices lie outside from.mesh", done.stdout)

    def test_what_cannot_be_kept_is_said(self):
        self.write("from.mesh", ONE_TET)
        self.write("s.sol", solution_text([(1,)] * 4, kind=1))
        done = self.weft("interpolate", "from.mesh", self.box(1), "--field", "s.sol", "--transfer", "conservative", "-o",
                         "t.sol")
        self.assertIn("warning: s leaves its old bounds by 0.833", done.stdout)  # a sixth of the volume

    def test_bad_input(self):
        self.write("from.mesh", ONE_TET)
        self.write("s.sol", solution_text([(1,)] * 3, kind=1))
        words = ["interpolate", "from.mesh", "from.mesh", "-o", "t.sol"]
        self.assert_fails(*words, "--field", "s.sol", says=["s.sol", "another mesh", "from.mesh has 4"])
        self.assert_fails("interpolate", "from.mesh", "none.mesh", "--field", "s.sol", "-o", "t.sol", says="none.mesh")
        self.assert_fails(*words, says="--field", code=64)
        self.assert_fails(*words, "--field", "s.sol", "--transfer", "magic", says="magic", code=64)
        self.write("s.sol", solution_text([(1,), (1,), ("nan",), (1,)], kind=1))
        self.assert_fails(*words, "--field", "s.sol", says=["s.sol: field 1: vertex 3", "not a finite number"])

    def test_the_mesh_that_cannot_be_used_is_named(self):
        self.write("good.mesh", ONE_TET)
        self.write("s.sol", solution_text([(1,)] * 4, kind=1))
        for bad, tets, says in (("none.mesh", [], "has no tetrahedra"), ("inverted.mesh", [(2, 1, 3, 4)], "tet 1: has no volume")):
            self.write(bad, mesh_text(ONE_TET_POINTS, tets, ONE_TET_FACES))
            for method in ("linear", "conservative"):
                for meshes in ((bad, "good.mesh"), ("good.mesh", bad)):
                    self.assert_fails("interpolate", *meshes, "--field", "s.sol", "--transfer", method, "-o", "t.sol", says=f"{bad}: {says}")


class AdaptWithFields(Fields):
    def adapt(self, *words, out="out.mesh", **others):
        return self.weft("adapt", "box.mesh", "--metric-fn", "uniform:0.23", *words, "-o", out, **others)

    def linear_files(self):
        """A scalar, a vector and a tensor, all linear, in two files."""
        self.box(3, "box.mesh")
        self.solution(lambda x, y, z: 1 + x - 2 * y + 3 * z, "s.sol")
        rows = [(x, y, z, x + y, 1, 2, 3, 4, z) for x, y, z in self.points("box.mesh")]
        text = solution_text(rows).replace("\n1 3\n", "\n2 2 3\n")
        self.write("two.sol", text)

    def test_linear_fields_of_all_kinds_arrive(self):
        self.linear_files()
        for how in ("linear", "conservative"):
            text = self.adapt("--field", "s.sol", "--field", "two.sol", "--transfer", how, "--report", "r").stdout
            self.assertIn("out-fields.sol", text)
            self.assertIn("two_1 3", text)
            report = json.loads((self.folder / "r/report.json").read_text())["fields"]
            self.assertEqual(report["transfer"], how)
            self.assertEqual(len(report["components"]), 10)
            for component in report["components"]:
                self.assertAlmostEqual(component["integral_after"], component["integral_before"], delta=1e-10)
                self.assertLess(component["back_difference_l2"], 1e-10)
            words = (self.folder / "out-fields.sol").read_text().split()
            at = words.index("SolAtVertices")
            self.assertEqual(words[at + 2 : at + 6], ["3", "1", "2", "3"])
            values = list(map(float, words[at + 6 : words.index("End")]))
            for i, (x, y, z) in enumerate(self.points("out.mesh")):
                wanted = (1 + x - 2 * y + 3 * z, x, y, z, x + y, 1, 2, 3, 4, z)
                for got, value in zip(values[10 * i : 10 * i + 10], wanted):
                    self.assertAlmostEqual(got, value, delta=1e-9)

    def test_a_shock_keeps_its_integral(self):
        self.box(6, "box.mesh")
        self.solution(lambda x, y, z: math.tanh(20 * (x - 0.4)), "s.sol")
        self.adapt("--field", "s.sol", "--transfer", "conservative", "--report", "r")
        component = json.loads((self.folder / "r/report.json").read_text())["fields"]["components"][0]
        self.assertEqual(component["name"], "s")
        self.assertAlmostEqual(component["integral_after"] / component["integral_before"], 1, delta=1e-10)
        self.assertGreater(component["back_difference_l2"], 0)

    def test_formats_that_hold_fields_get_them(self):
        self.linear_files()
        self.adapt("--field", "s.sol", out="out.vtu")
        self.assertIn('Name="s"', (self.folder / "out.vtu").read_bytes().decode("latin-1"))
        self.assertIn("out-fields.solb", self.files())
        self.weft("interpolate", "out.vtu", "box.mesh", "--field", "out.vtu", "-o", "back.sol")

    def test_without_fields_nothing_is_said_of_them(self):
        self.box(3, "box.mesh")
        self.assertNotIn("fields", self.adapt("--report", "r").stdout)
        self.assertIsNone(json.loads((self.folder / "r/report.json").read_text())["fields"])
        self.assertNotIn("out-fields.sol", self.files())

    def test_bad_input(self):
        self.linear_files()
        words = ["adapt", "box.mesh", "--metric-fn", "uniform:0.3", "-o", "out.mesh"]
        self.write("short.sol", solution_text([(1,)] * 5, kind=1))
        self.assert_fails(*words, "--field", "short.sol", says=["short.sol", "another mesh"])
        self.assert_fails(*words, "--field", "none.sol", says="none.sol")
        self.assert_fails(*words, "--field", "box.mesh", says="box.mesh")
        self.write("inf.sol", solution_text([("inf",)] + [(1,)] * 63, kind=1))
        self.assert_fails(*words, "--field", "inf.sol", says=["inf.sol: field 1: vertex 1", "not a finite"])
        self.assert_fails(*words, "--transfer", "linear", says="--field", code=64)
        self.assert_fails(*words[:-1], "s.mesh", "--field", "s.sol", says="would replace", code=64)
        self.assert_fails("interpolate", "box.mesh", "box.mesh", "--field", "s.sol", "-o", "s.sol", says="would replace", code=64)


if __name__ == "__main__":
    unittest.main()
