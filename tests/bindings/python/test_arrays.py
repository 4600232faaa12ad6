"""NumPy in and out: what is accepted, what is refused and how that is said, what is a view of what."""

import gc

import numpy as np
import pytest

import weft


def test_arrays_come_back_as_they_went_in(box):
    points, tets = np.array(box.points), np.array(box.tets, np.int64)
    mesh = weft.Mesh(points, tets, box.triangles, edges=box.edges, tet_refs=np.arange(len(tets)),
                     triangle_refs=box.triangle_refs, ridges=box.ridges, corners=[0, 1])
    assert np.array_equal(mesh.points, points) and mesh.points.dtype == np.float64
    assert np.array_equal(mesh.tets, tets) and mesh.tets.dtype == np.int32
    assert np.array_equal(mesh.tet_refs, np.arange(len(tets)))
    assert np.array_equal(mesh.triangle_refs, box.triangle_refs)
    assert list(mesh.corners) == [0, 1] and np.array_equal(mesh.ridges, box.ridges)


@pytest.mark.parametrize("kind", [np.int32, np.int64, np.uint32, np.uint64, np.int16, ">i8"])
def test_indices_of_any_integer_type_and_layout_mean_the_same(box, kind):
    points = np.asfortranarray(box.points)
    mesh = weft.Mesh(points, np.asfortranarray(box.tets.astype(kind)))
    assert np.array_equal(mesh.tets, box.tets) and np.array_equal(mesh.points, box.points)


def test_views_keep_the_mesh_and_cannot_be_written_to():
    points = weft.box(2).points
    gc.collect()
    assert points.shape == (27, 3) and points.max() == 1
    with pytest.raises(ValueError):
        points[0] = 5


@pytest.mark.parametrize("arguments, error, text", [
    (dict(points=np.zeros((4, 2))), weft.InputError, r"points: has shape \(4, 2\), not \(n, 3\)"),
    (dict(points=np.zeros(3)), weft.InputError, r"points: has shape \(3,\)"),
    (dict(points=[[0, 0, np.nan]]), weft.InputError, r"points\[0\]: is not finite"),
    (dict(points="here"), weft.UsageError, "points: has dtype"),
    (dict(points=[[0, 0, 0]], tets=[[0, 0, 0, 1]]), weft.InputError, r"tets\[0, 3\]: 1 is not an index of the 1 points"),
    (dict(points=[[0, 0, 0]], tets=[[0, 0, 0, -1]]), weft.InputError, r"tets\[0, 3\]: -1 is not an index"),
    (dict(points=[[0, 0, 0]], tets=[[0.0, 0, 0, 0]]), weft.UsageError, "tets: has dtype float64"),
    (dict(points=[[0, 0, 0]], tets=[0, 0, 0, 0]), weft.InputError, r"tets: has shape \(4,\), not \(n, 4\)"),
    (dict(points=[[0, 0, 0]], point_refs=[1, 2]), weft.InputError, "point_refs: has 2 references"),
    (dict(points=[[0, 0, 0]], point_refs=[2**40]), weft.InputError, r"point_refs\[0\]: 1099511627776 does not fit"),
    (dict(points=[[0, 0, 0]], ridges=[0]), weft.InputError, r"ridges\[0\]: 0 is not an index below 0"),
])
def test_wrong_arrays_are_refused_by_name_and_index(arguments, error, text):
    with pytest.raises(error, match=text):
        weft.Mesh(**arguments)


TENSOR = {"sol": [2, 0.1, 3, 0.2, 0.3, 4], "rows": [2, 0.1, 0.2, 3, 0.3, 4], "voigt": [2, 3, 4, 0.3, 0.2, 0.1]}
FULL = np.array([[2, 0.1, 0.2], [0.1, 3, 0.3], [0.2, 0.3, 4]])


@pytest.mark.parametrize("order", TENSOR)
def test_orders_of_tensors_mean_the_same_metric(order):
    metric = weft.Metric([TENSOR[order]], order=order)
    assert np.allclose(metric.tensors(), FULL, rtol=1e-12)
    for other, values in TENSOR.items():
        assert np.allclose(weft.Metric([FULL]).tensors(order=other), values, rtol=1e-12)


@pytest.mark.parametrize("values, more, error, text", [
    ([TENSOR["sol"]], {}, weft.UsageError, "say by order="),
    ([TENSOR["sol"]], dict(order="mmg"), weft.UsageError, "'mmg' is none of"),
    ([1, 0], {}, weft.InputError, r"metric\[1\]: is not a size above 0"),
    ([1, np.inf], {}, weft.InputError, r"metric\[1\]: is not finite"),
    ([np.eye(3), np.diag([1, 1, -1])], {}, weft.InputError, r"metric\[1\]: not positive definite"),
    ([FULL + np.triu(np.ones((3, 3)), 1)], {}, weft.InputError, r"metric\[0\]: is not symmetric"),
    (np.zeros((2, 4)), {}, weft.InputError, r"shape \(2, 4\)"),
])
def test_wrong_metrics_are_refused(values, more, error, text):
    with pytest.raises(error, match=text):
        weft.Metric(values, **more)


def test_a_box_takes_whole_numbers_of_numpy():
    assert len(weft.box(np.int64(2)).points) == len(weft.box(np.array([2, 2, 2])).points) == 27


@pytest.mark.parametrize("values, text", [
    (lambda n: np.zeros(n - 1), "not one row for each of the 64 points"),
    (lambda n: np.full(n, np.nan), r"fields\['u'\]\[0\]: is not finite"),
    (lambda n: np.zeros((n, 4)), r"fields\['u'\]: has shape \(64, 4\)"),
])
def test_wrong_fields_are_refused(box, sizes, values, text):
    with pytest.raises(weft.InputError, match=text):
        weft.adapt(box, sizes, fields={"u": values(len(box.points))})


@pytest.mark.parametrize("call, error, text", [
    (lambda m, h: weft.adapt(m, h[1:]), weft.InputError, "metric of another mesh: it has 63 vertices, the mesh 64"),
    (lambda m, h: weft.adapt(m), weft.OptionError, "no metric"),
    (lambda m, h: weft.adapt(m, h, fields=[1, 2]), weft.UsageError, "fields: is no dictionary"),
    (lambda m, h: weft.box(cells=(2**20, 2**20, 2**20)), weft.OptionError, "--cells: are more than a mesh can have"),
    (lambda m, h: weft.box(min=(0, 0, 0), max=(1, 0, 1)), weft.OptionError, "--max: must be above --min"),
    (lambda m, h: weft.adapt(m, h, hmim=1), weft.OptionError, "--hmim: is not an option"),
    (lambda m, h: weft.adapt(m, h, hmin=2, hmax=1), weft.OptionError, "--hmin: is larger than --hmax"),
    (lambda m, h: weft.adapt(m, h, hmin=float("nan")), weft.OptionError, "--hmin"),
    (lambda m, h: weft.adapt(m, h, threads=1.5), weft.OptionError, "--threads: '1.5' is not a whole number"),
    (lambda m, h: weft.adapt(m, h, force=3), weft.OptionError, "--force: '3' is neither yes nor no"),
    (lambda m, h: weft.adapt(m, h, hmin=object()), weft.UsageError, "hmin: is a object"),
    (lambda m, h: weft.adapt(m), weft.OptionError, "no metric"),
    (lambda m, h: weft.adapt(7, h), weft.UsageError, "mesh: is a int"),
    (lambda m, h: weft.adapt(m, h, ids=[1]), weft.UsageError, "need comm="),
    (lambda m, h: weft.read("none.meshb"), weft.InputError, "none.meshb: cannot read"),
    (lambda m, h: weft.adapt(m, h, progress=3), weft.UsageError, "progress: is a int, not a function"),
    (lambda m, h: weft.adapt(m, h, cancel=3), weft.UsageError, "cancel: is a int, not a weft.Cancel"),
    (lambda m, h: weft.adapt(m, solutions={"v": np.ones((64, 3))}), weft.InputError, "solutions: holds no scalar field"),
    (lambda m, h: weft.adapt(m, solutions={"u": h[1:]}), weft.InputError, r"solutions\['u'\]: has shape"),
    (lambda m, h: weft.box(0), weft.OptionError, "--cells"),
    (lambda m, h: weft.box(2.5), weft.UsageError, "cells: 2.5 is neither a whole number nor three of them"),
    (lambda m, h: weft.box(("a", 1, 2)), weft.UsageError, "cells: .'a', 1, 2. is neither"),
    (lambda m, h: weft.ball_surface(radius=-1), weft.OptionError, "--radius"),
    (lambda m, h: weft.ball_surface(size=h), weft.UsageError, "size: is a ndarray, not a number"),
    (lambda m, h: weft.box(max=1), weft.UsageError, "max: is a int, not three numbers"),
    (lambda m, h: weft.read(3), weft.UsageError, "path: is a int, not a path"),
    (lambda m, h: weft.read("box\0.meshb"), weft.UsageError, "path: is a str, not a path"),
    (lambda m, h: weft.adapt_files("a.meshb", "b.meshb", fields="u.solb"), weft.UsageError, "fields: is a str, not a list of"),
    (lambda m, h: weft.measure(m, None), weft.UsageError, "metric: is None"),
    (lambda m, h: weft.measure(m, h, order=6), weft.UsageError, "order: is a int, not a text"),
    (lambda m, h: weft.verify(m, max_problems=2**40), weft.UsageError, "max_problems: is a int, not a whole number of 32 bits"),
    (lambda m, h: weft.adapt(dict(points=h, tet=h), h), weft.UsageError, "mesh: has no member 'tet'"),
    (lambda m, h: weft.adapt(m, h, hmax=h), weft.OptionError, "--hmax: '"),
    (lambda m, h: weft.adapt(m, h, geometry="part\0.step"), weft.UsageError, "geometry: is a str"),
    (lambda m, h: weft.draw("a.png", m, size=3), weft.UsageError, "size: a int makes no sense"),
    (lambda m, h: weft.to_meshio(h), weft.UsageError, "mesh: is a ndarray"),
    (lambda m, h: weft.from_meshio(m), weft.UsageError, "mesh: is a Mesh, not a mesh of meshio"),
    (lambda m, h: weft.write("a.meshb", m, names={1: "iron"}), weft.UsageError, "names: is no dictionary"),
    (lambda m, h: weft.draw("none.gif", m), weft.Error, "none.gif"),
    (lambda m, h: weft.draw("none.png", m, colour=3), weft.OptionError, "--colour"),
])
def test_wrong_calls_are_refused(box, sizes, call, error, text):
    with pytest.raises(error, match=text):
        call(box, sizes)


def test_every_error_is_also_one_of_pythons():
    assert issubclass(weft.InputError, ValueError) and issubclass(weft.UsageError, TypeError)
    assert issubclass(weft.OptionError, ValueError) and issubclass(weft.OutOfMemory, MemoryError)
    assert issubclass(weft.Interrupted, KeyboardInterrupt) and not issubclass(weft.Interrupted, Exception)
