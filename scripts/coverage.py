#!/usr/bin/env python3
"""Writes the coverage that gcovr's JSON file holds as Markdown: a table by folder, then the error paths that nothing ran.

    coverage.py COVERAGE.json > coverage.md

An error path is a statement that throws, or a line in the body of a catch. Lines are the compiler's: what it made no code for counts
neither way.
"""

import collections
import json
import pathlib
import re
import sys

THROWS = re.compile(r"\b(throw|rethrow_exception|std::terminate|std::abort|MPI_Abort)\b")
CATCHES = re.compile(r"\bcatch\s*\(")


def catch_bodies(lines):
    """The numbers of the lines in bodies of catch, by counting braces."""
    inside, depth, begins = set(), 0, []
    waits = False
    for number, line in enumerate(lines, 1):
        code = re.sub(r'"(\\.|[^"\\])*"|\'(\\.|[^\'\\])*\'|//.*', "", line)
        if begins:
            inside.add(number)
        catch = CATCHES.search(code)
        for place, sign in enumerate(code):
            if catch and place == catch.start():
                waits = True
            if sign == "{":
                depth += 1
                if waits:
                    begins.append(depth)
                    waits = False
            elif sign == "}":
                if begins and begins[-1] == depth:
                    begins.pop()
                depth -= 1
    return inside


def main():
    root = pathlib.Path(__file__).resolve().parent.parent
    files = json.loads(pathlib.Path(sys.argv[1]).read_text())["files"]
    counts = collections.defaultdict(lambda: [0, 0, 0, 0])  # lines, run; error paths, run
    never = {}
    for entry in files:
        source = (root / entry["file"]).read_text().splitlines()
        caught = catch_bodies(source)
        runs = collections.defaultdict(int)
        for line in entry["lines"]:
            if not line.get("gcovr/noncode", False):
                runs[line["line_number"]] += line["count"]
        folder = "/".join(entry["file"].split("/")[:2])
        for number, count in runs.items():
            text = source[number - 1] if number <= len(source) else ""
            counted = counts[folder]
            counted[0] += 1
            counted[1] += count > 0
            if number in caught or THROWS.search(text):
                counted[2] += 1
                counted[3] += count > 0
                if count == 0:
                    never.setdefault(entry["file"], []).append((number, text.strip()))
    print("| folder | lines | run | error paths | run |\n|---|---|---|---|---|")
    total = [sum(column) for column in zip(*counts.values())]
    for folder, row in [*sorted(counts.items()), ("all", total)]:
        share = [f"{100 * row[i + 1] / row[i]:.1f} %" if row[i] else "-" for i in (0, 2)]
        print(f"| {folder} | {row[0]:,} | {share[0]} | {row[2]:,} | {share[1]} |")
    print("\n## Error paths that nothing ran\n")
    for file, lines in sorted(never.items()):
        print(f"- `{file}`")
        for number, text in lines:
            print(f"  - {number}: `{text}`")


if __name__ == "__main__":
    main()
