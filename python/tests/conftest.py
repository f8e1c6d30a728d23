"""Meshes that several tests use."""

import numpy as np
import pytest

TETRAHEDRA = np.array([[0, 1, 2, 3], [4, 5, 6, 7]])
POINTS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [-1, -1, 2], [2, -1, 2], [-1, 2, 2], [0, 0, 3]], float)


@pytest.fixture
def falling():
    """points0, points1, cells: the tip of the first tetrahedron meets the base of the second one at t = 0.5."""
    moved = POINTS.copy()
    moved[4:, 2] -= 2
    return POINTS.copy(), moved, TETRAHEDRA.copy()


@pytest.fixture
def clean_registry():
    """Removes the stages and pipelines that a test has registered."""
    import volccd._stages as stages
    before = dict(stages._registered), dict(stages._pipelines)
    yield
    stages._apply(*before)


CUBE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float)
CUBE_FACES = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
