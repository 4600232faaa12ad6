"""`weft view` and `weft stat --plot`: pictures, looked at pixel by pixel."""

import collections
import struct
import unittest
import zlib

from command import ONE_TET, CommandTest, solution_text
from mesh_test import CORNERS, SQUARES, cube_obj

WHITE = (255, 255, 255)
BLUE, ORANGE = (0x56, 0xB4, 0xE9), (0xE6, 0x9F, 0x00)  # the first two colours of things without an order
SURFACE, INSIDE = (0xB9, 0xCD, 0xE0), (0xF2, 0xDE, 0xB0)
CONFORMING, RED = (0xDD, 0xE1, 0xE6), (0xD7, 0x19, 0x1C)


def unfiltered(kind, line, above, step):
    """A row of a PNG without its filter (PNG specification, section 9)."""
    if kind == 0:
        return bytearray(line)
    if kind == 2:
        return bytearray((x + up) & 255 for x, up in zip(line, above))
    row = bytearray(line)
    for i, x in enumerate(line):
        left, up = row[i - step] if i >= step else 0, above[i]
        corner = above[i - step] if i >= step else 0
        estimate = left + up - corner
        paeth = min((left, up, corner), key=lambda value: abs(estimate - value))
        row[i] = (x + (0, left, up, (left + up) // 2, paeth)[kind]) & 255
    return row


class Png:
    """The pixels of an 8-bit RGB picture."""

    def __init__(self, path):
        data = path.read_bytes()
        assert data[:8] == b"\x89PNG\r\n\x1a\n"
        at, compressed = 8, b""
        while at < len(data):
            size, name = struct.unpack(">I4s", data[at:at + 8])
            body = data[at + 8:at + 8 + size]
            if name == b"IHDR":
                self.width, self.height, depth, kind = struct.unpack(">IIBB", body[:10])
                assert (depth, kind) == (8, 2), (depth, kind)
            compressed += body if name == b"IDAT" else b""
            at += size + 12
        raw, stride, above = zlib.decompress(compressed), 3 * self.width, bytes(3 * self.width)
        self.rows = []
        for begin in range(0, len(raw), stride + 1):
            above = unfiltered(raw[begin], raw[begin + 1:begin + 1 + stride], above, 3)
            self.rows.append(above)

    def at(self, x, y):
        """The pixel at these shares of width and height."""
        column = min(int(x * self.width), self.width - 1)
        return tuple(self.rows[min(int(y * self.height), self.height - 1)][3 * column:3 * column + 3])

    def pixels(self):
        return (tuple(row[i:i + 3]) for row in self.rows for i in range(0, len(row), 3))

    def count(self, colour):
        """How many pixels have the colour, lit more or less."""
        return sum(n for pixel, n in collections.Counter(self.pixels()).items() if like(pixel, colour))


def like(pixel, colour, tolerance=4):
    light = max(pixel) / max(colour)
    return 0.65 < light < 1.02 and all(abs(p - light * c) <= tolerance for p, c in zip(pixel, colour))


class View(CommandTest):
    def view(self, *words, size="160x120"):
        """The picture without edges, legend and axes, unless `words` is all there should be."""
        self.weft("view", *words, "-o", "out.png", "--size", size, "--no-edges", "--no-legend", "--no-axes")
        return Png(self.folder / "out.png")

    def assert_like(self, pixel, colour):
        self.assertTrue(like(pixel, colour), f"{pixel} is not like {colour}")

    def two_materials(self):
        """A cube within a cube; references of tets 1 and 2."""
        far = [(3 * x - 1, 3 * y - 1, 3 * z - 1) for x, y, z in CORNERS]
        text = "".join(f"v {x} {y} {z}\n" for x, y, z in far)
        for a, b, c, d in SQUARES:
            text += f"f {a + 1} {b + 1} {c + 1}\nf {a + 1} {c + 1} {d + 1}\n"
        self.write("two.obj", text + cube_obj(first=9))
        self.weft("mesh", "two.obj", "--materials", "-o", "two.meshb", "--quiet")
        return "two.meshb"

    def test_a_box_in_the_middle_of_nothing(self):
        picture = self.view(self.box(), "--from", "-y")
        self.assertEqual((picture.width, picture.height), (160, 120))
        for place in [(0, 0), (1, 0), (0, 1), (1, 1), (0.05, 0.5), (0.95, 0.5)]:
            self.assertEqual(picture.at(*place), WHITE)
        self.assert_like(picture.at(0.5, 0.5), SURFACE)
        self.assertAlmostEqual(picture.count(SURFACE), (0.94 * 120) ** 2, delta=300)

    def test_a_ball_is_round(self):
        self.weft("mesh", "ball", "--size", "0.2", "-o", "ball.meshb", "--quiet")
        for view in ("iso", "z", "40,20"):
            area = self.view("ball.meshb", "--from", view).count(SURFACE)
            self.assertAlmostEqual(area, 3.1416 * (0.47 * 120) ** 2, delta=450)

    def test_edges_axes_legend_and_title_add_ink(self):
        self.box()
        bare = self.view("box.meshb", "--from", "-y")

        def dark(*words):
            self.weft("view", "box.meshb", "--from", "-y", "-o", "a.png", "--size", "320x240", *words)
            return sum(max(pixel) < 120 for pixel in Png(self.folder / "a.png").pixels())

        self.assertEqual(sum(max(pixel) < 120 for pixel in bare.pixels()), 0)
        self.assertGreater(dark("--no-axes"), 100)  # edges
        self.assertGreater(dark("--no-edges"), 10)  # axes
        self.assertGreater(dark("--no-edges", "--no-axes", "--title", "A box"), 10)
        self.assertGreater(dark("--no-edges", "--no-axes", "--color-by", "ref"), 10)

    def test_the_clipped_half_is_empty(self):
        self.box(4)
        for more in ([], ["--slice"]):
            left = self.view("box.meshb", "--from", "-y", "--clip", "x=0.5", *more)
            self.assert_like(left.at(0.4, 0.5), SURFACE)
            self.assertEqual(left.at(0.6, 0.5), WHITE)
            right = self.view("box.meshb", "--from", "-y", "--clip", "x=0.5", "--flip", *more)
            self.assertEqual(right.at(0.4, 0.5), WHITE)
            self.assert_like(right.at(0.6, 0.5), SURFACE)

    def test_a_cut_shows_the_inside_to_the_eye(self):
        self.box(4)
        for view, plane in [("-y", "y=0.3"), ("y", "y=0.3"), ("z", "z=0.51"), ("x", "0.4,0,0,1,0,0")]:
            for more in ([], ["--slice"]):
                picture = self.view("box.meshb", "--from", view, "--clip", plane, *more)
                with self.subTest(view=view, plane=plane, more=more):
                    self.assert_like(picture.at(0.5, 0.5), INSIDE)
        whole = self.view("box.meshb", "--from", "-y", "--clip", "0,0.3,0,0,1,0")  # the far side goes
        self.assert_like(whole.at(0.5, 0.5), SURFACE)

    def test_two_materials_two_colours(self):
        mesh = self.two_materials()
        outside = self.view(mesh, "--color-by", "subdomain", "--from", "-y")
        self.assertEqual(min(outside.count(BLUE), outside.count(ORANGE)), 0)
        section = self.view(mesh, "--color-by", "subdomain", "--from", "-y", "--clip", "y=0.5", "--slice")
        counts = sorted([section.count(BLUE), section.count(ORANGE)])
        self.assertAlmostEqual(counts[0] / sum(counts), 1 / 9, delta=0.02)
        whole_tets = self.view(mesh, "--color-by", "subdomain", "--from", "-y", "--clip", "y=0.5")
        self.assertGreater(min(whole_tets.count(BLUE), whole_tets.count(ORANGE)), 200)

    def test_pieces_are_subdomains(self):
        """Their tets have one reference, which is what a .vtu of them all shows."""
        self.box(4)
        for name, colours in (("whole.vtu", 1), ("pieces.pvtu", 2)):
            self.weft("convert", "box.meshb", name, *(["--pieces", 2] if name.endswith(".pvtu") else []))
            picture = self.view(name, "--color-by", "subdomain", "--from", "-y")
            self.assertEqual(sum(picture.count(c) > 100 for c in (BLUE, ORANGE)), colours, name)

    def test_references_of_the_surface(self):
        self.box()
        left = self.view("box.meshb", "--color-by", "ref", "--from", "-x")
        right = self.view("box.meshb", "--color-by", "ref", "--from", "x")
        self.assert_like(left.at(0.5, 0.5), BLUE)
        self.assert_like(right.at(0.5, 0.5), ORANGE)
        only = self.view("box.meshb", "--color-by", "ref", "--only", "1,6", "--from", "x")
        self.assert_like(only.at(0.5, 0.5), BLUE)  # through the missing side
        self.assertEqual(only.count(ORANGE), 0)

    def test_nonconforming_is_red(self):
        self.box(4)
        rest = ["--color-by", "nonconforming", "--from", "-y"]
        good = self.view("box.meshb", "--metric-fn", "uniform:0.33", *rest)
        bad = self.view("box.meshb", "--metric-fn", "uniform:0.05", *rest)
        self.assertEqual((good.count(RED), bad.count(CONFORMING)), (0, 0))
        self.assertGreater(min(good.count(CONFORMING), bad.count(RED)), 10000)

    def test_lengths_diverge_from_one(self):
        self.box(4)
        short = self.view("box.meshb", "--metric-fn", "uniform:2", "--color-by", "length", "--from", "z").at(0.5, 0.5)
        long = self.view("box.meshb", "--metric-fn", "uniform:0.02", "--color-by", "length", "--from", "z").at(0.5, 0.5)
        self.assertGreater(short[2], 2 * short[0])
        self.assertGreater(long[0], 2 * long[2])

    def test_a_field_rises_from_dark_to_light(self):
        self.box(2)
        rows = [(x,) for _ in range(3) for _ in range(3) for x in (0, 0.5, 1)]
        self.write("f.sol", solution_text(rows, 1))
        picture = self.view("box.meshb", "--color-by", "field", "--field", "f.sol", "--from", "-y")
        places = [0.5 + 0.68 * (i / 20 - 0.5) for i in range(21)]
        sums = [sum(picture.at(x, 0.5)) for x in places]
        # A constant field's picture would be even, one against x would fall.
        self.assertTrue(all(a <= b + 6 for a, b in zip(sums, sums[1:])), sums)
        self.assertGreater(sums[-1], 2 * sums[0])
        self.weft("convert", "box.meshb", "box.vtu", "--sol", "f.sol")
        inside = self.view("box.vtu", "--color-by", "field", "--from", "-y")
        self.assertEqual([sum(inside.at(x, 0.5)) for x in places], sums)
        clamped = self.view("box.meshb", "--color-by", "field:f", "--field", "f.sol", "--from", "-y", "--range", "-9,-8")
        for x in places:
            for part, middle in zip(clamped.at(x, 0.5), clamped.at(0.5, 0.5)):
                self.assertAlmostEqual(part, middle, delta=1)

    def test_zoom_and_focus(self):
        self.box()
        rest = ["--from", "-y", "--clip", "x=0.5"]
        self.assertEqual(self.view("box.meshb", *rest, "--focus", "0.6,0,0.3,1,1,0.6").count(SURFACE), 0)
        self.assertEqual(self.view("box.meshb", "--from", "-y", "--focus", "0.4,0,0.4,0.6,1,0.6").count(SURFACE), 160 * 120)
        once = self.view("box.meshb", "--from", "-y", "--zoom", "0.5").count(SURFACE)
        self.assertAlmostEqual(once, (0.47 * 120) ** 2, delta=150)

    def test_up(self):
        self.weft("mesh", "box", "-o", "long.meshb", "--max", 2, 1, 1)
        wide, high = self.view("long.meshb", "--from", "z"), self.view("long.meshb", "--from", "z", "--up", "x")
        for picture, left, top in [(wide, SURFACE, WHITE), (high, WHITE, SURFACE)]:
            self.assertTrue(like(picture.at(0.1, 0.5), left) and like(picture.at(0.5, 0.1), top))

    def test_dark_ground(self):
        picture = self.view(self.box(), "--dark")
        self.assertLess(max(picture.at(0, 0)), 50)
        self.assertGreater(max(picture.at(0.5, 0.5)), 80)

    def test_every_format(self):
        self.box()
        for name, begins in [("a.png", b"\x89PNG"), ("a.pdf", b"%PDF"), ("a.svg", b"<?xml")]:
            self.weft("view", "box.meshb", "-o", name, "--size", "200x100", "--color-by", "quality")
            data = (self.folder / name).read_bytes()
            self.assertTrue(data.startswith(begins), data[:20])
            self.assertGreater(len(data), 500)
        self.assertIn("72pt", (self.folder / "a.svg").read_text())  # 200 pixels to an inch

    def test_every_input(self):
        self.box()
        for name in ("a.vtu", "a.msh", "a.su2", "a.cgns", "a.lb8.ugrid", "a.stl", "a.ply", "a.obj", "a.off"):
            self.weft("convert", "box.meshb", name)
            self.assert_like(self.view(name).at(0.5, 0.5), SURFACE)

    def test_what_makes_no_sense(self):
        self.box()
        for bad, says in [
            (["--size", "9x9"], "--size"),
            (["--from", "up"], "--from"),
            (["--from", "z", "--up", "-z"], "parallel to the view direction"),
            (["--clip", "x"], "--clip"),
            (["--clip", "0,0,0,0,0,0"], "--clip"),
            (["--slice"], "--clip"),
            (["--flip"], "--clip"),
            (["--focus", "1,2"], "--focus"),
            (["--zoom", "0"], "--zoom"),
            (["--color-by", "taste"], "taste"),
            (["--color-by", "length"], "--metric"),
            (["--color-by", "nonconforming"], "--metric"),
            (["--color-by", "field"], "--field"),
            (["--color-by", "quality", "--field", "f.sol"], "--field"),
            (["--color-by", "deviation"], "--geometry"),
            (["--color-by", "quality", "--geometry", "a.step"], "--geometry"),
            (["--range", "0,1"], "--range"),
            (["--color-by", "quality", "--range", "1,0"], "--range"),
            (["--color-by", "length", "--metric-fn", "uniform:1", "--range", "0,1"], "--range"),
            (["--only", "one"], "--only"),
        ]:
            self.assert_fails("view", "box.meshb", "-o", "a.png", *bad, says=says, code=64)
        self.assert_fails("view", "box.meshb", says="--out", code=64)
        self.assert_fails("view", "box.meshb", "-o", "a.jpg", says=".png, .svg or .pdf", code=64)
        self.assert_fails("stat", "box.meshb", "--plot", "a.png", says="--metric", code=64)
        self.assert_fails("stat", "box.meshb", "--plot", "a.gif", "--metric-fn", "uniform:1", says="a.gif", code=64)

    def test_what_cannot_be_read_or_shown(self):
        self.box()
        self.assert_fails("view", "missing.meshb", "-o", "a.png", says="missing.meshb")
        self.write("bad.meshb", "no mesh")
        self.assert_fails("view", "bad.meshb", "-o", "a.png", says="bad.meshb")
        self.assert_fails("view", "box.meshb", "-o", "nowhere/a.png", says="nowhere/a.png")
        self.assert_fails("view", "box.meshb", "-o", "a.png", "--only", "99", says=["box.meshb", "references"])
        self.assert_fails("view", "box.meshb", "-o", "a.png", "--clip", "9,9,9,-1,0,0", says=["box.meshb", "behind"])
        self.write("f.sol", solution_text([(1,)] * 4, 1))
        rest = ["-o", "a.png", "--color-by", "field", "--field", "f.sol"]
        self.assert_fails("view", "box.meshb", *rest, says=["f.sol", "another mesh"])
        self.write("one.mesh", ONE_TET)
        self.assert_fails("view", "one.mesh", *rest[:3], "field:g", "--field", "f.sol", says=["f.sol", "'g'", "f"])
        self.write("three.mesh", ONE_TET.replace("Tetrahedra\n1\n1 2 3 4 1\n", "Tetrahedra\n3\n" + 3 * "1 2 3 4 1\n"))
        self.assert_fails("view", "three.mesh", "-o", "a.png", says=["three.mesh", "tet"])

    def test_the_same_bytes_again(self):
        self.box(4)
        for name in ("a.png", "b.png"):
            self.weft("view", "box.meshb", "-o", name, "--clip", "x=0.4", "--color-by", "quality", "--size", "300x200")
        self.assertEqual((self.folder / "a.png").read_bytes(), (self.folder / "b.png").read_bytes())


class Plot(CommandTest):
    def plot(self, metric, name="h.png"):
        return self.weft("stat", "box.meshb", "--metric-fn", metric, "--plot", name)

    def bars(self, name="h.png"):
        """Bar pixels in the left and right, upper and lower quarter."""
        picture = Png(self.folder / name)
        self.assertEqual((picture.width, picture.height), (1800, 1300))
        counts = collections.Counter()
        for y, row in enumerate(picture.rows):
            line = bytes(row)
            for side, half in (("left", line[:2700]), ("right", line[2700:])):
                counts["upper" if y < 650 else "lower", side] += half.count(b"\x31\x68\x8e")
        return counts

    def test_four_histograms(self):
        self.box(4)
        said = self.plot("uniform:0.3")
        self.assertIn("unit", said.stdout)  # the plot is beside the words
        bars = self.bars()
        for panel in [(y, x) for y in ("upper", "lower") for x in ("left", "right")]:
            self.assertGreater(bars[panel], 1000, panel)

    def test_values_beyond_the_axis_are_not_bars(self):
        self.box(4)
        self.plot("uniform:0.001")  # all edges are far too long
        bars = self.bars()
        self.assertEqual(bars["lower", "left"] + bars["lower", "right"], 0)
        self.assertGreater(bars["upper", "left"], 1000)

    def test_formats_and_failures(self):
        self.box()
        self.plot("uniform:0.3", "h.pdf")
        self.assertTrue((self.folder / "h.pdf").read_bytes().startswith(b"%PDF"))
        self.plot("uniform:0.3", "h.svg")
        self.assertIn("<svg", (self.folder / "h.svg").read_text())
        self.weft("convert", "box.meshb", "box.stl")
        self.assert_fails("stat", "box.stl", "--metric-fn", "uniform:1", "--plot", "a.png", says=["box.stl", "no tets"])
        self.assert_fails("stat", "box.meshb", "--metric-fn", "uniform:1", "--plot", "no/a.png", says="no/a.png")


if __name__ == "__main__":
    unittest.main()
