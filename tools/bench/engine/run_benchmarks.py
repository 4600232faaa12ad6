#!/usr/bin/env python3
"""Runs the engine's benchmarks under mpirun and prints their figures beside what is required of them.

All figures also go to OUT (build/bench/engine.json), with commit, processor and load. Other programs make all of them
worse. Balancing runs several times and the run counts in which others took least CPU; where that was more than 5 % of
the machine, the ratio says nothing, and the row says BUSY. "examples" runs graph/examples on the engine and plain, in
turns; their overheads are printed beside published ones of other systems."""

import argparse
import json
import os
import pathlib
import shlex
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[3]
# More ranks than cores, and root in containers: mpirun must be told that both are meant.
MPIRUN = shlex.split(os.environ.get("WEFT_MPIRUN", "mpirun --oversubscribe --bind-to none --mca mpi_yield_when_idle 1"))
ENVIRONMENT = {**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
PARTS = ["transport", "latency", "rate", "migration", "balance", "trace", "idle", "examples"]
RANKS = {"transport": 2, "latency": 2, "rate": 2, "migration": 2, "balance": 4, "trace": 1, "idle": 9}
POLICIES = ["none", "stealing", "diffusion"]
LARGE = 1 << 20
# Of graph/examples: name, program, options; the work a task is coarse in the first of a program, fine in the second.
EXAMPLES = [("heat, blocks of 256 x 256", "heat", {"size": 2048, "tile": 256, "steps": 50}),
            ("heat, blocks of 32 x 32", "heat", {"size": 1024, "tile": 32, "steps": 50}),
            ("Cholesky, tiles of 192", "cholesky", {"size": 3072, "tile": 192}),
            ("Cholesky, tiles of 64", "cholesky", {"size": 2048, "tile": 64}),
            ("particles", "particles", {"size": 20000, "tile": 24, "steps": 10})]
SMALLEST = {"size": 128, "tile": 4, "steps": 50}  # blocks of heat whose work is next to nothing
MACHINES = [(1, 2), (2, 1), (2, 2)]  # ranks, threads a rank
PUBLISHED = [
    ("TTG on PaRSEC, a task in shared memory", "a few hundred clock cycles", "Schuchart et al., CLUSTER 2022, 10.1109/CLUSTER51413.2022.00026"),
    ("StarPU, a task", "a few microseconds", "StarPU handbook 1.4, Task Granularity"),
    ("15 systems, Charm++, StarPU and PaRSEC among them, on 256 nodes",
     "tasks of 100 us for half the peak", "Slaughter et al., Task Bench, SC20"),
]
MOST_OTHERS = 0.05  # of the machine's CPU time


def run(folder, part, *arguments):
    program = [folder / "weft_transport_bench"] if part == "transport" else [folder / "weft_engine_bench", part]
    command = [str(word) for word in (*MPIRUN, "-n", RANKS[part], *program, *arguments)]
    print(f"bench: {part} {' '.join(arguments)}".rstrip(), file=sys.stderr)
    done = subprocess.run(command, env=ENVIRONMENT, stdout=subprocess.PIPE, text=True, timeout=600, check=False)
    if done.returncode != 0:
        sys.exit(f"bench: {' '.join(command)} failed with status {done.returncode}")
    return json.loads(done.stdout)


def run_example(folder, program, ranks, threads, options):
    words = [str(word) for name, value in options.items() for word in (f"--{name}", value)]
    command = [*MPIRUN, "-n", str(ranks), str(folder / f"weft_example_{program}"), *words, "--threads", str(threads)]
    done = subprocess.run(command, env=ENVIRONMENT, stdout=subprocess.PIPE, text=True, timeout=600, check=False)
    if done.returncode != 0:
        sys.exit(f"bench: {' '.join(command)} failed with status {done.returncode}")
    return json.loads(done.stdout)


def run_pair(folder, program, ranks, threads, options, repeats):
    """In turns, so that both meet the same other programs; of each the run with the least wall time, and the least processor time."""
    runs = {version: [] for version in ("", "_plain")}
    for _ in range(repeats):
        for version, done in runs.items():
            done.append(run_example(folder, program + version, ranks, threads, options))
    return {name: {**runs[version][0], **{key: min(one[key] for one in runs[version]) for key in ("seconds", "processor_seconds")}}
            for name, version in (("engine", ""), ("plain", "_plain"))}


def run_examples(folder, repeats):
    result = {"pairs": []}
    for name, program, options in EXAMPLES:
        for ranks, threads in MACHINES:
            print(f"bench: {name}, {ranks} x {threads}", file=sys.stderr)
            result["pairs"].append({"name": name, **run_pair(folder, program, ranks, threads, options, repeats)})
    result["smallest"] = run_pair(folder, "heat", 1, 1, SMALLEST, repeats)
    result["rate"] = run(folder, "rate")
    return result


def size_name(size):
    for unit, scale in (("MiB", 1 << 20), ("MB", 10**6), ("KiB", 1 << 10), ("KB", 10**3)):
        if size >= scale and size % scale == 0:
            return f"{size // scale} {unit}"
    return f"{size} B"


# --- Rows of the table: name, measured value, its unit and format, and what is required: None, or a bound behind "<=",
# ">=", or "BUSY" where it could not be measured.

def transport_rows(figures):
    for case in figures["latency"]:
        name = f"transport, {size_name(case['bytes'])}: above plain MPI"
        yield name, case["overhead_us"], "us", ".2f", ("<=", 3)
    for case in figures["bandwidth"]:
        required = (">=", 0.9) if case["bytes"] >= LARGE else None
        yield f"transport, {size_name(case['bytes'])}: bandwidth / plain MPI's", case["ratio"], "", ".3f", required


def latency_rows(figures):
    for place in ("remote", "local"):
        for case in figures[place]:
            name = f"handler to handler, {place}, {size_name(case['bytes'])}"
            yield f"{name}: median", case["median_us"], "us", ".2f", None
            yield f"{name}: 90 %", case["quantile_90_us"], "us", ".2f", None


def rate_rows(figures):
    for place in ("local", "remote"):
        best = max(case["handlers_per_s_per_rank"] for case in figures[place])
        yield f"handlers a rank, {place}, best of {len(figures[place])}", best, "/s", ".0f", None


def migration_rows(figures):
    for case in figures:
        name = f"migration, {size_name(case['bytes'])}"
        yield name, case["s_per_mb"] * 1e3, "ms/MB", ".3f", None


def others_share(one):
    return one["other_programs_cpu"] / (os.cpu_count() * one["wall"])


def balance_rows(figures):
    for policy in POLICIES:
        best = min(figures[policy], key=others_share)
        required = (">=", 1.7) if policy == "none" else ("<=", 1.15)
        if others_share(best) > MOST_OTHERS:
            required = ("BUSY", required[1])
        name = f"balance, {policy}: wall / ideal, quietest of {len(figures[policy])}"
        yield name, best["ratio"], "", ".3f", required
        yield f"  migrations in {best['tasks']:.0f} tasks", best["migrations"], "", ".0f", None
        yield "  CPU of other programs meanwhile", best["other_programs_cpu"], "s", ".2f", None


def trace_rows(figures):
    yield "tracing, CPU of a 1 ms task: with spans / without", figures["cpu_ratio"], "", ".4f", ("<=", 1.02)


def idle_rows(figures):
    for case in figures:
        name = f"idle, {case['policy']}: most of {case['idle_ranks']} ranks"
        yield name, case["most_percent_of_core"], "% of a core", ".2f", ("<=", 5)


def blocks_of(run):
    return (run["size"] // run["tile"]) ** 2 * run["steps"]


def example_rows(figures):
    for pair in figures["pairs"]:
        engine, plain = pair["engine"], pair["plain"]
        name = f"{pair['name']}, {engine['ranks']} x {engine['threads']}"
        yield f"{name}: wall / plain", engine["seconds"] / plain["seconds"], "", ".3f", None
        yield "  processor time / plain", engine["processor_seconds"] / plain["processor_seconds"], "", ".3f", None
        yield "  messages between ranks", engine["messages"], f"plain {plain['messages']}", ".0f", None
    engine, plain = figures["smallest"]["engine"], figures["smallest"]["plain"]
    above = 1e6 * (engine["processor_seconds"] - plain["processor_seconds"])
    yield "dataflow, a step of a block that waits for 4 values: processor time", above / blocks_of(engine), "us", ".2f", None
    yield "  each handler of it", above / engine["tasks"], "us", ".2f", None
    for place in ("local", "remote"):
        best = max(case["handlers_per_s_per_rank"] for case in figures["rate"][place])
        yield f"engine, a message of 4 bytes and its handler, {place}: one in", 1e6 / best, "us", ".2f", None


ROWS = {"transport": transport_rows, "latency": latency_rows, "rate": rate_rows, "migration": migration_rows,
        "balance": balance_rows, "trace": trace_rows, "idle": idle_rows,
        "examples": example_rows}


def verdict(value, required):
    if not required or required[0] == "BUSY":
        return required[0] if required else ""
    holds = value <= required[1] if required[0] == "<=" else value >= required[1]
    return "ok" if holds else "MISSED"


def print_table(rows):
    width = max(len(row[0]) for row in rows)
    for name, value, unit, form, required in rows:
        bound = f"{required[0]} {required[1]}" if required and required[0] != "BUSY" else ""
        print(f"{name:{width}}  {value:>10{form}} {unit:12} {bound:8} {verdict(value, required)}".rstrip())


def about():
    commit = subprocess.run(["git", "-C", ROOT, "rev-parse", "--short", "HEAD"], capture_output=True, text=True,
                            check=False).stdout.strip()
    models = [line.split(":", 1)[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")]
    return {"commit": commit, "processor": (models or ["unknown"])[0], "cores": os.cpu_count(),
            "load_before": os.getloadavg()}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", metavar="PART", help=f"of {', '.join(PARTS)} (default: all)")
    parser.add_argument("--repeats", type=int, default=3, help="runs of each balancing policy and example (default 3)")
    parser.add_argument("--bin", type=pathlib.Path, default=ROOT / "build/bin", help="folder of the programs")
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "build/bench/engine.json")
    options = parser.parse_args()
    unknown = set(options.parts) - set(PARTS)
    if unknown:
        parser.error(f"no part {', '.join(unknown)}")
    result, rows = {"about": about()}, []
    for part in options.parts or PARTS:
        if part == "balance":
            result[part] = {policy: [run(options.bin, part, policy) for _ in range(max(1, options.repeats))]
                            for policy in POLICIES}
        elif part == "examples":
            result[part] = run_examples(options.bin, max(1, options.repeats))
        else:
            result[part] = run(options.bin, part)
        rows += ROWS[part](result[part])
    result["about"]["load_after"] = os.getloadavg()
    options.out.parent.mkdir(parents=True, exist_ok=True)
    options.out.write_text(json.dumps(result, indent=2) + "\n")
    print_table(rows)
    if "examples" in result:
        print("published, on other machines:")
        for system, value, source in PUBLISHED:
            print(f"  {system}: {value} ({source})")
    verdicts = [verdict(row[1], row[4]) for row in rows if row[4]]
    missed, busy = verdicts.count("MISSED"), verdicts.count("BUSY")
    print(f"of {len(verdicts)} requirements {missed} missed, {busy} not measured; all figures: {options.out}")
    return 1 if missed or busy else 0


if __name__ == "__main__":
    sys.exit(main())
