"""Runs beside other threads, ended early, told of."""

import json
import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import weft


def ticks_of_another_thread_while(call):
    """What call() returns, and how often another thread has run meanwhile."""
    done, ticks = threading.Event(), [0]

    def tick():
        while not done.is_set():
            ticks[0] += 1
            time.sleep(0.001)

    other = threading.Thread(target=tick)
    other.start()
    before = ticks[0]
    result = call()
    during = ticks[0] - before
    done.set()
    other.join()
    return result, during


def test_another_thread_runs_while_adapting(box):
    result, during = ticks_of_another_thread_while(lambda: weft.adapt(box, np.full(len(box.points), 0.06), threads=1))
    assert result.goal_met and during > 10


def test_another_thread_runs_while_fields_are_read(tmp_path):
    weft.write_fields(tmp_path / "u.sol", {"u": np.random.default_rng(1).random(1_000_000)})
    _, during = ticks_of_another_thread_while(lambda: weft.read_fields(tmp_path / "u.sol"))
    assert during > 5


def test_two_adaptations_at_once_give_what_each_gives_alone(box):
    metrics = [np.full(len(box.points), h) for h in (0.12, 0.15)]
    alone = [weft.adapt(box, metric, threads=1).mesh for metric in metrics]
    together = [None, None]

    def adapt(i):
        together[i] = weft.adapt(box, metrics[i], threads=1).mesh

    threads = [threading.Thread(target=adapt, args=(i,)) for i in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for a, b in zip(alone, together):
        assert np.array_equal(a.points, b.points) and np.array_equal(a.tets, b.tets)


def test_progress_is_told_and_false_cancels_with_a_valid_mesh(box, sizes):
    told = []
    result = weft.adapt(box, sizes, progress=lambda stage, done, tets: told.append((stage, done, tets)))
    assert not result.cancelled and len(told) > 2
    assert all(isinstance(stage, str) and 0 <= done <= 1 for stage, done, tets in told)
    ended = weft.adapt(box, np.full(len(box.points), 0.03), progress=lambda stage, done, tets: False)
    assert ended.cancelled and not ended.goal_met and weft.verify(ended.mesh, against=box)


def test_measures_are_taken_when_they_are_asked_for_where_the_run_leaves_them_out(box, sizes):
    measured = json.loads(weft.adapt(box, sizes, threads=1).json())
    result = weft.adapt(box, sizes, threads=1, measure=False)
    assert result.goal_met and result.missed == []
    assert json.loads(result.json())["after"] == measured["after"]
    ended = weft.adapt(box, np.full(len(box.points), 0.03), progress=lambda stage, done, tets: False)
    assert "of the edges are unit" in " ".join(ended.missed) and "interrupted" in ended.summary()
    assert json.loads(ended.json())["after"]["tets"] == len(ended.mesh.tets)


def test_another_thread_cancels_with_a_valid_mesh(box):
    cancel = weft.Cancel()
    threading.Timer(0.3, cancel.cancel).start()
    result = weft.adapt(box, np.full(len(box.points), 0.012), cancel=cancel, threads=1)
    assert result.cancelled and weft.verify(result.mesh, against=box)
    cancel.reset()
    assert not weft.adapt(box, np.full(len(box.points), 0.3), cancel=cancel).cancelled


def test_a_limit_ends_its_run_and_leaves_the_cancel_for_the_next(box):
    cancel = weft.Cancel()
    ended = weft.adapt(box, np.full(len(box.points), 0.012), cancel=cancel, time_limit=0.01, threads=1)
    assert ended.cancelled and not cancel.wanted
    assert not weft.adapt(box, np.full(len(box.points), 0.3), cancel=cancel).cancelled


def test_another_thread_asks_for_a_checkpoint_to_go_on_from(box, tmp_path):
    asked = weft.Cancel()

    def ask(stage, done, tets):
        asked.checkpoint()
        return not list(tmp_path.iterdir())  # ended once there is one

    sizes = np.full(len(box.points), 0.05)
    options = dict(checkpoint=tmp_path, checkpoint_every=0, threads=1)
    ended = weft.adapt(box, sizes, cancel=asked, progress=ask, **options)
    assert ended.cancelled and list(tmp_path.iterdir())
    gone_on = weft.adapt(box, sizes, resume=tmp_path, threads=1)
    assert gone_on.goal_met and np.array_equal(gone_on.mesh.tets, weft.adapt(box, sizes, threads=1).mesh.tets)


def test_what_a_callback_raises_is_raised(box, sizes):
    def fail(stage, done, tets):
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        weft.adapt(box, sizes, progress=fail)


@pytest.mark.parametrize("mine", [KeyError("mine"), KeyboardInterrupt("mine")])
def test_what_a_callback_raises_is_raised_where_there_is_no_mesh_yet(mine):
    def fail(stage, done, tets):
        raise mine

    with pytest.raises(type(mine), match="mine"):
        weft.fill(weft.ball_surface(size=0.3), progress=fail)


INTERRUPTED = """
import numpy as np, weft
box = weft.box(4)
def started(stage, done, tets):
    print("started", flush=True)
try:
    weft.adapt(box, np.full(len(box.points), 0.012), threads=1, progress=started)
except KeyboardInterrupt as interrupt:
    assert isinstance(interrupt, weft.Interrupted) and interrupt.result.cancelled
    assert weft.verify(interrupt.result.mesh, against=box)
    print("valid")
"""


def test_ctrl_c_interrupts_and_leaves_a_valid_mesh():
    program = subprocess.Popen([sys.executable, "-c", INTERRUPTED], stdout=subprocess.PIPE, text=True)
    assert program.stdout.readline() == "started\n"
    program.send_signal(signal.SIGINT)
    told, _ = program.communicate(timeout=120)
    assert program.returncode == 0 and told.endswith("valid\n")
