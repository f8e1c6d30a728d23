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
# File name extension: meshio's name of the format.
FORMATS = {".vtu": "vtu", ".vtk": "vtk", ".msh": "gmsh", ".ply": "ply", ".obj": "obj", ".inp": "abaqus", ".bdf": "nastran",
           ".fem": "nastran", ".nas": "nastran"}
VTK_51_TYPES = {b"vtkIdType": b"vtktypeint32", b"int": b"vtktypeint32", b"unsigned_int": b"vtktypeuint32",
                b"char": b"vtktypeint8", b"unsigned_char": b"vtktypeuint8", b"short": b"vtktypeint16",
                b"unsigned_short": b"vtktypeuint16"}


# Keywords of Abaqus that make or move nodes and elements, and that meshio ignores.
ABAQUS_UNREAD = {"SYSTEM", "NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY"}


def abaqus_keyword(line):
    """NODE for *Node, NSET=..; "" for a line of data."""
    return line[1:].split(",")[0].strip().upper() if line.startswith("*") else ""


def abaqus_lines(file, parents=()):
    """The lines of an Abaqus deck without comments and blank lines, with those of the files that it includes."""
    if file in parents:
        raise BadInput(file, "*Include", "the file includes itself")
    with open(file, encoding="utf-8", errors="replace") as stream:
        for line in map(str.strip, stream):
            if abaqus_keyword(line) != "INCLUDE":
                if line and not line.startswith("**"):
                    yield line
                continue
            name = os.path.join(os.path.dirname(file), line.split("=")[-1].strip().strip('"'))
            if not os.path.isfile(name):
                raise BadInput(file, "*Include", f"no such file: {name}")
            yield from abaqus_lines(name, (*parents, file))


def abaqus_deck(file):
    """The deck for meshio, which keeps the last *Node block only: all nodes are in the first one. Decks that mean another
    mesh than their nodes and elements are errors."""
    lines, nodes, first, instances, parts, keyword = [], {}, None, 0, 0, ""
    for line in abaqus_lines(file):
        if line.startswith("*"):
            keyword = abaqus_keyword(line)
            instances += keyword == "INSTANCE"
            parts += keyword == "PART"
            if keyword in ABAQUS_UNREAD or (keyword == "NODE" and re.search(r",\s*(SYSTEM|INPUT)\s*=", line, re.IGNORECASE)):
                raise BadInput(file, "", f"'{line}' is not supported: write the deck with all nodes and elements, in global "
                               "coordinates")
            if keyword == "NODE":
                first = len(lines) if first is None else first
                continue
        elif keyword == "NODE":
            number = int(line.split(",")[0])
            if number in nodes:
                raise BadInput(file, "*Node", f"node {number} is there twice")
            nodes[number] = line
            continue
        moved = keyword == "INSTANCE" and not line.startswith("*")
        if moved or instances > 1 or parts > 1:
            problem = "an instance is moved" if moved else f"more than one {'instance' if instances > 1 else 'part'}"
            raise BadInput(file, "*Instance", f"{problem}: assemblies are not supported; write a deck without them "
                           "(Abaqus/CAE: Model > Edit Attributes > Do not use parts and assemblies in input files)")
        lines.append(line)
    if first is not None:
        lines[first:first] = ["*NODE", *nodes.values()]
    return "\n".join([*lines, ""]).encode()


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
    if FORMATS[extension] == "abaqus":
        return abaqus_deck(file)
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
    if extension == ".vtu":
        with open(file, "rb") as stream:
            if len(re.findall(rb"<Piece\b", stream.read())) > 1:
                raise BadInput(file, "Piece", "several pieces in one file: meshio drops cells; merge them first")
    return mesh, text
