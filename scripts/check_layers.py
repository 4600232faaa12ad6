#!/usr/bin/env python3
"""Reads every #include and fails on one that the layer diagram forbids; --self-test checks the checker."""

import argparse
import pathlib
import re
import sys
import tempfile

# Folder -> folders of this repository it may include (besides itself). The longest matching folder counts.
ALLOWED = {
    "meshing": [],
    "engine": [],
    "partition": ["meshing"],
    "graph": ["engine", "partition", "meshing"],
    "graph/dataflow": ["engine"],
    "graph/adaptation": ["graph/dataflow", "engine", "partition", "meshing"],
    "tools": ["meshing", "engine", "partition", "graph"],
    "tests": ["meshing", "engine", "partition", "graph", "tools"],
}
# Library -> (pattern of its headers, paths that may include them).
LIBRARIES = {
    "MPI": (re.compile(r"(mpi|mpi-ext|mpio)\.h$"), ["engine/mpi_transport.cpp", "tools/bench/engine/plain_mpi.cpp"]),
    "CGAL": (re.compile(r"CGAL/"), ["meshing/"]),
    "pugixml": (re.compile(r"pugixml"), ["meshing/io/vtk_xml.", "graph/dataflow/graphml.cpp", "tests/graph/"]),
    "CGNS": (re.compile(r"(cgns|pcgns|hdf5|H5)"), ["meshing/io/cgns."]),
    "zlib": (re.compile(r"zlib"), ["meshing/io/vtk_xml.", "tools/report/gzip."]),
    "cairo": (re.compile(r"(cairo/)?cairo"), ["tools/picture/canvas.cpp"]),
    "Ceres": (re.compile(r"ceres/"), ["meshing/", "engine/"]),
    "METIS": (re.compile(r"metis\.h$"), ["partition/graph_partition.cpp"]),
}
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]')
SOURCES = {".h", ".hpp", ".cpp", ".cc", ".c", ".inl"}
FOLDERS = ["meshing", "engine", "partition", "graph", "tools", "tests"]


def layer_of(path):
    """The most specific folder of ALLOWED that holds `path`, or None for a path outside the repository."""
    holders = [folder for folder in ALLOWED if path.startswith(folder + "/")]
    return max(holders, key=len, default=None)


def problem_with(source, header):
    """Why the file `source` must not include `header`; None when it may. Both relative to the repository."""
    for library, (pattern, places) in LIBRARIES.items():
        if pattern.match(header) and not any(source.startswith(place) for place in places):
            return f"{library} may be included in {', '.join(places)} only"
    if header.startswith("../"):
        return "includes are written from the top folder"
    mine, theirs = layer_of(source), layer_of(header)
    if theirs is None or theirs == mine:
        return None
    if not any((theirs + "/").startswith(allowed + "/") for allowed in ALLOWED[mine]):
        return f"{mine}/ must not know {theirs}/"
    return None


def check(root):
    """All forbidden includes below `root`, as FILE:LINE: sentences, and the number of files read."""
    problems, files = [], 0
    for folder in FOLDERS:
        for path in sorted((root / folder).rglob("*")):
            if path.suffix not in SOURCES:
                continue
            files += 1
            source = path.relative_to(root).as_posix()
            for number, line in enumerate(path.read_text(errors="replace").splitlines(), 1):
                include = INCLUDE.match(line)
                problem = include and problem_with(source, include.group(1))
                if problem:
                    problems.append(f"{source}:{number}: {line.strip()}: {problem}")
    return problems, files


FORBIDDEN = [
    ("meshing/a.cpp", "<mpi.h>"),
    ("engine/a.cpp", "<mpi.h>"),
    ("tools/bench/engine/transport_bench.cpp", "<mpi.h>"),
    ("meshing/a.cpp", '"engine/mobile.h"'),
    ("meshing/a.cpp", '"partition/decomposition.h"'),
    ("meshing/io/a.cpp", '"graph/dataflow/node.h"'),
    ("meshing/a.cpp", '"tools/weft/text.h"'),
    ("meshing/a.cpp", '"../engine/mobile.h"'),
    ("engine/a.cpp", '"meshing/metric.h"'),
    ("partition/a.h", '"engine/mobile.h"'),
    ("partition/a.h", "<CGAL/Kernel.h>"),
    ("partition/decomposition.cpp", "<metis.h>"),
    ("meshing/io/gmf.cpp", "<pugixml.hpp>"),
    ("tools/weft/a.cpp", "<zlib.h>"),
    ("meshing/io/vtu.cpp", "<cgnslib.h>"),
    ("tools/weft/a.cpp", "<CGAL/Kernel.h>"),
    ("tools/picture/legend.cpp", "<cairo.h>"),
    ("tools/weft/view_command.cpp", "<cairo-pdf.h>"),
    ("graph/dataflow/dot.cpp", "<pugixml.hpp>"),
    ("graph/dataflow/a.h", '"meshing/metric.h"'),
    ("graph/dataflow/a.h", '"partition/decomposition.h"'),
    ("graph/dataflow/a.h", '"graph/adaptation/converged.h"'),
    ("graph/adaptation/a.h", '"tools/weft/text.h"'),
    ("tools/weft/a.cpp", '"tests/support/fixtures.h"'),
]
PERMITTED = [
    ("engine/mpi_transport.cpp", "<mpi.h>"),
    ("meshing/predicates.cpp", "<CGAL/Kernel.h>"),
    ("meshing/io/vtk_xml.h", "<pugixml.hpp>"),
    ("graph/dataflow/graphml.cpp", "<pugixml.hpp>"),
    ("meshing/a.cpp", '"meshing/io/gmf.h"'),
    ("partition/a.h", '"meshing/metric.h"'),
    ("graph/adaptation/a.h", '"graph/dataflow/node.h"'),
    ("partition/graph_partition.cpp", "<metis.h>"),
    ("graph/adaptation/a.h", '"partition/decomposition.h"'),
    ("tools/weft/a.cpp", '"graph/adaptation/converged.h"'),
    ("tests/tools/a.cpp", '"tools/weft/text.h"'),
    ("tools/picture/canvas.cpp", "<cairo.h>"),
    ("meshing/a.cpp", "<vector>"),
]


def found_in_tree(source, header):
    """True when check() reports a tree whose only include is this one."""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / source
        path.parent.mkdir(parents=True)
        path.write_text(f"// A file.\n#include {header}\n")
        problems, files = check(pathlib.Path(folder))
        assert files == 1
        return len(problems) == 1


def self_test():
    missed = [case for case in FORBIDDEN if not found_in_tree(*case)]
    accused = [case for case in PERMITTED if found_in_tree(*case)]
    for source, header in missed:
        print(f"not caught: {source} includes {header}")
    for source, header in accused:
        print(f"wrongly caught: {source} includes {header}")
    print(f"{len(FORBIDDEN)} forbidden and {len(PERMITTED)} permitted includes tried")
    return not missed and not accused


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--root", type=pathlib.Path, default=pathlib.Path(__file__).resolve().parent.parent)
    parser.add_argument("--self-test", action="store_true")
    options = parser.parse_args()
    if options.self_test:
        return 0 if self_test() else 1
    problems, files = check(options.root)
    print("\n".join(problems) if problems else f"{files} files respect the layers")
    return 1 if problems or files == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
