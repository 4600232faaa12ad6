"""Meshes in parts, on a split communicator: mpirun -n N python3 parts.py. Any rank that fails ends all."""

import sys
import traceback

import numpy as np
from mpi4py import MPI

import weft

WORLD = MPI.COMM_WORLD
COMM = WORLD.Split(0, -WORLD.rank)  # the ranks in the opposite order
WHOLE = weft.box(5)
OTHER = weft.box((7, 6, 7))
OPTIONS = dict(threads=1, subdomains=6)


def part(rank, ranks):
    """The tets that are a rank's by a rule; the last of several ranks has none. Ids are neither small nor dense."""
    holders = max(ranks - 1, 1)
    mine = np.nonzero(np.arange(len(WHOLE.tets)) % holders == rank)[0]
    vertices, local = np.unique(WHOLE.tets[mine], return_inverse=True)
    return dict(mesh=(WHOLE.points[vertices].reshape(-1, 3), local.reshape(-1, 4)), ids=1000 + 3 * vertices.astype(np.int64),
                tet_ids=mine, metric=0.08 + 0.1 * WHOLE.points[vertices][:, 0])


def background(rank, ranks):
    """Another mesh of the box, dealt out by another rule, and the metric at its points."""
    mine = np.nonzero(np.arange(len(OTHER.tets)) // 5 % ranks == ranks - 1 - rank)[0]
    vertices, local = np.unique(OTHER.tets[mine], return_inverse=True)
    points = OTHER.points[vertices].reshape(-1, 3)
    return dict(background=(points, local.reshape(-1, 4)), background_ids=5 + 2 * vertices.astype(np.int64),
                background_tet_ids=mine, metric=0.08 + 0.1 * points[:, 0])


def shape(result, comm):
    """All own tets by the coordinates of their points, sorted, on all ranks."""
    corners = result.mesh.points[result.mesh.tets[:result.num_own_tets]]
    mine = [tuple(sorted(map(tuple, tet))) for tet in corners.tolist()]
    return sorted(tet for share in comm.allgather(mine) for tet in share)


def fails(error, text, beside={}, **changes):
    """The same error on all ranks, though the last rank alone is wrong. `beside`: more arguments of all."""
    call = {**part(COMM.rank, COMM.size), **OPTIONS, **beside}
    if COMM.rank == COMM.size - 1:
        call.update(changes)
    try:
        weft.adapt(comm=COMM, **call)
    except error as caught:
        said = COMM.allgather(str(caught))
        assert len(set(said)) == 1, said
        assert text in said[0] and f"rank {COMM.size - 1}: " in said[0], said
        return
    raise AssertionError("nothing was raised")


def check_the_mesh_does_not_depend_on_ranks():
    there = part(COMM.rank, COMM.size)
    fine = weft.adapt(comm=COMM, **there, fields={"x": there["mesh"][0][:, 0]}, **OPTIONS)
    alone = weft.adapt(comm=MPI.COMM_SELF, **part(0, 1), **OPTIONS)
    assert shape(fine, COMM) == shape(alone, MPI.COMM_SELF)
    assert np.allclose(fine.fields["x"], fine.mesh.points[:, 0], atol=1e-9)
    owned = COMM.allreduce(int(np.sum(fine.owners == COMM.rank)))
    assert owned == COMM.allreduce(int(fine.ids.max()) if len(fine.ids) else 0, MPI.MAX) + 1
    assert COMM.allreduce(len(there["ids"]) == 0) == (COMM.size > 1)  # one of several ranks has nothing


def check_ghosts():
    fine = weft.adapt(comm=COMM, **part(COMM.rank, COMM.size), ghosts=True, **OPTIONS)
    ghosts = len(fine.mesh.tets) - fine.num_own_tets
    assert len(fine.ghost_owners) == ghosts and (ghosts > 0) == (COMM.size > 1)
    assert COMM.rank not in fine.ghost_owners


def check_what_one_rank_does_wrong_all_hear_of():
    last = part(COMM.rank, COMM.size) if COMM.size == 1 else None
    points = last["mesh"][0] if last else np.zeros((4, 3)) + np.eye(4, 3)
    tets = last["mesh"][1] if last else np.array([[0, 1, 2, 3]])
    ids = np.arange(len(points))
    wrong = tets.copy()
    wrong[0, 2] = 99999
    good = dict(mesh=(points, tets), ids=ids, tet_ids=np.arange(len(tets)) + 10**6, metric=np.ones(len(points)))
    fails(weft.InputError, "tets[0, 2]: 99999 is not an index of the", **{**good, "mesh": (points, wrong)})
    fails(weft.InputError, "points: has shape", **{**good, "mesh": (points[:, :2], tets)})
    fails(weft.UsageError, "tets: has dtype float64", **{**good, "mesh": (points, tets.astype(float))})
    fails(weft.InputError, "ids: has", **{**good, "ids": ids[1:]})
    fails(weft.InputError, "ids[1]: 0 is that of ids[0] too", **{**good, "ids": np.maximum(ids - 1, 0)})
    fails(weft.InputError, "ids[0]: -5 is negative", **{**good, "ids": ids - 5})
    fails(weft.InputError, "metric[0]: is not a size above 0", **{**good, "metric": np.zeros(len(points))})
    fails(weft.InputError, "metric of another mesh", **{**good, "metric": np.ones(len(points) + 1)})
    fails(weft.OptionError, "no metric: give one", **{**good, "metric": None})
    fails(weft.UsageError, "ids: are needed with comm", **{**good, "ids": None})
    fails(weft.OptionError, "--hgrad: is not a number", **good, hgrad=float("nan"))
    fails(weft.OptionError, "--nonsense: is not an option", **good, nonsense=1)
    fails(weft.UsageError, "mesh: is a str", **{**good, "mesh": "a mesh"})


def check_metrics_of_solutions_are_made_in_parts():
    mine = part(COMM.rank, COMM.size)
    x = np.asarray(mine["mesh"][0])
    mine.pop("metric")
    fine = weft.adapt(comm=COMM, **mine, solutions={"u": x @ [1, 2, 3] + x**2 @ [1, 2, 3]}, complexity=500, threads=1,
                      subdomains=4)
    tets = COMM.allreduce(fine.num_own_tets)
    assert 2000 < tets < 8000 and COMM.bcast(tets) == tets
    assert not any("rank 0 has made" in text for text in fine.warnings)


def check_the_metric_of_another_mesh_in_parts_gives_the_mesh_of_one_process():
    fine = weft.adapt(comm=COMM, **{**part(COMM.rank, COMM.size), **background(COMM.rank, COMM.size)}, **OPTIONS)
    alone = weft.adapt(comm=MPI.COMM_SELF, **{**part(0, 1), **background(0, 1)}, **OPTIONS)
    assert shape(fine, COMM) == shape(alone, MPI.COMM_SELF)
    whole = weft.adapt((WHOLE.points, WHOLE.tets), 0.08 + 0.1 * OTHER.points[:, 0],
                       background=(OTHER.points, OTHER.tets), **OPTIONS)
    corners = whole.mesh.points[whole.mesh.tets].tolist()
    assert sorted(tuple(sorted(map(tuple, tet))) for tet in corners) == shape(fine, COMM)


def check_solutions_at_the_points_of_a_background_make_the_metric():
    def arguments(rank, ranks):
        other = {**part(rank, ranks), **background(rank, ranks)}
        other.pop("metric")
        x = other["background"][0]
        return dict(other, solutions={"u": x @ [1, 2, 3] + x**2 @ [1, 2, 3]}, complexity=500, **OPTIONS)

    fine = weft.adapt(comm=COMM, **arguments(COMM.rank, COMM.size))
    assert shape(fine, COMM) == shape(weft.adapt(comm=MPI.COMM_SELF, **arguments(0, 1)), MPI.COMM_SELF)


def check_what_is_wrong_with_a_background_on_one_rank_all_hear_of():
    beside = background(COMM.rank, COMM.size)
    (points, tets), ids = beside["background"], beside["background_ids"]
    wrong, sizes = tets.copy(), beside["metric"].copy()
    wrong[0, 2], sizes[1] = 99999, np.nan
    n = len(points)
    longer = f"background: rank {COMM.size - 1}: metric of another mesh: it has {n + 1} vertices, the mesh {n}"
    fails(weft.InputError, longer if COMM.rank == COMM.size - 1 else "metric of another mesh", beside,
          metric=np.ones(n + 1))
    fails(weft.InputError, "background: rank", beside, metric=np.ones(n - 1))
    fails(weft.InputError, "metric[1]: is not finite", beside, metric=sizes)
    fails(weft.InputError, "background: tets[0, 2]: 99999 is not an index of the", beside, background=(points, wrong))
    fails(weft.InputError, "background: points: has shape", beside, background=(points[:, :2], tets))
    fails(weft.InputError, "background_ids: has", beside, background_ids=ids[1:])
    fails(weft.InputError, "background_ids[1]:", beside, background_ids=np.concatenate([ids[:1], ids[:1], ids[2:]]))
    fails(weft.InputError, "background_tet_ids: has", beside, background_tet_ids=[1])
    fails(weft.UsageError, "background_ids: are needed with comm", beside, background_ids=None)
    fails(weft.UsageError, "background_ids: are those of a background", background_ids=[1])
    if COMM.size == 1:
        return
    try:
        weft.adapt(comm=COMM, **part(COMM.rank, COMM.size), **OPTIONS,
                   **({} if COMM.rank else {name: beside[name] for name in ("background", "background_ids")}))
    except weft.InputError as error:
        assert "background: some ranks give one" in str(error), error
    else:
        raise AssertionError("a background of some ranks alone")


def check_cancel_on_all_ranks_leaves_a_valid_mesh():
    cancel = weft.Cancel()
    cancel.cancel()
    ended = weft.adapt(comm=COMM, **part(COMM.rank, COMM.size), cancel=cancel, **OPTIONS)
    corners = ended.mesh.points[ended.mesh.tets[:ended.num_own_tets]]
    volume = np.einsum("ti,ti->", np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]),
                       corners[:, 3] - corners[:, 0]) / 6
    assert ended.cancelled and abs(COMM.allreduce(volume) - 1) < 1e-12


def check_communicators_that_are_none_are_refused():
    for comm, text in ((MPI.COMM_NULL, "COMM_NULL"), ("world", "not a communicator")):
        try:
            weft.adapt(comm=comm, **part(0, 1), **OPTIONS)
        except weft.UsageError as error:
            assert text in str(error)
        else:
            raise AssertionError(text)


if __name__ == "__main__":
    try:
        for name, check in sorted(globals().copy().items()):
            if name.startswith("check_"):
                check()
                if COMM.rank == 0:
                    print(name.replace("_", " "), flush=True)
    except BaseException:
        traceback.print_exc()
        sys.stderr.flush()
        COMM.Abort(1)
