"""Files of other programs, read through meshio."""

import contextlib
import io
import os
import re
import tempfile

import meshio

from .errors import BadInput

# meshio's name: VTK's number, number of nodes, dimension.
CELLS = {"triangle": (5, 3, 2), "quad": (9, 4, 2), "tetra": (10, 4, 3), "hexahedron": (12, 8, 3), "wedge": (13, 6, 3),
         "pyramid": (14, 5, 3)}
NODES = {number: nodes for number, nodes, _ in CELLS.values()}
LEFT_OUT = re.compile(r"vertex|line\d*|VTK_LAGRANGE_CURVE")
# Elements of higher order are named by the number of nodes, or by VTK; their corners come first.
HIGHER = re.compile(r"(triangle|quad|tetra|hexahedron|wedge|pyramid)(\d+)|VTK_LAGRANGE_(TRIANGLE|QUADRILATERAL|TETRAHEDRON|"
                    r"HEXAHEDRON|WEDGE|PYRAMID)")
LAGRANGE = {"QUADRILATERAL": "quad", "TETRAHEDRON": "tetra"}


def linear_type(name):
    """The type of the element with the corners of a named one: tetra for tetra10 and for tetra; None for others."""
    match = HIGHER.fullmatch(name)
    if match is None:
        return name if name in CELLS else None
    return match.group(1) or LAGRANGE.get(match.group(3), match.group(3).lower())

# Names of arrays of objects, in lower case; earlier names are preferred.
OBJECT_IDS = ("partid", "part_id", "part", "gmsh:physical", "nastran:ref", "obj:group_ids")
# File name extension: meshio's name of the format.
FORMATS = {".vtu": "vtu", ".vtk": "vtk", ".msh": "gmsh", ".ply": "ply", ".obj": "obj", ".bdf": "nastran", ".fem": "nastran",
           ".nas": "nastran"}
VTK_51_TYPES = {b"vtkIdType": b"vtktypeint32", b"int": b"vtktypeint32", b"unsigned_int": b"vtktypeuint32",
                b"char": b"vtktypeint8", b"unsigned_char": b"vtktypeuint8", b"short": b"vtktypeint16",
                b"unsigned_short": b"vtktypeuint16"}


def patched(file, extension):
    """The text of the file with changes that meshio needs to read it, or None if it needs none."""
    if extension == ".vtk":
        with open(file, "rb") as stream:
            data = stream.read()
        # VTK stores ids as int under a type name that meshio does not know. In files of version 5.1, meshio takes int
        # for 64 bits.
        names = VTK_51_TYPES if data.startswith(b"# vtk DataFile Version 5") else {b"vtkIdType": b"int"}
        result = re.sub(rb"(?m)^(\S+ \d+ \d+|SCALARS \S+) (%s)(?=[ \d\r]*$)" % b"|".join(names),
                        lambda match: match.group(1) + b" " + names[match.group(2)], data)
        return result if result != data else None
    if FORMATS[extension] == "nastran":
        with open(file, "rb") as stream:
            data = stream.read()
        # Gmsh writes the bulk data section without the line that begins it.
        return None if re.search(rb"(?m)^\s*BEGIN\s+BULK", data) else b"BEGIN BULK\n" + data
    return None


def meshio_read(file):
    """The mesh as meshio reads it. Messages on the console, ends of the process and cells that meshio leaves out
    become errors."""
    extension = os.path.splitext(file)[1].lower()
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
    except BadInput:
        raise
    except (Exception, SystemExit) as problem:  # pylint: disable=broad-except  # a parser throws anything at a bad file
        text = " ".join(said.getvalue().split()).replace(source, file)
        if not isinstance(problem, SystemExit):
            text += f" {type(problem).__name__}: {problem}"
        raise BadInput(file, "", f"meshio cannot read it as {FORMATS[extension]}: {text.strip()}") from problem
    text = " ".join(said.getvalue().split())
    if "cannot handle" in text:
        raise BadInput(file, "cells", text)
    return mesh, text


def is_in_pieces(file):
    """Whether a .vtu has several pieces; meshio drops cells of these."""
    with open(file, "rb") as stream:
        return len(re.findall(rb"<Piece\b", stream.read())) > 1
