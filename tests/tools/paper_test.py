"""The parts of scripts/paper.py and scripts/scaling.py that compute, and the interface shift that is found by place."""

import json
import pathlib
import sys
import types
import unittest
import xml.etree.ElementTree

from command import WEFT, CommandTest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent.parent / "scripts"))

import drawing  # noqa: E402
import interface_shift  # noqa: E402
import paper  # noqa: E402
import published  # noqa: E402
import scaling  # noqa: E402


def histogram(counts, below=0, above=0):
    return {"lo": 0.0, "hi": 1.0, "logarithmic": False, "counts": counts, "below": below, "above": above}


class Histograms(unittest.TestCase):
    def test_interior_and_interface_make_the_whole(self):
        whole, interface = histogram([4, 6, 10], 1, 2), histogram([1, 6, 3], 0, 2)
        interior = paper.without(whole, interface)
        self.assertEqual((interior["below"], interior["counts"], interior["above"]), (1, [3, 0, 7], 0))
        self.assertEqual(paper.size_of(whole), paper.size_of(interior) + paper.size_of(interface))

    def test_a_part_has_no_more_than_the_whole(self):
        with self.assertRaises(ValueError):
            paper.without(histogram([4, 6]), histogram([5, 0]))
        with self.assertRaises(ValueError):
            paper.without(histogram([4, 6]), histogram([0, 0], above=1))

    def test_the_area_under_a_density_is_the_share_of_values_in_its_bins(self):
        points = paper.density(histogram([3, 5], above=2))
        self.assertEqual([x for x, _ in points], [0.25, 0.75])
        self.assertAlmostEqual(sum(y * 0.5 for _, y in points), 0.8)
        logarithmic = {**histogram([1, 1]), "logarithmic": True}
        self.assertAlmostEqual(paper.density(logarithmic)[0][1] * (10 ** 0.5 - 1), 0.5)
        self.assertEqual(paper.density(histogram([0, 0])), [])

    def test_the_difference_is_the_share_that_would_have_to_move(self):
        self.assertEqual(paper.difference(histogram([2, 2]), histogram([30, 30])), 0)
        self.assertEqual(paper.difference(histogram([1, 0]), histogram([0, 1])), 1)
        self.assertEqual(paper.difference(histogram([3, 1]), histogram([2, 2])), 0.25)
        self.assertEqual(paper.difference(histogram([1, 0]), histogram([1, 0], above=1)), 0.5)

    def test_published_curves_are_cut_at_the_largest_value(self):
        for case in ("cube-polar2-500000", "delta-wing-500000"):
            curves = published.histogram_curves(case, "edge_length", 4)
            self.assertIn("CDT3D, 1 core", curves)
            for points, _, _ in curves.values():
                self.assertLess(max(x for x, _ in points), 4)
        self.assertEqual(published.histogram_curves(None, "edge_length", 4), {})


class Times(unittest.TestCase):
    SECONDS = {"interior adaptation": 6.0, "MII adaptation": 2.0, "gather": 1.0, "idle": 10.0, "communication": 1.0}

    def test_percentages_are_of_the_busy_time(self):
        self.assertEqual(paper.percentages(self.SECONDS), {"interior adaptation": 60, "MII adaptation": 20, "gather": 10, "communication": 10})

    def test_the_communication_thread_is_not_a_worker(self):
        self.assertAlmostEqual(paper.idle_share(self.SECONDS), 10 / 19)

    def test_cores_to_measure_are_powers_of_two_and_all(self):
        self.assertEqual([paper.cores_to_measure(n) for n in (1, 2, 6, 16)], [[1], [1, 2], [1, 2, 4, 6], [1, 2, 4, 8, 16]])


class Recorded:
    """In place of weft: as many subdomains as are asked for."""

    def __init__(self, subdomains):
        self.subdomains, self.copies = subdomains, []

    def say(self, text):
        pass

    def replay(self, _, ranks, __, *words):
        words = list(words)
        self.copies.append(words[words.index("--copies") + 1])
        return {"seconds": 2.0, "work_seconds": 1.0 * ranks, "subdomains": self.subdomains * self.copies[-1]}


class WeakScaling(unittest.TestCase):
    def options(self, **more):
        return types.SimpleNamespace(**{"a_core": 8, "subdomains": 64, "weak": [1, 4, 8, 12, 16, 64], "threads": [1], "grow": 1, "balancer": "stealing", **more})

    def test_all_rows_have_as_many_subdomains_a_core_as_the_title_says(self):
        book, options = Recorded(64), self.options()
        rows = scaling.weak(book, options)
        self.assertEqual([row["cores"] for row in rows], [8, 16, 64] * 2)
        self.assertEqual({row["subdomains"] / row["cores"] for row in rows}, {8})
        self.assertEqual(book.copies, [1, 2, 8] * 2)
        self.assertIn("1, 4, 12 cores", scaling.left_out_of_weak(options)[0])

    def test_nothing_is_left_out_where_all_fit(self):
        self.assertEqual(scaling.left_out_of_weak(self.options(weak=[8, 16])), [])

    def test_another_recording_is_refused(self):
        with self.assertRaises(SystemExit):
            scaling.weak(Recorded(32), self.options())


class Drawing(unittest.TestCase):
    def test_plots_are_valid_xml_and_leave_out_what_has_no_logarithm(self):
        text = drawing.plot("a < b", "x", "y", {"one": ([(1, 0), (10, 2), (100, 5)], True, True)}, log_x=True, log_y=True)
        picture = xml.etree.ElementTree.fromstring(text)
        self.assertEqual(len(picture.findall(".//{http://www.w3.org/2000/svg}circle")), 2)
        self.assertEqual(drawing.plot("empty", "x", "y", {"none": ([], False, False)}), "")

    def test_bars_are_as_long_as_their_shares(self):
        picture = xml.etree.ElementTree.fromstring(drawing.shares("shares", ["a", "b"], {"one": {"a": 1, "b": 3}, "two": {"a": 0, "b": 0}}))
        widths = [float(bar.get("width")) for bar in picture.iter("{http://www.w3.org/2000/svg}rect")]
        self.assertAlmostEqual(widths[1] / widths[0], 3, delta=0.01)
        self.assertEqual(widths[2:], [0, 0])


class InterfaceShift(CommandTest):
    def test_tets_change_sides_by_the_field_and_stay_where_they_only_touch_the_interface(self):
        sides = [0, 0, 0, 1e-17, 1, -0.5]
        tets = [(0, 1, 2, 3), (0, 1, 2, 4), (0, 1, 2, 5)]
        self.assertEqual(interface_shift.subdomains_after(tets, [1, 0, 1], sides), [1, 1, 0])
        self.assertEqual(interface_shift.subdomains_after(tets, [0, 1, 0], sides), [0, 1, 0])

    def test_what_is_handed_over_is_found_by_its_place(self):
        options = types.SimpleNamespace(weft=WEFT, out=self.folder, times="wall", start=None, complexity=1000)
        book = paper.Book(options)
        book.call("mesh", "delta-wing", "--size", 0.1, "-o", "wing-start.meshb", "--quiet")
        found, body = interface_shift.sequence(book, paper.Case("wing", "wing-start.meshb", ["--implied"], 4000))
        self.assertEqual(body.count("<img"), 6)
        before, after = (interface_shift.Pieces(book, f"shift-{name}") for name in ("before", "after"))
        self.assertEqual(set(after.sides()), {-1, 0, 1})
        self.assertEqual(interface_shift.after_shift(book, after, after), after.subdomains)  # in its own mesh all stay
        handed = sum(a != b for a, b in zip(before.subdomains, interface_shift.after_shift(book, before, after)))
        shift, = json.loads((self.folder / "shift-after/report.json").read_text())["subdomains"]["shifts"]
        self.assertIn(f"{shift['tets_moved']:,} tets ({handed:,} of", found)
        self.assertGreater(handed, 100)
        self.assertAlmostEqual(handed / shift["tets_moved"], 1, delta=0.1)


if __name__ == "__main__":
    unittest.main()
