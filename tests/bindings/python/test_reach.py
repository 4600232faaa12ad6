"""What the command can do, Python can; with the same bytes where files come of it."""

import os
import re
import subprocess

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


def test_options_are_those_of_the_command():
    documented = set(re.findall(r"--([a-z][a-z-]+)", subprocess.run(
        [WEFT, "adapt", "--help"], capture_output=True, text=True, timeout=60).stdout.split("Examples")[0]))
    of_command = {name for name, _, _, there in weft._weft.named_options() if there}
    beside = {"help", "out", "background", "field", "report", "case", "graph", "trace", "progress", "quiet"}
    beside |= {"simulate-ranks", "simulate-network", "simulate-slowdown"}  # of <weft/replay.h>, in C++
    assert of_command <= documented
    assert documented - of_command - beside == set()
