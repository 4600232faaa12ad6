"""Solve, make a metric of the solution, adapt in memory, carry the solution over, solve again: dolfinx and weft, on any
number of ranks.    mpirun -n 4 python3 dolfinx_loop.py [--problem poisson|advection] [--levels N] [--plot errors.png]

Both problems have a known solution with a thin layer. The error falls with the number of unknowns as it does on uniform
meshes, but from a far lower start: the plot shows both.
"""

import argparse
from types import SimpleNamespace

import numpy as np
import ufl
from dolfinx import fem, mesh
from dolfinx.fem.petsc import LinearProblem
from mpi4py import MPI
from petsc4py import PETSc

import weft
from dolfinx_meshes import mesh_of_part, part_of_mesh, values_at

comm = MPI.COMM_WORLD
EPS = 0.03


def poisson(domain, V, u, v):
    """-div grad u = f; the solution falls from 1 to -1 across a sphere."""
    x = ufl.SpatialCoordinate(domain)
    exact = -ufl.tanh((ufl.sqrt(ufl.dot(x, x) + 1e-12) - 0.7) / EPS)
    f = -ufl.div(ufl.grad(exact))
    return exact, ufl.inner(ufl.grad(u), ufl.grad(v)) * ufl.dx, f * v * ufl.dx


def advection(domain, V, u, v):
    """-eps div grad u + b.grad u = f with b = (1, 0, 0), by SUPG; the solution has an outflow layer at x = 1."""
    x = ufl.SpatialCoordinate(domain)
    b = ufl.as_vector((1.0, 0.0, 0.0))
    along = ufl.dot(ufl.JacobianInverse(domain), b)  # b.grad of three of a tet's hat functions; the fourth's is -sum
    h = 2 / (sum(abs(along[i]) for i in range(3)) + abs(along[0] + along[1] + along[2]))  # a stretched tet's along b
    exact = (x[0] - ufl.exp((x[0] - 1) / EPS)) * (1 + x[1])
    f = -EPS * ufl.div(ufl.grad(exact)) + ufl.dot(b, ufl.grad(exact))
    tau = ufl.min_value(h / 2, h * h / (12 * EPS))
    stabilised = v + tau * ufl.dot(b, ufl.grad(v))
    a = EPS * ufl.inner(ufl.grad(u), ufl.grad(v)) * ufl.dx + ufl.dot(b, ufl.grad(u)) * stabilised * ufl.dx
    return exact, a, f * stabilised * ufl.dx


def boundary_dofs(V):
    V.mesh.topology.create_connectivity(2, 3)
    return fem.locate_dofs_topological(V, 2, mesh.exterior_facet_indices(V.mesh.topology))


def solve(domain, problem, start=None):
    """The solution, and its error in the L2 norm; `start` are values of a first guess at the points of the mesh."""
    V = fem.FunctionSpace(domain, ("Lagrange", 1))
    exact, a, L = problem(domain, V, ufl.TrialFunction(V), ufl.TestFunction(V))
    boundary = fem.Function(V)
    boundary.interpolate(fem.Expression(exact, V.element.interpolation_points()))
    bc = fem.dirichletbc(boundary, boundary_dofs(V))
    u = fem.Function(V)
    options = {"ksp_type": "gmres", "ksp_rtol": 1e-9, "pc_type": "hypre", "ksp_initial_guess_nonzero": start is not None}
    if start is not None:
        u.x.array[V.dofmap.list.array] = start[domain.geometry.dofmap.array]
    LinearProblem(a, L, bcs=[bc], u=u, petsc_options=options).solve()
    u.x.scatter_forward()
    square = fem.assemble_scalar(fem.form((u - exact) ** 2 * ufl.dx(degree=6)))
    return u, np.sqrt(comm.allreduce(square.real)), V.dofmap.index_map.size_global


def recovered(V, derivative):
    """The derivative of a P1 function at the vertices: its L2 projection with the lumped mass matrix."""
    v, g = ufl.TestFunction(V), fem.Function(V)
    load, mass = (fem.petsc.assemble_vector(fem.form(integrand * v * ufl.dx))
                  for integrand in (derivative, fem.Constant(V.mesh, PETSc.ScalarType(1))))
    for vector in (load, mass):
        vector.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
    load.pointwiseDivide(load, mass)
    g.x.array[:V.dofmap.index_map.size_local] = load.array
    g.x.scatter_forward()
    return g


def hessian(u):
    """At the vertices; at those of the boundary the mean of the inner neighbours, because averages are one-sided there."""
    V = u.function_space
    inside = fem.Function(V)
    inside.x.array[:] = 1
    inside.x.array[boundary_dofs(V)] = 0
    weight = recovered(V, inside).x.array.real
    outer = (inside.x.array.real == 0) & (weight > 0)
    gradient = [recovered(V, u.dx(i)) for i in range(3)]
    H = np.empty((len(weight), 3, 3))
    for i, j in (0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2):
        second = recovered(V, (gradient[i].dx(j) + gradient[j].dx(i)) / 2)
        mean = recovered(V, inside * second).x.array.real
        H[:, i, j] = H[:, j, i] = np.where(outer, mean / np.where(outer, weight, 1), second.x.array.real)
    return H


def metric_of(u, norm=2):
    """|H| det|H|^(-1/(2p+3)): the metric of least interpolation error of u in L^p, up to a factor, at the points."""
    V, H = u.function_space, hessian(u)
    values, directions = np.linalg.eigh(H)
    largest = comm.allreduce(np.abs(values).max(initial=0), MPI.MAX)
    values = np.maximum(np.abs(values), 1e-3 * largest)
    values *= np.prod(values, axis=1, keepdims=True) ** (-1 / (2 * norm + 3))
    tensors = np.einsum("nij,nj,nkj->nik", directions, values, directions)
    at_points = np.empty((len(V.mesh.geometry.x), 3, 3))
    at_points[V.mesh.geometry.dofmap.array] = tensors[V.dofmap.list.array]
    return at_points


def adapt(u, complexity):
    """The adapted mesh and the values that u has there."""
    domain, V = u.function_space.mesh, u.function_space
    at_points = np.empty(len(domain.geometry.x))
    at_points[domain.geometry.dofmap.array] = u.x.array[V.dofmap.list.array].real
    part = part_of_mesh(domain)
    result = weft.adapt((part.points, part.tets), metric_of(u)[part.which], fields={"u": at_points[part.which]},
                        comm=comm, ids=part.ids, complexity=complexity, threads=1, subdomains=2 * comm.size)
    adapted = mesh_of_part(comm, result)
    return adapted, values_at(comm, adapted, result, result.fields["u"])


def errors_of(problem, levels):
    """(unknowns, error) of uniform meshes and of adapted ones."""
    uniform, adapted = [], []
    for n in range(levels):
        u, error, unknowns = solve(mesh.create_unit_cube(comm, 6 * 2**n, 6 * 2**n, 6 * 2**n), problem)
        uniform.append((unknowns, error))
        if n == 0:
            first = u
    u = first
    for complexity in [300 * 3**level for level in range(levels) for _ in range(2)]:  # twice each: the metric settles
        domain, start = adapt(u, complexity)
        u, error, unknowns = solve(domain, problem, start)
        adapted.append((unknowns, error))
    return SimpleNamespace(uniform=uniform, adapted=adapted[1::2])


def plot(path, results):
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(1, len(results), figsize=(5 * len(results), 4), squeeze=False)
    for axis, (name, errors) in zip(axes[0], results.items()):
        for label in ("uniform", "adapted"):
            axis.loglog(*zip(*getattr(errors, label)), "o-", label=label)
        axis.set(title=name, xlabel="unknowns", ylabel="error in L2")
        axis.legend()
    figure.tight_layout()
    figure.savefig(path)


def main():
    problems = {"poisson": poisson, "advection": advection}
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--problem", choices=problems, action="append")
    parser.add_argument("--levels", type=int, default=3)
    parser.add_argument("--plot", metavar="FILE")
    given = parser.parse_args()
    results = {name: errors_of(problems[name], given.levels) for name in given.problem or problems}
    if comm.rank == 0:
        for name, errors in results.items():
            for label in ("uniform", "adapted"):
                for unknowns, error in getattr(errors, label):
                    print(f"{name} {label}: {unknowns} unknowns, error {error:.3e}")
        if given.plot:
            plot(given.plot, results)


if __name__ == "__main__":
    main()
