"""Command lines that make no sense, help, and version."""

import os
import subprocess
import unittest

from command import WEFT, CommandTest

SUBCOMMANDS = [["adapt"], ["stat"], ["verify"], ["metric"], ["mesh"], ["mesh", "box"], ["mesh", "ball"], ["mesh", "cylinder"],
               ["mesh", "delta-wing"], ["convert"], ["interpolate"], ["loop"], ["view"], ["graph"], ["replay"], ["report"]]


class Usage(CommandTest):
    def test_help_of_everything_has_an_example_and_fits(self):
        for words in [[], *SUBCOMMANDS]:
            text = self.weft(*words, "--help").stdout
            self.assertIn("Example", text)
            self.assertLessEqual(max(map(len, text.splitlines())), 108, words)

    def test_the_main_job_comes_first(self):
        text = self.weft("--help").stdout
        self.assertLess(text.index("  adapt"), text.index("  stat"))

    def test_version(self):
        first, *others = self.weft("--version").stdout.splitlines()
        self.assertRegex(first, r"^weft \d+\.\d+\.\d+$")
        told = dict(line.split(maxsplit=1) for line in others)
        self.assertEqual(list(told), ["compiler", "MPI", "TBB", "CGAL", "Ceres", "Eigen", "METIS", "HDF5", "CGNS", "processor",
                                      "assertions"])
        for name in ["compiler", "MPI", "TBB", "CGAL", "Ceres", "Eigen", "METIS", "HDF5", "CGNS"]:
            self.assertRegex(told[name], r"\d+\.\d+", name)

    def test_what_few_runs_need_is_not_loaded_by_all(self):
        done = subprocess.run([WEFT], env=dict(os.environ, LD_TRACE_LOADED_OBJECTS="1"), capture_output=True, text=True, timeout=60)
        self.assertIn("libmpi", done.stdout)
        self.assertNotRegex(done.stdout, "libcgns|libhdf5|libcairo|libcurl|libX11|libTKernel|libsimgrid")

    def test_everything_is_silent_when_quiet(self):
        size = ["--metric-fn", "uniform:0.5"]
        self.write("one.sol", "MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n27\n1 1\n" + "1\n" * 27 + "End\n")
        self.write("loop.json", '{"mesh": "box.meshb", "solver": "%s interpolate box.meshb {mesh} --field one.sol -o {solution} --quiet",'
                                ' "complexities": [8]}' % WEFT)
        for words in [
            ["mesh", "box", "-o", "box.meshb", "--cells", 2, 2, 2],
            ["mesh", "ball", "--size", 0.8, "-o", "ball.meshb"],
            ["mesh", "cylinder", "--size", 0.8, "-o", "cylinder.meshb"],
            ["mesh", "delta-wing", "-o", "wing.meshb"],
            ["convert", "ball.meshb", "ball.stl"],
            ["mesh", "ball.stl", "-o", "filled.meshb"],
            ["adapt", "box.meshb", *size, "-o", "fine.meshb", "--subdomains", 2, "--report", "run"],
            ["adapt", "box.meshb", *size, "-o", "fine.meshb"],
            ["stat", "fine.meshb", *size, "--histogram"],
            ["stat", "fine.meshb", "--json"],
            ["verify", "fine.meshb", "--against", "box.meshb"],
            ["metric", "box.meshb", *size, "-o", "metric.solb"],
            ["interpolate", "box.meshb", "fine.meshb", "--field", "metric.solb", "-o", "carried.solb"],
            ["convert", "fine.meshb", "fine.vtu"],
            ["view", "fine.meshb", "-o", "fine.png", "--size", "64x64"],
            ["graph", "run/graph.json"],
            ["replay", "run/graph.json", "--ranks", 4],
            ["report", "run/profile.json", "run/profile.json", "-o", "compared.html"],
            ["loop", "loop.json"],
        ]:
            for style in [[], ["--progress", "plain"]]:
                done = self.weft(*words, "--quiet", *style)
                # The address sanitizer tells of its own limits where SimGrid changes stacks.
                told = [line for line in done.stderr.splitlines() if "WARNING: ASan doesn't fully support" not in line]
                self.assertEqual((done.stdout, told), ("", []), words)
        self.assertTrue((self.folder / "compared.html").exists())

    def test_a_quiet_answer_is_the_exit_code(self):
        self.box()
        self.weft("mesh", "box", "-o", "other.meshb", "--max", 1, 1, 2, "--quiet")
        done = self.weft("verify", "box.meshb", "--against", "other.meshb", "--quiet", expect=1)
        self.assertEqual(done.stdout + done.stderr, "")

    def test_nothing_given_prints_the_help(self):
        self.assertIn("weft adapt wing.meshb", self.weft(expect=64).stderr)

    def test_an_unknown_subcommand_is_guessed(self):
        self.assert_fails("adpt", "a.meshb", says="did you mean `weft adapt`?", code=64)
        self.assert_fails("wing.meshb", says="weft --help", code=64)

    def test_bad_options(self):
        good = ["adapt", "a.meshb", "--metric-fn", "polar-2", "-o", "b.meshb"]
        for bad, says in [
            (["--complexity", "-5"], "--complexity"),
            (["--complexity", "nan"], "nan"),
            (["--complexity", "many"], "many"),
            (["--hmin", "0"], "--hmin"),
            (["--hmin", "2", "--hmax", "1"], "--hmin"),
            (["--threads", "0"], "--threads"),
            (["--threads", "1.5"], "--threads"),
            (["--ridge-angle", "200"], "--ridge-angle"),
            (["--progress", "loud"], "--progress: 'loud' is not one of auto, none and plain"),
            (["--field", "f.solb", "--transfer", "1"], "--transfer: '1' is not one of conservative and linear"),
            (["--metric", "m.solb"], "--metric"),
            (["--nonsense"], "--nonsense"),
        ]:
            self.assert_fails(*good, *bad, says=says, code=64)

    def test_what_is_missing_is_named(self):
        self.assert_fails("adapt", says="IN", code=64)
        self.assert_fails("adapt", "a.meshb", "--metric-fn", "polar-2", says="--out", code=64)
        self.assert_fails("adapt", "a.meshb", "-o", "b.meshb", says=["--metric FILE", "--metric-fn NAME", "--implied", "--sagitta D"], code=64)
        self.assert_fails("adapt", "a.meshb", "--metric-fn", "polar-9", "-o", "b.meshb", says="polar-9", code=64)
        self.assert_fails("adapt", "a.meshb", "--metric-fn", "polar-2", "-o", "b.stl", says="b.stl", code=64)
        self.assert_fails("mesh", says="subcommand", code=64)
        self.assert_fails("metric", "a.meshb", "-o", "m.solb", says=["--metric-fn", "--sagitta D"], code=64)

    def test_a_box_without_volume(self):
        self.assert_fails("mesh", "box", "-o", "b.meshb", "--max", 1, 0, 1, says="--max", code=64)
        self.assert_fails("mesh", "box", "-o", "b.meshb", "--cells", 0, 1, 1, says="--cells", code=64)
        self.assert_fails("mesh", "box", "-o", "b.meshb", "--cells", 2, 2, says="one number or three", code=64)


if __name__ == "__main__":
    unittest.main()
