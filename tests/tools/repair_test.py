"""`--repair`: what is refused without it is mended with it, and every mend is told."""

import json
import math
import re
import unittest

from command import CommandTest, mesh_text, solution_text


def sections(text):
    """The numbers of an ASCII .mesh file by section, references included."""
    words = text.split()
    widths = {"Vertices": 4, "Tetrahedra": 5, "Triangles": 4, "Edges": 3}
    found = {name: [] for name in widths}
    for name, width in widths.items():
        if name not in words:
            continue
        at = words.index(name) + 1
        count = int(words[at])
        rows = [words[at + 1 + i * width:at + 1 + (i + 1) * width] for i in range(count)]
        kind = float if name == "Vertices" else int
        found[name] = [[kind(x) for x in row] for row in rows]
    return found


def text_of(mesh):
    text = "MeshVersionFormatted 2\nDimension 3\n"
    for name, rows in mesh.items():
        if rows:
            text += f"{name}\n{len(rows)}\n" + "".join(" ".join(
                repr(x) if name == "Vertices" and i < 3 else str(int(x)) for i, x in enumerate(row)) + "\n" for row in rows)
    return text + "End\n"


class Repair(CommandTest):
    def setUp(self):
        super().setUp()
        self.weft("mesh", "box", "-o", "good.mesh", "--cells", 2, 2, 2)
        self.mesh = sections((self.folder / "good.mesh").read_text())

    def vertex_at(self, *place):
        return next(i + 1 for i, v in enumerate(self.mesh["Vertices"]) if tuple(v[:3]) == place)

    def assert_mended(self, says, *options, refused=True):
        """Refused without --repair (unless it is let pass with a note), adapted and told with it, in all modes."""
        self.write("bad.mesh", text_of(self.mesh))
        words = ("adapt", "bad.mesh", *(options or ("--metric-fn", "uniform:0.4")), "-o", "out.meshb")
        if refused:
            self.assert_fails(*words, says="bad.mesh" if "m.sol" not in words else "m.sol")
        for mode in ((), ("--subdomains", 2)):
            out = self.weft(*words, "--repair", "--report", "r", *mode, "--threads", 1, expect=(0, 1)).stdout
            self.assertIn("repaired: ", out)
            self.assertIn(says, out)
            mends = json.loads((self.folder / "r/report.json").read_text())["mends"]
            self.assertIn(says, [mend["what"] for mend in mends])
            self.weft("verify", "out.meshb", "--against", "good.mesh")

    def test_vertices_at_the_same_place(self):
        centre = self.vertex_at(0.5, 0.5, 0.5)
        self.mesh["Vertices"].append([0.5, 0.5, 0.5, 0])
        tet = next(t for t in self.mesh["Tetrahedra"] if centre in t[:4])
        tet[tet.index(centre)] = len(self.mesh["Vertices"])
        self.assert_mended("vertices at the same place merged", refused=False)

    def test_vertices_nearly_at_the_same_place(self):
        """One tet has vertices of its own, off by some units of single precision: inside, at the boundary, all four."""
        for corner in ((0.5, 0.5, 0.5), (0.5, 0.5, 1), (1, 1, 1), None):
            self.setUp()
            tet = self.tet_with(self.vertex_at(*(corner or (0.5, 0.5, 0.5))))
            for vertex in [self.vertex_at(*corner)] if corner else tet[:4]:
                x, y, z = self.mesh["Vertices"][vertex - 1][:3]
                self.mesh["Vertices"].append([x + 1e-7, y - 1e-7, z, 0])
                tet[tet.index(vertex)] = len(self.mesh["Vertices"])
            self.assert_mended("vertices at the same place merged", refused=False)

    def test_all_tets_have_their_own_vertices(self):
        places = []
        for i, tet in enumerate(self.mesh["Tetrahedra"]):
            for k in range(4):
                places.append([x + (i % 5 - 2) * 1e-8 for x in self.mesh["Vertices"][tet[k] - 1][:3]] + [0])
                tet[k] = len(places)
        self.mesh.update(Vertices=places, Triangles=[], Edges=[])
        self.write("bad.mesh", text_of(self.mesh))
        out = self.weft("adapt", "bad.mesh", "--metric-fn", "uniform:0.4", "-o", "out.meshb", "--repair", expect=(0, 1)).stdout
        self.assertIn("repaired: 165 vertices at the same place merged", out)

    def test_a_gap_between_surfaces_stays(self):
        count = len(self.mesh["Vertices"])
        self.mesh["Vertices"] += [[x + 1 + 1e-9, y, z, ref] for x, y, z, ref in self.mesh["Vertices"]]
        for name in ("Tetrahedra", "Triangles", "Edges"):
            self.mesh[name] += [[v + count for v in row[:-1]] + row[-1:] for row in self.mesh[name]]
        self.write("gap.mesh", text_of(self.mesh))
        out = self.weft("adapt", "gap.mesh", "--metric-fn", "uniform:0.4", "-o", "out.meshb", "--repair", expect=(0, 1)).stdout
        self.assertNotIn("repaired", out)

    def point_on(self, *vertices, shares=None):
        """A new vertex between these."""
        shares = shares or [1 / len(vertices)] * len(vertices)
        places = [self.mesh["Vertices"][v - 1] for v in vertices]
        self.mesh["Vertices"].append([sum(s * p[c] for s, p in zip(shares, places)) for c in range(3)] + [0])
        return len(self.mesh["Vertices"])

    def split(self, name, row, corners, new):
        """One row alone becomes as many as there are corners that the new vertex replaces."""
        self.mesh[name].remove(row)
        self.mesh[name] += [[new if v == corner else v for v in row[:-1]] + row[-1:] for corner in corners]

    def tet_with(self, *vertices):
        return next(t for t in self.mesh["Tetrahedra"] if set(vertices) <= set(t[:4]))

    def test_vertices_on_edges_of_other_tets(self):
        """Of edges inside the box that one tet alone has divided."""
        centre = self.vertex_at(0.5, 0.5, 0.5)
        for end in ((1, 1, 1), (0.5, 0.5, 1), (0.5, 1, 1), (0, 0, 0)):
            edge = (centre, self.vertex_at(*end))
            self.split("Tetrahedra", self.tet_with(*edge), edge, self.point_on(*edge))
        self.assert_mended("hanging vertices joined", refused=False)
        self.assert_mended("pairs of tets swapped to fit what is beyond their faces", refused=False)

    def test_several_vertices_on_an_edge(self):
        edge = (self.vertex_at(0.5, 0.5, 0.5), self.vertex_at(1, 1, 1))
        new = self.point_on(*edge)
        self.split("Tetrahedra", self.tet_with(*edge), edge, new)
        for end in edge:
            self.split("Tetrahedra", self.tet_with(end, new), (end, new), self.point_on(end, new, shares=(0.3, 0.7)))
        self.assert_mended("hanging vertices joined", refused=False)

    def test_vertices_on_edges_of_the_boundary(self):
        for divided in (False, True):
            for edge in (((0, 0, 0), (0.5, 0, 0)), ((0, 0, 0), (0.5, 0, 0.5)), ((0.5, 0.5, 0), (1, 1, 0)), ((1, 0, 0), (1, 0, 0.5))):
                self.setUp()
                self.mesh["Triangles"] = [[*t[:3], t[3] + 10 * i] for i, t in enumerate(self.mesh["Triangles"])]
                self.write("good.mesh", text_of(self.mesh))
                ends = tuple(self.vertex_at(*end) for end in edge)
                new = self.point_on(*ends)
                tet = self.tet_with(*ends)
                self.split("Tetrahedra", tet, ends, new)
                for triangle in [t for t in self.mesh["Triangles"] if divided and set(ends) <= set(t[:3]) <= set(tet[:4])]:
                    self.split("Triangles", triangle, ends, new)
                self.assert_mended("hanging vertices joined", refused=False)

    def test_vertices_in_faces_of_other_tets(self):
        face = (self.vertex_at(0.5, 0.5, 0.5), self.vertex_at(1, 1, 1), self.vertex_at(0.5, 1, 1))
        both = [t for t in self.mesh["Tetrahedra"] if set(face) <= set(t[:4])]
        self.assertEqual(len(both), 2)
        new = self.point_on(*face)
        self.split("Tetrahedra", both[0], face, new)
        inner = (face[0], face[1], new)
        self.split("Tetrahedra", self.tet_with(*inner, *(v for v in both[0][:4] if v not in face)), inner, self.point_on(*inner))
        self.assert_mended("hanging vertices joined", refused=False)

    def test_unused_vertices(self):
        self.mesh["Vertices"].insert(0, [9, 9, 9, 0])
        for name in ("Tetrahedra", "Triangles", "Edges"):
            for row in self.mesh[name]:
                row[:-1] = [i + 1 for i in row[:-1]]
        self.assert_mended("unused vertices removed", refused=False)

    def test_an_unused_vertex_at_no_place(self):
        self.mesh["Vertices"].append([math.nan, 9, math.inf, 0])
        self.assert_mended("unused vertices removed")

    def test_a_vertex_at_no_place_that_tets_have_is_refused(self):
        self.mesh["Vertices"][self.vertex_at(0.5, 0.5, 0.5) - 1][1] = math.nan
        self.write("bad.mesh", text_of(self.mesh))
        self.assert_fails("adapt", "bad.mesh", "--metric-fn", "uniform:0.4", "-o", "out.meshb", "--repair",
                          says=["bad.mesh", "vertex", "not finite"])

    def test_tets_listed_the_wrong_way_round(self):
        tet = self.mesh["Tetrahedra"][5]
        tet[0], tet[1] = tet[1], tet[0]
        self.assert_mended("tets listed the wrong way round turned")

    def test_all_tets_listed_the_wrong_way_round(self):
        for tet in self.mesh["Tetrahedra"]:
            tet[0], tet[1] = tet[1], tet[0]
        self.assert_mended("tets listed the wrong way round turned")

    def test_inverted_tets(self):
        centre = self.mesh["Vertices"][self.vertex_at(0.5, 0.5, 0.5) - 1]
        centre[:3] = [1.2, 0.6, 0.5]
        self.assert_mended("vertices of inverted or flat tets moved")

    def test_inverted_tets_at_a_vertex_of_the_boundary(self):
        for place in ([0.3, 0.45, 0.5], [1.0, 1.3, 0.5]):
            with self.subTest(place=place):
                vertex = self.mesh["Vertices"][self.vertex_at(1.0, 0.5, 0.5) - 1]
                vertex[:3] = place
                self.assert_mended("vertices of the boundary at inverted or flat tets moved")
                vertex[:3] = [1.0, 0.5, 0.5]

    def test_inverted_tets_at_a_ridge(self):
        for place in ([0.3, 0.45, 0.5], [1.0, 1.0, 1.3], [0.8, 0.2, -0.4]):
            with self.subTest(place=place):
                vertex = self.mesh["Vertices"][self.vertex_at(1.0, 1.0, 0.5) - 1]
                vertex[:3] = place
                self.assert_mended("vertices of ridges, and beside them, at inverted or flat tets moved")
                vertex[:3] = [1.0, 1.0, 0.5]

    def test_inverted_tets_at_a_required_edge(self):
        v = self.vertex_at(1.0, 1.0, 0.5)
        self.mesh["Edges"] = [[self.vertex_at(1.0, 1.0, z), v, 1] for z in (0.0, 1.0)]
        self.mesh["Vertices"][v - 1][:3] = [0.3, 0.45, 0.5]
        self.write("bad.mesh", text_of(self.mesh).replace("End\n", "RequiredEdges\n1\n2\nEnd\n"))
        self.assert_fails("adapt", "bad.mesh", "--metric-fn", "uniform:0.4", "-o", "out.meshb", "--repair",
                          says=["bad.mesh", "is inverted, and moving its vertices does not help"])

    def test_inverted_tets_at_a_corner(self):
        self.mesh["Vertices"][self.vertex_at(1.0, 1.0, 1.0) - 1][:3] = [0.3, 0.35, 0.4]
        self.write("bad.mesh", text_of(self.mesh))
        self.assert_fails("adapt", "bad.mesh", "--metric-fn", "uniform:0.4", "-o", "out.meshb", "--repair",
                          says=["bad.mesh", "is inverted, and moving its vertices does not help"])

    def test_flat_tets_inside(self):
        centre = self.mesh["Vertices"][self.vertex_at(0.5, 0.5, 0.5) - 1]
        centre[:3] = [1.0, 0.6, 0.55]
        self.assert_mended("vertices of inverted or flat tets moved")

    def test_flat_tets_at_the_boundary(self):
        triangles = [t for t in self.mesh["Triangles"] if t[3] == 1]
        first = triangles[0]
        second = next(t for t in triangles if len(set(t[:3]) & set(first[:3])) == 2)
        apex = next(v for v in second[:3] if v not in first[:3])
        self.mesh["Tetrahedra"].append([*first[:3], apex, 0])
        self.mesh["Tetrahedra"][-1][4] = self.mesh["Tetrahedra"][0][4]
        self.assert_mended("flat tets at the boundary removed")

    def test_repeated_and_degenerate_tets(self):
        self.mesh["Tetrahedra"].append(list(self.mesh["Tetrahedra"][3]))
        self.assert_mended("repeated tets removed")
        self.mesh["Tetrahedra"][-1][0] = self.mesh["Tetrahedra"][-1][1]
        self.assert_mended("tets with a repeated vertex removed")

    def test_triangles(self):
        self.mesh["Triangles"].append([*self.mesh["Triangles"][0][:3], 77])
        self.assert_mended("repeated triangles with another reference removed", refused=False)
        self.mesh["Triangles"][-1] = [self.vertex_at(0, 0, 0), self.vertex_at(1, 0, 0), self.vertex_at(1, 1, 1), 3]
        self.assert_mended("triangles that are no faces of tets removed")
        del self.mesh["Triangles"][-2:]
        self.assert_mended("missing triangles made", refused=False)

    def test_metrics(self):
        count = len(self.mesh["Vertices"])
        rows = ["4 0 4 0 0 4"] * count
        rows[7] = "4 0 -4 0 0 4"
        rows[11] = "0 0 0 0 0 0"
        self.write("m.sol", f"MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n{count}\n1 3\n" + "\n".join(rows) + "\nEnd\n")
        self.assert_mended("metrics that are not finite or not positive definite replaced by their neighbours' mean",
                           "--metric", "m.sol")

    def test_the_field_that_is_read_as_the_metric_is_mended(self):
        count = len(self.mesh["Vertices"])
        rows = ["0.5 4 0 4 0 0 4"] * count
        rows[7] = "-1 4 0 4 0 0 4"
        self.write("m.sol", f"MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n{count}\n2 1 3\n" + "\n".join(rows) + "\nEnd\n")
        self.assert_mended("metrics that are not finite or not positive definite replaced by their neighbours' mean",
                           "--metric", "m.sol")

    def test_metrics_of_a_background(self):
        self.weft("mesh", "box", "-o", "back.mesh", "--cells", 3, 3, 3)
        metric = [(4, 0, 4, 0, 0, 4) for _ in range(64)]
        metric[9] = (-1, 0, 4, 0, 0, 4)
        self.write("m.sol", solution_text(metric))
        words = ("adapt", "good.mesh", "--background", "back.mesh", "--metric", "m.sol", "-o", "out.meshb")
        self.assert_fails(*words, says=["m.sol", "vertex 10"])
        for mode in ((), ("--subdomains", 2)):
            out = self.weft(*words, "--repair", *mode, "--threads", 1, expect=(0, 1)).stdout
            self.assertIn("replaced by their neighbours' mean (background's vertex 10", out)
            self.weft("verify", "out.meshb", "--against", "good.mesh")

    def test_a_solution_that_is_not_finite_is_named(self):
        self.write("s.sol", solution_text([("nan" if i == 7 else i,) for i in range(27)], kind=1))
        for more in ((), ("--repair",)):
            self.assert_fails("adapt", "good.mesh", "--sol", "s.sol", *more, "-o", "out.meshb", says=["s.sol", "vertex 8"])

    def test_what_cannot_be_mended_is_refused(self):
        """Two tets that both could be the one too many."""
        face = self.mesh["Tetrahedra"][0][:3]
        self.mesh["Tetrahedra"] += [[*face, 27, 1], [*face, 26, 1]]
        self.write("bad.mesh", text_of(self.mesh))
        self.assert_fails("adapt", "bad.mesh", "--metric-fn", "uniform:0.4", "-o", "out.meshb", "--repair",
                          says=["bad.mesh", "49 and 50: share the face ("])

    def test_inverted_tets_that_are_listed_as_if_they_were_not(self):
        """As written by a program that gives every tet a positive volume."""
        self.mesh["Vertices"][self.vertex_at(0.5, 0.5, 0.5) - 1][:3] = [1.2, 0.6, 0.5]
        for tet in self.mesh["Tetrahedra"]:
            a, b, c, d = (self.mesh["Vertices"][v - 1][:3] for v in tet[:4])
            u, v, w = ([x - y for x, y in zip(p, a)] for p in (b, c, d))
            if u[0] * (v[1] * w[2] - v[2] * w[1]) - u[1] * (v[0] * w[2] - v[2] * w[0]) + u[2] * (v[0] * w[1] - v[1] * w[0]) < 0:
                tet[0], tet[1] = tet[1], tet[0]
        self.assert_mended("vertices of inverted or flat tets moved")

    def test_an_unused_vertex_far_away(self):
        self.mesh["Vertices"].append([1e14, 0, 0, 0])
        self.assert_mended("unused vertices removed", refused=False)

    def test_a_tet_that_overlaps_others(self):
        for apex in (27, 26):
            self.mesh["Tetrahedra"].append([*self.mesh["Tetrahedra"][0][:3], apex, 1])
            self.assert_mended("overlapping tets removed")
            self.mesh["Tetrahedra"].pop()

    def test_repeated_tets(self):
        for ref, says in ((self.mesh["Tetrahedra"][3][4], "repeated tets removed"), (77, "repeated tets with another reference removed")):
            self.mesh["Tetrahedra"].append([*self.mesh["Tetrahedra"][3][:4], ref])
            self.assert_mended(says)
            self.mesh["Tetrahedra"].pop()


class Surfaces(CommandTest):
    def setUp(self):
        super().setUp()
        self.weft("mesh", "ball", "-o", "ball.mesh", "--size", 0.4)
        mesh = sections((self.folder / "ball.mesh").read_text())
        used = sorted({v for t in mesh["Triangles"] for v in t[:3]})
        number = {v: i + 1 for i, v in enumerate(used)}
        self.points = [tuple(mesh["Vertices"][v - 1][:3]) for v in used]
        self.triangles = [tuple(number[v] for v in t[:3]) for t in mesh["Triangles"]]

    def assert_filled(self, says, refused=True):
        self.write("bad.mesh", mesh_text(self.points, [], self.triangles))
        words = ("mesh", "bad.mesh", "-o", "out.meshb")
        if refused:
            self.weft(*words, "--quiet", expect=2)
        out = self.weft(*words, "--repair").stdout
        self.assertIn("repaired: ", out)
        self.assertIn(says, out)
        self.weft("verify", "out.meshb")

    def test_a_seam(self):
        """One triangle has vertices of its own, a little off."""
        corners = self.triangles[3]
        for v in corners:
            x, y, z = self.points[v - 1]
            self.points.append((x * 1.0003, y * 1.0003, z * 1.0003))
        n = len(self.points)
        self.triangles[3] = (n - 2, n - 1, n)
        self.assert_filled("vertices joined across seams")

    def test_a_triangle_that_has_a_vertex_twice(self):
        a, b, _ = self.triangles[7]
        self.triangles.append((a, b, b))
        self.assert_filled("triangles without area removed", refused=False)
        out = self.weft("mesh", "bad.mesh", "-o", "out.meshb").stdout
        self.assertIn("1 triangles without area dropped", out)

    def test_a_hole(self):
        vertex = self.triangles[0][0]
        self.triangles = [t for t in self.triangles if vertex not in t]
        del self.triangles[5]
        self.write("bad.mesh", mesh_text(self.points, [], self.triangles))
        self.weft("mesh", "bad.mesh", "-o", "out.meshb", "--quiet", expect=2)

    def test_a_small_hole(self):
        self.weft("mesh", "ball", "-o", "fine.mesh", "--size", 0.1)
        mesh = sections((self.folder / "fine.mesh").read_text())
        self.points = [tuple(v[:3]) for v in mesh["Vertices"]]
        self.triangles = [tuple(t[:3]) for t in mesh["Triangles"]][1:]
        self.assert_filled("holes filled")

    def test_a_loose_triangle(self):
        """Small, outside or inside: it is no volume, and no void."""
        n = len(self.points)
        for z in (2, 0.2):
            points = self.points + [(0.1, 0.1, z), (0.11, 0.1, z), (0.1, 0.11, z)]
            self.write("bad.mesh", mesh_text(points, [], [*self.triangles, (n + 1, n + 3, n + 2)]))
            self.weft("mesh", "bad.mesh", "-o", "out.meshb", "--quiet", expect=2)
            out = self.weft("mesh", "bad.mesh", "-o", "out.meshb", "--repair").stdout
            self.assertIn(f"{len(self.triangles)} triangles, 1 region", out)
            self.assertNotIn("holes filled", out)

    def test_a_junction(self):
        """An edge is split on one side only."""
        a, b, c = self.triangles[0]
        mid = tuple(0.5 * (p + q) for p, q in zip(self.points[a - 1], self.points[b - 1]))
        self.points.append(mid)
        n = len(self.points)
        self.triangles[0:1] = [(a, n, c), (n, b, c)]
        self.assert_filled("triangles split at vertices beside their free edges")

    def test_bodies_that_cross(self):
        """Two balls: what is within both goes, and the report names the mends."""
        n = len(self.points)
        self.points += [(x + 0.7, y + 0.2, z + 0.1) for x, y, z in self.points]
        self.triangles += [(b + n, a + n, c + n) for a, b, c in self.triangles]
        self.assert_filled("triangles that crossed others cut along the crossing")
        out = self.weft("mesh", "bad.mesh", "-o", "out.meshb", "--repair").stdout
        for says in ("vertices made where triangles crossed", "triangles inside the volume removed",
                     "triangles turned to agree with those beside them", "1 region"):
            self.assertIn(says, out)

    def test_an_opening(self):
        """A cap is missing: it gets a lid. Half a ball is an open sheet, and says so."""
        self.triangles = [t for t in self.triangles if min(self.points[v - 1][2] for v in t) < 0.6]
        self.assert_filled("triangles made across openings")
        self.triangles = [t for t in self.triangles if min(self.points[v - 1][2] for v in t) < 0]
        self.write("bad.mesh", mesh_text(self.points, [], self.triangles))
        self.assert_fails("mesh", "bad.mesh", "-o", "out.meshb", "--repair", "--quiet", says="closing its openings would take")

    def test_required_triangles_behind_what_is_removed(self):
        self.triangles.append(self.triangles[0])
        text = mesh_text(self.points, [], self.triangles)
        n = len(self.triangles)
        self.write("bad.mesh", text.replace("End\n", f"RequiredTriangles\n2\n{n - 1}\n{n}\nEnd\n"))
        self.weft("mesh", "bad.mesh", "-o", "out.mesh", "--repair")
        required = (self.folder / "out.mesh").read_text().split("RequiredTriangles")[1].split()
        self.assertEqual(required[0], "2")

    def test_what_is_left_is_named_by_the_input(self):
        """Half a ball, which stays open, behind two triangles that are repeated."""
        half = [t for t in self.triangles if min(self.points[v - 1][2] for v in t) < 0]
        self.triangles = [half[0], half[0], *half]
        self.write("bad.mesh", mesh_text(self.points, [], self.triangles))
        error = self.weft("mesh", "bad.mesh", "-o", "out.meshb", "--repair", "--quiet", expect=2).stderr
        triangle, a, b = map(int, re.search(r"triangle (\d+): .* has its edge \((\d+), (\d+)\)", error).groups())
        self.assertTrue({a, b} <= set(self.triangles[triangle - 1]), error)

    def test_doubled_and_turned(self):
        self.triangles += [(a, c, b) for a, b, c in self.triangles[::2]]
        self.assert_filled("repeated triangles removed", refused=False)


if __name__ == "__main__":
    unittest.main()
