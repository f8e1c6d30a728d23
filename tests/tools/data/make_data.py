#!/usr/bin/env python3
"""Has gmsh and VTK write the files of this folder again (gmsh 4.8.4, VTK 9.1 when they were made).

Example:
  /usr/bin/python3 make_data.py      needs the Debian packages gmsh and python3-vtk9; the tests need neither
"""

import os
import subprocess
import tempfile

import vtk

HERE = os.path.dirname(os.path.abspath(__file__))
os.chdir(HERE)

# A box of tetrahedra and a hexahedron beside it: two physical volumes, and a physical surface around the first.
GEO = """
SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 1, 1, 1};
Box(2) = {3, 0, 0, 1, 1, 1};
Mesh.MeshSizeMin = 1; Mesh.MeshSizeMax = 1;
Transfinite Curve {13:24} = 2; Transfinite Surface {7:12}; Recombine Surface {7:12}; Transfinite Volume {2};
Physical Volume("soft body", 7) = {1};
Physical Volume("plate", 9) = {2};
Physical Surface("skin", 20) = {1:6};
"""


def gmsh(target, *arguments, geometry=GEO):
    with tempfile.NamedTemporaryFile("w", suffix=".geo") as geo:
        geo.write(geometry)
        geo.flush()
        subprocess.run(["gmsh", geo.name, "-3", "-o", target, *arguments], check=True, stdout=subprocess.DEVNULL)


def named(array, name, values):
    array.SetName(name)
    for value in values:
        array.InsertNextValue(value)
    return array


def grid(shift, alive, reverse=False):
    """A tetrahedron, a hexahedron, a wedge and a pyramid, separate from each other along x; ids from 10 and from
    100."""
    shapes = [(vtk.VTK_TETRA, [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]),
              (vtk.VTK_HEXAHEDRON, [(2, 0, 0), (3, 0, 0), (3, 1, 0), (2, 1, 0),
                                    (2, 0, 1), (3, 0, 1), (3, 1, 1), (2, 1, 1)]),
              (vtk.VTK_WEDGE, [(4, 0, 0), (5, 0, 0), (4, 1, 0), (4, 0, 1), (5, 0, 1), (4, 1, 1)]),
              (vtk.VTK_PYRAMID, [(6, 0, 0), (7, 0, 0), (7, 1, 0), (6, 1, 0), (6.5, 0.5, 1)])]
    corners = [p for _, points in shapes for p in points]
    order = list(range(len(corners)))
    if reverse:
        order.reverse()
    place = {old: new for new, old in enumerate(order)}
    result, points = vtk.vtkUnstructuredGrid(), vtk.vtkPoints()
    points.SetDataTypeToDouble()
    velocity = vtk.vtkDoubleArray()
    velocity.SetName("Velocity")
    velocity.SetNumberOfComponents(3)
    for old in order:
        x, y, z = corners[old]
        points.InsertNextPoint(x + shift, y, z)
        velocity.InsertNextTuple3(0.25, 0, old)
    result.SetPoints(points)
    first = 0
    for number, (kind, members) in enumerate(shapes):
        if number in alive:
            ids = [place[first + i] for i in range(len(members))]
            result.InsertNextCell(kind, len(ids), ids)
        first += len(members)
    result.GetPointData().AddArray(velocity)
    result.GetPointData().AddArray(named(vtk.vtkIdTypeArray(), "GlobalPointIds", [10 + old for old in order]))
    result.GetCellData().AddArray(named(vtk.vtkIdTypeArray(), "ElementId", [100 + n for n in alive]))
    result.GetCellData().AddArray(named(vtk.vtkIntArray(), "PartId", [1 + n % 2 for n in alive]))
    return result


def write(writer, target, data, mode=None):
    writer.SetFileName(target)
    writer.SetInputData(data)
    if mode is not None:
        getattr(writer, mode)()
    writer.Write()


def surface(shift):
    source = vtk.vtkCubeSource()
    source.SetCenter(shift, 0, 0)
    triangles, clean = vtk.vtkTriangleFilter(), vtk.vtkCleanPolyData()
    triangles.SetInputConnection(source.GetOutputPort())
    clean.SetInputConnection(triangles.GetOutputPort())
    clean.Update()
    result = clean.GetOutput()
    result.GetPointData().Initialize()
    return result


gmsh("boxes_22.msh", "-format", "msh22")
gmsh("boxes_41.msh", "-format", "msh41")
gmsh("boxes_41b.msh", "-format", "msh41", "-bin")
gmsh("boxes.inp", "-format", "inp")
gmsh("boxes.bdf", "-format", "bdf")
gmsh("boxes_order2.msh", "-format", "msh41", "-order", "2")

everything = [0, 1, 2, 3]
write(vtk.vtkXMLUnstructuredGridWriter(), "cells_1.vtu", grid(0, everything), "SetDataModeToAscii")
write(vtk.vtkXMLUnstructuredGridWriter(), "cells_2.vtu", grid(0.5, everything, reverse=True))
write(vtk.vtkXMLUnstructuredGridWriter(), "cells_10.vtu", grid(1, [0, 2, 3]), "SetDataModeToBinary")
for number, version in ((1, 42), (2, 51)):
    legacy = vtk.vtkUnstructuredGridWriter()
    legacy.SetFileVersion(version)
    write(legacy, f"legacy_{version}.vtk", grid(number - 1, everything),
          "SetFileTypeToASCII" if number == 1 else "SetFileTypeToBinary")
polyhedron = vtk.vtkUnstructuredGrid()
corners = vtk.vtkPoints()
for corner in ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)):
    corners.InsertNextPoint(corner)
polyhedron.SetPoints(corners)
faces = vtk.vtkIdList()
for number in (4, 3, 0, 2, 1, 3, 0, 1, 3, 3, 1, 2, 3, 3, 2, 0, 3):
    faces.InsertNextId(number)
polyhedron.InsertNextCell(vtk.VTK_POLYHEDRON, faces)
write(vtk.vtkXMLUnstructuredGridWriter(), "polyhedron.vtu", polyhedron, "SetDataModeToAscii")
write(vtk.vtkPLYWriter(), "cube.ply", surface(0))
write(vtk.vtkPLYWriter(), "cube_moved.ply", surface(0.25), "SetFileTypeToASCII")
write(vtk.vtkOBJWriter(), "cube.obj", surface(0))
