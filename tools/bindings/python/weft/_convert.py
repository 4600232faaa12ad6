"""Meshes of meshio and PyVista to weft's and back. Neither is imported unless it is used, nor is NumPy."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Mapping, Optional

from . import _weft
from ._arguments import checked
from ._errors import InputError, UsageError

if TYPE_CHECKING:
    import meshio
    import numpy as np
    import pyvista

Mesh = _weft.Mesh
_Fields = Mapping[str, "np.ndarray"]
_VTK_LINE, _VTK_TRIANGLE, _VTK_TETRA = 3, 5, 10
_REFERENCES = ("ref", "medit:ref", "gmsh:physical", "cell_tags")


def _references(data: Mapping[str, Any]) -> Optional[str]:
    """The name of the cell data that are references, if any are."""
    return next((name for name in _REFERENCES if name in data), None)


def _whole_numbers(values: Any, name: str) -> np.ndarray:
    """References, which some formats keep as real numbers."""
    import numpy as np

    values = np.asarray(values)
    if values.dtype.kind == "f" and np.all(values == np.rint(values)):
        values = values.astype(np.int64)
    if values.dtype.kind not in "iu":
        raise InputError(f"{name}: are no whole numbers")
    return values.ravel()


def _turned(points: np.ndarray, tets: Optional[np.ndarray]) -> Optional[np.ndarray]:
    """Tets that are all of the other orientation, as some filters of VTK make them. A mesh with both kinds stays as it is:
    repair= looks at each of its tets."""
    import numpy as np

    def volumes(some: np.ndarray) -> np.ndarray:
        return np.linalg.det(points[some[:, 1:]] - points[some[:, :1]])

    if tets is None or len(tets) == 0 or tets.min() < 0 or tets.max() >= len(points) or points.shape[1:] != (3,):
        return tets  # what is wrong is said of the mesh
    if np.all(volumes(tets[:1]) < 0) and np.all(volumes(tets) < 0):
        return tets[:, [1, 0, 2, 3]]
    return tets


def from_meshio(mesh: "meshio.Mesh") -> Mesh:
    """A weft.Mesh of the linear tets, triangles and lines of a meshio.Mesh.

    References are the cell data called ref, medit:ref, gmsh:physical or cell_tags. Other volume elements are
    refused; vertices and the like are left out. Where all tets are inverted they are turned.
    """
    if not (hasattr(mesh, "cells") and hasattr(mesh, "cell_data")):
        raise UsageError(f"mesh: is a {type(mesh).__name__}, not a mesh of meshio")
    import numpy as np

    rows: dict = {"tetra": [], "triangle": [], "line": []}
    refs: dict = {"tetra": [], "triangle": [], "line": []}
    name = _references(mesh.cell_data)
    for number, block in enumerate(mesh.cells):
        if block.type in rows:
            rows[block.type].append(np.asarray(block.data))
            given = mesh.cell_data[name][number] if name else np.zeros(len(block.data), np.int32)
            refs[block.type].append(_whole_numbers(given, f"cell_data[{name!r}]"))
        elif block.type not in ("vertex",):
            raise InputError(f"cells[{number}]: {block.type} elements are not possible, only tetra, triangle and line")
    arrays = {kind: np.concatenate(blocks) if blocks else None for kind, blocks in rows.items()}
    labels = {kind: np.concatenate(blocks) if blocks else None for kind, blocks in refs.items()}
    points = np.asarray(mesh.points)
    return Mesh(points, _turned(points, arrays["tetra"]), arrays["triangle"], edges=arrays["line"], tet_refs=labels["tetra"],
                triangle_refs=labels["triangle"], edge_refs=labels["line"])


@checked
def to_meshio(mesh: Mesh, fields: Optional[_Fields] = None) -> "meshio.Mesh":
    """A meshio.Mesh of a weft.Mesh, with references as the cell data `ref` and fields as point data."""
    import meshio

    mesh = as_mesh(mesh)
    kinds = (("tetra", mesh.tets, mesh.tet_refs), ("triangle", mesh.triangles, mesh.triangle_refs),
             ("line", mesh.edges, mesh.edge_refs))
    there = [(kind, rows, refs) for kind, rows, refs in kinds if len(rows) > 0]
    point_data = {name: _flat(values) for name, values in (fields or {}).items()}
    return meshio.Mesh(mesh.points, [(kind, rows) for kind, rows, _ in there], point_data=point_data,
                       cell_data={"ref": [refs for _, _, refs in there]} if there else {})


def _flat(values: np.ndarray) -> np.ndarray:
    """Tensors (n, 3, 3) as (n, 9), which is how VTK has them."""
    import numpy as np

    values = np.asarray(values)
    return values.reshape(len(values), 9) if values.ndim == 3 else values


def _pyvista_refs(cell_data: Mapping[str, Any], types: np.ndarray, kind: int) -> Optional[np.ndarray]:
    import numpy as np

    name = _references(cell_data)
    return _whole_numbers(cell_data[name], f"cell_data[{name!r}]")[types == kind] if name else None


def _surface_refs(surface: "pyvista.PolyData", triangles: int) -> Optional[np.ndarray]:
    """Those of the polygons, which come behind vertices and lines in the data of a PolyData's cells."""
    cell_data = getattr(surface, "cell_data", {})
    name = _references(cell_data)
    if not name:
        return None
    first = surface.n_verts + surface.n_lines
    return _whole_numbers(cell_data[name], f"cell_data[{name!r}]")[first:first + triangles]


def from_pyvista(grid: "pyvista.UnstructuredGrid") -> Mesh:
    """A weft.Mesh of the linear tets, triangles and lines of a pyvista.UnstructuredGrid, or of the triangles of a
    pyvista.PolyData. References are the cell data called ref. Where all tets are inverted, as PyVista's to_tetrahedra() leaves
    them, they are turned."""
    import numpy as np

    if not hasattr(grid, "cells_dict"):
        if not hasattr(grid, "regular_faces"):
            raise UsageError(f"mesh: is a {type(grid).__name__}, not an UnstructuredGrid or PolyData of PyVista")
        triangles = np.asarray(grid.regular_faces)
        return Mesh(np.asarray(grid.points, np.float64), None, triangles, triangle_refs=_surface_refs(grid, len(triangles)))
    cells = grid.cells_dict
    types = np.asarray(grid.celltypes)
    strange = sorted(set(cells) - {1, _VTK_LINE, _VTK_TRIANGLE, _VTK_TETRA})
    if strange:
        raise InputError(f"cells: elements of VTK's types {strange} are not possible, only tets (10), triangles (5) "
                         "and lines (3)")
    points = np.asarray(grid.points, np.float64)
    return Mesh(points, _turned(points, cells.get(_VTK_TETRA)), cells.get(_VTK_TRIANGLE),
                edges=cells.get(_VTK_LINE), tet_refs=_pyvista_refs(grid.cell_data, types, _VTK_TETRA),
                triangle_refs=_pyvista_refs(grid.cell_data, types, _VTK_TRIANGLE),
                edge_refs=_pyvista_refs(grid.cell_data, types, _VTK_LINE))


def vtk_cells(mesh: Mesh, boundary: bool = False) -> tuple:
    """VTK's arrays of a mesh: cells (size, indices, size, indices, ...), types, references."""
    import numpy as np

    kinds = [(_VTK_TETRA, mesh.tets, mesh.tet_refs)]
    if boundary:
        kinds.append((_VTK_TRIANGLE, mesh.triangles, mesh.triangle_refs))
    cells = [np.column_stack([np.full(len(rows), rows.shape[1], np.int64), rows]).ravel() for _, rows, _ in kinds]
    types = [np.full(len(rows), kind, np.uint8) for kind, rows, _ in kinds]
    return np.concatenate(cells), np.concatenate(types), np.concatenate([refs for _, _, refs in kinds])


@checked
def to_pyvista(mesh: Mesh, fields: Optional[_Fields] = None, *,
               boundary: bool = False) -> "pyvista.UnstructuredGrid":
    """A pyvista.UnstructuredGrid of the tets (and, with `boundary`, the triangles) of a weft.Mesh, with references
    as the cell data `ref` and fields as point data."""
    import numpy as np
    import pyvista

    mesh = as_mesh(mesh)
    cells, types, refs = vtk_cells(mesh, boundary)
    grid = pyvista.UnstructuredGrid(cells, types, np.array(mesh.points))
    grid.cell_data["ref"] = refs
    for name, values in (fields or {}).items():
        grid.point_data[name] = _flat(values)
    return grid


def as_mesh(mesh: Any) -> Mesh:
    """A weft.Mesh of a weft.Mesh, a pair (points, tets), a dictionary of the arguments of weft.Mesh, a result of
    weft, a meshio.Mesh or a grid of PyVista."""
    if isinstance(mesh, Mesh):
        return mesh
    if isinstance(mesh, Mapping):
        strange = [name for name in mesh if not isinstance(getattr(Mesh, str(name), None), property)]
        if strange or "points" not in mesh:
            raise UsageError(f"mesh: has no member {strange[0]!r}" if strange else "mesh: has no points")
        return Mesh(**mesh)
    if isinstance(mesh, (tuple, list)):
        if not 2 <= len(mesh) <= 3:
            raise UsageError(f"mesh: has {len(mesh)} members, not points, tets and possibly triangles")
        return Mesh(*mesh)
    if isinstance(getattr(mesh, "mesh", None), Mesh):
        return mesh.mesh
    if hasattr(mesh, "cells") and hasattr(mesh, "cell_data") and hasattr(mesh, "get_cells_type"):
        return from_meshio(mesh)
    if hasattr(mesh, "points") and (hasattr(mesh, "cells_dict") or hasattr(mesh, "regular_faces")):
        return from_pyvista(mesh)
    raise UsageError(f"mesh: is a {type(mesh).__name__}, neither a weft.Mesh, (points, tets), a mesh of meshio nor one "
                     "of PyVista")
