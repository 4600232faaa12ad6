"""`weft mesh`: from surfaces and of simple bodies, as a user meets it."""

import re
import signal
import subprocess
import unittest

from command import WEFT, CommandTest

CORNERS = [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
SQUARES = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]


def cube_obj(shift=0.0, squares=SQUARES, first=1):
    """Vertices and triangles of a unit cube moved along (1, 1, 1)."""
    lines = [f"v {x + shift} {y + shift} {z + shift}\n" for x, y, z in CORNERS]
    for a, b, c, d in squares:
        lines += [f"f {first + a} {first + b} {first + c}\n", f"f {first + a} {first + c} {first + d}\n"]
    return "".join(lines)


class Mesh(CommandTest):
    def verified(self, *words, says=()):
        done = self.weft("mesh", *words, "-o", "out.meshb", "--progress", "none")
        for word in says:
            self.assertIn(word, done.stdout)
        self.assertIn("conforms", self.weft("verify", "out.meshb").stdout)
        return done

    def test_surface_to_volume(self):
        self.write("cube.obj", cube_obj())
        self.verified("cube.obj", says=["12 triangles", "1 region", "dihedral"])
        self.verified("cube.obj", "--remesh-surface", "--size", "0.3")

    def test_box_by_one_number_or_three(self):
        for cells, tets in (([3], 162), ([1, 2, 3], 36)):
            self.assertIn(f"{tets} tets", self.weft("mesh", "box", "-o", "box.meshb", "--cells", *cells).stdout)

    def test_every_surface_format(self):
        self.write("cube.obj", cube_obj())
        for name in ("cube.stl", "cube.ply", "cube.meshb", "cube.msh"):
            self.weft("convert", "cube.obj", name)
            self.verified(name, says=["12 triangles"])

    def test_concave_polygons(self):
        corners = [(1, 1), (1, 2), (0, 2), (0, 0), (2, 0), (2, 1)]  # a fan around the second folds over
        order = [1, 2, 3, 4, 5, 0]
        points = [f"v {x} {y} {z}\n" for z in (0, 1) for x, y in corners]
        faces = ["f " + " ".join(str(1 + i) for i in reversed(order)) + "\n", "f " + " ".join(str(7 + i) for i in order) + "\n"]
        faces += [f"f {1 + i} {1 + (i + 1) % 6} {7 + (i + 1) % 6} {7 + i}\n" for i in range(6)]
        self.write("l.obj", "".join(points + faces))
        self.verified("l.obj", says=["20 triangles"])

    def test_ends_at_a_signal_before_there_is_a_mesh(self):
        self.weft("mesh", "ball", "--size", "0.05", "-o", "ball.meshb", "--quiet")
        self.weft("convert", "ball.meshb", "ball.stl")
        process = subprocess.Popen([str(WEFT), "mesh", "ball.stl", "-o", "out.meshb", "--progress", "plain"], cwd=self.folder,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(process.kill)
        process.stderr.readline()  # it has begun to look at the surface
        process.send_signal(signal.SIGTERM)
        _, errors = process.communicate(timeout=120)
        self.assertEqual(process.returncode, 2, errors)
        self.assertIn("interrupted before there was a mesh", errors)
        self.assertEqual(self.files(), ["ball.meshb", "ball.solb", "ball.stl"])

    def test_bodies(self):
        self.verified("ball", "--size", "0.4")
        self.verified("cylinder", "--size", "0.4", "--height", "1")
        self.verified("delta-wing")

    def test_what_stands_before_a_body_is_refused(self):
        self.write("part.obj", cube_obj())
        for words, says in ((["--size", 0.2, "ball"], ["--size", "belongs after `ball`"]), (["-o", "x.meshb", "box"], ["--out", "belongs after `box`"]),
                            (["--materials", "cylinder"], ["--materials", "belongs after `cylinder`"]), (["part.obj", "ball"], ["SURFACE", "`ball`"])):
            self.assert_fails("mesh", *words, "-o", "x.meshb", "--quiet", says=says, code=64)
        self.assertIn("--radius", self.weft("mesh", "--help", "ball").stdout + self.weft("mesh", "ball", "--help").stdout)

    def test_delta_wing_sizes(self):
        self.verified("delta-wing")
        coarse = (self.folder / "out.meshb").stat().st_size
        self.verified("delta-wing", "--size", "0.1", "--far-size", "2", "--growth", "1.5")
        self.assertGreater((self.folder / "out.meshb").stat().st_size, 2 * coarse)
        self.assert_fails("mesh", "delta-wing", "--size", "1e-9", "-o", "x.meshb", "--quiet", says="too small")

    def test_metric_beside(self):
        self.verified("ball", "--size", "0.3")
        measures = self.weft("stat", "out.meshb", "--metric", "out.solb").stdout
        self.assertGreater(float(re.search(r"unit +([0-9.]+) %", measures).group(1)), 80)

    def test_background(self):
        self.write("cube.obj", cube_obj())
        self.weft("mesh", "box", "-o", "bg.meshb", "--cells", "2", "2", "2", "--min", -1, -1, -1, "--max", 2, 2, 2)
        self.weft("metric", "bg.meshb", "--metric-fn", "uniform:0.25", "-o", "sizes.solb")
        self.verified("cube.obj", "--background", "bg.meshb", "--metric", "sizes.solb", "--remesh-surface")
        self.assert_fails("mesh", "cube.obj", "-o", "x.meshb", "--background", "bg.meshb", says="--metric", code=64)
        self.weft("mesh", "box", "-o", "bg.meshb", "--cells", 2, 4, 4, "--max", 0.5, 1, 1)
        self.weft("metric", "bg.meshb", "--metric-fn", "uniform:0.25", "-o", "sizes.solb")
        told = self.weft("mesh", "cube.obj", "--background", "bg.meshb", "--metric", "sizes.solb", "--remesh-surface", "-o", "half.meshb").stdout
        self.assertIn("lie outside the background, up to 0.5 from it", told)

    def test_refuses_open_surface(self):
        self.write("open.obj", cube_obj(squares=SQUARES[:-1]))
        self.assert_fails("mesh", "open.obj", "-o", "x.meshb", "--quiet", says=["open.obj", "triangle", "open", "4 such edges"])

    def test_refuses_self_intersection(self):
        self.write("two.obj", cube_obj() + cube_obj(0.4, first=9))
        self.assert_fails("mesh", "two.obj", "-o", "x.meshb", "--quiet", says=["two.obj", "intersects itself", "triangles"])

    def test_refuses_no_surface(self):
        self.write("empty.obj", "v 0 0 0\n")
        self.assert_fails("mesh", "empty.obj", "-o", "x.meshb", "--quiet", says="empty.obj")
        self.assert_fails("mesh", "missing.stl", "-o", "x.meshb", "--quiet", says="missing.stl")

    def test_same_bytes_with_one_thread(self):
        self.weft("mesh", "ball", "--size", "0.4", "--threads", 1, "-o", "a.meshb", "--quiet")
        self.weft("mesh", "ball", "--size", "0.4", "--threads", 1, "-o", "b.meshb", "--quiet")
        self.assertEqual((self.folder / "a.meshb").read_bytes(), (self.folder / "b.meshb").read_bytes())


if __name__ == "__main__":
    unittest.main()
