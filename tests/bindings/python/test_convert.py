"""Meshes of meshio and PyVista."""

import types

import numpy as np
import pytest

import weft


def equal(a, b):
    return all(np.array_equal(getattr(a, name), getattr(b, name)) for name in
               ("points", "tets", "triangles", "edges", "tet_refs", "triangle_refs", "edge_refs"))


def test_meshio_there_and_back(box):
    meshio = pytest.importorskip("meshio")
    other = weft.to_meshio(box, {"x": box.points[:, 0], "t": np.broadcast_to(np.eye(3), (len(box.points), 3, 3))})
    assert isinstance(other, meshio.Mesh) and other.point_data["t"].shape == (64, 9)
    assert equal(weft.from_meshio(other), box)
    assert equal(weft.as_mesh(other), box)


def test_meshio_files_are_adapted(tmp_path, box, sizes):
    meshio = pytest.importorskip("meshio")
    weft.to_meshio(box).write(tmp_path / "box.vtu")
    fine = weft.adapt(meshio.read(tmp_path / "box.vtu"), sizes, threads=1)
    assert equal(fine.mesh, weft.adapt(weft.from_meshio(weft.to_meshio(box)), sizes, threads=1).mesh)


def test_other_elements_are_refused():
    meshio = pytest.importorskip("meshio")
    hexahedron = meshio.Mesh(np.zeros((8, 3)), [("hexahedron", [list(range(8))])])
    with pytest.raises(weft.InputError, match=r"cells\[0\]: hexahedron"):
        weft.as_mesh(hexahedron)


def grid_of(mesh):
    """What a pyvista.UnstructuredGrid offers, for machines without PyVista."""
    kinds = np.concatenate([np.full(len(mesh.tets), 10), np.full(len(mesh.triangles), 5)])
    return types.SimpleNamespace(points=mesh.points, cells_dict={10: mesh.tets, 5: mesh.triangles}, celltypes=kinds,
                                 cell_data={"ref": np.concatenate([mesh.tet_refs, mesh.triangle_refs]).astype(float)})


def test_grids_like_pyvistas_are_understood(box):
    mesh = weft.as_mesh(grid_of(box))
    assert np.array_equal(mesh.tets, box.tets) and np.array_equal(mesh.triangle_refs, box.triangle_refs)
    surface = types.SimpleNamespace(points=box.points, regular_faces=box.triangles)
    assert np.array_equal(weft.as_mesh(surface).triangles, box.triangles)


def test_references_of_surfaces_like_pyvistas_are_read(box):
    refs = np.arange(len(box.triangles)) % 7
    surface = types.SimpleNamespace(points=box.points, regular_faces=box.triangles, cell_data={"ref": refs}, n_verts=0, n_lines=0)
    assert np.array_equal(weft.as_mesh(surface).triangle_refs, refs)
    surface.n_verts, surface.n_lines = 2, 1  # vertices, lines, polygons, strips
    surface.cell_data = {"ref": np.concatenate([[-1, -1, -2], refs, [-3]])}
    assert np.array_equal(weft.as_mesh(surface).triangle_refs, refs)


def test_tets_that_are_all_inverted_are_turned(box):
    grid = grid_of(box)
    grid.cells_dict[10] = np.array(box.tets)[:, [0, 2, 1, 3]]
    assert weft.verify(weft.as_mesh(grid), against=box)
    grid.cells_dict[10][0] = box.tets[0]
    assert not weft.verify(weft.as_mesh(grid))


def test_vtk_arrays_count_vertices_cell_by_cell(box):
    cells, kinds, refs = weft._convert.vtk_cells(box, boundary=True)
    assert len(cells) == 5 * len(box.tets) + 4 * len(box.triangles)
    assert np.array_equal(cells[:5 * len(box.tets)].reshape(-1, 5)[:, 1:], box.tets)
    assert len(kinds) == len(refs) == len(box.tets) + len(box.triangles) and set(kinds) == {5, 10}


def test_pyvista_there_and_back(box):
    pytest.importorskip("pyvista")
    grid = weft.to_pyvista(box, {"x": box.points[:, 0]}, boundary=True)
    back = weft.as_mesh(grid)
    assert np.array_equal(back.tets, box.tets) and np.array_equal(back.triangles, box.triangles)
    assert np.array_equal(back.tet_refs, box.tet_refs) and np.array_equal(grid.point_data["x"], box.points[:, 0])
