"""Contacts of a mesh given by arrays."""

from __future__ import annotations

import numpy as np

from . import _core, _meshes
from ._arguments import settings_list, suggesting


def _options(pipeline, settings, threads, separation, pairs, exclude, lists="off"):
    if not 0 <= threads < 2**32 or threads != int(threads):
        raise _core.ConfigError(f"threads: {threads} is not a number of threads; 0: as many as the machine has")
    exclude = _meshes.numbers_of(list(exclude), "exclude", np.int32)
    if exclude.size and (exclude.ndim != 2 or exclude.shape[1] != 2):
        raise _core.InputError(f"exclude: has the shape {exclude.shape} instead of (n, 2), pairs of objects")
    return {"pipeline": pipeline, "settings": settings_list(settings), "threads": int(threads), "separation": float(separation),
            "pairs": pairs, "exclude": [(int(a), int(b)) for a, b in exclude],
            "lists": lists if isinstance(lists, str) else tuple(float(x) for x in lists)}


class Detector:
    """A mesh and a pipeline that keep their memory and their tables (features, trees) from step to step.

    Parameters
    ----------
    cells :
        What `volccd.detect` accepts, or a mesh of meshio or PyVista.
    vertices : int, optional
        How many points a step has. Default: the largest vertex number of the cells, plus 1.
    objects : int array (n,), optional
        The object that each element belongs to; default: those of `cells` if it is a dict that has them, as
        `Sequence.cells` gives them, else 0. Wherever integers are expected, floats that are exact
        integers of that range count, as files have them; everything else raises InputError.
    ids : int array (n,), optional
        Distinct ids of the elements, by which `edit` names them; default: those of `cells`, as for objects, else 0, 1,
        2, ...
    thickness : float or float array (n,), optional
        Thickens triangles and quads into solids, in the unit of the points. Vertex v of a contact then stems from point
        v // 3, and contacts between features that stem from one point are not reported.
    pipeline, separation, threads, settings, pairs, exclude, edges :
        As in `volccd.detect`.
    lists : "off", "auto" or (budget, steps)
        Whether steps test the candidates of earlier steps instead of finding all pairs anew; contacts are the same. For
        small steps, as a solver's. "auto": where that is faster, as measured; or with a budget (a distance) by which
        points may be away from where the motion would bring them if it went on for a number of steps.

    A Detector serves one thread at a time; it raises `volccd.Error` otherwise. The GIL is released while it works, so
    that Detectors of several Python threads run side by side.

    >>> import numpy as np, volccd
    >>> points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1],
    ...                    [-1, -1, 2], [2, -1, 2], [-1, 2, 2], [0, 0, 3]], float)
    >>> detector = volccd.Detector([[0, 1, 2, 3], [4, 5, 6, 7]], objects=[0, 1])
    >>> for step in range(4):
    ...     moved = points.copy()
    ...     moved[4:, 2] -= 0.5
    ...     print(step, len(detector.step(points, moved)))
    ...     points = moved
    0 0
    1 1
    2 1
    3 25
    """

    @suggesting
    def __init__(self, cells, vertices=None, *, objects=None, ids=None, thickness=None, pipeline="VolCCD+",
                 separation=0.0, threads=0, settings=(), pairs="all", exclude=(), edges="triangulated", lists="off"):
        if hasattr(cells, "points"):
            vertices = len(cells.points) if vertices is None else vertices
            cells = _meshes.cells_of(cells)
        arrays = _meshes.cell_arrays(cells, objects, ids)
        n = len(arrays["types"])
        if vertices is None:
            vertices = _meshes.vertex_count(arrays)
        self._core = _core.Detector(arrays, vertices, _meshes.thickness_of(thickness, arrays), edges,
                                    _options(pipeline, settings, threads, separation, pairs, exclude, lists))
        self._next_id = int(arrays["ids"].max()) + 1 if n else 0

    @suggesting
    def step(self, points0, points1, middle=None, *, first=False, initial_overlaps=False, t_max=1.0, ends=False):
        """Contacts of the motion from `points0` (t = 0) to `points1` (t = 1), float (vertices, 3) each.

        Arrays that are float64 and C-contiguous are read in place; others are converted once. The motion itself is kept
        interleaved by vertex, so that each coordinate is copied once in any case.

        middle : float (vertices, 3), optional
            Middle control points of quadratic Bezier curves (not points of the curves): constant acceleration.
        first : bool
            The earliest contact alone.
        initial_overlaps : bool
            Also list the pairs of elements that overlap at t = 0.
        t_max : float
            Contacts later than this, in 0 .. 1 of the step, need not be found.
        ends : bool
            Also give distance and closest points of each contact's features at t = 1, as `Result.ends`.

        Returns a `volccd.Result`. Ctrl-C ends the step with KeyboardInterrupt; the Detector can be used again.
        """
        points0, points1 = _meshes.points_of(points0, "points0"), _meshes.points_of(points1, "points1")
        middle = None if middle is None else _meshes.points_of(middle, "middle")
        return self._core.step(points0, points1, middle, first, initial_overlaps, t_max, ends)

    @suggesting
    def edit(self, remove=(), add=(), *, new_vertices=0, objects=None, ids=None, thickness=None):
        """Changes the mesh between two steps; stages follow the change instead of starting anew.

        First the elements with the ids `remove` go, or those where `remove`, a bool array by slot as `element_ids`, is
        True. Then `new_vertices` points are appended, then the cells `add` come, with `objects`, `ids` (default: numbers
        not used before) and, where the Detector has shells, `thickness`. An edit that the mesh does not allow raises
        InputError and changes nothing. Returns the ids of the added elements.
        """
        arrays = _meshes.cell_arrays(add, objects, ids, self._next_id)
        thickness = _meshes.thickness_of(thickness, arrays)
        remove = np.atleast_1d(np.asarray(remove))
        if remove.dtype == bool:
            remove = _meshes.selected(remove, self.element_ids)
        self._core.edit(_meshes.numbers_of(remove, "remove"), new_vertices, arrays, thickness)
        if len(arrays["ids"]):
            self._next_id = max(self._next_id, int(arrays["ids"].max()) + 1)
        return arrays["ids"]

    @property
    def element_ids(self):
        """Ids by slot, int64; -1 where a removed element has left its slot empty. `initial_overlaps` are slots."""
        return self._core.element_ids

    @property
    def separation(self):
        """Contact when the distance reaches this, in the unit of the points. May be changed between steps."""
        return self._core.separation

    @separation.setter
    def separation(self, value):
        self._core.separation = value

    @property
    def vertex_count(self):
        """Points of a step."""
        return self._core.vertex_count

    @property
    def element_count(self):
        """Elements that there are now."""
        return self._core.element_count

    @property
    def facts(self):
        """dict: pipeline, guarantee ("exact", "conservative", "approximate"), threads, and stages: (role, name,
        options) with defaults."""
        return self._core.facts

    def __repr__(self):
        return f"<volccd.Detector: {self.element_count} elements, {self.vertex_count} points, {self.facts['pipeline']}>"


@suggesting
def detect(points0, points1, cells=None, pipeline="VolCCD+", separation=0.0, *, middle=None, objects=None, ids=None,
           thickness=None, threads=0, first=False, initial_overlaps=False, t_max=1.0, pairs="all", exclude=(),
           edges="triangulated", settings=()):
    """All contacts of a mesh that moves from `points0` to `points1`.

    Parameters
    ----------
    points0, points1 : float array (n, 3)
        The points at t = 0 and t = 1, any unit of length. Or a meshio.Mesh, or a pyvista.UnstructuredGrid; `cells` may
        then be left out.
    cells :
        The elements, as one of
          - an int array: (m, 4) tetrahedra, (m, 8) hexahedra, (m, 6) wedges, (m, 5) pyramids, (m, 3) triangles;
          - pairs (type, array), or a dict of them: {"tetra": (m, 4), "quad": (k, 4)}, types as in `volccd.CELL_TYPES`;
            polyhedra, which must be convex, as lists of faces: ("polyhedron", [[[0, 1, 2], ...], ...]);
          - meshio's list of blocks;
          - VTK's arrays: `volccd.vtk_cells(connectivity, offsets, types)`.
    pipeline : str
        One of `volccd.pipelines()`. All that are exact or conservative find the same contacts.
    separation : float
        Contact when the distance reaches this, in the unit of the points. 0: when they touch.
    middle : float array (n, 3), optional
        Middle control points of quadratic Bezier curves: constant acceleration.
    objects : int array (m,), optional
        The object of each element, for `pairs` and `exclude`.
    ids : int array (m,), optional
        Distinct ids of the elements.
    thickness : float or float array (m,), optional
        Thickens triangles and quads into solids; vertices of contacts are then 3 v, 3 v + 1, 3 v + 2 for point v.
    threads : int
        0: as many as the machine has.
    first : bool
        The earliest contact alone: the largest safe step.
    initial_overlaps : bool
        Also list the pairs of elements that overlap at t = 0.
    t_max : float
        Contacts later than this, in 0 .. 1 of the step, need not be found.
    pairs : "all", "inter", "intra"
        Contacts of all pairs, between different objects, or within objects.
    exclude : pairs of objects
        Between which contacts are not looked for; (a, a): within object a.
    edges : "triangulated", "polytope"
        With the diagonals of faces (complete), or without (the paper's counts).
    settings : str, list of str, or dict
        Changes of the pipeline, as `--set` of the program: "csat.axis=optimal", "element-culling=csat"; or as a dict:
        {"csat.axis": "optimal", "feature-filter": ["feature-kdop", "coplanarity"], "flood": None}.

    Returns
    -------
    Result
        `.contacts`, a structured array with fields kind (0: vertex-face, 1: edge-edge), vertices (4), toi (0 .. 1 of
        the step), normal (3), point (3), weights (4), at_start; `.statistics`, a dict; `.initial_overlaps`. It is also a
        sequence of `volccd.Contact`, and has `.to_frame()`, `.to_meshio()`, `.to_pyvista()`.

    Examples
    --------
    >>> import numpy as np, volccd
    >>> points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1],
    ...                    [-1, -1, 2], [2, -1, 2], [-1, 2, 2], [0, 0, 3]], float)
    >>> moved = points.copy()
    >>> moved[4:, 2] -= 2
    >>> result = volccd.detect(points, moved, [[0, 1, 2, 3], [4, 5, 6, 7]])
    >>> contact = result.contacts[result.contacts["toi"].argmin()]
    >>> contact["kind"] == volccd.VF, contact["vertices"].tolist(), round(float(contact["toi"]), 6)
    (True, [3, 4, 5, 6], 0.5)
    """
    if cells is None:
        cells = _meshes.cells_of(points0)
    points0 = _meshes.points_of(points0, "points0")
    detector = Detector(cells, len(points0), objects=objects, ids=ids, thickness=thickness, pipeline=pipeline,
                        separation=separation, threads=threads, settings=settings, pairs=pairs, exclude=exclude,
                        edges=edges)
    return detector.step(points0, points1, middle, first=first, initial_overlaps=initial_overlaps, t_max=t_max)
