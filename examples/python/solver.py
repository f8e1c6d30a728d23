"""A small finite-element solver whose contacts come from volccd: a block falls onto a clamped beam and breaks it.
docs/into_a_solver.md goes through this file; examples/solver/solver.cpp is the same program in C++."""

import sys

import numpy as np
import volccd

# Units: m, kg, s.
TIME_STEP = 1e-3
STEPS = 300
DENSITY, SHEAR_MODULUS, LAME, GRAVITY = 1000, 2e5, 3e5, 9.81
STRAIN_LIMIT = 0.3  # of the largest principal Green strain; beyond it, an element breaks
SEPARATION = 1e-5   # distance at which features stop approaching each other
SWEEPS = 5          # passes over the contacts in which impulses are applied
MAX_PARTS = 10      # parts of a step; the rest of its time is omitted
# The block at the beginning; the beam has its corner at the origin.
IMPACT_VELOCITY, SPIN = np.array([0, 0, -6.0]), np.array([6, 4, 2.0])
BLOCK_SIZE, BLOCK_CENTRE = np.array([0.4, 0.36, 0.4]), np.array([0.97, 0.21, 0.41])

BEAM, BLOCK = 0, 1


def box(origin, size, n):
    """Points and tetrahedra of a box of n[0] * n[1] * n[2] cubes, each divided into six of positive volume."""
    points = origin + size * (np.stack(np.indices(np.add(n, 1)), -1).reshape(-1, 3) / n)
    number = np.arange(len(points)).reshape(np.add(n, 1))
    cubes = np.indices(n).reshape(3, -1).T
    cells = []
    # Paths along the edges of a cube from (0,0,0) to (1,1,1); those of odd permutations exchange two vertices.
    for path, axes in enumerate([(0, 1, 2), (1, 2, 0), (2, 0, 1), (0, 2, 1), (2, 1, 0), (1, 0, 2)]):
        corners = cubes[:, None] + np.vstack([np.zeros((1, 3), int), np.eye(3, dtype=int)[list(axes)].cumsum(axis=0)])
        cell = number[tuple(np.moveaxis(corners, -1, 0))]
        cells.append(cell if path < 3 else cell[:, [0, 2, 1, 3]])
    return points, np.stack(cells, axis=1).reshape(-1, 4)


class Solver:
    """Both bodies, as one mesh with one array of positions and velocities."""

    def __init__(self):
        beam, beam_cells = box(np.zeros(3), np.array([2, 0.4, 0.2]), (10, 2, 1))
        block, block_cells = box(BLOCK_CENTRE - BLOCK_SIZE / 2, BLOCK_SIZE, (2, 2, 2))
        self.x = np.concatenate([beam, block])
        self.cells = np.concatenate([beam_cells, block_cells + len(beam)])
        self.objects = np.repeat([BEAM, BLOCK], [len(beam_cells), len(block_cells)])
        self.ids = np.arange(len(self.cells))
        # A Detector keeps its workspace: tables of the mesh are built in the first step and updated after edits.
        self.detector = volccd.Detector(self.cells, len(self.x), objects=self.objects, pipeline="VolCCD+")
        self.judge = volccd.Detector(self.cells, len(self.x), objects=self.objects, pipeline="NavCCD")

        edges = self.edge_matrices()
        self.inverse_rest, self.volume = np.linalg.inv(edges), np.linalg.det(edges) / 6
        mass = np.zeros(len(self.x))
        np.add.at(mass, self.cells, (DENSITY * self.volume / 4)[:, None])
        clamped = (self.x[:, 0] == 0) | (self.x[:, 0] == 2)
        self.inverse_mass = np.where(clamped, 0, 1 / mass)
        self.v = np.zeros_like(self.x)
        self.v[len(beam):] = IMPACT_VELOCITY + np.cross(SPIN, block - BLOCK_CENTRE)
        self.rest = self.x.copy()
        self.time, self.removed, self.contact_count, self.shortened, self.good = 0.0, 0, 0, 0, True
        self.first_energy = self.min_energy = self.energy()

    def advance(self):
        """One step: candidate velocities; contacts, response and the largest safe motion; then elements that break."""
        self.add_forces()
        self.move()
        self.remove_broken_elements()

    def edge_matrices(self):
        corners = self.x[self.cells]
        return np.moveaxis(corners[:, 1:] - corners[:, :1], 1, 2)

    def deformation_gradients(self):
        return self.edge_matrices() @ self.inverse_rest

    def add_forces(self):
        """Explicit step of the velocities: gravity and neo-Hookean elements,
        P = mu (F - F^-T) + lambda ln(det F) F^-T."""
        f = self.deformation_gradients()
        inverse = np.linalg.inv(f).transpose(0, 2, 1)
        stress = SHEAR_MODULUS * (f - inverse) + LAME * np.log(np.linalg.det(f))[:, None, None] * inverse
        forces = (-self.volume[:, None, None] * stress @ self.inverse_rest.transpose(0, 2, 1)).transpose(0, 2, 1)
        force = np.zeros_like(self.x)
        np.add.at(force, self.cells[:, 1:], forces)
        np.add.at(force, self.cells[:, 0], -forces.sum(axis=1))
        free = self.inverse_mass > 0
        self.v[free] += TIME_STEP * (self.inverse_mass[:, None] * force - [0, 0, GRAVITY])[free]

    def move(self):
        """Moves all vertices by their velocities for the time of a step, in as many parts as the contacts demand."""
        left = TIME_STEP
        for _ in range(MAX_PARTS):
            self.respond(left)
            earliest = self.detector.step(self.x, self.x + left * self.v, first=True).contacts
            share = 0.9 * earliest[0]["toi"] if len(earliest) else 1.0  # the largest safe step, with a reserve
            before, self.x = self.x, self.x + share * left * self.v
            left *= 1 - share
            self.check(before)
            if left == 0:
                break
            self.stick(earliest[0])
        self.time += TIME_STEP - left

    def respond(self, time):
        """Contacts of the motion that comes next, in which features touch or come within the separation, and their
        impulses."""
        self.detector.separation = SEPARATION
        contacts = self.detector.step(self.x, self.x + time * self.v).contacts
        self.detector.separation = 0
        self.contact_count += len(contacts)
        weights = contacts["weights"].copy()  # of the velocities: negative on the second feature
        weights[:, 2:] *= -1
        weights[contacts["kind"] == volccd.VF, 1] *= -1
        for _ in range(SWEEPS):
            for vertices, weight, normal in zip(contacts["vertices"], weights, contacts["normal"]):
                self.apply_impulse(vertices, weight, normal)

    def apply_impulse(self, vertices, weights, normal):
        """An inelastic impulse: afterwards, the features no longer approach each other."""
        speed = weights @ self.v[vertices] @ normal
        inverse_mass = weights**2 @ self.inverse_mass[vertices]
        if speed < 0 and inverse_mass > 0:
            shares = weights * self.inverse_mass[vertices]
            self.v[vertices] -= speed / inverse_mass * shares[:, None] * normal

    def stick(self, contact):
        """For a contact that the impulses have not resolved, since they disturb each other: its vertices continue with
        their common mean velocity."""
        vertices = contact["vertices"]
        inverse_mass = self.inverse_mass[vertices]
        clamped = (inverse_mass == 0).any()
        self.v[vertices] = 0 if clamped else np.average(self.v[vertices], axis=0, weights=1 / inverse_mass)
        self.shortened += 1

    def remove_broken_elements(self):
        """An element whose largest principal Green strain exceeds the limit is removed. Its vertices keep their
        mass."""
        f = self.deformation_gradients()
        strain = (f.transpose(0, 2, 1) @ f - np.eye(3)) / 2
        broken = np.linalg.eigvalsh(strain)[:, -1] > STRAIN_LIMIT
        if not broken.any():
            return
        for detector in (self.detector, self.judge):
            detector.edit(remove=self.ids[broken])
        for name in ("cells", "objects", "ids", "inverse_rest", "volume"):
            setattr(self, name, getattr(self, name)[~broken])
        self.removed += broken.sum()

    def check(self, before):
        """What the solver promises, checked after every motion: nothing touches in it (by another pipeline), no
        element is inverted, and the energy does not grow."""
        touching = len(self.judge.step(before, self.x))
        min_volume = np.linalg.det(self.deformation_gradients()).min()
        self.min_energy = min(self.min_energy, self.energy())
        gain = (self.energy() - self.min_energy) / self.first_energy
        if touching or min_volume <= 0 or gain >= 0.02:
            print(f"t = {self.time:.4f} s: {touching} contacts in the accepted motion, least volume {min_volume:.3g} "
                  f"of that at rest, energy {100 * gain:+.2f} %")
            self.good = False

    def energy(self):
        """Kinetic, elastic and potential energy. The potential energy is 0 at the beginning."""
        free = self.inverse_mass > 0
        height = (self.x - self.rest)[free, 2]
        energy = (((self.v[free] ** 2).sum(axis=1) / 2 + GRAVITY * height) / self.inverse_mass[free]).sum()
        f = self.deformation_gradients()
        log_volume = np.log(np.linalg.det(f))
        density = SHEAR_MODULUS * (((f**2).sum(axis=(1, 2)) - 3) / 2 - log_volume) + LAME / 2 * log_volume**2
        return energy + self.volume @ density

    def height(self):
        """Mean height of the vertices of the block, weighted by their elements."""
        return self.x[self.cells[self.objects == BLOCK], 2].mean()

    def print(self):
        print(f"{self.time:8.3f}  {self.removed:7d}  {self.contact_count:8d}  {self.shortened:9d}  "
              f"{self.height():10.4f}  {self.energy():10.2f}")


def main():
    solver = Solver()
    print("time [s]  removed  contacts  shortened  height [m]  energy [J]")
    for step in range(STEPS):
        if not solver.good:
            break
        if step % 30 == 0:
            solver.print()
        solver.advance()
    solver.print()
    return 0 if solver.good else 1


if __name__ == "__main__":
    sys.exit(main())
