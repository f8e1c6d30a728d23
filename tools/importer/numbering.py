"""Node and element numbers of a file."""

import dataclasses
import re

import numpy as np

from .errors import BadInput


@dataclasses.dataclass
class Numbering:
    """Numbers by point and by element in the order of the file; elements of the sets; elements of the parts, which are the
    objects unless sets are chosen."""

    nodes: np.ndarray
    elements: np.ndarray
    sets: dict = dataclasses.field(default_factory=dict)
    parts: dict = dataclasses.field(default_factory=dict)


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


def numbering_of(file, mesh, format_name):
    """Numbers of the nodes and elements in a file that meshio has read, in its order, or None. meshio drops those of
    Gmsh."""
    numbering = None
    try:
        if format_name == "gmsh":
            numbering = gmsh_numbering(file)
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
