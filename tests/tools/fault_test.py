"""One call fails, by number: writes on a full disk, fsync, rename, open, allocations. However it ends, the files
that were there are whole: the old ones, or the new ones.

WEFT_FAULTS: how many points of each kind are tried (nightly: 1000).
"""

import os
import random
import subprocess
import unittest

from command import WEFT, CommandTest

SHIM = os.environ["WEFT_FAULT_SHIM"]
FAULTS = int(os.environ.get("WEFT_FAULTS", "6"))
SECONDS = 120
MODES = {
    "one mesh": (),
    "threads": ("--threads", 2),
    "subdomains": ("--subdomains", 3, "--threads", 1),
    "checkpoints of one mesh": ("--threads", 1, "--checkpoint", "ck", "--checkpoint-every", "0.01"),
    "checkpoints": ("--subdomains", 3, "--threads", 1, "--checkpoint", "ck", "--checkpoint-every", "0.01"),
}


class Faults(CommandTest):
    def setUp(self):
        super().setUp()
        self.box(2)
        self.weft("adapt", "box.meshb", "--metric-fn", "uniform:0.5", "-o", "out.meshb", "--threads", 1, "--quiet")
        self.old = {name: (self.folder / name).read_bytes() for name in ("out.meshb", "out.solb")}

    def run_with(self, fault, mode):
        environment = {**os.environ, "LD_PRELOAD": SHIM, "WEFT_FAULT": fault, "WEFT_FAULT_COUNT": str(self.folder / "count")}
        return subprocess.run([str(WEFT), "adapt", "box.meshb", "--metric-fn", "uniform:0.3", "-o", "out.meshb", "--quiet",
                               *map(str, MODES[mode])], cwd=self.folder, env=environment, capture_output=True, text=True,
                              timeout=SECONDS)

    def calls(self, mode):
        done = self.run_with("none:0", mode)
        self.assertIn(done.returncode, (0, 1), done.stderr)
        lines = (self.folder / "count").read_text().split()
        return dict(zip(lines[::2], map(int, lines[1::2])))

    def assert_nothing_is_lost(self, done, fault, mode):
        told = f"{fault} in {mode}: exit {done.returncode}\n{done.stdout}{done.stderr}"
        self.assertIn(done.returncode, (0, 1, 2), told)
        now = {name: (self.folder / name).read_bytes() for name in self.old}
        if done.returncode == 2:
            self.assertTrue(done.stderr.startswith(("weft", "error")), told)
        if now["out.meshb"] != self.old["out.meshb"]:
            self.weft("verify", "out.meshb", "--against", "box.meshb")
            (self.folder / "out.meshb").write_bytes(self.old["out.meshb"])
            (self.folder / "out.solb").write_bytes(self.old["out.solb"])
        left = [name for name in self.files() if name.startswith(".weft")]
        self.assertEqual(left, [], told)

    def test_every_kind_in_every_mode(self):
        chance = random.Random(4)
        for mode in MODES:
            counts = self.calls(mode)
            self.assertGreater(min(counts.values()), 0, f"calls are not seen: {counts}")
            for kind, count in counts.items():
                points = sorted(chance.sample(range(1, count + 1), min(FAULTS, count)))
                for point in points:
                    fault = f"{kind}:{point}"
                    self.assert_nothing_is_lost(self.run_with(fault, mode), fault, mode)


if __name__ == "__main__":
    unittest.main()
