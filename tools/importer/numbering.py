"""Node and element numbers that meshio drops: Gmsh (text) and Abaqus."""

import dataclasses
import itertools
import os
import re

import meshio
import numpy as np

from .errors import BadInput
from .formats import FORMATS, abaqus_keyword, abaqus_lines


@dataclasses.dataclass
class Numbering:
    """Node and element numbers that meshio drops: by point, by element in the order of the file, and sets of
    elements."""

    nodes: np.ndarray
    elements: np.ndarray
    sets: dict = dataclasses.field(default_factory=dict)


def gmsh_numbering(file):
    """The numbers of a Gmsh file. None for binary files and for versions that are not supported."""
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
    """Node numbers, element numbers, and element sets by name."""
    nodes, elements, sets = [], [], {}
    numbers = row = None  # list to which the numbers of data lines are added; kind of these lines
    generate = False
    for line in abaqus_lines(file):
        if line.startswith("*"):
            keyword = abaqus_keyword(line)
            values = dict(re.findall(r"(\w+)\s*=\s*([^,]+)", line))
            values = {key.upper(): value.strip() for key, value in values.items()}
            numbers, generate = None, bool(re.search(r",\s*GENERATE", line, re.IGNORECASE))
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
            # An element may continue on further lines.
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
