"""Exodus II results (.e, .exo, .ex2), by netCDF4."""

import meshio
import numpy as np

from .errors import BadInput, needed
from .numbering import Numbering

# How the name of an element type begins, and meshio's name and the number of corners.
TYPES = (("TRI", "triangle", 3), ("SHELL3", "triangle", 3), ("TET", "tetra", 4), ("HEX", "hexahedron", 8),
         ("WEDGE", "wedge", 6), ("PYRA", "pyramid", 5), ("QUAD", "quad", 4), ("SHELL", "quad", 4))
LEFT_OUT = ("SPHERE", "CIRCLE", "BEAM", "BAR", "TRUSS", "EDGE", "POINT", "LINE", "RBAR", "JOINT", "SPRING", "NULL")


def text(characters):
    return b"".join(characters).split(b"\0")[0].decode("utf-8", "replace").strip()


def names(data, variable):
    return [text(row) for row in data.variables[variable][:]] if variable in data.variables else []


def vectors_of(scalars):
    """Scalars by name, with those that end in X, Y (and Z) as one vector: disp_x, disp_y, disp_z are disp."""
    result = dict(scalars)
    for name in scalars:
        if name[-1:] not in ("x", "X"):
            continue
        stem, x = name[:-1], name[-1]
        rest = [stem + letter for letter in ("yz" if x == "x" else "YZ")]
        components = [name] + [other for other in rest if other in scalars]
        if len(components) < 2 or stem.rstrip("_") in scalars or not stem.rstrip("_"):
            continue
        for component in components:
            result.pop(component)
        result[stem.rstrip("_")] = np.column_stack([scalars[component] for component in components]
                                                   + [np.zeros(len(scalars[name]))] * (3 - len(components)))
    return result


def block_cells(data, number, file):
    """(meshio's type, nodes from 0) of an element block, or None if its elements have no surface."""
    connectivity = data.variables[f"connect{number}"]
    name = str(getattr(connectivity, "elem_type", "")).strip("\0 ").upper()
    if name.startswith(LEFT_OUT) or len(connectivity.shape) != 2 and name.startswith("NSIDED"):
        return None
    nodes = np.asarray(connectivity[:], np.int64) - 1
    kind = next(((kind, corners) for start, kind, corners in TYPES if name.startswith(start)), None)
    if kind == ("quad", 4) and nodes.shape[1] in (3, 6, 7) and name.startswith("SHELL"):
        kind = ("triangle", 3)
    if kind is None or nodes.ndim != 2 or nodes.shape[1] < kind[1]:
        raise BadInput(file, f"connect{number}", f"elements of type '{name}' are not supported")
    return kind[0] if nodes.shape[1] == kind[1] else f"{kind[0]}{nodes.shape[1]}", nodes


def coordinates(data):
    if "coord" in data.variables:
        return np.asarray(data.variables["coord"][:], np.float64).T
    return np.column_stack([np.asarray(data.variables[name][:], np.float64)
                            for name in ("coordx", "coordy", "coordz") if name in data.variables])


def opened(file):
    data = needed("netCDF4", "python3-netcdf4", file).Dataset(file)
    data.set_auto_mask(False)
    return data


def times(file):
    with opened(file) as data:
        found = data.variables["time_whole"][:] if "time_whole" in data.variables else []
        return [float(time) for time in found]


def read(file, step):
    """The mesh and its numbers, with the results of a step (None: the file has no steps). Element blocks are objects."""
    with opened(file) as data:
        blocks, rows, parts, first = [], [], {}, 0
        ids = data.variables["eb_prop1"][:].tolist() if "eb_prop1" in data.variables else []
        block_names = names(data, "eb_names")
        number = 1
        while f"connect{number}" in data.variables:
            cells = block_cells(data, number, file)
            count = data.variables[f"connect{number}"].shape[0]
            if cells is not None:
                blocks.append(cells)
                part = ids[number - 1] if number <= len(ids) else number
                rows += range(first, first + count)
                name = block_names[number - 1] if number <= len(block_names) else ""
                parts[int(part)] = (name, len(cells[1]))
            first += count
            number += 1
        points = coordinates(data)
        scalars = {name: np.asarray(values[step]) for name, values in node_results(data)} if step is not None else {}
        mesh = meshio.Mesh(points, blocks, point_data=vectors_of(scalars),
                           cell_data={"PartId": [np.full(count, part, np.int64) for part, (_, count) in parts.items()]})
        mesh.part_names = {part: name for part, (name, _) in parts.items() if name}
        return mesh, Numbering(numbers(data, "node_num_map", len(points)), numbers(data, "elem_num_map", first)[rows])


def numbers(data, name, count):
    """Numbers of nodes or elements; without them 1, 2, .."""
    for known in (name, name.replace("_num", "")):
        if known in data.variables and data.variables[known].shape == (count,):
            return np.asarray(data.variables[known][:], np.int64)
    return np.arange(1, count + 1)


def node_results(data):
    for k, name in enumerate(names(data, "name_nod_var")):
        variable = f"vals_nod_var{k + 1}"
        if variable in data.variables:
            yield name, data.variables[variable]
        elif "vals_nod_var" in data.variables:  # the older layout: [step, variable, node]
            yield name, data.variables["vals_nod_var"][:, k]
