"""What a command in subdomains takes beside its loop, predicted for ranks and tets that this machine does not have.

start   All of the command with the real protocols but without work in the loop: the start mesh goes into the real number
        of subdomains on simulated ranks of one thread, nothing may be changed, and it is checked, measured and written.
        What grows with the ranks is in it. Threads of a rank share the empty loop, and what is done after it and for
        measures as in the end; what of that is messages they do not, and reading and division count as of one thread.
end     What is done after the loop (pieces, check, measures, writing) with the tets that the result has more: seconds
        a tet of a rank, from the finished mesh of the recording on --end-ranks, where each has about as many tets as in
        the large case. Threads of a rank share what two threads share here in one process, by Amdahl's law.
disk    The files' bytes at --disk bytes a second for all ranks together: assumed, as files are in a cache here. Ranks
        of several threads write while they measure: what the measures of the result take is hidden."""

import re

NO_NETWORK = "1ns,1000GB/s"
BEFORE_RESULT = ("read", "metric", "decompose", "adapt", "of the input")
NOTHING_CHANGES = ("--no-insert", "--no-swap", "--no-move", "--shifts", 0, "--force")


class WholeCommand:
    def __init__(self, book, options):
        self.book, self.options = book, options
        self.start, self.result = book.folder / book.start_mesh(options.complexity), book.folder / "recorded.meshb"
        self.start_metric = book.metric_file or self.start.with_suffix(".solb")
        self.scale = options.copies * options.grow
        self.tets_recorded = self.tets_of(self.result)
        self.more_tets = self.scale * self.tets_recorded - self.tets_of(self.start)
        self.done = {}

    def tets_of(self, mesh):
        return int(re.search(r"tets +([\d,]+)", self.book.run(self.book.command("stat", mesh))).group(1).replace(",", ""))

    def run(self, name, mesh, metric, subdomains, *more):
        """What a run says, or said when it was made for --out before and --reuse is given."""
        path = self.book.folder / f"whole-{name}.txt".replace("/", "-")
        if name not in self.done and self.options.reuse and path.exists():
            self.done[name] = path.read_text()
        if name not in self.done:
            self.done[name] = self.book.run(self.book.command(
                "adapt", mesh, "--metric", metric, "--subdomains", subdomains, *NOTHING_CHANGES, "-o", "whole.meshb", *more), (0, 1))
            path.write_text(self.done[name])
            self.book.say(f"whole command: {name}")
        return self.done[name]

    @staticmethod
    def on_ranks(ranks, network):
        return "--threads", 1, "--simulate-ranks", ranks, "--simulate-network", network

    @staticmethod
    def seconds_of(text):
        """Those of the steps; of simulated ranks virtual ones."""
        return {step: sum(map(float, re.findall(rf"^ +{step} +([\d.]+)", text, re.M)))  # none of steps that were not taken
                for step in (*BEFORE_RESULT, "measure", "total")}

    def of_start(self, ranks, subdomains, network):
        """All seconds, and those of the steps."""
        text = self.run(f"start-{self.options.complexity * self.scale:g}-{ranks}-{subdomains}-{network}", self.start, self.start_metric, subdomains,
                        "--complexity", self.options.complexity * self.scale, *self.on_ranks(ranks, network))
        return float(re.search(r"^simulated: .*?: ([\d.e+-]+) s,", text, re.M).group(1)), self.seconds_of(text)

    def start_seconds(self, ranks, threads, subdomains, network):
        _, work = self.of_start(ranks, subdomains, NO_NETWORK)
        after_loop = work["total"] - sum(work[step] for step in BEFORE_RESULT)
        saved = work["adapt"] * (1 - 1 / threads)
        saved += (after_loop + work["of the input"]) * (1 - self.share_of_thread(threads, max(1, subdomains // self.options.copies)))
        return self.of_start(ranks, subdomains, network)[0] - saved

    def end_run(self, name, subdomains, *more):
        return self.seconds_of(self.run(f"{name}-{subdomains}", self.result, self.result.with_suffix(".solb"), subdomains, *more))

    def after_loop(self, name, subdomains, *more):
        seconds = self.end_run(name, subdomains, *more)
        return seconds["total"] - sum(seconds[step] for step in BEFORE_RESULT)

    def share_of_thread(self, threads, subdomains):
        one, two = (self.after_loop(f"threads-{n}", subdomains, "--threads", n) for n in (1, 2))
        serial = min(1.0, max(0.0, 2 * two / one - 1))
        return serial + (1 - serial) / threads

    def share_of_measures(self, subdomains):
        """Of what is done after the loop."""
        seconds = self.end_run("threads-1", subdomains, "--threads", 1)
        return (seconds["measure"] - seconds["of the input"]) / self.after_loop("threads-1", subdomains, "--threads", 1)

    def end_seconds(self, ranks, threads, subdomains, network):
        """`subdomains` of the recorded mesh, each as large as in the case."""
        measured_on = self.options.end_ranks if ranks > 1 else 1
        seconds = self.after_loop(f"end-{measured_on}-{network}", subdomains, *self.on_ranks(measured_on, network))
        return seconds * measured_on / self.tets_recorded * self.more_tets / ranks * self.share_of_thread(threads, subdomains)

    def disk_seconds(self):
        files = [self.start, self.start_metric], [self.result, self.result.with_suffix(".solb")]
        of_start, of_result = (sum(path.stat().st_size for path in pair) for pair in files)
        return (of_start + self.scale * of_result) / self.options.disk

    def seconds(self, ranks, threads, subdomains, network):
        """All but the loop."""
        recorded = max(1, subdomains // self.options.copies)
        end = self.end_seconds(ranks, threads, recorded, network)
        hidden = end * self.share_of_measures(recorded) if threads > 1 else 0
        return {"start": self.start_seconds(ranks, threads, subdomains, network), "end": end, "disk": max(0, self.disk_seconds() - hidden)}
