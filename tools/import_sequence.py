#!/usr/bin/env python3
"""Turns mesh files of other programs into one sequence file that `volccd` reads.

Input: .vtu, .vtk (legacy), .msh (Gmsh), .ply, .obj, .inp (Abaqus), .bdf/.fem/.nas (Nastran), read through meshio. Each file
is one step. Output: VTKHDF, the layout that docs/sequence_files.md describes.

What is kept where the source has it:
  point ids    array GlobalPointIds, NODE_ID, ..; node numbers of Gmsh (text), Abaqus and Nastran
  cell ids     array GlobalCellIds, ElementId, ELEMENT_ID, ..; element numbers of Gmsh (text), Abaqus and Nastran
  parts        array PartId, PART_ID, ..; Gmsh physical groups, Nastran property ids, groups of .obj, element sets of Abaqus
               (numbered from 1 in the order of the file)
  velocities   array Velocity, ..; as point vectors
  thickness    array Thickness, ..; per cell
With point ids, files may list points in different orders, and points may come and go: where a point is missing, it is
written at the place it had last (or gets first), and no cell uses it. With cell ids, cells may come and go. Without ids, all
files must have the same points and cells.

Cells whose nodes repeat (a wedge as a hexahedron, a triangle as a quad) are written as they are: volccd reads them as the
elements that they stand for. Those with too few distinct nodes for any are refused.

Lines and single vertices are left out; so are triangles and quads that are faces of volume cells (--keep-faces keeps them).
Higher-order cells, polygons and polyhedra are refused.

Examples:
  import_sequence.py block.msh -o block.vtkhdf                        one step
  import_sequence.py run_*.vtu -o run.vtkhdf --sort natural           run_2 before run_10, times from the files, else 0, 1, ..
  import_sequence.py run_*.vtk -o run.vtkhdf --sort natural --dt 1e-6 --units m --time-unit second
  import_sequence.py a.inp b.inp -o run.vtkhdf --times 0,0.5 --sets Bolt,Plate
  import_sequence.py cloth_*.ply -o cloth.vtkhdf --sort natural --velocity vx,vy,vz --thickness 0.001

Needs python3-meshio and python3-h5py. Exit code: 0 written, 2 bad input or usage; then nothing is left behind.
"""

import argparse
import contextlib
import dataclasses
import io
import itertools
import os
import re
import sys
import tempfile

try:
    import h5py
    import meshio
    import numpy as np
except ImportError as problem:
    sys.exit(f"import_sequence.py: {problem}; install python3-meshio and python3-h5py")

# meshio's name -> VTK's number, nodes, dimension.
CELLS = {"triangle": (5, 3, 2), "quad": (9, 4, 2), "tetra": (10, 4, 3), "hexahedron": (12, 8, 3), "wedge": (13, 6, 3),
         "pyramid": (14, 5, 3)}
NODES = {number: nodes for number, nodes, _ in CELLS.values()}
LEFT_OUT = re.compile(r"vertex|line\d*|VTK_LAGRANGE_CURVE")
FACES = {10: [(0, 1, 2), (0, 1, 3), (1, 2, 3), (0, 2, 3)],
         12: [(0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)],
         13: [(0, 1, 2), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)],
         14: [(0, 1, 2, 3), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)]}

# By extension: meshio's name.
FORMATS = {".vtu": "vtu", ".vtk": "vtk", ".msh": "gmsh", ".ply": "ply", ".obj": "obj", ".inp": "abaqus", ".bdf": "nastran",
           ".fem": "nastran", ".nas": "nastran"}

VTK_51_TYPES = {b"vtkIdType": b"vtktypeint32", b"int": b"vtktypeint32", b"unsigned_int": b"vtktypeuint32",
                b"char": b"vtktypeint8", b"unsigned_char": b"vtktypeuint8", b"short": b"vtktypeint16",
                b"unsigned_short": b"vtktypeuint16"}

# Guesses, in lower case, best first.
POINT_IDS = ("globalpointids", "globalnodeids", "globalnodeid", "node_id", "nodeid", "pointids")
CELL_IDS = ("globalcellids", "globalelementids", "globalelementid", "element_id", "elementid", "cellids")
PARTS = ("partid", "part_id", "part", "gmsh:physical", "nastran:ref", "obj:group_ids")
VELOCITIES = ("velocity", "velocities", "vel")
THICKNESSES = ("thickness",)
TIMES = ("timevalue", "time")


class BadInput(Exception):
    """`file: what[index]: problem`, as the program words it."""

    def __init__(self, file, what, problem, index=None):
        place = what + (f"[{index}]" if index is not None else "")
        super().__init__(": ".join(part for part in (file, place, problem) if part))


@dataclasses.dataclass
class Step:
    """A file, checked; cells in CSR form. Without ids in the source, `point_ids` and `cell_ids` are None."""

    points: np.ndarray
    types: np.ndarray
    offsets: np.ndarray
    connectivity: np.ndarray
    parts: np.ndarray
    point_ids: np.ndarray = None
    cell_ids: np.ndarray = None
    velocity: np.ndarray = None
    thickness: np.ndarray = None
    time: float = None
    part_names: dict = dataclasses.field(default_factory=dict)
    notes: list = dataclasses.field(default_factory=list)


@dataclasses.dataclass
class Numbering:
    """Node and element numbers that meshio drops: [points]; by element in the order of the file; sets of elements."""

    nodes: np.ndarray
    elements: np.ndarray
    sets: dict = dataclasses.field(default_factory=dict)


# ---------------------------------------------------------------------------------------------- reading


def first_bad(bad):
    """Index of the first row that has a True in it, or None."""
    rows = np.flatnonzero(bad.reshape(len(bad), -1).any(axis=1)) if bad.size else []
    return int(rows[0]) if len(rows) else None


def patched(file, extension):
    """Text in place of the file's where meshio stumbles over what other programs write, or None."""
    if extension == ".vtk":
        with open(file, "rb") as stream:
            data = stream.read()
        # VTK stores its ids as int, under a name that meshio does not know; in version 5.1 it takes int for 64 bits.
        names = VTK_51_TYPES if data.startswith(b"# vtk DataFile Version 5") else {b"vtkIdType": b"int"}
        result = re.sub(rb"(?m)^(\S+ \d+ \d+|SCALARS \S+) (%s)(?=[ \d\r]*$)" % b"|".join(names),
                        lambda match: match.group(1) + b" " + names[match.group(2)], data)
        return result if result != data else None
    if FORMATS[extension] == "nastran":
        with open(file, "rb") as stream:
            data = stream.read()
        # Gmsh writes the bulk data alone.
        return None if re.search(rb"(?m)^\s*BEGIN\s+BULK", data) else b"BEGIN BULK\n" + data
    return None


def meshio_read(file):
    """meshio's mesh. It reports on the console, ends the process, and leaves out what it does not know: all caught."""
    extension = os.path.splitext(file)[1].lower()
    if extension not in FORMATS:
        raise BadInput(file, "", f"unknown extension '{extension}'; known: {' '.join(FORMATS)}")
    if not os.path.isfile(file):
        raise BadInput(file, "", "no such file")
    said = io.StringIO()
    try:
        with contextlib.ExitStack() as stack:
            source = file
            text = patched(file, extension)
            if text is not None:
                copy = stack.enter_context(tempfile.NamedTemporaryFile(suffix=extension))
                copy.write(text)
                copy.flush()
                source = copy.name
            stack.enter_context(contextlib.redirect_stdout(said))
            stack.enter_context(contextlib.redirect_stderr(said))
            mesh = meshio.read(source, FORMATS[extension])
    except (Exception, SystemExit) as problem:  # pylint: disable=broad-except  # a parser throws anything at a bad file
        text = " ".join(said.getvalue().split()).replace(source, file)
        if not isinstance(problem, SystemExit):
            text += f" {type(problem).__name__}: {problem}"
        raise BadInput(file, "", f"meshio cannot read it as {FORMATS[extension]}: {text.strip()}") from problem
    text = " ".join(said.getvalue().split())
    if "cannot handle" in text:
        raise BadInput(file, "cells", text)
    if extension == ".vtu":
        with open(file, "rb") as stream:
            if len(re.findall(rb"<Piece\b", stream.read())) > 1:
                raise BadInput(file, "Piece", "several pieces in one file: meshio drops cells; merge them first")
    return mesh, text


def gmsh_numbering(file):
    """None for binary files and versions without a scanner."""
    with open(file, "rb") as stream:
        data = stream.read()
    header = re.match(rb"\s*\$MeshFormat\s+([\d.]+)\s+(\d)", data)
    if not header or header.group(2) != b"0" or header.group(1) not in (b"2", b"2.1", b"2.2", b"4.1"):
        return None
    section = {}
    for name in (b"Nodes", b"Elements"):
        body = re.search(rb"\$%s\s(.*?)\$End%s" % (name, name), data, re.DOTALL)
        section[name] = [line.split() for line in body.group(1).splitlines() if line.strip()] if body else [[]]
    nodes, elements = [], []
    if header.group(1) != b"4.1":
        nodes = [line[0] for line in section[b"Nodes"][1:]]
        elements = [line[0] for line in section[b"Elements"][1:]]
    else:
        for name, numbers, rows in ((b"Nodes", nodes, 2), (b"Elements", elements, 1)):
            lines, at = section[name], 1
            while at < len(lines):
                count = int(lines[at][3])
                numbers += [line[0] for line in lines[at + 1:at + 1 + count]]
                at += 1 + count * rows
    return Numbering(np.array(nodes, np.int64), np.array(elements, np.int64))


def abaqus_numbering(file):
    """Node numbers, element numbers, element sets by name; None where another file is included."""
    nodes, elements, sets = [], [], {}
    numbers = row = None  # where data lines go; how many numbers a row has
    generate = False
    with open(file, encoding="utf-8", errors="replace") as stream:
        for line in stream:
            line = line.strip()
            if line.startswith("**") or not line:
                continue
            if line.startswith("*"):
                keyword = line[1:].split(",")[0].strip().upper()
                values = dict(re.findall(r"(\w+)\s*=\s*([^,]+)", line))
                values = {key.upper(): value.strip() for key, value in values.items()}
                numbers, generate = None, bool(re.search(r",\s*GENERATE", line, re.IGNORECASE))
                if keyword == "INCLUDE":
                    return None
                if keyword == "NODE":
                    numbers, row = nodes, "first"
                elif keyword == "ELEMENT":
                    numbers, row, pending = elements, "element", []
                    kind = meshio.abaqus._abaqus.abaqus_to_meshio_type.get(values.get("TYPE", ""), "")
                    width = 1 + meshio._mesh.num_nodes_per_cell.get(kind, 0)
                    members = sets.setdefault(values["ELSET"], []) if "ELSET" in values else None
                elif keyword == "ELSET" and "ELSET" in values:
                    numbers, row = sets.setdefault(values["ELSET"], []), "set"
                continue
            if numbers is None:
                continue
            fields = [field.strip() for field in line.split(",") if field.strip()]
            if row == "first":
                numbers.append(int(fields[0]))
            elif row == "element":
                # An element may go over several lines.
                pending += fields
                while width > 1 and len(pending) >= width:
                    numbers.append(int(pending[0]))
                    if members is not None:
                        members.append(int(pending[0]))
                    pending = pending[width:]
            elif generate:
                first, last, stride = (int(field) for field in (fields + ["1"])[:3])
                numbers += range(first, last + 1, stride)
            else:
                numbers += itertools.chain.from_iterable(
                    [int(field)] if field.lstrip("-").isdigit() else sets.get(field, []) for field in fields)
    return Numbering(np.array(nodes, np.int64), np.array(elements, np.int64), sets)


def numbering_of(file, mesh):
    """Numbers of the nodes and elements in the file, in meshio's order, or None."""
    format_name = FORMATS[os.path.splitext(file)[1].lower()]
    numbering = None
    try:
        if format_name == "gmsh":
            numbering = gmsh_numbering(file)
        elif format_name == "abaqus":
            numbering = abaqus_numbering(file)
        elif format_name == "nastran":
            numbering = Numbering(np.array(mesh.points_id, np.int64),
                                  np.concatenate([np.asarray(ids, np.int64) for ids in mesh.cells_id] or [[]]))
    except (ValueError, IndexError, AttributeError):
        return None
    if numbering is None:
        return None
    cells = sum(len(block.data) for block in mesh.cells)
    for what, found, read in (("nodes", len(numbering.nodes), len(mesh.points)), ("elements", len(numbering.elements), cells)):
        if found != read:
            raise BadInput(file, what, f"the file has {found}, meshio reads {read}")
    return numbering


def pick(arrays, wanted, guesses, file, what):
    """Array called `wanted`, or the best guess, or None."""
    if wanted == "none":
        return None
    if wanted:
        if wanted not in arrays:
            raise BadInput(file, what, f"no array '{wanted}'; there is: {', '.join(sorted(arrays)) or 'none'}")
        return arrays[wanted]
    by_lower = {name.lower(): name for name in arrays}
    return next((arrays[by_lower[guess]] for guess in guesses if guess in by_lower), None)


def integers(values, file, what, kind):
    """As integers of `kind`, exactly."""
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


def vectors(mesh, wanted, file):
    """Velocities [points, 3], or None. "vx,vy,vz" names three arrays."""
    names = wanted.split(",") if wanted else []
    if len(names) == 3:
        columns = [np.asarray(pick(mesh.point_data, name, (), file, "velocity")).reshape(-1) for name in names]
        values = np.column_stack(columns)
    else:
        values = pick(mesh.point_data, wanted, VELOCITIES, file, "velocity")
    if values is None:
        return None
    values = np.asarray(values, np.float64)
    if values.shape != (len(mesh.points), 3):
        raise BadInput(file, "velocity", f"shape {values.shape} instead of ({len(mesh.points)}, 3)")
    return finite(values, file, "velocity")


def finite(values, file, what):
    bad = first_bad(~np.isfinite(values))
    if bad is not None:
        raise BadInput(file, what, "not a finite number", bad)
    return values


def points_of(mesh, file):
    points = np.asarray(mesh.points, np.float64)
    if points.ndim != 2 or points.shape[1] < 2 or len(points) == 0:
        raise BadInput(file, "points", "none" if len(points) == 0 else f"shape {points.shape}")
    if points.shape[1] == 2:
        points = np.column_stack([points, np.zeros(len(points))])
    # .obj may have a weight or a colour behind the place.
    return np.ascontiguousarray(finite(points[:, :3], file, "points"))


def refuse_unsupported(mesh, file):
    bad = {}
    for block in mesh.cells:
        if block.type not in CELLS and not LEFT_OUT.fullmatch(block.type):
            bad[block.type] = bad.get(block.type, 0) + len(block.data)
    if bad:
        listed = ", ".join(f"{count} {name}" for name, count in bad.items())
        raise BadInput(file, "cells", f"{listed}: not supported; what is: {', '.join(CELLS)}")


def is_face_of_volume(types, offsets, connectivity):
    """For each cell, whether it is a triangle or quad whose vertices are those of a face of a volume cell."""
    if (types >= 10).all():
        return np.zeros(len(types), bool)
    faces = set()
    for kind, members in FACES.items():
        cells = np.flatnonzero(types == kind)
        if len(cells):
            nodes = connectivity[offsets[cells][:, None] + np.arange(NODES[kind])]
            for face in members:
                faces.update(map(tuple, np.sort(nodes[:, face], axis=1)))
    result = np.zeros(len(types), bool)
    if faces:
        for i in np.flatnonzero(types < 10):
            result[i] = tuple(sorted(set(connectivity[offsets[i]:offsets[i + 1]].tolist()))) in faces
    return result


def parts_from_sets(sets, chosen, ids, file):
    """Part of each element id: the number of its set, from 1, in the order of `chosen` or of the file; 0 without one."""
    if chosen:
        for name in chosen:
            if name not in sets:
                raise BadInput(file, "sets", f"no set '{name}'; there is: {', '.join(sets) or 'none'}")
        sets = {name: sets[name] for name in chosen}
    here, parts, names = {int(element): i for i, element in enumerate(ids)}, np.zeros(len(ids), np.int32), {}
    seen = {}
    for name, members in sets.items():
        rows = sorted({here[element] for element in members if element in here})
        # The same elements under a second name: the later name is that of the group that the user made.
        if rows and tuple(rows) in seen:
            names[seen[tuple(rows)]] = name
            continue
        if not rows:
            continue
        number = len(names) + 1
        taken = [row for row in rows if parts[row]]
        if taken:
            raise BadInput(file, "sets", f"element {ids[taken[0]]} is in '{names[parts[taken[0]]]}' and in '{name}': "
                           "choose with --sets, or --part none")
        parts[rows], names[number], seen[tuple(rows)] = number, name, number
    return parts, names


def cell_arrays(mesh):
    """Arrays over all cells, in the order of the blocks."""
    sizes = [len(block.data) for block in mesh.cells]
    return {name: np.concatenate([np.asarray(values) for values in blocks]) for name, blocks in mesh.cell_data.items()
            if [len(values) for values in blocks] == sizes and sizes}


def parts_of(mesh, arrays, numbering, keep, options, file):
    """Part of each kept cell, and names of the parts."""
    if options.part == "none":
        return np.zeros(int(keep.sum()), np.int32), {}
    values = None if options.sets else pick(arrays, options.part, PARTS, file, "part")
    if values is None:
        if numbering is None or not numbering.sets:
            if options.sets:
                raise BadInput(file, "sets", "the file has no element sets")
            return np.zeros(int(keep.sum()), np.int32), {}
        return parts_from_sets(numbering.sets, options.sets, numbering.elements[keep], file)
    parts = integers(values, file, "part", np.int32)[keep]
    if not options.part and "obj:group_ids" in arrays and values is arrays["obj:group_ids"]:
        parts = parts + 1  # meshio counts from 0, and -1 is "no group yet"
    names = {}
    if values is arrays.get("gmsh:physical"):
        dimensions = {CELLS[block.type][2] for block in mesh.cells if block.type in CELLS}
        names = {int(number): name for name, (number, dimension) in mesh.field_data.items() if dimension in dimensions}
    present = set(parts.tolist())
    return parts, {number: name for number, name in names.items() if number in present}


def time_of(mesh, file):
    value = pick(dict(mesh.field_data or {}), None, TIMES, file, "time")
    value = np.asarray(value, np.float64).reshape(-1) if value is not None else []
    return float(value[0]) if len(value) == 1 and np.isfinite(value[0]) else None


def read_step(file, options):
    mesh, said = meshio_read(file)
    refuse_unsupported(mesh, file)
    points, numbering, arrays = points_of(mesh, file), numbering_of(file, mesh), cell_arrays(mesh)
    blocks = [(CELLS.get(block.type, (0, 0, 0))[0], np.asarray(block.data)) for block in mesh.cells if len(block.data)]
    if not any(kind for kind, _ in blocks):
        raise BadInput(file, "cells", "no cells of a supported type: " + ", ".join(CELLS))
    types = np.concatenate([np.full(len(data), kind, np.uint8) for kind, data in blocks])
    keep = types > 0
    connectivity = np.concatenate([data.reshape(-1) for kind, data in blocks if kind]).astype(np.int64)
    offsets = np.concatenate([[0], np.cumsum([NODES[kind] for kind in types[keep]])]).astype(np.int64)
    outside = (connectivity < 0) | (connectivity >= len(points))
    if outside.any():
        at = int(np.searchsorted(offsets, first_bad(outside), "right")) - 1
        raise BadInput(file, "cells", f"uses point {connectivity[first_bad(outside)]} of {len(points)}", at)
    notes = [said] if said else []
    if not options.keep_faces:
        face = is_face_of_volume(types[keep], offsets, connectivity)
        if face.any():
            notes.append(f"{int(face.sum())} triangles and quads that are faces of volume cells are left out")
            connectivity = connectivity[np.repeat(~face, np.diff(offsets))]
            keep[np.flatnonzero(keep)[face]] = False
            offsets = np.concatenate([[0], np.cumsum([NODES[kind] for kind in types[keep]])]).astype(np.int64)
    cells = int(keep.sum())
    parts, names = parts_of(mesh, arrays, numbering, keep, options, file)
    step = Step(points, types[keep], offsets, connectivity, parts, time=time_of(mesh, file), part_names=names, notes=notes)
    ids = pick(mesh.point_data, options.point_ids, POINT_IDS, file, "point ids")
    if ids is None and numbering is not None and options.point_ids != "none":
        ids = numbering.nodes
    if ids is not None:
        step.point_ids = check_ids(integers(ids, file, "point ids", np.int64), len(points), file, "point ids")
    ids = pick(arrays, options.cell_ids, CELL_IDS, file, "cell ids")
    if ids is None and numbering is not None and options.cell_ids != "none":
        ids = numbering.elements
    if ids is not None:
        step.cell_ids = check_ids(integers(ids, file, "cell ids", np.int64)[keep], cells, file, "cell ids")
    step.velocity = vectors(mesh, options.velocity, file) if options.velocity != "none" else None
    step.thickness = thickness_of(arrays, keep, step.types, options.thickness, file)
    check_repeated_vertices(step, file)
    return step


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


def check_repeated_vertices(step, file):
    """Refuses cells with too few distinct vertices for an element; notes how many others have a vertex twice."""
    repeated = 0
    for kind, nodes in NODES.items():
        cells = np.flatnonzero(step.types == kind)
        members = np.sort(step.connectivity[step.offsets[cells][:, None] + np.arange(nodes)], axis=1)
        distinct = 1 + (np.diff(members, axis=1) != 0).sum(axis=1)
        least = 3 if kind < 10 else 4
        bad = first_bad(distinct < least)
        if bad is not None:
            cell = int(cells[bad])
            name = "" if step.cell_ids is None else f" (cell id {step.cell_ids[cell]})"
            raise BadInput(file, "cells", f"has {distinct[bad]} distinct vertices, an element has at least {least}{name}", cell)
        repeated += int((distinct < nodes).sum())
    if repeated:
        step.notes.append(f"{repeated} cells have a vertex more than once, and stand for elements with fewer")


# ---------------------------------------------------------------------------------------------- putting together


def natural_key(file):
    return [int(part) if part.isdigit() else part for part in re.split(r"(\d+)", file)]


def order_files(files, how):
    natural = sorted(files, key=natural_key)
    if how == "natural":
        return natural
    if how is None and files != natural:
        first = next(i for i, (given, sorted_) in enumerate(zip(files, natural)) if given != sorted_)
        raise BadInput("", "files", f"{files[first]} comes before {natural[first]}, but the numbers in the names say otherwise: "
                       "give --sort natural, or --sort given", first)
    return files


class Union:
    """All points that any file has: those of the first file in its order, then the others as they come."""

    def __init__(self):
        self.ids = self.order = self.places = None

    def add(self, step, file):
        if self.places is None:
            self.ids, self.places = step.point_ids, step.points
        elif (step.point_ids is None) != (self.ids is None):
            raise BadInput(file, "point ids", "given here but not in the first file" if self.ids is None else
                           "not given here but in the first file")
        elif self.ids is None:
            if len(step.points) != len(self.places):
                raise BadInput(file, "points", f"{len(step.points)}, the first file has {len(self.places)}, and there are no "
                               "point ids")
        else:
            new = ~np.isin(step.point_ids, self.ids)
            self.ids = np.concatenate([self.ids, step.point_ids[new]])
            self.places = np.concatenate([self.places, step.points[new]])
        self.order = None if self.ids is None else np.argsort(self.ids)

    def renumber(self, step):
        """Puts the points of a step into this order; those that it lacks stay where they were, with no velocity."""
        if self.ids is None:
            return step
        row = self.order[np.searchsorted(self.ids, step.point_ids, sorter=self.order)]
        self.places = self.places.copy()
        self.places[row] = step.points
        if step.velocity is not None:
            velocity = np.zeros_like(self.places)
            velocity[row] = step.velocity
            step.velocity = velocity
        step.points, step.connectivity = self.places, row[step.connectivity]
        return step


def check_same(step, first, file):
    """What every step has to have alike."""
    for what in ("velocity", "thickness", "cell_ids"):
        if (getattr(step, what) is None) != (getattr(first, what) is None):
            there = "not in this file" if getattr(step, what) is None else "not in the first file"
            raise BadInput(file, what.replace("_", " "), f"{there}, but in others")
    if step.cell_ids is None and not same_cells(step, first):
        raise BadInput(file, "cells", "differ from those of the first file, and there are no cell ids")
    for number, name in step.part_names.items():
        if first.part_names.setdefault(number, name) != name:
            raise BadInput(file, "part", f"{number} is '{name}' here and '{first.part_names[number]}' before")


def same_cells(a, b):
    return all(np.array_equal(getattr(a, name), getattr(b, name)) for name in ("types", "connectivity", "parts", "cell_ids"))


def times_of(files, options, found):
    """Times of the steps: given, else the files' own, else 0, 1, .."""
    if options.times is not None:
        times = options.times
        if len(times) != len(files):
            raise BadInput("", "--times", f"{len(times)} times for {len(files)} files")
    elif options.dt is not None:
        times = [options.dt * k for k in range(len(files))]
    else:
        times = list(found) if None not in found else [float(k) for k in range(len(files))]
    for k in range(len(times)):
        if not np.isfinite(times[k]) or (k > 0 and not times[k] > times[k - 1]):
            raise BadInput(files[k], "time", f"{times[k]} is not finite or not after that of the file before: give --times or "
                           "--dt", k)
    return times


# ---------------------------------------------------------------------------------------------- writing


class Writer:
    """The layout of docs/sequence_files.md, a step at a time."""

    def __init__(self, file):
        self.file = file
        self.root = file.create_group("VTKHDF")
        for name in ("PointData", "CellData", "Steps", "Steps/PointDataOffsets", "Steps/CellDataOffsets"):
            self.root.create_group(name)
        self.last = None
        self.cells, self.connectivity, self.tables = [], [], {}

    def append(self, name, values):
        """Rows at the end of a dataset, which is made with the first; the number of rows before."""
        values = np.ascontiguousarray(values)
        if name not in self.root:
            rows = max(16, min(len(values), 16384))
            self.root.create_dataset(name, data=values, maxshape=(None, *values.shape[1:]), chunks=(rows, *values.shape[1:]),
                                     shuffle=True, compression="gzip", compression_opts=4)
            return 0
        dataset = self.root[name]
        before = len(dataset)
        dataset.resize(before + len(values), axis=0)
        dataset[before:] = values
        return before

    def table(self, name, value):
        self.tables.setdefault(name, []).append(value)

    def add(self, step):
        if self.last is None or not same_cells(step, self.last):
            self.first_cell = self.append("Types", step.types)
            self.append("Offsets", step.offsets)
            self.first_connectivity = self.append("Connectivity", step.connectivity)
            self.append("CellData/PartId", step.parts)
            ids = step.cell_ids if step.cell_ids is not None else np.arange(len(step.types), dtype=np.int64)
            self.append("CellData/GlobalCellIds", ids)
            self.cells.append(len(step.types))
            self.connectivity.append(len(step.connectivity))
            self.last = step
        self.table("PartOffsets", len(self.cells) - 1)
        self.table("NumberOfParts", 1)
        self.table("PointOffsets", self.append("Points", step.points))
        self.table("CellOffsets", self.first_cell)
        self.table("ConnectivityIdOffsets", self.first_connectivity)
        self.table("PointDataOffsets/GlobalPointIds", 0)
        self.table("CellDataOffsets/PartId", self.first_cell)
        self.table("CellDataOffsets/GlobalCellIds", self.first_cell)
        if step.velocity is not None:
            self.table("PointDataOffsets/Velocity", self.append("PointData/Velocity", step.velocity))
        if step.thickness is not None:
            self.table("CellDataOffsets/Thickness", self.append("CellData/Thickness", step.thickness))

    def finish(self, times, point_ids, points, about):
        self.root.attrs["Version"] = np.array([2, 2], np.int64)
        self.root.attrs["Type"] = np.bytes_(b"UnstructuredGrid")
        self.root["NumberOfPoints"] = np.full(len(self.cells), points, np.int64)
        self.root["NumberOfCells"] = np.array(self.cells, np.int64)
        self.root["NumberOfConnectivityIds"] = np.array(self.connectivity, np.int64)
        ids = point_ids if point_ids is not None else np.arange(points, dtype=np.int64)
        self.root["PointData/GlobalPointIds"] = np.asarray(ids, np.int64)
        self.root["Steps"].attrs["NSteps"] = np.int64(len(times))
        self.root["Steps/Values"] = np.array(times, np.float64)
        for name, values in self.tables.items():
            values = np.array(values, np.int64)
            self.root[f"Steps/{name}"] = values[:, None] if name in ("CellOffsets", "ConnectivityIdOffsets") else values
        for name, text in about.items():
            if text:
                self.file.attrs[name] = np.bytes_(text.encode("ascii", "replace"))


def about_of(options, first, files):
    names = "; ".join(f"{number} {name.replace(';', ',')}" for number, name in sorted(first.part_names.items()))
    source = os.path.basename(files[0]) + (f" .. {os.path.basename(files[-1])}" if len(files) > 1 else "")
    return {"Title": options.title, "Source": options.source or source, "License": options.license, "Units": options.units,
            "TimeUnit": options.time_unit, "Parts": names}


def import_files(files, options, output):
    union, found = Union(), []
    # Files are read twice rather than kept: a run may be larger than memory.
    first = None
    for file in files:
        step = read_step(file, options)
        union.add(step, file)
        found.append(step.time)
        first = first or step
    times = times_of(files, options, found)
    writer, notes, shapes = Writer(output), [], []
    for file in files:
        step = union.renumber(read_step(file, options) if len(files) > 1 else first)
        first = step if not shapes else first
        check_same(step, first, file)
        writer.add(step)
        shapes.append(len(step.types))
        notes += [f"{file}: {note}" for note in step.notes if not notes]
    writer.finish(times, union.ids, len(union.places), about_of(options, first, files))
    given = ", ".join(f"{name} {'kept' if there else 'made up'}" for name, there in (
        ("point ids", union.ids is not None), ("cell ids", first.cell_ids is not None)))
    return notes, f"{len(files)} steps, {len(union.places)} points, {shapes[0]} cells at first, {shapes[-1]} at last; {given}"


def parse_arguments(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+", metavar="FILE", help="one a step")
    parser.add_argument("-o", "--output", required=True, metavar="FILE", help="sequence to write (VTKHDF)")
    parser.add_argument("--sort", choices=("given", "natural"), help="order of the files; default: as given, refused if the "
                        "numbers in the names say otherwise")
    when = parser.add_mutually_exclusive_group()
    when.add_argument("--times", type=lambda text: [float(word) for word in text.split(",")], metavar="T0,T1,..",
                      help="times of the steps")
    when.add_argument("--dt", type=float, help="time from step to step")
    for name, text in (("point-ids", "point array of ids"), ("cell-ids", "cell array of ids"), ("part", "cell array of parts"),
                       ("velocity", "point array of velocities, or three: vx,vy,vz"),
                       ("thickness", "cell array of shell thickness, or a number for all shells")):
        parser.add_argument(f"--{name}", metavar="NAME", help=f"{text}; 'none': not used; default: by its usual names")
    parser.add_argument("--sets", type=lambda text: text.split(","), metavar="A,B,..",
                        help="element sets that are the parts 1, 2, .. (Abaqus)")
    parser.add_argument("--keep-faces", action="store_true", help="keep triangles and quads that are faces of volume cells")
    for name in ("title", "source", "license", "units", "time-unit"):
        parser.add_argument(f"--{name}", default="", metavar="TEXT", help="attribute of the sequence")
    return parser.parse_args(arguments)


def main(arguments):
    options = parse_arguments(arguments)
    folder, name = os.path.split(os.path.abspath(options.output))
    temporary = os.path.join(folder, f".{name}.{os.getpid()}.tmp")
    try:
        files = order_files(options.files, options.sort)
        with h5py.File(temporary, "w") as output:
            notes, summary = import_files(files, options, output)
        os.replace(temporary, options.output)
    except (BadInput, OSError, MemoryError) as problem:
        print(f"import_sequence.py: {problem}", file=sys.stderr)
        return 2
    finally:
        with contextlib.suppress(FileNotFoundError):
            os.remove(temporary)
    for note in notes:
        print(f"import_sequence.py: {note}", file=sys.stderr)
    print(f"{options.output}: {summary}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
