"""XDMF series (.xdmf, .xmf): XML with arrays in itself, in HDF5 or in binary files."""

import os
import xml.etree.ElementTree as ET

import meshio
import numpy as np

from .errors import BadInput, needed

# Number of the type in a mixed topology: meshio's name, nodes.
TYPES = {1: ("vertex", 1), 2: ("line", 2), 4: ("triangle", 3), 5: ("quad", 4), 6: ("tetra", 4), 7: ("pyramid", 5), 8: ("wedge", 6),
         9: ("hexahedron", 8), 34: ("line3", 3), 35: ("quad9", 9), 36: ("triangle6", 6), 37: ("quad8", 8), 38: ("tetra10", 10),
         39: ("pyramid13", 13), 40: ("wedge15", 15), 41: ("wedge18", 18), 48: ("hexahedron20", 20), 49: ("hexahedron24", 24),
         50: ("hexahedron27", 27)}
NAMES = {"polyvertex": 1, "polyline": 2, "triangle": 4, "quadrilateral": 5, "tetrahedron": 6, "pyramid": 7, "wedge": 8, "hexahedron": 9,
         "edge_3": 34, "quadrilateral_9": 35, "triangle_6": 36, "tri_6": 36, "quadrilateral_8": 37, "quad_8": 37, "quad_9": 35,
         "tetrahedron_10": 38, "tet_10": 38, "pyramid_13": 39, "wedge_15": 40, "wedge_18": 41, "hexahedron_20": 48, "hex_20": 48,
         "hexahedron_24": 49, "hex_24": 49, "hexahedron_27": 50, "hex_27": 50}


def attribute(element, *names, default=None):
    """The value of an attribute, whose name and value differ between versions of XDMF."""
    return next((element.get(name) for name in names if element.get(name) is not None), default)


class Xdmf:
    """The file and its frames: grids, one for each time."""

    def __init__(self, file):
        self.file = file
        try:
            self.root = ET.parse(file).getroot()
        except ET.ParseError as problem:
            raise BadInput(file, "", f"is not XML: {problem}") from problem
        domain = self.root.find("Domain")
        grids = domain.findall("Grid") if domain is not None else []
        if not grids:
            raise BadInput(file, "Grid", "none")
        series = [grid for grid in grids if self.is_collection(grid)]
        if series:
            # meshio and FEniCS keep the mesh in a grid beside the series, or several series beside each other.
            if len(series) > 1:
                raise BadInput(file, "Grid", f"{len(series)} collections of grids: write one (FEniCS: one mesh and function for "
                               "a file)")
            kind = attribute(series[0], "CollectionType", default="Spatial").lower()
            if kind != "temporal":
                raise BadInput(file, "Grid", "the collection is of pieces: save it as one piece (ParaView: Merge Blocks)")
            grids = series[0].findall("Grid")
            self.shared_times = self.listed_times(series[0], len(grids))
        elif len(grids) > 1:
            raise BadInput(file, "Grid", f"{len(grids)} grids beside each other: a series is a collection of type Temporal")
        else:
            self.shared_times = None
        self.grids = grids
        for k, grid in enumerate(grids):
            if self.is_collection(grid):
                raise BadInput(file, "Grid", "the frame is a collection of pieces: save it as one piece (ParaView: Merge "
                               "Blocks)", k)
        self.times = [self.time_of(grid, k) for k, grid in enumerate(grids)]

    @staticmethod
    def is_collection(grid):
        return attribute(grid, "GridType", "Type", default="Uniform").lower() in ("collection", "tree")

    def listed_times(self, grid, count):
        """Times that the collection lists for its grids."""
        time = grid.find("Time")
        if time is None or attribute(time, "TimeType", "Type", default="Single").lower() != "list":
            return None
        values = self.data(time.find("DataItem")).reshape(-1)
        if len(values) != count:
            raise BadInput(self.file, "Time", f"{len(values)} times for {count} grids")
        return values

    def time_of(self, grid, k):
        time = grid.find("Time")
        if time is not None and time.get("Value") is not None:
            return float(time.get("Value"))
        return float(self.shared_times[k]) if self.shared_times is not None else None

    def referred(self, path):
        """The element that an absolute path of XPath means, without /Xdmf."""
        path = path.strip()
        path = path[len("/Xdmf/"):] if path.startswith("/Xdmf/") else path.lstrip("/")
        found = self.root.find(path) if path else None
        if found is None:
            found = self.root.find(".//" + path)
        if found is None:
            raise BadInput(self.file, "Reference", f"nothing is at '{path}'")
        return found

    def child(self, grid, name):
        """The topology or geometry of a grid: its own, or that of another grid to which it points."""
        found = grid.find(name)
        if found is None:
            for include in grid:  # xpointer(//Grid[@Name="mesh"]/*[self::Topology or self::Geometry])
                if not str(include.tag).endswith("}include"):  # in namespaces of several years
                    continue
                path = include.get("xpointer", "").strip()
                path = path[len("xpointer("):-1] if path.startswith("xpointer(") else path
                owner = self.referred(path.rsplit("/*", 1)[0].replace("//", ""))
                found = owner if owner.tag == name else owner.find(name)
                if found is not None:
                    break
        while found is not None and found.get("Reference") is not None:
            path = found.text if found.get("Reference").upper() == "XML" else found.get("Reference")
            found = self.referred(path or "")
        if found is None:
            raise BadInput(self.file, name, "none")
        return found

    def item(self, element, what):
        items = element.findall("DataItem")
        if len(items) != 1:
            raise BadInput(self.file, what, f"{len(items)} data items")
        return self.data(items[0])

    def data(self, item):
        while item.get("Reference") is not None:
            item = self.referred(item.text if item.get("Reference").upper() == "XML" else item.get("Reference"))
        if attribute(item, "ItemType", default="Uniform").lower() != "uniform":
            raise BadInput(self.file, "DataItem", f"of type {item.get('ItemType')}: only Uniform is read")
        shape = [int(word) for word in item.get("Dimensions", "").split()]
        number = attribute(item, "NumberType", "DataType", default="Float").lower()
        kind = {"float": "f", "int": "i", "uint": "u", "char": "i", "uchar": "u"}.get(number)
        size = {"char": 1, "uchar": 1}.get(number, int(item.get("Precision", "4")))
        if kind is None or size not in (1, 2, 4, 8):
            raise BadInput(self.file, "DataItem", f"numbers of type {number} and {size} bytes")
        values = self.raw(item, np.dtype(f"{kind}{size}"))
        if shape and values.size != np.prod(shape):
            raise BadInput(self.file, "DataItem", f"{values.size} values instead of {' x '.join(map(str, shape))}")
        return values.reshape(shape or [-1])

    def raw(self, item, dtype):
        text, how = (item.text or "").strip(), item.get("Format", "XML").upper()
        folder = os.path.dirname(self.file)
        if how == "XML":
            try:
                return np.array(text.split(), np.float64 if dtype.kind == "f" else dtype)
            except ValueError as problem:
                raise BadInput(self.file, "DataItem", str(problem)) from problem
        if how == "HDF":
            name, _, path = text.rpartition(":")
            name = os.path.join(folder, name.strip())
            try:
                with needed("h5py", "python3-h5py", self.file).File(name, "r") as source:
                    return source[path.strip()][()]
            except (OSError, KeyError) as problem:
                raise BadInput(self.file, "DataItem", f"{text}: cannot be read: {problem}") from problem
        if how == "BINARY" and item.get("Compression", "Raw").lower() == "raw":
            order = ">" if item.get("Endian", "Native").lower() == "big" else "<"
            name = os.path.join(folder, text)
            try:
                return np.fromfile(name, dtype.newbyteorder(order), offset=int(item.get("Seek", "0")),
                                   count=int(np.prod([int(word) for word in item.get("Dimensions", "-1").split()])))
            except OSError as problem:
                raise BadInput(self.file, "DataItem", f"{name}: cannot be read: {problem}") from problem
        raise BadInput(self.file, "DataItem", f"the format {how} is not read: XML, HDF, and Binary without compression are")

    def points(self, geometry):
        kind = attribute(geometry, "GeometryType", "Type", default="XYZ").upper()
        if kind == "X_Y_Z":
            return np.column_stack([self.data(item).reshape(-1) for item in geometry.findall("DataItem")])
        if kind not in ("XYZ", "XY"):
            raise BadInput(self.file, "Geometry", f"of type {kind}: XYZ, XY, X_Y_Z are read")
        return self.item(geometry, "Geometry").reshape(-1, len(kind))

    def blocks(self, topology):
        name = attribute(topology, "TopologyType", "Type", default="").lower()
        values = self.item(topology, "Topology")
        if name == "mixed":
            return self.mixed_blocks(values.reshape(-1).astype(np.int64))
        if name not in NAMES:
            raise BadInput(self.file, "Topology", f"of type {name or 'none'}: not supported")
        kind, nodes = TYPES[NAMES[name]]
        nodes = int(topology.get("NodesPerElement", nodes)) if nodes < 3 else nodes
        return [(kind, values.reshape(-1, nodes).astype(np.int64))]

    def mixed_blocks(self, values):
        """Blocks of cells of one type, in the order of the file."""
        blocks, at = [], 0
        while at < len(values):
            kind = TYPES.get(int(values[at]))
            if kind is None:
                raise BadInput(self.file, "Topology", f"number {values[at]} is no type of a cell that is supported", at)
            name, nodes = kind
            at += 1 + (nodes < 3)  # the number of nodes follows those without a fixed one
            if nodes < 3:
                nodes = int(values[at - 1])
                name = "vertex" if kind[0] == "vertex" else f"line{nodes}"
            if at + nodes > len(values):
                raise BadInput(self.file, "Topology", "ends within a cell", at)
            if not blocks or blocks[-1][0] != name:
                blocks.append((name, []))
            blocks[-1][1].append(values[at:at + nodes])
            at += nodes
        return [(name, np.array(rows)) for name, rows in blocks]

    def read(self, k):
        grid = self.grids[k]
        points = self.points(self.child(grid, "Geometry"))
        blocks = self.blocks(self.child(grid, "Topology"))
        sizes = np.cumsum([len(rows) for _, rows in blocks])
        point_data, cell_data = {}, {}
        for found in grid.findall("Attribute"):
            centre, name = found.get("Center", "Node").lower(), found.get("Name", "")
            if centre not in ("node", "cell"):
                continue
            values = self.item(found, f"Attribute {name}")
            values = values[:, 0] if values.ndim == 2 and values.shape[1] == 1 else values
            count = len(points) if centre == "node" else sizes[-1]
            if len(values) != count:
                raise BadInput(self.file, f"Attribute {name}", f"{len(values)} values for {count} {centre}s")
            if centre == "node":
                point_data[name] = values
            else:
                cell_data[name] = np.split(values, sizes[:-1])
        return meshio.Mesh(points, blocks, point_data=point_data, cell_data=cell_data)
