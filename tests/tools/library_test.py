"""The library program of the README: the same text as the one that is built, and it runs."""

import os
import pathlib
import re
import shutil
import subprocess
import unittest

from command import DATA, CommandTest

SOURCE = pathlib.Path(__file__).resolve().parent / "library_example.cpp"
README = SOURCE.parents[2] / "README.md"


class Library(CommandTest):
    def test_the_readme_shows_the_program_that_is_built(self):
        shown = re.search(r"```cpp\n(.*?)```", README.read_text(), re.DOTALL).group(1)
        self.assertEqual(shown, SOURCE.read_text().split("\n", 1)[1])

    def test_the_program_runs(self):
        shutil.copy(DATA / "delta-wing-coarse.meshb", self.folder / "wing.meshb")
        self.weft("metric", "wing.meshb", "--metric-fn", "uniform:1", "-o", "wing.solb")
        subprocess.run([os.environ["WEFT_LIBRARY_EXAMPLE"]], cwd=self.folder, check=True, timeout=250)
        self.weft("verify", "fine.meshb", "--against", "wing.meshb")
        self.weft("stat", "fine.meshb", "--metric", "fine.solb")


if __name__ == "__main__":
    unittest.main()
