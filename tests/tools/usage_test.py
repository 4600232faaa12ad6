"""Command lines that make no sense, help, and version."""

import unittest

from command import CommandTest

SUBCOMMANDS = [["adapt"], ["stat"], ["verify"], ["metric"], ["mesh"], ["mesh", "box"], ["mesh", "ball"], ["mesh", "cylinder"],
               ["mesh", "delta-wing"], ["convert"], ["interpolate"], ["loop"], ["view"]]


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
        self.assertRegex(self.weft("--version").stdout, r"^weft \d+\.\d+\.\d+\n$")

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
            (["--progress", "loud"], "--progress"),
            (["--metric", "m.solb"], "--metric"),
            (["--nonsense"], "--nonsense"),
        ]:
            self.assert_fails(*good, *bad, says=says, code=64)

    def test_what_is_missing_is_named(self):
        self.assert_fails("adapt", says="IN", code=64)
        self.assert_fails("adapt", "a.meshb", "--metric-fn", "polar-2", says="--out", code=64)
        self.assert_fails("adapt", "a.meshb", "-o", "b.meshb", says=["--metric FILE", "--metric-fn NAME"], code=64)
        self.assert_fails("adapt", "a.meshb", "--metric-fn", "polar-9", "-o", "b.meshb", says="polar-9", code=64)
        self.assert_fails("adapt", "a.meshb", "--metric-fn", "polar-2", "-o", "b.stl", says="b.stl", code=64)
        self.assert_fails("mesh", says="subcommand", code=64)
        self.assert_fails("metric", "a.meshb", "-o", "m.solb", says="--metric-fn", code=64)

    def test_a_box_without_volume(self):
        self.assert_fails("mesh", "box", "-o", "b.meshb", "--max", 1, 0, 1, says="--max", code=64)
        self.assert_fails("mesh", "box", "-o", "b.meshb", "--cells", 0, 1, 1, says="--cells", code=64)


if __name__ == "__main__":
    unittest.main()
