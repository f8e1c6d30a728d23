"""Results of CalculiX (.frd, text)."""

import meshio
import numpy as np

from .errors import BadInput
from .numbering import Numbering

# Number of the element type: meshio's name, nodes. The corners come first.
TYPES = {1: ("hexahedron", 8), 2: ("wedge", 6), 3: ("tetra", 4), 4: ("hexahedron20", 20), 5: ("wedge15", 15), 6: ("tetra10", 10),
         7: ("triangle", 3), 8: ("triangle6", 6), 9: ("quad", 4), 10: ("quad8", 8), 11: ("line", 2), 12: ("line3", 3)}


def width_of(form):
    """Digits of a node number: 5 in the short form (0), 10 in the long one (1)."""
    return 5 if form == 0 else 10


class Frd:
    """Mesh and results; `steps` has (time, {name: vectors}) of each increment. Numbers stand in fixed columns."""

    def __init__(self, file):
        self.file, self.steps, self.cells, self.elements, self.materials = file, [], [], [], []
        self.numbers, self.points = np.zeros(0, np.int64), np.zeros((0, 3))
        with open(file, encoding="ascii", errors="replace") as stream:
            self.lines = (line.rstrip("\n") for line in stream)
            try:
                for line in self.lines:
                    self.block(line)
            except (ValueError, IndexError, StopIteration) as problem:
                raise BadInput(file, "", f"is not the text form of .frd: {problem}") from problem
        if not len(self.points) or not self.cells:
            raise BadInput(file, "", "has no nodes or no elements; .frd in binary form is not read")

    def block(self, line):
        key = line[:6].strip()
        if key == "2C":
            self.numbers, self.points = self.rows(width_of(int(line[73:75])), 3)
        elif key == "3C":
            self.read_elements(int(line[73:75]))
        elif key.startswith("100C"):
            self.read_results(float(line[12:24]), int(line[73:75]))

    def rows(self, width, count):
        """Lines ` -1`, node, values, up to ` -3`."""
        numbers, values = [], []
        for line in self.lines:
            if line.startswith(" -3"):
                break
            numbers.append(int(line[3:3 + width]))
            start = 3 + width
            values.append([float(line[start + 12 * k:start + 12 * k + 12]) for k in range(count)])
        return np.array(numbers, np.int64), np.array(values, float).reshape(-1, count)

    def read_elements(self, form):
        width = width_of(form)
        for line in self.lines:
            if line.startswith(" -3"):
                return
            if line.startswith(" -1"):
                kind, material = int(line[3 + width:8 + width]), int(line[13 + width:18 + width])
                if kind not in TYPES:
                    raise BadInput(self.file, "cells", f"of type {kind}: not supported", len(self.elements))
                self.elements.append(int(line[3:3 + width]))
                self.materials.append(material)
                self.cells.append((TYPES[kind][0], []))
            elif line.startswith(" -2"):
                self.cells[-1][1].extend(int(line[at:at + width]) for at in range(3, len(line.rstrip()), width))

    def read_results(self, time, form):
        name = line = ""
        for line in self.lines:
            if line.startswith(" -4"):
                name = line[3:13].strip()
            elif not line.startswith(" -5"):
                break
        if name not in ("DISP", "VELO"):
            while not line.startswith(" -3"):
                line = next(self.lines)
            return
        rows = self.rows_after(line, width_of(form))
        if not self.steps or self.steps[-1][0] != time:
            self.steps.append((time, {}))
        self.steps[-1][1][name] = rows

    def rows_after(self, line, width):
        """A vector for each node in the order of the nodes; nodes without one have 0."""
        order = {int(number): row for row, number in enumerate(self.numbers)}
        values = np.zeros((len(self.numbers), 3))
        while not line.startswith(" -3"):
            start = 3 + width
            values[order[int(line[3:start])]] = [float(line[start + 12 * k:start + 12 * k + 12]) for k in range(3)]
            line = next(self.lines)
        return values

    def read(self, step):
        """The mesh with the displacements (DISP) and velocities (VELO) of a step, and its numbers; materials are objects."""
        rows = {int(number): row for row, number in enumerate(self.numbers)}
        blocks, members = [], []
        for k, (kind, nodes) in enumerate(self.cells):
            if not blocks or blocks[-1][0] != kind:
                blocks.append((kind, []))
                members.append([])
            try:
                blocks[-1][1].append([rows[node] for node in nodes])
            except KeyError as missing:
                raise BadInput(self.file, "cells", f"element {self.elements[k]} has node {missing}, which is not there", k) from missing
            members[-1].append(self.materials[k])
        names = {"DISP": "DISP", "VELO": "Velocity"}
        data = {names[name]: values for name, values in (self.steps[step][1] if step is not None else {}).items()}
        mesh = meshio.Mesh(self.points, [(kind, np.array(nodes)) for kind, nodes in blocks], point_data=data,
                           cell_data={"PartId": [np.array(materials) for materials in members]})
        return mesh, Numbering(self.numbers, np.array(self.elements, np.int64))
