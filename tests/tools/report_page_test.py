"""The report in a browser: every view opens, shows the figures of the JSON, complains of nothing and asks for nothing."""

import json
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

from browser import Browser

LONG = bool(os.environ.get("WEFT_LONG_TESTS"))
WRITE_SAMPLE = os.environ["WEFT_WRITE_SAMPLE"]
WEFT = os.environ["WEFT"]


class Sample:
    """A simulated run and its page, in a folder that lives as long as the tests."""

    def __init__(self, subdomains, ranks, workers, rounds, cells):
        self.folder = tempfile.TemporaryDirectory(prefix="weft-report-test-")
        self.path = pathlib.Path(self.folder.name)
        words = [subdomains, ranks, workers, rounds, 1, cells]
        subprocess.run([WRITE_SAMPLE, self.path, *map(str, words)], check=True, timeout=120)
        self.profile = json.loads((self.path / "profile.json").read_text())
        self.page = self.path / "report.html"


def number(text):
    """The number that a text begins with, its unit taken off: "1.25 MB", "12 min 05 s", "88.4 %"."""
    minutes = re.match(r"(\d+) min (\d+) s", text)
    if minutes:
        return 60.0 * int(minutes[1]) + int(minutes[2])
    value, unit = re.match(r"([-\d.,e]+)\s*(\S*)", text).groups()
    factor = {"ms": 1e-3, "µs": 1e-6, "%": 1e-2, "kB": 1e3, "MB": 1e6, "GB": 1e9}.get(unit, 1)
    return float(value.replace(",", "")) * factor


class PageTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        """One browser and one run for all classes: each test opens the page anew."""
        if "browser" not in vars(PageTest):
            PageTest.sample, PageTest.browser = Sample(24, 4, 2, 4, 8), Browser()
            PageTest.profile = cls.sample.profile
            unittest.addModuleCleanup(cls.browser.close)
            unittest.addModuleCleanup(cls.sample.folder.cleanup)

    def setUp(self):
        self.browser.console.clear(), self.browser.requests.clear()
        self.browser.open(self.sample.page)

    def tearDown(self):
        self.assertEqual(self.browser.console, [])
        self.assertEqual([r for r in self.browser.requests if not r.startswith(("file:", "data:"))], [])
        self.assertEqual(sum(r.startswith("file:") for r in self.browser.requests), 1)

    def tabs(self):
        return self.browser.run("[...document.querySelectorAll('[role=tab]')].map(t => t.id.slice(4))")

    def show(self, view):
        self.browser.run(f"document.getElementById('tab-{view}').click()")
        self.browser.settle()

    def choose(self, value):
        count = self.browser.run(f"""(() => {{
            const all = [...document.querySelectorAll('section:not([hidden]) [data-choice="{value}"]')];
            all.forEach(b => b.click());
            return all.length; }})()""")
        self.assertGreater(count, 0, value)
        self.browser.settle()

    def figure(self, name):
        text = self.browser.run(f"""document.querySelector('section:not([hidden]) [data-figure="{name}"]')?.textContent""")
        self.assertIsNotNone(text, name)
        return text

    def assert_shows(self, name, value, digits=3):
        shown = number(self.figure(name))
        self.assertAlmostEqual(shown, value, delta=max(abs(value) * 0.6 * 10 ** (1 - digits), 5e-9), msg=name)


class Views(PageTest):
    def test_all_views_are_there_and_not_empty(self):
        self.assertEqual(self.tabs(), ["summary", "time", "timeline", "communication", "quality", "convergence", "graph",
                                       "mesh", "details"])
        for view in self.tabs():
            self.show(view)
            visible = self.browser.run("[...document.querySelectorAll('main > section')].filter(s => !s.hidden).map(s => s.id)")
            self.assertEqual(visible, ["view-" + view])
            self.assertGreater(self.browser.run(f"document.getElementById('view-{view}').getBoundingClientRect().height"), 150)

    def test_a_link_opens_the_tab_that_it_names(self):
        """In the words of the tab, when the page is opened and later; other places of the page are no tabs."""
        selected = "document.querySelector('[aria-selected=true]').textContent"
        for title in self.browser.run("[...document.querySelectorAll('[role=tab]')].map(t => t.textContent)"):
            self.browser.run(f"location.hash = '{title.lower()}'")
            self.browser.settle()
            self.assertEqual(self.browser.run(selected), title)
        self.browser.run("location.hash = 'content'")
        self.browser.settle()
        self.assertEqual(self.browser.run(selected), "Details")
        self.browser.requests.clear()
        self.browser.call("Page.navigate", url="about:blank")
        self.browser.settle()
        self.browser.open(self.sample.page, "time")
        self.assertEqual(self.browser.run(selected), "Time")

    def test_everything_that_can_be_clicked_may_be_clicked(self):
        for view in self.tabs():
            self.show(view)
            clicked = self.browser.run("""(() => {
                const all = document.querySelectorAll('section:not([hidden]) button, section:not([hidden]) input[type=checkbox]');
                for (const b of all) b.click();
                return all.length; })()""")
            self.browser.settle()
            self.show(view)  # a button of the graph leads to the timeline
            self.assertTrue(clicked > 0 or view in ("summary", "convergence", "details"), view)

    def test_summary_has_the_figures_of_the_profile(self):
        report, engine = self.profile["report"], self.profile["engine"]
        self.assert_shows("seconds.total", report["seconds"]["total"])
        self.assertEqual(number(self.figure("output.tets")), report["output"]["tets"])
        self.assert_shows("after.quality.mean", report["after"]["quality"]["mean"])
        self.assert_shows("after.edge_length.share_unit", report["after"]["edge_length"]["share_unit"])
        self.assert_shows("bytes_sent", sum(t["sent"]["bytes"] for t in engine["traffic"].values()))
        self.assert_shows("critical_path.seconds", self.profile["critical_path"]["seconds"])
        self.assertIn("Goal met", self.browser.run("document.querySelector('.verdict').textContent"))
        self.assertIn(engine["verdict"], self.browser.run("document.body.innerText"))

    def test_seconds_are_fewer_than_a_minute(self):
        shown = self.browser.run("[120, 179.4, 179.7, 3599.6].map((s) => weft.seconds(s))")
        self.assertEqual(shown, ["2 min 00 s", "2 min 59 s", "3 min 00 s", "60 min 00 s"])

    def test_markup_in_names_stays_text(self):
        self.assertIn("<b>markup</b> & </script>", self.browser.run("document.getElementById('view-summary').innerText"))

    def test_times_of_all_operations_and_ranks_are_shown(self):
        self.show("time")
        for name in self.profile["operations"]:
            self.assert_shows(f"total.seconds.{name}", self.profile["total"]["seconds"][name], digits=2)
            for rank in self.profile["ranks"]:
                self.assert_shows(f"rank.{rank['rank']}.{name}", rank["seconds"][name], digits=2)

    def test_convergence_counts_what_the_nodes_counted(self):
        self.show("convergence")
        for entry in self.profile["convergence"]:
            for name, value in entry["counters"].items():
                self.assert_shows(f"round.{entry['round']}.{name}", value)

    def test_convergence_shows_what_is_wrong_after_each_step(self):
        self.show("convergence")
        self.assertGreater(len(self.profile["left"]), 2)
        for entry in self.profile["left"]:
            for part in ("interior", "interface"):
                for name, value in entry[part].items():
                    self.assert_shows(f"left.{entry['step']}.{part}.{name}", value)

    def test_published_histograms_and_means_are_beside_ones_own(self):
        self.show("quality")
        labels = self.browser.run("weft.charts.filter(c => c.canvas.closest('#view-quality')).map(c => c.chart.data.datasets.map(d => d.label))")
        self.assertEqual(len(labels), 2)
        for program in ("CDT3D", "refine", "feflo.a"):
            for chart in labels:
                self.assertTrue(any(label.startswith(program + ", ") for label in chart), (program, chart))
        self.assertTrue(any(label.startswith("mean of Mmg") for label in labels[0]), labels[0])
        # A curve is as high as the histogram would be: its share in a bin adds up to all tets.
        drawn = self.browser.run("weft.charts.find(c => c.canvas.closest('#view-quality')).chart.data.datasets.find(d => d.label === 'refine, 1 core').data")
        curve = next(c for c in self.profile["published_curves"] if (c["program"], c["cores"], c["measure"]) == ("refine", 1, "mean_ratio"))
        widths = [b - a for a, b in zip(curve["edges"], curve["edges"][1:])]
        bins = len(self.profile["report"]["after"]["quality"]["histogram"]["counts"])
        self.assertAlmostEqual(sum(p["y"] * w * bins for p, w in zip(drawn, widths)), 100, delta=0.5)

    def test_page_holds_the_document(self):
        self.assertEqual(self.browser.run("weft.data"), self.profile)

    def test_quality_before_and_after(self):
        self.show("quality")
        for when in ("before", "after"):
            quality = self.profile["report"][when]["quality"]
            self.assert_shows(f"{when}.quality.mean", quality["mean"])
            self.assert_shows(f"{when}.quality.min", quality["min"])
        for scale in ("log", "linear"):
            self.choose(scale)

    def test_details_tell_operators_and_collectives(self):
        self.show("details")
        for name, counts in self.profile["report"]["operations"].items():
            self.assertEqual(number(self.figure(f"operations.{name}.tried")), counts["tried"])
            self.assertEqual(number(self.figure(f"operations.{name}.done")), counts["done"])
        self.assertIn(": 0", self.figure("collective_calls"))



class Replayed(PageTest):
    """The page of a replay is of the simulated run, and of no mesh."""

    def setUp(self):
        super().setUp()
        self.folder = self.sample.path / "on-64"
        if not self.folder.exists():
            words = ["replay", self.sample.path / "graph.json", "--ranks", "64", "--copies", "2", "--report", self.folder, "--quiet"]
            subprocess.run([WEFT, *words], check=True, timeout=120)
        self.simulation = json.loads((self.folder / "profile.json").read_text())["simulation"]
        self.browser.requests.clear()
        self.browser.open(self.folder / "report.html")

    def test_it_is_marked_as_simulated(self):
        verdict = self.browser.run("document.querySelector('.verdict').textContent")
        self.assertIn("Simulated, not measured: ", verdict)
        self.assertIn(" on 64 ranks of 1 thread", verdict)
        self.assertIn("with 2 times the mesh", verdict)
        self.assertIn("simulated on 64 ranks", self.browser.run("document.getElementById('what').textContent"))

    def test_its_figures_are_those_of_the_simulation(self):
        self.assert_shows("simulation.seconds", self.simulation["seconds"])
        self.assert_shows("simulation.efficiency", self.simulation["efficiency"], digits=2)
        self.assertEqual(number(self.figure("simulation.subdomains")), 48)
        self.assert_shows("simulation.memory", self.simulation["subdomain_bytes"] * self.simulation["most_subdomains"])

    def test_views_without_a_mesh_are_not_empty(self):
        self.assertEqual(self.tabs(), ["summary", "time", "timeline", "communication", "convergence", "graph", "details"])
        for view in self.tabs():
            self.show(view)
            self.assertGreater(self.browser.run(f"document.getElementById('view-{view}').getBoundingClientRect().height"), 150)
            self.assertNotRegex(self.browser.run(f"document.getElementById('view-{view}').innerText"), "undefined|NaN|null")


class Timeline(PageTest):
    def setUp(self):
        super().setUp()
        self.show("timeline")
        self.place = self.browser.run("(({left, top, width, height}) => ({left, top, width, height}))(document.getElementById('timeline').getBoundingClientRect())")

    def visible(self):
        self.browser.settle()
        return self.browser.run("Number(document.getElementById('timeline').dataset.visible)")

    def selected(self):
        return self.browser.run("Number(document.getElementById('timeline').dataset.selected)")

    def test_shows_every_task_and_fewer_when_zoomed(self):
        runs = len(self.profile["graph"]["runs"]["node"])
        self.assertEqual(self.visible(), runs)
        x, y = self.place["left"] + self.place["width"] / 2, self.place["top"] + self.place["height"] / 2
        for _ in range(8):
            self.browser.mouse("mouseWheel", x, y, deltaX=0, deltaY=-300)
        self.assertLess(self.visible(), runs / 2)
        self.browser.run("document.getElementById('timeline').focus()")
        self.browser.key("Home")
        self.assertEqual(self.visible(), runs)

    def test_critical_path_can_be_followed_with_the_keyboard(self):
        path = self.profile["graph"]["critical_path"]["runs"]
        self.browser.run("document.getElementById('timeline').focus()")
        for run in path[:5]:
            self.browser.key("n")
            self.assertEqual(self.selected(), run)
        self.browser.key("p")
        self.assertEqual(self.selected(), path[3])
        self.browser.run("document.getElementById('only-critical').click()")
        self.browser.key("Home")
        self.assertEqual(self.visible(), len(path))

    def test_a_task_tells_what_it_waited_for(self):
        graph = self.profile["graph"]
        path = graph["critical_path"]["runs"]
        self.browser.run(f"weft.selectRun({path[-1]})")
        self.browser.settle()
        self.browser.settle()
        text = self.browser.run("document.getElementById('task').innerText")
        self.assertIn(graph["graph"]["nodes"][graph["runs"]["node"][path[-1]]]["name"], text)
        senders = graph["uses"]["to"].count(path[-1])
        self.assertIn(f"Got values from ({senders})", text)

    def test_a_click_chooses_the_task_under_it(self):
        self.browser.run("document.getElementById('timeline').focus()")
        self.browser.key("n"), self.browser.key("n"), self.browser.key("n"), self.browser.key("Escape")
        self.assertEqual(self.selected(), -1)
        found = set()
        for step in range(1, 14):
            self.browser.click(self.place["left"] + 100 + step * (self.place["width"] - 100) / 14, self.place["top"] + 38)
            found.add(self.selected())
        rank0 = {r for r, rank in enumerate(self.profile["graph"]["runs"]["rank"]) if rank == 0}
        self.assertTrue(found - {-1})
        self.assertLessEqual(found - {-1}, rank0)


class Others(PageTest):
    def test_graph_can_be_clicked(self):
        self.show("graph")
        graph = self.profile["graph"]
        for node, description in enumerate(graph["graph"]["nodes"]):
            self.browser.run(f"""document.querySelector('[data-node="{node}"]').dispatchEvent(new MouseEvent('click'))""")
            text = self.browser.run("document.getElementById('graph-details').innerText")
            self.assertIn(description["name"], text)
            self.assertIn(f"{graph['runs']['node'].count(node):,}", text)
        self.choose("rounds")
        groups = len(set(zip(graph["runs"]["round"], graph["runs"]["node"])))
        self.assertEqual(self.browser.run("document.querySelectorAll('#graph-drawing .box').length"), groups)
        self.choose("subdomains")
        self.assertEqual(self.browser.run("document.querySelectorAll('#graph-drawing .box').length"), len(graph["instances"]))
        self.browser.run("""document.querySelector('[data-subdomain="5"]').dispatchEvent(new MouseEvent('click'))""")
        self.assertIn("Subdomain 5", self.browser.run("document.getElementById('graph-details').innerText"))

    def test_mesh_is_drawn_cut_and_coloured(self):
        self.show("mesh")
        self.browser.settle()
        layers = self.profile["mesh"]["layers"]

        def pixels():
            """How many pixels differ from the ground, and a sum that tells pictures apart."""
            self.browser.settle()
            return self.browser.run("""(() => {
                const gl = document.getElementById('mesh-canvas'), c = document.createElement('canvas');
                c.width = gl.width; c.height = gl.height;
                const d = c.getContext('2d'); d.drawImage(gl, 0, 0);
                const p = d.getImageData(0, 0, c.width, c.height).data; let n = 0, sum = 0;
                for (let i = 0; i < p.length; i += 4) if (p[i] !== p[0] || p[i + 1] !== p[1]) { ++n; sum += p[i] + 3 * p[i + 1] + 7 * p[i + 2]; }
                return [n, sum]; })()""")

        whole = pixels()
        self.assertGreater(whole[0], 10000)
        facets = lambda: self.browser.run("Number(document.getElementById('mesh-canvas').dataset.facets)")
        self.assertEqual(facets(), layers[0]["facets"])
        pictures = {tuple(whole)}
        for colouring in ("length", "conforming", "subdomain", "plain"):
            self.choose(colouring)
            pictures.add(tuple(pixels()))
        self.assertEqual(len(pictures), 5)
        self.assertEqual(self.browser.run("document.querySelectorAll('[data-choice=deviation]').length"), 0)  # there is no model
        self.choose("1")
        section = [layer for layer in layers if layer["axis"] == 1]
        self.assertEqual(facets(), layers[0]["facets"] + section[len(section) // 2]["facets"])
        self.assertLess(pixels()[0], whole[0])
        self.browser.run("document.getElementById('mesh-canvas').focus()")
        before = pixels()
        self.browser.key("ArrowLeft")
        self.assertNotEqual(pixels(), before)

    def test_tabs_work_with_the_keyboard(self):
        self.browser.run("document.querySelector('[role=tab]').focus()")
        self.browser.key("ArrowRight")
        self.assertEqual(self.browser.run("document.querySelector('[aria-selected=true]').id"), "tab-time")
        self.browser.key("4")
        self.assertEqual(self.browser.run("document.querySelector('[aria-selected=true]').id"), "tab-communication")
        self.browser.key("d")
        self.assertEqual(self.browser.run("document.documentElement.dataset.theme"), "dark")


class Sizes(unittest.TestCase):
    def browse(self, sample, dark=False):
        browser = Browser(dark=dark)
        self.addCleanup(browser.close)
        self.addCleanup(sample.folder.cleanup)
        browser.open(sample.page)
        for view in browser.run("[...document.querySelectorAll('[role=tab]')].map(t => t.id.slice(4))"):
            browser.run(f"document.getElementById('tab-{view}').click()")
            browser.settle()
        self.assertEqual(browser.console, [])
        return browser

    def test_page_of_128_subdomains_is_small_enough_to_send(self):
        sample = Sample(128, 16, 2, 8, 20 if LONG else 12)
        self.assertLess(sample.page.stat().st_size, 10e6 if LONG else 5e6)
        browser = self.browse(sample, dark=True)
        self.assertEqual(browser.run("document.documentElement.dataset.theme"), "dark")

    def test_256_ranks_and_many_tasks_are_added_up(self):
        tasks = 100000 if LONG else 25000
        sample = Sample(tasks * 24 // 1000, 256, 4 if LONG else 1, 8, 6)  # of 1,024 rows 300 are seen at once
        self.assertGreater(len(sample.profile["graph"]["runs"]["node"]), tasks)
        self.assertLess(sample.page.stat().st_size, 10e6 if LONG else 5e6)
        browser = self.browse(sample)
        browser.run("document.getElementById('tab-timeline').click()")
        browser.settle()
        self.assertIn("added up by pixel", browser.run("document.getElementById('timeline-status').textContent"))


class Changed(unittest.TestCase):
    """Pages of what the sample is not."""

    @classmethod
    def setUpClass(cls):
        cls.sample, cls.browser = Sample(8, 2, 2, 2, 5), Browser()
        cls.addClassCleanup(cls.sample.folder.cleanup)
        cls.addClassCleanup(cls.browser.close)

    def summary(self, engine=None, **of_report):
        """The text of the first view, where report and engine say so."""
        sample = self.sample.profile
        self.open(sample | {"report": sample["report"] | of_report, "engine": sample["engine"] | (engine or {})})
        return self.browser.run("document.getElementById('view-summary').innerText")

    def open(self, profile):
        (self.sample.path / "changed.json").write_text(json.dumps(profile))
        subprocess.run([WEFT, "report", "changed.json", "-o", "changed.html"], cwd=self.sample.path, check=True, timeout=60)
        self.browser.console.clear()
        self.browser.open(self.sample.path / "changed.html")

    def test_a_limit_is_no_interruption_by_the_user(self):
        limited = self.summary(goal_met=False, interrupted=True, ended_by="time limit", goals_missed=["ended by its time limit"])
        self.assertIn("ended by its time limit", limited)
        self.assertNotIn("by the user", limited)
        self.assertIn("by the user", self.summary(goal_met=False, interrupted=True, ended_by="interrupted"))

    def test_simulated_ranks_have_the_memory_of_their_process(self):
        text = self.summary(engine={"peak_rss": {"sum": 0, "max": 0}}, peak_memory_bytes=123_000_000)
        self.assertIn("123 MB", text)
        self.assertNotIn("on a rank", text)


    def test_tasks_on_ranks_without_rows_have_their_details(self):
        profile = json.loads(json.dumps(self.sample.profile))
        timeline, runs = profile["timeline"], profile["graph"]["runs"]
        timeline["lanes"] = [lane for lane in timeline["lanes"] if lane["rank"] == 0]
        timeline["of_run"] = [None if rank else lane for rank, lane in zip(runs["rank"], timeline["of_run"])]
        self.open(profile)
        browser = self.browser
        browser.run("document.getElementById('tab-timeline').click()")
        browser.settle()
        self.assertIn("of 1 of 2 ranks", browser.run("document.getElementById('timeline-status').textContent"))
        self.assertEqual(browser.run("Number(document.getElementById('timeline').dataset.visible)"), runs["rank"].count(0))
        browser.run("document.getElementById('only-critical').click()")
        browser.run("document.getElementById('timeline').focus()")
        for _ in profile["graph"]["critical_path"]["runs"]:
            browser.key("n")
        for rank, where in ((0, "rank 0, worker"), (1, "rank 1, which has no row")):
            browser.run(f"weft.selectRun({runs['rank'].index(rank)})")
            browser.settle()
            browser.settle()
            self.assertIn(where, browser.run("document.getElementById('task').innerText"))
        self.assertEqual(browser.console, [])


class Comparison(unittest.TestCase):
    def test_page_of_a_comparison_shows_both(self):
        one, other = Sample(8, 2, 2, 2, 5), Sample(8, 2, 2, 4, 5)
        for sample in (one, other):
            self.addCleanup(sample.folder.cleanup)
        page = one.path / "compared.html"
        subprocess.run([WEFT, "report", one.path / "profile.json", other.path / "profile.json", "-o", page], check=True,
                       capture_output=True, timeout=60)
        browser = Browser()
        self.addCleanup(browser.close)
        browser.open(page)
        self.assertEqual(browser.console, [])
        for name, sample in (("A", one), ("B", other)):
            shown = number(browser.run(f"""document.querySelector('[data-figure="{name}.seconds"]').textContent"""))
            self.assertAlmostEqual(shown, sample.profile["report"]["seconds"]["adapt"], delta=0.01 * shown)
        text = browser.run("document.body.innerText")
        self.assertIn("MII adaptation", text)
        self.assertIn("slower", text)


if __name__ == "__main__":
    unittest.main()
