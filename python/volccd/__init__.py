"""Continuous collision detection between deforming volume meshes: what touches what, and when.

A mesh of tetrahedra, hexahedra, wedges, pyramids, convex polyhedra or shells moves from `points0` at t = 0 to `points1`
at t = 1. `volccd.detect` finds every vertex-triangle and edge-edge contact in between, those of interior features
included, with its first time. Points are float arrays (n, 3) in any unit of length; times are in 0 .. 1 of the step.

In one line
-----------
>>> import numpy as np, volccd
>>> points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1],           # one tetrahedron,
...                    [-1, -1, 2], [2, -1, 2], [-1, 2, 2], [0, 0, 3]], float)  # and one above it
>>> tetrahedra = [[0, 1, 2, 3], [4, 5, 6, 7]]
>>> moved = points - np.repeat([[0, 0, 0], [0, 0, 2]], 4, axis=0)             # which falls by 2
>>> result = volccd.detect(points, moved, tetrahedra)
>>> round(result.earliest, 6)
0.5
>>> first = result.contacts[result.contacts["toi"].argmin()]
>>> first["vertices"].tolist()                                                # vertex 3, triangle 4 5 6
[3, 4, 5, 6]

Contacts are a structured array: kind (volccd.VF, volccd.EE), vertices, toi, normal, point, weights, at_start. A result can
also be iterated over, pickled, and turned into a frame of pandas or a mesh of meshio or PyVista.

Step after step
---------------
`Detector` keeps its tables and memory; `edit` removes and adds elements between two steps; `first=True` asks for the
largest safe step alone:

>>> detector = volccd.Detector(tetrahedra, threads=2)
>>> detector.step(points, moved, first=True).earliest == result.earliest
True
>>> detector.edit(remove=[1])
array([], dtype=int64)
>>> len(detector.step(points, moved).contacts)
0

Files and scenes
----------------
>>> sequence = volccd.scene("builtin")                                        # or volccd.Sequence("run.vtkhdf")
>>> [(step, len(result)) for step, result in sequence.detect(range(2))]
[(0, 104), (1, 385)]

Stages in Python
----------------
A class with one method on arrays runs in any pipeline: see `volccd.ElementCulling`, `volccd.FeatureFilter`,
`volccd.NarrowPhase`, `volccd.register`; `volccd.verify` compares it with all the others, and `volccd.main` is the whole
program with it.

Errors: `InputError` and `ConfigError`, both `volccd.Error` and ValueError. docs/python.md goes through it all.
"""

try:
    from ._core import ConfigError, Error, InputError, Result, __version__, contact_dtype, pair_dtype
except ImportError as problem:
    import sys as _sys
    raise ImportError(
        f"{problem}. volccd needs its compiled module and NumPy for {_sys.executable}. To build it: cmake --build --preset "
        "release --target volccd_python; `cmake --preset release` says for which Python (VOLCCD_PYTHON names another)"
    ) from problem
from . import distributed
from ._detect import Detector, detect
from ._meshes import CELL_TYPES, vtk_cells
from ._records import read_record, records
from ._results import Contact
from ._sequences import Sequence, Verification, scene, scenes, verify
from ._stages import (CONTACT_FREE, DISJOINT, KEEP, ElementCulling, FeatureFilter, NarrowPhase, Stage, Step,
                      add_pipeline, main, pipelines, register, stages, unregister)

VF, EE = 0, 1  # kinds of contacts: vertex-face, edge-edge

__all__ = [
    "detect", "Detector", "Result", "Contact", "vtk_cells", "CELL_TYPES", "VF", "EE", "contact_dtype", "pair_dtype",
    "Sequence", "scene", "scenes", "verify", "Verification",
    "Stage", "Step", "ElementCulling", "FeatureFilter", "NarrowPhase", "KEEP", "DISJOINT", "CONTACT_FREE",
    "register", "unregister", "add_pipeline", "stages", "pipelines", "main",
    "distributed", "records", "read_record", "Error", "InputError", "ConfigError",
]
