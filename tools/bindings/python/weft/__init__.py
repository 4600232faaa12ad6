"""weft adapts tetrahedral meshes to anisotropic metric fields.

    import weft
    mesh = weft.read("wing.meshb")
    mach = weft.read_fields("mach.solb")
    fine = weft.adapt(mesh, solutions=mach, complexity=500_000, hgrad=1.5, fields=mach)
    weft.write("fine.meshb", fine)

Meshes are weft.Mesh, (points, tets) of NumPy, meshio's or PyVista's. Lengths and sizes are in the unit of the points.
Options are those of the command `weft adapt`, with _ for -: weft.options() lists them. Contiguous arrays are read in
place; what weft gives out owns its memory. Long calls let other threads of Python run, and may be made from several
threads at the same time. The library prints nothing; errors are exceptions (weft.Error).
"""

from __future__ import annotations

import json as _json
import os as _os
from dataclasses import dataclass as _dataclass, field as _field
from operator import index as _index
from typing import TYPE_CHECKING, Any, Callable, Dict, Iterator, List, Mapping, Optional, Sequence, Tuple, Union

from . import _errors, _weft
from ._arguments import checked as _checked, of_kind as _of_kind
from ._convert import as_mesh, from_meshio, from_pyvista, to_meshio, to_pyvista
from ._errors import (Error, InputError, InternalError, Interrupted, OptionError, OutOfMemory, RunError,
                      UsageError)

if TYPE_CHECKING:
    import numpy as _np  # 22 MB of memory, which calls that see no arrays do without

Mesh = _weft.Mesh
Metric = _weft.Metric
Result = _weft.Result
PartResult = _weft.PartResult
FilesResult = _weft.FilesResult
SimulatedFilesResult = _weft.SimulatedFilesResult
FillResult = _weft.FillResult
Cancel = _weft.Cancel

__version__ = _weft.version()

#: Anything that as_mesh() understands.
MeshLike = Any
#: A weft.Metric, or the values of one: (n,) sizes, (n, 3, 3) tensors, (n, 6) tensors with order=.
MetricLike = Any
#: progress(stage, done, tets): `done` is the share of the time, 0 to 1. Returning False cancels.
Progress = Callable[[str, float, int], Optional[bool]]
_Path = Union[str, bytes, "_os.PathLike[str]"]
_Point = Sequence[float]
_Fields = Mapping[str, "_np.ndarray"]

__all__ = [
    "Cancel", "Check", "Error", "FilesResult", "FillResult", "InputError", "InternalError", "Interrupted", "Mesh",
    "MeshFile", "Metric", "Option", "OptionError", "OutOfMemory", "PartResult", "Result", "RunError",
    "SimulatedFilesResult", "Transfer", "UsageError", "adapt", "adapt_files", "as_mesh", "ball_surface", "box",
    "compare_reports", "complexity", "convert", "cylinder_surface", "delta_wing_surface", "draw", "draw_histograms",
    "fill", "from_meshio", "from_pyvista", "interpolate", "loop", "make_metric", "measure", "options", "read",
    "read_fields", "read_file", "read_metric", "repair", "repair_metric", "repair_surface", "replay", "report_page",
    "stat", "task_graph", "tessellate", "to_meshio", "to_pyvista", "verify", "version_details", "write", "write_fields",
    "write_metric",
]


@_dataclass(frozen=True)
class Option:
    """An option of adapt(): its name, what values it has, what it means."""

    name: str
    type: str
    text: str


def options() -> List[Option]:
    """All options that adapt(), make_metric() and adapt_files() take by name."""
    return [Option(name.replace("-", "_"), kind, text) for name, kind, text, _ in _weft.named_options()]


def version_details() -> str:
    """What this weft was built of: compiler, libraries, processor."""
    return _weft.version_details()


# ---------------------------------------------------------------------------------------------------------------------
# Adaptation


def _as_metric(metric: MetricLike, order: Optional[str]) -> Optional[Metric]:
    order = _of_kind("order", order, "Optional[str]")
    return metric if metric is None or isinstance(metric, Metric) else Metric(metric, order=order)


def _some_metric(metric: MetricLike, order: Optional[str]) -> Metric:
    if metric is None:
        raise UsageError("metric: is None, not a weft.Metric nor the values of one")
    made = _as_metric(metric, order)
    assert made is not None
    return made


def _check_watch(progress: Any, cancel: Any) -> None:
    _of_kind("progress", progress, "Optional[Progress]")
    if cancel is not None and not isinstance(cancel, Cancel):
        raise UsageError(f"cancel: is a {type(cancel).__name__}, not a weft.Cancel")


def adapt(mesh: MeshLike, metric: MetricLike = None, *, fields: Optional[_Fields] = None,
          solutions: Optional[_Fields] = None, background: MeshLike = None, order: Optional[str] = None,
          progress: Optional[Progress] = None, cancel: Optional[Cancel] = None, comm: Any = None, ids: Any = None,
          tet_ids: Any = None, background_ids: Any = None, background_tet_ids: Any = None,
          **options: Any) -> Union[Result, PartResult]:
    """Adapts a mesh to a metric, and returns the new mesh, its metric and fields.

    mesh: see as_mesh(). Points (n, 3) float64, tets (m, 4) int64 or int32, indices from 0.
    metric: at the points: a weft.Metric, sizes (n,), tensors (n, 3, 3) or, with `order`, (n, 6); or None, where
        `solutions` or an option (metric_fn, implied, curvature, ...) make one. It is scaled to the option complexity
        (about half the points of the result), limited (hmin, hmax, aspect) and graded (hgrad).
    fields: carried along; name -> (n,), (n, 3), (n, 3, 3) or, with `order`, (n, 6). transfer="conservative" keeps
        their integrals.
    solutions: name -> (n,): the metric is that in which their interpolation error is least (norm, recovery).
    background: the mesh that `metric` and `solutions` belong to, where it is another of the same domain.
    order: 'sol' (11 12 22 13 23 33), 'rows' (11 12 13 22 23 33) or 'voigt' (11 22 33 23 13 12).
    progress, cancel: a function that is told how far the run is; an object by which any thread ends it. Ctrl-C ends
        it too: weft.Interrupted then has the valid mesh as its member `result`.
    comm: a communicator of mpi4py, whose ranks all make this call, each with what it has of the mesh; `ids` are the
        global numbers (n,) of its points, the same wherever a point is, and `tet_ids` (optional) of its tets. A rank
        may have no points. What is wrong on one rank is raised on all, naming the rank. A `background` is in parts
        too, any tets of it on any rank, with its `background_ids` and (optional) `background_tet_ids`.
    threads=1 gives the same bytes every time, those of the command.

    A run that is ended early returns the valid mesh that it has, with `cancelled` set. A whole mesh is not measured
    before that, nor is one with measure=False: goal_met, missed, summary() and json() of the result take the measures
    when they are first asked for.

    Raises InputError for data, OptionError for options, UsageError for arguments of a wrong kind, OutOfMemory, and
    RunError where ranks fail. Errors name arrays by argument and index; what they call a vertex, tet or triangle with
    a number counts from 1, as in files.
    """
    if comm is not None:
        return _adapt_parts(comm, (mesh, ids, tet_ids), (background, background_ids, background_tet_ids), metric,
                            fields, solutions, order, progress, cancel, options)
    if any(numbers is not None for numbers in (ids, tet_ids, background_ids, background_tet_ids)):
        raise UsageError("ids: are those of a mesh in parts, and need comm=")
    _check_watch(progress, cancel)
    return _weft.adapt(as_mesh(mesh), _as_metric(metric, order), options, fields, solutions, order,
                       _as_background(background), progress, cancel)


def _handle(comm: Any) -> int:
    """The communicator as MPI of Fortran knows it; it must be of the MPI that weft was built with."""
    if hasattr(comm, "py2f"):
        from mpi4py import MPI

        if _weft.mpi and MPI.get_vendor()[0] != _weft.mpi:
            raise UsageError(f"comm: is one of {MPI.get_vendor()[0]}, but weft was built with {_weft.mpi}")
        return comm.py2f()
    if isinstance(comm, int):
        return comm
    raise UsageError(f"comm: is a {type(comm).__name__}, not a communicator of mpi4py")


def _raise_issue(rank: int, text: str, cause: Optional[BaseException]) -> None:
    kind, _, said = text.partition("\n")
    error = getattr(_errors, kind, Error)
    raise error(f"rank {rank}: {said}") from cause


def _as_background(background: MeshLike) -> Optional[Mesh]:
    """What is wrong with its arrays is said of the background."""
    if background is None:
        return None
    try:
        return as_mesh(background)
    except (InputError, UsageError) as error:
        raise type(error)(f"background: {error}") from error


def _is_no_mesh_of_weft(mesh: MeshLike) -> bool:
    """as_mesh() makes one then, which nobody else has."""
    return not isinstance(mesh, Mesh) and not isinstance(getattr(mesh, "mesh", None), Mesh)


def _adapt_parts(comm: Any, part: Tuple[Any, Any, Any], background: Tuple[Any, Any, Any], metric: MetricLike,
                 fields: Any, solutions: Any, order: Optional[str], progress: Optional[Progress],
                 cancel: Optional[Cancel], options: Dict[str, Any]) -> PartResult:
    """`part`, `background`: mesh, ids of its points, ids of its tets."""
    handle = _handle(comm)
    issue, cause, prepared = "", None, None
    try:
        _check_watch(progress, cancel)
        mesh, ids, tet_ids = part
        other, *of_other = background
        if other is None and any(numbers is not None for numbers in of_other):
            raise UsageError("background_ids: are those of a background, and there is none")
        prepared = _weft.prepare_part(as_mesh(mesh), _as_metric(metric, order), ids, tet_ids, _as_background(other),
                                      *of_other, options, fields, solutions, order, _is_no_mesh_of_weft(mesh),
                                      _is_no_mesh_of_weft(other))
    except Exception as error:  # whatever it is, the other ranks are waiting to hear of it
        kind = type(error).__name__ if isinstance(error, Error) else "Error"
        issue, cause = f"{kind}\n{error}", error
    rank, text = _weft.first_error(handle, issue.encode(errors="replace"))  # names of files may be no UTF-8
    if rank >= 0:
        _raise_issue(rank, text, cause)
    return _weft.adapt_prepared(handle, prepared, progress, cancel)


@_checked
def adapt_files(input: _Path, output: _Path, *, fields: Sequence[_Path] = (), background: _Path = "",
                report: _Path = "", page: bool = True, case: str = "", graph: _Path = "", trace: _Path = "",
                simulate_ranks: int = 0, simulate_network: str = "2us,10GB/s", simulate_slowdown: float = 1,
                simulate_cores: int = 0, progress: Optional[Progress] = None, cancel: Optional[Cancel] = None, **options: Any) -> FilesResult:
    """From file to file, as `weft adapt INPUT -o OUTPUT` does; metric="FILE", sol=["FILE", ...] and the other options
    of the command say what the metric is.

    report: folder for report.json and (page) report.html, profile.json and, in subdomains,
    graph.json; case: published figures to show there.
    graph, trace: files for the task graph and a timeline, of runs in subdomains. simulate_ranks: so many ranks that
    this thread simulates, on a network, with processors slower by a factor and, unless 0, so many cores that they
    share; the result is a SimulatedFilesResult.
    Under mpirun it is a call of all ranks, which starts and ends MPI: only one can be made, unless mpi4py.MPI has been
    imported before.
    """
    _check_watch(progress, cancel)
    texts = dict(input=input, output=output, background=background, report=report, case=case, graph=graph, trace=trace)
    return _weft.adapt_files(texts, fields, page, options, simulate_ranks, simulate_network, simulate_slowdown,
                             simulate_cores, progress, cancel)


@_checked
def loop(mesh: MeshLike, solve: Callable[[Mesh], _Fields], complexities: Sequence[float], *,
         on: Optional[Sequence[str]] = None, **options: Any) -> Iterator[Tuple[Mesh, Dict[str, "_np.ndarray"]]]:
    """Solves and adapts in turns: yields (mesh, solution) before the first adaptation and after each.

    solve(mesh): the solution, name -> values at the points. `complexities`: one an adaptation. on: the names of the
    fields that drive the metric; all scalar ones by default. Other options go to adapt().
    """
    import numpy as np

    mesh = as_mesh(mesh)
    solution = dict(solve(mesh))
    yield mesh, solution
    for complexity_wanted in complexities:
        drive = {name: values for name, values in solution.items()
                 if (name in on if on is not None else np.ndim(values) == 1)}
        fine = adapt(mesh, solutions=drive, complexity=complexity_wanted, **options)
        mesh = fine.mesh
        solution = dict(solve(mesh))
        yield mesh, solution


# ---------------------------------------------------------------------------------------------------------------------
# Metrics, measures, checks, transfer


@_checked
def make_metric(mesh: MeshLike, metric: MetricLike = None, *, solutions: Optional[_Fields] = None,
                order: Optional[str] = None, **options: Any) -> Metric:
    """The metric that options ask for, as `weft metric` makes it: of `metric`, of solutions, of the mesh (implied=True),
    of its boundary (curvature, sagitta, wall); limited, graded (hgrad) and scaled (complexity). Warnings are issued
    as Python's."""
    made, warnings = _weft.make_metric(as_mesh(mesh), _as_metric(metric, order), options, solutions, order)
    for text in warnings:
        _warn(text)
    return made


def _warn(text: str) -> None:
    import warnings

    warnings.warn(text, stacklevel=3)


@_checked
def complexity(mesh: MeshLike, metric: MetricLike, *, order: Optional[str] = None) -> float:
    """The integral of sqrt(det M): about half the points of a mesh that conforms to the metric."""
    return _weft.complexity(as_mesh(mesh), _some_metric(metric, order))


@_checked
def measure(mesh: MeshLike, metric: MetricLike, *, order: Optional[str] = None) -> Dict[str, Any]:
    """Quality of the tets (mean ratio) and lengths of the edges in a metric, as report.json has them."""
    return _json.loads(_weft.measure(as_mesh(mesh), _some_metric(metric, order)))


@_checked
def stat(mesh: MeshLike, metric: MetricLike = None, *, order: Optional[str] = None,
         **options: Any) -> Dict[str, Any]:
    """What `weft stat` tells: counts, shapes, bounding box, volumes and areas by reference; with a metric also
    `measures` with histograms; with the options geometry (and geometry_scale) how the mesh lies on that CAD model,
    `model`."""
    told = _json.loads(_weft.stat(as_mesh(mesh), _as_metric(metric, order), options))
    shape, (least, most) = told["shape"], told["bounding_box"]
    figures = {"points": told["vertices"], **{name: told[name] for name in ("tets", "triangles", "edges", "corners",
                                                                            "ridges", "required")},
               "min": tuple(least), "max": tuple(most), "quality_mean": shape["quality"]["mean"],
               "quality_min": shape["quality"]["min"], "quality_q01": shape["quality"]["quantile_0.01"],
               "least_dihedral_degrees": shape["least_dihedral_degrees"]}
    for name in ("volume_by_ref", "area_by_ref"):
        figures[name] = {int(ref): value for ref, value in told[name].items()}
    return {**figures, **{name: told[name] for name in ("measures", "model") if name in told}}


@_dataclass(frozen=True)
class Check:
    """What verify() found. `problems` are sentences, which count entities from 1, as files do."""

    ok: bool
    problems: List[str]
    num_problems: int
    num_components: int
    volume: float
    volume_by_ref: Dict[int, float]
    area_by_ref: Dict[int, float]
    unreferenced_points: int
    touching_edges: int
    touching_vertices: int

    def __bool__(self) -> bool:
        return self.ok


@_checked
def verify(mesh: MeshLike, against: MeshLike = None, *, max_problems: int = 20) -> Check:
    """Checks with exact arithmetic that a mesh conforms. `against`: another mesh of the same domain, whose volumes and
    areas by reference must agree to 1e-9, as they do where the boundary is planar."""
    other = None if against is None else as_mesh(against)
    return Check(**_weft.verify(as_mesh(mesh), other, max_problems))


@_checked
def repair(mesh: MeshLike, fields: Optional[_Fields] = None, *,
           order: Optional[str] = None) -> Tuple[Mesh, Dict[str, "_np.ndarray"], List[str]]:
    """Mends what can be mended of a mesh that adapt() would refuse: the mesh, the fields at its points, and a line for
    each kind of mend. Raises InputError for what cannot be mended."""
    return _weft.repair(as_mesh(mesh), {} if fields is None else fields, order)


@_checked
def repair_metric(mesh: MeshLike, metric: "_np.ndarray", *,
                  order: Optional[str] = None) -> Tuple["_np.ndarray", List[str]]:
    """The same for sizes (n), or tensors (n, 3, 3) or, with an order, (n, 6): values that are not finite or not positive
    definite become means of their neighbours'. Tensors come back as (n, 3, 3)."""
    fields, mends = _weft.repair_metric(as_mesh(mesh), {"metric": metric}, order)
    return fields["metric"], mends


@_checked
def repair_surface(surface: MeshLike) -> Tuple[Mesh, List[str]]:
    """The same for triangles that are to bound a volume, before fill()."""
    return _weft.repair_surface(as_mesh(surface))


@_dataclass(frozen=True)
class Transfer:
    """Fields at the points of another mesh; how many of these lie outside the old mesh, and how far; for every
    component what became of its integral."""

    fields: Dict[str, "_np.ndarray"]
    outside: int
    farthest: float
    accounts: List[Dict[str, Any]] = _field(default_factory=list)


@_checked
def interpolate(mesh: MeshLike, fields: _Fields, to: MeshLike, *, transfer: str = "linear", threads: int = 0,
                order: Optional[str] = None) -> Transfer:
    """Fields at the points of `mesh`, at those of another. transfer: 'linear' or 'conservative'."""
    return Transfer(**_weft.interpolate(as_mesh(mesh), fields, as_mesh(to),
                                        {"transfer": transfer, "threads": threads}, order))


# ---------------------------------------------------------------------------------------------------------------------
# Initial meshes


@_checked
def fill(surface: MeshLike, *, growth: float = 1.3, size: float = 0, merge: float = 1e-9, materials: bool = False,
         remesh_surface: bool = False, background: MeshLike = None, metric: MetricLike = None,
         order: Optional[str] = None, progress: Optional[Progress] = None, cancel: Optional[Cancel] = None,
         **options: Any) -> FillResult:
    """Fills the volumes that closed triangles bound with tets, as `weft mesh` does.

    growth: of neighbouring edges away from the surface. size: the largest; 0: no limit. merge: points nearer than this
    share of the diagonal are one. materials: a shell within a volume bounds a material, not a hole (of a CAD model with
    several bodies each is filled, and voids between them only with materials). remesh_surface: the surface may be
    adapted too, within hausd. background, metric: sizes of another mesh instead of the surface's.
    Of the options threads, time_limit, max_memory, hausd, ridge_angle, repair, no_verify and, with remesh_surface, geometry
    and geometry_scale have a meaning.
    """
    _check_watch(progress, cancel)
    return _weft.fill(as_mesh(surface), growth, size, merge, materials, remesh_surface, _as_background(background),
                      _as_metric(metric, order), options, progress, cancel)


@_checked
def tessellate(geometry: _Path, *, geometry_scale: float = 1, hausd: float = 0, angle: float = 20) -> Mesh:
    """Triangles on a CAD model (.step, .iges, .brep, .egads), conforming, with its faces and edges as references.
    hausd: largest distance of an edge from the model, 0: 0.1 % of the diagonal and what a face's size and curvature
    bear. angle: degrees that the normal turns
    along an edge. fill(surface, remesh_surface=True, geometry=...) makes tets of them, as `weft mesh part.step` does.
    """
    return _weft.tessellate(dict(geometry=geometry, geometry_scale=geometry_scale, hausd=hausd), angle)


@_checked
def box(cells: Union[int, Sequence[int]] = 8, *, min: _Point = (0, 0, 0), max: _Point = (1, 1, 1)) -> Mesh:
    """A structured box: `cells` in x, y and z (or in each), of 6 tets. Its sides have the references 1 to 6."""
    try:
        counts = [_index(count) for count in (cells if hasattr(cells, "__len__") else [cells] * 3)]
    except TypeError:
        raise UsageError(f"cells: {cells!r} is neither a whole number nor three of them") from None
    if len(counts) != 3 or any(not 0 < count < 2**32 for count in counts):
        raise OptionError(f"--cells: {cells} are not three numbers above 0 and below 2^32")
    return _weft.box(counts, min, max)


@_checked
def ball_surface(radius: float = 1, *, center: _Point = (0, 0, 0), size: float = 0.1) -> Mesh:
    """The triangles of a sphere, with edges of length `size`; fill() makes tets of them."""
    return _weft.ball_surface(radius, center, size)


@_checked
def cylinder_surface(radius: float = 1, height: float = 2, *, base: _Point = (0, 0, 0),
                     size: float = 0.1) -> Mesh:
    """The triangles of an upright cylinder."""
    return _weft.cylinder_surface(radius, height, base, size)


@_checked
def delta_wing_surface(size: float = 0) -> Mesh:
    """The triangles of UGAWG's delta wing in its far-field box."""
    return _weft.delta_wing_surface(size)


# ---------------------------------------------------------------------------------------------------------------------
# Files and pictures


@_dataclass(frozen=True)
class MeshFile:
    """All that a file has: mesh, fields at its points, names of references ((dimension, ref) -> name), and what has no
    place here (what, how many)."""

    mesh: Mesh
    fields: Dict[str, "_np.ndarray"]
    names: Dict[Tuple[int, int], str]
    dropped: List[Tuple[str, int]]


@_checked
def read(path: _Path) -> Mesh:
    """Reads a mesh of any format that weft knows."""
    return _weft.read(path)


@_checked
def read_file(path: _Path) -> MeshFile:
    """Reads everything that a mesh file has."""
    return MeshFile(*_weft.read_all(path))


@_checked
def read_fields(path: _Path) -> Dict[str, "_np.ndarray"]:
    """The fields of a .solb or .sol, or of a mesh file that has some."""
    return _weft.read_fields(path)


@_checked
def read_metric(path: _Path, mesh: MeshLike) -> Metric:
    """The metric of a .solb or .sol for a mesh."""
    return _weft.read_metric(path, as_mesh(mesh))


@_checked
def write(path: _Path, mesh: MeshLike, *, metric: MetricLike = None, fields: Optional[_Fields] = None,
          order: Optional[str] = None, names: Optional[Mapping[Tuple[int, int], str]] = None) -> None:
    """Writes a mesh, or a result with its metric and fields as `weft adapt` does; whole or not at all."""
    if isinstance(mesh, (Result, PartResult)):
        metric = mesh.metric if metric is None else metric
        fields = mesh.fields if fields is None else fields
    _weft.write(path, as_mesh(mesh), _as_metric(metric, order), fields or {}, order, names)


@_checked
def convert(input: _Path, output: _Path, *, sol: _Path = "", encoding: str = "binary", msh_version: str = "4.1",
            compress: bool = False, pieces: int = 2) -> List[Tuple[str, int]]:
    """From file to file, with fields and names, as `weft convert` does; returns what had no place (what, how many).

    sol: a file of fields at the points. encoding: 'binary', 'ascii' (.msh, .stl, .ply, .vtu), 'big-endian' (.ply).
    msh_version: '4.1' or '2.2'. compress: arrays of a .vtu or .pvtu. pieces: of a .pvtu.
    """
    return _weft.convert(input, output, sol, encoding, msh_version, compress, pieces)


@_checked
def write_fields(path: _Path, fields: _Fields, *, order: Optional[str] = None) -> None:
    """Writes fields as .solb or .sol."""
    if not fields:
        raise UsageError("fields: there are none to write")
    _weft.write_fields(path, fields, order)


@_checked
def write_metric(path: _Path, metric: MetricLike, *, order: Optional[str] = None) -> None:
    """Writes a metric as .solb or .sol."""
    _weft.write_metric(path, _some_metric(metric, order))


@_checked
def draw(path: _Path, mesh: MeshLike, *, metric: MetricLike = None, field: Any = None, order: Optional[str] = None,
         **options: Any) -> None:
    """Draws a mesh into a .png, .svg or .pdf, as `weft view` does.

    field: (n,) values that colour the mesh. options: color_by (ref, quality, length, ...; the last two need the
    metric), size ("1600x1200"), view_from, up, clip, focus, range, title, only, zoom, line_width, dark, flip, slice,
    edges, legend, axes.
    """
    _weft.draw(path, as_mesh(mesh), _as_metric(metric, order), field, options)


@_checked
def draw_histograms(path: _Path, mesh: MeshLike, metric: MetricLike, *, order: Optional[str] = None,
                    title: str = "the mesh in the metric") -> None:
    """Draws histograms of quality and length in a metric into a .png, .svg or .pdf, as `weft stat --plot` does."""
    _weft.draw_histograms(path, as_mesh(mesh), _some_metric(metric, order), title)


@_checked
def replay(graph: _Path, *, ranks: int = 1, threads: int = 1, network: str = "2us,10GB/s", balancer: str = "stealing",
           slowdown: float = 1, processor_times: bool = False, copies: int = 1, split: int = 1, grow: float = 1,
           subdomain_bytes: int = 0, report: _Path = "", account: _Path = "", trace: _Path = "") -> Dict[str, Any]:
    """What a recorded run (graph.json or profile.json of report=) would take on another machine, as `weft replay` says.

    Returns its account (schema weft-replay-1), with the one for people as "summary". The options are those of the
    command. report: folder, account and trace: files to write; empty: none.
    """
    summary, told = _weft.replay(graph, ranks, threads, network, balancer, slowdown, processor_times, copies, split, grow,
                                 subdomain_bytes, report, account, trace)
    return {**_json.loads(told), "summary": summary}


@_checked
def task_graph(path: _Path, *, format: str = "dot", round: Optional[int] = None, subdomain: Optional[int] = None,
               collapse: str = "none", critical_path: bool = False, plan: bool = False) -> str:
    """The task graph of a run (graph.json, profile.json) as 'dot', 'graphml', 'json' or 'svg', as `weft graph` gives it.

    round, subdomain: only runs of this one. collapse: 'rounds' or 'subdomains' are one vertex each. critical_path: only
    that. plan: the planned graph, which is the same for every subdomain.
    """
    return _weft.task_graph(path, format, round, subdomain, collapse, critical_path, plan)


@_checked
def report_page(profile: _Path, page: _Path) -> None:
    """Writes the page of a run's profile.json."""
    _weft.report_page(profile, page)


@_checked
def compare_reports(a: _Path, b: _Path, *, page: _Path = "") -> str:
    """What got slower from run `a` to run `b` (profile.json or report.json), and how the meshes differ, as
    `weft report A B` says; `page`: a file for it as a page, too."""
    return _weft.compare_reports(a, b, page)
