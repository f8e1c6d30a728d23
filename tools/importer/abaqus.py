"""Abaqus and CalculiX decks: nodes, elements, element sets; parts and instances are assembled."""

import dataclasses
import os
import re

import meshio
import numpy as np

from .errors import BadInput
from .numbering import Numbering

# Keywords that make or move nodes and elements, and that are not read.
UNREAD = {"SYSTEM", "NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY"}
# Names of elements, of Abaqus and CalculiX, that meshio does not know.
FURTHER = {"R3D4": "quad", "C3D4": "tetra", "C3D4H": "tetra", "M3D3": "triangle", "M3D4": "quad", "M3D4R": "quad", "S6": "triangle6",
           "S8": "quad8", "C3D6H": "wedge", "C3D15H": "wedge15", "C3D5": "pyramid", "C3D5H": "pyramid", "SC6R": "wedge",
           "SC8R": "hexahedron", "C3D8T": "hexahedron", "C3D8RT": "hexahedron", "C3D4T": "tetra", "C3D6T": "wedge",
           "C3D10T": "tetra10", "C3D20T": "hexahedron20", "C3D20RT": "hexahedron20", "SFM3D3": "triangle", "SFM3D4": "quad",
           "SFM3D4R": "quad", "S4T": "quad", "S3T": "triangle", "S3RT": "triangle", "S4RT": "quad"}
TYPES = {**meshio.abaqus._abaqus.abaqus_to_meshio_type, **FURTHER}
# Points, springs, beams and the like: no surface to touch.
LEFT_OUT = re.compile(r"MASS|ROTARYI|SPRING\w*|DASHPOT\w*|CONN\w+|DCOUP\w+|D(IST)?COUP\w*|[BT][23]\w*|PIPE\w+|FRAME\w+|ELBOW\w+|"
                      r"GAP\w*|HEATCAP|R[23]D2|D|U\d+|JOINTC|ITS\w+|DRAG\w+")


def keyword_of(line):
    """NODE for *Node, NSET=..; "" for a line of data."""
    return line[1:].split(",")[0].strip().upper() if line.startswith("*") else ""


def parameters(line):
    """{"NSET": "a"} for *Node, nset=a; the value of a word without one is ""."""
    words = [word.partition("=") for word in line.split(",")[1:]]
    return {key.strip().upper(): value.strip().strip('"') for key, _, value in words}


def lines_of(file, parents=()):
    """The lines of a deck without comments and blank lines, with those of the files that it includes."""
    if file in parents:
        raise BadInput(file, "*Include", "the file includes itself")
    with open(file, encoding="utf-8", errors="replace") as stream:
        for line in map(str.strip, stream):
            if keyword_of(line) != "INCLUDE":
                if line and not line.startswith("**"):
                    yield line
                continue
            name = os.path.join(os.path.dirname(file), parameters(line).get("INPUT", ""))
            if not os.path.isfile(name):
                raise BadInput(file, "*Include", f"no such file: {name}")
            yield from lines_of(name, (*parents, file))


@dataclasses.dataclass
class Part:
    """Nodes and elements by their numbers; sets of elements by name."""

    nodes: dict = dataclasses.field(default_factory=dict)
    elements: dict = dataclasses.field(default_factory=dict)  # number: (meshio's type, nodes)
    sets: dict = dataclasses.field(default_factory=dict)
    left_out: int = 0

    def set_named(self, name):
        """The members of a set, which is made if there is none. Letters of a name may be small or large."""
        known = next((key for key in self.sets if key.upper() == name.upper()), name)
        return self.sets.setdefault(known, [])


@dataclasses.dataclass
class Instance:
    """A part at its place. `own` are nodes and elements that the instance itself has, for a part without a mesh."""

    name: str
    part: str
    moves: list = dataclasses.field(default_factory=list)
    own: Part = dataclasses.field(default_factory=Part)


class Deck:
    """Reads a deck keyword by keyword. Nodes and elements belong to the part or instance in which they stand, else to the
    deck itself, as those of CalculiX."""

    def __init__(self, file):
        self.file, self.model, self.parts, self.instances, self.sets = file, Part(), {}, {}, []
        self.here, self.instance, self.assembly = self.model, None, False
        keyword, words, pending = "", {}, []
        for line in lines_of(file):
            if not line.startswith("*"):
                self.data(keyword, words, line, pending)
                continue
            self.complete(keyword, pending)
            keyword, words, pending = keyword_of(line), parameters(line), []
            self.begin(keyword, words, line)
        self.complete(keyword, pending)

    def begin(self, keyword, words, line):
        if keyword in UNREAD or (keyword == "NODE" and ("SYSTEM" in words or "INPUT" in words)):
            raise BadInput(self.file, "", f"'{line}' is not supported: write the deck with all nodes and elements, in global "
                           "coordinates")
        if keyword == "PART":
            self.here = self.parts[words.get("NAME", "").upper()] = Part()
        elif keyword == "INSTANCE":
            if "PART" not in words:
                raise BadInput(self.file, "*Instance", f"'{line}' names no part: instances of earlier analyses are not read")
            self.instance = Instance(words.get("NAME", ""), words["PART"])
            self.instances[self.instance.name.upper()], self.here = self.instance, self.instance.own
        elif keyword in ("END PART", "END INSTANCE"):
            self.here, self.instance = self.model, None
        elif keyword in ("ASSEMBLY", "END ASSEMBLY"):
            self.assembly = keyword == "ASSEMBLY"
        elif keyword == "ELEMENT":
            self.begin_elements(words)

    def begin_elements(self, words):
        name = words.get("TYPE", "").upper()
        self.kind = TYPES.get(name) if not LEFT_OUT.fullmatch(name) else None
        if self.kind is None and not LEFT_OUT.fullmatch(name):
            raise BadInput(self.file, "*Element", f"type '{name}' is not supported; what is: tetrahedra, wedges, hexahedra, and "
                           "triangles and quads as shells")
        if self.assembly and self.instance is None and self.kind and not self.kind.startswith("line"):
            raise BadInput(self.file, "*Element", f"elements of type '{name}' in the assembly: put them into a part")
        self.width = 1 + meshio._mesh.num_nodes_per_cell[self.kind] if self.kind else 1
        self.elset = words.get("ELSET")

    def data(self, keyword, words, line, pending):
        fields = [field.strip() for field in line.split(",") if field.strip()]
        try:
            if keyword == "NODE":
                self.add_node(fields)
            elif keyword == "ELEMENT":
                self.add_element(fields, pending)
            elif keyword == "INSTANCE":
                self.instance.moves.append([float(field) for field in fields])
            elif keyword == "ELSET":
                self.add_to_set(words, fields)
        except ValueError as problem:
            raise BadInput(self.file, f"*{keyword.capitalize()}", f"'{line}': {problem}") from problem

    def add_node(self, fields):
        number = int(fields[0])
        if number in self.here.nodes:
            raise BadInput(self.file, "*Node", f"node {number} is there twice")
        self.here.nodes[number] = [*map(float, fields[1:4]), 0.0, 0.0, 0.0][:3]

    def add_element(self, fields, pending):
        if self.kind is None:
            self.here.left_out += 1
            return
        pending += map(int, fields)  # an element may continue on further lines
        while len(pending) >= self.width:
            number, nodes = pending[0], pending[1:self.width]
            del pending[:self.width]
            if number in self.here.elements:
                raise BadInput(self.file, "cell ids", f"{number} is there twice", len(self.here.elements))
            self.here.elements[number] = (self.kind, nodes)
            if self.elset is not None:
                self.here.set_named(self.elset).append(number)

    def add_to_set(self, words, fields):
        if "GENERATE" in words:
            first, last, stride = (int(field) for field in (fields + ["1"])[:3])
            members = list(range(first, last + 1, stride))
        else:
            members = [int(field) if field.lstrip("-").isdigit() else field for field in fields]
        if self.assembly and self.instance is None:
            self.sets.append((words.get("ELSET", ""), words.get("INSTANCE", "").upper(), members))
        else:
            self.here.set_named(words.get("ELSET", "")).extend(members)

    def complete(self, keyword, pending):
        if keyword == "ELEMENT" and pending:
            raise BadInput(self.file, "*Element", f"element {pending[0]} has {len(pending) - 1} nodes, its type has {self.width - 1}")


def moved(points, moves, file):
    """The points at the place of an instance: first the translation, then the rotation, in degrees about an axis through two
    points. The translation does not move the axis."""
    points = np.array(points, float).reshape(-1, 3)
    if len(moves) > 2 or any(len(values) != count for values, count in zip(moves, (3, 7))):
        raise BadInput(file, "*Instance", "its data are 3 numbers (translation) and 7 numbers (rotation)")
    if moves:
        points = points + moves[0]
    if len(moves) == 2:
        start, end, angle = np.array(moves[1][:3]), np.array(moves[1][3:6]), np.radians(moves[1][6])
        length = np.linalg.norm(end - start)
        if not length > 0:
            raise BadInput(file, "*Instance", "the two points of the axis of rotation are one")
        axis, arm = (end - start) / length, points - start
        points = (start + arm * np.cos(angle) + np.cross(axis, arm) * np.sin(angle)
                  + np.outer(arm @ axis, axis) * (1 - np.cos(angle)))
    return points


def members_of(sets, name, file, seen=()):
    """Numbers of a set's elements; a set may name other sets."""
    result, by_upper = [], {key.upper(): key for key in sets}
    for member in sets[name]:
        known = member if isinstance(member, int) else by_upper.get(member.upper())
        if isinstance(known, int):
            result.append(known)
        elif known in (*seen, name):
            raise BadInput(file, "*Elset", f"'{name}' has itself as a member")
        elif known is not None:
            result += members_of(sets, known, file, (*seen, name))
    return result


class Assembly:
    """Nodes and elements of all instances under numbers of their own: those of the second instance follow the largest
    numbers of the first, and so on."""

    def __init__(self, file):
        self.file = file
        self.nodes, self.points, self.elements, self.kinds, self.corners = [], [], [], [], []
        self.sets, self.instances, self.notes = {}, {}, []
        self.next_node = self.next_element = 0

    def add(self, instance, part, alone):
        numbers = np.array(list(part.nodes), np.int64)
        rows = {number: row for row, number in enumerate(part.nodes)}
        first_row, node_shift, element_shift = len(self.nodes), self.next_node, self.next_element
        self.points.append(moved(list(part.nodes.values()), instance.moves, self.file))
        self.nodes += (numbers + node_shift).tolist()
        for number, (kind, nodes) in part.elements.items():
            missing = [node for node in nodes if node not in rows]
            if missing:
                raise BadInput(self.file, "*Element", f"element {number} has node {missing[0]}, which is not there")
            self.elements.append(number + element_shift)
            self.kinds.append(kind)
            self.corners.append([first_row + rows[node] for node in nodes])
        for name in part.sets:
            whole = name if alone else f"{instance.name}.{name}"
            self.sets[whole] = [number + element_shift for number in members_of(part.sets, name, self.file)]
        self.instances[instance.name.upper()] = (instance.name, element_shift, [number + element_shift for number in part.elements])
        if not alone:
            self.notes.append(f"instance {instance.name}: node numbers + {node_shift}, element numbers + {element_shift}")
        if part.left_out:
            self.notes.append(f"{part.left_out} elements without a surface (springs, beams, ..) are left out")
        self.next_node += max(part.nodes, default=0)
        self.next_element += max(part.elements, default=0)

    def mesh(self):
        blocks = []
        for kind, corners in zip(self.kinds, self.corners):  # in the order of the deck
            if not blocks or blocks[-1][0] != kind:
                blocks.append((kind, []))
            blocks[-1][1].append(corners)
        points = np.concatenate(self.points) if self.points else np.zeros((0, 3))
        numbering = Numbering(np.array(self.nodes, np.int64), np.array(self.elements, np.int64), self.sets)
        return meshio.Mesh(points, [(kind, np.array(rows)) for kind, rows in blocks]), numbering


def part_of(deck, instance):
    if instance.part.upper() not in deck.parts:
        raise BadInput(deck.file, "*Instance", f"{instance.name}: no part '{instance.part}'; there is: "
                       f"{', '.join(deck.parts) or 'none'}")
    part, own = deck.parts[instance.part.upper()], instance.own
    return Part({**part.nodes, **own.nodes}, {**part.elements, **own.elements}, {**part.sets, **own.sets},
                part.left_out + own.left_out)


def read(file):
    """The mesh, what to say about it, and its numbers. Each instance of several is an object, by its name."""
    deck = Deck(file)
    instances = list(deck.instances.values())
    if not instances and len(deck.parts) > 1:
        raise BadInput(file, "*Part", f"{len(deck.parts)} parts, and no *Instance says where they are")
    if not instances and deck.parts:
        instances = [Instance(name, name) for name in deck.parts]
    assembly = Assembly(file)
    if deck.model.elements or not instances:
        if instances:
            raise BadInput(file, "*Element", "elements outside the parts of the assembly")
        assembly.add(Instance("", ""), deck.model, alone=True)
    for instance in instances:
        assembly.add(instance, part_of(deck, instance), alone=len(instances) == 1)
    for name, instance, members in deck.sets:
        if instance not in assembly.instances:
            continue
        shift = assembly.instances[instance][1]
        assembly.sets.setdefault(name, []).extend(number + shift for number in members if isinstance(number, int))
    mesh, numbering = assembly.mesh()
    if len(instances) > 1:
        numbering.parts = {name: members for name, _, members in assembly.instances.values() if members}
    return mesh, "; ".join(assembly.notes), numbering
