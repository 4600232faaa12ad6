"""What the command can do, Python can; with the same bytes where files come of it."""

import ast
import inspect
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys

import numpy as np
import pytest

import weft

WEFT = os.environ["WEFT"]


def run(folder, *words):
    done = subprocess.run([WEFT, *map(str, words)], cwd=folder, capture_output=True, text=True, timeout=250)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture
def start(tmp_path):
    run(tmp_path, "mesh", "box", "--cells", 4, 4, 4, "-o", "start.meshb")
    mesh = weft.read(tmp_path / "start.meshb")
    wave = np.tanh(20 * (mesh.points[:, 0] + 0.3 * mesh.points[:, 1] ** 2 - 0.6))
    weft.write_fields(tmp_path / "wave.solb", {"wave": wave})
    return mesh


def test_numpy_is_imported_with_the_first_array(tmp_path):
    """It takes memory that a run from file to file does without."""
    run(tmp_path, "mesh", "box", "--cells", 2, "-o", "box.meshb")
    program = ("import sys, weft\n"
               "weft.adapt_files('box.meshb', 'fine.meshb', metric_fn='uniform:0.4', threads=1)\n"
               "assert 'numpy' not in sys.modules\n"
               "weft.read('fine.meshb').points\n"
               "assert 'numpy' in sys.modules\n")
    done = subprocess.run([sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, timeout=250)
    assert done.returncode == 0, done.stderr


def same(folder, *names):
    return all((folder / a).read_bytes() == (folder / b).read_bytes() for a, b in zip(names[::2], names[1::2]))


def test_adapting_arrays_to_a_solution_gives_the_commands_bytes(tmp_path, start):
    run(tmp_path, "adapt", "start.meshb", "--sol", "wave.solb", "--complexity", 800, "--hgrad", 1.5, "--field",
        "wave.solb", "--threads", 1, "-o", "fine.meshb")
    wave = weft.read_fields(tmp_path / "wave.solb")
    arrays = dict(points=np.array(start.points), tets=start.tets.astype(np.int64), triangles=start.triangles,
                  edges=start.edges, triangle_refs=start.triangle_refs, edge_refs=start.edge_refs,
                  tet_refs=start.tet_refs, point_refs=start.point_refs, ridges=start.ridges, corners=start.corners)
    fine = weft.adapt(arrays, solutions=wave, complexity=800, hgrad=1.5, fields=wave, threads=1)
    weft.write(tmp_path / "python.meshb", fine)
    assert same(tmp_path, "fine.meshb", "python.meshb", "fine.solb", "python.solb", "fine-fields.solb",
                "python-fields.solb")


def test_files_to_files_give_the_commands_bytes(tmp_path, start):
    run(tmp_path, "adapt", "start.meshb", "--metric-fn", "uniform:0.15", "--threads", 1, "-o",
        "fine.meshb")
    told = weft.adapt_files(tmp_path / "start.meshb", tmp_path / "python.meshb", metric_fn="uniform:0.15",
                            threads=1)
    assert same(tmp_path, "fine.meshb", "python.meshb", "fine.solb", "python.solb")
    assert told.mesh.endswith("python.meshb") and "python.meshb" in told.summary()


NO_UTF_8 = "fl\udcfcgel"  # as os.fsdecode() makes it of Latin-1


def test_names_that_are_no_utf_8_go_in_and_come_out(tmp_path, start):
    fine = weft.adapt(start, np.full(len(start.points), 0.3), fields={NO_UTF_8: start.points[:, 0]}, threads=1)
    assert list(fine.fields) == [NO_UTF_8]
    carried = weft.interpolate(start, {NO_UTF_8: start.points[:, 0]}, fine.mesh)
    assert list(carried.fields) == [NO_UTF_8] and carried.accounts[0]["name"] == NO_UTF_8
    path = tmp_path / f"{NO_UTF_8}.meshb"
    weft.write(path, start)
    told = weft.adapt_files(path, path, metric_fn="uniform:0.3", threads=1)
    assert told.mesh == str(path) and weft.read(told.mesh) and "fl\ufffdgel.meshb" in told.summary()
    weft.write_metric(tmp_path / f"{NO_UTF_8}.solb", np.full(len(fine.mesh.points), 0.3))
    with pytest.raises(weft.InputError, match="fl.gel.solb"):
        weft.adapt(start, metric_fn="linear", sol=[tmp_path / f"{NO_UTF_8}.solb"])
    with pytest.raises(weft.InputError, match="none-fl.gel.meshb: cannot read"):
        weft.read(tmp_path / f"none-{NO_UTF_8}.meshb")
    with pytest.raises(weft.UsageError, match="fields: has a name that is no text"):
        weft.adapt(start, np.full(len(start.points), 0.3), fields={"\ud800": start.points[:, 0]})


def test_a_report_that_could_not_be_written_is_told(tmp_path, start):
    def lose(stage, done, tets):
        shutil.rmtree(tmp_path / "run", ignore_errors=True)

    told = weft.adapt_files(tmp_path / "start.meshb", tmp_path / "fine.meshb", metric_fn="uniform:0.3", threads=1,
                            report=tmp_path / "run", progress=lose)
    assert told.report == "" and "report.json" in told.report_error and told.report_error in told.summary()
    assert (tmp_path / "fine.meshb").exists()


def test_metrics_give_the_commands_bytes(tmp_path, start):
    run(tmp_path, "metric", "start.meshb", "--sol", "wave.solb", "--complexity", 900, "--hgrad", 1.4, "-o", "m.solb")
    metric = weft.make_metric(start, solutions=weft.read_fields(tmp_path / "wave.solb"), complexity=900, hgrad=1.4)
    weft.write_metric(tmp_path / "python.solb", metric)
    assert same(tmp_path, "m.solb", "python.solb")
    assert weft.complexity(start, metric) == pytest.approx(900, rel=0.01)


def test_interpolation_gives_the_commands_bytes(tmp_path, start):
    fine = weft.box(5)
    weft.write(tmp_path / "fine.meshb", fine)
    run(tmp_path, "interpolate", "start.meshb", "fine.meshb", "--field", "wave.solb", "--transfer", "conservative",
        "--threads", 1, "-o", "there.solb")
    there = weft.interpolate(start, weft.read_fields(tmp_path / "wave.solb"), fine, transfer="conservative", threads=1)
    weft.write_fields(tmp_path / "python.solb", there.fields)
    assert same(tmp_path, "there.solb", "python.solb") and there.outside == 0
    account = there.accounts[0]
    assert account["integral_after"] == pytest.approx(account["integral_before"], abs=1e-10)


def test_filling_a_surface_gives_the_commands_bytes(tmp_path):
    run(tmp_path, "mesh", "ball", "--size", 0.4, "-o", "ball.meshb")
    ball = weft.fill(weft.ball_surface(size=0.4))
    assert ball.regions == 1 and weft.verify(ball.mesh) and not ball.cancelled
    assert len(ball.mesh.tets) == len(weft.read(tmp_path / "ball.meshb").tets)


def test_stat_and_verify_say_what_the_command_says(tmp_path, start):
    told = weft.stat(start, np.full(len(start.points), 0.25))
    assert told["points"] == 125 and told["tets"] == 384 and told["max"] == (1, 1, 1)
    assert told["measures"]["tets"] == 384
    check = weft.verify(start, against=weft.box(2))
    assert check and check.volume == pytest.approx(1)
    other = weft.verify(start, against=weft.box(2, max=(1, 1, 2)))
    assert not other and any("volume" in problem for problem in other.problems)
    assert not weft.verify((start.points, start.tets[1:], start.triangles))


def test_files_keep_fields_and_names(tmp_path, start):
    weft.write(tmp_path / "all.vtu", start, fields={"x": start.points[:, 0]})
    read = weft.read_file(tmp_path / "all.vtu")
    assert np.array_equal(read.fields["x"], start.points[:, 0]) and np.array_equal(read.mesh.tets, start.tets)


def test_a_loop_solves_and_adapts_in_turns():
    def solve(mesh):
        return {"u": np.tanh(20 * (mesh.points[:, 0] + 0.3 * mesh.points[:, 1] ** 2 - 0.6))}

    points = [len(mesh.points) for mesh, solution in weft.loop(weft.box(3), solve, [200, 400], hgrad=1.5, threads=1)]
    assert len(points) == 3 and points[1] < points[2]


def test_pictures_are_drawn(tmp_path, start):
    weft.draw(tmp_path / "field.png", start, field=start.points[:, 0], size="200x150")
    weft.draw(tmp_path / "quality.svg", start, metric=np.full(len(start.points), 0.3), color_by="quality")
    assert all((tmp_path / name).stat().st_size > 500 for name in ("field.png", "quality.svg"))


def test_a_metric_of_another_mesh_gives_the_commands_bytes(tmp_path, start):
    other = weft.box((3, 5, 4))
    weft.write(tmp_path / "other.meshb", other)
    wave = {"wave": np.tanh(20 * (other.points[:, 0] - 0.4))}
    weft.write_fields(tmp_path / "other.solb", wave)
    run(tmp_path, "adapt", "start.meshb", "--background", "other.meshb", "--sol", "other.solb", "--complexity", 500,
        "--threads", 1, "-o", "fine.meshb")
    fine = weft.adapt(start, background=other, solutions=wave, complexity=500, threads=1)
    weft.write(tmp_path / "python.meshb", fine)
    assert same(tmp_path, "fine.meshb", "python.meshb", "fine.solb", "python.solb")
    with pytest.raises(weft.InputError, match="metric of another mesh: it has 125 vertices, the mesh 120"):
        weft.adapt(start, np.ones(125), background=other)
    with pytest.raises(weft.InputError, match="solutions.'field1'.: has shape .125,., not one row for each of the 120 points"):
        weft.adapt(start, background=other, solutions=weft.read_fields(tmp_path / "wave.solb"), complexity=500)


def test_runs_on_files_write_all_that_the_command_writes(tmp_path, start):
    told = weft.adapt_files(tmp_path / "start.meshb", tmp_path / "fine.meshb", metric_fn="uniform:0.2", subdomains=3,
                            fields=[tmp_path / "wave.solb"], threads=1, report=tmp_path / "run",
                            case="cube-polar2-50000", graph=tmp_path / "graph.dot", trace=tmp_path / "trace.json")
    assert told.fields and (tmp_path / "run/report.html").exists()
    assert (tmp_path / "graph.dot").read_text().startswith("digraph") and (tmp_path / "trace.json").exists()
    plain = weft.adapt_files(tmp_path / "start.meshb", tmp_path / "plain.meshb", metric_fn="uniform:0.2", subdomains=3,
                             threads=1, report=tmp_path / "plain", page=False)
    assert plain.report and not (tmp_path / "plain/report.html").exists()
    simulated = weft.adapt_files(tmp_path / "start.meshb", tmp_path / "simulated.meshb", metric_fn="uniform:0.2",
                                 subdomains=3, simulate_ranks=2, simulate_network="5us,1GB/s", simulate_slowdown=2,
                                 simulate_cores=1)
    assert simulated.seconds > 0 and isinstance(simulated, weft.SimulatedFilesResult)
    assert same(tmp_path, "fine.meshb", "plain.meshb", "fine.meshb", "simulated.meshb")
    with pytest.raises(weft.OptionError, match="--simulate-cores"):
        weft.adapt_files(tmp_path / "start.meshb", tmp_path / "simulated.meshb", metric_fn="uniform:0.2", subdomains=3,
                         simulate_ranks=2, simulate_cores=-1)


def test_recorded_runs_are_replayed_drawn_and_compared_as_by_the_command(tmp_path, start):
    for name, size in ("run", 0.2), ("finer", 0.15):
        weft.adapt_files(tmp_path / "start.meshb", tmp_path / "out.meshb", metric_fn=f"uniform:{size}", subdomains=3, threads=1,
                         report=tmp_path / name)
    graph, profile = tmp_path / "run/graph.json", tmp_path / "run/profile.json"
    told = weft.replay(graph, ranks=4, network="5us,1GB/s", balancer="diffusion", copies=2, slowdown=1.5,
                       account=tmp_path / "replay.json", trace=tmp_path / "replay.trace.json")
    assert told.pop("summary").startswith("simulated on    4 ranks")
    assert told == json.loads((tmp_path / "replay.json").read_text()) and (tmp_path / "replay.trace.json").exists()
    run(tmp_path, "replay", "run/graph.json", "--ranks", 4, "--network", "5us,1GB/s", "--balancer", "diffusion", "--copies", 2,
        "--slowdown", 1.5, "--account", "command.json")
    by_command = json.loads((tmp_path / "command.json").read_text())
    assert {key: told[key] for key in ("seconds", "packets", "work_seconds", "subdomains")} == {
        key: by_command[key] for key in ("seconds", "packets", "work_seconds", "subdomains")}
    assert weft.task_graph(graph, collapse="rounds") == run(tmp_path, "graph", "run/graph.json", "--collapse", "rounds")
    assert weft.task_graph(graph, format="graphml", subdomain=1) != weft.task_graph(graph, format="graphml")
    assert weft.task_graph(graph, plan=True).startswith("digraph")
    weft.report_page(profile, tmp_path / "page.html")
    assert (tmp_path / "page.html").read_bytes() == (tmp_path / "run/report.html").read_bytes()
    differences = weft.compare_reports(profile, tmp_path / "finer/profile.json", page=tmp_path / "both.html")
    assert differences == run(tmp_path, "report", profile, tmp_path / "finer/profile.json") and (tmp_path / "both.html").exists()
    for wrong in dict(ranks=0), dict(balancer="none of them"), dict(subdomain_bytes=-1):
        with pytest.raises(weft.OptionError, match="--" + next(iter(wrong)).replace("_", "-")):
            weft.replay(graph, **wrong)


def test_files_are_converted_as_by_the_command(tmp_path, start):
    options = {"msh_version": "2.2", "encoding": "ascii"}
    run(tmp_path, "convert", "start.meshb", "start.msh", "--sol", "wave.solb", "--msh-version", "2.2", "--encoding",
        "ascii")
    dropped = weft.convert(tmp_path / "start.meshb", tmp_path / "python.msh", sol=tmp_path / "wave.solb", **options)
    assert same(tmp_path, "start.msh", "python.msh") and isinstance(dropped, list)
    weft.convert(tmp_path / "start.meshb", tmp_path / "plain.vtu")
    weft.convert(tmp_path / "start.meshb", tmp_path / "small.vtu", compress=True)
    assert (tmp_path / "small.vtu").stat().st_size < (tmp_path / "plain.vtu").stat().st_size
    weft.convert(tmp_path / "start.meshb", tmp_path / "three.pvtu", pieces=3)
    assert len(list(tmp_path.rglob("three*.vtu"))) == 3
    assert [what for what, count in weft.convert(tmp_path / "start.meshb", tmp_path / "start.stl") if "tets" in what]
    for wrong in ({"encoding": "utf"}, {"msh_version": "3"}, {"pieces": 0}):
        with pytest.raises(weft.OptionError, match="--" + next(iter(wrong)).replace("_", "-")):
            weft.convert(tmp_path / "start.meshb", tmp_path / "wrong.msh", **wrong)


def test_histograms_are_drawn(tmp_path, start):
    weft.draw_histograms(tmp_path / "plot.svg", start, np.full(len(start.points), 0.25), title="of the start")
    run(tmp_path, "stat", "start.meshb", "--metric-fn", "uniform:0.25", "--plot", "command.svg")
    assert (tmp_path / "plot.svg").stat().st_size > 2000 and (tmp_path / "command.svg").stat().st_size > 2000
    assert len(weft.stat(start, np.full(len(start.points), 0.25))["measures"]["quality"]["histogram"]["counts"]) > 10


CYLINDER = os.path.join(os.path.dirname(__file__), "../../data/models/cylinder.brep")


@pytest.mark.skipif(os.environ.get("WEFT_HAS_CAD") != "1", reason="SKIPPED: this build has no OpenCASCADE")
def test_cad_models_are_meshed_and_measured(tmp_path):
    surface = weft.tessellate(CYLINDER, geometry_scale=2, hausd=0.05)
    assert surface.points[:, 2].max() - surface.points[:, 2].min() == pytest.approx(4) and len(surface.tets) == 0
    filled = weft.fill(surface, remesh_surface=True, geometry=CYLINDER, geometry_scale=2, hausd=0.05, size=0.8)
    assert weft.verify(filled.mesh) and filled.mends == ""
    told = weft.stat(filled.mesh, geometry=CYLINDER, geometry_scale=2)
    assert told["model"] and told["corners"] == len(filled.mesh.corners)
    assert "model" not in weft.stat(filled.mesh)
    with pytest.raises(weft.OptionError, match="--angle"):
        weft.tessellate(CYLINDER, angle=-1)


def test_mends_are_told(start):
    inverted = start.tets.copy()
    inverted[0, :2] = inverted[0, 1::-1]
    mended = weft.adapt((start.points, inverted), np.full(125, 0.3), repair=True, threads=1)
    assert "listed the wrong way round turned" in mended.mends and weft.adapt(start, np.full(125, 0.3), threads=1).mends == ""


def test_stubs_name_what_there_is():
    tree = ast.parse(pathlib.Path(weft.__file__).with_name("_weft.pyi").read_text())
    told = {node.name: node for node in tree.body if isinstance(node, (ast.FunctionDef, ast.ClassDef))}
    there = {name for name in vars(weft._weft) if not name.startswith("__")} - {"mpi"}
    assert set(told) == there
    for name, node in told.items():
        if isinstance(node, ast.ClassDef):
            kind = getattr(weft._weft, name)
            inherited = set(dir(kind.__mro__[1]))
            members = {member.name for member in node.body if isinstance(member, ast.FunctionDef)}
            assert {m for m in members if not m.startswith("__")} == {
                m for m in vars(kind) if not m.startswith("_") and m not in inherited}, name
        else:
            doc = getattr(weft._weft, name).__doc__
            inside = doc[doc.index("(") + 1:doc.index(" -> ")]
            assert len(node.args.args) == inside.count("arg") + inside.count("self:"), name
    assert {node.name for node in ast.parse(pathlib.Path(weft.__file__).read_text()).body
            if isinstance(node, ast.FunctionDef) and not node.name.startswith("_")} <= set(weft.__all__)


def test_options_are_those_of_the_command():
    documented = set(re.findall(r"--([a-z][a-z-]+)", subprocess.run(
        [WEFT, "adapt", "--help"], capture_output=True, text=True, timeout=60).stdout.split("Examples")[0]))
    of_command = {name for name, _, _, there in weft._weft.named_options() if there}
    named = set(inspect.signature(weft.adapt_files).parameters)
    beside = {"help", "out", "field", "no-page", "progress", "quiet"}  # of the command line, output=, fields= and page=
    assert of_command <= documented
    assert {name.replace("-", "_") for name in documented - of_command - beside} <= named


def test_repair_mends_what_adapt_refuses(start):
    tets = start.tets.copy()
    tets[0] = tets[0][[1, 0, 2, 3]]
    points = np.vstack([start.points, [[9, 9, 9]]])
    mended, fields, mends = weft.repair((points, tets, start.triangles), {"x": points[:, 0]})
    assert weft.verify(mended) and len(mended.points) == len(start.points)
    assert np.array_equal(fields["x"], mended.points[:, 0])
    assert any("unused vertices removed" in line for line in mends)
    assert weft.repair(start)[2] == []


def test_repair_mends_metrics_and_surfaces(start):
    sizes = np.full(len(start.points), 0.3)
    sizes[3] = np.nan
    metric, mends = weft.repair_metric(start, sizes)
    assert metric == pytest.approx(np.full(len(start.points), 0.3)) and len(mends) == 1
    tensors = np.tile([10.0, 0, 10, 0, 0, 10], (len(start.points), 1))
    tensors[5, 0] = -1
    metric, mends = weft.repair_metric(start, tensors, order="sol")
    assert metric.shape == (len(start.points), 3, 3) and np.linalg.eigvalsh(metric).min() > 0 and mends
    ball = weft.ball_surface(1, size=0.5)
    doubled = (ball.points, np.empty((0, 4), int), np.vstack([ball.triangles, ball.triangles[:1]]))
    mended, mends = weft.repair_surface(doubled)
    assert len(mended.triangles) == len(ball.triangles) and mends
