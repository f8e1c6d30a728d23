#!/usr/bin/env python3
"""Turns meshes and results of other programs into one sequence file that `volccd` reads.

Input, one frame each:    .vtu, .pvtu, .vtk (legacy), .msh (Gmsh), .ply, .obj, .inp (Abaqus, CalculiX), .bdf/.fem/.nas (Nastran)
Input, all its frames:    .pvd (ParaView), .xdmf/.xmf, .e/.exo/.ex2 (Exodus II), .frd (CalculiX), d3plot (LS-DYNA)
Output: VTKHDF, the layout that docs/sequence_files.md describes.

These data are kept if the source has them:
  point ids    array GlobalPointIds, NODE_ID, ..; node numbers of Gmsh (text), Abaqus, Nastran, Exodus, .frd
  cell ids     array GlobalCellIds, ElementId, ELEMENT_ID, ..; element numbers of Gmsh (text), Abaqus, Nastran, Exodus, .frd
  objects      array PartId, PART_ID, ..; Gmsh physical groups, Nastran property ids, groups of .obj, element blocks of Exodus,
               materials of .frd, parts of d3plot, files of one time in a .pvd; of Abaqus the instances, if there are
               several, else the element sets (numbered from 1 in the order of the file)
  velocities   array Velocity, ..; as point vectors
  displacement only as --displacement says: files do not tell whether their points are displaced already. Exodus and .frd have
               the points before deformation, so that their displacements are added without the option
  thickness    array Thickness, ..; per cell
  times        of .pvd, .xdmf, Exodus, .frd, d3plot, and of a field TimeValue; else 0, 1, ..
With point ids, files may list points in different orders, and may have different points. In a frame without a certain
point, the point is written at its last (or else its first) position, and no cell uses it. With cell ids, files may have
different cells. Without ids, all files must have the same points and cells.

Cells whose nodes repeat (a wedge as a hexahedron, a triangle as a quad) are written unchanged; volccd reads them as the
elements that they represent. A cell with too few distinct nodes for any element is an error. Elements of higher order are
taken as straight, by their corners, and counted; their middle nodes are left out.

Lines and single vertices are left out, and so are triangles and quads that are faces of volume cells (--keep-faces keeps
them). Polygons and polyhedra are errors, and so are Abaqus decks with generated nodes or elements.

Abaqus: instances are assembled, with their translations and rotations. Of several, the node and element numbers of the second
follow the largest numbers of the first, and so on; the output says by how much.

Pieces (.pvtu, .vtu, files of one time in a .pvd) are joined at points of one id. Without point ids, --pieces says whether points
at one place are one.

Examples:
  volccd-import block.msh -o block.vtkhdf                        one frame
  volccd-import run_*.vtu -o run.vtkhdf --sort natural           run_2 before run_10, times from the files, else 0, 1, ..
  volccd-import run.pvd -o run.vtkhdf --displacement u           points displaced by the array u
  volccd-import run_*.vtk -o run.vtkhdf --sort natural --dt 1e-6 --units m --time-unit second
  volccd-import a.inp b.inp -o run.vtkhdf --times 0,0.5 --sets Bolt,Plate

The output must be a regular file and not one of the inputs. If it is a symbolic link, the target of the link is replaced.

Needs python3-meshio and python3-h5py; Exodus needs python3-netcdf4; .pvtu, .vtu in pieces, and d3plot need python3-vtk9. Exit
code: 0 written, 2 bad input, output or usage, 130 interrupted. If the exit code is not 0, no new file remains, and an earlier
output is unchanged.
"""

import argparse
import contextlib
import os
import stat
import sys

NAME = "volccd-import"
try:
    import h5py
    import meshio  # noqa: F401  # pylint: disable=unused-import
    import numpy as np
except ImportError as problem:
    sys.exit(f"{NAME}: {problem}; install python3-meshio and python3-h5py")

from importer.errors import BadInput
from importer.sequence import Union, check_same, order_files, times_of
from importer.frame import read_frame
from importer.series import sources_of
from importer.writer import Sink, Writer, output_path
from version import version

def counted(number, what):
    return f"{number} {what}{'' if number == 1 else 's'}"


def about_of(options, first, files):
    names = "; ".join(f"{number} {name.replace(';', ',')}" for number, name in sorted(first.object_names.items()))
    source = os.path.basename(files[0]) + (f" .. {os.path.basename(files[-1])}" if len(files) > 1 else "")
    return {"Title": options.title, "Source": options.source or source, "License": options.license, "Units": options.units,
            "TimeUnit": options.time_unit, "Parts": names}


def import_sources(sources, files, options, output, check):
    """Imports the frames. `check` raises an error if the data written so far could not be stored."""
    union, found = Union(), []
    # Frames are read twice and not kept, because a run may be larger than memory.
    first = None
    for source in sources:
        frame = read_frame(source, options)
        union.add(frame, source.name)
        found.append(frame.time)
        first = first or frame
    times = times_of([source.name for source in sources], options, found)
    writer, notes, shapes, moving = Writer(output), [], [], False
    for source in sources:
        frame = union.renumber(read_frame(source, options) if len(sources) > 1 else first)
        first = frame if not shapes else first
        check_same(frame, first, source.name)
        moving = moving or not np.array_equal(frame.points, first.points)
        writer.add(frame)
        check()
        shapes.append(len(frame.types))
        notes += [f"{source.name}: {note}" for note in frame.notes] if len(shapes) == 1 else []
    if len(sources) > 1 and not moving:
        notes.append(f"no point moves in {len(sources)} frames: are the displacements in an array (--displacement NAME)?")
    writer.finish(times, union.ids, len(union.places), about_of(options, first, files))
    given = ", ".join(f"{name} {'kept' if there else 'made up'}" for name, there in (
        ("point ids", union.ids is not None), ("cell ids", first.cell_ids is not None)))
    return notes, (f"{counted(len(sources), 'frame')}, {counted(len(union.places), 'point')}, {counted(shapes[0], 'cell')} at "
                   f"first, {shapes[-1]} at last; {given}")


def parse_arguments(arguments):
    parser = argparse.ArgumentParser(prog=NAME, description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--version", action="version", version=f"{NAME} {version()}")
    parser.add_argument("files", nargs="+", metavar="FILE", help="of one frame each, or of several")
    parser.add_argument("-o", "--output", required=True, metavar="FILE", help="sequence to write (VTKHDF)")
    parser.add_argument("--sort", choices=("given", "natural"), help="order of the files; default: as given, refused if the "
                        "numbers in the names say otherwise")
    when = parser.add_mutually_exclusive_group()
    when.add_argument("--times", type=lambda text: [float(word) for word in text.split(",")], metavar="T0,T1,..",
                      help="times of the frames")
    when.add_argument("--dt", type=float, help="time from frame to frame")
    for name, text in (("point-ids", "point array of ids"), ("cell-ids", "cell array of ids"), ("part", "cell array of objects"),
                       ("velocity", "point array of velocities, or three: vx,vy,vz"),
                       ("thickness", "cell array of shell thickness, or a number for all shells")):
        parser.add_argument(f"--{name}", metavar="NAME", help=f"{text}; 'none': not used; default: by its usual names")
    parser.add_argument("--displacement", metavar="NAME", help="point array of displacements, or three: ux,uy,uz, which are "
                        "added to the points; 'none': not added; must be given if an array has a usual name (disp, U, ..)")
    parser.add_argument("--pieces", choices=("join", "apart"), help="points at one place in several pieces: are one, or stay apart; "
                        "must be given if there are such points and no point ids")
    parser.add_argument("--sets", type=lambda text: text.split(","), metavar="A,B,..",
                        help="element sets that are the objects 1, 2, .. (Abaqus)")
    parser.add_argument("--keep-faces", action="store_true", help="keep triangles and quads that are faces of volume cells")
    for name in ("title", "source", "license", "units", "time-unit"):
        parser.add_argument(f"--{name}", default="", metavar="TEXT", help="attribute of the sequence")
    return parser.parse_args(arguments)


def main(arguments):
    options = parse_arguments(arguments)
    temporary = None
    try:
        files = order_files(options.files, options.sort)
        target = output_path(options.output, files)
        sources = [source for file in files for source in sources_of(file)]
        name = f"{target}.{os.getpid()}.tmp"
        with Sink(name, options.output) as sink:
            temporary = name
            if os.path.exists(target):
                os.chmod(temporary, stat.S_IMODE(os.stat(target).st_mode))
            with h5py.File(sink, "w") as output:
                notes, summary = import_sources(sources, files, options, output, sink.check)
            sink.to_disk()
        os.replace(temporary, target)
    except (BadInput, OSError, MemoryError) as problem:
        print(f"{NAME}: {problem}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print(f"{NAME}: interrupted; nothing has been written to {options.output}", file=sys.stderr)
        return 130
    finally:
        if temporary:
            with contextlib.suppress(FileNotFoundError):
                os.remove(temporary)
    for note in notes:
        print(f"{NAME}: {note}", file=sys.stderr)
    print(f"{options.output}: {summary}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
