"""The frames of a file: one, or several of a series."""

import dataclasses
import os
import re
import typing
import xml.etree.ElementTree as ET

import numpy as np

from . import abaqus, exodus, frd, vtk_grids, xdmf
from .errors import BadInput
from .formats import FORMATS, OBJECT_IDS, is_in_pieces, meshio_read
from .numbering import numbering_of
from .pieces import concatenated, without_ghosts

# What to do about files that are not read.
ADVICE = {
    ".vtkhdf": "is a sequence or mesh in VTKHDF already: volccd reads it",
    ".hdf": "if it is VTKHDF, volccd reads it; of an XDMF series, give the .xdmf file",
    ".h5": "is data without a layout: give the .xdmf file that goes with it",
    ".stl": "has no common vertices: merge them (meshlab, ParaView: Clean) and save .ply or .obj",
    ".vtp": "is a surface: save it as .ply (ParaView: Save Data), or make it a grid (Append Datasets) and save .vtu",
    ".vtm": "is a set of grids: save one (ParaView: Merge Blocks) as .vtu or .pvd",
    ".k": "is a deck of LS-DYNA, without results: give its d3plot",
    ".key": "is a deck of LS-DYNA, without results: give its d3plot",
    ".odb": "is read by Abaqus alone: export the frames with its scripting interface (abaqus python) as .inp or .vtu",
    ".rst": "is of Ansys: save .vtu with ansys-mapdl-reader (save_as_vtk)",
    ".rth": "is of Ansys: save .vtu with ansys-mapdl-reader (save_as_vtk)",
    ".op2": "is of Nastran: save .vtu with pyNastran (format_converter)",
    ".rad": "is a deck of OpenRadioss: convert its results (A001, ..) with its anim_to_vtk",
    ".case": "is of EnSight: save it as .pvd or .vtu with ParaView",
    ".foam": "is of OpenFOAM: save it as .pvd or .vtu with ParaView",
    ".med": "is of Salome: convert it with `meshio convert` to .vtu",
}
SERIES = (".pvd", ".pvtu", ".xdmf", ".xmf", ".e", ".exo", ".ex2", ".frd")


@dataclasses.dataclass
class Source:
    """One frame that can be read: `read()` gives mesh, remarks of the reader, and numbers. `name` stands in messages."""

    name: str
    read: typing.Callable
    time: float = None
    in_pieces: bool = False  # points on the borders of pieces are there more than once
    undeformed: bool = False  # the format has points before deformation, and displacements


def is_d3plot(file):
    """d3plot is a name, or the end of one, and no extension; the further files of the family have a number."""
    return os.path.basename(file).lower().endswith("d3plot")


def sources_of(file):
    """The frames of a file, in their order."""
    if not os.path.isfile(file):
        raise BadInput(file, "", "no such file")
    if is_d3plot(file):
        return d3plot_sources(file)
    extension = os.path.splitext(file)[1].lower()
    if extension in (".xdmf", ".xmf"):
        return xdmf_sources(file)
    if extension in (".e", ".exo", ".ex2"):
        return exodus_sources(file)
    if extension == ".frd":
        return frd_sources(file)
    if extension == ".pvd":
        return pvd_sources(file)
    if extension == ".pvtu" or (extension == ".vtu" and is_in_pieces(file)):
        return [Source(file, lambda: (vtk_grids.pieces(file), "", None), in_pieces=True)]
    if extension == ".inp":
        return [Source(file, lambda: abaqus.read(file))]
    if re.search(r"d3plot\d+$", file.lower()):
        raise BadInput(file, "", "is a further file of the family: give d3plot, which is read with all of them")
    if extension not in FORMATS:
        advice = ADVICE.get(extension)
        if advice:
            raise BadInput(file, "", f"{advice} (not read: '{extension}')")
        known = " ".join([*FORMATS, ".inp", *SERIES, "d3plot"])
        raise BadInput(file, "", f"unknown extension '{extension}'; known: {known}")
    return [Source(file, lambda: mesh_of(file))]


def mesh_of(file):
    mesh, said = meshio_read(file)
    format_name = FORMATS[os.path.splitext(file)[1].lower()]
    if format_name == "vtu":
        mesh = without_ghosts(mesh)
    return mesh, said, numbering_of(file, mesh, format_name)


def xdmf_sources(file):
    series = xdmf.Xdmf(file)
    return [Source(f"{file}: frame {k}", lambda k=k: (series.read(k), "", None), time) for k, time in enumerate(series.times)]


def d3plot_sources(file):
    results = vtk_grids.D3plot(file)
    return [Source(f"{file}: state {k}", lambda k=k: (*results.read(k), None), time, in_pieces=True)
            for k, time in enumerate(results.times)]


def exodus_sources(file):
    def frame(step):
        try:
            mesh, numbering = exodus.read(file, step)
        except (OSError, KeyError, IndexError, ValueError) as problem:
            raise BadInput(file, "", f"is not an Exodus file that can be read: {problem}") from problem
        return mesh, "", numbering

    try:
        times = exodus.times(file)
    except OSError as problem:
        raise BadInput(file, "", f"is not an Exodus file: {problem.strerror or problem}") from problem
    if not times:
        return [Source(file, lambda: frame(None))]
    return [Source(f"{file}: step {k}", lambda k=k: frame(k), time, undeformed=True) for k, time in enumerate(times)]


def frd_sources(file):
    results = frd.Frd(file)

    def frame(step):
        mesh, numbering = results.read(step)
        return mesh, "", numbering

    if not results.steps:
        return [Source(file, lambda: frame(None))]
    return [Source(f"{file}: step {k}", lambda k=k: frame(k), time, undeformed=True)
            for k, (time, _) in enumerate(results.steps)]


def pvd_sources(file):
    """The files of each time. Several of one time are pieces."""
    try:
        entries = ET.parse(file).getroot().findall("Collection/DataSet")
    except ET.ParseError as problem:
        raise BadInput(file, "", f"is not XML: {problem}") from problem
    if not entries:
        raise BadInput(file, "DataSet", "none")
    groups = {}
    for k, entry in enumerate(entries):
        name = entry.get("file")
        if not name:
            raise BadInput(file, "DataSet", "has no file", k)
        try:
            time = float(entry.get("timestep", k))
        except ValueError:
            raise BadInput(file, "DataSet", f"timestep '{entry.get('timestep')}' is not a number", k) from None
        groups.setdefault(time, []).append(os.path.join(os.path.dirname(file), name))
    result = []
    for time, names in groups.items():
        parts = [source for name in names for source in sources_of(name)]
        if len(parts) == 1:
            result.append(dataclasses.replace(parts[0], time=time))
        else:
            result.append(Source(f"{file}: time {time:g}", lambda parts=parts: joined(parts), time, in_pieces=True))
    return result


def joined(parts):
    """Several files as one mesh. Each file is an object unless the files have an array of objects."""
    meshes = [part.read()[0] for part in parts]
    mesh = concatenated(meshes)
    if not any(name.lower() in OBJECT_IDS for name in mesh.cell_data):
        mesh.cell_data["PartId"] = [np.full(len(block.data), k) for k, one in enumerate(meshes) for block in one.cells]
    return mesh, "", None
