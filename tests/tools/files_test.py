"""The subcommands around adapt: stat, verify, metric, mesh box, convert."""

import json
import math
import unittest

from command import DATA, ONE_TET, ONE_TET_FACES, ONE_TET_POINTS, CommandTest, mesh_text, solution_text


class MeshBox(CommandTest):
    def test_conforms(self):
        self.weft("mesh", "box", "-o", "b.meshb", "--cells", 2, 3, 4, "--min", -1, -1, -1, "--max", 1, 1, "1e3")
        self.weft("verify", "b.meshb")
        stat = json.loads(self.weft("stat", "b.meshb", "--json").stdout)
        self.assertEqual(stat["tets"], 6 * 2 * 3 * 4)
        self.assertEqual(stat["bounding_box"], [[-1, -1, -1], [1, 1, 1000]])
        self.assertEqual(sorted(stat["area_by_ref"]), list("123456"))
        self.assertIn("least dihedral angle", self.weft("stat", "b.meshb").stdout)
        self.assertAlmostEqual(stat["volume_by_ref"]["1"], 4004, places=8)


class Verify(CommandTest):
    def test_the_delta_wing_conforms(self):
        self.assertIn("conforms", self.weft("verify", DATA / "delta-wing-coarse.meshb").stdout)

    def test_a_missing_triangle_is_a_problem(self):
        self.write("a.mesh", mesh_text(ONE_TET_POINTS, [(1, 2, 3, 4)], ONE_TET_FACES[:3]))
        self.assertIn("PROBLEM", self.weft("verify", "a.mesh", expect=1).stdout)

    def test_an_inverted_tet_is_a_problem(self):
        self.write("a.mesh", mesh_text(ONE_TET_POINTS, [(2, 1, 3, 4)], ONE_TET_FACES))
        self.assertIn("PROBLEM", self.weft("verify", "a.mesh", expect=1).stdout)

    def test_unreadable(self):
        self.assert_fails("verify", "no.meshb", says="no.meshb")

    def test_against_another_mesh(self):
        self.box(2, "coarse.meshb")
        self.box(3, "fine.meshb")
        self.weft("verify", "fine.meshb", "--against", "coarse.meshb")
        self.weft("mesh", "box", "-o", "longer.meshb", "--max", 1, 1, "1.00000001")
        done = self.weft("verify", "longer.meshb", "--against", "coarse.meshb", expect=1)
        self.assertIn("volume of reference 1", done.stdout)
        self.assertIn("area of reference 1", done.stdout)
        self.assertNotIn("area of reference 6", done.stdout.split("against")[1])

    def test_a_body_that_has_come_to_touch_itself(self):
        """Two tets apart, and hanging together by an edge: the same volumes and areas."""
        apart = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 0, 1)]
        apart += [(x - 5, y, z) for x, y, z in ((0, 0, 0), (-1, 0, 0), (-1, -1, 0), (0, 0, 1))]
        together = apart[:4] + [(x + 5, y, z) for x, y, z in apart[5:7]]
        faces = [(2, 3, 4), (1, 4, 3), (1, 2, 4), (1, 3, 2)]
        for name, points, second in (("apart", apart, {1: 5, 2: 6, 3: 7, 4: 8}), ("together", together, {1: 1, 2: 5, 3: 6, 4: 4})):
            tets = [(1, 2, 3, 4), tuple(second[v] for v in (1, 2, 3, 4))]
            self.write(f"{name}.mesh", mesh_text(points, tets, faces + [tuple(second[v] for v in face) for face in faces]))
            self.weft("verify", f"{name}.mesh", "--against", f"{name}.mesh")
        done = self.weft("verify", "together.mesh", "--against", "apart.mesh", expect=1)
        self.assertIn("the body touches itself at 1 edges, the other mesh's at 0", done.stdout)


class Stat(CommandTest):
    def test_measures_in_a_uniform_metric(self):
        self.box(4)
        stat = json.loads(self.weft("stat", "box.meshb", "--metric-fn", "uniform:0.25", "--json").stdout)
        self.assertEqual(stat["schema"], "weft-stat-1")
        measures = stat["measures"]
        self.assertAlmostEqual(measures["complexity"], 64, places=9)
        self.assertAlmostEqual(measures["edge_length"]["min"], 1, places=12)
        self.assertAlmostEqual(measures["edge_length"]["max"], math.sqrt(3), places=12)

    def test_histograms(self):
        self.box()
        text = self.weft("stat", "box.meshb", "--metric-fn", "uniform:1", "--histogram").stdout
        self.assertIn("#", text)
        self.assertLessEqual(max(map(len, text.splitlines())), 100)
        self.assert_fails("stat", "box.meshb", "--histogram", says="--metric", code=64)


class Metric(CommandTest):
    def complexity(self, mesh, metric):
        stat = json.loads(self.weft("stat", mesh, "--metric", metric, "--json").stdout)
        return stat["measures"]["complexity"]

    def test_scaled_to_a_complexity(self):
        self.box(6)
        self.weft("metric", "box.meshb", "--metric-fn", "polar-2", "--complexity", 5000, "-o", "m.solb")
        self.assertAlmostEqual(self.complexity("box.meshb", "m.solb") / 5000, 1, places=6)

    def test_scaled_within_limits(self):
        self.box(6)
        self.weft("metric", "box.meshb", "--metric-fn", "polar-2", "--complexity", 5000, "--hmin", 0.02, "-o", "m.sol")
        self.assertAlmostEqual(self.complexity("box.meshb", "m.sol") / 5000, 1, places=2)
        text = self.weft("metric", "box.meshb", "--metric-fn", "polar-2", "--complexity", 5000, "--hmin", 0.5, "-o",
                         "m.sol").stdout
        self.assertIn("warning", text)

    def test_gradation_lowers_sizes(self):
        self.box(6)
        self.weft("metric", "box.meshb", "--metric-fn", "polar-1", "-o", "as-is.solb")
        self.weft("metric", "box.meshb", "-met", "as-is.solb", "-hgrad", 1.2, "-out", "graded.solb")
        self.assertGreater(self.complexity("box.meshb", "graded.solb"), self.complexity("box.meshb", "as-is.solb"))

    def test_sizes_become_a_metric(self):
        self.write("a.mesh", ONE_TET)
        self.write("h.sol", solution_text([(0.5,)] * 4, kind=1))
        self.weft("metric", "a.mesh", "--metric", "h.sol", "-o", "m.sol")
        self.assertAlmostEqual(self.complexity("a.mesh", "m.sol"), 8 / 6, places=12)


class Convert(CommandTest):
    def test_there_and_back(self):
        self.box()
        self.weft("convert", "box.meshb", "box.mesh")
        self.weft("convert", "box.mesh", "again.meshb")
        self.assertEqual((self.folder / "again.meshb").read_bytes(), (self.folder / "box.meshb").read_bytes())

    def test_vtu_says_what_it_drops(self):
        self.box()
        self.weft("metric", "box.meshb", "--metric-fn", "linear", "-o", "m.solb")
        text = self.weft("convert", "box.meshb", "box.vtu", "--sol", "m.solb").stdout
        self.assertIn("dropped ridges (among the edges): 24\n", text)
        self.assertIn(b"UnstructuredGrid", (self.folder / "box.vtu").read_bytes()[:400])
        self.assertEqual(self.files(), ["box.meshb", "box.vtu", "m.solb"])

    def test_fields_go_beside_a_mesh(self):
        self.box()
        self.weft("metric", "box.meshb", "--metric-fn", "linear", "-o", "m.solb")
        self.weft("convert", "box.meshb", "a.mesh", "--sol", "m.solb")
        self.assertEqual(self.files(), ["a.mesh", "a.sol", "box.meshb", "m.solb"])

    def test_fields_of_another_mesh(self):
        self.box()
        self.weft("metric", self.box(3, "other.meshb"), "--metric-fn", "linear", "-o", "m.solb")
        self.assert_fails("convert", "box.meshb", "a.vtu", "--sol", "m.solb", says=["m.solb", "another mesh"])

    def test_unknown_format(self):
        self.box()
        self.assert_fails("convert", "box.meshb", "box.xyz", says="box.xyz", code=64)
        self.assert_fails("convert", "box.xyz", "box.meshb", says=["box.xyz", "unexpected extension"])

    def test_options_that_the_format_has_no_use_for(self):
        self.box()
        for name, option, *value in (("a.meshb", "--compress"), ("a.vtu", "--pieces", 3), ("a.vtu", "--msh-version", "2.2"),
                                     ("a.su2", "--encoding", "ascii"), ("a.cgns", "--encoding", "binary")):
            self.assert_fails("convert", "box.meshb", name, option, *value, says=[f"{option}: is for .", f"not for '{name}'"], code=64)
        self.assert_fails("convert", "box.meshb", "a.vtu", "--encoding", "big-endian", says="--encoding: big-endian is for .ply", code=64)
        self.assert_fails("convert", "box.meshb", "a.vtu", "--encoding", "ascii", "--compress", says="--compress", code=64)

    def test_words_of_counts_and_formats(self):
        self.write("one.mesh", ONE_TET)
        self.assertIn("4 vertices, 1 tet, 4 triangles\n", self.weft("convert", "one.mesh", "one.meshb").stdout)
        self.assert_fails("convert", "one.mesh", "one.xyz", says=["must end in .meshb, .mesh, ", ", .off or .ply"], code=64)

    def test_gmsh_there_and_back(self):
        self.box()
        self.weft("metric", "box.meshb", "--metric-fn", "uniform:0.3", "-o", "box.solb")
        for words in ((), ("--encoding", "ascii"), ("--msh-version", "2.2"), ("--msh-version", "2.2", "--encoding", "ascii")):
            self.weft("convert", "box.meshb", "a.msh", "--sol", "box.solb", *words)
            self.weft("convert", "a.msh", "back.meshb")
            self.weft("verify", "back.meshb", "--against", "box.meshb")
            self.assertEqual((self.folder / "back.solb").read_bytes(), (self.folder / "box.solb").read_bytes())
        self.weft("adapt", "a.msh", "--metric", "a.msh", "-o", "fine.msh", expect=(0, 1))
        self.weft("verify", "fine.msh", "--against", "box.meshb")

    def test_ugrid_and_su2_there_and_back(self):
        self.box()
        for name in ("a.lb8.ugrid", "a.b8.ugrid", "a.ugrid", "a.su2"):
            self.assertIn("dropped corners: 8\n", self.weft("convert", "box.meshb", name).stdout)
            self.weft("convert", name, "back.meshb")
            self.weft("verify", "back.meshb")
        self.weft("metric", "a.b8.ugrid", "--metric-fn", "uniform:0.3", "-o", "a.solb")
        self.weft("adapt", "a.b8.ugrid", "--metric", "a.solb", "-o", "b.lb8.ugrid", expect=(0, 1))
        self.weft("verify", "b.lb8.ugrid", "--against", "a.b8.ugrid")
        self.assertIn("b.lb8.solb", self.files())

    def test_the_mapbc_goes_along_from_ugrid_to_ugrid(self):
        self.box()
        self.weft("convert", "box.meshb", "a.b8.ugrid")
        self.assertNotIn("a.mapbc", self.files())
        self.write("a.mapbc", "2\n1 5000 inflow\n4 3000 the wall\n")
        lost = ("dropped boundary conditions of a.mapbc: 2\n", "dropped names of references: 2\n")
        for name in ("b.lb8.ugrid", "b.ugrid"):
            text = self.weft("convert", "a.b8.ugrid", name).stdout
            self.assertEqual((self.folder / "b.mapbc").read_bytes(), (self.folder / "a.mapbc").read_bytes())
            for line in lost:
                self.assertNotIn(line, text)
        self.write("b.mapbc", "1\n1 4000 skin\n")
        text = self.weft("convert", "a.b8.ugrid", "b.lb8.ugrid").stdout
        self.assertEqual((self.folder / "b.mapbc").read_text(), "1\n1 4000 skin\n", "another one stays")
        for line in lost:
            self.assertIn(line, text)

    def test_names_survive_an_adaptation(self):
        self.weft("convert", DATA / "formats/gmsh-box-41.msh", "box.su2")
        self.weft("adapt", "box.su2", "--metric-fn", "uniform:0.4", "-o", "fine.su2", expect=(0, 1))
        text = (self.folder / "fine.su2").read_text()
        for name in ("bottom", "other_sides"):
            self.assertIn(f"MARKER_TAG= {name}\n", text)
        self.weft("verify", "fine.su2", "--against", "box.su2")

    def test_binary_ugrid_under_the_name_of_text(self):
        """As cgns_to_aflr3 of the CGNS tools writes it."""
        self.box(1)
        self.weft("convert", "box.meshb", "a.b8.ugrid")
        (self.folder / "a.b8.ugrid").rename(self.folder / "b.ugrid")
        self.assert_fails("stat", "b.ugrid", says=["b.ugrid", "is binary: call it .b8.ugrid"])

    def test_other_volume_elements_are_dropped_by_convert_only(self):
        self.write("a.ugrid", "4 0 0 1 1 0 0\n0 0 0 1 0 0 0 1 0 0 0 1\n1 2 3 4\n1 2 3 4 4\n")
        self.assertIn("dropped pyramids: 1\n", self.weft("convert", "a.ugrid", "a.meshb").stdout)
        self.assert_fails("stat", "a.ugrid", says=["a.ugrid", "1 volume elements other than linear tetrahedra"])

    def test_vtu_there_and_back(self):
        self.box()
        self.weft("metric", "box.meshb", "--metric-fn", "uniform:0.3", "-o", "box.solb")
        for name, *words in (("a.vtu",), ("b.vtu", "--compress"), ("c.vtu", "--encoding", "ascii"), ("d.pvtu", "--pieces", 3)):
            self.weft("convert", "box.meshb", name, "--sol", "box.solb", *words)
            self.weft("convert", name, "back.meshb")
            self.weft("verify", "back.meshb", "--against", "box.meshb")
            self.assertEqual((self.folder / "back.solb").read_bytes(), (self.folder / "box.solb").read_bytes())
        self.assertIn("d_2.vtu", self.files())
        self.weft("adapt", "d.pvtu", "--metric", "d.pvtu", "-o", "e.pvtu", expect=(0, 1))
        self.assertIn("e_1.vtu", self.files())

    def test_nothing_beside_a_pvtu_is_replaced(self):
        self.box()
        beside = ("fine.solb", "fine-fields.solb")
        for name in beside:
            self.weft("metric", "box.meshb", "--metric-fn", "uniform:0.3", "-o", name)
        before = [(self.folder / name).read_bytes() for name in beside]
        told = self.weft("adapt", "box.meshb", "--metric", beside[0], "--field", beside[1], "-o", "fine.pvtu", expect=(0, 1)).stdout
        self.assertEqual([(self.folder / name).read_bytes() for name in beside], before)
        self.assertIn("fields  fine.pvtu", told)
        self.weft("stat", "fine.pvtu", "--metric", "fine.pvtu")

    def test_cgns_there_and_back(self):
        self.box()
        self.weft("metric", "box.meshb", "--metric-fn", "uniform:0.3", "-o", "box.solb")
        self.weft("convert", "box.meshb", "a.cgns", "--sol", "box.solb")
        self.weft("convert", "a.cgns", "back.meshb")
        self.weft("verify", "back.meshb", "--against", "box.meshb")
        self.assertEqual((self.folder / "back.solb").read_bytes(), (self.folder / "box.solb").read_bytes())

    def test_surfaces_there_and_back(self):
        self.box()
        for name in ("a.stl", "a.obj", "a.off", "a.ply"):
            text = self.weft("convert", "box.meshb", name).stdout
            self.assertIn("48 tets", text)
            self.assertIn("dropped tets: 48\n", text)
            self.assertIn("0 tets, 48 triangles", self.weft("convert", name, "back.meshb").stdout)
        self.weft("convert", "box.meshb", "b.stl", "--encoding", "ascii")
        self.assertTrue((self.folder / "b.stl").read_text().startswith("solid"))
        self.weft("convert", "box.meshb", "b.ply", "--encoding", "big-endian")
        self.assertIn(b"binary_big_endian", (self.folder / "b.ply").read_bytes()[:60])

    def test_surfaces_are_not_adapted(self):
        self.box()
        self.weft("convert", "box.meshb", "a.stl")
        self.assert_fails("adapt", "a.stl", "--metric-fn", "uniform:1", "-o", "b.meshb", says=["a.stl", "no tetra"])


if __name__ == "__main__":
    unittest.main()
