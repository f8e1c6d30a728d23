"""What VTK reads: .vtu in several pieces, .pvtu, and d3plot of LS-DYNA."""

import contextlib
import os
import re

import meshio
import numpy as np

from .errors import BadInput, needed
from .pieces import concatenated, without_ghosts

PACKAGE = "python3-vtk9"


@contextlib.contextmanager
def errors_of(file, reader):
    """Messages that VTK would print become one error."""
    said = []
    reader.AddObserver("ErrorEvent", lambda *_: said.append("VTK cannot read it"))
    vtk = needed("vtkmodules.vtkCommonCore", PACKAGE, file)
    vtk.vtkObject.GlobalWarningDisplayOff()
    try:
        yield
    finally:
        vtk.vtkObject.GlobalWarningDisplayOn()
    if said or reader.GetErrorCode():
        raise BadInput(file, "", "VTK cannot read it")


def arrays_of(data, file):
    """Numeric arrays with a value for each point or cell, by name."""
    convert = needed("vtkmodules.util.numpy_support", PACKAGE, file).vtk_to_numpy
    result = {}
    for k in range(data.GetNumberOfArrays()):
        array = data.GetArray(k)
        if array is not None and array.GetName():
            result[array.GetName()] = convert(array).copy()
    return result


def mesh_of(grid, file):
    """A grid of VTK as meshio's mesh: cells of one type in a row are a block."""
    convert = needed("vtkmodules.util.numpy_support", PACKAGE, file).vtk_to_numpy
    if grid.GetNumberOfPoints() == 0 or grid.GetNumberOfCells() == 0:
        raise BadInput(file, "cells", "none")
    points = convert(grid.GetPoints().GetData()).astype(np.float64)
    types = convert(grid.GetCellTypesArray()).astype(int)
    offsets, nodes = convert(grid.GetCells().GetOffsetsArray()), convert(grid.GetCells().GetConnectivityArray())
    cell_arrays = arrays_of(grid.GetCellData(), file)
    kinds = np.column_stack([types, np.diff(offsets)])
    starts = np.concatenate([[0], 1 + np.flatnonzero((np.diff(kinds, axis=0) != 0).any(axis=1)), [len(types)]])
    blocks, members = [], []
    for first, last in zip(starts[:-1], starts[1:]):
        kind = int(kinds[first, 0])
        if kind not in meshio._vtk_common.vtk_to_meshio_type:
            raise BadInput(file, "cells", f"of VTK's type {kind}: not supported", int(first))
        here = np.arange(first, last)
        blocks.append((meshio._vtk_common.vtk_to_meshio_type[kind], nodes[offsets[here][:, None] + np.arange(kinds[first, 1])]))
        members.append(here)
    return meshio.Mesh(points, blocks, point_data=arrays_of(grid.GetPointData(), file),
                       cell_data={name: [values[here] for here in members] for name, values in cell_arrays.items()})


def pieces(file):
    """The grid of a .vtu or .pvtu with several pieces."""
    xml = needed("vtkmodules.vtkIOXML", PACKAGE, file)
    parallel = file.lower().endswith(".pvtu")
    reader = xml.vtkXMLPUnstructuredGridReader() if parallel else xml.vtkXMLUnstructuredGridReader()
    reader.SetFileName(file)
    with errors_of(file, reader):
        reader.Update()
    grid = reader.GetOutput()
    mesh = mesh_of(grid, file)
    mesh.field_data = arrays_of(grid.GetFieldData(), file)
    return without_ghosts(mesh)


def node_numbers(values):
    """Numbers of nodes in a d3plot. VTK 9.1 puts those of single precision, 32 bits each, into an array of 64 bits."""
    packed = values.view(np.int32)[:len(values)]
    return packed.astype(np.int64) if len(values) and values[0] >> 32 else values


def control_words(file):
    """The 64 words at the start of a d3plot, and the type of its integers. VTK crashes on files that are none."""
    head = np.fromfile(file, np.uint8, 512)
    for word, order in ((4, "<"), (8, "<"), (4, ">"), (8, ">")):
        if len(head) >= 64 * word and 900 < head[14 * word:15 * word].view(f"{order}f{word}")[0] < 1000:
            return head[:64 * word].view(f"{order}i{word}").astype(np.int64), np.dtype(f"{order}i{word}")
    raise BadInput(file, "", "is no d3plot of LS-DYNA")


def part_numbers(file):
    """Numbers of the parts in a d3plot, in the order of VTK's blocks; none if the file does not list them. VTK 9.1 takes the
    position of the last part for its number."""
    control, integer = control_words(file)
    kind, nodes, solids, beams, shells, particles, thick = control[[15, 16, 23, 28, 31, 37, 40]].tolist()
    words = np.memmap(file, integer, "r", shape=os.path.getsize(file) // integer.itemsize)
    start = 64 + (2 + int(words[65]) if kind in (5, 7) else 0) + int(control[47])
    start += nodes * 3 + 9 * solids + 9 * thick + 6 * beams + 5 * shells
    if start > len(words):
        raise BadInput(file, "", "ends before its mesh is complete")
    materials = int(control[51])
    first = start + 16 + nodes + solids + beams + shells + thick
    if control[39] <= 0 or particles or materials <= 0 or first + materials > len(words) or words[start] >= 0:
        return []
    return words[first:first + materials].tolist()


class D3plot:
    """Results of LS-DYNA. Points are those of each state, deformed; parts are objects; deleted elements are gone. `times` has
    the times of the states."""

    def __init__(self, file):
        self.file, self.shift, self.part_numbers = file, 0, part_numbers(file)
        self.reader = needed("vtkmodules.vtkIOLSDyna", PACKAGE, file).vtkLSDynaReader()
        whole = os.path.abspath(file)
        self.reader.SetDatabaseDirectory(os.path.dirname(whole))
        self.reader.SetFileName(whole)
        with errors_of(file, self.reader):
            self.reader.UpdateInformation()
        self.times = [self.reader.GetTimeValue(k) for k in range(self.reader.GetNumberOfTimeSteps())]
        if not self.times:
            raise BadInput(file, "", "is not a d3plot with a state")
        self.reader.RemoveDeletedCellsOff()
        solids, shells = self.numbers()
        self.reader.RemoveDeletedCellsOn()
        if solids & shells:  # LS-DYNA numbers solids and shells apart
            self.shift = max(solids)

    def numbers(self):
        """The numbers of the solids, and of the shells."""
        solids, shells = set(), set()
        for mesh in self.parts(0):
            for block, ids in zip(mesh.cells, mesh.cell_data.get("ELEMENT_ID", [])):
                (shells if block.type in ("triangle", "quad") else solids).update(ids.tolist())
        return solids, shells

    def parts(self, k):
        """A mesh for each part of a state."""
        self.reader.SetTimeStep(k)
        with errors_of(self.file, self.reader):
            self.reader.Update()
        output, key = self.reader.GetOutput(), needed("vtkmodules.vtkCommonDataModel", PACKAGE, self.file).vtkCompositeDataSet.NAME()
        for number in range(output.GetNumberOfBlocks()):
            grid = output.GetBlock(number)
            if grid is None or not grid.IsA("vtkUnstructuredGrid") or grid.GetNumberOfCells() == 0:
                continue
            mesh, fields = mesh_of(grid, self.file), arrays_of(grid.GetFieldData(), self.file)
            part = int(fields["Material Id"][0]) if len(fields.get("Material Id", ())) else number + 1
            if number + 1 == len(self.part_numbers) == part:
                part = int(self.part_numbers[-1])
            name = output.GetMetaData(number).Get(key) or ""
            yield self.named(mesh, part, "" if re.fullmatch(r"Part\d+ \(Matl\d+\)", name) else name.strip())

    def named(self, mesh, part, name):
        """The mesh of a part with the arrays that the importer knows."""
        ids, velocity = mesh.point_data.get("UserID"), mesh.point_data.get("Velocity")
        mesh.point_data = {} if ids is None else {"NODE_ID": node_numbers(ids)}
        if velocity is not None:
            mesh.point_data["Velocity"] = velocity
        numbers = mesh.cell_data.get("UserIds")
        mesh.cell_data = {"PART_ID": [np.full(len(block.data), part) for block in mesh.cells]}
        if numbers is not None:
            mesh.cell_data["ELEMENT_ID"] = [ids + self.shift * (block.type in ("triangle", "quad"))
                                            for block, ids in zip(mesh.cells, numbers)]
        mesh.part_names = {part: name} if name else {}
        return mesh

    def read(self, k):
        """The mesh of a state. Parts have points of their own: those of one number are one."""
        meshes = list(self.parts(k))
        if not meshes:
            raise BadInput(self.file, "cells", "none are left")
        mesh = concatenated(meshes)
        mesh.part_names = {part: name for one in meshes for part, name in one.part_names.items()}
        return mesh, f"numbers of shells + {self.shift}, because solids have the same" if self.shift else ""
