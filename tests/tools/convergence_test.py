"""scripts/convergence.py on a small scale: the error of interpolation falls at the rate of theory."""

import csv
import os
import pathlib
import subprocess
import sys
import unittest
import xml.etree.ElementTree

from command import WEFT, CommandTest

SCRIPT = pathlib.Path(__file__).resolve().parent.parent.parent / "scripts/convergence.py"


class Convergence(CommandTest):
    def run_script(self, *words, expect=0):
        done = subprocess.run([sys.executable, "-B", str(SCRIPT), "--bin", str(WEFT.parent), "--out", str(self.folder),
                               *map(str, words)], capture_output=True, text=True)
        self.assertEqual(done.returncode, expect, done.stdout + done.stderr)
        return done

    def test_known_fields_reach_the_rate_of_theory(self):
        targets = [1000, 4000, 16000] if os.environ.get("WEFT_LONG_TESTS") else [500, 1000, 4000]
        words = ["--complexities", *targets, "--cycles", 2, "--hgrad", 2]
        text = self.run_script(*words).stdout
        for field in ("smooth", "layer", "shock"):
            self.assertIn(f"{field}: rate ", text)
        with open(self.folder / "convergence.csv") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual([row["target"] for row in rows], [str(target) for target in targets] * 3)
        for row in rows:
            self.assertGreater(float(row["l2_error"]), 0)
            self.assertAlmostEqual(float(row["complexity"]) / float(row["target"]), 1, delta=0.2)
        picture = xml.etree.ElementTree.parse(self.folder / "convergence.svg").getroot()
        marks = [len(picture.findall(".//{http://www.w3.org/2000/svg}" + mark)) for mark in ("circle", "polygon")]
        self.assertEqual(marks, [3, 6])  # three points of each curve, every curve with marks of its own
        self.run_script(*words, "--least", 9, expect=1)  # takes the loops that are there

    def test_bad_options(self):
        self.assertIn("--complexities", self.run_script("--complexities", 1000, expect=2).stderr)
        self.assertIn("wavy", self.run_script("--fields", "wavy", expect=2).stderr)


if __name__ == "__main__":
    unittest.main()
