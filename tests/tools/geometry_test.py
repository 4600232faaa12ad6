"""`--geometry`: meshes made of a CAD model, adapted on it and measured against it."""

import json
import os
import unittest

from command import DATA, CommandTest

MODEL = DATA / "models" / "cylinder.brep"  # radius 1, height 2, made by OpenCASCADE


@unittest.skipUnless(os.environ.get("WEFT_HAS_CAD") == "1", "this build has no OpenCASCADE")
class Geometry(CommandTest):
    def model(self, mesh):
        """What stat tells of a mesh on the model."""
        return json.loads(self.weft("stat", mesh, "--geometry", MODEL, "--json").stdout)["model"]

    def start(self):
        self.weft("mesh", MODEL, "--size", 0.5, "--hausd", 0.05, "-o", "start.meshb")
        return "start.meshb"

    def assert_on_model(self, mesh):
        account = self.model(mesh)
        self.assertEqual(account["off"], 0)
        self.assertEqual(account["unclassified_triangles"], 0)
        self.assertLess(account["largest"], 1e-10)
        self.assertGreater(account["least_normal"], 0)
        return account

    def test_a_model_becomes_a_mesh_that_lies_on_it(self):
        account = self.assert_on_model(self.start())
        self.assertEqual((account["faces"], account["edges"], account["nodes"]), (3, 3, 2))
        verified = self.weft("verify", "start.meshb")
        self.assertIn("start.meshb", verified.stdout)

    def test_an_adapted_mesh_stays_on_the_model_and_records_where(self):
        self.start()
        self.weft("adapt", "start.meshb", "--geometry", MODEL, "--curvature", 24, "--complexity", 800, "-o", "fine.mesh",
                  "--report", "report", expect=(0, 1))
        self.assert_on_model("fine.mesh")
        text = (self.folder / "fine.mesh").read_text()
        self.assertIn("VerticesOnGeometricTriangles", text)
        report = json.loads((self.folder / "report" / "report.json").read_text())
        self.assertEqual(report["model"]["off"], 0)

    def test_subdomains_stay_on_the_model(self):
        self.start()
        self.weft("adapt", "start.meshb", "--geometry", MODEL, "--metric-fn", "uniform:0.2", "--subdomains", 4, "-o",
                  "parts.meshb", expect=(0, 1))
        self.assert_on_model("parts.meshb")

    def test_a_wrong_unit_is_refused_with_the_factor(self):
        self.start()
        self.assert_fails("adapt", "start.meshb", "--geometry", MODEL, "--geometry-scale", 1000, "--metric-fn", "uniform:0.3",
                          "-o", "x.meshb", says="--geometry-scale 1?")

    def test_words_that_name_no_model_are_refused(self):
        self.start()
        self.assert_fails("adapt", "start.meshb", "--geometry", "part.dwg", "--metric-fn", "uniform:0.3", "-o", "x.meshb",
                          says=".step", code=64)
        self.assert_fails("adapt", "start.meshb", "--geometry", "none.step", "--metric-fn", "uniform:0.3", "-o", "x.meshb",
                          says="none.step")


if __name__ == "__main__":
    unittest.main()
