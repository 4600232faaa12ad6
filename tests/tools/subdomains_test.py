"""`weft adapt --subdomains`, by itself and under mpirun: the same results, reports, errors that all ranks learn of."""

import json
import re
import signal
import subprocess
import unittest

from command import WEFT, solution_text, without_first_triangle
from on_ranks import LONG, MPIRUN, SECONDS, Subdomains, some_of

SUBDOMAIN_KEYS = {
    "subdomains", "partitioner", "ranks", "layers", "checks", "decomposition_seconds", "adaptation_seconds",
    "seconds_by_operation", "share_beside_adaptation", "coarse_shifts", "divided_from", "shifts", "by_rank",
    "exchanged_by_rank", "former_interface", "engine", "checkpoints",
}
OPERATIONS = {
    "interior adaptation", "MII adaptation", "interface refinement", "colouring and quality check", "gather", "scatter",
    "topology update", "conversion", "misc", "help", "idle", "communication",
}


class Results(Subdomains):
    def test_operations_that_are_ruled_out_are_done_nowhere(self):
        self.box(4)
        words = ("box.meshb", "--metric-fn", "uniform:0.15", "--subdomains", 4, "--report", "r", "-o", "out.meshb", "--quiet")
        for option, operators in (("--no-insert", ("split", "collapse")), ("--no-swap", ("swap_edge", "swap_face")),
                                  ("--no-move", ("smooth", "relocate"))):
            with self.subTest(option):
                self.run_on(2, *words, option, expect=(0, 1))
                counts = json.loads((self.folder / "r" / "report.json").read_text())["operations"]
                self.assertEqual([counts[name]["done"] for name in operators], [0, 0], counts)
                self.assertGreater(sum(counts[name]["done"] for name in counts), 0, counts)

    def test_without_swaps_nothing_is_split_unjudged(self):
        """Of a thin plate the interface's needles became 18,000 vertices, and nothing could mend what was beside them."""
        words = (self.box(4), "--metric-fn", "uniform:0.15", "--subdomains", 4, "--threads", 1, "--quiet", "--no-swap")
        self.weft("adapt", *words, "-o", "a.meshb", expect=(0, 1))
        self.weft("adapt", *words, "--no-interface-refinement", "-o", "b.meshb", expect=(0, 1))
        self.assertEqual(*self.bytes_of("a.meshb", "b.meshb"))

    def test_same_bytes_on_any_number_of_ranks(self):
        self.assert_same_on_all(self.box(4), "--metric-fn", "uniform:0.15", "--subdomains", 5)
        self.weft("verify", "out.meshb", "--against", "box.meshb")

    def test_same_bytes_with_a_metric_that_is_scaled(self):
        self.weft("metric", self.box(4), "--metric-fn", "polar-2", "-o", "m.solb")
        self.assert_same_on_all("box.meshb", "--metric", "m.solb", "--complexity", 300, "--subdomains", 5, expect=1)
        self.weft("verify", "out.meshb", "--against", "box.meshb")

    def test_same_bytes_where_a_curved_boundary_limits_the_metric(self):
        self.weft("mesh", "ball", "-o", "ball.meshb", "--size", 0.25)
        self.weft("metric", "ball.meshb", "--metric-fn", "polar-2", "-o", "m.solb")
        for words in (("--metric-fn", "uniform:0.5"), ("--metric", "m.solb", "--complexity", 300)):
            done = self.assert_same_on_all("ball.meshb", *words, "--hausd", 0.01, "--subdomains", 4, expect=(0, 1))
            self.assertIn("metric made finer at", done.stdout)
            self.weft("verify", "out.meshb")

    def assert_in_shares(self, whole, done):
        """Whether the run has read the mesh in shares, which it says where it has not."""
        (self.assertIn if whole else self.assertNotIn)("rank 0 has read all of", done.stdout + done.stderr)

    def test_same_bytes_with_metrics_that_are_made_in_parts(self):
        self.weft("convert", self.box(4), "box.mesh")
        lines = (self.folder / "box.mesh").read_text().split("Vertices")[1].splitlines()
        points = [map(float, line.split()[:3]) for line in lines[2:2 + int(lines[1])]]
        self.write("field.sol", solution_text([[(x * x + 0.2 * y) * (1 + z)] for x, y, z in points], kind=1))
        for turn, words in enumerate((("--metric-fn", "uniform:0.2", "--hmax", 0.18, "--hgrad", 1.5),
                                      ("--sol", "field.sol", "--complexity", 250, "--hgrad", 1.5),
                                      ("--sol", "field.sol", "--recovery", "l2", "--complexity", 250, "--aspect", 3, "--implied"),
                                      ("--metric-fn", "uniform:0.3", "--wall", "1,3", "--wall-height", 0.1, "--hgrad", 1.8))):
            done = self.assert_same_on_all("box.meshb", *words, "--subdomains", 4, ranks=some_of((2, 3), turn), expect=(0, 1))
            self.assert_in_shares(False, done)

    def test_a_finished_mesh_is_left_as_it_is(self):
        self.weft("adapt", self.box(2), "--metric-fn", "uniform:0.08", "--subdomains", 3, "--threads", 1, "-o", "in.meshb")
        self.weft("metric", "in.meshb", "--metric-fn", "polar-2", "-o", "field.solb")
        words = ("in.meshb", "--metric", "in.solb", "--subdomains", 7, "-o", "out.meshb", "--field", "field.solb")
        more = ("--report", "r", "--graph", "g.json", "--trace", "t.json", "--check")
        for turn, ranks in enumerate((0, 2, 3)):
            done = self.run_on(ranks, *words, *(more if turn < 2 else ()))
            self.assertIn("the mesh fits its metric: left as it is", done.stdout)
            self.assertEqual(self.bytes_of("out.meshb", "out.solb", "out-fields.solb"), self.bytes_of("in.meshb", "in.solb", "field.solb"))
        report = json.loads((self.folder / "r/report.json").read_text())
        self.assertEqual(report["before"], report["after"])
        self.assertEqual(report["subdomains"]["subdomains"], 7)
        self.assertEqual(json.loads((self.folder / "g.json").read_text())["runs"]["node"], [])
        self.run_on(2, *words[:-4], "-o", "out.pvtu")
        self.weft("verify", "out.pvtu", "--against", "in.meshb")

    def test_a_mesh_that_does_not_quite_fit_is_adapted(self):
        self.weft("adapt", self.box(2), "--metric-fn", "uniform:0.08", "--subdomains", 3, "--threads", 1, "-o", "in.meshb")
        self.weft("convert", "in.meshb", "in.mesh")
        self.write("less.mesh", without_first_triangle((self.folder / "in.mesh").read_text()))
        for mesh, options in (("less.mesh", ()), ("in.meshb", ("--complexity", 2200))):
            done = self.run_on(2, mesh, "--metric", "in.solb", *options, "--subdomains", 3, "-o", "out.meshb")
            self.assertNotIn("left as it is", done.stdout)
            self.weft("verify", "out.meshb")

    def test_it_is_told_where_rank_0_reads_the_whole_mesh(self):
        self.weft("convert", self.box(4), "box.pvtu")
        for options, whole in ((["--repair"], True), ([], False)):
            self.assert_in_shares(whole, self.run_on(2, "box.pvtu", "--metric-fn", "uniform:0.3", "--subdomains", 4, "-o", "o.meshb", *options))

    def test_ranks_may_have_different_numbers_of_threads(self):
        self.box(4)
        words = [str(WEFT), "adapt", "box.meshb", "--metric-fn", "uniform:0.2", "-o", "out.meshb", "--threads"]
        subprocess.run([*MPIRUN, "-n", "1", *words, "1", ":", "-n", "1", *words, "3"], cwd=self.folder, check=True, capture_output=True, timeout=300)
        self.weft("verify", "out.meshb", "--against", "box.meshb")

    def test_a_mesh_that_is_mended_has_its_metric_scaled(self):
        self.box(4)
        self.weft("metric", "box.meshb", "--metric-fn", "polar-2", "-o", "m.solb")
        meshes = []
        for ranks in (0, 2, 3):
            self.run_on(ranks, "box.meshb", "--metric", "m.solb", "--complexity", 500, "--repair", "--subdomains", 4, "--threads", 1, "-o", "o.meshb",
                        expect=(0, 1))
            meshes.append(self.bytes_of("o.meshb", "o.solb"))
        self.assertEqual(meshes[1:], meshes[:1] * 2)

    def test_pieces_that_were_there_stay_when_one_cannot_be_written(self):
        words = (self.box(4), "--metric-fn", "uniform:0.2", "--subdomains", 4, "--partitioner", "pqr:4x1x1", "-o", "out.pvtu")
        self.run_on(2, *words)
        before = self.bytes_of("out.pvtu", "out_0.vtu", "out_1.vtu", "out_2.vtu")
        (self.folder / "out_3.vtu").unlink()
        (self.folder / "out_3.vtu").mkdir()
        self.assertIn("out_3.vtu", self.run_on(2, *words, expect=2).stderr)
        self.assertEqual(self.bytes_of("out.pvtu", "out_0.vtu", "out_1.vtu", "out_2.vtu"), before)

    def test_text_is_dealt_out_by_one_reader_and_gives_the_same_result(self):
        box = self.box(5)
        self.weft("convert", box, "in.lb8.ugrid")
        (self.folder / "in.mapbc").write_text("2\n1 5000 inflow\n4 3000 the wall\n")
        for turn, (name, *options) in enumerate((
                ("in.su2",), ("in.mesh",), ("in.ugrid",), ("a.msh", "--encoding", "ascii"),
                ("b.msh", "--encoding", "ascii", "--msh-version", "2.2"), ("in.vtu", "--encoding", "ascii"))):
            self.weft("convert", "in.lb8.ugrid", name, *options)
            meshes = []
            for ranks in (0, *some_of((1, 2, 4) if LONG or turn else (1, 4), turn)):
                done = self.run_on(ranks, name, "--metric-fn", "uniform:0.15", "--subdomains", 5, "--threads", 1, "-o", "out.su2")
                self.assert_in_shares(False, done)
                meshes.append(self.bytes_of("out.su2", "out.solb"))
            self.assertEqual(meshes[1:], meshes[:1] * (len(meshes) - 1), name)
            if name != "in.mesh" and not name.endswith(".vtu"):
                self.assertIn(b"MARKER_TAG= the_wall", meshes[0][0], name)
        text = (self.folder / "in.su2").read_text()
        self.write("bad.su2", text.replace("\n10 ", "\n10 99999 ", 1))
        self.assert_all_ranks_fail("bad.su2", "--metric-fn", "uniform:0.3", "-o", "o.meshb", says="bad.su2: NELEM 1: ", ranks=3)

    def test_checks_after_every_round_are_told_and_change_nothing(self):
        words = (self.box(4), "--metric-fn", "uniform:0.15", "--subdomains", 5, "-o", "out.meshb", "--threads", 1)
        self.run_on(2, *words)
        expected = self.bytes_of("out.meshb")
        for ranks in (0, 1, 3) if LONG else (0, 3):
            done = self.run_on(ranks, *words, "--check", "--report", "r")
            self.assertRegex(done.stdout, r"all invariants checked \d+ times, and held")
            self.assertEqual(self.bytes_of("out.meshb"), expected)
            report = json.loads((self.folder / "r" / "report.json").read_text())
            self.assertGreaterEqual(report["subdomains"]["checks"], 3)
            self.check_times(report, done.stdout)

    def check_times(self, report, summary):
        seconds = report["seconds"]
        steps = ("read", "metric", "decompose", "adapt", "measure", "write")
        for step in steps:
            self.assertGreater(seconds[step], 0, step)
            self.assertRegex(summary, rf"\n  {step} +{seconds[step]:.3f}")
        self.assertLessEqual(sum(seconds[step] for step in steps), seconds["total"])
        self.assertEqual(seconds["decompose"], report["subdomains"]["decomposition_seconds"])

    def test_partitioners(self):
        self.box(4)
        for partitioner in ("graph", "pqr:3x1x1", "pqr:3x1x1:principal", "bisection", "pqr:3x1x1:harmonic=5,1",
                            "pqr:wall=2,3:principal:fewer"):
            self.run_on(0, "box.meshb", "--metric-fn", "uniform:0.2", "--subdomains", 3, "--partitioner", partitioner, "-o",
                        "out.meshb", "--quiet")
            self.weft("verify", "out.meshb", "--against", "box.meshb")

    def test_thin_slabs_stay_unless_fewer_are_asked_for(self):
        self.box(4)
        for partitioner, fewer in (("pqr:20x1x1:fewer", True), ("pqr:20x1x1", False)):
            for ranks in (0, 2):
                done = self.run_on(ranks, "box.meshb", "--metric-fn", "uniform:0.2", "--partitioner", partitioner, "-o", "out.meshb")
                self.assertEqual("12 of 20 subdomains stay empty" in done.stdout + done.stderr, fewer)
                self.assertEqual("by the graph partitioner have about" in done.stdout + done.stderr, not fewer)
                self.assertIn(f"20 subdomains by {partitioner}", done.stdout)
                self.weft("verify", "out.meshb", "--against", "box.meshb")

    def test_thin_slabs_of_a_mesh_that_is_divided_later_are_told_too(self):
        self.box(2)
        words = ("box.meshb", "--metric-fn", "uniform:0.1", "--complexity", 4000, "-o", "out.meshb", "--partitioner")
        for ranks in (0, 2):
            done = self.run_on(ranks, *words, "pqr:40x1x1")
            self.assertIn("by the graph partitioner have about", done.stdout + done.stderr)
            done = self.run_on(ranks, *words, "pqr:40x1x1:fewer")
            self.assertRegex(done.stdout + done.stderr, r"\d+ of 40 subdomains stay empty")

    def test_work_in_a_few_tets_is_spread_over_all_subdomains(self):
        self.box(9)
        self.weft("metric", "box.meshb", "--metric-fn", "uniform:0.1", "-o", "m.sol")
        head, values = (self.folder / "m.sol").read_text().split("1 3\n")
        lines = values.split("\n")
        middle = sorted(range(1000), key=lambda i: sum(abs(i // 10**k % 10 - 4.5) for k in range(3)))[:8]
        for i in middle:
            lines[i] = "10000 0 10000 0 0 10000"
        (self.folder / "m.sol").write_text(head + "1 3\n" + "\n".join(lines))
        done = self.run_on(2, "box.meshb", "--metric", "m.sol", "--complexity", 10000, "--subdomains", 64, "-o", "out.meshb", "--threads", 1,
                           "--report", "r", expect=(0, 1))  # the metric between the vertices is none of this complexity
        self.assertNotIn("***", done.stdout + done.stderr)  # METIS's words
        self.weft("verify", "out.meshb", "--against", "box.meshb")
        self.assertGreater(json.loads((self.folder / "r" / "report.json").read_text())["subdomains"]["divided_from"], 0)

    def test_as_many_subdomains_as_the_partitioner_says(self):
        self.box(4)
        done = self.run_on(0, "box.meshb", "--metric-fn", "uniform:0.2", "--partitioner", "bisection", "--threads", 2, "-o",
                           "out.meshb")
        self.assertIn("8 subdomains by bisection on 1 rank", done.stdout)
        done = self.run_on(2, "box.meshb", "--metric-fn", "uniform:0.2", "--partitioner", "pqr:3x1x1", "-o", "out.meshb")
        self.assertIn("3 subdomains by pqr:3x1x1 on 2 ranks", done.stdout)

    def test_slabs_along_the_boundary_are_the_same_on_any_ranks(self):
        self.box(5)
        for partitioner in ("pqr:4x1x1:harmonic=3,2", "pqr:4x1x1:wall=1"):
            meshes = []
            for ranks in (0, 1, 3):
                self.run_on(ranks, "box.meshb", "--metric-fn", "uniform:0.15", "--partitioner", partitioner, "--threads", 1, "-o",
                            "out.meshb", "--quiet")
                meshes.append(self.bytes_of("out.meshb"))
            self.assertEqual(meshes[1:], meshes[:1] * 2)
            self.weft("verify", "out.meshb", "--against", "box.meshb")
        self.assert_all_ranks_fail("box.meshb", "--metric-fn", "uniform:0.3", "--partitioner", "pqr:2x1x1:harmonic=1,7", "-o",
                                   "new.meshb", says="box.meshb: partitioner harmonic=1,7: no triangle has the reference 7")

    def test_layers_as_given_move_more_tets_in_later_shifts(self):
        self.box(6)
        moved = {}
        for words in ((), ("--layers", 2), ("--layers", 4)):
            self.run_on(2, "box.meshb", "--metric-fn", "uniform:0.08", "--subdomains", 6, "--threads", 1, *words, "-o", "out.meshb",
                        "--report", "r", "--quiet")
            report = json.loads((self.folder / "r" / "report.json").read_text())["subdomains"]
            self.assertEqual(report["layers"], words[1] if words else 2)
            first = report["coarse_shifts"]  # shifts count from 1
            moved[words] = [shift["tets_moved"] for shift in report["shifts"] if shift["shift"] in (first + 1, first + 2)]
        self.assertEqual(moved[()][0], moved["--layers", 2][0])
        self.assertLess(moved[()][1], moved["--layers", 2][1])
        self.assertLess(moved["--layers", 2][0], moved["--layers", 4][0])

    def test_all_options(self):
        self.box(4)
        for turn, words in enumerate((["--shifts", 0], ["--shifts", 1, "--layers", 0], ["--layers-by", "faces"], ["--balancer", "none"],
                                      ["--balancer", "diffusion"], ["--equal", "tets"], ["--no-interface-refinement"])):
            self.run_on(2 if LONG or turn % 2 == 0 or "--balancer" in words else 0, "box.meshb", "--metric-fn", "uniform:0.2", "--subdomains", 4, *words, "-o", "out.meshb", "--quiet")
            self.weft("verify", "out.meshb", "--against", "box.meshb")

    def test_curved_boundary_and_a_boundary_coarser_than_wanted(self):
        self.weft("mesh", "ball", "-o", "ball.meshb", "--size", 0.5)
        self.run_on(2, "ball.meshb", "--metric-fn", "uniform:0.2", "--subdomains", 4, "-o", "out.meshb", "--quiet")
        self.weft("verify", "out.meshb")

    def test_formats_that_one_rank_writes(self):
        self.box(3)
        for name in ("a.vtu", "b.mesh", "c.cgns"):
            self.run_on(2, "box.meshb", "--metric-fn", "uniform:0.25", "--subdomains", 4, "-o", name, "--quiet")
            self.weft("verify", name, "--against", "box.meshb")

    def test_ugrid_and_cgns_are_read_in_shares_and_names_are_kept(self):
        box = self.box(4)
        self.weft("convert", box, "in.lb8.ugrid")
        (self.folder / "in.mapbc").write_text("2\n1 5000 inflow\n4 3000 the wall\n")
        self.weft("convert", "in.lb8.ugrid", "in.cgns")
        self.weft("convert", "in.lb8.ugrid", "in.vtu")
        self.weft("convert", "in.lb8.ugrid", "in.msh")
        words = ("--metric-fn", "uniform:0.15", "--subdomains", 5, "--threads", 1, "--quiet")
        for turn, (name, out) in enumerate((("in.lb8.ugrid", "out.lb8.ugrid"), ("in.cgns", "out.cgns"), ("in.lb8.ugrid", "out.cgns"),
                                            ("in.vtu", "out.vtu"), ("in.msh", "out.cgns"))):
            meshes = []
            for ranks in (0, *some_of((1, 2, 4) if LONG or turn else (1, 4), turn)):
                done = self.run_on(ranks, name, *words[:-1], "-o", out)
                self.assert_in_shares(False, done)
                self.assertNotIn("names of references", done.stdout + done.stderr)
                self.weft("convert", out, "out.msh")  # has references, names and no time of writing
                meshes.append(self.bytes_of("out.msh")[0])
                if out.endswith("ugrid"):
                    self.assertEqual(*self.bytes_of("in.mapbc", "out.mapbc"))
                    (self.folder / "out.mapbc").unlink()
                elif name != "in.vtu":  # which has no names
                    self.assertIn(b'"inflow"', meshes[-1])
                    self.assertIn(b'"the wall"', meshes[-1])
            self.assertEqual(meshes, meshes[:1] * len(meshes), f"{name} to {out}")

    def test_a_metric_of_another_mesh(self):
        self.box(3)
        self.box(7, "other.meshb")
        self.weft("metric", "other.meshb", "--metric-fn", "polar-1", "--complexity", 400, "-o", "other.solb")
        words = ("box.meshb", "--background", "other.meshb", "--metric", "other.solb", "--hgrad", 2, "--subdomains", 4)
        self.assert_in_shares(False, self.assert_same_on_all(*words, expect=(0, 1)))
        self.weft("verify", "out.meshb", "--against", "box.meshb")
        subdomains = self.figures("out")
        self.run_on(0, *words[:-2], "-o", "one.meshb", "--threads", 1, "--quiet", expect=(0, 1))
        one = self.figures("one")
        self.assertGreater(subdomains["edge_length"]["share_unit"], one["edge_length"]["share_unit"] - 0.03)
        self.assertLess(abs(subdomains["complexity"] / one["complexity"] - 1), 0.05)
        self.weft("convert", "other.meshb", "other.su2")
        done = self.run_on(2, *[word if word != "other.meshb" else "other.su2" for word in words], "-o", "su2.meshb", "--threads", 1,
                           expect=(0, 1))
        self.assertNotIn("rank 0 has read all of", done.stdout + done.stderr)
        self.assertEqual(*self.bytes_of("su2.meshb", "out.meshb"))
        self.assert_all_ranks_fail("box.meshb", "--background", "other.meshb", "--metric", "out.solb", "-o",
                                   "o.meshb", says="out.solb: metric of another mesh")

    def test_a_metric_of_a_mesh_that_does_not_cover_the_input(self):
        """The same words of one mesh, in subdomains and on ranks; none where it does."""
        self.box(4)
        self.weft("mesh", "box", "-o", "half.meshb", "--cells", 2, 4, 4, "--max", 0.5, 1, 1)
        self.weft("metric", "half.meshb", "--metric-fn", "uniform:0.3", "-o", "half.solb")
        words = ("box.meshb", "--background", "half.meshb", "--metric", "half.solb", "-o", "out.meshb")
        for ranks, *more in ((0,), (0, "--subdomains", 3), (2,), (3, "--repair")):
            told = self.run_on(ranks, *words, *more, expect=(0, 1)).stdout
            self.assertIn("warning: 50 of the input's 125 vertices lie outside the background, up to 0.5 from it: ", told)
        self.box(5, "whole.meshb")
        self.weft("metric", "whole.meshb", "--metric-fn", "uniform:0.3", "-o", "whole.solb")
        words = [word.replace("half", "whole") for word in words]
        for ranks in (0, 2):
            self.assertNotIn("outside", self.run_on(ranks, *words, expect=(0, 1)).stdout)

    def figures(self, name):
        done = self.weft("stat", f"{name}.meshb", "--metric", f"{name}.solb", "--json")
        return json.loads(done.stdout)["measures"]

    def test_a_mesh_and_its_metric_in_any_format(self):
        self.box(3)
        self.weft("metric", "box.meshb", "--metric-fn", "uniform:0.25", "-o", "m.solb")
        self.weft("convert", "box.meshb", "box.vtu", "--sol", "m.solb")
        words = ("--hmax", 0.22, "--subdomains", 3, "--threads", 1)
        self.run_on(0, "box.meshb", "--metric", "m.solb", *words, "-o", "gmf.meshb")
        done = self.run_on(2, "box.vtu", "--metric", "box.vtu", *words, "-o", "vtu.meshb")
        self.assert_in_shares(False, done)
        self.assertEqual(*self.bytes_of("gmf.meshb", "vtu.meshb"))
        self.weft("convert", "box.meshb", "box.pvtu", "--sol", "m.solb", "--pieces", 4, "--compress")
        for ranks in (0, 3):
            done = self.run_on(ranks, "box.pvtu", "--metric", "box.pvtu", *words, "-o", "pvtu.meshb")
            self.assert_in_shares(False, done)
            self.assertEqual(*self.bytes_of("gmf.meshb", "pvtu.meshb"))
        self.weft("convert", "box.meshb", "box.msh", "--sol", "m.solb")
        done = self.run_on(2, "box.vtu", "--metric", "box.msh", *words, "-o", "msh.meshb")
        self.assert_in_shares(False, done)
        self.assertEqual(*self.bytes_of("gmf.meshb", "msh.meshb"))

    def test_fields_of_the_input_that_are_left_behind_are_told(self):
        """In the same words on ranks; not the one that is the metric, and not those that are carried."""
        self.box()
        rows = "".join(f"0.5 {i} 0 1\n" for i in range(27))
        self.write("flow.sol", f"MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n27\n2 1 2\n{rows}End\n")
        for turn, name in enumerate(("box.vtu", "box.pvtu", "box.cgns", "box.msh")):
            self.weft("convert", "box.meshb", name, "--sol", "flow.sol")
            for ranks in (0, *some_of((2, 3), turn)):
                told = self.run_on(ranks, name, "--metric-fn", "uniform:0.5", "-o", "out.meshb", expect=(0, 1)).stdout
                self.assertIn(f"warning: fields field_1, field_2 of {name} are left behind: --field {name} carries them\n", told)
        told = self.run_on(0, "box.vtu", "--metric", "box.vtu", "-o", "out.vtu", expect=(0, 1)).stdout
        self.assertIn("warning: field field_2 of box.vtu is left behind: --field box.vtu carries it\n", told)
        for words in (("box.vtu", "--field", "box.vtu"), ("out.vtu",)):
            told = self.run_on(0, *words, "--metric-fn", "uniform:0.5", "-o", "fine.vtu", expect=(0, 1)).stdout
            self.assertNotIn("left behind", told)

    def test_pieces(self):
        self.box(3)
        self.run_on(2, "box.meshb", "--metric-fn", "uniform:0.25", "--subdomains", 4, "-o", "a.pvtu", "--quiet")
        self.assertIn("a.pvtu", self.files())
        self.weft("verify", "a.pvtu", "--against", "box.meshb")

    def test_carries_fields(self):
        self.weft("metric", self.box(3), "--metric-fn", "uniform:0.3", "-o", "field.solb")
        cases = (("linear", "out.meshb"), ("conservative", "out.vtu"), ("linear", "out.msh"), ("conservative", "out.meshb"), ("linear", "out.mesh"))
        for turn, (transfer, mesh) in enumerate(cases if LONG else cases[:3]):
            with self.subTest(transfer=transfer, mesh=mesh):
                sol = "sol" if mesh.endswith(".mesh") else "solb"
                self.assert_same_on_all("box.meshb", "--metric-fn", "uniform:0.25", "--field", "field.solb", "--subdomains", 4,
                                        "--transfer", transfer, outputs=(mesh, f"out.{sol}", f"out-fields.{sol}"),
                                        ranks=some_of((2, 3), turn))
        self.run_on(2, "box.meshb", "--metric-fn", "uniform:0.25", "--field", "field.solb", "-o", "a.pvtu", "--quiet")
        self.assertEqual(len(self.fields("a.pvtu")), 2)

    def fields(self, file):
        """The names of the point data of a .vtu or .pvtu, the ids aside."""
        text = (self.folder / file).read_bytes()
        part = text[text.index(b"PointData"):text.rindex(b"PointData")]
        return [name for name in re.findall(rb'Name="([^"]*)"', part) if b"Ids" not in name]

    def test_report(self):
        self.box(5)
        self.run_on(2, "box.meshb", "--metric-fn", "uniform:0.2", "--subdomains", 5, "-o", "out.meshb", "--report", "r",
                    "--quiet")
        report = json.loads((self.folder / "r/report.json").read_text())["subdomains"]
        self.assertEqual(set(report), SUBDOMAIN_KEYS)
        self.assertEqual((report["subdomains"], report["ranks"], report["layers"]), (5, 2, 2))
        self.assertEqual(report["engine"]["collective_calls"], 0)
        self.assertEqual(set(report["seconds_by_operation"]), OPERATIONS)
        self.assertEqual([rank["rank"] for rank in report["by_rank"]], [0, 1])
        for rank in report["by_rank"]:
            self.assertEqual(set(rank["seconds_by_operation"]), OPERATIONS)
        self.check_shifts(report["shifts"])
        lanes = json.loads((self.folder / "r/profile.json").read_text())["timeline"]["lanes"]
        self.assertEqual({lane["name"].split()[0] for lane in lanes}, {"worker"}, "which worker ran a task is known of all")
        self.assertGreater(report["former_interface"]["tets"], 0)

    def test_a_report_without_a_page_is_the_same_account(self):
        self.box(5)
        words = ("box.meshb", "--metric-fn", "uniform:0.2", "--subdomains", 5, "-o", "out.meshb", "--quiet")
        accounts = []
        for folder, more in (("full", ()), ("plain", ("--no-page",)), ("drawn", ("--no-page", "--graph", "g.json"))):
            self.run_on(2, *words, "--report", folder, *more)
            report = json.loads((self.folder / folder / "report.json").read_text())
            accounts.append({name: report[name].keys() if isinstance(report[name], dict) else None for name in report})
            self.assertEqual([rank["rank"] for rank in report["subdomains"]["by_rank"]], [0, 1])
        self.assertEqual(accounts, [accounts[0]] * 3)
        for folder in ("plain", "drawn"):
            self.assertEqual([path.name for path in (self.folder / folder).iterdir()], ["report.json"])
        self.weft("graph", "g.json", "-o", "g.svg")  # it is complete

    def test_the_input_is_measured_by_all_ranks_as_by_one(self):
        self.box(5)
        words = ("box.meshb", "--metric-fn", "polar-2", "--complexity", 300, "-o", "out.meshb", "--report", "r", "--quiet")

        def before():
            return json.loads((self.folder / "r/report.json").read_text())["before"]

        self.weft("adapt", *words, expect=(0, 1))
        expected = before()
        for ranks in (1, 3):
            self.run_on(ranks, *words, "--subdomains", 4, expect=(0, 1))
            self.assert_alike(before(), expected, f"on {ranks} ranks")

    def assert_alike(self, these, those, where):
        """But for rounding."""
        if isinstance(those, dict):
            self.assertEqual(set(these), set(those), where)
            for name in those:
                self.assert_alike(these[name], those[name], f"{name} {where}")
        elif isinstance(those, list):
            self.assertEqual(len(these), len(those), where)
            for i in range(len(those)):
                self.assert_alike(these[i], those[i], f"{i} of {where}")
        elif isinstance(those, float):
            self.assertAlmostEqual(these, those, delta=1e-9 * max(1, abs(those)), msg=where)
        else:
            self.assertEqual(these, those, where)

    def check_shifts(self, shifts):
        self.assertGreater(len(shifts), 0)
        for number, shift in enumerate(shifts, 1):
            self.assertEqual(set(shift), {"shift", "vertices_wanted", "tets_moved", "receivers", "vertices_freed"})
            self.assertEqual(shift["shift"], number)
        self.assertGreater(shifts[0]["tets_moved"], 0)

    def test_a_mesh_that_conforms_keeps_its_interface_where_nothing_is_wrong(self):
        words = ("--metric-fn", "uniform:0.07", "--subdomains", 6, "--threads", 1, "--report", "r")

        def moved():
            report = json.loads((self.folder / "r" / "report.json").read_text())["subdomains"]
            return sum(shift["tets_moved"] for shift in report["shifts"])

        self.run_on(2, self.box(6), *words, "-o", "first.meshb")
        first = moved()
        self.run_on(2, "first.meshb", *words, "-o", "second.meshb")
        self.assertLess(moved(), 0.2 * first)
        self.weft("verify", "second.meshb", "--against", "box.meshb")


class LookingOn(Subdomains):
    """What a run tells while it works."""

    def long_run(self, ranks, *words):
        """A run of some seconds that is under way; its lines on stderr come as they are written."""
        self.box(4)
        run = subprocess.Popen([*MPIRUN, "-n", str(ranks), str(WEFT), "adapt", "box.meshb", "--metric-fn", "uniform:0.025",
                                "--subdomains", "12", "--threads", "1", "-o", "out.meshb", *words], cwd=self.folder,
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(run.stdout.close), self.addCleanup(run.stderr.close), self.addCleanup(run.wait)
        self.addCleanup(run.kill)
        return run

    def check_progress(self, errors):
        """Of a run with `--progress plain`: its lines tell what is done and what is left."""
        lines = [line for line in errors.splitlines() if line.startswith("weft: ")]
        about = [line for line in lines if re.match(
            r"weft: (interior|shift \d+ of at most 12): \d+ of 12 subdomains( \(\d+ at rest\))?, "
            r"(time left unknown|this step about [\dmins ]+ more, (then shifts|all about [\dmins ]+ \(at most [\dmins ]+\)))"
            r"(, [\d,]+ tets?, remaining: [\d,]+ edges?, [\d,]+ poor tets?( in \d+ subdomains?)?)?, [\d.]+ s$", line)]
        self.assertTrue(about, errors)
        self.assertEqual(len(about), sum("subdomains" in line for line in lines), errors)
        self.assertTrue(any("remaining" in line for line in about), errors)
        for step, all_left, most in re.findall(r"about (\d+) s more, all about (\d+) s \(at most (\d+) s\)", errors):
            self.assertTrue(int(step) <= int(all_left) <= int(most), errors)

    def test_progress_changes_nothing(self):
        self.box(4)
        words = ("box.meshb", "--metric-fn", "uniform:0.1", "--subdomains", 6, "--threads", 1)
        self.run_on(0, *words, "-o", "out.meshb", "--quiet")
        quiet = self.bytes_of("out.meshb", "out.solb")
        for ranks in (0, 3):
            for form, says in (("plain", self.assertIn), ("none", self.assertNotIn)):
                done = self.run_on(ranks, *words, "-o", "out.meshb", "--progress", form)
                says("weft: reading", done.stderr)
                self.assertEqual(self.bytes_of("out.meshb", "out.solb"), quiet)
        self.assertEqual(done.stderr, "")

    def test_progress_tells_what_is_left_and_sigusr1_the_state_of_all_ranks_and_the_run_ends_well(self):
        """In long tests by itself, else by a signal once it has told what is left."""
        run = self.long_run(2, "--progress", "plain")
        before = ""
        for line in run.stderr:
            before += line
            if re.match("weft: (interior|shift)", line):  # the subdomains are at work
                break
        run.send_signal(signal.SIGUSR1)  # mpirun passes it on
        errors = ""
        for line in run.stderr if not LONG else ():
            errors += line
            if "remaining" in line and errors.count("weft: state of rank") == 2:
                run.send_signal(signal.SIGALRM)
                break
        errors += run.communicate(timeout=SECONDS)[1]
        self.assertIn(run.returncode, (0,) if LONG else (0, 1), errors)
        self.weft("verify", "out.meshb", "--against", "box.meshb")
        self.check_progress(before + re.sub(r"(?m)^(weft: state of rank|  ).*\n", "", errors))
        for rank in (0, 1):
            self.assertRegex(errors, rf"(?m)^weft: state of rank {rank} of 2, [\d.]+ s into the run$")
        self.assertEqual(len(re.findall(r"(?m)^  load: [01] of 1 workers busy", errors)), 2, errors)
        self.assertEqual(len(re.findall(r"(?m)^  messages: \d+ bytes to be sent", errors)), 2, errors)
        subdomains = set(map(int, re.findall(r"(?m)^  subdomain (\d+): ", errors)))
        self.assertGreaterEqual(len(subdomains), 10, errors)  # one may be on its way from rank to rank
        running = sum(map(int, re.findall(r"(?m) objects: (\d+) running,", errors)))  # none where a rank is at its start
        self.assertEqual(len(re.findall(r"(?m)^  [^:]+: runs \S[^,]* for [\d.]+ s$", errors)), running, errors)


class Failures(Subdomains):
    def test_options_that_make_no_sense(self):
        self.box(2)
        adapt = ("adapt", "box.meshb", "--metric-fn", "uniform:0.3", "-o", "out.meshb", "--subdomains", 4)
        for words, says in ((["--partitioner", "nonsense"], "nonsense"), (["--partitioner", "pqr:3x1x1"], "makes 3"),
                            (["--partitioner", "pqr:2x2"], "pqr:2x2"), (["--partitioner", "pqr:4x1x1:wall=x"], "'x' is not a reference"),
                            (["--partitioner", "pqr:4x1x1:harmonic=1"], "two different references"), (["--shifts", "x"], "--shifts"),
                            (["--shifts", "-1"], "--shifts"), (["--layers", "-1"], "--layers"),
                            (["--layers-by", "edges"], "--layers-by"), (["--equal", "parts"], "--equal"),
                            (["--balancer", "rotate"], "--balancer")):
            self.assert_fails(*adapt, *words, says=says, code=64)

    def test_damaged_input(self):
        whole = (self.folder / self.box(4)).read_bytes()
        (self.folder / "cut.meshb").write_bytes(whole[:3000])
        self.assert_all_ranks_fail("cut.meshb", "--metric-fn", "uniform:0.3", "-o", "out.meshb", says="cut.meshb: ")
        (self.folder / "late.meshb").write_bytes(whole[:-100])
        self.assert_all_ranks_fail("late.meshb", "--metric-fn", "uniform:0.3", "-o", "out.meshb", says="late.meshb: ")

    def test_an_inverted_tet(self):
        self.weft("convert", self.box(3), "box.mesh")
        lines = (self.folder / "box.mesh").read_text().splitlines()
        at = lines.index("Tetrahedra") + 80
        a, b, c, d, ref = lines[at].split()
        lines[at] = " ".join((b, a, c, d, ref))
        self.write("bad.mesh", "\n".join(lines) + "\n")
        self.assert_all_ranks_fail("bad.mesh", "--metric-fn", "uniform:0.3", "-o", "out.meshb", says="is inverted", ranks=3)

    def test_files_that_are_missing_or_of_another_mesh(self):
        self.weft("metric", self.box(3, "other.meshb"), "--metric-fn", "uniform:0.3", "-o", "other.solb")
        self.box(2)
        constant = ("box.meshb", "--metric-fn", "uniform:0.3", "-o", "out.meshb")
        self.assert_all_ranks_fail("none.meshb", *constant[1:], says="none.meshb")
        self.assert_all_ranks_fail("box.meshb", "--metric", "other.solb", "-o", "out.meshb", says="another mesh")
        self.assert_all_ranks_fail("box.meshb", "--metric", "none.solb", "-o", "out.meshb", says="none.solb")
        self.assert_all_ranks_fail(*constant, "--field", "other.solb", says="another mesh")
        self.assert_all_ranks_fail(*constant, "--field", "none.solb", says="none.solb")

    def test_outputs_that_cannot_be_written(self):
        self.box(2)
        self.assert_all_ranks_fail("box.meshb", "--metric-fn", "uniform:0.3", "-o", "none/out.meshb", says="none/out.meshb")
        self.assert_all_ranks_fail("box.meshb", "--metric-fn", "uniform:0.3", "-o", "out.meshb", "--report", "box.meshb/r",
                                   says="box.meshb/r")

    def test_outputs_that_would_replace_an_input(self):
        self.weft("metric", self.box(2), "--metric-fn", "uniform:0.3", "-o", "out.solb")
        before = self.files()
        done = self.run_on(2, "box.meshb", "--metric", "out.solb", "-o", "out.meshb", "--quiet", expect=64)
        self.assertIn("--out: its metric out.solb would replace the input out.solb", done.stderr)
        self.assertEqual(self.files(), before)


if __name__ == "__main__":
    unittest.main()
