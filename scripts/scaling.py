#!/usr/bin/env python3
"""Strong and weak scaling of a run in subdomains as `weft replay` predicts it, beside published efficiencies.

Records one run on one core (--complexity in --subdomains), makes of it the graph of a mesh of --copies times the size
with --grow times the tets in each subdomain, and replays that on --cores, as ranks of --threads, with the networks of a
common cluster and a slow one: once in its own decomposition and, where that has fewer than --a-core subdomains a core,
in a finer one. What the whole command takes beside the loop is predicted from runs on simulated ranks, up to --whole
of them (whole_command.py says how). Writes scaling.md and SVG plots to --out."""

import argparse
import itertools
import json
import sys

from drawing import plot
from published import efficiency_curves
from recordings import Recording, Recordings
from whole_command import WholeCommand

NETWORKS = {"2 us, 10 GB/s": "2us,10GB/s", "50 us, 1 GB/s": "50us,1GB/s"}


def splits_for(options, cores):
    """1 and, if there are too few subdomains for so many cores, what gives enough."""
    subdomains, split = options.subdomains * options.copies, 1
    while subdomains * split < options.a_core * cores:
        split *= 2
    return sorted({1, split})


def machines(options, cores):
    """(ranks, threads a rank) with so many cores."""
    return [(cores // threads, threads) for threads in options.threads if cores % threads == 0]


def add_command(row, whole, one_core, network):
    """Predicted seconds and efficiency of the whole command."""
    row["parts"] = whole.seconds(row["ranks"], row["threads"], row["subdomains"], network)
    row["beside"] = sum(row["parts"].values())
    row["command"] = (one_core + row["reference"]) / (row["cores"] * (row["seconds"] + row["beside"]))


def strong(book, options, whole):
    rows = []
    reference = one_core = None
    for words, network in NETWORKS.items():
        for cores in options.cores:
            for split, (ranks, threads) in itertools.product(splits_for(options, cores), machines(options, cores)):
                replay = book.replay("recorded", ranks, network, "--threads", threads, "--copies", options.copies, "--grow", options.grow,
                                     "--split", split, "--balancer", options.balancer)
                reference = reference or replay["work_seconds"]  # of one core, in the decomposition that is asked for
                row = {**replay, "network": words, "cores": cores, "threads": threads, "split": split, "reference": reference}
                row["loop"] = reference / (cores * replay["seconds"])
                row["ranks"] = ranks
                if ranks <= options.whole:
                    one_core = one_core or sum(whole.seconds(1, 1, replay["subdomains"], network).values())
                    add_command(row, whole, one_core, network)
                rows.append(row)
                book.say(f"strong, {words}, {ranks} x {threads} cores, {replay['subdomains']} subdomains: {replay['seconds']:.4g} s, "
                         f"{100 * row['loop']:.1f} %")
    return rows


def copies_of(options, cores):
    """Of the recording, for --a-core subdomains on each of so many cores; 0: no whole number of copies has them."""
    copies, left = divmod(options.a_core * cores, options.subdomains)
    return 0 if left else copies


def left_out_of_weak(options):
    """What is not in the table of weak scaling, and why."""
    out = [cores for cores in options.weak if not copies_of(options, cores)]
    return [f"Left out: {', '.join(map(str, out))} cores, for {options.a_core} subdomains on each are no multiple of the {options.subdomains} recorded."] if out else []


def weak(book, options):
    rows = []
    for (words, network), threads in itertools.product(NETWORKS.items(), options.threads):
        reference = None
        for cores in [cores for cores in options.weak if cores % threads == 0 and copies_of(options, cores)]:
            copies = copies_of(options, cores)
            replay = book.replay("recorded", cores // threads, network, "--threads", threads, "--copies", copies, "--grow", options.grow,
                                 "--balancer", options.balancer)
            if replay["subdomains"] != options.a_core * cores:
                sys.exit(f"scaling: --subdomains {options.subdomains}, but the recording has {replay['subdomains'] // copies}")
            of_core = replay["seconds"] / (replay["work_seconds"] / cores)  # the drawn work is not quite the same for each
            reference = reference or of_core
            rows.append({**replay, "network": words, "cores": cores, "threads": threads, "weak": reference / of_core})
            book.say(f"weak, {words}, {cores // threads} x {threads} cores: {replay['seconds']:.4g} s, {100 * rows[-1]['weak']:.1f} %")
    return rows


def limit_of(row):
    """What the loop waits for."""
    ideal = row["work_seconds"] / row["cores"]
    for name, key in (("critical path", "critical_path_seconds"), ("largest subdomain", "largest_subdomain_seconds")):
        if row[key] > 0.8 * row["seconds"]:
            return name
    return "-" if row["seconds"] < 1.1 * ideal else "balance"


def text_of(book, strong_rows, weak_rows, options):
    tets = 12e-6 * options.complexity * options.copies * options.grow
    out = [f"# Scaling, simulated\n\n{book.case}, recorded at complexity {options.complexity} in {options.subdomains} subdomains ({options.times} times), "
           f"then {options.copies} copies of {options.grow:g} times the tets a subdomain: about {tets:.3g} M tets. Balancer {options.balancer}.\n",
           "| network | cores | threads a rank | subdomains | loop s | efficiency | critical path s | largest subdomain s | moved | packets | end found after s | limit | start, end, disk s | command |",
           "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|"]
    for r in strong_rows:
        command = (", ".join(f"{s:.3g}" for s in r["parts"].values()), f"{100 * r['command']:.1f} %") if "command" in r else ("", "")
        out.append(f"| {r['network']} | {r['cores']} | {r['threads']} | {r['subdomains']} | {r['seconds']:.4g} | {100 * r['loop']:.1f} % | {r['critical_path_seconds']:.3g} | "
                   f"{r['largest_subdomain_seconds']:.3g} | {r['migrations']['messages']} | {r['packets']['packets']} | {max(0, r['run_seconds'] - r['seconds']):.2g} | "
                   f"{limit_of(r)} | {command[0]} | {command[1]} |")
    out += [f"\nWeak: {options.a_core} subdomains a core.\n", *(line + "\n" for line in left_out_of_weak(options)), "| network | cores | threads a rank | subdomains | loop s | work a core s | efficiency against the first |", "|---|---|---|---|---|---|---|"]
    for r in weak_rows:
        out.append(f"| {r['network']} | {r['cores']} | {r['threads']} | {r['subdomains']} | {r['seconds']:.4g} | {r['work_seconds'] / r['cores']:.4g} | {100 * r['weak']:.1f} % |")
    return "\n".join(out) + "\n"


def plots(book, strong_rows, weak_rows, options):
    best = {}
    for r in strong_rows:
        key = (r["network"], r["cores"])
        if key not in best or r["loop"] > best[key]["loop"]:
            best[key] = r
    curves = {}
    for words in NETWORKS:
        mine = [r for (network, _), r in sorted(best.items()) if network == words]
        curves[f"weft, loop, simulated, {words}"] = ([(r["cores"], r["loop"]) for r in mine], True, True)
        whole = [(r["cores"], r["command"]) for r in mine if "command" in r]
        if whole:
            curves[f"weft, command, predicted, {words}"] = (whole, True, True)
    (book.folder / "strong.svg").write_text(plot("Efficiency against one core", "cores", "efficiency", {**curves, **efficiency_curves()}, log_x=True))
    curves = {f"weft, simulated, {words}, {threads} threads a rank": ([(r["cores"], r["weak"]) for r in weak_rows if (r["network"], r["threads"]) == (words, threads)], True, True)
              for words, threads in itertools.product(NETWORKS, options.threads)}
    (book.folder / "weak.svg").write_text(plot("Weak scaling of the loop", "cores", "efficiency", curves, log_x=True))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    Recordings.add_options(parser, "scaling", 50_000)
    parser.add_argument("--subdomains", type=int, default=64, help="of the recording (default 64)")
    parser.add_argument("--copies", type=int, default=20, help="(default 20)")
    parser.add_argument("--grow", type=float, default=4, help="(default 4)")
    parser.add_argument("--a-core", type=int, default=8, help="subdomains a core, in weak scaling and where there are too few (default 8)")
    parser.add_argument("--cores", nargs="+", type=int, default=[16, 64, 256, 512, 1024, 4096])
    parser.add_argument("--threads", nargs="+", type=int, default=[1, 8], help="of a rank (default 1 8)")
    parser.add_argument("--weak", nargs="*", type=int, default=[16, 64, 256, 1024])
    parser.add_argument("--whole", type=int, default=512, help="predict the whole command on up to so many ranks (default 512; 0: the loop alone)")
    parser.add_argument("--end-ranks", type=int, default=6, help="of its end (default 6)")
    parser.add_argument("--disk", type=float, default=10e9, help="bytes a second that all ranks together read or write (default 10e9)")
    parser.add_argument("--reuse", action="store_true", help="the recording, and runs of the whole command, that are in --out already")
    parser.add_argument("--balancer", default="stealing")
    options = parser.parse_args()
    book = Recordings(options)
    kept = book.folder / "recorded"
    recording = Recording(kept, bool(book.processor_times)) if options.reuse else book.record("recorded", options.subdomains)
    book.say(f"recorded: {recording.tasks} tasks, {recording.work:.3g} s of work")
    whole = WholeCommand(book, options) if options.whole else None
    strong_rows, weak_rows = strong(book, options, whole), weak(book, options)
    text = text_of(book, strong_rows, weak_rows, options)
    (book.folder / "scaling.md").write_text(text)
    (book.folder / "scaling.json").write_text(json.dumps({"strong": strong_rows, "weak": weak_rows}, indent=1, default=str))
    plots(book, strong_rows, weak_rows, options)
    print(text)


if __name__ == "__main__":
    sys.exit(main())
