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


def _fail(problem):
    from ._core import InputError
    raise InputError(problem)


def numbers_of(values, name, dtype=np.int64, shape=None):
    """`values` as a C-contiguous array of `dtype`; not copied where they are one already.

    For an integer dtype, the values must be integers in its range; floats that are exact integers count, because files
    store numbers in this way. For float64, integers count, too. Booleans and text do not. With a shape, the array must
    have it; a single number stands for all. Raises InputError naming the argument, the index and the value.
    """
    try:
        values, dtype = np.asarray(values), np.dtype(dtype)
    except ValueError as error:  # rows of different lengths
        _fail(f"{name}: {error}")
    if values.dtype == object:  # integers beyond 64 bits, or no numbers
        for index, value in np.ndenumerate(values):
            if not isinstance(value, int) or isinstance(value, bool):
                _fail(f"{_at(name, index)}: {value!r} is not a number")
    elif values.dtype.kind not in "iuf":
        _fail(f"{name}: values of type {values.dtype} are not numbers")
    if dtype.kind == "i" or dtype.kind == "u":
        _check_integers(values, name, dtype)
    if shape is not None and values.ndim > 0 and values.shape != shape:
        _fail(f"{name}: has the shape {values.shape} instead of {shape}")
    if shape and values.ndim == 0:
        values = np.full(shape, values)
    return np.asarray(values, dtype, order="C")


def _check_integers(values, name, dtype):
    if values.dtype == dtype:
        return
    low, end = int(np.iinfo(dtype).min), int(np.iinfo(dtype).max) + 1
    if values.dtype.kind == "f":  # both bounds are exact as floats
        bad = ~((values >= float(low)) & (values < float(end)) & (values == np.floor(values)))
    elif values.dtype == object:
        bad = (values < low) | (values >= end)
    else:
        own = np.iinfo(values.dtype)
        bad = (values < max(low, int(own.min))) | (values > min(end - 1, int(own.max)))
    if np.any(bad):
        index = tuple(int(i[0]) for i in np.nonzero(np.atleast_1d(bad)))
        value = np.atleast_1d(values)[index]
        fraction = values.dtype.kind == "f" and value != np.floor(value)
        _fail(f"{_at(name, index if values.ndim else ())}: {value} is not "
              + ("an integer" if fraction else f"within {low} .. {end - 1}"))


def _at(name, index):
    return f"{name}[{', '.join(map(str, index))}]" if index else name


def _type_number(name):
    """VTK's number for a name ("tetra", "polyhedron12") or a number."""
    if not isinstance(name, str):
        return int(numbers_of(name, "cells: type", np.uint8, ()))
    if name in CELL_TYPES:
        return CELL_TYPES[name]
    if name.startswith("polyhedron"):  # meshio appends the number of vertices
        return _POLYTOPE
    _fail(f"cells: type {name!r} is none of {', '.join(CELL_TYPES)}, and no VTK cell type")


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
            _fail(f"cells: an array of type {name!r} must have the shape (n, {expected}), not {data.shape}")
        self.types.append(np.full(len(data), number, np.uint8))
        self.lengths.append(np.full(len(data), data.shape[1], np.int64))
        self.connectivity.append(numbers_of(data, "cells").ravel())
        self.face_lengths.append(np.zeros(len(data), np.int64))

    def add_polytope(self, faces):
        faces = [numbers_of(face, "cells: face").ravel() for face in faces]
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
    return _vtk_arrays({"connectivity": connectivity, "offsets": offsets, "types": types})


_VTK_ARRAYS = {"types": np.uint8, "offsets": np.int64, "connectivity": np.int64, "face_offsets": np.int64,
               "faces": np.int64}


def _vtk_arrays(cells):
    return {name: None if cells.get(name) is None else numbers_of(cells[name], name, dtype)
            for name, dtype in _VTK_ARRAYS.items()}


def _is_blocks_of_meshio(cells):
    return isinstance(cells, (list, tuple)) and bool(cells) and hasattr(cells[0], "type") and hasattr(cells[0], "data")


def _is_pairs(cells):
    """Blocks in the form [(type, array), ...]. An array of two columns is no block, because no element has two
    vertices."""
    return isinstance(cells, (list, tuple)) and bool(cells) and isinstance(cells[0], (list, tuple)) and \
        len(cells[0]) == 2 and (isinstance(cells[0][0], str) or hasattr(cells[0][1], "__len__"))


def _arrays_of(cells):
    if isinstance(cells, dict) and {"connectivity", "offsets", "types"} <= cells.keys():
        return _vtk_arrays(cells)
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
                _fail(f"cells: an array of the shape {data.shape} is no list of elements: triangles have 3 columns, "
                      "tetrahedra 4, pyramids 5, wedges 6, hexahedra 8; name other types: [('quad', array)]")
    for name, data in pairs:
        made.add_block(name, data)
    return made.finished()


def cell_arrays(cells, objects=None, ids=None, first_id=0):
    """The arrays of `cells`, with an object and an id for each cell."""
    cells = getattr(cells, "cells", cells) if hasattr(cells, "points") else cells
    arrays = _arrays_of(cells)
    n = len(arrays["types"])
    if isinstance(cells, dict) and "connectivity" in cells:  # as Sequence.cells has them
        objects = cells.get("objects") if objects is None else objects
        ids = cells.get("ids") if ids is None else ids
    arrays["objects"] = numbers_of(0 if objects is None else objects, "objects", np.int32, (n,))
    arrays["ids"] = numbers_of(np.arange(first_id, first_id + n) if ids is None else ids, "ids", np.int64, (n,))
    return arrays


def thickness_of(values, arrays):
    return None if values is None else numbers_of(values, "thickness", np.float64, (len(arrays["types"]),))


def selected(mask, ids):
    """The ids at which a mask over `ids`, the ids by slot, is True."""
    if mask.shape != ids.shape:
        _fail(f"remove: the mask has the shape {mask.shape} instead of {ids.shape}, that of `element_ids`")
    empty = np.flatnonzero(mask & (ids == -1))
    if len(empty):
        _fail(f"remove[{empty[0]}]: the mask selects an empty slot")
    return ids[mask]


def vertex_count(arrays):
    connectivity = arrays["connectivity"]
    return int(connectivity.max()) + 1 if len(connectivity) else 0


def points_of(points, name):
    """The points of an array, or of a mesh of meshio or PyVista."""
    return numbers_of(getattr(points, "points", points), name, np.float64)


def cells_of(mesh):
    """The cells of a mesh of meshio (list of blocks) or of PyVista (VTK's arrays)."""
    if hasattr(mesh, "celltypes"):  # pyvista.UnstructuredGrid
        return _cells_of_pyvista(mesh)
    if hasattr(mesh, "cells"):
        return list(mesh.cells)
    _fail(f"cells: {type(mesh).__name__} has none: pass a meshio.Mesh, a pyvista.UnstructuredGrid, or cells=...")


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
