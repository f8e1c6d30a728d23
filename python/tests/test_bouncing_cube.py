"""The examples in C and Fortran print what the same loop in Python finds."""

import os
from pathlib import Path

import numpy as np
import pytest
import volccd

H, MASS, STIFFNESS, PENALTY, SEPARATION = 1e-3, 1.0, 2e4, 4e3, 0.05
PLATE, VERTICES, STEPS = 8, 16, 400
CORNERS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], bool)


def springs(rest, x, force):
    for a in range(PLATE, VERTICES):
        for b in range(a + 1, VERTICES):
            pull = STIFFNESS * ((x[b] - x[a]) - (rest[b] - rest[a]))
            force[a] += pull
            force[b] -= pull


def contact_force(contact, end, force):
    size = PENALTY * (SEPARATION - end["gap"])
    first = 1 if contact["kind"] == volccd.VF else 2
    if size > 0:
        for k, vertex in enumerate(contact["vertices"]):
            force[vertex] += (size if k < first else -size) * contact["weights"][k] * contact["normal"]


def line(step, contact, end):
    kind = "VF" if contact["kind"] == volccd.VF else "EE"
    return (f"{step} {kind} {' '.join(map(str, contact['vertices']))}  time {contact['toi']:.6f}  "
            f"end gap {end['gap']:.6f}  normal {' '.join(f'{x:6.3f}' for x in contact['normal'])}")


def by_python():
    rest = np.concatenate([np.where(CORNERS, [2, 2, 0], [-2, -2, -1]), np.where(CORNERS, [0.5, 0.6, 1.12], [-0.5, -0.4, 0.12])])
    x0, v, total, lines = rest.copy(), np.zeros((VERTICES, 3)), 0, []
    detector = volccd.Detector(np.arange(VERTICES).reshape(2, 8), objects=[1, 2], separation=SEPARATION, pairs="inter")
    for step in range(STEPS):
        x1 = x0 + H * v
        found = detector.step(x0, x1, ends=True)
        force = np.zeros((VERTICES, 3))
        springs(rest, x1, force)
        for contact, end in zip(found.contacts, found.ends):
            contact_force(contact, end, force)
            if step % 20 == 0:
                lines.append(line(step, contact, end))
        total += len(found.contacts)
        v[PLATE:] += H * (force[PLATE:] / MASS + [0, 0, -9.81])
        x0 = x1
    return "\n".join([*lines, f"{total} contacts, height {x0[PLATE, 2]:.6f}\n"])


def test_examples_print_what_python_finds():
    """The test package.c stores what the example in C prints; package.fortran compares that in Fortran with it."""
    file = os.environ.get("VOLCCD_BOUNCING_CUBE", "")
    if not file:
        pytest.skip("VOLCCD_BOUNCING_CUBE does not name the output of the example in C, which the ctest package.c makes")
    expected = by_python()
    assert expected.count("\n") > 20
    # zeros of both signs occur among the normals, and sums of forces differ in their last bits
    assert Path(file).read_text().replace("-0.000", " 0.000") == expected.replace("-0.000", " 0.000")
