"""`weft graph` and `weft report`, and the documents they read, as other programs see them."""

import json
import os
import pathlib
import subprocess
import sys
import time
import unittest
import xml.etree.ElementTree as xml

import jsonschema
from command import CommandTest

WRITE_SAMPLE = os.environ["WEFT_WRITE_SAMPLE"]
SOURCES = pathlib.Path(os.environ["WEFT_SOURCES"])
GRAPHML = "{http://graphml.graphdrawing.org/xmlns}"


def schema(path):
    return json.loads((SOURCES / path).read_text())


class SampleTest(CommandTest):
    def sample(self, name=".", subdomains=9, rounds=3):
        folder = self.folder / name
        folder.mkdir(exist_ok=True)
        subprocess.run([WRITE_SAMPLE, folder, str(subdomains), "3", "2", str(rounds), "7", "4"], check=True, timeout=60)
        return json.loads((folder / "profile.json").read_text())

    def graph(self, *words):
        return self.weft("graph", "graph.json", *words).stdout


class Schemas(SampleTest):
    def test_documents_obey_their_schemas(self):
        profile = self.sample()
        jsonschema.validate(profile, schema("tools/report/weft-profile-1.schema.json"))
        for words in ([], ["--round", 1], ["--subdomain", 4], ["--critical-path"]):
            jsonschema.validate(json.loads(self.graph("--format", "json", *words)), schema("graph/weft-graph-1.schema.json"))
        self.assertEqual(json.loads((self.folder / "graph.json").read_text()), json.loads(self.graph("--format", "json")))

    def test_schemas_refuse_what_is_wrong(self):
        profile = self.sample()
        for document, path in ((profile, "tools/report/weft-profile-1.schema.json"), (profile["graph"], "graph/weft-graph-1.schema.json")):
            for key in document:
                broken = dict(document)
                del broken[key]
                with self.assertRaises(jsonschema.ValidationError, msg=key):
                    jsonschema.validate(broken, schema(path))

    def test_examples_in_the_readmes_obey_the_schemas(self):
        for readme, path in (("graph/dataflow/dump/README.md", "graph/weft-graph-1.schema.json"), ("tools/report/README.md", "tools/report/weft-profile-1.schema.json")):
            text = (SOURCES / readme).read_text()
            example = text.split("```json\n", 1)[1].split("```", 1)[0]
            jsonschema.validate(json.loads(example), schema(path))

    def test_sums_are_consistent(self):
        profile = self.sample(subdomains=17, rounds=4)
        for rank in profile["ranks"]:
            available = rank["workers"] * rank["wall"]
            self.assertAlmostEqual(sum(rank["seconds"].values()), available, delta=0.01 * available)
        for name in profile["operations"]:
            self.assertAlmostEqual(sum(r["seconds"][name] for r in profile["ranks"]), profile["total"]["seconds"][name], places=9)
        sent = sum(t["sent"]["bytes"] for t in profile["engine"]["traffic"].values())
        self.assertEqual(sent, sum(profile["messages"]["bytes"]))
        remote = [i for i, e in enumerate(profile["graph"]["graph"]["edges"]) if e["kind"] == "remote"]
        uses = profile["graph"]["uses"]
        self.assertEqual(sent, sum(b for e, b in zip(uses["edge"], uses["bytes"]) if e in remote))
        self.assertLessEqual(profile["critical_path"]["seconds"], profile["critical_path"]["wall"])
        parts = profile["critical_path"]["by_operation"]
        self.assertAlmostEqual(sum(p["seconds"] for p in parts), profile["critical_path"]["seconds"], places=9)


class Graphs(SampleTest):
    def dot(self, text):
        """What Graphviz makes of a graph, as JSON."""
        done = subprocess.run(["dot", "-Tjson0"], input=text, capture_output=True, text=True, timeout=100)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertNotRegex(done.stderr, "(?i)error")
        return json.loads(done.stdout)

    def test_graphviz_takes_the_dot_files(self):
        runs = self.sample()["graph"]["runs"]
        whole = self.dot(self.graph())
        boxes = [o for o in whole["objects"] if not o["name"].startswith("cluster")]
        self.assertEqual(len(boxes), len(runs["node"]))
        self.assertEqual(sum(o["name"].startswith("cluster") for o in whole["objects"]), 3)
        self.assertEqual(sum(o["name"].startswith("round") for o in self.dot(self.graph("--collapse", "rounds"))["objects"]),
                         len(set(zip(runs["round"], runs["node"]))))
        self.assertEqual(sum(o["name"].startswith("instance") for o in self.dot(self.graph("--collapse", "subdomains"))["objects"]), 9)
        self.assertEqual(len(self.dot(self.graph("--plan"))["objects"]), 10)

    def test_filters_leave_what_they_say(self):
        graph = self.sample()["graph"]
        runs = graph["runs"]
        left = json.loads(self.graph("--format", "json", "--round", 1, "--subdomain", 4))["runs"]
        wanted = [i for i, r in enumerate(runs["round"]) if r == 1 and graph["instances"][runs["instance"][i]]["number"] == 4]
        self.assertEqual(left["begin_ns"], [runs["begin_ns"][i] for i in wanted])
        self.assertGreater(len(wanted), 0)
        path = json.loads(self.graph("--format", "json", "--critical-path"))
        self.assertEqual(len(path["runs"]["node"]), len(graph["critical_path"]["runs"]))

    def test_the_plan_as_json_is_that_of_no_run(self):
        graph = self.sample()["graph"]
        plan = json.loads(self.graph("--plan", "--format", "json"))
        jsonschema.validate(plan, schema("graph/weft-graph-1.schema.json"))
        self.assertEqual((plan["graph"], len(plan["instances"])), (graph["graph"], len(graph["instances"])))
        self.assertEqual((plan["runs"]["node"], plan["uses"]["edge"], plan["network"]["edge"]), ([], [], []))

    def test_filters_that_would_do_nothing_are_refused(self):
        self.sample()
        for words in (["--round", 1], ["--subdomain", 4], ["--critical-path"], ["--collapse", "rounds"]):
            self.assert_fails("graph", "graph.json", "--plan", *words, says="--plan", code=64)
        self.assert_fails("graph", "graph.json", "--collapse", "rounds", "-o", "rounds.json", says="--collapse", code=64)

    def test_the_recording_is_not_replaced(self):
        self.sample()
        before = (self.folder / "graph.json").read_bytes()
        for words in (["-o", "graph.json"], ["-o", "./graph.json", "--format", "dot"]):
            self.assert_fails("graph", "graph.json", *words, says="--out: it would replace the input graph.json", code=64)
        self.assertEqual((self.folder / "graph.json").read_bytes(), before)

    def test_graphml_is_xml_with_every_edge_between_nodes(self):
        uses = self.sample()["graph"]["uses"]
        root = xml.fromstring(self.graph("--format", "graphml"))
        ids = {node.get("id") for node in root.iter(GRAPHML + "node")}
        edges = list(root.iter(GRAPHML + "edge"))
        self.assertGreaterEqual(len(edges), len(uses["to"]))
        for edge in edges:
            self.assertIn(edge.get("source"), ids)
            self.assertIn(edge.get("target"), ids)

    def test_the_network_of_many_subdomains_is_drawn_in_time(self):
        """In layers Graphviz had not finished it after ten minutes."""
        self.sample(subdomains=128, rounds=6)
        begin = time.monotonic()
        self.weft("graph", "graph.json", "--collapse", "subdomains", "-o", "network.svg")
        self.assertLess(time.monotonic() - begin, 60)
        text = "".join(xml.parse(self.folder / "network.svg").getroot().itertext())
        for subdomain in (0, 64, 127):
            self.assertIn(f"subdomain {subdomain}", text)

    def test_svg_is_drawn_by_graphviz(self):
        self.sample()
        self.weft("graph", "profile.json", "--collapse", "rounds", "-o", "rounds.svg")
        root = xml.fromstring((self.folder / "rounds.svg").read_text())
        self.assertTrue(root.tag.endswith("svg"))
        self.assertIn("adapt interior", "".join(root.itertext()))

    def test_what_cannot_be_done_is_said(self):
        self.sample()
        self.assert_fails("graph", "graph.json", "--subdomain", 99, says=["graph.json", "no subdomain 99"])
        self.write("other.json", '{"schema": "weft-report-1"}')
        self.assert_fails("graph", "other.json", says=["other.json", "weft-report-1"])
        self.write("broken.json", "{")
        self.assert_fails("graph", "broken.json", says=["broken.json", "no JSON"])
        self.write("odd.json", '{"schema": {"vertices": 14}}')
        self.assert_fails("graph", "odd.json", says=["odd.json", "schema"])
        self.assert_fails("report", "odd.json", "-o", "page.html", says=["odd.json", "weft-profile-1"])
        self.assert_fails("graph", "missing.json", says="missing.json")
        profile = json.loads((self.folder / "profile.json").read_text())
        self.write("thinned.json", json.dumps(profile | {"uses_left_out": 12}))
        for command in ("graph", "replay"):
            self.assert_fails(command, "thinned.json", says=["thinned.json", "lacks 12 messages", "graph.json"])
        self.assert_fails("graph", "graph.json", "-o", "graph.xyz", says="graph.xyz", code=64)
        self.assert_fails("graph", "graph.json", "-o", "no/folder/g.dot", says="no/folder/g.dot")


class Replays(SampleTest):
    def replay(self, name, *words):
        self.weft("replay", "graph.json", "--report", name, *words)
        return json.loads((self.folder / name / "replay.json").read_text())

    def profile(self, name):
        return json.loads((self.folder / name / "profile.json").read_text())

    def account(self, *words):
        self.weft("replay", "graph.json", "--account", "account.json", *words)
        return json.loads((self.folder / "account.json").read_text())

    def test_more_ranks_take_less_time_for_the_same_work(self):
        self.sample(subdomains=24, rounds=4)
        one, six = self.replay("one"), self.replay("six", "--ranks", 6)
        self.assertEqual(one["work_seconds"], six["work_seconds"])
        self.assertLess(six["seconds"], one["seconds"])
        self.assertGreaterEqual(six["seconds"], six["critical_path_seconds"] * 0.999)
        self.assertEqual(len(six["memory_by_rank"]), 6)
        self.assertTrue(six["engine"]["consistent"]["pairs"])
        self.assertEqual([rank["rank"] for rank in six["engine"]["per_rank"]], list(range(6)))
        self.assertFalse(any(rank["peers"] for rank in six["engine"]["per_rank"]), "as many as pairs of ranks")

    def test_its_account_obeys_its_schema(self):
        self.sample()
        account, rules = self.replay("on-3", "--ranks", 3), schema("graph/replay/weft-replay-1.schema.json")
        jsonschema.validate(account, rules)
        for key in account:
            broken = dict(account)
            del broken[key]
            with self.assertRaises(jsonschema.ValidationError, msg=key):
                jsonschema.validate(broken, rules)

    def test_profile_and_page_are_of_the_simulated_run(self):
        """Whatever lies beside the recording; the numbers of its mesh are not those of a machine that made none."""
        recording = self.sample(subdomains=24, rounds=4)
        account = self.replay("on-64", "--ranks", 64, "--copies", 2)
        profile = self.profile("on-64")
        jsonschema.validate(profile, schema("tools/report/weft-profile-1.schema.json"))
        simulation = profile["simulation"]
        self.assertEqual(simulation, {key: value for key, value in account.items() if key not in ("schema", "memory_by_rank", "engine")})
        self.assertEqual((simulation["ranks"], simulation["subdomains"], len(profile["graph"]["instances"])), (64, 48, 48))
        self.assertEqual((profile["report"], profile["mesh"], profile["memory"], profile["hardware"]), (None, None, [], []))
        self.assertAlmostEqual(profile["critical_path"]["wall"], simulation["seconds"])
        self.assertAlmostEqual(profile["total"]["wall"], simulation["run_seconds"])
        self.assertEqual([rank["peak_memory"] for rank in profile["ranks"]], account["memory_by_rank"])
        self.assertNotEqual(simulation["seconds"], recording["report"]["seconds"]["adapt"])
        (self.folder / "profile.json").unlink()
        self.replay("without", "--ranks", 64, "--copies", 2, "--subdomain-bytes", simulation["subdomain_bytes"])
        self.assertEqual(self.profile("without")["total"], profile["total"])
        self.assertTrue((self.folder / "without/report.html").exists())

    def test_simulated_times_are_compared(self):
        self.sample("a", subdomains=24, rounds=4)
        seconds = {}
        for ranks in (2, 24):
            self.weft("replay", "a/graph.json", "--ranks", ranks, "--report", f"on-{ranks}")
            seconds[ranks] = json.loads((self.folder / f"on-{ranks}/replay.json").read_text())["seconds"]
        self.weft("report", "on-2/profile.json", "on-24/profile.json", "-o", "compared.html")
        text = self.weft("report", "on-2/profile.json", "on-24/profile.json").stdout
        self.assertIn(f"B is {100 * (1 - seconds[24] / seconds[2]):.0f} % faster than A", text.splitlines()[0])
        self.assertIn("Both runs are simulated", text)
        self.assertIn("24 ranks, 24 workers, 24 subdomains, simulated: a replay of a/graph.json", text)
        mixed = self.weft("report", "a/profile.json", "on-2/profile.json").stdout
        self.assertIn("B is simulated", mixed)
        self.box(3)
        self.weft("adapt", "box.meshb", "--metric-fn", "uniform:0.4", "-o", "out.meshb", "--report", "one", "--quiet", expect=(0, 1))
        self.assert_fails("report", "one/report.json", "on-2/profile.json", says="one/report.json has no task graph")

    def test_a_subdomain_has_the_memory_that_the_recording_shows(self):
        """Whether or not anything moved in it: the processes' most, without what they began with."""
        profile = self.sample()
        words = ("--ranks", 3)
        grown = sum(max(rank["bytes"]) - rank["bytes"][0] for rank in profile["memory"])
        for moved in (0, 5):
            profile["engine"]["traffic"]["migrate"]["sent"] = {"messages": moved, "bytes": 1000 * moved}
            profile["engine"]["peak_rss"]["sum"] = sum(rank["bytes"][0] for rank in profile["memory"]) + 9 * 5000
            self.write("profile.json", json.dumps(profile))
            account = self.account(*words)
            self.assertEqual((account["subdomain_bytes"], account["subdomain_bytes_from"]), (5000, "recorded"))
        self.assertGreater(grown, 0)
        self.assertEqual(self.account(*words, "--split", 5)["subdomain_bytes"], 1000)
        self.assertEqual(max(self.account(*words)["memory_by_rank"]) % 5000, 0)
        self.weft("replay", "profile.json", "--report", "again")
        again = self.weft("replay", "again/graph.json", *words)
        self.assertIn("of the recording's memory", again.stdout)
        self.assertIn("as given", self.weft("replay", "graph.json", "--subdomain-bytes", 7).stdout)
        (self.folder / "profile.json").unlink()
        account = self.account(*words)
        self.assertEqual((account["subdomain_bytes"], account["subdomain_bytes_from"]), (1 << 20, "assumed"))
        self.assertIn("assumed", self.weft("replay", "graph.json").stdout)

    def test_an_enlarged_graph_has_the_network_of_its_messages(self):
        self.sample()
        links = {}
        for copies in (1, 3):
            self.replay(f"times-{copies}", "--copies", copies)
            graph = json.loads((self.folder / f"times-{copies}/graph.json").read_text())
            remote = [i for i, edge in enumerate(graph["graph"]["edges"]) if edge["kind"] == "remote"]
            self.assertEqual(sum(graph["network"]["values"]), sum(edge in remote for edge in graph["uses"]["edge"]))
            links[copies] = len(graph["network"]["from"])
        self.assertGreaterEqual(links[3], 3 * links[1])

    def test_what_is_damaged_is_named(self):
        graph = self.sample()["graph"]
        counters = graph["runs"]["counters"]
        self.assertIn("processor, seconds", counters)
        for name, column, value, words, says in (
                ("processor", counters["processor, seconds"], -1, ["--processor-times"], "processor, seconds"),
                ("processor", counters["processor, seconds"], 1e300, ["--processor-times"], "1e+300"),
                ("sizes", counters["tets predicted"], 1e300, ["--split", 2], "tets predicted"),
                ("duration", graph["runs"]["duration_ns"], 9 * 10**18, [], "9e+09 s")):
            before, column[2] = column[2], value
            self.write(f"{name}.json", json.dumps(graph))
            column[2] = before
            self.assert_fails("replay", f"{name}.json", "--ranks", 3, *words, says=[f"{name}.json", says])

    def test_larger_and_finer_ones_are_made_of_the_recorded(self):
        self.sample(subdomains=24, rounds=4)
        recorded, fine, large = (self.account(*words) for words in ((), ("--split", 4), ("--copies", 2, "--grow", 3, "--processor-times")))
        self.assertEqual([r["subdomains"] for r in (recorded, fine, large)], [24, 96, 48])
        self.assertEqual(len({r["recorded_seconds"] for r in (recorded, fine, large)}), 1)
        self.assertAlmostEqual(fine["work_seconds"] / recorded["work_seconds"], 1, delta=0.3)
        self.assertAlmostEqual(large["work_seconds"] / recorded["work_seconds"], 2 * 3 / 2, delta=0.9)

    def test_networks_of_simgrid_have_contention(self):
        self.sample(subdomains=24, rounds=4)
        networks = [f"1us,20MB/s,{topology}" for topology in ("tree:4", "fat-tree:4", "dragonfly:2")]
        if os.environ["WEFT_HAS_SIMGRID"] != "1":
            for network in networks[1:]:
                done = self.weft("replay", "graph.json", "--ranks", 8, "--network", network, expect=(2, 64))
                self.assertIn("libsimgrid-dev", done.stderr)
            self.skipTest("SimGrid is not installed: scripts/setup.sh --all")
        words = ("--ranks", 8, "--balancer", "none", "--network")
        fast, *slow = (self.account(*words, network) for network in ("1us,100GB/s,fat-tree:4", *networks))
        for replay in slow:
            self.assertEqual(replay["messages"], fast["messages"])
            self.assertEqual(replay["work_seconds"], fast["work_seconds"])
            self.assertGreater(replay["seconds"], 1.01 * fast["seconds"])
        tree, fat_tree, dragonfly = (replay["seconds"] - fast["seconds"] for replay in slow)
        self.assertGreater(fat_tree, tree / 4)
        self.assertLess(fat_tree, 4 * tree)
        self.assertGreater(dragonfly, tree / 4)
        self.assertIn("dragonfly of SimGrid, 2 ranks a router", self.weft("replay", "graph.json", *words, networks[2]).stdout)
        again = self.account(*words, networks[2])
        self.assertEqual([again[key] for key in ("seconds", "packets")], [slow[2][key] for key in ("seconds", "packets")])

    def test_its_graph_is_a_graph_and_can_be_replayed_again(self):
        recorded = self.sample()["graph"]
        self.replay("first", "--ranks", 3, "--balancer", "diffusion", "--network", "50us,1GB/s,tree:2")
        graph = json.loads((self.folder / "first/graph.json").read_text())
        jsonschema.validate(graph, schema("graph/weft-graph-1.schema.json"))
        self.assertEqual(sorted(graph["runs"]["duration_ns"]), sorted(recorded["runs"]["duration_ns"]))
        self.weft("replay", "first/graph.json", "--ranks", 2, "--trace", "again.json")
        self.assertTrue(json.loads((self.folder / "again.json").read_text())["traceEvents"])

    def test_what_cannot_be_is_named(self):
        self.sample()
        for words, says in ((["--network", "2us"], "--network"), (["--balancer", "luck"], "--balancer"), (["--ranks", 0], "--ranks"),
                            (["--slowdown", 0], "--slowdown"), (["--copies", 0], "--copies"), (["--split", 0], "--split"),
                            (["--grow", 0], "--grow"), (["--slowdown", 1e30], "--slowdown"), (["--grow", 1e12], "--grow"),
                            (["--subdomain-bytes", -1], "--subdomain-bytes"), (["--network", "1e9s,1B/s"], "--network"),
                            (["--network", "2us,1GB/s,fat-tree:2000000000"], "--network"),
                            (["--copies", 2000000000], "times as many")):
            done = self.weft("replay", "graph.json", *words, expect=(2, 64))
            self.assertIn(says, done.stderr)

    def test_its_outputs_do_not_replace_each_other(self):
        self.sample()
        before = sorted(self.folder.iterdir())
        for words, says in ((["--report", "R", "--trace", "R/graph.json"], "--trace: R/graph.json would be written by --report, too"),
                            (["--trace", "x.json", "--account", "./x.json"], "--account: ./x.json would be written by --trace, too")):
            self.assert_fails("replay", "graph.json", *words, says=says, code=64)
            self.assertEqual(sorted(self.folder.iterdir()), before)

    def test_its_recording_is_not_replaced(self):
        self.sample("run")
        self.write("run/report.json", "{}")
        before = {path: path.read_bytes() for path in (self.folder / "run").iterdir()}
        for name, option, output in (("graph.json", "--report", "run"), ("profile.json", "--report", "run"), ("graph.json", "--trace", "run/graph.json"),
                                     ("graph.json", "--account", "run/report.json")):
            self.assert_fails("replay", f"run/{name}", option, output, says=[option, "would replace the input run/"], code=64)
            self.assertEqual({path: path.read_bytes() for path in (self.folder / "run").iterdir()}, before)


class Reports(SampleTest):
    def test_two_runs_are_compared(self):
        self.sample("a", rounds=2), self.sample("b", rounds=5)
        text = self.weft("report", "a/profile.json", "b/profile.json").stdout
        self.assertIn("slower than A", text.splitlines()[0])
        self.assertRegex(text, r"MII adaptation +[\d.]+ m?s +[\d.]+ m?s +\+")
        self.assertRegex(text, r"rank 2 ")
        self.assertRegex(text, r"quality, mean +0\.\d+ +0\.\d+")
        back = self.weft("report", "b/profile.json", "a/profile.json").stdout
        self.assertIn("faster than A", back.splitlines()[0])

    def test_a_run_is_as_fast_as_itself(self):
        self.sample("a")
        text = self.weft("report", "a/profile.json", "a/profile.json").stdout
        self.assertIn("as fast as", text.splitlines()[0])
        self.assertNotIn("worse", text)

    def test_report_json_of_any_run_can_be_compared(self):
        self.box(3)
        for name in ("a", "b"):
            self.weft("adapt", "box.meshb", "--metric-fn", "uniform:0.4", "-o", "out.meshb", "--report", name, "--quiet", expect=(0, 1))
        text = self.weft("report", "a/report.json", "b/report.json", "-o", "page.html").stdout
        self.assertIn("by step", text)
        self.assertIn("<!DOCTYPE html>", (self.folder / "page.html").read_text())

    def test_page_is_made_again(self):
        self.sample()
        self.weft("report", "profile.json", "-o", "again.html")
        self.assertEqual((self.folder / "again.html").read_bytes(), (self.folder / "report.html").read_bytes())

    def test_profiles_of_older_versions_are_read(self):
        """What was added to the document later may be missing; the rest must be there."""
        profile = self.sample()
        for added in ("left", "published_curves", "simulation"):
            del profile[added]
        self.write("older.json", json.dumps(profile))
        self.weft("report", "older.json", "-o", "older.html")
        self.assertIn("as fast as", self.weft("report", "older.json", "profile.json").stdout)
        self.assertIn("as fast as", self.weft("report", "profile.json", "older.json").stdout)
        self.weft("graph", "older.json", "--collapse", "rounds", "-o", "older.dot")
        del profile["waiting"]
        self.write("damaged.json", json.dumps(profile))
        self.assert_fails("report", "damaged.json", "-o", "page.html", says=["damaged.json", "waiting", "version"])
        del profile["ranks"]
        self.write("damaged.json", json.dumps(profile))
        self.assert_fails("report", "profile.json", "damaged.json", says=["damaged.json", "ranks", "version"])

    def test_page_asks_for_nothing(self):
        self.sample()
        page = (self.folder / "report.html").read_text()
        self.assertIn("default-src 'none'", page)
        self.assertNotRegex(page, r"<(script|img|link)[^>]+(src|href)=\"http")

    def test_what_cannot_be_done_is_said(self):
        self.sample()
        self.assert_fails("report", "profile.json", says="second run", code=64)
        self.sample("other")
        for words in (["profile.json"], ["profile.json", "other/profile.json"], ["other/profile.json", "profile.json"]):
            self.assert_fails("report", *words, "-o", "profile.json", says="would replace the input profile.json", code=64)
        self.assert_fails("report", "graph.json", "-o", "page.html", says=["graph.json", "weft-profile-1"])
        self.assert_fails("report", "profile.json", "graph.json", says=["graph.json", "neither a profile"])
        self.write("hollow.json", '{"schema": "weft-profile-1"}')
        self.assert_fails("report", "profile.json", "hollow.json", says="hollow.json")
        self.assert_fails("report", "hollow.json", "-o", "page.html", says="hollow.json")
        self.write("huge.json", '{"schema": 1e999}')
        self.assert_fails("report", "huge.json", "-o", "page.html", says="huge.json: has a number that is too large")


class Runs(SampleTest):
    """`weft adapt` in subdomains, which leaves all of it."""

    def adapt(self, *words, expect=(0, 1)):
        return self.weft("adapt", self.box(6), "--metric-fn", "polar-1", "--complexity", 1500, "-o", "out.meshb", "--quiet", *words, expect=expect)

    def test_a_run_in_subdomains_leaves_profile_page_and_graph(self):
        self.adapt("--subdomains", 6, "--threads", 2, "--report", "report", "--case", "cube-polar2-50000", "--graph", "graph.dot", "--trace", "trace.json")
        self.assertEqual(sorted(p.name for p in (self.folder / "report").iterdir()), ["graph.json", "profile.json", "report.html", "report.json"])
        profile = json.loads((self.folder / "report/profile.json").read_text())
        jsonschema.validate(profile, schema("tools/report/weft-profile-1.schema.json"))
        graph = json.loads((self.folder / "report/graph.json").read_text())
        jsonschema.validate(graph, schema("graph/weft-graph-1.schema.json"))
        self.assertEqual(sorted(i["number"] for i in graph["instances"]), list(range(6)))
        self.assertEqual(graph["unmatched_uses"], 0)
        self.assertLessEqual(graph["critical_path"]["length_ns"], graph["critical_path"]["wall_ns"])
        self.assertLessEqual(profile["critical_path"]["wall"], profile["total"]["wall"])
        for rank in profile["ranks"]:
            self.assertAlmostEqual(sum(rank["seconds"].values()), rank["workers"] * rank["wall"], delta=0.01 * rank["workers"] * rank["wall"])
        self.assertEqual({lane["name"] for lane in profile["timeline"]["lanes"]} - {"worker 0", "worker 1"}, set())
        self.assertGreaterEqual(len(profile["published"]), 4)
        self.assertGreater(profile["memory"][0]["bytes"][-1], 1e6)
        self.assertEqual({layer["axis"] for layer in profile["mesh"]["layers"]}, {-1, 0, 1, 2})
        self.assertIn("digraph", (self.folder / "graph.dot").read_text())
        self.assertIn("digraph", (self.folder / "graph-planned.dot").read_text())
        self.check_what_is_left(profile)
        self.check_phases(profile)
        self.check_trace(json.loads((self.folder / "trace.json").read_text())["traceEvents"], graph)
        nodes = [n["name"] for n in graph["graph"]["nodes"]]
        for operation, counter, its_nodes in (
            ("interface refinement", "interface refinement, seconds", {"register interface"}),
            ("colouring and quality check", "quality check, seconds", {"propose", "wake"}),
        ):
            beside = graph["runs"]["counters"][counter]
            self.assertGreater(sum(beside), 0)
            in_nodes = sum(d for n, d in zip(graph["runs"]["node"], graph["runs"]["duration_ns"]) if nodes[n] in its_nodes)
            self.assertAlmostEqual(profile["total"]["seconds"][operation], sum(beside) + 1e-9 * in_nodes, places=6)
        self.check_colours(graph["runs"], nodes.index("gather"))

    def check_colours(self, runs, gather):
        """Who sends in a round is not first among its neighbours, and somebody is."""
        for this_round in sorted({r for r, node in zip(runs["round"], runs["node"]) if node == gather}):
            mine = [i for i, (r, node) in enumerate(zip(runs["round"], runs["node"])) if (r, node) == (this_round, gather)]
            colours = [runs["counters"]["colour"][i] for i in mine]
            self.assertEqual(min(colours), 0)
            for i, colour in zip(mine, colours):
                self.assertTrue(colour > 0 or runs["counters"]["tets sent"][i] == 0, (this_round, i))

    def check_trace(self, events, graph):
        """Slices nest, arrows go forward from slice to slice, and runs are those of the graph."""
        slices = [e for e in events if e["ph"] == "X"]
        threads = {}
        for e in slices:
            threads.setdefault((e["pid"], e["tid"]), []).append((round(1000 * e["ts"]), round(1000 * (e["ts"] + e["dur"]))))
        for spans in threads.values():
            self.assertEqual(spans, sorted(spans, key=lambda s: (s[0], -s[1])), "outermost first")
            open_until = []
            for begin, end in spans:
                while open_until and open_until[-1] <= begin:
                    open_until.pop()
                self.assertTrue(not open_until or end <= open_until[-1], "a slice ends after the one around it")
                open_until.append(end)
        runs, nodes = graph["runs"], [n["name"] for n in graph["graph"]["nodes"]]
        shown = sorted((e["args"]["run"], e["name"], e["args"]["subdomain"], e["args"]["round"], e["pid"]) for e in slices if e["cat"] == "node")
        numbers = [i["number"] for i in graph["instances"]]
        self.assertEqual(shown, [(r, nodes[runs["node"][r]], numbers[runs["instance"][r]], runs["round"][r], runs["rank"][r]) for r in range(len(runs["node"]))])
        self.assertEqual({e["args"]["subdomain"] for e in slices if e["name"] == "subdomain::gather"}, set(numbers))
        self.check_arrows(events, threads, graph)

    def check_arrows(self, events, threads, graph):
        tails, heads = ({(e["cat"], e["name"], e["id"]): e for e in events if e["ph"] == phase} for phase in "sf")
        self.assertEqual(set(tails), set(heads))
        self.assertEqual(len(tails), sum(e["ph"] == "s" for e in events), "each arrow has its own number")
        remote = {i for i, e in enumerate(graph["graph"]["edges"]) if e["kind"] == "remote"}
        self.assertEqual(sum(cat == "edge" for cat, _, _ in tails), sum(e in remote for e in graph["uses"]["edge"]))
        for key, tail in tails.items():
            self.assertLessEqual(tail["ts"], heads[key]["ts"])
            for end in (tail, heads[key]):
                at = round(1000 * end["ts"])
                self.assertTrue(any(begin <= at <= until for begin, until in threads[end["pid"], end["tid"]]), end)

    def check_phases(self, profile):
        """The box is far from its metric: it is made coarse before it is made fine."""
        left = profile["left"]
        begins = [step["step"] for step in left if step["everything"]]
        self.assertEqual(begins[0], 0)
        self.assertEqual(begins[-1], profile["report"]["subdomains"]["coarse_shifts"])
        self.assertGreater(len(begins), 1)
        tets = [step["interior"]["tets"] + step["interface"]["tets"] for step in left]
        coarse = [t for t, step in zip(tets, left) if step["step"] < begins[1]]
        self.assertLess(max(coarse), 0.5 * tets[-1])

    def check_what_is_left(self, profile):
        """After the last step nothing is counted that the measures of the result do not know of."""
        last, after = profile["left"][-1], profile["report"]["after"]
        self.assertEqual(profile["left"][0]["subdomains"], 1, "it is divided into six")
        self.assertEqual(max(step["subdomains"] for step in profile["left"]), 6, "in the last those alone that are woken")
        self.assertEqual(last["interior"]["tets"] + last["interface"]["tets"], after["tets"])
        long = last["interior"]["long edges"] + last["interface"]["long edges"]
        self.assertAlmostEqual(long, after["edge_length"]["share_long"] * after["edges"], delta=0.02 * after["edges"])

    def links_at_first(self, edge):
        """Who sends what along an edge in the first round, as planned and as executed."""
        planned, executed = (json.loads((self.folder / name).read_text()) for name in ("run-planned.json", "run.json"))
        at_first = json.loads(self.weft("graph", "run.json", "--round", 0, "--format", "json").stdout)
        number = next(i for i, e in enumerate(executed["graph"]["edges"]) if e["name"] == edge)
        return [{link[:2] for link in zip(g["network"]["from"], g["network"]["to"], g["network"]["edge"]) if link[2] == number}
                for g in (planned, at_first)]

    def test_a_division_is_in_the_graph(self):
        """The box is far from its metric: one subdomain makes a coarse mesh, and divides."""
        self.adapt("--subdomains", 6, "--graph", "run.json")
        planned, executed = self.links_at_first("divide -> scatter")
        self.assertEqual(executed, {(0, part) for part in range(1, 6)})
        self.assertLessEqual(executed, planned)

    def test_the_planned_graph_is_what_the_executed_one_was_allowed_to_do(self):
        self.adapt()
        self.weft("adapt", "out.meshb", "--metric", "out.solb", "--complexity", 1350, "-o", "again.meshb", "--quiet", "--subdomains", 6, "--graph", "run.json")
        planned, executed = (json.loads((self.folder / name).read_text()) for name in ("run-planned.json", "run.json"))
        jsonschema.validate(planned, schema("graph/weft-graph-1.schema.json"))
        self.assertEqual(planned["graph"], executed["graph"])
        self.assertEqual([i["number"] for i in planned["instances"]], list(range(6)))
        self.assertEqual(planned["runs"]["node"], [])
        # First neighbours exchange what they have made of their interface; later ones meet by shifts.
        links = self.links_at_first("adapt interior -> register interface")
        self.assertEqual(*links)
        self.assertTrue(links[0])
        self.weft("graph", "run-planned.json", "-o", "plan.svg")

    def test_a_run_of_the_whole_mesh_leaves_a_page_too(self):
        self.adapt("--report", "report")
        profile = json.loads((self.folder / "report/profile.json").read_text())
        jsonschema.validate(profile, schema("tools/report/weft-profile-1.schema.json"))
        self.assertIsNone(profile["graph"])
        self.assert_fails("graph", "report/profile.json", says=["contains no graph", "graph.json"])
        self.assertGreater(profile["mesh"]["layers"][0]["facets"], 100)

    def test_what_makes_no_sense_is_said(self):
        self.box(2)
        words = ["adapt", "box.meshb", "--metric-fn", "uniform:0.5", "-o", "out.meshb"]
        self.assert_fails(*words, "--graph", "g.json", says=["--graph", "--subdomains"], code=64)
        self.assert_fails(*words, "--trace", "t.json", says=["--trace", "--subdomains"], code=64)
        for outputs, says in ((["--report", "r", "--trace", "r/profile.json"], "--trace: r/profile.json would be written by --report, too"),
                              (["--graph", "x.json", "--trace", "./x.json"], "--trace: ./x.json would be written by --graph, too"),
                              (["--report", "r", "--trace", "r/graph.json", "--graph", "r/graph.json"], "--trace: r/graph.json would be written by --report, too")):
            self.assert_fails(*words, "--subdomains", 2, *outputs, says=says, code=64)
        self.assert_fails(*words, "--subdomains", 2, "--graph", "g.png", says="g.png", code=64)
        self.assert_fails(*words, "--case", "cube-polar2-50000", says="--report", code=64)
        self.assert_fails(*words, "--report", "r", "--case", "my case", says="my case", code=64)


class Breakdown(SampleTest):
    def test_ten_lines_draw_the_papers_figure(self):
        profile = self.sample()
        script = SOURCES / "tools/report/breakdown.py"
        done = subprocess.run([sys.executable, script, self.folder / "profile.json"], capture_output=True, text=True, check=True)
        root = xml.fromstring(done.stdout)
        titles = [title.text for title in root.iter("{http://www.w3.org/2000/svg}title")]
        self.assertEqual(len(titles), (1 + len(profile["ranks"])) * len(profile["operations"]))
        total = profile["total"]["seconds"]
        share = 100 * total["MII adaptation"] / sum(total.values())
        self.assertIn(f"all: MII adaptation {share:.1f} %", titles)


if __name__ == "__main__":
    unittest.main()
