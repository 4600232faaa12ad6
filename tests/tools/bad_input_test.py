"""Input that cannot be used: exit code 2, one line that names file, entity and reason, nothing left behind."""

import resource
import signal
import struct
import subprocess
import unittest

from command import DATA, ONE_TET, ONE_TET_FACES, ONE_TET_POINTS, WEFT, CommandTest, mesh_text, solution_text

IDENTITY = (1, 0, 1, 0, 0, 1)


class BadInput(CommandTest):
    def refuse(self, mesh, *metric, says):
        self.assert_fails("adapt", mesh, *(metric or ["--metric-fn", "uniform:1"]), "-o", "out.meshb", says=says)

    def test_missing_file(self):
        self.refuse("no.meshb", says="no.meshb")
        self.refuse(self.box(), "--metric", "no.solb", says="no.solb")

    def test_not_a_mesh(self):
        self.refuse(self.write("a.meshb", "what is this"), says="a.meshb")
        self.refuse(self.write("a.mesh", "what is this"), says="a.mesh")
        self.refuse(self.write("empty.meshb", ""), says="empty.meshb")
        self.refuse(self.write("a.stl", "solid"), says="a.stl")

    def test_truncated_anywhere(self):
        whole = (DATA / "delta-wing-coarse.meshb").read_bytes()
        for share in range(0, 100, 7):
            (self.folder / "cut.meshb").write_bytes(whole[: len(whole) * share // 100])
            self.refuse("cut.meshb", says="cut.meshb")

    def test_damaged_bytes_never_crash(self):
        self.box(1)
        whole = (self.folder / "box.meshb").read_bytes()
        for at in range(0, len(whole), 97):
            (self.folder / "bad.meshb").write_bytes(whole[:at] + bytes([whole[at] ^ 0xFF]) + whole[at + 1 :])
            self.weft("stat", "bad.meshb", expect=(0, 2))

    def test_messages_are_text(self):
        """Whatever lies in the file: no byte of it may do anything to a terminal."""
        (self.folder / "a.mesh").write_bytes(ONE_TET.replace("0 0 1", "0 0 \x9b1m", 1).encode("latin-1"))
        self.refuse("a.mesh", says=["a.mesh: Vertices", "found '?1m'"])
        piece = b'<VTKFile type="PUnstructuredGrid"><PUnstructuredGrid><Piece Source="p\xe5.vtu"/></PUnstructuredGrid></VTKFile>'
        (self.folder / "a.pvtu").write_bytes(piece)
        self.refuse("a.pvtu", says="p?.vtu")

    def test_count_beyond_the_file(self):
        self.box(1)
        data = bytearray((self.folder / "box.meshb").read_bytes())
        keyword = struct.pack("<i", 4)  # Vertices; its count follows the position of the next section
        at = data.index(keyword, 8)
        data[at + 8 : at + 12] = struct.pack("<i", 2_000_000_000)
        (self.folder / "bad.meshb").write_bytes(data)
        self.refuse("bad.meshb", says="bad.meshb")

    def test_wrong_count_in_text(self):
        self.refuse(self.write("a.mesh", ONE_TET.replace("Tetrahedra\n1\n", "Tetrahedra\n3\n")), says="a.mesh")

    def test_index_out_of_range(self):
        text = mesh_text(ONE_TET_POINTS, [(1, 2, 3, 9)], ONE_TET_FACES)
        self.refuse(self.write("a.mesh", text), says=["a.mesh", "etrahedra 1"])

    def test_no_tetrahedra(self):
        self.refuse(self.write("a.mesh", mesh_text(ONE_TET_POINTS, [], ONE_TET_FACES)), says=["a.mesh", "tetrahedr"])

    def test_inverted_tet(self):
        text = mesh_text(ONE_TET_POINTS, [(2, 1, 3, 4)], ONE_TET_FACES)
        self.refuse(self.write("a.mesh", text), says="a.mesh")

    def test_duplicate_tet(self):
        text = mesh_text(ONE_TET_POINTS, [(1, 2, 3, 4), (1, 2, 3, 4)], ONE_TET_FACES)
        self.refuse(self.write("a.mesh", text), says="a.mesh")

    def test_nonconforming_face(self):
        """Three tets at one face."""
        points = [*ONE_TET_POINTS, (0, 0, -1), (0.1, 0.1, 2)]
        text = mesh_text(points, [(1, 2, 3, 4), (1, 3, 2, 5), (1, 2, 3, 6)])
        self.refuse(self.write("a.mesh", text), says="a.mesh")

    def test_coordinate_that_is_not_finite(self):
        points = [*ONE_TET_POINTS[:3], (0, 0, "nan")]
        self.refuse(self.write("a.mesh", mesh_text(points, [(1, 2, 3, 4)], ONE_TET_FACES)), says=["a.mesh", "4"])

    def test_metric_not_a_number(self):
        mesh = self.write("a.mesh", ONE_TET)
        for bad in ("nan", "inf"):
            self.write("m.sol", solution_text([IDENTITY, IDENTITY, (bad, 0, 1, 0, 0, 1), IDENTITY]))
            self.refuse(mesh, "--metric", "m.sol", says=["m.sol", "vertex 3"])

    def test_metric_not_positive_definite(self):
        mesh = self.write("a.mesh", ONE_TET)
        self.write("m.sol", solution_text([IDENTITY, (1, 2, 1, 0, 0, 1), IDENTITY, IDENTITY]))
        self.refuse(mesh, "--metric", "m.sol", says=["m.sol", "vertex 2", "positive definite"])

    def test_metric_in_the_other_tensor_order(self):
        """Row-wise m11 m12 m13 m22 m23 m33 of diag(1, 1, 1): read as GMF's order it is not definite."""
        mesh = self.write("a.mesh", ONE_TET)
        self.write("m.sol", solution_text([(1, 0, 0, 1, 0, 1)] * 4))
        self.refuse(mesh, "--metric", "m.sol", says=["m.sol", "vertex 1", "m11 m12 m13 m22 m23 m33"])

    def test_size_not_above_zero(self):
        mesh = self.write("a.mesh", ONE_TET)
        for bad in (0, -1):
            self.write("m.sol", solution_text([(1,), (1,), (1,), (bad,)], kind=1))
            self.refuse(mesh, "--metric", "m.sol", says=["m.sol", "vertex 4"])

    def test_metric_of_another_mesh(self):
        self.weft("metric", self.box(2, "other.meshb"), "--metric-fn", "uniform:1", "-o", "other.solb")
        self.refuse(self.box(3), "--metric", "other.solb", says=["other.solb", "another mesh"])

    def test_solution_without_a_metric(self):
        mesh = self.write("a.mesh", ONE_TET)
        self.write("v.sol", solution_text([(1, 0, 0)] * 4, kind=2))
        self.refuse(mesh, "--metric", "v.sol", says="v.sol")

    def test_unwritable_output(self):
        mesh = self.box()
        self.write("file", "")
        for out in ("no-such-folder/out.meshb", "file/out.meshb"):
            self.assert_fails("adapt", mesh, "--metric-fn", "uniform:1", "-o", out, says=out)
            self.assert_fails("mesh", "box", "-o", out, says=out)
            self.assert_fails("convert", mesh, out, says=out)
        self.assert_fails("adapt", mesh, "--metric-fn", "uniform:1", "-o", "out.meshb", "--report", "file/r",
                          says="file/r")

    def test_output_that_there_is_no_room_for(self):
        """Of CGNS too, whose library does not tell the reason."""
        def little_room():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (2000, 2000))

        self.box()
        before = self.files()
        for name in ("a.cgns", "a.meshb"):
            done = subprocess.run([WEFT, "convert", "box.meshb", name], cwd=self.folder, preexec_fn=little_room, capture_output=True,
                                  text=True, timeout=100)
            self.assertEqual((done.returncode, done.stderr), (2, f"weft: {name}: cannot write: File too large\n"))
            self.assertEqual(self.files(), before)

    def test_output_that_is_a_folder(self):
        (self.folder / "out.meshb").mkdir()
        self.refuse(self.box(), says="out.meshb")

    def test_more_than_the_memory(self):
        mesh = self.box()
        self.assert_fails("adapt", mesh, "--metric-fn", "uniform:1", "--complexity", "8e7", "-o", "out.meshb",
                          says=["160,000,000 vertices", "960,000,000 tets", "240.0 GB", "--force"])
        self.assert_fails("adapt", mesh, "--metric-fn", "uniform:1e-9", "-o", "out.meshb", says=["tets", "--complexity"])
        for complexity in "3e8", "1e12":  # a tet's faces have numbers of 32 bits
            self.assert_fails("adapt", mesh, "--metric-fn", "uniform:1", "--complexity", complexity, "--force", "-o",
                              "out.meshb", says="more tets than one mesh can have")
        self.assert_fails("adapt", mesh, "--metric-fn", "uniform:1", "--complexity", "3e8", "--subdomains", "8",
                          "--force", "-o", "out.meshb", says="more tets than subdomains can have")

    def test_output_that_would_replace_the_metric(self):
        mesh = self.box()
        self.weft("metric", mesh, "--metric-fn", "uniform:1", "-o", "out.solb")
        for subdomains in [], ["--subdomains", 2], ["--subdomains", 2, "--simulate-ranks", 2]:
            self.assert_fails("adapt", mesh, "--metric", "out.solb", "-o", "out.meshb", *subdomains, code=64,
                              says="--out: its metric out.solb would replace the input out.solb")

    def test_output_that_would_replace_another_input(self):
        mesh = self.box()
        metric = ("--metric-fn", "uniform:1")
        self.weft("metric", mesh, *metric, "-o", "fine-fields.solb")
        self.assert_fails("adapt", mesh, *metric, "--field", "fine-fields.solb", "-o", "fine.meshb", says=["its fields", "would replace"],
                          code=64)
        self.weft("metric", self.box(3, "other.meshb"), *metric, "-o", "other.solb")
        self.assert_fails("adapt", mesh, "--background", "other.meshb", "--metric", "other.solb", "-o", "other.meshb", says="would replace",
                          code=64)
        self.weft("metric", "other.meshb", *metric, "-o", "ball.solb")
        self.weft("convert", mesh, "surface.stl")
        self.assert_fails("mesh", "surface.stl", "--background", "other.meshb", "--metric", "ball.solb", "-o", "ball.meshb", says="would replace",
                          code=64)
        self.assert_fails("mesh", mesh, "-o", mesh, says="would replace the input box.meshb", code=64)
        self.assert_fails("adapt", mesh, *metric, "--subdomains", 2, "--trace", mesh, "-o", "fine.meshb",
                          says="--trace: it would replace the input box.meshb", code=64)

    def test_pieces_that_would_replace_an_input(self):
        self.weft("convert", self.box(), "a_0.vtu")
        for words in (["convert", "a_0.vtu", "a.pvtu"], ["adapt", "a_0.vtu", "--metric-fn", "uniform:1", "-o", "a.pvtu"]):
            self.assert_fails(*words, says="would replace the input a_0.vtu", code=64)
        (self.folder / "b").mkdir()
        self.weft("convert", "a_0.vtu", "b/a.pvtu")
        self.weft("convert", "a_0.vtu", "a_.pvtu")

    def test_pieces_of_an_input_that_would_be_replaced(self):
        self.weft("convert", self.box(), "a.pvtu")
        before = (self.folder / "a_1.vtu").read_bytes()
        for words in (["convert", "a.pvtu", "a_1.vtu"], ["adapt", "a.pvtu", "--metric-fn", "uniform:1", "-o", "a_1.vtu"]):
            self.assert_fails(*words, says="would replace the input a.pvtu", code=64)
        self.assertEqual((self.folder / "a_1.vtu").read_bytes(), before)
        self.weft("convert", "a.pvtu", "a_2.vtu")
        self.weft("convert", "a.pvtu", "a.pvtu")

    def test_conversion_that_would_replace_an_input(self):
        mesh = self.box()
        self.weft("metric", mesh, "--metric-fn", "uniform:1", "-o", "a.solb")
        self.weft("convert", mesh, "a.vtu", "--sol", "a.solb")
        self.weft("convert", mesh, "a.meshb", "--sol", "a.solb")  # the fields beside it are those that are there
        before = (self.folder / "a.solb").read_bytes()
        self.weft("convert", "a.vtu", "a.vtu", "--compress")  # it is read before
        self.assert_fails("convert", mesh, "a.vtu", "--sol", "a.vtu", says="OUT: it would replace the input a.vtu", code=64)
        self.assertEqual((self.folder / "a.solb").read_bytes(), before)


if __name__ == "__main__":
    unittest.main()
