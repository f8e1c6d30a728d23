"""Arrays of a mesh that become a frame's points, ids, objects, velocities, thickness and time."""

import contextlib
import re

import numpy as np

from .errors import BadInput, did_you_mean, first_bad
from .formats import CELLS, OBJECT_IDS, linear_type

# Names that arrays may have, in lower case; earlier names are preferred.
POINT_IDS = ("globalpointids", "globalnodeids", "globalnodeid", "node_id", "nodeid", "pointids")
CELL_IDS = ("globalcellids", "globalelementids", "globalelementid", "element_id", "elementid", "cellids")
VELOCITIES = ("velocity", "velocities", "vel")
THICKNESSES = ("thickness",)
DISPLACEMENTS = re.compile(r".*displac.*|(displ?|depl|u)(_?[xyz123])?")
TIMES = ("timevalue", "time")


def pick(arrays, wanted, guesses, file, what):
    """The array named `wanted`; if no name is given, the first array whose name is among the guesses, or None."""
    if wanted == "none":
        return None
    if wanted:
        if wanted not in arrays:
            raise BadInput(file, what, f"no array '{wanted}'; there is: {', '.join(sorted(arrays)) or 'none'}"
                           + did_you_mean(wanted, arrays))
        return arrays[wanted]
    by_lower = {name.lower(): name for name in arrays}
    return next((arrays[by_lower[guess]] for guess in guesses if guess in by_lower), None)


def integers(values, file, what, kind):
    """The values as integers of type `kind`; an error if they are not integers in its range."""
    values = np.asarray(values).reshape(-1)
    bounds = np.iinfo(kind)
    if not np.issubdtype(values.dtype, np.number):
        raise BadInput(file, what, "not numbers")
    with np.errstate(invalid="ignore"):
        bad = ~((values >= bounds.min) & (values <= bounds.max) & (values == np.floor(values)))
    if bad.any():
        raise BadInput(file, what, f"{values[first_bad(bad)]} is not an integer of {bounds.bits} bits", first_bad(bad))
    return values.astype(kind)


def check_ids(ids, count, file, what):
    if len(ids) != count:
        raise BadInput(file, what, f"{len(ids)} ids for {count}")
    negative = first_bad(ids < 0)
    if negative is not None:
        raise BadInput(file, what, f"{ids[negative]} is negative", negative)
    order = np.argsort(ids, kind="stable")
    again = np.flatnonzero(np.diff(ids[order]) == 0)
    if len(again):
        raise BadInput(file, what, f"{ids[order[again[0]]]} is there twice", int(order[again[0] + 1]))
    return ids


def finite(values, file, what):
    bad = first_bad(~np.isfinite(values))
    if bad is not None:
        raise BadInput(file, what, "not a finite number", bad)
    return values


def vectors(mesh, wanted, guesses, file, what):
    """A vector for each point [points, 3], or None. "vx,vy,vz" names three arrays."""
    names = wanted.split(",") if wanted else []
    if len(names) == 3:
        columns = [np.asarray(pick(mesh.point_data, name, (), file, what)).reshape(-1) for name in names]
        values = np.column_stack(columns)
    else:
        values = pick(mesh.point_data, wanted, guesses, file, what)
    if values is None:
        return None
    values = np.asarray(values, np.float64)
    if values.shape == (len(mesh.points), 2):  # of plane meshes
        values = np.column_stack([values, np.zeros(len(values))])
    if values.shape != (len(mesh.points), 3):
        raise BadInput(file, what, f"shape {values.shape} instead of ({len(mesh.points)}, 3)")
    return finite(values, file, what)


def displacements(mesh, options, source):
    """The displacements to be added to the points, and their name; or None. Without the option, arrays that may be
    displacements are an error, because files do not say whether their points are displaced already, except for formats
    whose points are always those before deformation."""
    file = source.name
    if options.displacement:
        return vectors(mesh, options.displacement, (), file, "displacement"), options.displacement
    used = (options.velocity or "").split(",")
    names = [name for name in mesh.point_data if DISPLACEMENTS.fullmatch(name.lower()) and name not in used]
    if len(names) == 1 and source.undeformed:
        return vectors(mesh, names[0], (), file, "displacement"), names[0]
    if names:
        raise BadInput(file, "displacement", f"the points have {', '.join(map(repr, names))}: give --displacement "
                       f"{names[0] if len(names) == 1 else 'NAME'} to add it to the points, or --displacement none if they are "
                       "displaced already")
    return None, ""


def points_of(mesh, file):
    points = np.asarray(mesh.points, np.float64)
    if points.ndim != 2 or points.shape[1] < 2 or len(points) == 0:
        raise BadInput(file, "points", "none" if len(points) == 0 else f"shape {points.shape}")
    if points.shape[1] == 2:
        points = np.column_stack([points, np.zeros(len(points))])
    # In .obj files, a weight or a colour may follow the coordinates.
    return np.ascontiguousarray(finite(points[:, :3], file, "points"))


def cell_arrays(mesh):
    """Arrays with a value for every cell, in the order of the blocks."""
    sizes = [len(block.data) for block in mesh.cells]
    return {name: np.concatenate([np.asarray(values) for values in blocks]) for name, blocks in mesh.cell_data.items()
            if [len(values) for values in blocks] == sizes and sizes}


def ids_of(frame, mesh, arrays, numbering, rows, keep, options, file):
    """Sets the ids of points and cells, if the source has them."""
    ids = pick(mesh.point_data, options.point_ids, POINT_IDS, file, "point ids")
    if ids is None and numbering is not None and options.point_ids != "none":
        ids = numbering.nodes[rows]
    if ids is not None:
        frame.point_ids = check_ids(integers(ids, file, "point ids", np.int64), len(frame.points), file, "point ids")
    ids = pick(arrays, options.cell_ids, CELL_IDS, file, "cell ids")
    if ids is None and numbering is not None and options.cell_ids != "none":
        ids = numbering.elements
    if ids is not None:
        frame.cell_ids = check_ids(integers(ids, file, "cell ids", np.int64)[keep], len(frame.types), file, "cell ids")


def objects_from_sets(sets, chosen, ids, file):
    """The object of each element: the number of its set, counted from 1 in the order of `chosen` or of the file, or 0."""
    if chosen:
        for name in chosen:
            if name not in sets:
                raise BadInput(file, "sets", f"no set '{name}'; there is: {', '.join(sets) or 'none'}" + did_you_mean(name, sets))
        sets = {name: sets[name] for name in chosen}
    here, objects, names = {int(element): i for i, element in enumerate(ids)}, np.zeros(len(ids), np.int32), {}
    seen = {}
    for name, members in sets.items():
        rows = sorted({here[element] for element in members if element in here})
        # Two sets have the same elements. The name of the later one is used, because it is that of the user's group.
        if rows and tuple(rows) in seen:
            names[seen[tuple(rows)]] = name
            continue
        if not rows:
            continue
        number = len(names) + 1
        taken = [row for row in rows if objects[row]]
        if taken:
            raise BadInput(file, "sets", f"element {ids[taken[0]]} is in '{names[objects[taken[0]]]}' and in '{name}': "
                           "choose with --sets, or --part none")
        objects[rows], names[number], seen[tuple(rows)] = number, name, number
    return objects, names


def objects_of(mesh, arrays, numbering, keep, options, file):
    """The object of each kept cell, and the names of the objects."""
    if options.part == "none":
        return np.zeros(int(keep.sum()), np.int32), {}
    values = None if options.sets else pick(arrays, options.part, OBJECT_IDS, file, "object")
    if values is None:
        sets = {} if numbering is None else (not options.sets and numbering.parts) or numbering.sets
        if not sets:
            if options.sets:
                raise BadInput(file, "sets", "the file has no element sets")
            return np.zeros(int(keep.sum()), np.int32), {}
        return objects_from_sets(sets, options.sets, numbering.elements[keep], file)
    objects = integers(values, file, "object", np.int32)[keep]
    if not options.part and "obj:group_ids" in arrays and values is arrays["obj:group_ids"]:
        objects = objects + 1  # meshio counts groups from 0, and -1 means that the cell has no group
    names = dict(getattr(mesh, "part_names", {}))
    if values is arrays.get("gmsh:physical"):
        dimensions = {CELLS[linear_type(block.type)][2] for block in mesh.cells if linear_type(block.type)}
        names = {int(number): name for name, (number, dimension) in mesh.field_data.items() if dimension in dimensions}
    present = set(objects.tolist())
    return objects, {number: name for number, name in names.items() if number in present}


def thickness_of(arrays, keep, types, wanted, file):
    with contextlib.suppress(TypeError, ValueError):
        value = float(wanted)
        return np.where(types < 10, value, 0.0)
    values = pick(arrays, wanted, THICKNESSES, file, "thickness")
    if values is None:
        return None
    values = finite(np.asarray(values, np.float64).reshape(len(keep), -1)[keep], file, "thickness")
    if values.shape[1] != 1:
        raise BadInput(file, "thickness", f"{values.shape[1]} numbers a cell instead of one")
    if first_bad(values < 0) is not None:
        raise BadInput(file, "thickness", "negative", first_bad(values < 0))
    return values[:, 0]


def time_of(mesh, file):
    value = pick(dict(mesh.field_data or {}), None, TIMES, file, "time")
    value = np.asarray(value, np.float64).reshape(-1) if value is not None else []
    return float(value[0]) if len(value) == 1 and np.isfinite(value[0]) else None
