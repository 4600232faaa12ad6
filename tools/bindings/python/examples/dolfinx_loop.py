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

from dolfinx_weft import adapt, boundary_dofs

comm = MPI.COMM_WORLD
EPS = 0.03
dx = ufl.dx(degree=6)  # of what is no polynomial UFL would take hundreds of points a tet


def poisson(domain, V, u, v):
    """-div grad u = f; the solution falls from 1 to -1 across a sphere."""
    x = ufl.SpatialCoordinate(domain)
    exact = -ufl.tanh((ufl.sqrt(ufl.dot(x, x) + 1e-12) - 0.7) / EPS)
    f = -ufl.div(ufl.grad(exact))
    return exact, ufl.inner(ufl.grad(u), ufl.grad(v)) * dx, f * v * dx


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
    a = EPS * ufl.inner(ufl.grad(u), ufl.grad(v)) * dx + ufl.dot(b, ufl.grad(u)) * stabilised * dx
    return exact, a, f * stabilised * dx


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
    square = fem.assemble_scalar(fem.form((u - exact) ** 2 * dx))
    return u, np.sqrt(comm.allreduce(square.real)), V.dofmap.index_map.size_global


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
