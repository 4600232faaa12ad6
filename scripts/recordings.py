"""What calibrate.py, paper.py and scaling.py share: recorded runs of weft, and replays of them."""

import json
import os
import pathlib
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent


class Recordings:
    """Runs weft in a folder, on cube-polar2 or on the start mesh and metric given."""

    def __init__(self, options):
        self.weft, self.folder = pathlib.Path(options.weft).resolve(), pathlib.Path(options.out).resolve()
        self.processor_times = ["--processor-times"] if options.times == "processor" else []
        self.start, self.complexity = options.start, options.complexity
        self.metric_file = pathlib.Path(self.start[1]).resolve() if self.start else None
        self.metric = ["--metric", self.metric_file] if self.start else ["--metric-fn", "polar-2"]
        self.case = pathlib.Path(self.start[0]).resolve().parent.name if self.start else "Cube, polar-2"
        self.folder.mkdir(parents=True, exist_ok=True)
        self.begin = time.monotonic()

    @staticmethod
    def add_options(parser, out, complexity):
        parser.add_argument("--weft", default=ROOT / "build/bin/weft")
        parser.add_argument("--out", default=ROOT / "build" / out)
        parser.add_argument("--start", nargs=2, metavar=("MESH", "METRIC"), help="in place of a cube to polar-2")
        parser.add_argument("--complexity", type=int, default=complexity, help="of the adapted mesh" + (f" (default {complexity})" if complexity else ""))
        parser.add_argument("--times", choices=("wall", "processor"), default="wall",
                            help="of recorded tasks; processor: for a machine that has other work, too")

    def say(self, text):
        print(f"[{time.monotonic() - self.begin:.0f} s] {text}", flush=True)

    def command(self, *words):
        return [str(self.weft), *map(str, words)]

    def run(self, words, allowed=(0,)):
        """What the program prints."""
        done = subprocess.run(list(map(str, words)), capture_output=True, text=True, cwd=self.folder)
        if done.returncode not in allowed:
            sys.exit(f"{' '.join(map(str, words))} has ended with {done.returncode}:\n{done.stdout}{done.stderr}")
        return done.stdout

    def start_mesh(self, complexity):
        """That given, or a mesh that has been adapted to a tenth before, as in the paper's cases."""
        if self.start:
            return pathlib.Path(self.start[0]).resolve()
        name = f"start-{complexity}.meshb"
        if not (self.folder / name).exists():
            self.run(self.command("mesh", "box", "-o", "box.meshb", "--cells", 6, 6, 6))
            self.run(self.command("adapt", "box.meshb", *self.metric, "--complexity", max(500, complexity // 10), "-o", name, "--quiet"), (0, 1))
        return name

    def adapt_words(self, name, subdomains, *more, complexity=None):
        complexity = complexity or self.complexity
        return self.command("adapt", self.start_mesh(complexity), *self.metric, "--complexity", complexity, "--subdomains", subdomains,
                            "--threads", 1, "-o", f"{name}.meshb", "--report", name, "--quiet", *more)

    def record(self, name, subdomains, *more, complexity=None):
        """One rank, one thread: what a task takes when the other cores have nothing to do."""
        self.run(self.adapt_words(name, subdomains, *more, complexity=complexity), (0, 1))
        return Recording(self.folder / name, bool(self.processor_times))

    def mpirun(self, ranks):
        as_root = ["--allow-run-as-root"] if os.geteuid() == 0 else []
        return ["mpirun", *as_root, "-n", str(ranks), "--oversubscribe", "--bind-to", "none", "--mca", "mpi_yield_when_idle", "1"]

    def replay(self, recording, ranks, network, *more):
        """What it says of the run, without what it says of each rank."""
        self.run(self.command("replay", f"{recording}/graph.json", "--ranks", ranks, "--network", network, *self.processor_times,
                              "--account", "replay.json", "--quiet", *more))
        account = json.loads((self.folder / "replay.json").read_text())
        del account["engine"], account["memory_by_rank"]
        return account


class Recording:
    """What a run with --report says of its tasks."""

    def __init__(self, folder, processor_times):
        graph = json.loads((folder / "graph.json").read_text())
        runs, self.report = graph["runs"], json.loads((folder / "report.json").read_text())
        counted = runs["counters"].get("processor, seconds", [])
        self.seconds = counted if processor_times else [1e-9 * d for d in runs["duration_ns"]]
        self.tasks, self.work = len(self.seconds), sum(self.seconds)
        self.loop = 1e-9 * graph["critical_path"]["wall_ns"]  # from the first task's begin to the last one's end
        self.times = self.report["seconds"]
        self.engine = self.report["subdomains"]["engine"]

    def count(self, traffic):
        return self.engine["traffic"][traffic]["sent"]["messages"]
