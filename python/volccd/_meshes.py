"""Converts cells from all accepted forms to one set of arrays."""

import numpy as np

# VTK's number of each type, under VTK's, meshio's and this library's names.
CELL_TYPES = {
    "triangle": 5, "quad": 9, "tetra": 10, "tetrahedron": 10, "hexahedron": 12, "wedge": 13, "pyramid": 14,
    "polyhedron": 42, "polytope": 42,
}
_POLYTOPE = 42
_VERTICES = {5: 3, 9: 4, 10: 4, 12: 8, 13: 6, 14: 5}
_BY_COLUMNS = {3: 5, 4: 10, 5: 14, 6: 13, 8: 12}


def _type_number(name):
    """VTK's number for a name ("tetra", "polyhedron12") or a number."""
    if not isinstance(name, str):
        return int(name)
    if name in CELL_TYPES:
        return CELL_TYPES[name]
    if name.startswith("polyhedron"):  # meshio appends the number of vertices
        return _POLYTOPE
    from ._core import InputError
    raise InputError(f"cells: type {name!r} is none of {', '.join(CELL_TYPES)}, and no VTK cell type")


class _Arrays:
    """Collects blocks of cells in their order."""

    def __init__(self):
        self.types, self.lengths, self.connectivity = [], [], []
        self.faces, self.face_lengths = [], []

    def add_block(self, name, data):
        number = _type_number(name)
        if number == _POLYTOPE:
            for faces in data:
                self.add_polytope(faces)
            return
        data = np.asarray(data)
        expected = _VERTICES.get(number)
        if data.ndim != 2 or (expected and data.shape[1] != expected):
            from ._core import InputError
            raise InputError(f"cells: an array of type {name!r} must have the shape (n, {expected}), "
                             f"not {data.shape}")
        self.types.append(np.full(len(data), number, np.uint8))
        self.lengths.append(np.full(len(data), data.shape[1], np.int64))
        self.connectivity.append(_integers(data).ravel())
        self.face_lengths.append(np.zeros(len(data), np.int64))

    def add_polytope(self, faces):
        faces = [_integers(face).ravel() for face in faces]
        vertices = np.unique(np.concatenate(faces)) if faces else np.zeros(0, np.int64)
        stream = [part for face in faces for part in (np.array([len(face)], np.int64), face)]
        self.types.append(np.array([_POLYTOPE], np.uint8))
        self.lengths.append(np.array([len(vertices)], np.int64))
        self.connectivity.append(vertices)
        self.faces.extend(stream)
        self.face_lengths.append(np.array([sum(map(len, stream))], np.int64))

    def finished(self):
        polytopes = bool(self.faces)
        return {
            "types": _joined(self.types, np.uint8),
            "offsets": _offsets(_joined(self.lengths, np.int64)),
            "connectivity": _joined(self.connectivity, np.int64),
            "face_offsets": _offsets(_joined(self.face_lengths, np.int64)) if polytopes else None,
            "faces": _joined(self.faces, np.int64) if polytopes else None,
        }


def _integers(values):
    values = np.asarray(values)
    if values.size and values.dtype.kind not in "iu":
        from ._core import InputError
        raise InputError(f"cells: vertex numbers must be integers, not {values.dtype}")
    return values.astype(np.int64, copy=False)


def _joined(parts, dtype):
    return np.concatenate(parts).astype(dtype, copy=False) if parts else np.zeros(0, dtype)


def _offsets(lengths):
    return np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64)


def vtk_cells(connectivity, offsets, types):
    """Cells as VTK stores them: all vertex numbers one after another, where each cell begins (n + 1 offsets, the last
    one the end), and VTK's cell types. For polyhedra use the form ("polyhedron", [[face, ...], ...]) instead.

    Returns what every `cells` argument of this package accepts.

    >>> cells = vtk_cells([0, 1, 2, 3], offsets=[0, 4], types=[10])
    """
    return {"connectivity": _integers(connectivity), "offsets": _integers(offsets),
            "types": np.asarray(types).astype(np.uint8, casting="unsafe")}


def _is_blocks_of_meshio(cells):
    return isinstance(cells, (list, tuple)) and bool(cells) and hasattr(cells[0], "type") and hasattr(cells[0], "data")


def _is_pairs(cells):
    """Blocks in the form [(type, array), ...]. An array of two columns is no block, because no element has two
    vertices."""
    return isinstance(cells, (list, tuple)) and bool(cells) and isinstance(cells[0], (list, tuple)) and \
        len(cells[0]) == 2 and (isinstance(cells[0][0], str) or hasattr(cells[0][1], "__len__"))


def _arrays_of(cells):
    if isinstance(cells, dict) and {"connectivity", "offsets", "types"} <= cells.keys():
        arrays = {"face_offsets": None, "faces": None, **cells}
        return {key: arrays[key] for key in ("types", "offsets", "connectivity", "face_offsets", "faces")}
    made = _Arrays()
    if isinstance(cells, dict):
        pairs = cells.items()
    elif _is_blocks_of_meshio(cells):
        pairs = [(block.type, block.data) for block in cells]
    elif _is_pairs(cells):
        pairs = cells
    else:
        data = np.asarray(cells)
        if data.size == 0:
            pairs = []
        else:
            pairs = [(_BY_COLUMNS.get(data.shape[1] if data.ndim == 2 else 0, 0), data)]
            if pairs[0][0] == 0:
                from ._core import InputError
                raise InputError(f"cells: an array of the shape {data.shape} is no list of elements: triangles have 3 "
                                 "columns, tetrahedra 4, pyramids 5, wedges 6, hexahedra 8; name other types: "
                                 "[('quad', array)]")
    for name, data in pairs:
        made.add_block(name, data)
    return made.finished()


def _per_cell(values, n, default, dtype):
    if values is None:
        return default
    return np.ascontiguousarray(np.broadcast_to(np.asarray(values), (n,)).astype(dtype))


def cell_arrays(cells, objects=None, ids=None, first_id=0):
    """The arrays of `cells`, with an object and an id for each cell."""
    cells = getattr(cells, "cells", cells) if hasattr(cells, "points") else cells
    arrays = _arrays_of(cells)
    n = len(arrays["types"])
    arrays["objects"] = _per_cell(objects, n, np.zeros(n, np.int32), np.int32)
    arrays["ids"] = _per_cell(ids, n, np.arange(first_id, first_id + n, dtype=np.int64), np.int64)
    return arrays


def vertex_count(arrays):
    connectivity = arrays["connectivity"]
    return int(connectivity.max()) + 1 if len(connectivity) else 0


def points_of(points):
    """The points of an array, or of a mesh of meshio or PyVista."""
    return np.asarray(getattr(points, "points", points), dtype=np.float64)


def cells_of(mesh):
    """The cells of a mesh of meshio (list of blocks) or of PyVista (VTK's arrays)."""
    if hasattr(mesh, "celltypes"):  # pyvista.UnstructuredGrid
        return _cells_of_pyvista(mesh)
    if hasattr(mesh, "cells"):
        return list(mesh.cells)
    from ._core import InputError
    raise InputError(f"cells: {type(mesh).__name__} has none: pass a meshio.Mesh, a "
                     "pyvista.UnstructuredGrid, or cells=...")


def _cells_of_pyvista(grid):
    types = np.asarray(grid.celltypes)
    if not np.any(types == _POLYTOPE):
        return vtk_cells(grid.cell_connectivity, grid.offset, types)
    made = _Arrays()
    for i in range(grid.n_cells):
        cell = grid.get_cell(i)
        if types[i] == _POLYTOPE:
            made.add_polytope([face.point_ids for face in cell.faces])
        else:
            made.add_block(int(types[i]), np.array([cell.point_ids]))
    return made.finished()
