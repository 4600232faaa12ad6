"""`--geometry`: meshes made of a CAD model, adapted on it and measured against it."""

import base64
import json
import os
import shlex
import shutil
import subprocess
import unittest

from command import DATA, WEFT, CommandTest
from view_test import Png

MPIRUN = os.environ["WEFT_MPIRUN"].split(";")
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
        self.assert_page_shows(report["model"])

    def assert_page_shows(self, account):
        """Of the report page's picture: the farthest triangle is that of the account, and all have a colour."""
        deviation = max(e["deviation"] for e in account["entities"] if e["kind"] == "face")
        mesh = json.loads((self.folder / "report" / "profile.json").read_text())["mesh"]
        self.assertAlmostEqual(mesh["largest_deviation"], deviation, delta=1e-6 * deviation)
        shown = base64.b64decode(mesh["layers"][0]["deviation"])
        self.assertEqual(len(shown), mesh["layers"][0]["facets"])
        self.assertEqual(max(shown), 254)
        self.assertLess(min(shown), 100)
        self.assertNotIn("deviation", mesh["layers"][1])

    def on_ranks(self, ranks, *words, before=""):
        """`weft` on so many ranks, each of which first runs a line of shell."""
        line = before + shlex.join(["exec", str(WEFT), *map(str, words)])
        return subprocess.run([*MPIRUN, "-n", str(ranks), "sh", "-c", line], cwd=self.folder, capture_output=True, text=True,
                              timeout=200)

    def test_a_metric_of_the_models_curvature(self):
        self.start()
        words = ["metric", "start.meshb", "--curvature", 24, "--geometry", MODEL, "--quiet", "-o"]
        self.weft(*words, "one.solb")
        self.weft(*words[:4], "--quiet", "-o", "triangles.solb")
        self.assertNotEqual((self.folder / "one.solb").read_bytes(), (self.folder / "triangles.solb").read_bytes())
        done = self.on_ranks(2, *words, "two.solb", "--threads", 1)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual((self.folder / "one.solb").read_bytes(), (self.folder / "two.solb").read_bytes())

    def test_stat_tells_what_lies_on_no_face(self):
        self.weft("mesh", "cylinder", "--radius", 1, "--height", 3, "--size", 0.4, "-o", "long.meshb")
        told = self.weft("stat", "long.meshb", "--geometry", MODEL).stderr
        self.assertRegex(told, r"warning: \d+ triangles of reference 1 lie on no face of the model")
        self.start()
        self.assertNotIn("warning", self.weft("stat", "start.meshb", "--geometry", MODEL).stderr)

    def test_a_picture_of_the_deviation(self):
        self.start()
        self.weft("mesh", MODEL, "--size", 0.5, "--hausd", 0.002, "-o", "fine.meshb")
        for mesh, is_far in (("start.meshb", True), ("fine.meshb", False)):
            self.weft("view", mesh, "--geometry", MODEL, "--color-by", "deviation", "--range", "0,0.05", "--no-edges", "--from", "x",
                      "--size", "320x240", "-o", "fit.png")
            red, green, blue = Png(self.folder / "fit.png").at(0.4, 0.5)
            self.assertEqual(green > 1.5 * blue or green > 100, is_far, (mesh, red, green, blue))

    def test_records_that_need_a_model_are_told_when_they_are_left(self):
        self.start()
        for mode in ((), ("--subdomains", 2)):
            out = self.weft("adapt", "start.meshb", "--metric-fn", "uniform:0.3", *mode, "-o", "out.meshb", expect=(0, 1)).stdout
            self.assertRegex(out, r"warning: the input's \d+ records of vertices on a CAD model are not kept")
            told = self.weft("adapt", "start.meshb", "--geometry", MODEL, "--metric-fn", "uniform:0.3", *mode, "-o", "out.vtu",
                             expect=(0, 1)).stdout
            self.assertIn("out.vtu does not keep the input's", told)

    def test_records_follow_vertices_that_repair_renumbers(self):
        self.start()
        self.weft("convert", "start.meshb", "start.mesh")
        lines = (self.folder / "start.mesh").read_text().splitlines()
        at = lines.index("Vertices")
        count = int(lines[at + 1])
        moved, section = [], ""
        for i, line in enumerate(lines):  # a vertex of no tet before all others: every number grows by one
            words = line.split()
            if len(words) == 1 and not words[0].lstrip("-").isdigit():
                section = words[0]
            if i == at + 1:
                moved += [str(count + 1), "9 9 9 0"]
            elif section in ("Tetrahedra", "Triangles", "Edges") and len(words) > 2:
                moved.append(" ".join([*(str(int(v) + 1) for v in words[:-1]), words[-1]]))
            elif section.startswith("VerticesOnGeometric") and len(words) > 1:
                moved.append(" ".join([str(int(words[0]) + 1), *words[1:]]))
            elif section in ("Corners", "RequiredVertices") and len(words) == 1 and words[0].isdigit() and lines[i - 1] != section:
                moved.append(str(int(words[0]) + 1))
            else:
                moved.append(line)
        self.write("unused.mesh", "\n".join(moved) + "\n")
        words = ("--geometry", MODEL, "--metric-fn", "uniform:0.3", "--threads", 1)
        out = self.weft("adapt", "unused.mesh", *words, "--repair", "-o", "out.meshb", expect=(0, 1)).stdout
        self.assertIn("unused vertices removed", out)
        self.assertNotIn("do not fit", out)
        self.weft("adapt", "start.meshb", *words, "-o", "same.meshb", expect=(0, 1))
        self.assertEqual((self.folder / "out.meshb").read_bytes(), (self.folder / "same.meshb").read_bytes())

    def test_subdomains_stay_on_the_model_and_report_what_stat_finds(self):
        self.start()
        self.weft("adapt", "start.meshb", "--geometry", MODEL, "--metric-fn", "uniform:0.2", "--subdomains", 4, "-o",
                  "parts.meshb", "--report", "report", expect=(0, 1))
        found = self.assert_on_model("parts.meshb")
        told = json.loads((self.folder / "report" / "report.json").read_text())["model"]
        counts = ("vertices", "triangles", "unclassified_triangles", "off", "faces", "edges", "nodes")
        self.assertEqual([told[key] for key in counts], [found[key] for key in counts])
        self.assertEqual([(e["kind"], e["id"], e["vertices"]) for e in told["entities"]],
                         [(e["kind"], e["id"], e["vertices"]) for e in found["entities"]])
        self.assertAlmostEqual(told["deviation"], found["deviation"], delta=1e-9)
        self.assert_page_shows(told)

    def test_subdomains_record_where_vertices_lie(self):
        self.start()
        self.weft("adapt", "start.meshb", "--geometry", MODEL, "--metric-fn", "uniform:0.2", "--subdomains", 4, "-o",
                  "parts.meshb", expect=(0, 1))
        self.weft("convert", "parts.meshb", "parts.mesh")
        words = (self.folder / "parts.mesh").read_text().split()
        model = self.model("parts.meshb")
        for keyword, kind in (("VerticesOnGeometricVertices", "node"), ("VerticesOnGeometricEdges", "edge"),
                              ("VerticesOnGeometricTriangles", "face")):
            recorded = int(words[words.index(keyword) + 1])
            self.assertEqual(recorded, sum(e["vertices"] for e in model["entities"] if e["kind"] == kind), keyword)

    def test_a_carried_model_is_read_in_shares_and_stays_in_the_file(self):
        self.start()
        self.weft("convert", "start.meshb", "start.mesh")
        model = MODEL.read_bytes()
        padded = model + bytes(-len(model) % 4)
        words = [int.from_bytes(padded[i:i + 4], "little", signed=True) for i in range(0, len(padded), 4)]
        section = f"ByteFlow\n{1 + len(words)}\n" + "\n".join(map(str, [len(model), *words])) + "\nEnd\n"
        text = (self.folder / "start.mesh").read_text()
        self.write("carrier.mesh", text[:text.rindex("End")] + section)
        self.weft("convert", "carrier.mesh", "carrier.meshb")
        results = []
        for geometry, mesh, ranks in ((MODEL, "carrier.meshb", 1), ("carried", "carrier.meshb", 1),
                                      ("carried", "carrier.meshb", 3)):
            done = self.on_ranks(ranks, "adapt", mesh, "--geometry", geometry, "--metric-fn", "uniform:0.3", "--subdomains", 4,
                                 "--threads", 1, "-o", "out.meshb")
            self.assertIn(done.returncode, (0, 1), done.stderr)
            self.assertNotIn("has read the whole mesh", done.stdout + done.stderr)
            results.append((self.folder / "out.meshb").read_bytes())
        self.assertTrue(results[0] == results[1] == results[2])
        self.assertIn(model, results[0])
        self.weft("stat", "out.meshb", "--geometry", "carried")
        other = model.replace(b"\n", b"\n\n", 1)
        (self.folder / "other.egads").write_bytes(other)
        (self.folder / "other.brep").write_bytes(other)
        for file in ("other.egads", "other.brep"):
            for subdomains in ([], ["--subdomains", 4]):
                done = self.weft("adapt", "carrier.meshb", "--geometry", file, "--metric-fn", "uniform:0.3", *subdomains, "-o", "out.meshb",
                                 expect=(0, 1))
                result = (self.folder / "out.meshb").read_bytes()
                self.assertEqual(other in result, file == "other.egads", "its records are of it")
                self.assertNotIn(model, result)
                self.assertEqual("the model that the mesh carries is left out" in done.stdout + done.stderr, file == "other.brep")

    def test_ranks_give_the_same_bytes(self):
        self.start()
        words = ["adapt", "start.meshb", "--geometry", MODEL, "--curvature", 24, "--complexity", 800, "--subdomains", 4,
                 "--threads", 1, "--quiet", "-o", "out.meshb"]
        results = []
        for ranks in (1, 2, 3):
            done = self.on_ranks(ranks, *words)
            self.assertIn(done.returncode, (0, 1), done.stderr)
            results.append((self.folder / "out.meshb").read_bytes())
            (self.folder / "out.meshb").unlink()
        self.assertTrue(results[0] == results[1] == results[2])

    def test_a_model_that_one_rank_cannot_read_ends_all_and_names_the_rank(self):
        start = self.folder / self.start()
        shutil.copy(MODEL, self.folder / "model.brep")
        (self.folder / "elsewhere").mkdir()
        done = self.on_ranks(2, "adapt", start, "--geometry", "model.brep", "--metric-fn", "uniform:0.3", "--subdomains", 2,
                             "--quiet", "-o", self.folder / "x.meshb",
                             before='[ "${OMPI_COMM_WORLD_RANK:-$PMI_RANK}" = 0 ] || cd elsewhere; ')
        self.assertNotIn(done.returncode, (0, 1), done.stderr)
        self.assertIn("rank 1: model.brep", done.stderr)
        self.assertFalse((self.folder / "x.meshb").exists())

    def test_a_truncated_model_is_refused(self):
        self.start()
        whole = MODEL.read_bytes()
        (self.folder / "half.brep").write_bytes(whole[:len(whole) // 2])
        self.assert_fails("adapt", "start.meshb", "--geometry", "half.brep", "--metric-fn", "uniform:0.3", "-o", "x.meshb",
                          says="half.brep")

    def test_what_is_no_model_is_refused(self):
        for name, says in (("a.brep", "BREP"), ("a.iges", "IGES"), ("a.step", "STEP"), ("a.egads", "")):
            self.write(name, "no model\n" * 20)
            self.assert_fails("mesh", name, "-o", "out.meshb", says=(name, says))

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
