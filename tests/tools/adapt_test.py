"""`weft adapt` from file to file: results, exit codes, the report, interruption."""

import json
import signal
import subprocess
import time
import unittest

from command import DATA, ONE_TET, ONE_TET_FACES, ONE_TET_POINTS, WEFT, CommandTest, mesh_text, solution_text, without_first_triangle

REPORT_KEYS = {
    "schema", "version", "arguments", "input", "output", "target_complexity", "asked_complexity", "predicted", "goal_met", "goals_missed",
    "left_as_is", "interrupted", "ended_by", "mends", "before", "after", "stages", "operations", "checkpoints", "subdomains", "fields", "surface_deviation", "surface_limit", "surface_demands", "hausd", "model",
    "seconds", "measure_input_seconds", "peak_memory_bytes", "threads", "warnings",
}


class Adapt(CommandTest):
    def adapt(self, mesh, *words, expect=0):
        return self.weft("adapt", mesh, "-o", "out.meshb", *words, expect=expect)

    def measures(self, mesh="out.meshb", metric="out.solb"):
        return json.loads(self.weft("stat", mesh, "--metric", metric, "--json").stdout)["measures"]

    def test_refines_a_box(self):
        text = self.adapt(self.box(), "--metric-fn", "uniform:0.1").stdout
        for word in ("GOAL MET", "before", "after", "out.meshb", "out.solb", "collapse", "peak memory"):
            self.assertIn(word, text)
        self.assertLessEqual(max(map(len, text.splitlines())), 100)
        self.weft("verify", "out.meshb", "--against", "box.meshb")
        self.assertGreater(self.measures()["edge_length"]["share_unit"], 0.8)
        self.assertEqual(self.files(), ["box.meshb", "out.meshb", "out.solb"])

    def test_says_where_the_surface_needs_short_edges(self):
        self.weft("mesh", "ball", "-o", "ball.meshb", "--size", "0.3")
        words = ("ball.meshb", "--metric-fn", "uniform:0.8", "--hausd", "0.01", "--report", "report")
        text = self.adapt(*words, "--no-surface-limit", expect=1).stdout
        self.assertRegex(text, r"edges of reference 1 stay short: the surface allows 0\.\d+ at \(")
        self.assertNotIn("made finer", text)
        self.assertLessEqual(max(map(len, text.splitlines())), 100)
        demand, = json.loads((self.folder / "report" / "report.json").read_text())["surface_demands"]
        self.assertEqual(demand["reference"], 1)
        self.assertGreater(demand["edges"], 10)
        self.assertAlmostEqual(sum(x * x for x in demand["where"]), 1, delta=0.05)
        text = self.adapt(*words, "--sagitta", "0.005", "--hgrad", "1.5").stdout
        self.assertNotIn("stay short", text)
        self.assertNotIn("made finer", text)

    def test_warns_where_the_boundary_is_farther_from_its_surface_than_allowed(self):
        """A ball of large triangles that may not be split."""
        self.weft("mesh", "ball", "-o", "ball.meshb", "--size", "0.4")
        words = ("ball.meshb", "--metric-fn", "uniform:0.4", "--hausd", "0.0005", "--no-insert", "--report", "report")
        for more in ((), ("--subdomains", "3")):
            with self.subTest(more):
                done = self.adapt(*words, *more, expect=(0, 1))
                self.assertRegex(done.stdout + done.stderr, r"farther than the 0.0005 that --hausd allows")
                report = json.loads((self.folder / "report" / "report.json").read_text())
                self.assertRegex("\n".join(report["warnings"]), r"is up to 0\.\d+ from its surface, farther")

    def test_keeps_the_boundary_near_its_surface_or_says_that_it_is_not(self):
        """Circles at which subdomains met were left with edges of twice the length that hausd allows."""
        for body, size in (("cylinder", "0.3"), ("ball", "0.3")):
            self.weft("mesh", body, "-o", "body.meshb", "--size", size)
            for complexity in ("200", "500"):
                for subdomains in ("1", "2", "3", "4", "6", "8", "12"):
                    with self.subTest(body=body, complexity=complexity, subdomains=subdomains):
                        self.adapt("body.meshb", "--metric-fn", "polar-2", "--complexity", complexity, "--subdomains",
                                   subdomains, "--threads", "1", "--report", "report", expect=(0, 1))
                        report = json.loads((self.folder / "report" / "report.json").read_text())
                        far = report["surface_deviation"] > 1.01 * report["hausd"]
                        self.assertEqual(far, "from its surface" in "\n".join(report["warnings"]), report["warnings"])

    def test_makes_the_metric_as_fine_as_a_curved_boundary_needs(self):
        self.weft("mesh", "ball", "-o", "ball.meshb", "--size", "0.15")
        words = ("ball.meshb", "--metric-fn", "uniform:0.4", "--complexity", "150", "--hausd", "0.01", "--report", "report")
        units = {}
        for option in ((), ("--no-surface-limit",)):
            text = self.adapt(*words, *option, expect=(0, 1)).stdout
            self.assertLessEqual(max(map(len, text.splitlines())), 100)
            self.assertAlmostEqual(self.measures()["complexity"] / 150, 1, delta=0.05)
            units[option] = self.measures()["edge_length"]["share_unit"]
            limit = json.loads((self.folder / "report" / "report.json").read_text())["surface_limit"]
            if option:
                self.assertIsNone(limit)
                continue
            self.assertRegex(text, r"metric made finer at \d+ vertices of curved boundary")
            self.assertGreater(limit["vertices"], 50)
            self.assertGreater(limit["longest"], 1.25)
            self.assertAlmostEqual(sum(x * x for x in limit["where"]), 1, delta=0.01)
        self.assertGreater(units[()], units[("--no-surface-limit",)] + 0.02)

    def test_coarsens_a_box(self):
        self.adapt(self.box(8), "--metric-fn", "uniform:0.5")
        self.weft("verify", "out.meshb", "--against", "box.meshb")
        self.assertLess(self.measures()["tets"], 500)

    def test_metric_from_a_file_scaled(self):
        self.weft("metric", self.box(4), "--metric-fn", "uniform:1", "-o", "m.solb")
        self.adapt("box.meshb", "--metric", "m.solb", "--complexity", 500)
        self.assertAlmostEqual(self.measures()["complexity"] / 500, 1, places=6)

    def test_options_of_subdomains_without_them_are_told(self):
        words = (self.box(), "--metric-fn", "uniform:0.5", "--report", "report", "--layers", 3, "--freeze", "tets", "--balancer", "stealing",
                 "--shifts", "auto")
        told = ["--layers has no effect without --subdomains", "--freeze has no effect without --subdomains"]
        text = self.adapt(*words).stdout
        self.assertEqual([line.removeprefix("warning: ") for line in text.splitlines() if "no effect" in line], told)
        self.assertEqual(json.loads((self.folder / "report/report.json").read_text())["warnings"], told)
        for asked in (("--subdomains", 2), ("--partitioner", "bisection")):
            self.assertNotIn("no effect", self.adapt(*words, *asked, expect=(0, 1)).stdout)

    def test_the_peers_words(self):
        self.weft("metric", self.box(), "--metric-fn", "uniform:0.3", "-out", "m.solb")
        self.weft("adapt", "-in", "box.meshb", "-met", "m.solb", "-out", "a.meshb", "-hgrad", "-1", "-hmin", "0.1", "-hmax",
                  "0.5", "-hausd", "0.01", "-ar", "40")
        self.weft("adapt", "box.meshb", "-sol", "m.solb", "-x", "b.meshb", "-hgrad", "1.5")
        self.assertIn("a.solb", self.files())
        self.assertIn("b.solb", self.files())

    def test_text_and_vtu_results(self):
        mesh = self.box()
        self.weft("adapt", mesh, "--metric-fn", "uniform:0.4", "-o", "a.mesh")
        self.weft("adapt", mesh, "--metric-fn", "uniform:0.4", "-o", "b.vtu")
        self.assertEqual(self.files(), ["a.mesh", "a.sol", "b.solb", "b.vtu", "box.meshb"])
        self.weft("verify", "a.mesh", "--against", mesh)

    def test_in_place(self):
        self.weft("metric", self.box(), "--metric-fn", "uniform:0.4", "-o", "box.solb")
        self.weft("adapt", "box.meshb", "--metric", "box.solb", "-o", "box.meshb")
        self.assertEqual(self.files(), ["box.meshb", "box.solb"])
        self.weft("stat", "box.meshb", "--metric", "box.solb")

    def test_metric_of_a_background_mesh(self):
        self.weft("metric", self.box(5, "background.meshb"), "--metric-fn", "uniform:0.25", "-o", "background.solb")
        text = self.adapt(self.box(2), "--background", "background.meshb", "--metric", "background.solb").stdout
        self.assertIn("GOAL MET", text)
        self.weft("verify", "out.meshb", "--against", "box.meshb")

    def test_quiet_prints_nothing(self):
        done = self.adapt(self.box(), "--metric-fn", "uniform:0.4", "--quiet")
        self.assertEqual(done.stdout + done.stderr, "")

    def test_progress_in_plain_lines(self):
        done = self.adapt(self.box(), "--metric-fn", "uniform:0.4")
        self.assertRegex(done.stderr, r"^weft: reading ")
        self.assertNotIn("\r", done.stderr)
        self.assertEqual(self.adapt("box.meshb", "--metric-fn", "uniform:0.4", "--progress", "none").stderr, "")

    def test_same_bytes_twice_with_one_thread(self):
        mesh = self.box(4)
        for name in ("a.meshb", "b.meshb"):
            self.weft("adapt", mesh, "--metric-fn", "polar-2", "--complexity", 300, "-o", name, "--threads", 1,
                      expect=(0, 1))
        self.assertEqual((self.folder / "a.meshb").read_bytes(), (self.folder / "b.meshb").read_bytes())

    def test_more_threads_than_cores(self):
        self.adapt(self.box(4), "--metric-fn", "uniform:0.1", "--threads", 64)
        self.weft("verify", "out.meshb", "--against", "box.meshb")

    def test_one_tet(self):
        self.write("a.mesh", ONE_TET)
        self.adapt("a.mesh", "--metric-fn", "uniform:1.2")
        self.weft("verify", "out.meshb", "--against", "a.mesh")
        self.adapt("a.mesh", "--metric-fn", "uniform:0.2")
        self.weft("verify", "out.meshb", "--against", "a.mesh")

    def test_sizes_far_beyond_the_mesh_miss_the_goal(self):
        done = self.adapt(self.box(), "--metric-fn", "uniform:1e6", expect=1)
        self.assertIn("GOAL NOT MET", done.stdout)
        self.weft("verify", "out.meshb", "--against", "box.meshb")

    def finished(self):
        """A mesh that fits its metric, of some 20,000 tets; a field at its vertices."""
        self.adapt(self.box(), "--metric-fn", "uniform:0.08", "--threads", 1)
        self.weft("metric", "out.meshb", "--metric-fn", "polar-2", "-o", "field.solb")
        return self.measures()

    def adapt_again(self, *words, mesh="out.meshb"):
        done = self.weft("adapt", mesh, "--metric", "out.solb", "-o", "again.meshb", "--report", "r", *words)
        return done, json.loads((self.folder / "r/report.json").read_text())

    def test_a_finished_mesh_is_left_as_it_is(self):
        first = self.finished()
        self.assertGreater(first["tets"], 16384)
        for transfer in ("linear", "conservative"):
            done, report = self.adapt_again("--field", "field.solb", "--transfer", transfer)
            self.assertIn("the mesh fits its metric: left as it is", done.stdout)
            for old, new in (("out.meshb", "again.meshb"), ("out.solb", "again.solb"), ("field.solb", "again-fields.solb")):
                self.assertEqual((self.folder / old).read_bytes(), (self.folder / new).read_bytes(), new)
            self.assertEqual(report["before"], report["after"])
            self.assertEqual(report["after"]["tets"], first["tets"])
            self.assertLess(report["left_as_is"]["share_long"], 0.01)
            self.assertEqual({c["back_difference_max"] for c in report["fields"]["components"]}, {0})
            self.assertIn("was left as it is", (self.folder / "r/report.html").read_text())

    def test_a_finished_mesh_is_adapted_by_force(self):
        first = self.finished()
        done, report = self.adapt_again("--force")
        self.assertIsNone(report["left_as_is"])
        self.assertNotIn("left as it is", done.stdout)
        self.assertAlmostEqual(report["after"]["tets"] / first["tets"], 1, delta=0.05)

    def test_a_nearly_finished_mesh_is_adapted(self):
        first = self.finished()
        done, report = self.adapt_again("--complexity", 1.2 * first["complexity"])
        self.assertIsNone(report["left_as_is"])
        self.assertNotIn("left as it is", done.stdout)
        self.assertGreater(report["after"]["tets"], first["tets"])
        self.assertGreater(report["operations"]["split"]["done"], 0)

    def test_a_finished_mesh_whose_boundary_lacks_a_triangle_is_completed(self):
        self.finished()
        self.weft("convert", "out.meshb", "out.mesh")
        self.write("less.mesh", without_first_triangle((self.folder / "out.mesh").read_text()))
        done, report = self.adapt_again(mesh="less.mesh")
        self.assertIn("boundary or interface triangles were missing", done.stdout)
        self.assertIsNone(report["left_as_is"])

    def test_missing_boundary_triangles_are_made_with_a_warning(self):
        self.write("a.mesh", mesh_text(ONE_TET_POINTS, [(1, 2, 3, 4)], ONE_TET_FACES[:3]))
        done = self.adapt("a.mesh", "--metric-fn", "uniform:1.2")
        self.assertIn("warning", done.stdout)
        self.weft("verify", "out.meshb")

    def test_the_delta_wing(self):
        mesh = DATA / "delta-wing-coarse.meshb"
        self.weft("adapt", mesh, "--metric-fn", "uniform:1", "-o", "wing.meshb")
        self.weft("verify", "wing.meshb", "--against", mesh)


class Report(CommandTest):
    def test_without_a_page_is_one_file(self):
        words = ("adapt", self.box(), "--metric-fn", "uniform:0.3", "-o", "out.meshb", "--threads", 1, "--no-page")
        self.weft(*words, "--report", "report")
        report = self.folder / "report"
        self.assertEqual([file.name for file in report.iterdir()], ["report.json"])
        self.assertEqual(set(json.loads((report / "report.json").read_text())), REPORT_KEYS)
        self.assert_fails(*words, says="--report", code=64)
        self.assert_fails(*words, "--report", "report", "--case", "cube-polar2-50000", says="--no-page", code=64)

    def test_holds_everything(self):
        self.box()
        self.weft("adapt", "box.meshb", "--metric-fn", "uniform:0.3", "-o", "out.meshb", "--report", "new/report",
                  "--threads", 1)
        path = self.folder / "new/report/report.json"
        self.assertEqual(sorted(file.name for file in path.parent.iterdir()), ["profile.json", "report.html", "report.json"])
        report = json.loads(path.read_text())
        self.assertEqual(set(report), REPORT_KEYS)
        self.assertEqual(report["schema"], "weft-report-1")
        self.assertEqual(report["arguments"][:2], ["adapt", "box.meshb"])
        self.assertNotIn(str(self.folder), path.read_text())
        self.assertEqual(report["input"]["tets"], 48)
        self.assertEqual(report["output"]["tets"], report["after"]["tets"])
        self.assertIs(report["goal_met"], True)
        self.check_measures(report["before"])
        self.check_measures(report["after"])
        self.check_operations(report)

    def test_may_have_graph_and_timeline_in_its_folder(self):
        files = ("new/report/g.json", "new/report/t.json")
        self.weft("adapt", self.box(), "--metric-fn", "uniform:0.4", "--subdomains", 2, "-o", "out.meshb", "--report", "new/report",
                  "--graph", files[0], "--trace", files[1], expect=(0, 1))
        for name in files:
            json.loads((self.folder / name).read_text())

    def check_measures(self, measures):
        for name, count in (("quality", "tets"), ("edge_length", "edges")):
            for histogram in (measures[name]["histogram"], measures[name]["histogram_log"]):
                total = sum(histogram["counts"]) + histogram["below"] + histogram["above"]
                self.assertEqual(total, measures[count])

    def check_operations(self, report):
        self.assertGreater(report["operations"]["split"]["done"], 0)
        for operation in report["operations"].values():
            parts = operation["done"] + operation["rolled_back"] + sum(operation["refused"].values())
            self.assertEqual(operation["tried"], parts)
        self.assertLessEqual(report["seconds"]["adapt"], report["seconds"]["total"])
        self.assertGreater(report["measure_input_seconds"], 0)
        self.assertLess(report["measure_input_seconds"], report["seconds"]["measure"])
        self.assertGreater(report["peak_memory_bytes"], 1e6)

    def test_has_no_measures_before_when_the_metric_is_another_mesh(self):
        self.weft("metric", self.box(3, "background.meshb"), "--metric-fn", "uniform:0.4", "-o", "m.solb")
        self.weft("adapt", self.box(), "--background", "background.meshb", "--metric", "m.solb", "-o", "out.meshb",
                  "--report", "r")
        self.assertIsNone(json.loads((self.folder / "r/report.json").read_text())["before"])

    def test_of_a_name_that_is_no_text_is_made_too(self):
        name = b"fl\xfcgel.meshb".decode("utf-8", "surrogateescape")  # Latin-1
        self.box(2)
        for subdomains in ([], ["--subdomains", 2]):
            self.weft("adapt", "box.meshb", "--metric-fn", "uniform:0.4", *subdomains, "-o", name, "--report", "r", "--quiet")
            json.loads((self.folder / "r/report.json").read_text())

    def test_tells_the_complexity_that_was_asked_for_even_where_limits_keep_it_away(self):
        self.box(4)
        for subdomains in ([], ["--subdomains", 2]):
            self.weft("adapt", "box.meshb", "--metric-fn", "uniform:0.3", "--complexity", 500, "--hmin", 0.3, *subdomains,
                      "-o", "out.meshb", "--report", "r", expect=1)
            report = json.loads((self.folder / "r/report.json").read_text())
            self.assertEqual((report["asked_complexity"], report["target_complexity"]), (500, 500), subdomains)

    def test_is_not_refused_for_a_complexity_that_limits_keep_away(self):
        self.box(4)
        for subdomains in ([], ["--subdomains", 2]):
            self.weft("adapt", "box.meshb", "--metric-fn", "uniform:0.3", "--complexity", "1e11", "--hmin", 0.3, *subdomains,
                      "-o", "out.meshb", expect=1)


class Interrupt(CommandTest):
    def interrupted(self, number):
        """Sends a signal in the midst of a long adaptation; returns the exit code and what was printed."""
        process = self.long_adaptation()
        process.send_signal(number)
        out, _ = process.communicate(timeout=120)
        return process.returncode, out

    def long_adaptation(self):
        self.box(8)
        command = [str(WEFT), "adapt", "box.meshb", "--metric-fn", "polar-2", "--complexity", "400000", "-o", "out.meshb",
                   "--report", "r", "--progress", "plain"]
        process = subprocess.Popen(command, cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(process.kill)
        process.stderr.readline()  # the first stage has begun: signals are caught
        time.sleep(1.5)
        return process

    def test_sigusr1_asks_for_a_line_and_ends_nothing(self):
        process = self.long_adaptation()
        process.send_signal(signal.SIGUSR1)
        time.sleep(1)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=120)
        self.assertEqual(process.returncode, 1, errors)
        self.assertRegex(errors, r"weft: .* %, [\d,]+ tets, ")

    def test_ends_with_a_valid_mesh_and_code_1(self):
        for number in (signal.SIGINT, signal.SIGTERM):
            code, out = self.interrupted(number)
            self.assertEqual(code, 1, out)
            self.assertIn("interrupted", out)
            self.weft("verify", "out.meshb", "--against", "box.meshb")
            self.assertIs(json.loads((self.folder / "r/report.json").read_text())["interrupted"], True)
            self.assertEqual(self.files(), ["box.meshb", "out.meshb", "out.solb", "r"])


if __name__ == "__main__":
    unittest.main()
