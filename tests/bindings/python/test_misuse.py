"""Each argument of each function in turn is something that makes no sense: an error of weft says so, and nothing crashes."""

import numpy as np
import pytest

import weft

MESH = weft.box(2)
N = len(MESH.points)
ONES = np.ones(N)


class Nothing:
    """No array can be made of it, nor a number."""

    def __array__(self, *_):
        raise ValueError("no array")


STRANGE = [
    None, float("nan"), float("inf"), -1, 2**70, 10**400, 1j, "", "no such text", "x\0y", "\ud800", b"bytes", [], {}, {"u": None},
    {3: ONES}, [[1, 2], [3]], [None], object(), Nothing(), set(), iter([1]), weft.Cancel(), weft.Metric(ONES), MESH,
    (MESH.points, MESH.tets), dict(points=1), dict(point=ONES), np.array(3), np.zeros((0, 4)), np.full(N, np.nan), np.full(N, -1.0),
    np.full(N, 1e300), np.ones(N - 1), np.ones((N, 6)), np.full((N, 3, 3), np.nan), MESH.points.T, MESH.tets + 1000,
    MESH.tets.astype(float), np.ones(N, complex), np.ones(N, object), np.array(["a"] * N), np.zeros(N, [("a", int)]),
    np.full(N, 2**63, np.uint64), np.full((N, 3), 1e308),
]
SOME = dict(fields={"u": ONES}, order="sol")
CALLS = {
    "adapt": dict(mesh=MESH, metric=ONES, **SOME, solutions=None, background=None, progress=None, cancel=None, ids=None, hmin=None,
                  hausd=0.01, threads=1, geometry=None),
    "adapt_files": dict(input="box.meshb", output="fine.meshb", metric="box.solb", fields=["box.solb"], page=False, background="",
                        report="", case="", simulate_ranks=0, simulate_cores=0, progress=None, cancel=None),
    "loop": dict(mesh=MESH, solve=lambda mesh: {"u": mesh.points[:, 0]**2}, complexities=[20], on=["u"]),
    "make_metric": dict(mesh=MESH, metric=ONES, solutions=None, order="sol", hgrad=1.5),
    "complexity": dict(mesh=MESH, metric=ONES, order="sol"),
    "measure": dict(mesh=MESH, metric=ONES, order="sol"),
    "stat": dict(mesh=MESH, metric=ONES, order="sol", geometry=None),
    "verify": dict(mesh=MESH, against=MESH, max_problems=3),
    "interpolate": dict(mesh=MESH, fields={"u": ONES}, to=MESH, transfer="linear", threads=1, order="sol"),
    "fill": dict(surface=MESH, growth=1.3, size=0, merge=1e-9, materials=False, remesh_surface=False, background=None, metric=None,
                 order=None, progress=None, cancel=None, hausd=0.01),
    "tessellate": dict(geometry="none.step", geometry_scale=1, hausd=0, angle=20),
    "box": dict(cells=2, min=(0, 0, 0), max=(1, 1, 1)),
    "ball_surface": dict(radius=1, center=(0, 0, 0), size=0.5),
    "cylinder_surface": dict(radius=1, height=2, base=(0, 0, 0), size=0.5),
    "read": dict(path="box.meshb"),
    "read_file": dict(path="box.meshb"),
    "read_fields": dict(path="box.solb"),
    "read_metric": dict(path="box.solb", mesh=MESH),
    "write": dict(path="out.meshb", mesh=MESH, metric=ONES, **SOME, names={(3, 1): "iron"}),
    "convert": dict(input="box.meshb", output="out.vtu", sol="", encoding="binary", msh_version="4.1", compress=False, pieces=2),
    "write_fields": dict(path="out.solb", fields={"u": ONES}, order="sol"),
    "write_metric": dict(path="out.solb", metric=ONES, order="sol"),
    "draw": dict(path="out.png", mesh=MESH, metric=ONES, field=ONES, order="sol", size="80x60", only=[1], zoom=1, dark=False),
    "draw_histograms": dict(path="out.png", mesh=MESH, metric=ONES, order="sol", title="a"),
    "replay": dict(graph="run/graph.json", ranks=2, threads=1, network="2us,10GB/s", balancer="none", slowdown=1, processor_times=False,
                   copies=1, split=1, grow=1, subdomain_bytes=0, report="", account="", trace=""),
    "task_graph": dict(path="run/graph.json", format="dot", round=None, subdomain=None, collapse="none", critical_path=False, plan=False),
    "report_page": dict(profile="run/profile.json", page="page.html"),
    "compare_reports": dict(a="run/profile.json", b="run/profile.json", page=""),
    "as_mesh": dict(mesh=MESH),
    "from_meshio": dict(mesh=MESH),
    "from_pyvista": dict(grid=MESH),
    "Metric": dict(values=ONES, order="sol"),
}


@pytest.mark.parametrize("name", CALLS)
def test_strange_arguments_are_refused_by_name_or_mean_something(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    weft.write("box.meshb", MESH, metric=ONES)
    weft.adapt_files("box.meshb", "small.meshb", metric_fn="uniform:1", subdomains=2, threads=1, report="run")
    for argument in CALLS[name]:
        for value in STRANGE:
            try:
                got = getattr(weft, name)(**{**CALLS[name], argument: value})
                if name == "loop":
                    list(got)
            except weft.InternalError:
                raise
            except weft.Error as error:
                assert len(str(error)) > 10, (argument, value)
            except Exception as error:
                raise AssertionError(f"{name}({argument}={value!r:.100}): {type(error).__name__}: {error}") from error


def test_a_fault_of_weft_is_an_error_of_weft(tmp_path):
    """Past the checks of the module: what the library throws then is none of its errors for users."""
    with pytest.raises(weft.InternalError, match="there is no field to write"):
        weft._weft.write_fields(str(tmp_path / "none.solb"), {}, None)
    with pytest.raises(KeyError):
        weft._weft.adapt_files({}, [], True, {}, 0, "", 1, 0, None, None)
