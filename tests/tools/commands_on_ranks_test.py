"""The subcommands beside adapt under mpirun: the figures and bytes of one process, told once."""

import json
import re
import shutil
import unittest

from command import DATA, ONE_TET_FACES, ONE_TET_POINTS, mesh_text, solution_text
from on_ranks import LONG, MPICH, Subdomains, some_of


class OtherCommands(Subdomains):
    """Those that all ranks do together, or rank 0 alone, which is said then."""

    def test_stat_has_the_figures_of_one_process(self):
        self.weft("mesh", "ball", "-o", "ball.meshb", "--size", 0.4)
        for turn, words in enumerate((("ball.meshb",), ("ball.meshb", "--metric-fn", "polar-2", "--histogram"))):
            expected = self.command_on(0, "stat", *words)
            for ranks in some_of((1, 3, 2), turn):
                done = self.command_on(ranks, "stat", *words)
                self.assertEqual(done.stdout, expected.stdout, f"{ranks} ranks")
        whole = json.loads(self.command_on(0, "stat", *words, "--json").stdout)
        parts = json.loads(self.command_on(3, "stat", *words, "--json").stdout)
        self.assert_near(parts, whole)

    def test_tets_that_are_none_are_measured_as_by_one_process(self):
        """Inverted, flat, or lacking: a metric that is taken as it is asks nothing of them."""
        for turn, (name, tets) in enumerate((("inverted", [(2, 1, 3, 4)]), ("flat", [(1, 2, 3, 4), (1, 2, 3, 5)]), ("none", []))):
            mesh = self.write(name + ".mesh", mesh_text([*ONE_TET_POINTS, (1, 1, 0)], tets, ONE_TET_FACES))
            told = self.command_on(0, "metric", mesh, "--metric-fn", "uniform:1", "-o", "m.sol").stdout
            expected = self.bytes_of("m.sol")
            stat = ("stat", mesh, "--metric", "m.sol")
            self.assertEqual(self.command_on(2, *stat).stdout, self.command_on(0, *stat).stdout)
            if LONG or turn == 0:
                self.assertEqual(self.command_on(2, "metric", mesh, "--metric-fn", "uniform:1", "-o", "m.sol").stdout, told)
                self.assertEqual(self.bytes_of("m.sol"), expected)

    def assert_near(self, a, b):
        """Counts and words alike, numbers but for rounding."""
        self.assertEqual(type(a), type(b))
        if isinstance(a, dict):
            self.assertEqual(a.keys(), b.keys())
            for key in a:
                self.assert_near(a[key], b[key])
        elif isinstance(a, list):
            self.assertEqual(len(a), len(b))
            for x, y in zip(a, b):
                self.assert_near(x, y)
        elif isinstance(a, float):
            self.assertAlmostEqual(a, b, delta=1e-12 * max(1, abs(a)))
        else:
            self.assertEqual(a, b)

    def test_metrics_have_the_same_bytes(self):
        self.box(5)
        for turn, words in enumerate((("--metric-fn", "polar-2", "--hmax", 0.2, "--hgrad", 1.5), ("--implied", "--hmin", 0.01))):
            self.command_on(0, "metric", "box.meshb", *words, "-o", "out.solb")
            expected = self.bytes_of("out.solb")
            for ranks in some_of((1, 3, 2), turn):
                (self.folder / "out.solb").unlink()
                done = self.command_on(ranks, "metric", "box.meshb", *words, "-o", "out.solb")
                self.assertEqual(self.bytes_of("out.solb"), expected, f"{words} on {ranks} ranks")
                self.assertEqual(done.stdout.count("metric at 216 vertices"), 1, done.stdout)
        made = []
        for ranks in (1, 2, 4) if LONG else (1, 4):  # what is scaled is so by another order of summation than in one process
            self.command_on(ranks, "metric", "box.meshb", "--metric-fn", "polar-2", "--complexity", 500, "--hgrad", 1.5, "-o", "out.solb")
            made += self.bytes_of("out.solb")
        self.assertEqual(made, made[:1] * len(made))

    def test_interpolation_has_the_same_bytes(self):
        self.box(4, "from.meshb")
        self.box(5, "to.meshb")
        self.weft("metric", "from.meshb", "--metric-fn", "polar-1", "-o", "f.solb")
        for transfer in ("linear", "conservative"):
            told = []
            for ranks in (0, 1, 3):
                done = self.command_on(ranks, "interpolate", "from.meshb", "to.meshb", "--field", "f.solb", "--transfer", transfer, "-o",
                                       f"on{ranks}.solb")
                told.append(done.stdout.replace(f"on{ranks}.solb", "out.solb").splitlines())
            self.assertEqual(*self.bytes_of("on1.solb", "on3.solb"))
            self.assertEqual(told[1], told[2])
            self.assertEqual((told[0][:2], len(told[0])), (told[1][:2], len(told[1])))  # the rest says how much was lost: rounding
        done = self.command_on(2, "interpolate", "from.meshb", "to.meshb", "--field", "f.solb", "-o", "on2.sol")
        self.command_on(1, "interpolate", "from.meshb", "to.meshb", "--field", "f.solb", "-o", "on1.sol")
        self.assertEqual(*self.bytes_of("on1.sol", "on2.sol"))

    def test_conversion_has_the_same_bytes(self):
        self.weft("mesh", "ball", "-o", "a.meshb", "--size", 0.6)
        self.weft("metric", "a.meshb", "--metric-fn", "polar-1", "-o", "f.solb")
        self.weft("convert", "a.meshb", "b.lb8.ugrid")
        (self.folder / "b.mapbc").write_text("1\n1 4000 skin\n")
        self.weft("convert", "a.meshb", "c.msh", "--sol", "f.solb")
        self.weft("convert", "a.meshb", "d.msh", "--sol", "f.solb", "--encoding", "ascii", "--msh-version", "2.2")
        for turn, (source, out, *words) in enumerate((
                ("a.meshb", "o.vtu"), ("a.meshb", "o.msh"), ("a.meshb", "o.su2"), ("a.meshb", "o.mesh"), ("a.meshb", "o.ugrid"),
                ("a.meshb", "o.b8.ugrid"), ("b.lb8.ugrid", "o.meshb"), ("b.lb8.ugrid", "o.msh"), ("b.lb8.ugrid", "p.ugrid"),
                ("a.meshb", "o.vtu", "--encoding", "ascii"), ("a.meshb", "o.vtu", "--compress"), ("b.lb8.ugrid", "o.msh", "--encoding", "ascii"),
                ("a.meshb", "o.msh", "--msh-version", "2.2"), ("a.meshb", "o.b4.ugrid"), ("c.msh", "o.vtu"), ("d.msh", "o.msh"))):
            words += "--sol", "f.solb"
            self.command_on(0, "convert", source, out, *words)
            expected, told, files = self.bytes_of(out), None, self.files()
            for ranks in (1, 3) if LONG or turn == 0 else (3,):
                (self.folder / out).unlink()
                if out == "p.ugrid":
                    (self.folder / "p.mapbc").unlink()  # comes with it
                done = self.command_on(ranks, "convert", source, out, *words)
                self.assertEqual(self.bytes_of(out), expected, f"{source} to {out} {words} on {ranks} ranks")
                self.assertEqual(self.files(), files)
                self.assertNotIn("alone", done.stderr)
                told = told or done.stdout
                self.assertEqual(done.stdout, told)
            self.assertEqual(self.command_on(0, "convert", source, out, *words).stdout, told)
        done = self.command_on(2, "convert", "a.meshb", "o.stl")
        self.assertEqual(done.stderr.count("rank 0 alone does `weft convert`"), 1, done.stderr)

    def pieces(self):
        """ids.pvtu of 5 pieces and places.pvtu of 3 without ids, with a field."""
        self.weft("mesh", "ball", "-o", "a.meshb", "--size", 0.6)
        self.weft("metric", "a.meshb", "--metric-fn", "polar-1", "-o", "f.solb")
        self.weft("convert", "a.meshb", "ids.pvtu", "--sol", "f.solb", "--pieces", 5)
        self.weft("convert", "a.meshb", "places.pvtu", "--sol", "f.solb", "--pieces", 3, "--encoding", "ascii")
        for i in range(3):
            piece = self.folder / f"places_{i}.vtu"
            self.write(piece, piece.read_text().replace("GlobalPointIds", "number").replace(' GlobalIds="number"', ""))

    def test_meshes_in_pieces_are_read_and_written_in_shares(self):
        self.pieces()
        shutil.copy(DATA / "formats/cgns-two-zones.cgns", self.folder / "zones.cgns")
        shutil.copy(DATA / "formats/cgns-mixed.cgns", self.folder / "mixed.cgns")
        self.weft("convert", "a.meshb", "packed.vtu", "--sol", "f.solb", "--compress")
        for source, out, ranks, *words in (("ids.pvtu", "o.vtu", (1, 2, 3, 4, 7) if LONG else (2, 7)),
                                           ("places.pvtu", "o.meshb", (2, 4) if LONG else (4,)),
                                           ("zones.cgns", "o.msh", (1, 2, 3, 4, 16) if LONG else (3, 9)),
                                           ("zones.cgns", "o.meshb", (2,)),
                                           ("mixed.cgns", "o.msh", (1, 2, 3, 4) if LONG else (3,)),
                                           ("packed.vtu", "o.pvtu", (1, 2, 3, 4) if LONG else (4,), "--pieces", 3, "--compress")):
            self.command_on(0, "convert", source, out, *words)
            made = [name for name in self.files() if name.startswith("o")]
            expected, told = self.bytes_of(*made), None
            for n in ranks:
                for name in made:
                    (self.folder / name).unlink()
                done = self.command_on(n, "convert", source, out, *words)
                self.assertEqual([name for name in self.files() if name.startswith("o")], made)
                self.assertEqual(self.bytes_of(*made), expected, f"{source} to {out} on {n} ranks")
                self.assertNotIn("rank 0", done.stderr + done.stdout)
                told = told or self.command_on(0, "convert", source, out, *words).stdout
                self.assertEqual(done.stdout, told)
            for name in made:
                (self.folder / name).unlink()
        self.command_on(3, "convert", "a.meshb", "o.pvtu")
        self.assertIn("o_2.vtu", self.files())  # a piece a rank
        self.assertNotIn("o_3.vtu", self.files())
        words = ("stat", "ids.pvtu", "--metric", "ids.pvtu")
        self.assertEqual(self.command_on(3, *words).stdout, self.command_on(0, *words).stdout)

    def test_odd_pieces_are_read_as_by_one_process(self):
        """Ghost cells, fields that a piece lacks or that are no symmetric tensors, reals that are references in some pieces, and several pieces in
        one file."""
        self.pieces()
        texts = [(self.folder / f"places_{i}.vtu").read_text() for i in range(3)]

        def count(text, what):
            return int(re.search(f'NumberOf{what}="(\\d+)"', text)[1])

        def with_tensors(text, last):
            rows = ["1 0 0 0 1 0 0 0 1\n"] * (count(text, "Points") - 1) + [last]
            array = '<DataArray type="Float64" Name="{}" NumberOfComponents="9" format="ascii">' + "".join(rows) + "</DataArray>\n"
            return text.replace("</PointData>", array.format("full") + array.format("even").replace(last, rows[0]) + "</PointData>")

        texts = [with_tensors(text, "1 2 0 0 1 0 0 0 1\n" if i == 1 else "1 2 0 2 1 0 0 0 1\n") for i, text in enumerate(texts)]
        ghosts = '<DataArray type="UInt8" Name="vtkGhostType" format="ascii">1 2' + " 0" * (count(texts[1], "Cells") - 2) + "</DataArray>"
        texts[1] = texts[1].replace('<CellData Scalars="ref">', '<CellData Scalars="ref">' + ghosts)
        texts[2] = texts[2].replace("</PointData>", '<DataArray type="Float32" Name="pair" NumberOfComponents="2" format="ascii">' +
                                    "0 0 " * count(texts[2], "Points") + "</DataArray></PointData>")
        for i, last in enumerate(("7", "7", "0.5")):
            array = '<DataArray type="Float64" Name="CellEntityIds" format="ascii">' + "7 " * (count(texts[i], "Cells") - 1) + last + "</DataArray>"
            texts[i] = texts[i].replace('<CellData Scalars="ref">', '<CellData Scalars="ref">' + array)
        for i, text in enumerate(texts):
            self.write(f"places_{i}.vtu", text)
        pieces = "".join(text[text.index("<Piece "):text.index("</Piece>") + 8] for text in texts)
        self.write("many.vtu", texts[0][:texts[0].index("<Piece ")] + pieces + texts[0][texts[0].index("</Piece>") + 8:])
        told, made = [], []
        for turn, source in enumerate(("places.pvtu", "many.vtu")):
            for ranks in (0, 1, 2, 4) if LONG else (0, 4 - 2 * turn):
                told.append(self.command_on(ranks, "convert", source, "o.vtu").stdout)
                made += self.bytes_of("o.vtu")
            self.assertEqual(made, made[:1] * len(made), source)
            made.clear()
        self.assertEqual(told, told[:1] * len(told))
        cells = sum(count(text, "Cells") for text in texts)
        for words in (f"values of cell data CellEntityIds: {cells:,}", "fields of 2 components: 1", "fields of tensors that are not symmetric: 1", "fields that some pieces lack: 2"):
            self.assertIn(f"dropped {words}\n", told[0])
        self.assertIn(b'Name="even"', self.bytes_of("o.vtu")[0])

    def test_cgns_is_written_by_all(self):
        self.pieces()
        told = self.command_on(0, "convert", "ids.pvtu", "o.cgns").stdout
        self.weft("convert", "o.cgns", "expected.msh")
        for ranks in (1, 2, 4) if LONG else (1, 4):
            self.assertEqual(self.command_on(ranks, "convert", "ids.pvtu", "o.cgns").stdout, told)
            self.weft("convert", "o.cgns", "found.msh")  # has references, names, fields and no time of writing
            self.assertEqual(*self.bytes_of("expected.msh", "found.msh"))

    def test_a_piece_that_is_wrong_is_told_once_and_nothing_is_written(self):
        self.pieces()
        whole = (self.folder / "ids_1.vtu").read_bytes()
        cut = whole[:len(whole) // 2]
        swapped = whole.replace(b'NumberOfPoints="', b'NumberOfPoints="1')
        for bytes_of_piece, says in ((None, "ids_1.vtu: cannot read"), (cut, "ids_1.vtu"), (swapped, "ids_1.vtu: ")):
            (self.folder / "ids_1.vtu").unlink(missing_ok=True)
            if bytes_of_piece:
                (self.folder / "ids_1.vtu").write_bytes(bytes_of_piece)
            before = self.files()
            for words in (("convert", "ids.pvtu", "o.pvtu"), ("stat", "ids.pvtu"))[:2 if LONG or bytes_of_piece == cut else 1]:
                done = self.command_on(3, *words, expect=2)
                lines = [line for line in done.stderr.splitlines() if line.startswith("weft")]
                self.assertEqual(len(lines), 1, done.stderr)
                self.assertIn(says, lines[0])
                self.assertEqual(self.files(), before)

    def test_verify_has_the_words_of_one_process(self):
        self.weft("mesh", "ball", "-o", "ball.mesh", "--size", 0.4)
        self.weft("convert", self.box(4, "box.mesh"), "box.su2")
        lines = (self.folder / "ball.mesh").read_text().splitlines()
        tets, triangles = lines.index("Tetrahedra") + 2, lines.index("Triangles") + 2
        a, b, c, d, ref = lines[tets + 30].split()
        inverted = lines[:tets + 30] + [" ".join((b, a, c, d, ref))] + lines[tets + 31:]
        self.write("inverted.mesh", "\n".join(inverted) + "\n")
        lacking = [*lines]
        del lacking[triangles + 7]
        lacking[triangles - 1] = str(int(lacking[triangles - 1]) - 1)
        self.write("lacking.mesh", "\n".join(lacking) + "\n")
        twice = [*lines]
        twice[tets + 3] = " ".join(lines[tets + 3].split()[:1] * 2 + lines[tets + 3].split()[2:])
        self.write("twice.mesh", "\n".join(twice) + "\n")
        for turn, (words, code) in enumerate((
                (("ball.mesh",), 0), (("box.su2",), 0), (("ball.mesh", "--against", "ball.mesh"), 0),
                (("ball.mesh", "--against", "box.mesh"), 1), (("inverted.mesh",), 1), (("lacking.mesh",), 1), (("twice.mesh",), 2))):
            expected, found = self.command_on(0, "verify", *words, expect=code), ""
            for ranks in (1, 2, 4) if LONG or turn == 0 else (2 + turn % 2 * 2,):
                done = self.command_on(ranks, "verify", *words, expect=code)
                found = found + done.stdout
                self.assertEqual(done.stdout, expected.stdout, f"{words} on {ranks} ranks")
                self.assertNotIn("warning", done.stderr)
                if code == 2:
                    self.assertEqual([line for line in done.stderr.splitlines() if line.startswith("weft")],
                                     expected.stderr.splitlines())
            if words == ("inverted.mesh",):
                self.assertIn("tet 31: inverted", found)

    def test_what_rank_0_does_alone_is_done_once_and_told(self):
        for ranks in (1, 3):
            done = self.command_on(ranks, "mesh", "box", "-o", "box.meshb", "--cells", 2, 2, 2)
            self.assertEqual(done.stderr.count("rank 0 alone does `weft mesh`"), ranks > 1, done.stderr)

    def test_a_quiet_rank_0_alone_says_nothing(self):
        for words in (("mesh", "box", "-o", "box.meshb", "--cells", 2, 2, 2), ("convert", "box.meshb", "box.vtu", "--compress")):
            done = self.command_on(2, *words, "--quiet")
            self.assertEqual((done.stdout, done.stderr), ("", ""))

    def test_what_is_wrong_is_told_once(self):
        self.weft("metric", self.box(2), "--metric-fn", "uniform:1", "-o", "f.solb")
        self.write("none.mesh", mesh_text(ONE_TET_POINTS, [], ONE_TET_FACES))
        for words in (("stat", "none.meshb"), ("metric", "box.meshb", "--metric", "none.solb", "-o", "o.solb"),
                      ("interpolate", "box.meshb", "none.meshb", "--field", "none.solb", "-o", "o.solb"),
                      ("metric", "box.meshb", "--implied", "-o", "nowhere/o.solb"),
                      ("interpolate", "box.meshb", "none.mesh", "--field", "f.solb", "-o", "o.solb")):
            before = self.files()
            done = self.command_on(3, *words, expect=2)
            lines = [line for line in done.stderr.splitlines() if line.startswith("weft")]
            self.assertEqual(len(lines), 1, done.stderr)
            self.assertRegex(lines[0], "^weft: (none|nowhere)")
            self.assertEqual(self.files(), before)

    def test_values_that_are_no_numbers_are_told_with_their_file_and_not_converted(self):
        self.box(2)
        self.write("bad.sol", solution_text([(1,)] * 20 + [("nan",)] + [(1,)] * 6, kind=1))
        self.write("good.sol", solution_text([(1,)] * 27, kind=1))
        self.weft("convert", "box.meshb", "bad.vtu", "--sol", "good.sol", "--encoding", "ascii")
        at = (text := (self.folder / "bad.vtu").read_text()).index(">", text.index('Name="field_1"')) + 1
        (self.folder / "bad.vtu").write_text(text[:at] + text[at:].replace("1", "nan", 1))
        before = self.files()
        for words, says in ((("box.meshb", "--sol", "bad.sol"), "bad.sol: field 1: vertex 21: not a finite number"),
                            (("bad.vtu",), "bad.vtu: field 1: vertex 1: not a finite number")):
            for ranks in (0, 3):
                done = self.command_on(ranks, "convert", words[0], "out.vtu", *words[1:], expect=2)
                self.assertEqual(done.stderr.count(f"weft: {says}"), 1, done.stderr)
                self.assertEqual(self.files(), before)

    def test_what_is_wrong_with_arguments_is_told_once(self):
        self.box(1)
        for words, code, said in ((("stat", "--bogus", "b.meshb"), 64, "See `weft stat --help`"), ((), 64, "Usage: weft"),
                                  (("stat", "box.meshb", "--histogram"), 64, "See `weft stat --help`"),
                                  (("adapt", "box.meshb", "-o", "o.meshb"), 64, "See `weft adapt --help`"), (("stat", "--help"), 0, "Usage: weft stat")):
            done = self.command_on(3, *words, expect=code)
            times = 3 if code and MPICH else 1  # its mpirun lets the others go on, which then tell what they found, too
            self.assertEqual((done.stdout + done.stderr).count(said), times, done.stdout + done.stderr)


if __name__ == "__main__":
    unittest.main()
