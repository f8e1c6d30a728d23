"""Results as rows, frames and meshes, and their pickling."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from . import _core

Result = _core.Result


class Contact(NamedTuple):
    """One contact of a `Result`: what its row in `Result.contacts` has.

    >>> import volccd
    >>> contact = volccd.Contact(0, (3, 4, 5, 6), 0.5, None, None, None, False, 0.0)
    >>> contact.kind == volccd.VF, contact.vertices, contact.toi
    (True, (3, 4, 5, 6), 0.5)
    """

    kind: int
    vertices: tuple
    toi: float
    normal: np.ndarray
    point: np.ndarray
    weights: np.ndarray
    at_start: bool
    gap: float


def _contact(row):
    return Contact(int(row["kind"]), tuple(row["vertices"].tolist()), float(row["toi"]), row["normal"].copy(),
                   row["point"].copy(), row["weights"].copy(), bool(row["at_start"]), float(row["gap"]))


def __iter__(self):
    """The contacts, one after another, as `volccd.Contact`. Arrays as a whole are faster: `Result.contacts`."""
    return map(_contact, self.contacts)


def __getitem__(self, index):
    """The contact of a row, as `volccd.Contact`; negative rows count from the end."""
    return _contact(self.contacts[index.__index__()])


def _imported(module, method, package):
    import importlib
    try:
        return importlib.import_module(module)
    except ImportError as problem:
        raise ImportError(f"Result.{method} needs {module} ({package}): {problem}") from None


def to_frame(self):
    """The contacts as a pandas.DataFrame with a row for each, in the order of `contacts`: kind ("VF", "EE"), vertices a,
    b, c, d, toi, normal nx, ny, nz, point px, py, pz, weights w0 .. w3, at_start, gap; the columns have the names of
    contacts.csv where it has them. Needs pandas (Debian: python3-pandas)."""
    pandas = _imported("pandas", "to_frame", "Debian: python3-pandas")
    rows = self.contacts
    columns = {"kind": np.where(rows["kind"] == 0, "VF", "EE")}
    columns.update(zip("abcd", rows["vertices"].T.astype(np.int64)))
    columns["toi"] = rows["toi"].copy()
    for names, field in ((("nx", "ny", "nz"), "normal"), (("px", "py", "pz"), "point"),
                         (("w0", "w1", "w2", "w3"), "weights")):
        columns.update(zip(names, rows[field].T.copy()))
    for name in ("at_start", "gap"):
        columns[name] = rows[name].copy()
    return pandas.DataFrame(columns)


def _point_data(contacts):
    """Arrays under the names that `volccd detect --vtk` gives them."""
    return {"Normal": contacts["normal"].copy(), "TimeOfImpact": contacts["toi"].copy(),
            "Kind": contacts["kind"].astype(np.int32), "AtStart": contacts["at_start"].astype(np.int32),
            "VertexIds": contacts["vertices"].astype(np.int64), "Gap": contacts["gap"].copy()}


def to_meshio(self):
    """The contacts as a meshio.Mesh: a point and a vertex cell for each, with Normal, TimeOfImpact, Kind, AtStart,
    VertexIds and Gap. `.write("contacts.vtu")` is for ParaView. Needs meshio (Debian: python3-meshio)."""
    meshio = _imported("meshio", "to_meshio", "Debian: python3-meshio")
    contacts = self.contacts
    return meshio.Mesh(contacts["point"].copy(), [("vertex", np.arange(len(contacts)).reshape(-1, 1))],
                       point_data=_point_data(contacts))


def to_pyvista(self):
    """The contacts as a pyvista.PolyData: a point for each, with the arrays of `to_meshio`. Needs PyVista, which
    Debian 12 does not have."""
    pyvista = _imported("pyvista", "to_pyvista", "not in Debian 12")
    mesh = pyvista.PolyData(self.contacts["point"].copy())
    for name, values in _point_data(self.contacts).items():
        mesh.point_data[name] = values
    return mesh


def _fields(array, dtype, name):
    """`array` with exactly this dtype."""
    if array.dtype.names != dtype.names:
        raise _core.InputError(f"{name}: pickled by another version of volccd: has {array.dtype.names}")
    result = np.zeros(array.shape, dtype)
    for field in dtype.names:
        result[field] = array[field]
    return result


def _restored(contacts, ends, initial_overlaps, statistics):
    return _core.result_of(_fields(contacts, _core.contact_dtype, "contacts"), _fields(ends, _core.end_dtype, "ends"),
                           _fields(initial_overlaps, _core.pair_dtype, "initial_overlaps"), statistics)


def __reduce__(self):
    """Results can be pickled and copied."""
    arrays = (self.contacts, self.ends, self.initial_overlaps)
    return _restored, (*(_fields(array, array.dtype, "") for array in arrays), dict(self.statistics))


for _method in (__iter__, __getitem__, to_frame, to_meshio, to_pyvista, __reduce__):
    _method.__qualname__ = f"Result.{_method.__name__}"
    setattr(Result, _method.__name__, _method)
