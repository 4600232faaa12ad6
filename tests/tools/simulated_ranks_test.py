"""`weft adapt --simulate-ranks`: the bytes and messages of real ranks."""

import json
import unittest

from on_ranks import Subdomains


class Simulated(Subdomains):
    """On ranks that one thread simulates: what they do is real."""

    WORDS = ("box.meshb", "--metric-fn", "uniform:0.15", "--subdomains", 24, "--threads", 1, "-o", "out.meshb", "--report", "r", "--quiet")

    def simulate(self, ranks, *words):
        """What the report says, and the values between subdomains."""
        self.run_on(0, *self.WORDS, *(("--simulate-ranks", ranks, "--force") if ranks else ()), *words, expect=(0, 1))
        return self.account()

    def account(self):
        graph = json.loads((self.folder / "r/graph.json").read_text())
        kinds = [edge["kind"] for edge in graph["graph"]["edges"]]
        values = sorted((e, b) for e, b in zip(graph["uses"]["edge"], graph["uses"]["bytes"]) if kinds[e] == "remote")
        return json.loads((self.folder / "r/report.json").read_text()), values

    def test_the_same_bytes_and_values_as_on_one_rank_under_both_balancers(self):
        self.box(4)
        _, values = self.simulate(0)
        expected = self.bytes_of("out.meshb", "out.solb")
        for balancer in ("stealing", "diffusion"):
            for ranks in (3, 32):
                report, of_ranks = self.simulate(ranks, "--balancer", balancer)
                self.assertEqual(self.bytes_of("out.meshb", "out.solb"), expected, f"{ranks} ranks, {balancer}")
                self.assertEqual(of_ranks, values)
                self.assertEqual(report["subdomains"]["ranks"], ranks)
                self.assertTrue(report["subdomains"]["engine"]["consistent"]["pairs"])
                self.assertEqual(report["subdomains"]["engine"]["peak_rss"], {"sum": 0, "max": 0}, "all ranks are one process")
                self.assertGreater(report["peak_memory_bytes"], 1e6)

    def test_ranks_that_share_cores_make_the_same_bytes(self):
        self.box(4)
        self.simulate(0)
        expected = self.bytes_of("out.meshb", "out.solb")
        for cores in (1, 3):
            self.simulate(8, "--simulate-cores", cores)
            self.assertEqual(self.bytes_of("out.meshb", "out.solb"), expected)

    def test_without_balancing_real_ranks_send_each_other_the_same_messages(self):
        self.box(4)
        for ranks in (2, 4):
            simulated, values = self.simulate(ranks, "--balancer", "none")
            self.run_on(ranks, *self.WORDS, "--balancer", "none", expect=(0, 1))
            real, of_real = self.account()
            self.assertEqual(of_real, values)
            sent = [{m["name"]: m["sent"] for m in run["subdomains"]["engine"]["methods"] if m["name"].startswith("subdomain::")}
                    for run in (simulated, real)]
            self.assertEqual(*sent)
            self.assertGreater(sum(method["messages"] for method in sent[0].values()), 100)

    def test_of_many_ranks_64_have_a_timeline(self):
        self.box(4)
        words = [140 if word == 24 else word for word in self.WORDS]
        self.run_on(0, *words, "--simulate-ranks", 70, "--force", "--trace", "t.json", "--balancer", "none", expect=(0, 1))
        profile = json.loads((self.folder / "r/profile.json").read_text())
        self.assertEqual(len(profile["ranks"]), 70)
        lanes, of_run = profile["timeline"]["lanes"], profile["timeline"]["of_run"]
        shown = {lane["rank"] for lane in lanes}
        ran = set(profile["graph"]["runs"]["rank"])
        self.assertEqual(ran, set(range(70)))
        self.assertEqual(len(shown), 64)
        self.assertIn(0, shown)
        for rank, lane in zip(profile["graph"]["runs"]["rank"], of_run):
            self.assertEqual(lane is not None and lanes[lane]["rank"], rank in shown and rank)
        events = json.loads((self.folder / "t.json").read_text())["traceEvents"]
        names = {e["pid"]: e["args"]["name"] for e in events if e["name"] == "process_name"}
        self.assertEqual(set(names), shown)
        self.assertEqual(names[0], "rank 0 (64 of 70 ranks are shown)")
        self.assertEqual({e["pid"] for e in events}, shown)
        numbers = {e["args"]["subdomain"] for e in events if e.get("cat") == "node"}
        self.assertTrue(numbers <= {i["number"] for i in profile["graph"]["instances"]})

    def test_a_slower_network_takes_longer(self):
        self.box(4)
        fast, slow = (self.simulate(8, "--simulate-network", network)[0]["seconds"]["adapt"] for network in ("1us,10GB/s", "20ms,1GB/s"))
        self.assertGreater(slow, fast + 0.1)

    def test_what_is_about_this_machine_is_refused(self):
        self.box(2)
        for option in (("--time-limit", 5), ("--max-memory", "4G"), ("--checkpoint", "states")):
            self.assert_fails("adapt", "box.meshb", "--metric-fn", "uniform:0.3", "--subdomains", 2, "-o", "out.meshb", "--simulate-ranks", 4,
                              *option, says="--simulate-ranks", code=64)


if __name__ == "__main__":
    unittest.main()
