#!/usr/bin/env python3
"""How good are the predictions of `weft replay`? Records, predicts, then measures; see calibration.md in --out.

1. Records a run on one core; then as many at once as there are cores: so many times longer take tasks when all are
   busy, which is given to the replay as --slowdown.
2. Predicts the loop on each number of cores, and writes that down.
3. Measures: mpirun with as many ranks of one thread.
4. With --finer: predicts the decomposition into so many subdomains from the coarser one, records it, and compares what
   both replays say on each number of cores --on.

Ends with 1 where the loop of 3 is off by more than --allowed, or that of 4 by more than --finer-allowed. A machine that
has other work shows in the load average, which is in the table: figures of such a run mean nothing, but for those of 4
with --times processor.

1,024 subdomains predicted from 256, of the cube, whose start mesh is far from its metric in places, and of a mesh with its
metric; each takes some minutes. A small mesh in many subdomains, as the default one in 256, is predicted much too short.

    calibrate.py --complexity 200000 --subdomains 256 --cores --finer 1024 --on 1 16 64 256 512 1024
    calibrate.py --start MESH METRIC --complexity 500000 --subdomains 256 --cores --finer 1024 --on 1 16 64 256 512 1024"""

import argparse
import json
import os
import statistics
import subprocess
import sys

from recordings import Recording, Recordings

NETWORK = "1us,10GB/s"  # ranks of one machine


def median_by(values, key):
    return sorted(values, key=key)[len(values) // 2]


def slowdown_of(book, alone, subdomains, cores):
    """The same run on all cores at once, beside the one that was alone."""
    if cores == 1:
        return 1.0
    words = [book.adapt_words(f"busy-{i}", subdomains) for i in range(cores)]
    for process in [subprocess.Popen(list(map(str, w)), cwd=book.folder, stdout=subprocess.DEVNULL) for w in words]:
        if process.wait() not in (0, 1):
            sys.exit("calibrate: one of the runs at once has failed")
    works = [Recording(book.folder / f"busy-{i}", bool(book.processor_times)).work for i in range(cores)]
    return statistics.mean(works) / alone.work


def measure(book, subdomains, cores, repeats):
    runs = []
    for i in range(repeats):
        name = f"on-{cores}"
        book.run([*book.mpirun(cores), *book.adapt_words(name, subdomains)], (0, 1))
        runs.append(Recording(book.folder / name, bool(book.processor_times)))
    return median_by(runs, lambda r: r.loop)


def record_alone(book, options):
    """The name of the recording with the median work, and what it says."""
    runs = [(f"alone-{i}", book.record(f"alone-{i}", options.subdomains)) for i in range(options.repeats)]
    name, alone = median_by(runs, lambda run: run[1].work)
    book.say(f"recorded: {alone.tasks} tasks, {alone.work:.3g} s of work")
    return name, alone


def predict_and_measure(book, options, name, alone):
    predictions = []
    for cores in options.cores:
        slowdown = slowdown_of(book, alone, options.subdomains, cores)
        replay = book.replay(name, cores, NETWORK, "--slowdown", slowdown)
        predictions.append({"cores": cores, "slowdown": slowdown, "seconds": replay["seconds"], "work": replay["work_seconds"],
                            "migrations": replay["migrations"]["messages"], "messages": replay["messages"]["messages"]})
    (book.folder / "predictions.json").write_text(json.dumps(predictions, indent=1))
    book.say("predicted")
    rows = []
    for p in predictions:
        run = measure(book, options.subdomains, p["cores"], options.repeats)
        rows.append({**p, "measured": run.loop, "error": p["seconds"] / run.loop - 1, "measured_work": run.work,
                     "measured_migrations": run.count("migrate"), "load": os.getloadavg()[0]})
        book.say(f"{p['cores']} cores: predicted {p['seconds']:.4g} s, measured {run.loop:.4g} s")
    return rows


def predict_finer(book, options, name):
    """The finer decomposition from the coarser one, beside its own recording."""
    if options.finer is None:
        return []
    predicted = {cores: book.replay(name, cores, NETWORK, "--split", options.finer // options.subdomains) for cores in options.on}
    fine = book.record("fine", options.finer)
    rows = []
    for cores in options.on:
        own, guess = book.replay("fine", cores, NETWORK), predicted[cores]
        rows.append({"cores": cores, "error": guess["seconds"] / own["seconds"] - 1, **{key: (guess[key], own[key]) for key in ("seconds", "work_seconds", "largest_subdomain_seconds", "critical_path_seconds", "tasks")}})
    book.say(f"finer: {fine.tasks} tasks recorded")
    return rows


def text_of(book, rows, finer, options):
    out = [f"# Calibration\n\n{book.case}, complexity {options.complexity}, {options.subdomains} subdomains, {options.times} times of tasks.\n"]
    if rows:
        out.append("| cores | slow-down | predicted s | measured s | error | predicted migrations | measured | load average |\n|---|---|---|---|---|---|---|---|")
        for r in rows:
            out.append(f"| {r['cores']} | {r['slowdown']:.3f} | {r['seconds']:.4g} | {r['measured']:.4g} | {100 * r['error']:+.1f} % | {r['migrations']} | "
                       f"{r['measured_migrations']} | {r['load']:.1f} |")
    if finer:
        out.append(f"\n{options.finer} subdomains predicted from {options.subdomains}, beside their own recording:\n")
        out.append("| cores | loop s | of own | error | work s | of own | largest subdomain s | of own | critical path s | of own |\n|---|---|---|---|---|---|---|---|---|---|")
        for r in finer:
            (t, t0), (w, w0), (l, l0), (c, c0) = (r[k] for k in ("seconds", "work_seconds", "largest_subdomain_seconds", "critical_path_seconds"))
            out.append(f"| {r['cores']} | {t:.4g} | {t0:.4g} | {100 * r['error']:+.1f} % | {w:.4g} | {w0:.4g} | {l:.4g} | {l0:.4g} | {c:.4g} | {c0:.4g} |")
    return "\n".join(out) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    Recordings.add_options(parser, "calibrate", 20_000)
    parser.add_argument("--subdomains", type=int, default=64, help="(default 64)")
    parser.add_argument("--cores", nargs="*", type=int, default=sorted({1, 2, os.cpu_count() or 1}), help="to predict and measure")
    parser.add_argument("--repeats", type=int, default=3, help="of recording and measurement; the median counts (default 3)")
    parser.add_argument("--finer", type=int, help="subdomains of the finer decomposition, a multiple of --subdomains (default: none)")
    parser.add_argument("--on", nargs="+", type=int, default=[1, 4, 16, 64], help="cores on which the finer one is compared (default 1 4 16 64)")
    parser.add_argument("--allowed", type=float, default=0.1, help="error of a prediction on --cores (default 0.1)")
    parser.add_argument("--finer-allowed", type=float, default=0.15, help="error of a prediction of the finer decomposition (default 0.15)")
    options = parser.parse_args()
    if min([options.subdomains, options.repeats, *options.cores, *options.on]) < 1:
        parser.error("--subdomains, --repeats, --cores, --on: at least 1")
    if options.finer is not None and (options.finer <= options.subdomains or options.finer % options.subdomains):
        parser.error(f"--finer {options.finer}: not a multiple of {options.subdomains} subdomains, or not more")
    book = Recordings(options)
    name, alone = record_alone(book, options)
    rows = predict_and_measure(book, options, name, alone)
    finer = predict_finer(book, options, name)
    text = text_of(book, rows, finer, options)
    (book.folder / "calibration.md").write_text(text)
    print(text)
    wrong = [r for r in rows if abs(r["error"]) > options.allowed] + [r for r in finer if abs(r["error"]) > options.finer_allowed]
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
