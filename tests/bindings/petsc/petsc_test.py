"""-dm_adaptor weft in a program on PETSc that does not know it (adapt_plex.c), on 1, 2 and 4 ranks."""

import os
import re
import subprocess
import unittest

PROGRAM = os.environ["WEFT_ADAPT_PLEX"]
ADAPTOR = os.environ["WEFT_PETSC_LIBRARY"]
MPIRUN = os.environ["WEFT_MPIRUN"].split(";")
SECONDS = 300
LONG = bool(os.environ.get("WEFT_LONG_TESTS"))


class Told:
    """What the program said of one mesh."""

    def __init__(self, text):
        counts = re.search(r"mesh: (\d+) vertices, (\d+) edges, (\d+) faces, (\d+) cells", text)
        self.vertices, self.edges, self.faces, self.cells = map(int, counts.groups())
        self.volume = float(re.search(r"volume: ([0-9.]+), least positive", text)[1])
        self.fewest, self.most = map(int, re.search(r"cells of a rank: (\d+) to (\d+)", text).groups())
        self.labels = {(name, int(value)): (int(count), float(size)) for name, value, count, size
                       in re.findall(r"label (.+) (\d+): (\d+) of ([0-9.]+)", text)}
        self.values = [values.split() for values in re.findall(r"values on rank \d+:(.*)", text)]
        self.differ = re.findall(r"shared vertices differ by (\S+)", text)


def run(ranks, *options):
    adaptor = ("-dll_append", ADAPTOR, "-dm_adaptor", "weft", "-weft_subdomains", "4")
    done = subprocess.run([*MPIRUN, "-n", str(ranks), PROGRAM, *adaptor, *options],
                          capture_output=True, text=True, timeout=SECONDS)
    return done.returncode, done.stdout + done.stderr


def adapted(ranks, *options):
    """The meshes before and after each adaptation."""
    code, text = run(ranks, *options)
    if code != 0:
        raise AssertionError(text)
    return [Told(part) for part in text.split("adapted:\n")]


def issue(ranks, *options):
    code, text = run(ranks, *options)
    if code == 0:
        raise AssertionError(f"no error: {text}")
    return text


class Adaptor(unittest.TestCase):
    def check(self, ranks, *options):
        """The last mesh, of which all must hold that holds for any."""
        *_, before, after = adapted(ranks, "-checks", *options)
        self.assertAlmostEqual(after.volume, 1, 9)
        self.assertEqual(after.vertices - after.edges + after.faces - after.cells, 1, "Euler's formula for a ball")
        self.assertLessEqual(after.most - after.fewest, 1)
        self.assertEqual(after.differ, ["0."])
        return before, after

    def test_a_cube_is_refined_in_a_layer_and_its_boundary_label_is_kept(self):
        cells = []
        for ranks in (1, 2, 4) if LONG else (1, 4):
            with self.subTest(ranks=ranks):
                before, after = self.check(ranks, "-metric", "layer", "-bd", "marker")
                self.assertGreater(after.cells, 5 * before.cells)
                self.assertAlmostEqual(after.labels["marker", 1][1], 6, 7)
                cells.append(after.cells)
        self.assertLess(max(cells) / min(cells), 1.1)

    def test_sides_regions_and_the_faces_between_them_are_kept(self):
        for ranks in (1, 2, 4) if LONG else (2,):
            with self.subTest(ranks=ranks):
                before, after = self.check(ranks, "-metric", "layer", "-bd", "Face Sets", "-regions")
                self.assertEqual(set(before.labels), set(after.labels))
                for side in (1, 2, 3, 4, 5, 6, 42):
                    self.assertAlmostEqual(after.labels["Face Sets", side][1], 1, 7)
                for region in (7, 9):
                    self.assertAlmostEqual(after.labels["Regions", region][1], 0.5, 7)

    def test_regions_without_a_label_of_the_boundary_are_kept(self):
        before, after = self.check(2, "-regions")
        self.assertAlmostEqual(after.labels["Regions", 7][1], 0.5, 7)

    def test_uniform_isotropic_and_tensor_metrics_of_one_size_give_meshes_of_one_size(self):
        cells = [self.check(2, "-metric", metric, "-h", "0.15")[1].cells for metric in ("uniform", "isotropic", "parts")]
        self.assertLess(max(cells) / min(cells), 1.1)

    def test_cells_of_an_overlap_are_taken_once(self):
        self.check(4, "-overlap", "1", "-bd", "Face Sets", "-metric", "layer")

    def test_a_result_can_be_adapted_again(self):
        _, first, second = adapted(2, "-rounds", "2", "-bd", "marker", "-h", "0.12")
        self.assertLess(abs(second.cells / first.cells - 1), 0.15)
        self.assertAlmostEqual(second.labels["marker", 1][1], 6, 7)

    def test_ranks_without_cells(self):
        before, after = self.check(3, "-distribute", "0", "-bd", "marker")
        self.assertEqual(before.fewest, 0)
        self.assertGreater(after.fewest, 0)

    def test_no_surf_leaves_the_boundary_as_it_is(self):
        before, after = self.check(2, "-dm_plex_metric_no_surf", "-bd", "marker", "-h", "0.1")
        self.assertEqual(before.labels["marker", 1], after.labels["marker", 1])
        self.assertGreater(after.vertices, 5 * before.vertices)

    def test_the_gradation_factor_makes_sizes_grow_slowly(self):
        free, graded = (self.check(1, "-metric", "layer", "-h", "0.4", *options)[1].cells
                        for options in ((), ("-dm_plex_metric_gradation_factor", "1.1")))
        self.assertGreater(graded, 1.2 * free)

    def test_the_number_of_iterations_and_the_hausdorff_number_are_taken(self):
        code, text = run(2, "-metric", "layer", "-dm_plex_metric_num_iterations", "1", "-info", ":dm")
        self.assertEqual(code, 0)
        self.assertIn("by its limit of 1 shift", text)
        self.assertIn("--hausd", issue(1, "-dm_plex_metric_hausdorff_number", "inf"))

    def test_every_rank_has_all_values_of_a_label_in_one_order(self):
        # Slabs: ranks between have no faces of some sides.
        before, after = self.check(4, "-bd", "Face Sets", "-values", "-petscpartitioner_type", "simple")
        self.assertGreater(len(set(map(tuple, before.values))), 1)
        self.assertEqual(len(after.values), 4)
        self.assertEqual(len(set(map(tuple, after.values))), 1, after.values)
        self.assertEqual(sorted(after.values[0]), list("123456"))

    def test_a_face_keeps_all_values_of_a_label_that_any_rank_gives_it(self):
        # In slabs across z. Of 40 values there are sets in two words, and a set with its only value in the second.
        for ranks, last in ((1, 2), (2, 2), (4, 2), (2, 40)) if LONG else ((4, 2), (2, 40)):
            with self.subTest(ranks=ranks, last=last):
                before, after = self.check(ranks, "-bd", "marks", "-marked", str(last), "-values",
                                           "-petscpartitioner_type", "simple")
                values = [str(value) for value in range(1, last + 1)]
                self.assertEqual([sorted(of_rank, key=int) for of_rank in after.values], [values] * ranks)
                self.assertAlmostEqual(after.labels["marks", last][1], 6 + ranks - 1, 7)
                for value in range(1, last):
                    self.assertAlmostEqual(after.labels["marks", value][1], 1, 7)

    def test_no_insert_keeps_all_vertices(self):
        code, text = run(2, "-metric", "layer", "-dm_plex_metric_no_insert", "-checks", "-dm_plex_metric_verbosity", "1")
        self.assertEqual(code, 0, text)
        before, after = (Told(part) for part in text.split("adapted:\n"))
        self.assertEqual(before.vertices, after.vertices)
        self.assertEqual(after.differ, ["0."])
        self.assertRegex(text, r"swap_edge +[0-9,]+ +[1-9]")  # done

    def test_no_swap_and_no_move_are_taken(self):
        free = self.check(1, "-metric", "layer")[1]
        for option in ("no_swap", "no_move"):
            self.assertNotEqual(self.check(1, "-metric", "layer", f"-dm_plex_metric_{option}")[1].cells, free.cells)

    def test_verbosity_prints_the_summary(self):
        self.assertNotIn("unit edges", run(2)[1])
        self.assertIn("unit edges", run(2, "-dm_plex_metric_verbosity", "1")[1])

    def test_with_as_many_subdomains_and_threads_a_run_can_be_repeated(self):
        # PETSc's default partitioner, which deals the cells at first, works with threads: its parts differ now and then.
        simple = ("-petscpartitioner_type", "simple")
        self.assertEqual(*(run(2, "-metric", "layer", "-weft_threads", "1", *simple) for _ in range(2)))

    def test_what_weft_cannot_do_is_refused(self):
        self.assertIn("dimension 2 in 2", issue(1, "-cells", "0", "-dm_plex_dim", "2", "-dm_plex_simplex", "0"))
        self.assertIn("is a hexahedron: all must be tetrahedra",
                      issue(2, "-cells", "0", "-dm_plex_dim", "3", "-dm_plex_simplex", "0"))

    def test_a_metric_that_is_none_is_named_on_all_ranks(self):
        self.assertRegex(issue(2, "-metric", "negative"), r"weft: rank 0: .*vertex \d+")
        self.assertIn("must be a local vector as of DMPlexMetricCreate()", issue(2, "-metric", "global"))


if __name__ == "__main__":
    unittest.main()
