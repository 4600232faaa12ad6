"""weft for dolfinx 0.5: adapt(u, complexity), and what it takes: meshes as parts and back, values at their points."""

from types import SimpleNamespace

import numpy as np
import ufl
from dolfinx import fem, mesh

import weft


def part_of_mesh(domain):
    """What this rank owns: points, tets, the ids of the points; `which`: their places among the mesh's points."""
    geometry = domain.geometry
    owned = domain.topology.index_map(3).size_local  # ghosts come after these
    cells = geometry.dofmap.array.reshape(-1, 4)[:owned]
    which, tets = np.unique(cells, return_inverse=True)
    tets = tets.reshape(-1, 4)
    points = geometry.x[which]
    edges = points[tets[:, 1:]] - points[tets[:, :1]]
    flipped = np.linalg.det(edges) < 0
    tets[flipped] = tets[flipped][:, [1, 0, 2, 3]]
    ids = geometry.index_map().local_to_global(which.astype(np.int32))
    return SimpleNamespace(points=points, tets=tets, ids=np.asarray(ids, np.int64), which=which)


def _blocks(comm, result, values):
    """Values at the points by id: each rank gets an equal share of consecutive ids, from their owners."""
    owned = np.asarray(result.owners) == comm.rank
    ids, values = np.asarray(result.ids)[owned], np.asarray(values)[owned]
    total = comm.allreduce(len(ids))
    home = ids * comm.size // max(total, 1)
    pieces = comm.alltoall([(ids[home == rank], values[home == rank]) for rank in range(comm.size)])
    order = np.argsort(np.concatenate([piece[0] for piece in pieces]))
    return np.concatenate([piece[1] for piece in pieces])[order]


def mesh_of_part(comm, result):
    """A mesh of dolfinx, which distributes it as it does its own."""
    element = ufl.VectorElement("Lagrange", ufl.tetrahedron, 1)
    tets = np.asarray(result.ids, np.int64)[np.asarray(result.mesh.tets)]
    return mesh.create_mesh(comm, tets, _blocks(comm, result, result.mesh.points), ufl.Mesh(element))


def values_at(comm, domain, result, values):
    """Values at the result's points as values at those of the mesh that was made of it."""
    block = _blocks(comm, result, values)
    starts = np.concatenate([[0], np.cumsum(comm.allgather(len(block)))])
    wanted = np.asarray(domain.geometry.input_global_indices)
    home = np.searchsorted(starts, wanted, side="right") - 1
    asked = comm.alltoall([wanted[home == rank] for rank in range(comm.size)])
    answers = comm.alltoall([block[ids - starts[comm.rank]] for ids in asked])
    out = np.empty((len(wanted), *block.shape[1:]))
    for rank, answer in enumerate(answers):
        out[home == rank] = answer
    return out


def boundary_dofs(V):
    V.mesh.topology.create_connectivity(2, 3)
    return fem.locate_dofs_topological(V, 2, mesh.exterior_facet_indices(V.mesh.topology))


def adapt(u, complexity):
    """A mesh of about 2 * complexity vertices on which u, a P1 function, has the least interpolation error; and u's values at
    its points. In memory, on all ranks of the mesh's communicator."""
    domain, V = u.function_space.mesh, u.function_space
    comm = domain.comm
    at_points = np.empty(len(domain.geometry.x))
    at_points[domain.geometry.dofmap.array] = u.x.array[V.dofmap.list.array].real
    part = part_of_mesh(domain)
    solution = {"u": at_points[part.which]}
    result = weft.adapt((part.points, part.tets), solutions=solution, fields=solution, comm=comm, ids=part.ids,
                        complexity=complexity, threads=1, subdomains=2 * comm.size)
    adapted = mesh_of_part(comm, result)
    return adapted, values_at(comm, adapted, result, result.fields["u"])
