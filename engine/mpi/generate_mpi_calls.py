#!/usr/bin/env python3
"""Writes a C++ source that counts the calls of every MPI function and passes them on (MPI's profiling interface)."""

import argparse
import pathlib
import re
import subprocess
import sys

PROTOTYPE = re.compile(
    r"\b(?P<type>int|double|MPI_\w+)\s+(?P<name>MPI_\w+)\s*\((?P<arguments>[^()]*)\)(?P<rest>[^;{}]*);")
PARAMETER = re.compile(r"^(?P<before>.*[\s*])(?P<name>[A-Za-z_]\w*)\s*(?P<after>(?:\[[^\]]*\]\s*)*)$", re.DOTALL)
# mpi.h declares some 400 functions, and these at least: fewer found means it was not understood.
FEWEST = 100
NEEDED = {"MPI_Isend", "MPI_Irecv", "MPI_Testsome", "MPI_Allreduce", "MPI_Init_thread"}

HEAD = """\
// Counts every MPI call by name and passes it on. Written by generate_mpi_calls.py from mpi.h; do not edit.
#include <mpi.h>

#include <atomic>
#include <cstddef>

namespace weft::engine::mpi_layer {
extern const char* const names[];
extern std::atomic<long> counts[];
extern const std::size_t size;
"""


def preprocessed(compiler, header):
    """The header with all that it includes, comments gone, macros expanded, and their definitions kept."""
    command = [compiler, "-E", "-dD", "-P", "-DOMPI_SKIP_MPICXX", "-DMPICH_SKIP_MPICXX", "-I", header.parent, "-x", "c",
               header]
    return subprocess.run(command, check=True, capture_output=True, text=True, errors="replace").stdout


def parameter_names(arguments):
    """The names in a parameter list; None when one has none (or is "...", which cannot be passed on)."""
    if arguments.strip() in ("", "void"):
        return []
    matches = [PARAMETER.match(parameter.strip()) for parameter in arguments.split(",")]
    return [match["name"] for match in matches] if all(matches) else None


def functions_in(header):
    """(return type, name, parameters, their names) of each function that can be wrapped, sorted by name."""
    macros = set(re.findall(r"^\s*#\s*define\s+(\w+)", header, flags=re.MULTILINE))
    declared = re.sub(r"^\s*#[^\n]*$", "", header, flags=re.MULTILINE)
    found = {}
    for match in PROTOTYPE.finditer(declared):
        name = match["name"]
        names = parameter_names(match["arguments"])
        wrappable = (
            names is not None
            and name not in macros  # a removed function, or one that MPI implements as a macro
            and "f08" not in name  # of MPI's Fortran library, which a C program is not linked with
            and "removed" not in match["rest"]
            and "deprecated" not in match["rest"].lower()
            and re.search(rf"\bP{name}\s*\(", declared))  # no PMPI twin: nothing to pass the call on to
        if wrappable:
            found[name] = (match["type"], name, " ".join(match["arguments"].split()), names)
    return [found[name] for name in sorted(found)]


def source_of(functions):
    lines = [HEAD, "const char* const names[] = {"]
    lines += [f'    "{name}",' for _, name, _, _ in functions]
    lines += ["};", f"std::atomic<long> counts[{len(functions)}];", f"const std::size_t size = {len(functions)};",
              "static void called(std::size_t function) { counts[function].fetch_add(1, std::memory_order_relaxed); }",
              "}  // namespace weft::engine::mpi_layer", "", 'extern "C" {', ""]
    for index, (result, name, parameters, names) in enumerate(functions):
        lines += [f"{result} {name}({parameters}) {{", f"  weft::engine::mpi_layer::called({index});",
                  f"  return P{name}({', '.join(names)});", "}", ""]
    lines += ['}  // extern "C"', ""]
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("header", type=pathlib.Path, help="mpi.h")
    parser.add_argument("output", type=pathlib.Path, help="the C++ source to write")
    parser.add_argument("--compiler", default="cc", help="a C compiler that preprocesses as GCC does (default: cc)")
    arguments = parser.parse_args()
    functions = functions_in(preprocessed(arguments.compiler, arguments.header))
    missing = NEEDED - {name for _, name, _, _ in functions}
    if len(functions) < FEWEST or missing:
        sys.exit(f"{arguments.header}: found {len(functions)} functions, not among them: "
                 f"{', '.join(sorted(missing)) or 'none of the needed'}; is this mpi.h?")
    arguments.output.write_text(source_of(functions))


if __name__ == "__main__":
    main()
