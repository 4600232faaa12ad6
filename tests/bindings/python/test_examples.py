"""The examples run; the wheel is made without a network, and the module in it works where nothing else of weft is."""

import os
import pathlib
import subprocess
import sys

import pytest

EXAMPLES = pathlib.Path(__file__).resolve().parents[3] / "tools/bindings/python/examples"


def run(*words, **more):
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, timeout=250, **more)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_the_notebook_has_at_most_15_lines_and_draws_its_picture(tmp_path):
    pytest.importorskip("meshio")
    script = EXAMPLES / "notebook.py"
    code = [line for line in script.read_text().split('"""', 2)[2].splitlines() if line.strip()]
    assert len(code) <= 15
    assert "GOAL MET" in run(sys.executable, "-B", script, cwd=tmp_path)
    assert (tmp_path / "fine.png").read_bytes().startswith(b"\x89PNG")


SMALL = """
import numpy as np, sys, weft
assert weft.__file__.startswith(sys.prefix), weft.__file__
fine = weft.adapt(weft.box(2), np.full(27, 0.4), threads=1)
assert weft.verify(fine.mesh)
loaded = [line.split()[-1] for line in open("/proc/self/maps") if "libweft.so" in line]
assert loaded and all(path.startswith(sys.prefix) for path in loaded), loaded
print("works")
"""


def test_a_wheel_is_made_offline_and_works_in_a_fresh_environment(tmp_path):
    run("cmake", "--build", os.environ["WEFT_BUILD"], "--target", "weft_wheel")
    wheel, = (pathlib.Path(os.environ["WEFT_BUILD"]) / "wheel").glob("*.whl")
    alone = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    run(sys.executable, "-m", "venv", "--system-site-packages", tmp_path / "fresh", env=alone)
    python = tmp_path / "fresh/bin/python"
    run(python, "-m", "pip", "install", "--no-index", "--no-deps", wheel, env=alone)
    assert run(python, "-c", SMALL, env=alone, cwd=tmp_path) == "works\n"
    files = list((tmp_path / "fresh").rglob("site-packages/weft/*"))
    assert {"py.typed", "_weft.pyi"} <= {path.name for path in files}
