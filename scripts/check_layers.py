#!/usr/bin/env python3
"""Reads every #include and fails on one that the layer diagram forbids; --self-test checks the checker."""

import argparse
import pathlib
import re
import sys
import tempfile

# Folder -> folders of this repository it may include (besides itself), in the order of the layers: below one of
# the five parts, a folder may know only folders that stand before it. The longest matching folder counts; a
# folder that is allowed does not bring along the folders within it.
GEOMETRY = ["geometry/model", "geometry/surface"]
MESHING = {
    "meshing/base": [],
    "meshing/mesh": ["base"],
    "meshing/mesh/repair": ["base", "mesh"],
    "meshing/geometry/model": ["base", "mesh"],
    "meshing/geometry/surface": ["base", "mesh", "geometry/model"],
    "meshing/cad": ["base", "mesh", "geometry/model", "io/files"],
    "meshing/metric": ["base", "mesh", "mesh/repair", *GEOMETRY],
    "meshing/metric/sources": ["base", "mesh", *GEOMETRY, "metric"],
    "meshing/fields": ["base", "mesh", *GEOMETRY, "metric"],
    "meshing/io/files": ["base", "mesh"],
    "meshing/io/gmf": ["base", "mesh", "io/files"],
    "meshing/io/vtk": ["base", "mesh", "io/files"],
    "meshing/io": ["base", "mesh", "io/files", "io/gmf", "io/vtk"],
    "meshing/kernel": ["base", "mesh", *GEOMETRY, "metric"],
    "meshing/operators": ["base", "mesh", *GEOMETRY, "metric", "kernel"],
    "meshing/adapt": ["base", "mesh", *GEOMETRY, "metric", "kernel", "operators"],
    "meshing/initial/grid": ["base", "mesh"],
    "meshing/initial/recovery": ["base", "mesh", "initial/grid"],
    "meshing/initial": ["base", "mesh", "mesh/repair", "metric", "kernel", "adapt", "io/files", "initial/grid", "initial/recovery"],
}
ENGINE = {
    "engine/base": [],
    "engine/json": [],
    "engine/trace": ["base", "json"],
    "engine/network": ["base"],
    "engine/mpi": ["base", "network"],
    "engine/objects": ["base", "trace"],
    "engine/schedule": ["base", "trace", "network", "objects"],
    "engine/balance": ["base", "trace", "objects", "schedule"],
    "engine/run": ["base", "trace", "network", "mpi", "objects", "schedule", "balance"],
    "engine/simulate": ["base", "trace", "network", "run"],
}
PARTITION = {
    "partition/subdomain": [],
    "partition/communication": ["subdomain"],
    "partition/decompose": ["communication", "subdomain"],
    "partition/refine": ["subdomain"],
    "partition/slice": ["communication"],
    "partition/surface": ["communication", "slice", "subdomain"],
    "partition/distribute": ["communication", "decompose", "refine", "slice", "subdomain", "surface"],
    "partition/metric": ["communication", "slice", "subdomain", "surface"],
    "partition/coordinate": ["communication", "decompose", "slice", "metric"],
    "partition/shift": ["subdomain"],
    "partition/divide": ["communication", "coordinate", "decompose", "distribute", "shift", "slice", "subdomain"],
    "partition/output": ["communication", "subdomain"],
    "partition/fields": ["communication", "decompose", "distribute", "metric", "output", "slice", "subdomain"],
    "partition/verify": ["communication", "output", "slice", "subdomain"],
    "partition/fit": ["communication", "decompose", "fields", "slice", "subdomain", "surface", "verify"],
}


def within(part, folders, others):
    """The rules of one part of the tree, whose folders are written without its name, and `others` it may know."""
    return {folder: [f"{part}/{known}" for known in known_folders] + others for folder, known_folders in folders.items()}


MESHING_FOLDERS, ENGINE_FOLDERS, PARTITION_FOLDERS = list(MESHING), list(ENGINE), list(PARTITION)
ALLOWED = {
    **within("meshing", MESHING, []),
    **within("engine", ENGINE, []),
    **within("partition", PARTITION, MESHING_FOLDERS),
    "graph/dataflow": ENGINE_FOLDERS,
    "graph/dataflow/dump": ["graph/dataflow", *ENGINE_FOLDERS],
    "graph/replay": ["graph/dataflow", "graph/dataflow/dump", *ENGINE_FOLDERS],
    "graph/examples": ["graph/dataflow", *ENGINE_FOLDERS],
    "graph/adaptation": ["graph/dataflow", *ENGINE_FOLDERS, *PARTITION_FOLDERS, *MESHING_FOLDERS],
    "tools": ["meshing", "engine", "partition", "graph"],
    "tools/common": [],
    "tools/picture": ["meshing/base", "meshing/mesh", "meshing/kernel", "meshing/metric", "meshing/io/files"],
    "tools/report": ["tools/picture", *MESHING_FOLDERS, "engine/json", "engine/trace", "graph/dataflow/dump"],
    "tools/library": ["tools/common", "tools/report", "tools/picture", "meshing", "engine", "partition", "graph"],
    "tools/weft": ["tools/common", "engine/json"],
    # Bindings translate: they know the public headers alone, which need no rule.
    "tools/bindings/c": [],
    "tools/bindings/petsc": [],
    "tools/bindings/python": [],
    "tools/bindings/fortran": [],
    "tests": ["meshing", "engine", "partition", "graph", "tools"],
}
# Parts whose rules hold for whole trees, not folder by folder.
WHOLE_TREES = ("tools", "tests")
# Library -> (pattern of its headers, paths that may include them).
LIBRARIES = {
    "MPI": (re.compile(r"(mpi|mpi-ext|mpio)\.h$"),
            ["engine/mpi/mpi_transport.cpp", "engine/mpi/mpi_version.cpp", "tools/library/include/weft/weft.h", "tools/library/jobs/ranks.",
             "tools/bindings/c/include/weft/weft-c.h", "graph/examples/plain_world.cpp",
             "tools/bench/engine/plain_mpi.cpp", "tests/engine/guest_test.cpp", "tests/support/fault_shim.cpp", "tests/library/",
             "tests/bindings/"]),
    "CGAL": (re.compile(r"CGAL/"), ["meshing/"]),
    "nlohmann's JSON": (re.compile(r"nlohmann/json\.hpp$"), ["engine/json/"]),
    "pugixml": (re.compile(r"pugixml"), ["meshing/io/vtk/vtk_xml.", "graph/dataflow/dump/graphml.cpp", "tests/graph/"]),
    "CGNS": (re.compile(r"(cgns|pcgns|hdf5|H5)"), ["meshing/io/cgns.", "meshing/io/cgns_", "tests/meshing/io/cgns_"]),
    "zlib": (re.compile(r"zlib"), ["meshing/io/vtk/vtk_bytes.", "tools/report/encode/gzip."]),
    "cairo": (re.compile(r"(cairo/)?cairo"), ["tools/picture/cairo_canvas.cpp"]),
    "Ceres": (re.compile(r"ceres/"), ["meshing/", "engine/"]),
    "PETSc": (re.compile(r"petsc"), ["tools/bindings/petsc/", "tests/bindings/petsc/"]),
    "OpenCASCADE": (re.compile(r"(Adaptor|BRep|GCPnts|Geom|IFSelect|IGES|Interface_|Message|Poly_|STEP|Shape|Standard|TCol|TKernel|"
                               r"Top|gp_?).*\.hxx$"),
                    ["meshing/cad/occ_", "tests/meshing/cad/"]),
    "SimGrid": (re.compile(r"simgrid/"), ["engine/simulate/simgrid_network.cpp"]),
    "METIS": (re.compile(r"metis\.h$"), ["partition/decompose/graph_partition.cpp"]),
}
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]')
SOURCES = {".h", ".hpp", ".cpp", ".cc", ".c", ".inl"}
FOLDERS = ["meshing", "engine", "partition", "graph", "tools", "tests"]


def layer_of(path):
    """The most specific folder of ALLOWED that holds `path`, or None for a path outside the repository."""
    holders = [folder for folder in ALLOWED if path.startswith(folder + "/")]
    return max(holders, key=len, default=None)


def part_of(path):
    """The top folder of a path of the repository, else None."""
    top = path.split("/")[0]
    return top if "/" in path and top in FOLDERS else None


def may_include(source, header):
    """Whether the layers allow it; both are files of the repository."""
    mine, theirs = layer_of(source), layer_of(header)
    if mine is None or theirs == mine and theirs is not None:
        return mine is not None
    if mine.split("/")[0] in WHOLE_TREES:
        return any(header.startswith(allowed + "/") for allowed in ALLOWED[mine])
    return theirs in ALLOWED[mine]


def problem_with(source, header):
    """Why the file `source` must not include `header`; None when it may. Both relative to the repository."""
    for library, (pattern, places) in LIBRARIES.items():
        if pattern.match(header) and not any(source.startswith(place) for place in places):
            return f"{library} may be included in {', '.join(places)} only"
    if header.startswith("../"):
        return "includes are written from the top folder"
    if part_of(header) is None:
        return None
    if layer_of(source) is None:
        return f"{source} is in no folder that has rules: see ALLOWED"
    if may_include(source, header):
        return None
    return f"{layer_of(source)}/ must not know {layer_of(header) or part_of(header)}/"


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
    ("meshing/base/a.cpp", "<mpi.h>"),
    ("engine/run/a.cpp", "<mpi.h>"),
    ("tools/bench/engine/transport_bench.cpp", "<mpi.h>"),
    ("meshing/a.cpp", '"meshing/base/ids.h"'),
    ("meshing/base/a.h", '"meshing/mesh/mesh_data.h"'),
    ("meshing/mesh/a.h", '"meshing/metric/metric.h"'),
    ("meshing/metric/a.h", '"meshing/kernel/kernel.h"'),
    ("meshing/kernel/a.h", '"meshing/operators/split_edge.h"'),
    ("meshing/operators/a.h", '"meshing/adapt/worklist.h"'),
    ("meshing/adapt/a.h", '"meshing/initial/shapes.h"'),
    ("meshing/adapt/a.h", '"meshing/io/gmf/gmf.h"'),
    ("meshing/io/gmf/a.h", '"meshing/io/mesh_file.h"'),
    ("meshing/io/a.h", '"meshing/kernel/kernel.h"'),
    ("meshing/kernel/a.cpp", '"engine/objects/message.h"'),
    ("meshing/kernel/a.cpp", '"partition/decompose/decomposition.h"'),
    ("meshing/io/a.cpp", '"graph/dataflow/node.h"'),
    ("meshing/io/a.cpp", '"tools/weft/text.h"'),
    ("meshing/io/a.cpp", '"../engine/base/rank.h"'),
    ("engine/base/a.cpp", '"meshing/metric/metric.h"'),
    ("engine/network/a.h", '"engine/mpi/mpi_transport.h"'),
    ("engine/schedule/a.h", '"engine/balance/balancer.h"'),
    ("engine/simulate/simulation.cpp", "<simgrid/s4u.hpp>"),
    ("partition/shift/a.h", '"engine/objects/message.h"'),
    ("partition/shift/a.h", '"partition/communication/peers.h"'),
    ("partition/subdomain/a.h", '"partition/shift/shift.h"'),
    ("partition/shift/a.h", "<CGAL/Kernel.h>"),
    ("partition/decompose/decomposition.cpp", "<metis.h>"),
    ("meshing/io/gmf/gmf.cpp", "<pugixml.hpp>"),
    ("tools/weft/a.cpp", "<zlib.h>"),
    ("tools/weft/a.cpp", "<nlohmann/json.hpp>"),
    ("meshing/io/vtk/vtu.cpp", "<cgnslib.h>"),
    ("tools/weft/a.cpp", "<CGAL/Kernel.h>"),
    ("tools/picture/canvas.cpp", "<cairo.h>"),
    ("tools/weft/commands/view_command.cpp", "<cairo-pdf.h>"),
    ("graph/dataflow/dump/dot.cpp", "<pugixml.hpp>"),
    ("graph/dataflow/a.h", '"graph/dataflow/dump/dot.h"'),
    ("graph/dataflow/a.h", '"meshing/metric/metric.h"'),
    ("graph/dataflow/a.h", '"partition/decompose/decomposition.h"'),
    ("graph/dataflow/a.h", '"graph/adaptation/progress.h"'),
    ("graph/adaptation/a.h", '"tools/weft/text.h"'),
    ("graph/examples/a.cpp", '"partition/decompose/decomposition.h"'),
    ("graph/examples/heat_plain.cpp", "<mpi.h>"),
    ("tools/weft/commands/a.cpp", '"tests/support/fixtures.h"'),
    ("tools/weft/commands/a.cpp", '"meshing/io/mesh_file.h"'),
    ("tools/weft/commands/a.cpp", '"tools/library/jobs/monitor.h"'),
    ("tools/library/jobs/a.cpp", '"tools/weft/terminal/progress.h"'),
    ("tools/bindings/python/a.cpp", '"tools/library/jobs/monitor.h"'),
    ("tools/bindings/c/a.cpp", '"meshing/base/error.h"'),
    ("tools/bindings/python/a.cpp", '"tools/bindings/c/objects.h"'),
    ("tools/bindings/c/a.cpp", "<mpi.h>"),
    ("tools/library/jobs/a.cpp", "<petscdmplex.h>"),
    ("tools/picture/a.cpp", '"tools/report/page.h"'),
    ("tools/picture/a.cpp", '"partition/shift/scatter.h"'),
    ("tools/report/a.cpp", '"partition/shift/scatter.h"'),
]
PERMITTED = [
    ("engine/mpi/mpi_transport.cpp", "<mpi.h>"),
    ("meshing/mesh/predicates.cpp", "<CGAL/Kernel.h>"),
    ("meshing/io/vtk/vtk_xml.h", "<pugixml.hpp>"),
    ("graph/dataflow/dump/graphml.cpp", "<pugixml.hpp>"),
    ("meshing/io/a.cpp", '"meshing/io/gmf/gmf.h"'),
    ("meshing/operators/a.cpp", '"meshing/kernel/kernel.h"'),
    ("partition/shift/a.h", '"meshing/metric/metric.h"'),
    ("partition/output/a.h", '"partition/communication/peers.h"'),
    ("graph/adaptation/a.h", '"graph/dataflow/node.h"'),
    ("graph/examples/a.cpp", '"graph/dataflow/node.h"'),
    ("graph/examples/plain_world.cpp", "<mpi.h>"),
    ("partition/decompose/graph_partition.cpp", "<metis.h>"),
    ("graph/adaptation/a.h", '"partition/decompose/decomposition.h"'),
    ("tools/library/a.cpp", '"graph/adaptation/progress.h"'),
    ("tools/weft/commands/a.cpp", '"weft/weft.h"'),
    ("tools/bindings/c/a.cpp", '"weft/weft.h"'),
    ("tools/bindings/c/a.cpp", '"tools/bindings/c/objects.h"'),
    ("tools/weft/commands/a.cpp", '"tools/common/text.h"'),
    ("tests/tools/a.cpp", '"tools/weft/text.h"'),
    ("tools/picture/cairo_canvas.cpp", "<cairo.h>"),
    ("meshing/base/a.cpp", "<vector>"),
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
