"""`weft metric`, and `weft adapt --sol`: metrics made from solutions, from the mesh and from its boundary."""

import math
import re
import unittest

from command import CommandTest, solution_text


class Metric(CommandTest):
    def points(self, name="box.mesh"):
        """The vertices of a text mesh."""
        lines = (self.folder / name).read_text().split("\n")
        at = next(i for i, line in enumerate(lines) if line.strip() == "Vertices")
        count = int(lines[at + 1])
        return [tuple(map(float, line.split()[:3])) for line in lines[at + 2 : at + 2 + count]]

    def solution(self, function, name="s.sol", mesh="box.mesh"):
        return self.write(name, solution_text([(function(*p),) for p in self.points(mesh)], kind=1))

    def tensors(self, name):
        numbers = (self.folder / name).read_text().split()
        at = numbers.index("SolAtVertices")
        values = list(map(float, numbers[at + 4 : numbers.index("End")]))
        return [values[i : i + 6] for i in range(0, len(values), 6)]

    def complexity(self, done):
        return float(re.search(r"complexity ([\d,.]+)", done.stdout).group(1).replace(",", ""))

    def shock(self, cells=8):
        self.box(cells, "box.mesh")
        return self.solution(lambda x, y, z: math.tanh(12 * (x - 0.5)))

    def test_threads_do_not_matter(self):
        self.shock()
        for threads in (1, 3):
            self.weft("metric", "box.mesh", "--sol", "s.sol", "--complexity", 700, "--hgrad", 1.4, "--threads", threads,
                      "-o", f"m{threads}.solb")
        self.assertEqual((self.folder / "m1.solb").read_bytes(), (self.folder / "m3.solb").read_bytes())
        self.assert_fails("metric", "box.mesh", "--sol", "s.sol", "--threads", 0, "-o", "x.solb", says="--threads", code=64)

    def test_a_solution_becomes_a_metric_of_the_complexity_asked_for(self):
        self.shock()
        for options in ([], ["--recovery", "l2"], ["--norm", "inf"], ["--norm", 4, "--hgrad", 1.5],
                        ["--hgrad", 1.3, "--hgrad-space", "mixed", "--aspect", 8, "--hmin", 0.01, "--hmax", 0.5]):
            done = self.weft("metric", "box.mesh", "--sol", "s.sol", "--complexity", 700, *options, "-o", "m.sol")
            self.assertAlmostEqual(self.complexity(done), 700, delta=1)
            self.assertEqual(done.stdout.count("warning"), 0)

    def test_without_a_complexity_a_solution_keeps_that_of_the_mesh(self):
        self.shock()
        own = self.complexity(self.weft("metric", "box.mesh", "--implied", "-o", "m.sol"))
        done = self.weft("metric", "box.mesh", "--sol", "s.sol", "-o", "m.sol")
        self.assertAlmostEqual(self.complexity(done), own, delta=1)

    def test_several_fields_are_intersected(self):
        self.box(6, "box.mesh")
        self.solution(lambda x, y, z: x * x, "x.sol")
        self.solution(lambda x, y, z: y * y, "y.sol")
        self.weft("metric", "box.mesh", "--sol", "x.sol", "--sol", "y.sol", "--complexity", 500, "--aspect", 50, "-o",
                  "m.sol")
        for m11, _, m22, _, _, m33 in self.tensors("m.sol"):
            self.assertAlmostEqual(m11 / m22, 1, delta=0.01)  # both directions alike, z without need
            self.assertGreater(m11 / m33, 100)

    def test_one_command_from_solution_to_adapted_mesh(self):
        self.shock(6)
        done = self.weft("adapt", "box.mesh", "--sol", "s.sol", "--complexity", 600, "--hgrad", 1.5, "-o", "fine.mesh")
        self.assertIn("fine.mesh", done.stdout)
        self.weft("verify", "fine.mesh")
        near = [p for p in self.points("fine.mesh") if abs(p[0] - 0.5) < 0.2]
        self.assertGreater(len(near), 0.48 * len(self.points("fine.mesh")))  # 40 % of the volume

    def test_wall_layers_keep_their_height(self):
        self.box(6, "box.mesh")
        self.weft("metric", "box.mesh", "--metric-fn", "uniform:0.2", "--wall", "5,1", "--wall-height", 0.01,
                  "--wall-size", 0.1, "--complexity", 3000, "--hgrad", 1.5, "-o", "m.sol")
        sizes = [m[5] ** -0.5 for p, m in zip(self.points(), self.tensors("m.sol")) if p[2] == 0]
        self.assertLessEqual(max(sizes), 0.0101)

    def test_boundary_sizes_that_are_scaled_are_told(self):
        self.box(4, "box.mesh")
        words = ["metric", "box.mesh", "--wall", 5, "--wall-height", 1e-2, "--wall-size", 0.1, "-o", "m.sol"]
        said = "warning: the boundary's sizes are not as asked for"
        self.assertNotIn(said, self.weft(*words).stdout)
        self.assertNotIn(said, self.weft(*words, "--complexity", 3000, "--metric-fn", "uniform:0.2").stdout)
        done = self.weft(*words, "--complexity", 20)
        self.assertAlmostEqual(self.complexity(done), 20, delta=0.1)
        self.assertIn(said, done.stdout)

    def test_curvature_of_planes_asks_for_nothing(self):
        self.box(3, "box.mesh")
        self.weft("metric", "box.mesh", "--curvature", 20, "--sagitta", 1e-3, "-o", "m.sol")
        for m in self.tensors("m.sol"):
            self.assertAlmostEqual(m[0] ** -0.5, math.sqrt(3), places=9)

    def test_demands_beyond_the_complexity_are_said(self):
        self.box(4, "box.mesh")
        done = self.weft("metric", "box.mesh", "--implied", "--wall", 5, "--wall-height", 1e-3, "--wall-size", 1e-2,
                         "--complexity", 10, "-o", "m.sol")
        self.assertIn("warning: limits and boundary sizes lead to a complexity of", done.stdout)

    def test_same_bytes_every_time(self):
        self.shock()
        for name in ("a.solb", "b.solb"):
            self.weft("metric", "box.mesh", "--sol", "s.sol", "--complexity", 700, "--hgrad", 1.5, "-o", name)
        self.assertEqual((self.folder / "a.solb").read_bytes(), (self.folder / "b.solb").read_bytes())

    def refuse(self, *words, says, code=2):
        self.assert_fails("metric", "box.mesh", *words, "-o", "m.sol", says=says, code=code)

    def test_bad_solutions(self):
        self.box(2, "box.mesh")
        n = len(self.points())
        self.refuse("--sol", "none.sol", says="none.sol")
        for bad in ("nan", "-inf"):
            self.write("s.sol", solution_text([(1,)] * 6 + [(bad,)] + [(1,)] * (n - 7), kind=1))
            self.refuse("--sol", "s.sol", says=["weft: s.sol: vertex 7", "not a finite number"])
        self.write("s.sol", solution_text([(1,)] * (n - 1), kind=1))
        self.refuse("--sol", "s.sol", says=["s.sol", "another mesh", str(n - 1), str(n)])
        self.write("s.sol", solution_text([(1, 0, 0)] * n, kind=2))
        self.refuse("--sol", "s.sol", says=["s.sol", "no scalar field"])
        self.write("s.sol", solution_text([(1,)] * n, kind=1).replace("1\nEnd", "End"))
        self.refuse("--sol", "s.sol", says="s.sol")
        self.write("s.sol", "what is this")
        self.refuse("--sol", "s.sol", says="s.sol")

    def test_bad_walls(self):
        self.box(2, "box.mesh")
        self.refuse("--wall", "9", "--wall-height", 0.1, says=["box.mesh: wall 9", "no triangle"])
        self.refuse("--wall", "1", says="--wall-height", code=64)
        self.refuse("--wall-height", 0.1, "--implied", says="--wall", code=64)

    def test_options_that_make_no_sense(self):
        self.shock(2)
        self.refuse(says="--sol", code=64)
        self.refuse("--sol", "s.sol", "--norm", 0.5, says="0.5", code=64)
        self.refuse("--sol", "s.sol", "--recovery", "guess", says="guess", code=64)
        self.refuse("--sol", "s.sol", "--hgrad-space", "outer", says="outer", code=64)
        self.refuse("--sol", "s.sol", "--aspect", 0.5, says="--aspect", code=64)
        self.refuse("--implied", "--norm", 2, says="--sol", code=64)

    def test_the_result_may_not_replace_the_solution(self):
        self.shock(2)
        self.assert_fails("adapt", "box.mesh", "--sol", "s.sol", "-o", "s.mesh", says="would replace", code=64)
        before = (self.folder / "s.sol").read_bytes()
        self.assert_fails("metric", "box.mesh", "--sol", "s.sol", "-o", "s.sol", says="would replace the input s.sol", code=64)
        self.assertEqual((self.folder / "s.sol").read_bytes(), before)


if __name__ == "__main__":
    unittest.main()
