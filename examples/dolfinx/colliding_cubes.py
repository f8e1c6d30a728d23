"""Two hyperelastic cubes collide, on any number of ranks: DOLFINx for the elements, volccd for the contacts.

    mpirun -n 2 python3 examples/dolfinx/colliding_cubes.py --picture cubes.png

Needs DOLFINx 0.5 and mpi4py (Debian: python3-dolfinx, python3-mpi4py), matplotlib for the picture, and volccd's module on
PYTHONPATH. docs/distributed.md explains the detector.

Explicit dynamics: central differences with lumped masses, neo-Hookean tetrahedra of degree 1. In each step the detector
finds what is within the separation, and each contact gets a penalty force along its normal, which its weights distribute
to its four vertices. Distance and forces belong to the features of the whole mesh, wherever they are; each rank adds those
to the vertices that it owns. The run ends with an error if momentum is not conserved, the cubes overlap, or do not part.
"""

import argparse
import sys

import numpy as np
import ufl
from dolfinx import fem, mesh
from dolfinx.fem.petsc import assemble_vector
from mpi4py import MPI
from petsc4py import PETSc
from volccd.distributed import Detector

YOUNG, POISSON, DENSITY = 100.0, 0.3, 1.0
SEPARATION, STIFFNESS = 0.03, 300.0  # a length; the pressure of contacts for each length that they are closer
SPEED, END = 0.5, 0.7
# The six tetrahedra of a cube, as paths along its edges from one corner to the opposite one.
CUBE = [[0, 1 << a, (1 << a) | (1 << b), 7] for a in range(3) for b in range(3) if a != b]


def cube(n):
    """Points and tetrahedra of a unit cube of n x n x n small ones."""
    grid = np.stack(np.meshgrid(*3 * [np.arange(n + 1)], indexing="ij"), -1).reshape(-1, 3)
    low = grid[(grid < n).all(axis=1)]
    corners = low[:, None, :] + np.array([[c & 1, c >> 1 & 1, c >> 2] for c in range(8)])
    rows = corners @ [(n + 1) ** 2, n + 1, 1]
    return grid / n - 0.5, rows[:, CUBE].reshape(-1, 4)


def two_cubes(n):
    """One above the other, turned, a little further apart than the separation."""
    points, cells = cube(n)
    a, b = np.radians([25, 4])
    turn = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]]) @ \
        np.array([[1, 0, 0], [0, np.cos(b), -np.sin(b)], [0, np.sin(b), np.cos(b)]])
    upper = points @ turn.T
    upper += (0.1, 0.15, 0.5 - upper[:, 2].min() + 1.5 * SEPARATION)
    return np.concatenate([points, upper]), np.concatenate([cells, cells + len(points)])


class Solver:
    def __init__(self, comm, n):
        points, cells = two_cubes(n) if comm.rank == 0 else (np.zeros((0, 3)), np.zeros((0, 4), np.int64))
        element = ufl.VectorElement("Lagrange", ufl.tetrahedron, 1)
        self.area = 1 / n**2  # that a contact stands for
        self.comm, self.domain = comm, mesh.create_mesh(comm, cells, points, ufl.Mesh(element))
        self.space = fem.VectorFunctionSpace(self.domain, ("Lagrange", 1))
        self.displacement = fem.Function(self.space)
        self.make_forms()

        index_map = self.space.dofmap.index_map
        self.owned, self.first = index_map.size_local, index_map.local_range[0]
        vertices = index_map.local_to_global(np.arange(self.owned + index_map.num_ghosts, dtype=np.int32))
        cell_count = self.domain.topology.index_map(3).size_local
        self.cells = self.space.dofmap.list.array.reshape(-1, 4)[:cell_count].astype(np.int64)
        x = self.space.tabulate_dof_coordinates()
        self.start = x[:self.owned].copy()
        between = 0.5 + 0.75 * SEPARATION  # in the gap between the cubes
        self.upper = self.start[:, 2] > between  # of the vertices: they belong to the upper cube
        self.velocity = np.where(self.upper[:, None], [0, 0, -SPEED], [0, 0, SPEED])
        objects = (x[self.cells[:, 0], 2] > between).astype(np.int32)
        self.ids = vertices[self.cells]
        self.detector = Detector(comm, self.cells, vertices, self.owned, objects=objects, pairs="inter",
                                 separation=SEPARATION)
        edge = x[self.cells[:, [0, 0, 0, 1, 1, 2]]] - x[self.cells[:, [1, 2, 3, 2, 3, 3]]]
        shortest = comm.allreduce(np.linalg.norm(edge, axis=2).min(), MPI.MIN)
        wave = np.sqrt(YOUNG * (1 - POISSON) / ((1 + POISSON) * (1 - 2 * POISSON)) / DENSITY)
        self.dt = 0.15 * shortest / wave

    def make_forms(self):
        u, v = self.displacement, ufl.TestFunction(self.space)
        mu, lame = YOUNG / (2 * (1 + POISSON)), YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))
        F = ufl.variable(ufl.Identity(3) + ufl.grad(u))
        J = ufl.det(F)
        energy = mu / 2 * (ufl.tr(F.T * F) - 3 - 2 * ufl.ln(J)) + lame / 2 * ufl.ln(J) ** 2
        self.elastic = fem.form(energy * ufl.dx)
        self.internal = fem.form(ufl.inner(ufl.diff(energy, F), ufl.grad(v)) * ufl.dx)
        ones = fem.Constant(self.domain, PETSc.ScalarType((1, 1, 1)))
        self.mass = self.assembled(fem.form(DENSITY * ufl.inner(ones, v) * ufl.dx))

    def assembled(self, form):
        """By owned vertex."""
        vector = assemble_vector(form)
        vector.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
        values = vector.array.reshape(-1, 3).copy()
        vector.destroy()
        return values

    def positions(self):
        return self.start + self.displacement.x.array.reshape(-1, 3)[:self.owned]

    def overlaps(self):
        """How many pairs of elements overlap: without separation, with which they would only have to be that close."""
        x = self.positions()
        self.detector.separation = 0.0
        result = self.detector.step(x, x, initial_overlaps=True)
        self.detector.separation = SEPARATION
        return self.comm.allreduce(len(result.initial_overlaps))

    def contact_forces(self):
        """Of contacts at the present positions, by owned vertex; and the number of contacts of all."""
        x = self.positions()
        result = self.detector.step(x, x)
        contacts = self.detector.to_owners()
        weights = contacts["weights"].copy()
        vertex = contacts["kind"] == 0
        weights[vertex, 1:] *= -1   # a vertex and a triangle
        weights[~vertex, 2:] *= -1  # two edges
        force = self.area * STIFFNESS * (SEPARATION - contacts["gap"])[:, None] * contacts["normal"]
        rows = contacts["vertices"] - self.first
        mine = (rows >= 0) & (rows < self.owned)
        forces = np.zeros((self.owned, 3))
        for i in range(4):
            np.add.at(forces, rows[mine[:, i], i], (weights[:, i, None] * force)[mine[:, i]])
        return forces, self.comm.allreduce(len(result))

    def step(self):
        forces, contacts = self.contact_forces()
        self.velocity += self.dt * (forces - self.assembled(self.internal)) / self.mass
        self.displacement.x.array.reshape(-1, 3)[:self.owned] += self.dt * self.velocity
        self.displacement.x.scatter_forward()
        return contacts

    def balance(self):
        """Momentum, kinetic and elastic energy, and the mean vertical velocities of the lower and the upper cube."""
        local = [self.mass * self.velocity, self.mass * self.velocity ** 2 / 2, self.mass]
        momentum = self.comm.allreduce(local[0].sum(axis=0))
        speeds = [self.comm.allreduce(local[0][part, 2].sum()) / self.comm.allreduce(local[2][part, 2].sum())
                  for part in (~self.upper, self.upper)]
        return (momentum, self.comm.allreduce(local[1].sum()),
                self.comm.allreduce(fem.assemble_scalar(self.elastic)), *speeds)

    def surface(self):
        """On rank 0: the positions of all vertices, and the triangles that one tetrahedron has."""
        points, cells = self.comm.gather(self.positions()), self.comm.gather(self.ids)
        if points is None:
            return None
        faces = np.sort(np.concatenate(cells)[:, [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]].reshape(-1, 3))
        unique, count = np.unique(faces, axis=0, return_counts=True)
        return np.concatenate(points)[unique[count == 1]]


def draw(surfaces, file):
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection
    figure = pyplot.figure(figsize=(3.2 * len(surfaces), 3.6))
    for i, (time, triangles) in enumerate(surfaces):
        axes = figure.add_subplot(1, len(surfaces), i + 1, projection="3d")
        normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        shade = 0.55 + 0.4 * np.abs(normals @ [0.3, -0.8, 0.52]) / np.linalg.norm(normals, axis=1)
        colour = np.where(triangles.mean(axis=1)[:, 2:] > 0.5, [0.85, 0.55, 0.25], [0.3, 0.5, 0.8])
        axes.add_collection3d(Poly3DCollection(triangles, facecolors=colour * shade[:, None], edgecolors="k",
                                               linewidths=0.15))
        axes.set(xlim=(-0.8, 0.9), ylim=(-0.8, 0.9), zlim=(-0.6, 1.7), box_aspect=(1.7, 1.7, 2.3))
        axes.set_title(f"t = {time:.2f}")
        axes.set_axis_off()
        axes.view_init(elev=12, azim=-60)
    figure.tight_layout()
    figure.savefig(file, dpi=120)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--cells", type=int, default=6, metavar="N", help="small cubes along an edge (default 6)")
    parser.add_argument("--picture", metavar="FILE", help="writes three instants as PNG or SVG")
    options = parser.parse_args()
    comm = MPI.COMM_WORLD
    solver = Solver(comm, options.cells)
    steps = int(np.ceil(END / solver.dt))
    instants, surfaces, touched, worst, overlapping = {0, steps // 2, steps}, [], 0, 0.0, 0
    for k in range(steps + 1):
        if options.picture and k in instants:
            surfaces.append((k * solver.dt, solver.surface()))
        if k % max(1, steps // 7) == 0 or k == steps:
            momentum, kinetic, elastic, lower, upper = solver.balance()
            contacts = solver.contact_forces()[1]
            worst, overlapping = max(worst, np.abs(momentum).max()), overlapping + solver.overlaps()
            if comm.rank == 0:
                print(f"t {k * solver.dt:5.3f}: {contacts:5d} contacts, energy {kinetic:.4f} kinetic + {elastic:.4f} "
                      f"elastic, velocities {lower:+.4f} and {upper:+.4f}, momentum {np.abs(momentum).max():.1e}",
                      flush=True)
        if k < steps:
            touched += solver.step() > 0
    if options.picture and comm.rank == 0:
        draw(surfaces, options.picture)
    problems = [text for bad, text in (
        (touched == 0, "the cubes did not touch"), (overlapping > 0, "the cubes overlap"),
        (lower >= 0 or upper <= 0, "the cubes did not part"), (worst > 1e-12, "momentum is not conserved")) if bad]
    if comm.rank == 0:
        print(f"{comm.size} ranks, {steps} steps: velocities {lower:+.9f} and {upper:+.9f}")
        print("; ".join(problems) or "the cubes touched, parted, never overlapped, and momentum was conserved to 1e-12")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
